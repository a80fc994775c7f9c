#!/usr/bin/env python3
"""Judges what a solver of quadratic programs answers: every answer by itself, not by another solver's.

    target/oracles/venv/bin/python tests/oracles/qp_judge.py target/oracles/qp/maros.jsonl \\
        --solver target/release/examples/solve_json --peers daqp clarabel

Problems are lines of JSON as in qp_problem.py, or files of one object each. Answers come from a program that reads them
on standard input and prints one line each (`--solver`, or `--answers` with what it has printed): `status`, `x`,
`iterations`, `microseconds`, and `y` and `z`, multipliers or the certificate, for `unbounded` the ray in `x`.

    optimal      every row and bound: violation <= PRIMAL (|limit| + sum |a_j x_j|);
                 every variable: |H x + g + A'y + z| <= DUAL times the sum of the sizes of its terms;
                 |x'Hx + g'x + weighted limits| <= GAP times the sum of the sizes of its terms; no multiplier on a side
                 without a limit. Where x is so large that this proves nothing: there must be no ray, and x must not
                 be farther than 1e-6 of it from what it becomes in long double, if that costs less.
    infeasible   |A'y + z| <= ROUNDED of its terms where a variable is free (else it is moved to the bounds, which is
                 exact), and the weighted limits' sum below zero by more than BEYOND of its terms; or a row's own limits
                 cross.
    unbounded    |Hd| and |violation of the recession cone| <= ROUNDED of their terms, g'd < 0 beyond that; and
                 feasible.
    invalid      an entry that is no number where one has to be, or an H that is indefinite beyond rounding.

A verdict is `right`, `wrong`, `doubtful` (right within coarser limits or only by rounding: either status is
defensible), `unproven` (the status is right by a linear programme of HiGHS, the multipliers or the certificate do not
show it) or `unsolved` (iteration_limit, time_limit, stalled). Sums are in long double.

`solved` is the criterion of benchmarks: no violation above 1e-6 and a cost within the file's `objective_tolerance`.
"""

import argparse
import collections
import json
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
from qp_peers import FLAT, PEERS, ask, farkas, feasible, ray, units
from qp_problem import LONG, Problem, gap, numbers, polished, ratio, stationarity, support, violations

PRIMAL, DUAL, GAP = 1e-9, 1e-8, 1e-8
# Of a doubtful answer, these times as much.
COARSER = 100.0
# What a sum that ought to be zero may be of its terms, and what one that ought not has to be.
ROUNDED, BEYOND = 1e-12, 1e-12
# A row of coefficients of size one may be missed by this, and any row by the second: limits of 1e-17 are rounding.
UNIT, NOTHING = 1e-12, 1e-15
# A row without coefficients that is missed by more than this is infeasible without doubt.
EMPTY = 1e-9
# Of the largest curvature times the largest variable: multipliers of this size are those of a cost that is flat.
VANISHING = 1e-20
# Infeasible by less than this share of its limits: within tolerances of feasibility.
MARGIN = 1e-9
UNSOLVED = ("iteration_limit", "time_limit", "stalled")


class Verdict:
    def __init__(self, kind, why="", **numbers_):
        self.kind, self.why, self.numbers = kind, why, numbers_

    def __str__(self):
        values = ", ".join(f"{k} {v:.1e}" for k, v in self.numbers.items())
        return " ".join(part for part in (self.kind, f"({values})" if values else "", self.why) if part)


class Answer:
    def __init__(self, data):
        self.status = data.get("status", "none")
        vector = lambda key: numbers(data[key]) if data.get(key) is not None else None  # noqa: E731
        self.x, self.y, self.z = vector("x"), vector("y"), vector("z")
        self.microseconds, self.iterations = data.get("microseconds"), data.get("iterations")

    def has(self, p, *keys):
        sizes = {"x": p.n, "y": p.m, "z": p.n}
        vectors = ((getattr(self, k), sizes[k]) for k in keys)
        return all(v is not None and v.shape == (size,) and np.all(np.isfinite(v)) for v, size in vectors)


def grade(amounts):
    """`right` where all (value, limit) hold, `doubtful` within COARSER of them, else `wrong`."""
    if all(value <= limit for value, limit in amounts):
        return "right"
    return "doubtful" if all(value <= COARSER * limit for value, limit in amounts) else "wrong"


