#!/usr/bin/env python3
"""wbqp's solver, DAQP and eiquadprog on problems of ticks with active limits: qp.sh builds what this needs.

    python3 tests/peers/qp.py --wbqp target/release/wbqp_qp --peer target/peers-qp/qp_peer target/peers-qp/*.ticks

All solvers take the same problems in the same order, in turns of BLOCK of them, which end elsewhere in every pass: what
disturbs the machine disturbs all.
Every problem is read once before its clock starts, as a controller has its problem in the caches.
Each goes through the file PASSES times; of every problem its least time counts, and of these the median and the 99th
percentile are printed, and the peer's divided by wbqp's. A ratio below 1 is a problem on which the peer is faster.

Warm starts from the tick before (the first of each sequence has none and is left out), cold from nothing. Whether they
agree: the largest violation of a limit in units of the problem, the cost's difference relative to 1 + |cost|, and how
many problems a solver does not call optimal.
"""

import argparse
import json
import os
import platform
import re
import struct
import subprocess
import sys
import tempfile
from array import array
from collections import Counter
from pathlib import Path

import numpy as np

BLOCK, PASSES = 100, 4
# (name, which program, its method, the method of wbqp it is compared with). `own`: with its package's own flags, which
# let the compiler change the order of sums.
ENTRANTS = [
    ("wbqp, warm", "wbqp", "warm", None),
    ("wbqp, cold", "wbqp", "cold", None),
    ("DAQP, warm", "peer", "daqp_warm", "wbqp, warm"),
    ("DAQP, cold", "peer", "daqp_cold", "wbqp, cold"),
    ("DAQP, own flags, warm", "own", "daqp_warm", "wbqp, warm"),
    ("DAQP, own flags, cold", "own", "daqp_cold", "wbqp, cold"),
    ("DAQP, equalities eliminated, warm", "own", "daqp_warm_reduced", "wbqp, warm"),
    ("DAQP, one call, cold", "own", "daqp_once", "wbqp, cold"),
    ("eiquadprog, cold", "peer", "eiquadprog", "wbqp, cold"),
]
TITLES = {
    "drifting_12": "drifting, 12 variables",
    "drifting_30": "drifting, 30 variables",
    "drifting_60": "drifting, 60 variables",
    "aerial_12": "sequence `aerial`, 3 to 8 active",
    "quadruped_30": "sequence `quadruped`, 3 to 8 active",
    "aerial_12_swelling": "sequence `aerial`, 0 to 4 active",
    "humanoid_60_swelling": "sequence `humanoid`, 0 to 21 active",
    "push_away": "experiment D's move, OTHex",
    "quadruped_slip": "quadruped, pushed until feet slip",
    "humanoid_slip": "humanoid, pushed until feet slip",
}


