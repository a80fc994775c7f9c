#!/usr/bin/env python3
"""Other solvers on the quadratic programs of wbqp's ticks: how long they take, and whether they are right.

    cargo build --release --bin tick_stats
    for robot in othex quadruped humanoid; do
        target/release/tick_stats --robot $robot --force --dump-problems target/$robot.json
    done
    python3 -m venv target/peers && target/peers/bin/pip install -r tests/peers/requirements.txt
    target/peers/bin/python tests/peers/compare.py --wbqp target/release/tick_stats target/*.json

Every solver gets the same problems, in the same order, through its own Python interface (no front end in between),
converted before the clock starts. What is timed is the call that hands the problem over and solves it. As that includes
the interface, each solver also solves a problem of one variable in the same way: the column `call`. Where a solver
measures its own time, `own` is its median. `warm` starts from the tick before, `cold` from nothing; a solver without a
warm start has `cold` alone. wbqp is timed by its own program, before and after the others, in the same run. `x wbqp`
is the time without the call (or `own`, if that is more) over wbqp's warm time.

Solutions are judged by the numbers in the file, in the problem's units:
    cost     (objective - wbqp's) / (1 + |wbqp's|), the worst in size: above zero is a higher cost
    primal   largest violation of a row or bound
    kkt      largest |H x + g + A' y + z| / (1 + max |g|), with the solver's multipliers
"""

import argparse
import json
import os
import statistics
import subprocess
import sys
import time
from pathlib import Path

# One core for everybody.
for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

import numpy as np  # noqa: E402

INF = np.inf


class Problem:
    """minimise 1/2 x'Hx + g'x subject to row_lower <= Ax <= row_upper, lower <= x <= upper."""

    def __init__(self, data):
        n, m = data["n"], data["m"]
        self.n, self.m = n, m
        self.H = np.array(data["h"], dtype=float).reshape(n, n)
        self.g = np.array(data["g"], dtype=float)
        self.A = np.array(data["a"], dtype=float).reshape(m, n)
        self.row_lower, self.row_upper = limits(data["row_lower"], -INF), limits(data["row_upper"], INF)
        self.lower, self.upper = limits(data["lower"], -INF), limits(data["upper"], INF)
        self.objective = data.get("objective", 0.0)
        self.equal = self.row_lower == self.row_upper

    def cost(self, x):
        return 0.5 * x @ self.H @ x + self.g @ x

    def errors(self, x, y, z):
        reference = self.objective
        cost = (self.cost(x) - reference) / (1 + abs(reference))
        rows = self.A @ x
        primal = max(
            0.0,
            *(
                np.max(v, initial=0.0)
                for v in (self.row_lower - rows, rows - self.row_upper, self.lower - x, x - self.upper)
            ),
        )
        kkt = float("nan")
        if y is not None:
            kkt = np.max(np.abs(self.H @ x + self.g + self.A.T @ y + z)) / (1 + np.max(np.abs(self.g)))
        return cost, primal, kkt


def limits(values, missing):
    return np.array([missing if v is None else v for v in values], dtype=float)


class Solver:
    """`prepare` converts (not timed), `solve` hands over and solves (timed), `solution` gives x, y, z (not timed).

    `warm` says whether the solve may use the one before. Multipliers are positive on an active upper side.
    """

    has_warm = True

    def own(self):
        """Its own measurement of the last solve, s, or None."""
        return None