def graded(residual, terms, limit, floor, coarse_floor):
    """What to compare with `limit`: the largest residual as a share of its terms. Below `floor` it is none; below
    `coarse_floor`, where it is rounding of something else, it is at most doubtful."""
    shares = np.where(residual <= floor, 0, ratio(residual, terms))
    shares = np.where((residual <= coarse_floor) & (shares > COARSER * limit), COARSER * limit, shares)
    return worst(shares)


def worst(values):
    return float(np.max(values, initial=0))


def primal_error(p, x):
    """The largest violation as a share of |limit| + sum |a_j x_j|."""
    violation, size = violations(p, x)
    largest = np.concatenate([np.max(np.abs(p.A), axis=1, initial=0), np.ones(p.n)])
    # A limit of zero says nothing of its variable's unit; a row without coefficients has no scale at all.
    unit = np.maximum(1, units(p))
    reach = np.concatenate([np.max(np.abs(p.A) * unit, axis=1, initial=0), unit])
    coarse = np.where(largest > 0, PRIMAL * reach, EMPTY)
    return graded(violation, size, PRIMAL, UNIT * largest + NOTHING, coarse)


def dual_error(p, x, y, z):
    """The largest |H x + g + A'y + z| as a share of its terms."""
    residual, terms = stationarity(p, x, y, z)
    # A multiplier is known to the rounding of what it balances elsewhere in its row.
    A = np.abs(p.A.astype(LONG))
    counts = A >= 1e-3 * np.max(A, axis=1, initial=0, keepdims=True)
    balanced = np.max(np.where(counts & (A > 0), ratio(terms[None, :], A), 0), axis=1, initial=0)
    # Where the cost is flat, nothing is left but rounding of nothing.
    flat = VANISHING * worst(np.abs(p.symmetric())) * worst(np.abs(x))
    coarse = np.maximum(1e-10 * worst(terms), UNIT * np.sum(np.abs(p.symmetric()), axis=1) + flat)
    return graded(residual, terms, DUAL, 1e-14 * (A.T @ balanced), coarse)


def without_nothing(p, y, z):
    """Multipliers on sides without a limit set to zero: they then have to show as a residual."""
    y, z = y.copy(), z.copy()
    for multipliers, lower, upper in ((y, p.row_lower, p.row_upper), (z, p.lower, p.upper)):
        multipliers[(multipliers > 0) & ~np.isfinite(upper)] = 0
        multipliers[(multipliers < 0) & ~np.isfinite(lower)] = 0
    return y, z


def settled(p, x, y, z):
    """z with what its equation leaves over put in, where that is rounding (of the largest term, or of the cost) and a
    limit takes it: multipliers that prove an optimum prove it whoever has found them."""
    residual, terms = stationarity(p, x, y, z)
    exact = -(p.symmetric() @ np.asarray(x, LONG) + p.g.astype(LONG) + p.A.astype(LONG).T @ np.asarray(y, LONG))
    takes = np.where(exact > 0, np.isfinite(p.upper), np.isfinite(p.lower)) | (exact == 0)
    finite = lambda v: np.where(np.isfinite(v), np.abs(v), 0)  # noqa: E731
    reach = np.maximum(np.abs(x), np.maximum(finite(p.lower), finite(p.upper)))
    _, sizes = gap(p, x, *without_nothing(p, y, z))
    rounding = (residual <= 1e-10 * worst(terms)) | ((reach > 0) & (residual * reach <= 1e-13 * sizes))
    return np.where(takes & rounding, exact, z)


def proven_optimal(p, x, y, z):
    """(grade, numbers) by the conditions of an optimum alone."""
    first = conditions(p, x, y, z)
    return first if first[0] == "right" else min(first, conditions(p, x, y, settled(p, x, y, z)), key=severity)


def severity(found):
    return ("right", "doubtful", "wrong").index(found[0])


def conditions(p, x, y, z):
    primal = primal_error(p, x)
    kept = without_nothing(p, y, z)
    # With and without them: then they are nothing themselves.
    dual = max(dual_error(p, x, y, z), dual_error(p, x, *kept))
    y, z = kept
    difference, sizes = gap(p, x, y, z)
    # Costs below what rounding of variables of size one makes of them are alike.
    floor = 1e-3 * UNIT * float(np.abs(p.g).sum()) + UNIT**2 * float(np.abs(p.symmetric()).sum())
    flat = VANISHING * worst(np.abs(p.symmetric())) * worst(np.abs(x)) ** 2
    coarse = UNIT * float(np.abs(p.g).sum()) + 1e4 * floor + flat
    share = graded(np.abs([difference]), np.array([sizes]), GAP, floor, coarse)
    figures = {"primal": primal, "dual": dual, "gap": share}
    return grade([(primal, PRIMAL), (dual, DUAL), (share, GAP)]), figures


