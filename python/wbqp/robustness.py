"""Which rows still hold in MuJoCo when something is not as the controller thinks: ``python -m wbqp.robustness``.

What is tried, one thing at a time, and the rows that are looked at are those of `cargo run --release -- --robustness`,
which does the same with this project's plant. The variant of each experiment is the one with an observer of the
unknown wrench, or with `--papers` that with the paper's gains.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections.abc import Mapping
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

from ._wbqp import _perturbations, _perturbed, _read_log, _robust, _rows
from .experiments import scenarios

_Job = tuple[str, str, Path, int]


def _run(job: _Job) -> str | None:
    """Runs a case with the perturbation at an index; what keeps it from being measured, in words."""
    from .mujoco import run_case

    scenario, case, log, index = job
    log.parent.mkdir(parents=True, exist_ok=True)
    try:
        summary = run_case(scenario, case, log, variation=_perturbed(scenario, case, index))
    except (RuntimeError, ValueError, KeyError) as error:
        return str(error)
    diverged = summary["diverged"]
    return None if diverged is None else f"diverged at {diverged:.2f} s"


def sweep(
    out: Path, *, indices: list[int], folder: Path, papers: bool = False, jobs: int | None = None
) -> dict[str, list[dict[str, Any]]]:
    """Runs perturbations, by their index, of every experiment that has rows which are to hold.

    Returns
    -------
    dict
        By perturbation in words, the rows: ``id``, ``quantity``, ``measured``, ``pass``.
    """
    variant = 0 if papers else 1
    work: list[_Job] = []
    for index in indices:
        for experiment, variants in _robust().items():
            for case in variants[variant]:
                log = out / str(index) / experiment / f"{case}.mcap"
                work.append((str(folder / f"{experiment}.toml"), case, log, index))
    with ProcessPoolExecutor(max_workers=jobs or os.cpu_count()) as pool:
        failed = {job[2]: why for job, why in zip(work, pool.map(_run, work)) if why is not None}
    results: dict[str, list[dict[str, Any]]] = {}
    for index in indices:
        rows = results.setdefault(_perturbations()[index], [])
        for experiment, variants in _robust().items():
            cases = variants[variant]
            logs = {case: out / str(index) / experiment / f"{case}.mcap" for case in cases}
            why = [failed[log] for log in logs.values() if log in failed]
            if why:
                rows.append({"id": experiment, "quantity": why[0], "measured": None, "pass": False})
                continue
            found = _rows(experiment, {case: _read_log(log) for case, log in logs.items()}, cases)
            rows += [{key: row[key] for key in ("id", "quantity", "measured", "pass")} for row in found]
    return results


def table(results: Mapping[str, list[dict[str, Any]]]) -> str:
    """A line per perturbation: what of it holds, or what was measured of the rows that do not."""
    lines = ["| | holds | does not |", "|---|---|---|"]
    for name, rows in results.items():
        missed = [row for row in rows if not row["pass"]]
        texts = [
            f"{row['id']} {row['quantity']}: {'–' if row['measured'] is None else format(row['measured'], '.3g')}"
            for row in missed
        ]
        lines.append(f"| {name} | {len(rows) - len(missed)} of {len(rows)} | {'; '.join(texts)} |")
    return "\n".join(lines)


def main(arguments: list[str] | None = None) -> int:
    """The command line."""
    parser = argparse.ArgumentParser(prog="python -m wbqp.robustness", description=__doc__)
    known = _perturbations()
    parser.add_argument("--only", nargs="+", choices=known, default=known, metavar="NAME", help="of these")
    parser.add_argument("--papers", action="store_true", help="the variant with the paper's gains")
    parser.add_argument("--out", type=Path, default=Path("out/robustness"), help="folder of logs and results")
    parser.add_argument("--jobs", type=int, help="cases at a time; as many as there are processors if not given")
    parser.add_argument("--scenarios", type=Path, help="folder of the scenario files instead of those that ship")
    given = parser.parse_args(arguments)
    folder = scenarios(given.scenarios)
    indices = [known.index(name) for name in given.only]
    results = sweep(given.out, indices=indices, folder=folder, papers=given.papers, jobs=given.jobs)
    text = json.dumps(results, indent=1, ensure_ascii=False)
    (given.out / "robustness.json").write_text(text + "\n", encoding="utf-8")
    print(table(results))
    return 0 if all(row["pass"] for rows in results.values() for row in rows) else 1


if __name__ == "__main__":
    sys.exit(main())
