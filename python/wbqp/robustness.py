"""Which rows still hold when something is not as the controller thinks: ``python -m wbqp.robustness``.

One thing at a time: mass, thrust, differences between rotors, bias of the force sensor, velocities that are estimated
from positions, stiffness of the wall, servos. The controllers are those that ship, the rows B4, C1, C2, D3 to D5, E1
and E3 of the experiments, the plants this project's own and MuJoCo.
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

from ._wbqp import _read_log, _rows, _simulate
from .experiments import scenarios

ROWS = {
    "push_with_disturbance": ("B4",),
    "push_and_slide": ("C1", "C2"),
    "push_away": ("D3", "D4", "D5"),
    "under_actuated": ("E1", "E3"),
}
"""The rows that are looked at, by experiment."""

_NEEDED = {
    "push_with_disturbance": ("with_ft",),
    "push_and_slide": ("with_ff",),
    "push_away": ("free", "contact"),
    "under_actuated": ("literal", "attitude_reference"),
}
_OTHERS = {"push_with_disturbance": ("no_ft",), "push_and_slide": ("without_ff", "heavier", "heavier_integral")}
"""Cases without which rows cannot be measured, though these rows have nothing of them: as they ship."""


def _bias(newton: float) -> dict[str, Any]:
    return {"sensors": {"force_torque": {"tool": {"force_bias": [newton] * 3}}}}


def _mismatch(**values: Any) -> dict[str, Any]:
    return {"plant": {"mismatch": values}}


def _wall(stiffness: float) -> dict[str, Any]:
    return {"plant": {"wall": {"wall": {"stiffness": stiffness}}}}


def _servo(scale: float) -> dict[str, Any]:
    return {"plant": {"servo": {"time_constant": 0.03 * scale}}}


VARIATIONS: Mapping[str, dict[str, Any]] = {
    "as it ships": {},
    "mass × 0.95": _mismatch(mass_scale=0.95),
    "mass × 1.05": _mismatch(mass_scale=1.05),
    "thrust × 0.95": _mismatch(thrust_scale=0.95),
    "thrust × 1.05": _mismatch(thrust_scale=1.05),
    "force bias -0.2 N": _bias(-0.2),
    "force bias 0.2 N": _bias(0.2),
    "rotors ± 2 % in turn": _mismatch(rotor_scales=[1.02, 0.98] * 3),
    "rotors ± 2 % by halves": _mismatch(rotor_scales=[1.02] * 3 + [0.98] * 3),
    "velocities estimated, 30 Hz": {
        "sensors": {"base": {"velocity_cutoff": 30.0}, "joints": {"velocity_cutoff": 30.0}}
    },
    "wall 5 kN/m": _wall(5e3),
    "wall 100 kN/m": _wall(1e5),
    "servo time × 0.5": _servo(0.5),
    "servo time × 1.5": _servo(1.5),
}
"""What is changed in the scenarios, by its name: the perturbations of `wbqp replicate --robustness`."""


def _toml(change: Mapping[str, Any], path: str = "change") -> str:
    """Nested tables as lines of dotted keys."""
    lines = []
    for key, value in change.items():
        if isinstance(value, Mapping):
            lines.append(_toml(value, f"{path}.{key}"))
        else:
            lines.append(f"{path}.{key} = {value}")
    return "\n".join(lines)


def _run(job: tuple[str, str, str, str, dict[str, Any]]) -> float | None:
    """Runs a case; the time at which it diverged, s, if it did."""
    plant, scenario, case, log, change = job
    Path(log).parent.mkdir(parents=True, exist_ok=True)
    if plant == "mujoco":
        from .mujoco import run_case

        summary: Mapping[str, Any] = run_case(scenario, case, log, variation=_toml(change))
    else:
        _, summary = _simulate(Path(scenario), case, 1, None, change or None, Path(log), None)
    diverged: float | None = summary["diverged"]
    return diverged


def sweep(out: Path, *, plants: list[str], names: list[str], folder: Path, jobs: int | None = None) -> dict[str, Any]:
    """Runs every variation on every plant.

    Returns
    -------
    dict
        By plant and variation, the rows: ``id``, ``quantity``, ``measured``, ``pass``.
    """
    work, labels = [], []
    for plant in plants:
        for index, name in enumerate(names):
            change = VARIATIONS[name]
            for experiment, cases in _NEEDED.items():
                for case in cases + (() if change else _OTHERS.get(experiment, ())):
                    log = out / plant / str(index) / experiment / f"{case}.mcap"
                    work.append((plant, str(folder / f"{experiment}.toml"), case, str(log), change))
                    labels.append((plant, name, experiment, case, log))
    with ProcessPoolExecutor(max_workers=jobs or os.cpu_count()) as pool:
        diverged = dict(zip(((*label[:4],) for label in labels), pool.map(_guarded, work)))
    logs = {label[:4]: label[4] for label in labels}
    results: dict[str, Any] = {}
    for plant in plants:
        for name in names:
            rows = results.setdefault(plant, {}).setdefault(name, [])
            for experiment, cases in _NEEDED.items():
                ended = [diverged[plant, name, experiment, case] for case in cases]
                failed = [str(e) for e in ended if e is not None]
                if failed:
                    why = {"quantity": failed[0], "measured": None, "pass": False}
                    rows += [{"id": id_, **why} for id_ in ROWS[experiment]]
                    continue
                read = {case: _read_log(logs[plant, name, experiment, case]) for case in cases}
                for case in _OTHERS.get(experiment, ()):
                    read[case] = _read_log(logs[plant, names[0], experiment, case])
                keys = ("id", "quantity", "measured", "pass")
                measured = [row for row in _rows(experiment, read) if row["pass"] is not None]
                rows += [{key: row[key] for key in keys} for row in measured if row["id"] in ROWS[experiment]]
    return results


def _guarded(job: tuple[str, str, str, str, dict[str, Any]]) -> str | None:
    """What keeps a case from being measured, in words."""
    try:
        diverged = _run(job)
    except (RuntimeError, ValueError, KeyError) as error:
        return str(error)
    return None if diverged is None else f"diverged at {diverged:.2f} s"


def table(results: Mapping[str, Any]) -> str:
    """A line per variation and plant: ✓ where all rows of an id hold, else what was measured of those that do not."""
    ids = [id_ for experiment in ROWS.values() for id_ in experiment]
    lines = ["| variation | plant | " + " | ".join(ids) + " |", "|---|---|" + "---|" * len(ids)]
    names = list(next(iter(results.values())))
    for name in names:
        for plant, variations in results.items():
            cells = []
            for id_ in ids:
                missed = [row for row in variations[name] if row["id"] == id_ and not row["pass"]]
                values = ["–" if row["measured"] is None else f"{row['measured']:.3g}" for row in missed]
                cells.append("✗ " + ", ".join(values) if missed else "✓")
            lines.append(f"| {name} | {plant} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def main(arguments: list[str] | None = None) -> int:
    """The command line."""
    parser = argparse.ArgumentParser(prog="python -m wbqp.robustness", description=__doc__)
    parser.add_argument("--plant", nargs="+", choices=["own", "mujoco"], default=["own", "mujoco"])
    known = list(VARIATIONS)
    parser.add_argument("--only", nargs="+", choices=known[1:], default=known[1:], metavar="NAME", help="of these")
    parser.add_argument("--out", type=Path, default=Path("out/robustness"), help="folder of logs and results")
    parser.add_argument("--jobs", type=int, help="cases at a time; as many as there are processors if not given")
    parser.add_argument("--scenarios", type=Path, help="folder of the scenario files instead of those that ship")
    given = parser.parse_args(arguments)
    folder = scenarios(given.scenarios)
    results = sweep(given.out, plants=given.plant, names=known[:1] + given.only, folder=folder, jobs=given.jobs)
    text = json.dumps(results, indent=1, ensure_ascii=False)
    (given.out / "robustness.json").write_text(text + "\n", encoding="utf-8")
    print(table(results))
    every = [row["pass"] for variations in results.values() for rows in variations.values() for row in rows]
    return 0 if all(every) else 1


if __name__ == "__main__":
    sys.exit(main())