def proven_ray(p, within=ROUNDED):
    """A direction along which the cost falls for ever, up to ROUNDED of every sum's terms, or None; `within` is that of
    H d. HiGHS keeps rows to
    1e-10 only: what is left of H d and of the rates of limits is taken away in long double, where d can give it up."""
    d = ray(p)
    if d is None:
        return None
    unit = units(p)
    lower, upper = np.concatenate([p.row_lower, p.lower]), np.concatenate([p.row_upper, p.upper])
    everything = np.vstack([p.A, np.eye(p.n)]).astype(LONG) * unit
    size = np.max(np.abs(everything), axis=1, initial=0)
    everything = everything / np.where(size > 0, size, 1)[:, None]
    own = np.asarray(d / unit, LONG)
    limited = (np.isfinite(lower) | np.isfinite(upper)) & (np.abs(everything @ own) <= 1e-8 * worst(np.abs(own)))
    H = p.symmetric() * unit * unit[:, None]
    rows = np.vstack([H / (worst(np.abs(H)) or 1), everything[limited]])
    u, s, v = np.linalg.svd(rows.astype(float), full_matrices=False)
    kept = s > 1e-13 * worst(s)
    inverse = (v[kept].T / s[kept]) @ u[:, kept].T
    for _ in range(6):
        own = own - inverse @ (rows @ own).astype(float)
    clean = np.where(np.abs(own) <= 1e-13 * worst(np.abs(own)), 0, own)
    for candidate in (clean * unit, own * unit, d):
        curvature, leaving, descent = recession(p, candidate)
        if curvature <= within and leaving <= ROUNDED and descent > MARGIN:
            return candidate
    return None


def huge(p, x, y, z):
    """Whether x is so large that rounding in H x outweighs the linear cost: a stationary point then proves nothing."""
    residual, _ = stationarity(p, x, *without_nothing(p, y, z))
    other = np.abs(p.g.astype(LONG)) + np.abs(p.A.astype(LONG)).T @ np.abs(y) + np.abs(z)
    return worst(ratio(residual, np.maximum(other, 1e-12 * worst(other)))) > 100 * DUAL


def distance(p, a):
    """How far x is from what it becomes in long double, as a share of the largest variable, where that costs less
    beyond rounding; None if that leads nowhere."""
    better = polished(p, a.x, *without_nothing(p, a.y, a.z))
    if better is None or primal_error(p, better[0]) > PRIMAL or huge(p, *better):
        return None
    less = p.cost(a.x) - p.cost(better[0])
    rounding = 1e-18 * (p.cost_size(a.x) + p.cost_size(better[0]))
    rounding += UNIT * float(np.abs(p.g).sum()) + UNIT**2 * float(np.abs(p.symmetric()).sum())
    return worst(np.abs(better[0] - a.x)) / worst(np.abs(a.x)) if less > rounding else 0.0


def reference(p, peers=("daqp", "clarabel", "highs", "piqp")):
    """The cost of the best polished solution that the conditions prove, or None."""
    for peer in peers:
        _, x, y, z = ask(peer, p)
        if x is None or y is None:
            continue
        better = polished(p, x, y, z)
        for candidate in ([better] if better else []) + [(x, y, z)]:
            is_finite = np.all(np.isfinite(np.concatenate(candidate).astype(float)))
            if is_finite and proven_optimal(p, *candidate)[0] == "right":
                return float(p.cost(candidate[0]))
    return None


def cost_tolerance(p, x, cost):
    """Where the file gives none: of the sizes of its terms, and of what rounding of x at size one makes of it."""
    if p.expected.get("objective_tolerance") is not None:
        return p.expected["objective_tolerance"]
    share, unit = p.expected.get("relative_tolerance", 1e-6), np.maximum(1, np.abs(x))
    # A cost is flat at its optimum: x is then off by 1e-7.
    flat = 1e-14 * float(unit @ (np.abs(p.symmetric()).astype(float) @ unit))
    return share * max(abs(cost), float(p.cost_size(x))) + 1e-9 * float(np.abs(p.g) @ unit) + flat


