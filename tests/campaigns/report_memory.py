"""How much memory the report of a long table takes: ``report_memory.py WBQP ROWS FOLDER``.

The table has the columns of experiment B's, and no run behind it. Fails above 80 MB and 40 bytes per row.
"""

from __future__ import annotations

import json
import multiprocessing
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

FACTORS = [f"factor_{i}" for i in range(20)]
JUDGED = [f"measure_{i}" for i in range(5)]
MEASURES = [*JUDGED, "informative"]
VARIANTS = ["papers", "observer"]
GROUP = 1 << 16


def description(rows: int) -> str:
    def measure(name: str) -> dict[str, object]:
        is_judged = name in JUDGED
        return {"name": name, "unit": "N", "tolerance": "≤ 1 N", "is_judged": is_judged, "counts": is_judged}

    about = {
        "name": "synthetic",
        "fingerprint": "0" * 64,
        "runs": rows,
        "points": rows // len(VARIANTS),
        "plan": 'name = "synthetic"\n',
        "variants": VARIANTS,
        "factors": [{"name": name, "relation": "scale"} for name in FACTORS],
        "measures": [measure(name) for name in MEASURES],
    }
    return json.dumps(about)


def group(first: int, lines: int, rng: np.random.Generator) -> pa.Table:
    """Some lines: the larger a factor is, the larger is the measure of its number."""
    run = np.arange(first, first + lines)
    factors = rng.uniform(0.9, 1.1, (lines, len(FACTORS)))
    # One in a hundred ends early.
    early = rng.uniform(size=lines) < 0.01
    times = 25 * rng.uniform(size=lines)
    reasons = [f"the plant diverged at {time:.2f} s" if is_early else None for is_early, time in zip(early, times)]
    columns: dict[str, object] = {
        "run": run,
        "point": run // len(VARIANTS),
        "seed": 1 + run // len(VARIANTS),
        "variant": [VARIANTS[number % len(VARIANTS)] for number in run],
    }
    columns |= {f"factor.{name}": factors[:, i] for i, name in enumerate(FACTORS)}
    columns["status"] = ["diverged" if is_early else "completed" for is_early in early]
    columns["reason"] = pa.array(reasons, pa.string())
    measured = 4 * np.abs(factors[:, : len(MEASURES)] - 1) + 0.3 * rng.standard_normal((lines, len(MEASURES)))
    holds = (measured[:, : len(JUDGED)] <= 1) & ~early[:, None]
    columns["holds"] = holds.all(axis=1)
    columns["ticks"] = np.full(lines, 6250)
    columns["held_ticks"] = rng.integers(0, 20, lines)
    for i, name in enumerate(MEASURES):
        columns[f"measure.{name}"] = pa.array(measured[:, i], mask=early)
        if name in JUDGED:
            columns[f"holds.{name}"] = pa.array(holds[:, i], mask=early)
    return pa.table(columns)


def write(rows: int, path: Path) -> None:
    rng = np.random.default_rng(1)
    whole = {"run", "point", "seed", "ticks", "held_ticks"}
    schema = group(0, 1, rng).schema
    schema = pa.schema([field.with_nullable(field.name not in whole) for field in schema])
    schema = schema.with_metadata({"wbqp.campaign": description(rows)})
    with pq.ParquetWriter(path, schema, compression="zstd") as writer:
        for first in range(0, rows, GROUP):
            lines = group(first, min(GROUP, rows - first), rng)
            writer.write_table(lines.cast(schema), row_group_size=GROUP)


def main(program: str, rows: int, folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    table = folder / "large.parquet"
    # Elsewhere: what this process has in memory counts as that of who is started from it.
    writer = multiprocessing.get_context("spawn").Process(target=write, args=(rows, table))
    writer.start()
    writer.join()
    assert writer.exitcode == 0
    report = subprocess.Popen([program, "campaign", "report", table, "--out", folder / "large.html"])
    _, status, usage = os.wait4(report.pid, 0)
    assert status == 0, status
    peak = 1024 * usage.ru_maxrss
    print(f"{rows} rows, {table.stat().st_size / 1e6:.0f} MB: the report took {peak / 1e6:.0f} MB at most")
    assert peak < 80e6 + 40 * rows, peak


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]), Path(sys.argv[3]))