class Quadprog(Solver):
    """minimise 1/2 x'Gx - a'x subject to C'x >= b, the first `meq` as equalities."""

    name, has_warm = "quadprog", False

    def __init__(self):
        import quadprog

        self.library = quadprog

    def prepare(self, p):
        identity = np.eye(p.n)
        parts = [(p.A[p.equal], p.row_lower[p.equal])]
        self.owners = [("y", i, -1.0) for i in np.flatnonzero(p.equal)]
        for rows, limit, kind, side in [
            (p.A, np.where(p.equal, -INF, p.row_lower), "y", -1.0),
            (-p.A, np.where(p.equal, -INF, -p.row_upper), "y", 1.0),
            (identity, p.lower, "z", -1.0),
            (-identity, -p.upper, "z", 1.0),
        ]:
            there = np.isfinite(limit)
            parts.append((rows[there], limit[there]))
            self.owners += [(kind, i, side) for i in np.flatnonzero(there)]
        C = np.ascontiguousarray(np.vstack([rows for rows, _ in parts]).T)
        self.arguments = (p.H, -p.g, C, np.concatenate([limit for _, limit in parts]), int(p.equal.sum()))
        self.size = (p.m, p.n)

    def solve(self, warm):
        self.result = self.library.solve_qp(*self.arguments)

    def solution(self):
        multipliers = {"y": np.zeros(self.size[0]), "z": np.zeros(self.size[1])}
        for (kind, index, side), value in zip(self.owners, self.result[4]):
            multipliers[kind][index] += side * value
        return self.result[0], multipliers["y"], multipliers["z"]


class Daqp(Solver):
    name = "daqp"

    def __init__(self):
        import daqp

        self.library, self.model, self.shape = daqp, None, None

    def prepare(self, p):
        finite = lambda v: np.clip(v, -1e30, 1e30)  # noqa: E731
        upper = np.concatenate([finite(p.upper), finite(p.row_upper)])
        lower = np.concatenate([finite(p.lower), finite(p.row_lower)])
        sense = np.zeros(p.n + p.m, dtype=np.int32)
        sense[p.n :][p.equal] = 5
        self.arguments = (p.H.copy(), p.g, np.ascontiguousarray(p.A), upper, lower)
        self.sense, self.n = sense, p.n

    def solve(self, warm):
        shape, self.warm = self.arguments[2].shape, warm
        if warm and self.model is not None and self.shape == shape:
            self.model.update(*self.arguments)
            self.result = self.model.solve()
        elif warm:
            self.model, self.shape = self.library.Model(), shape
            self.model.setup(*self.arguments, self.sense)
            self.result = self.model.solve()
        else:
            self.result = self.library.solve(*self.arguments, self.sense)

    def own(self):
        # After an update its clock leaves out the factorisation, which the update has done.
        return None if self.warm else self.result[3]["solve_time"] + self.result[3]["setup_time"]

    def solution(self):
        x, _, flag, info = self.result
        if flag < 1:
            raise ArithmeticError(f"exit flag {flag}")
        lam = np.array(info["lam"])
        return x, lam[self.n :], lam[: self.n]


class Proxqp(Solver):
    """Asked for 1e-6: with 1e-9 it takes many times as long."""

    name = "proxqp (dense)"

    def __init__(self):
        import proxsuite

        self.library, self.qp, self.shape = proxsuite.proxqp, None, None

    def prepare(self, p):
        unequal = ~p.equal
        self.shape_now = (p.n, int(p.equal.sum()), int(unequal.sum()))
        self.arguments = (p.H, p.g, p.A[p.equal], p.row_lower[p.equal], p.A[unequal], p.row_lower[unequal],
                          p.row_upper[unequal], p.lower, p.upper)
        self.equal, self.n = p.equal, p.n

    def solve(self, warm):
        if not (warm and self.shape == self.shape_now):
            self.qp, self.shape = self.library.dense.QP(*self.shape_now, True), self.shape_now
            self.qp.settings.eps_abs, self.qp.settings.eps_rel = 1e-6, 0.0
            self.qp.settings.compute_timings = True
            if warm:
                self.qp.settings.initial_guess = self.library.InitialGuess.WARM_START_WITH_PREVIOUS_RESULT
            self.qp.init(*self.arguments)
        else:
            self.qp.update(*self.arguments)
        self.qp.solve()

    def own(self):
        return (self.qp.results.info.setup_time + self.qp.results.info.solve_time) * 1e-6

    def solution(self):
        results = self.qp.results
        if results.info.status != self.library.QPSolverOutput.PROXQP_SOLVED:
            raise ArithmeticError(str(results.info.status))
        y = np.zeros(len(self.equal))
        y[self.equal] = results.y
        inequalities = len(results.z) - self.n
        y[~self.equal] = results.z[:inequalities]
        return np.array(results.x), y, np.array(results.z[inequalities:])


