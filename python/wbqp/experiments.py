"""The experiments of the paper on another engine: ``python -m wbqp.experiments --plant mujoco``.

Every case of experiments B, C, D, E and of ``switching`` runs from the scenario files that ship, with the controllers
that ship; rows are measured from the logs by the same definitions as those of ``wbqp replicate``. The exit status is 0
if every promised row is met.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

from ._wbqp import _experiments, _read_log, _rows


EXPERIMENTS = ("push_with_disturbance", "push_and_slide", "push_away", "under_actuated", "switching")
"""In the paper's order."""


def scenarios(given: Path | None = None) -> Path:
    """The folder of the scenario files that ship: inside the package, or in the clone that it was built from."""
    here = Path(__file__).resolve()
    folders = [given] if given else [here.parent / "scenarios", here.parents[2] / "examples" / "scenarios"]
    for folder in folders:
        if (folder / "push_with_disturbance.toml").is_file():
            return folder
    raise FileNotFoundError(f"there are no scenarios in {' or '.join(map(str, folders))}: --scenarios DIR")


def _run(job: tuple[str, str, str, str, int, float]) -> tuple[str, str, dict[str, Any]]:
    from .mujoco import run_case

    experiment, case, scenario, log, seed, step = job
    return experiment, case, dict(run_case(scenario, case, log, seed=seed, step=step))


def run(
    out: Path, *, names: list[str], folder: Path, seed: int = 1, step: float = 1.25e-4, jobs: int | None = None
) -> dict[str, dict[str, Any]]:
    """Runs experiments in MuJoCo; logs go to ``<out>/<experiment>/<case>.mcap``.

    Returns
    -------
    dict
        By experiment: ``rows``, ``breaches`` (promises that are not kept, in words) and ``cases`` with what is to be
        told of each run.
    """
    cases = _experiments()
    work = []
    for name in names:
        (out / name).mkdir(parents=True, exist_ok=True)
        scenario = str(folder / f"{name}.toml")
        work += [(name, case, scenario, str(out / name / f"{case}.mcap"), seed, step) for case in cases[name]]
    results: dict[str, dict[str, Any]] = {name: {"rows": [], "breaches": [], "cases": {}} for name in names}
    with ProcessPoolExecutor(max_workers=jobs or os.cpu_count()) as pool:
        for name, case, summary in pool.map(_run, work):
            results[name]["cases"][case] = summary
    for name, result in results.items():
        diverged = {case: s["diverged"] for case, s in result["cases"].items() if s["diverged"] is not None}
        if diverged:
            result["breaches"] = [f"{case}: diverged at {time:.3f} s" for case, time in diverged.items()]
            continue
        logs = {case: _read_log(out / name / f"{case}.mcap") for case in cases[name]}
        result["rows"] = _rows(name, logs)
        result["breaches"] = [text for text in map(_breach, result["rows"]) if text]
    return results


def _breach(row: dict[str, Any]) -> str | None:
    """What is wrong with a row, by what is promised of it."""
    label = f"{row['id']} {row['quantity']!r}"
    if row["promised"] and row["pass"] is not True:
        return f"{label} is promised but missed: measured {row['measured']}, accepted {row['tolerance']}"
    if row["pass"] is not None and not row["promised"] and not row["reason"]:
        return f"{label} is judged, but neither promised nor missed with a reason"
    return None


def table(rows: list[dict[str, Any]]) -> str:
    """The rows as text."""
    marks = {True: "✓", False: "✗", None: "·"}
    lines = []
    for row in rows:
        measured = "–" if row["measured"] is None else f"{row['measured']:.4g}"
        mark = marks[row["pass"]]
        lines.append(f"{mark} {row['id']:5} {row['quantity']:80} {measured:>10} {row['unit']:7} {row['tolerance']}")
    return "\n".join(lines)


def main(arguments: list[str] | None = None) -> int:
    """The command line."""
    parser = argparse.ArgumentParser(prog="python -m wbqp.experiments", description=__doc__)
    known = list(EXPERIMENTS)
    parser.add_argument("--plant", choices=["mujoco"], required=True, help="the engine")
    parser.add_argument("--out", type=Path, default=Path("out/mujoco"), help="folder of logs and results")
    parser.add_argument("--only", nargs="+", choices=known, default=known, metavar="NAME", help="these experiments")
    parser.add_argument("--seed", type=int, default=1, help="of the sensors' noise")
    parser.add_argument("--step", type=float, default=1.25e-4, help="integration step, s")
    parser.add_argument("--jobs", type=int, help="cases at a time; as many as there are processors if not given")
    parser.add_argument("--scenarios", type=Path, help="folder of the scenario files instead of those that ship")
    parser.add_argument("--record", type=Path, metavar="FILE", help="keeps the rows for docs/replication.md")
    given = parser.parse_args(arguments)
    try:
        import mujoco  # type: ignore[import-untyped, import-not-found, unused-ignore]
    except ImportError:
        print("error: MuJoCo is not installed: pip install mujoco", file=sys.stderr)
        return 1
    folder = scenarios(given.scenarios)
    results = run(given.out, names=given.only, folder=folder, seed=given.seed, step=given.step, jobs=given.jobs)
    kept = 0
    for name, result in results.items():
        print(f"\n{name}\n{table(result['rows'])}")
        for case, summary in result["cases"].items():
            if summary["held"]:
                print(f"{case}: {summary['held']} of {summary['ticks']} ticks kept the last command", file=sys.stderr)
        for breach in result["breaches"]:
            print(f"{name}: {breach}", file=sys.stderr)
        kept += sum(row["promised"] and row["pass"] is True for row in result["rows"])
    said = {"engine": f"MuJoCo {mujoco.__version__}", "step": given.step, "seed": given.seed, "experiments": results}
    (given.out / "mujoco.json").write_text(json.dumps(said, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    if given.record:
        keys = ("id", "quantity", "measured", "pass")
        rows = {
            # How long a tick took is the machine's.
            name: [{key: row[key] for key in keys} for row in result["rows"] if row["id"] != "time"]
            for name, result in results.items()
        }
        text = json.dumps({**said, "experiments": rows}, indent=1, ensure_ascii=False)
        given.record.write_text(text + "\n", encoding="utf-8")
    missed = [name for name, result in results.items() if result["breaches"]]
    print(f"\nNot as promised: {', '.join(missed)}." if missed else f"\nAll promised rows are met: {kept}.")
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