def judge_optimal(p, a):
    if not a.has(p, "x"):
        return Verdict("wrong", "x is not n finite numbers")
    primal = primal_error(p, a.x)
    if grade([(primal, PRIMAL)]) == "wrong":
        return Verdict("wrong", "violates a limit", primal=primal)
    found, figures = ("wrong", {"primal": primal})
    if a.has(p, "y", "z"):
        found, figures = proven_optimal(p, a.x, a.y, a.z)
        if found != "right":
            # Multipliers that are rounding: without them it has to be right by itself.
            without = proven_optimal(p, a.x, np.zeros(p.m), np.zeros(p.n))
            found, figures = without if without[0] == "right" else (found, figures)
        if huge(p, a.x, a.y, a.z):
            # Curvature beyond rounding of H, however little: there is a minimum.
            if proven_ray(p, FLAT * p.n) is not None:
                return Verdict("wrong", "the cost is unbounded", **figures)
            if found != "wrong":
                off = distance(p, a)
                if off is not None and off > 1e-6:
                    return Verdict("wrong", f"x is {off:.1e} off the one with more digits, which costs less", **figures)
                found = "doubtful" if off is None else found
        if found != "wrong":
            return Verdict(found, **figures)
    # The point is feasible, its multipliers show nothing: is the cost the optimum?
    best = reference(p)
    if best is None and p.expected.get("objective") is not None:
        best = p.expected["objective"]
    if best is None:
        why = "the cost is unbounded" if proven_ray(p) is not None else "nobody proves an optimum"
        return Verdict("wrong" if "unbounded" in why else "doubtful", why, **figures)
    excess = float(p.cost(a.x)) - best
    if excess <= cost_tolerance(p, a.x, best):
        return Verdict("unproven", "cost right, multipliers not", **figures)
    return Verdict("wrong", f"cost {float(p.cost(a.x)):.9e} instead of {best:.9e}", **figures)


def crossed(p):
    """By how much limits of one row cross, as a share of their size; 0 if none do."""
    lower, upper = np.concatenate([p.row_lower, p.lower]), np.concatenate([p.row_upper, p.upper])
    both = np.isfinite(lower) & np.isfinite(upper) & (lower > upper)
    return worst((lower - upper)[both] / (np.abs(lower) + np.abs(upper))[both])


def certificate(p, y, z):
    """(residual, margin): |A'y + z| of free variables as a share of its terms, and minus the weighted limits' sum as a
    share of its terms, after what is left for variables with bounds has been moved to these (exact: a certificate with
    other multipliers)."""
    y, z = (np.asarray(v, LONG) for v in without_nothing(p, np.asarray(y, float), np.asarray(z, float)))
    A = p.A.astype(LONG)
    combined, terms = A.T @ y, np.abs(A).T @ np.abs(y) + np.abs(z)
    exact = -combined
    bounded = np.where(exact > 0, np.isfinite(p.upper), np.isfinite(p.lower)) | (exact == 0)
    z = np.where(bounded, exact, z)
    residual = worst(ratio(np.abs(combined + z), np.where(bounded, 1, terms)))
    weighted, sizes = support(p, y, z)
    return residual, float(-weighted / sizes) if sizes > 0 else -1.0


def without_noise(p, y):
    """Multipliers of rows set to zero that vanish beside what another row has of some variable. What proves
    infeasibility without them proves it."""
    shares = np.abs(p.A) * np.abs(y)[:, None]
    terms = shares.sum(axis=0)
    vanishes = np.any((shares > 0) & (shares <= 1e-14 * terms), axis=1)
    return np.where(vanishes, 0.0, y)