class Piqp(Solver):
    name, has_warm = "piqp (dense)", False

    def __init__(self):
        import piqp

        self.library, self.solver, self.shape = piqp, None, None

    def prepare(self, p):
        unequal = ~p.equal
        f = np.asfortranarray
        self.shape_now = (p.n, int(p.equal.sum()), int(unequal.sum()), p.lower.tobytes() + p.upper.tobytes())
        self.arguments = (f(p.H), p.g, f(p.A[p.equal]), p.row_lower[p.equal], f(p.A[unequal]), p.row_lower[unequal],
                          p.row_upper[unequal], p.lower, p.upper)
        self.equal = p.equal

    def solve(self, warm):
        self.solver = self.library.DenseSolver()
        self.solver.settings.eps_abs = self.solver.settings.eps_duality_gap_abs = 1e-9
        self.solver.settings.eps_rel = self.solver.settings.eps_duality_gap_rel = 1e-10
        self.solver.settings.compute_timings = True
        self.solver.setup(*self.arguments)
        self.status = self.solver.solve()

    def own(self):
        return self.solver.result.info.setup_time + self.solver.result.info.solve_time

    def solution(self):
        if self.status != self.library.PIQP_SOLVED:
            raise ArithmeticError(str(self.status))
        r = self.solver.result
        y = np.zeros(len(self.equal))
        y[self.equal] = r.y
        y[~self.equal] = r.z_u - r.z_l
        return np.array(r.x), y, np.array(r.z_bu - r.z_bl)


class Osqp(Solver):
    """First order: asked for 1e-6."""

    name = "osqp"

    def __init__(self):
        import osqp
        from scipy import sparse

        self.library, self.sparse, self.solver, self.shape = osqp, sparse, None, None

    def prepare(self, p):
        # Full patterns: an update may change values, not the pattern.
        rows, columns = np.triu_indices(p.n)
        order = np.lexsort((rows, columns))
        rows, columns = rows[order], columns[order]
        pointers = np.concatenate([[0], np.cumsum(np.arange(1, p.n + 1))])
        self.P = self.sparse.csc_matrix((p.H[rows, columns], rows, pointers), shape=(p.n, p.n))
        full = np.vstack([p.A, np.eye(p.n)])
        dense = np.tile(np.arange(p.m), p.n).reshape(p.n, p.m)
        index = np.hstack([dense, p.m + np.arange(p.n)[:, None]]).ravel()
        values = np.hstack([p.A.T, np.ones((p.n, 1))]).ravel()
        self.A = self.sparse.csc_matrix((values, index, np.arange(p.n + 1) * (p.m + 1)), shape=full.shape)
        self.q, self.m = p.g, p.m
        self.l = np.concatenate([p.row_lower, p.lower])
        self.u = np.concatenate([p.row_upper, p.upper])

    def solve(self, warm):
        if not (warm and self.shape == self.A.shape):
            self.solver, self.shape = self.library.OSQP(), self.A.shape
            self.solver.setup(self.P, self.q, self.A, self.l, self.u, verbose=False, eps_abs=1e-6, eps_rel=1e-6,
                              max_iter=20000)
        else:
            self.solver.update(q=self.q, l=self.l, u=self.u, Px=self.P.data, Ax=self.A.data)
        self.result = self.solver.solve(raise_error=False)

    def own(self):
        return self.result.info.run_time

    def solution(self):
        if self.result.info.status != "solved":
            raise ArithmeticError(self.result.info.status)
        return self.result.x, self.result.y[: self.m], self.result.y[self.m :]


