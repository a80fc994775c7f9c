#!/usr/bin/env python3
"""Two public sets of quadratic programs as lines of JSON, with the optimal cost as several solvers find it.

    git clone https://github.com/qpsolvers/maros_meszaros_qpbenchmark FOLDER/maros
    git clone https://github.com/qpsolvers/mpc_qpbenchmark            FOLDER/mpc
    python3 -m venv target/oracles/venv && target/oracles/venv/bin/pip install -r tests/oracles/requirements_qp.txt
    target/oracles/venv/bin/python tests/oracles/qp_sets.py FOLDER/maros FOLDER/mpc --out target/oracles/qp

writes maros.jsonl: the convex problems of Maros and Meszaros with at most 300 variables and 600 rows, and mpc.jsonl:
all of the other set (two of whose files are kept elsewhere by some clones). A row is an equality where its limits are
equal; limits of 1e20 and more are none; constants of the cost are left out, which `objective` has not either.

The solution whose equations, limits and gap hold best after refinement in long double is the reference; `found_by` says
who came within 1e-6 of it. A problem whose reference misses 1e-9 is printed as doubtful.
"""

import argparse
import sys
from pathlib import Path

import numpy as np
from qp_peers import PEERS, ask
from qp_problem import INF, Problem, gap, polished, ratio, stationarity, violations

VARIABLES, ROWS = 300, 600
# A bound of this size is none.
NO_LIMIT = 9e19
RELATIVE = 1e-6


def maros(folder):
    """The problems of the set, convex or not, within the sizes."""
    from scipy.io import loadmat

    for file in sorted((folder / "data").glob("*.mat"), key=lambda f: f.name):
        if file.stat().st_size > 200_000:
            continue  # of thousands of variables
        data = loadmat(file)
        n, m = int(data["n"].ravel()[0]), int(data["m"].ravel()[0]) - int(data["n"].ravel()[0])
        if n > VARIABLES or m > ROWS:
            continue
        A = data["A"].toarray().astype(float)
        assert np.array_equal(A[m:], np.eye(n)), f"{file}: bounds come last"
        H, g = data["P"].toarray().astype(float), data["q"].ravel().astype(float)
        lower, upper = data["l"].ravel().astype(float), data["u"].ravel().astype(float)
        lower, upper = np.where(lower < -NO_LIMIT, -INF, lower), np.where(upper > NO_LIMIT, INF, upper)
        yield Problem(n, m, (H + H.T) / 2, g, A[:m], lower[:m], upper[:m], lower[m:], upper[m:], name=file.stem)


def mpc(folder):
    for file in sorted((folder / "data").glob("*.npz"), key=lambda f: f.name):
        if file.stat().st_size < 1000:
            print(f"{file.name}: a pointer to a file kept elsewhere, left out", file=sys.stderr)
            continue
        archive = np.load(file, allow_pickle=False)

        def optional(key, missing, archive=archive):
            try:
                return np.asarray(archive[key], dtype=float)
            except ValueError:  # None, which is a pickle
                return missing

        H, g = optional("P", None), optional("q", None).ravel()
        n = len(g)
        G, h = optional("G", np.zeros((0, n))), optional("h", np.zeros(0)).ravel()
        A, b = optional("A", np.zeros((0, n))), optional("b", np.zeros(0)).ravel()
        lower, upper = optional("lb", np.full(n, -INF)).ravel(), optional("ub", np.full(n, INF)).ravel()
        some = np.isfinite(h)
        G, h = G[some], h[some]
        rows, least = np.vstack([A, G]), np.concatenate([b, np.full(len(h), -INF)])
        most = np.concatenate([b, h])
        yield Problem(n, len(most), (H + H.T) / 2, g, rows, least, most, lower, upper, name=file.stem)


def missed(p, x):
    """The largest violation, relative to one more than its terms: a limit of zero and a value of 1e-17 agree."""
    violation, size = violations(p, x)
    return float(np.max(ratio(violation, 1 + size), initial=0))


def errors(p, x, y, z):
    """The largest violation and equation, relative, and the gap by the cost."""
    residual, terms = stationarity(p, x, y, z)
    primal = missed(p, x)
    dual = float(np.max(ratio(residual, 1 + terms), initial=0))
    difference, _ = gap(p, x, y, z)
    return primal, dual, float(abs(difference) / (1 + abs(p.cost(x))))


def usable(p, x, y, z):
    """Multipliers on sides without a limit set to zero."""
    y, z = np.array(y), np.array(z)
    for multipliers, lower, upper in ((y, p.row_lower, p.row_upper), (z, p.lower, p.upper)):
        multipliers[(multipliers > 0) & ~np.isfinite(upper)] = 0
        multipliers[(multipliers < 0) & ~np.isfinite(lower)] = 0
    return np.array(x), y, z


def reference(p):
    """`expected`, and the errors of the solution it is from."""
    best, costs, said = None, {}, {}
    for peer in PEERS:
        status, x, y, z = ask(peer, p)
        said[peer] = status
        if x is None or status not in ("optimal", "almost"):
            continue
        x, y, z = usable(p, x, y, z)
        costs[peer] = float(p.cost(x)), missed(p, x)
        candidates = [(x, y, z)]
        better = polished(p, x, y, z)
        if better is not None:
            candidates.append(usable(p, *better))
        for candidate in candidates:
            judged = max(errors(p, *candidate))
            if best is None or judged < best[0]:
                best = judged, candidate, peer
    if best is None:
        return None, said
    objective = float(p.cost(best[1][0]))
    allowed = RELATIVE * max(1.0, abs(objective))
    agree = [peer for peer, (cost, miss) in costs.items() if abs(cost - objective) <= allowed and miss <= RELATIVE]
    expected = {"status": "optimal", "objective": objective, "x": None, "relative_tolerance": RELATIVE,
                "objective_tolerance": allowed, "found_by": agree, "reference_error": best[0]}
    return expected, said


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("maros", type=Path, help="maros_meszaros_qpbenchmark, with its folder data")
    parser.add_argument("mpc", type=Path, help="mpc_qpbenchmark, with its folder data")
    parser.add_argument("--out", type=Path, default=Path("target/oracles/qp"))
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    for name, problems in (("maros", maros(arguments.maros)), ("mpc", mpc(arguments.mpc))):
        count = 0
        with open(arguments.out / f"{name}.jsonl", "w") as file:
            for problem in problems:
                least = problem.least_curvature()
                if least < -1e-9:
                    print(f"{problem.name}: not convex ({least:.1e}), left out")
                    continue
                problem.expected, said = reference(problem)
                if problem.expected is None:
                    sys.exit(f"{problem.name}: nobody solves it: {said}")
                expected = problem.expected
                doubt = "  DOUBTFUL" if expected["reference_error"] > 1e-9 or len(expected["found_by"]) < 2 else ""
                print(f"{problem.name:12} {problem.n:4} {problem.m:4} {expected['objective']:+.12e} "
                      f"error {expected['reference_error']:.0e} by {', '.join(expected['found_by'])}{doubt}",
                      flush=True)
                file.write(problem.line() + "\n")
                count += 1
        print(f"{name}: {count} problems in {arguments.out / name}.jsonl", flush=True)


if __name__ == "__main__":
    main()