class Program:
    """A process that solves on request."""

    def __init__(self, path, file):
        self.process = subprocess.Popen([path, file], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def ask(self, line):
        self.process.stdin.write(line + "\n")
        self.process.stdin.flush()
        answer = self.process.stdout.readline()
        if not answer:
            sys.exit(f"the program ended on `{line}`")
        return answer

    def outcomes(self, skipped):
        """(optimal, iterations, x) of every problem; `skipped` numbers stand before x."""
        with tempfile.NamedTemporaryFile("r") as file:
            self.ask(f"write {file.name}")
            lines = [line.split() for line in Path(file.name).read_text().splitlines()]
        return [(words[0] == "1", int(words[1]), np.array(words[skipped:], dtype=float)) for words in lines]

    def end(self):
        self.process.stdin.close()
        self.process.wait()


class Ticks:
    """A file of problems, as far as it takes to judge a solution."""

    def __init__(self, path):
        data = Path(path).read_bytes()
        assert data[:8] == b"WBQPTK01", path
        (count,), at = struct.unpack_from("<I", data, 8), 12
        self.problems = []
        for _ in range(count):
            n, m, first, _ = struct.unpack_from("<4I", data, at)
            at += 16
            sizes = [n * n, n, m * n, m, m, n, n]
            parts = []
            for size in sizes:
                values = array("d")
                values.frombytes(data[at : at + 8 * size])
                parts.append(np.array(values))
                at += 8 * size
            at += 4 * (m + n)
            parts[0], parts[2] = parts[0].reshape(n, n), parts[2].reshape(m, n)
            self.problems.append((bool(first), *parts))
        self.first = np.array([p[0] for p in self.problems])

    def shape(self):
        """Variables, equalities and inequalities of most of them."""
        sizes = Counter((len(h), int(np.sum(low == high)), len(a)) for _, h, _, a, low, high, *_ in self.problems)
        (n, equal, rows), _ = sizes.most_common(1)[0]
        return n, equal, rows - equal

    def judged(self, outcomes, references):
        """(largest violation, largest difference of costs in size, not optimal)."""
        violation, difference, failed = 0.0, 0.0, 0
        for (_, h, g, a, low, high, lower, upper), (optimal, _, x), (_, _, reference) in zip(
            self.problems, outcomes, references
        ):
            if not optimal:
                failed += 1
                continue
            rows = a @ x
            beyond = [np.max(v, initial=0) for v in (low - rows, rows - high, lower - x, x - upper)]
            violation = max(violation, *beyond)
            cost = lambda x, h=h, g=g: 0.5 * x @ h @ x + g @ x  # noqa: E731
            difference = max(difference, (cost(x) - cost(reference)) / (1 + abs(cost(reference))), key=abs)
        return float(violation), float(difference), failed


def measure(path, programs, passes, methods):
    ticks = Ticks(path)
    count = len(ticks.problems)
    running = {name: Program(program, path) for name, program in programs.items() if program}
    entrants = [e for e in ENTRANTS if e[0] in methods and e[1] in running]
    times = {name: np.full((passes, count), np.nan) for name, *_ in entrants}
    for turn in range(passes):
        # Another one begins each time.
        order = entrants[turn % len(entrants) :] + entrants[: turn % len(entrants)]
        # Turns end elsewhere in every pass: a turn's first problem waits for code and data of its solver, and would be
        # the same one, and with 1000 problems the 99th percentile, in all of them.
        for start in range(-(turn * BLOCK // passes), count, BLOCK):
            start, end = max(start, 0), min(start + BLOCK, count)
            for name, program, method, _ in order:
                answer = running[program].ask(f"{method} {start} {end}")
                times[name][turn, start:end] = np.array(answer.split(), dtype=float) * 1e-3
    rows, references = {}, None
    for name, program, method, against in entrants:
        running[program].ask(f"{method} 0 {count}")
        outcomes = running[program].outcomes(3 if program == "wbqp" else 2)
        references = references or outcomes
        least = times[name].min(axis=0)
        counted = least[~ticks.first] if "warm" in name else least
        violation, difference, failed = ticks.judged(outcomes, references)
        rows[name] = {
            "p50": float(np.quantile(counted, 0.5)),
            "p99": float(np.quantile(counted, 0.99)),
            "iterations": float(np.median([o[1] for o in outcomes])),
            "violation": violation,
            "cost": difference,
            "failed": failed,
            "against": against,
        }
    for program in running.values():
        program.end()
    for row in rows.values():
        if row["against"]:
            reference = rows[row["against"]]
            row["ratio"], row["ratio_p99"] = row["p50"] / reference["p50"], row["p99"] / reference["p99"]
    n, equal, unequal = ticks.shape()
    return {"problems": count, "size": f"{n} / {equal} / {unequal}", "rows": rows}


def markdown(results):
    """The table of ratios, then times and checks."""
    measured = [result["rows"] for result in results.values()]
    columns = [name for name, _, _, against in ENTRANTS if against and any(name in rows for rows in measured)]
    lines = [
        "| peer ÷ wbqp: p50 (p99) | variables / equalities / inequalities | " + " | ".join(columns) + " |",
        "|---" * 2 + "|---:" * len(columns) + "|",
    ]

    def ratio(row):
        if row is None:
            return ""
        shown = [f"{v:.2f}" if v >= 1 else f"**{v:.2f}**" for v in (row["ratio"], row["ratio_p99"])]
        return f"{shown[0]} ({shown[1]})"

    for name, result in results.items():
        cells = [ratio(result["rows"].get(column)) for column in columns]
        lines.append(f"| {TITLES.get(name, name)} | {result['size']} | " + " | ".join(cells) + " |")
    lines += [
        "",
        "| µs | solver | p50 | p99 | iterations, p50 | violation | cost | not optimal |",
        "|---|---|---:|---:|---:|---:|---:|---:|",
    ]
    for name, result in results.items():
        for solver, row in result["rows"].items():
            lines.append(
                f"| {TITLES.get(name, name)} | {solver} | {row['p50']:.2f} | {row['p99']:.2f} "
                f"| {row['iterations']:.0f} | {row['violation']:.0e} | {row['cost']:+.0e} | {row['failed'] or ''} |"
            )
    return "\n".join(lines)


def machine():
    names = re.findall(r"model name\s*: (.*)", Path("/proc/cpuinfo").read_text())
    name, load = (names or [platform.processor()])[0], os.getloadavg()[2]
    return f"{name}, {os.cpu_count()} logical cores; load over the last 15 minutes {load:.1f}."


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="+", type=Path, help="written by qp_ticks")
    parser.add_argument("--wbqp", required=True, help="the program wbqp_qp")
    parser.add_argument("--peer", required=True, help="the program qp_peer")
    parser.add_argument("--own", help="the same program, DAQP compiled with its package's flags")
    parser.add_argument("--passes", type=int, default=PASSES)
    parser.add_argument("--only", nargs="*", metavar="METHOD", help="methods of the peer, such as daqp_warm daqp_cold")
    parser.add_argument("--json", type=Path, help="also writes the results there")
    parser.add_argument("--page", type=Path, help="writes the tables between its marks `qp`")
    arguments = parser.parse_args()
    methods = {e[0] for e in ENTRANTS if e[3] is None or not arguments.only or e[2] in arguments.only}
    results = {}
    for file in arguments.files:
        programs = {"wbqp": arguments.wbqp, "peer": arguments.peer, "own": arguments.own}
        results[file.stem] = measure(file, programs, arguments.passes, methods)
        print(markdown({file.stem: results[file.stem]}), end="\n\n", flush=True)
    if arguments.json:
        arguments.json.write_text(json.dumps(results, indent=2) + "\n")
    if arguments.page:
        text, pattern = arguments.page.read_text(), re.compile(r"(<!-- begin qp -->\n).*?(<!-- end qp -->)", re.DOTALL)
        if not pattern.search(text):
            sys.exit(f"{arguments.page}: there is no place for qp")
        content = f"{machine()} Best of {arguments.passes} passes.\n\n{markdown(results)}"
        arguments.page.write_text(pattern.sub(lambda m: f"{m[1]}\n{content}\n\n{m[2]}", text))


if __name__ == "__main__":
    main()