def judge_infeasible(p, a):
    crossing = crossed(p)
    if crossing > BEYOND:
        return Verdict("right" if crossing > MARGIN else "doubtful", "limits cross", margin=crossing)
    if a.has(p, "y", "z"):
        residual, margin = min(certificate(p, a.y, a.z), certificate(p, without_noise(p, a.y), a.z))
        if residual <= ROUNDED and margin > MARGIN:
            return Verdict("right", residual=residual, margin=margin)
        if residual <= COARSER * ROUNDED and margin > BEYOND:
            # Either status is right, and the file may know which of the two was meant.
            known = residual <= ROUNDED and p.expected.get("status") == "infeasible"
            return Verdict("right" if known else "doubtful", residual=residual, margin=margin)
        figures = {"residual": residual, "margin": margin}
    else:
        figures = {}
    if feasible(p):
        return Verdict("wrong", "there is a feasible point", **figures)
    margin = farkas(p)
    if margin is None:
        return Verdict("doubtful", "no certificate, nor a feasible point that is found", **figures)
    return Verdict("unproven", f"infeasible (margin {margin:.0e}), the certificate does not show it", **figures)


def recession(p, d):
    """(curvature, violation, descent), each a share of its terms."""
    d = np.asarray(d, LONG)
    H, A = np.abs(p.symmetric()), p.A.astype(LONG)
    curvature = worst(ratio(np.abs(p.symmetric() @ d), H @ np.abs(d)))
    values = np.concatenate([A @ d, d])
    terms = np.concatenate([np.abs(A) @ np.abs(d), np.abs(d)])
    lower, upper = np.concatenate([p.row_lower, p.lower]), np.concatenate([p.row_upper, p.upper])
    leaving = np.maximum(np.where(np.isfinite(lower), -values, 0), np.where(np.isfinite(upper), values, 0))
    slope = p.g.astype(LONG) * d
    total = np.abs(slope).sum()
    return curvature, worst(ratio(np.maximum(leaving, 0), terms)), float(-slope.sum() / total) if total > 0 else 0.0


def judge_unbounded(p, a):
    figures = {}
    if a.has(p, "x") and np.any(a.x != 0):
        own = np.abs(a.x) / units(p)
        clean = np.where(own <= 1e-13 * worst(own), 0.0, a.x)
        # Components that are rounding of others count only if the ray is none without them.
        both = recession(p, a.x), recession(p, clean)
        curvature, violation, descent = min(both, key=lambda found: (found[1] > ROUNDED, found[0]))
        figures = {"curvature": curvature, "leaving": violation, "descent": descent}
        if curvature <= COARSER * ROUNDED and violation <= COARSER * ROUNDED and descent > BEYOND:
            if not feasible(p):
                return Verdict("doubtful", "the ray is one, of a problem without a feasible point", **figures)
            good = curvature <= ROUNDED and violation <= ROUNDED and descent > MARGIN
            return Verdict("right" if good else "doubtful", **figures)
    if not feasible(p):
        return Verdict("wrong", "there is no feasible point", **figures)
    if proven_ray(p) is not None:
        return Verdict("unproven", "unbounded, the ray does not show it", **figures)
    return Verdict("wrong", "there is no ray", **figures)


def judge(p, a):
    """The verdict on an answer to a problem; p is None where the line could not be read."""
    if p is None:
        return Verdict("right") if a.status == "invalid" else Verdict("wrong", "the line cannot be read")
    bad = p.bad_entry()
    if bad:
        return Verdict("right", bad) if a.status == "invalid" else Verdict("wrong", bad)
    curvature = p.least_curvature()
    if a.status == "invalid":
        if curvature < -1e-9:
            return Verdict("right", curvature=curvature)
        if crossed(p) > MARGIN:
            return Verdict("doubtful", "limits cross: infeasible rather than invalid")
        kind = "doubtful" if curvature < -1e-14 else "wrong"
        return Verdict(kind, "nothing is wrong with the problem beyond rounding", curvature=curvature)
    if curvature < -1e-9:
        return Verdict("wrong", "the cost is not convex", curvature=curvature)
    if a.status in UNSOLVED:
        return Verdict("unsolved", a.status)
    judges = {"optimal": judge_optimal, "infeasible": judge_infeasible, "unbounded": judge_unbounded}
    if a.status not in judges:
        return Verdict("wrong", f"status {a.status!r}")
    verdict = judges[a.status](p, a)
    expected = p.expected.get("status")
    # An answer that proves itself is right whatever a file expects; but somebody should look.
    if expected and expected != a.status and verdict.kind in ("right", "doubtful"):
        return Verdict("doubtful", f"proves itself, but {expected} is expected. {verdict.why}", **verdict.numbers)
    x = p.expected.get("x")
    if a.status == "optimal" and x is not None and verdict.kind in ("right", "doubtful", "unproven"):
        x = numbers(x)
        off = worst(np.abs(a.x - x) / np.maximum(np.abs(x), 1e-3 * worst(np.abs(x)) + 1e-9))
        if off > p.expected.get("relative_tolerance", 1e-6):
            return Verdict("wrong", f"x is {off:.1e} off the one that is known", **verdict.numbers)
    return verdict


