#!/usr/bin/env python3
"""Writes the tables of docs/performance.md from what measure.sh has measured.

    python3 tests/peers/performance.py FOLDER docs/performance.md

A table stands between `<!-- begin NAME -->` and `<!-- end NAME -->`; the rest of the page is written by hand.
"""

import json
import os
import platform
import re
import sys
from pathlib import Path

WORKLOADS = [
    ("othex_none", "OTHex, free flight, n_c = 0"),
    ("othex_normal", "OTHex, `normal`, n_c = 1"),
    ("othex_normal_tilt", "OTHex, `normal_tilt`, n_c = 3"),
    ("othex_point", "OTHex, `point`, n_c = 3"),
    ("othex_full", "OTHex, `full`, n_c = 6"),
    ("quadruped", "quadruped, four points"),
    ("humanoid", "humanoid, two soles"),
]
BUILDS = ["portable", "native"]
STAGES = ["dynamics", "rows", "assembly", "solve", "output"]
# (what, of which workload, value, promised)
PROMISED = [
    ("dynamics set, 9 DoF, p50", "othex_point", lambda s: s["dynamics_set"]["p50"], 0.5),
    ("tick, OTHex with a 3-D contact, p50", "othex_point", lambda s: s["tick"]["p50"], 6.0),
    ("tick, OTHex with a 3-D contact, p99, best of five batches", "othex_point", lambda s: s["best_p99"], 15.0),
    ("tick, quadruped, p50", "quadruped", lambda s: s["tick"]["p50"], 12.0),
    ("tick, humanoid, p50", "humanoid", lambda s: s["tick"]["p50"], 45.0),
]
SEQUENCES = ["12 variables, 5 rows", "60 variables, 18 equalities, 70 rows"]
# (what, of which sequence, whose median, promised: portable, native)
PROMISED_SOLVES = [
    ("solve, 12 variables, warm, p50", 0, "warm, ± 2 active", 2.0, 1.5),
    ("solve, 60 variables, 18 equalities, 70 rows, warm, p50", 1, "warm, ± 2 active", 45.0, 40.0),
    ("the same, cold, p50", 1, "active set, cold", 110.0, None),
]
# How much longer Clarabel is promised to take for 12 variables.
PROMISED_RATIO = 25


def table(header, rows):
    marks = ["---"] + ["---:"] * (len(header) - 1)
    return "\n".join("| " + " | ".join(row) + " |" for row in [header, marks, *rows])


def us(value):
    return f"{value:.2f}" if value < 100 else f"{value:.0f}"


def median(block, who):
    """The p50 of one solver in what `qp_medians` printed of a sequence."""
    return float(re.search(rf"^ *{re.escape(who)} +p50 +([0-9.]+)", block, re.MULTILINE)[1])