class ClarabelPeer(Solver):
    name, has_warm = "clarabel (Python)", False

    def __init__(self):
        import clarabel
        from scipy import sparse

        self.library, self.sparse = clarabel, sparse

    def prepare(self, p):
        identity, unequal = np.eye(p.n), ~p.equal
        parts = [(p.A[p.equal], p.row_lower[p.equal])]
        self.owners = [("y", i, 1.0) for i in np.flatnonzero(p.equal)]
        for rows, limit, kind, side in [
            (p.A, np.where(unequal, p.row_upper, INF), "y", 1.0),
            (-p.A, np.where(unequal, -p.row_lower, INF), "y", -1.0),
            (identity, p.upper, "z", 1.0),
            (-identity, -p.lower, "z", -1.0),
        ]:
            there = np.isfinite(limit)
            parts.append((rows[there], limit[there]))
            self.owners += [(kind, i, side) for i in np.flatnonzero(there)]
        equal, all_rows = int(p.equal.sum()), sum(len(limit) for _, limit in parts)
        cones = [self.library.ZeroConeT(equal), self.library.NonnegativeConeT(all_rows - equal)]
        A = self.sparse.csc_matrix(np.vstack([rows for rows, _ in parts]))
        P = self.sparse.csc_matrix(np.triu(p.H))
        settings = self.library.DefaultSettings()
        settings.verbose = False
        settings.max_threads = 1
        self.arguments = (P, p.g, A, np.concatenate([limit for _, limit in parts]), cones, settings)
        self.size = (p.m, p.n)

    def solve(self, warm):
        self.result = self.library.DefaultSolver(*self.arguments).solve()

    def own(self):
        return self.result.solve_time

    def solution(self):
        if str(self.result.status) != "Solved":
            raise ArithmeticError(str(self.result.status))
        multipliers = {"y": np.zeros(self.size[0]), "z": np.zeros(self.size[1])}
        for (kind, index, side), value in zip(self.owners, self.result.z):
            multipliers[kind][index] += side * value
        return np.array(self.result.x), multipliers["y"], multipliers["z"]


class Highs(Solver):
    name, has_warm = "highs", False

    def __init__(self):
        import highspy
        from scipy import sparse

        self.library, self.sparse = highspy, sparse

    def prepare(self, p):
        h = self.library
        model = h.HighsModel()
        lp = model.lp_
        lp.num_col_, lp.num_row_ = p.n, p.m
        lp.col_cost_, lp.col_lower_, lp.col_upper_ = p.g, p.lower, p.upper
        lp.row_lower_, lp.row_upper_ = p.row_lower, p.row_upper
        A, H = self.sparse.csc_matrix(p.A), self.sparse.csc_matrix(np.tril(p.H))
        lp.a_matrix_.format_ = h.MatrixFormat.kColwise
        lp.a_matrix_.start_, lp.a_matrix_.index_, lp.a_matrix_.value_ = A.indptr, A.indices, A.data
        model.hessian_.dim_ = p.n
        model.hessian_.format_ = h.HessianFormat.kTriangular
        model.hessian_.start_, model.hessian_.index_, model.hessian_.value_ = H.indptr, H.indices, H.data
        self.model = model
        self.highs = h.Highs()
        self.highs.setOptionValue("output_flag", False)
        self.highs.setOptionValue("threads", 1)

    def solve(self, warm):
        self.highs.passModel(self.model)
        self.highs.run()

    def solution(self):
        if self.highs.getModelStatus() != self.library.HighsModelStatus.kOptimal:
            raise ArithmeticError(str(self.highs.getModelStatus()))
        s = self.highs.getSolution()
        return np.array(s.col_value), -np.array(s.row_dual), -np.array(s.col_dual)


PEERS = [Daqp, Quadprog, Proxqp, Piqp, ClarabelPeer, Highs, Osqp]

ONE = {"n": 1, "m": 1, "h": [1.0], "g": [1.0], "a": [1.0], "row_lower": [-9.0], "row_upper": [9.0], "lower": [-8.0],
       "upper": [8.0], "objective": -0.5}


def timed(solver, warm):
    start = time.perf_counter_ns()
    solver.solve(warm)
    return (time.perf_counter_ns() - start) * 1e-3


def median(values):
    return statistics.median(values) if values else None


def one_variable(peer):
    """Median time of a call that has almost nothing to solve, us."""
    problem, times = Problem(ONE), []
    for _ in range(200):
        solver = peer()
        solver.prepare(problem)
        times.append(timed(solver, False))
    return median(times)