def solved(p, a):
    """The criterion of benchmarks, or None where the file has no cost."""
    expected = p.expected
    if expected.get("objective") is None:
        return None
    if a.status != "optimal" or not a.has(p, "x"):
        return False
    tolerance = expected.get("objective_tolerance", 1e-6 * max(1.0, abs(expected["objective"])))
    return worst(violations(p, a.x)[0]) <= 1e-6 and abs(float(p.cost(a.x)) - expected["objective"]) <= tolerance


def read(files):
    """(line, problem or None) of every line, or of a file of one object that is spread over lines."""
    for file in files:
        for line in Path(file).read_text().splitlines():
            if line.strip():
                try:
                    yield line, Problem.parse(line)
                except (ValueError, KeyError, TypeError):
                    yield line, None


def from_program(program, lines):
    run = subprocess.run(program, input="\n".join(lines) + "\n", capture_output=True, text=True, check=False)
    if run.returncode != 0:
        print(f"{program[0]} ended with {run.returncode}: {run.stderr[-2000:]}", file=sys.stderr)
    answers = [Answer(json.loads(line)) for line in run.stdout.splitlines() if line.strip()]
    if len(answers) != len(lines):
        sys.exit(f"{program[0]}: {len(answers)} answers to {len(lines)} problems")
    return answers


def from_peer(name, problems):
    for p in problems:
        start = time.perf_counter()
        status, x, y, z = ask(name, p) if p is not None and p.bad_entry() is None else ("invalid", None, None, None)
        spent = (time.perf_counter() - start) * 1e6
        status = "optimal" if status == "almost" else status
        yield Answer({"status": status, "x": x, "y": y, "z": z, "microseconds": spent})


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("problems", nargs="+", type=Path)
    parser.add_argument("--solver", nargs="+", help="the program that answers, with its arguments")
    parser.add_argument("--answers", type=Path, help="what it has answered")
    parser.add_argument("--peers", nargs="*", default=[], choices=sorted(PEERS), help="judged beside it")
    parser.add_argument("--all", action="store_true", help="prints right answers as well")
    parser.add_argument("--quiet", action="store_true", help="prints none but wrong and unsolved ones")
    arguments = parser.parse_args()
    lines, problems = zip(*read(arguments.problems))
    entrants = {}
    if arguments.solver:
        entrants["solver"] = from_program(arguments.solver, lines)
    if arguments.answers:
        entrants["answers"] = [Answer(json.loads(line)) for line in arguments.answers.read_text().splitlines()]
    for peer in arguments.peers:
        entrants[peer] = list(from_peer(peer, problems))
    failed = False
    for name, answers in entrants.items():
        counts, good, known = collections.Counter(), 0, 0
        for index, (p, a) in enumerate(zip(problems, answers, strict=True)):
            verdict = judge(p, a)
            counts[verdict.kind] += 1
            is_solved = solved(p, a) if p is not None else None
            good, known = good + bool(is_solved), known + (is_solved is not None)
            shown = ("wrong", "unsolved") if arguments.quiet else ("wrong", "unsolved", "doubtful", "unproven")
            if arguments.all or verdict.kind in shown or is_solved is False:
                label = (p.name if p is not None else "") or f"line {index + 1}"
                mark = "" if is_solved is not False else "  NOT SOLVED"
                count = "" if a.iterations is None else f"{a.iterations:5} it."
                took = "" if a.microseconds is None else f"{a.microseconds:10.1f} us"
                print(f"{name:8} {label[:44]:44} {a.status:15} {count:9} {took:13} {verdict}{mark}")
        total = " ".join(f"{kind} {counts[kind]}" for kind in ("right", "doubtful", "unproven", "unsolved", "wrong"))
        print(f"{name}: {len(problems)} problems: {total}" + (f"; solved {good} of {known}" if known else ""))
        if name not in PEERS:
            failed |= counts["wrong"] > 0
    sys.exit(int(failed))


if __name__ == "__main__":
    main()