class Results:
    def __init__(self, folder):
        self.folder = folder

    def get(self, name, build="portable"):
        file = self.folder / f"{name}.{build}.json"
        return json.loads(file.read_text()) if file.exists() else None

    def machine(self):
        cpu = next(
            (
                line.split(":", 1)[1].strip()
                for line in Path("/proc/cpuinfo").read_text().splitlines()
                if "model name" in line
            ),
            platform.processor(),
        )
        load = os.getloadavg()
        return (
            f"{cpu}, {os.cpu_count()} logical cores, {platform.system()}; "
            f"load over the last 15 minutes {load[2]:.1f}."
        )

    def promised(self):
        rows = []
        for what, workload, value, limit in PROMISED:
            measured = [self.get(workload, build) for build in BUILDS]
            values = [value(s) if s else None for s in measured]
            met = "yes" if values[0] is not None and values[0] <= limit else "**no**"
            rows.append([what, f"≤ {us(limit)}", *(us(v) if v is not None else "" for v in values), met])
        runs = [self.best_solves(build) for build in BUILDS]
        for what, sequence, who, *limits in PROMISED_SOLVES:
            values = [median(run[sequence], who) for run in runs]
            known = [limit for limit in limits if limit is not None]
            met = "yes" if all(value <= limit for value, limit in zip(values, known)) else "**no**"
            rows.append([what, "≤ " + ", native ≤ ".join(map(us, known)), *map(us, values), met])
        ratios = [median(run[0], "Clarabel") / median(run[0], "warm, ± 2 active") for run in runs]
        met = "yes" if ratios[0] >= PROMISED_RATIO else "**no**"
        rows.append(["Clarabel's solve ÷ this, 12 variables, warm", f"≥ {PROMISED_RATIO}",
                     *(f"{r:.0f}" for r in ratios), met])
        return table(["µs", "promised", "portable", "native", "met by portable, and by native where it is named"], rows)

    def ticks(self):
        rows = []
        for name, title in WORKLOADS:
            for build in BUILDS:
                s = self.get(name, build)
                if s:
                    q, loop = s["tick"], s["in_loop"]
                    rows.append([f"{title}, {build}", us(q["p50"]), us(q["p90"]), us(q["p99"]), us(s["best_p99"]),
                                 us(q["p999"]), us(q["max"]), us(loop["p50"]), str(s["allocations"])])
        return table(
            ["tick, µs", "p50", "p90", "p99", "best p99", "p99.9", "max", "p50 in the loop", "allocations"], rows
        )

    def stages(self):
        rows = []
        for name, title in WORKLOADS:
            for build in BUILDS:
                s = self.get(name, build)
                if s:
                    values = [f"{us(s[stage]['p50'])} / {us(s[stage]['p99'])}" for stage in STAGES]
                    rows.append([f"{title}, {build}", *values, us(s["dynamics_set"]["p50"])])
        return table(["p50 / p99, µs", *STAGES, "M, h, one J, J̇v alone"], rows)

    def problems(self):
        rows = []
        for name, title in WORKLOADS:
            s = self.get(name)
            if s:
                p, i = s["problem"], s["iterations"]
                sizes = [p["variables"], p["bounded"], p["equalities"], p["inequalities"]]
                rows.append([title, *map(str, sizes), f"{i['p50']} / {i['p99']} / {i['max']}",
                             str(s["ticks"]), str(s["not_optimal"])])
        return table(
            ["", "variables", "bounded", "equalities", "inequalities", "iterations p50 / p99 / max", "ticks",
             "not optimal"],
            rows,
        )

    def ratios(self):
        rows = []
        for robot, title in [("othex", "OTHex, `point`"), ("quadruped", "quadruped"), ("humanoid", "humanoid")]:
            own = self.get("othex_point" if robot == "othex" else robot)
            clarabel = self.get(f"{robot}_clarabel")
            if not (own and clarabel):
                continue
            solve = clarabel["solve"]["p50"] / own["solve"]["p50"]
            tick = clarabel["tick"]["p50"] / own["tick"]["p50"]
            rows.append([title, us(own["solve"]["p50"]), us(clarabel["solve"]["p50"]), f"{solve:.0f}", f"{tick:.0f}"])
        return table(["", "solve, µs", "with Clarabel, µs", "ratio of solves", "ratio of ticks"], rows)

    def formulations(self):
        names = sorted(
            {f.name.split(".")[0].split("_", 1)[1] for f in self.folder.glob("humanoid_*.json")} - {"clarabel"}
        )
        rows = []
        for robot, title in [("othex", "OTHex, `point`"), ("quadruped", "quadruped"), ("humanoid", "humanoid")]:
            for name in names:
                s = self.get(f"{robot}_{name}")
                if s:
                    p = s["problem"]
                    rows.append([f"{title}, {name}", f"{p['variables']} / {p['equalities']} / {p['inequalities']}",
                                 *(us(s[stage]["p50"]) for stage in ["assembly", "solve", "tick"])])
        return table(["p50, µs", "variables / equalities / inequalities", "assembly", "solve", "tick"], rows)

    def best_solves(self, build):
        """Of each sequence, the run with the least median of warm solves."""
        best = {}
        for file in sorted(self.folder.glob(f"solves.{build}.*.txt")):
            for block in re.split(r"^(?=\S)", file.read_text(), flags=re.MULTILINE)[1:]:
                sequence = next(i for i, title in enumerate(SEQUENCES) if block.startswith(title))
                if sequence not in best or (
                    median(block, "active set, warm") < median(best[sequence], "active set, warm")
                ):
                    best[sequence] = block
        return best

    def solves(self):
        runs = [(build, self.best_solves(build)) for build in BUILDS]
        blocks = ["".join(run[i] for i in range(len(SEQUENCES))).rstrip() for _, run in runs]
        return "\n\n".join(f"{build.capitalize()}:\n\n```text\n{block}\n```" for (build, _), block in zip(runs, blocks))

    def peers(self):
        file = self.folder / "peers.json"
        if not file.exists():
            return ""
        sys.path.insert(0, str(Path(__file__).parent))
        from compare import markdown

        return "\n".join(markdown(name, rows) for name, rows in json.loads(file.read_text()).items()).rstrip()


def main():
    folder, page = Path(sys.argv[1]), Path(sys.argv[2])
    results, text = Results(folder), page.read_text()
    for name in ["machine", "promised", "ticks", "stages", "problems", "ratios", "formulations", "solves", "peers"]:
        pattern = re.compile(rf"(<!-- begin {name} -->\n).*?(<!-- end {name} -->)", re.DOTALL)
        content = getattr(results, name)()
        if not pattern.search(text):
            sys.exit(f"{page}: there is no place for {name}")
        text = pattern.sub(lambda m, content=content: f"{m[1]}\n{content}\n\n{m[2]}", text)
    page.write_text(text)


if __name__ == "__main__":
    main()