def run(peer, sequences, repeats):
    times, own = {True: [], False: []}, {True: [], False: []}
    worst, failed, reasons = [0.0, 0.0, 0.0], 0, set()
    kinds = [True, False] if peer.has_warm else [False]
    for repeat in range(repeats):
        for sequence in sequences:
            for warm in kinds:
                solver = peer()
                for index, problem in enumerate(sequence):
                    solver.prepare(problem)
                    try:
                        spent = timed(solver, warm)
                        x, y, z = solver.solution()
                    except (ArithmeticError, ValueError) as error:
                        failed += repeat == 0 and warm == kinds[-1]
                        reasons.add(str(error))
                        continue
                    # The first of a sequence has no tick before it.
                    if not warm or index > 0:
                        times[warm].append(spent)
                        if solver.own() is not None:
                            own[warm].append(solver.own() * 1e6)
                    if repeat == 0:
                        worst = [max(w, float(e), key=abs) for w, e in zip(worst, problem.errors(x, y, z))]
    return {
        "solver": peer.name,
        "warm": median(times[True]),
        "cold": median(times[False]),
        "own": median(own[True] or own[False]),
        "call": one_variable(peer),
        "cost": worst[0],
        "primal": worst[1],
        "kkt": worst[2],
        "failed": failed,
        "reasons": sorted(reasons),
    }


def wbqp(program, file, repeats):
    command = [program, "--solve-problems", str(file), "--repeats", str(repeats), "--json"]
    return json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)


def number(value, form="{:.1f}"):
    return "" if value is None else form.format(value)


# Measured in C, by qp.py: what its Python interface takes says little about it.
ELSEWHERE = ("daqp",)


def markdown(workload, rows):
    reference = next(r for r in rows if r["solver"] == "wbqp")["warm"]
    lines = [
        "| solver | warm, µs | cold, µs | own, µs | call, µs | × wbqp | cost | primal | kkt | unsolved |",
        "|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|",
    ]
    for r in rows:
        taken = r["warm"] or r["cold"]
        ratio = max(r["own"] or 0.0, taken - (r["call"] or 0.0)) / reference if taken else None
        if r["solver"] in ELSEWHERE:
            ratio = None
        lines.append(
            f"| {r['solver']} | {number(r['warm'])} | {number(r['cold'])} | {number(r['own'])} | {number(r['call'])} "
            f"| {number(ratio)} | {number(r['cost'], '{:.0e}')} | {number(r['primal'], '{:.0e}')} "
            f"| {number(r['kkt'], '{:.0e}')} | {r['failed'] or ''} |"
        )
    return f"**{workload}**\n\n" + "\n".join(lines) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="+", type=Path, help="written by tick_stats --dump-problems")
    parser.add_argument("--wbqp", required=True, help="the program tick_stats")
    parser.add_argument("--repeats", type=int, default=5, help="how often each problem is solved")
    parser.add_argument("--json", type=Path, help="also writes the results there")
    arguments = parser.parse_args()
    everything = {}
    for file in arguments.files:
        data = json.loads(file.read_text())
        if data["format"] != "wbqp-problems-1":
            sys.exit(f"{file}: the format is {data['format']}")
        sequences = [[Problem(p) for p in sequence] for sequence in data["sequences"]]
        before = wbqp(arguments.wbqp, file, arguments.repeats)
        rows = []
        for peer in PEERS:
            try:
                peer()
            except ImportError as error:
                print(f"{peer.name}: {error}", file=sys.stderr)
                continue
            rows.append(run(peer, sequences, arguments.repeats))
            print(f"{data['workload']}: {rows[-1]}", file=sys.stderr)
        after = wbqp(arguments.wbqp, file, arguments.repeats)
        own = []
        for name, first, second in zip(["wbqp", "clarabel, tuned, in wbqp"], before, after):
            mean = lambda key: (first[key]["p50"] + second[key]["p50"]) / 2 if first[key] else None  # noqa: E731
            own.append({"solver": name, "warm": mean("warm"), "cold": mean("cold"), "own": None, "call": None,
                        "cost": first["objective_error"], "primal": first["primal"], "kkt": first["kkt"],
                        "failed": first["failed"]})
        rows = own + rows
        everything[data["workload"]] = rows
        print(markdown(data["workload"], rows))
    if arguments.json:
        arguments.json.write_text(json.dumps(everything, indent=2) + "\n")


if __name__ == "__main__":
    main()
