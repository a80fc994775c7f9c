"""Campaigns: many closed loops from a plan, on this machine or on a Ray cluster, with the same results.

A plan says what is varied, which points of that space are run, and what is measured of each run: see docs/campaigns.md.
Tables are Arrow tables (``pip install './python[campaign]'``); Ray is the user's choice
(``pip install './python[ray]'``).
"""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from . import _wbqp

if TYPE_CHECKING:
    import numpy as np
    import pyarrow as pa


def describe(plan: str | os.PathLike[str]) -> dict[str, Any]:
    """What a plan has: ``name``, ``runs``, ``points``, ``variants``, ``factors`` and ``measures``.

    Runs every variant of the scenario as it is once, which tells what can be measured.
    """
    return dict(_wbqp._campaign_plan(Path(plan)))


def run(
    plan: str | os.PathLike[str],
    *,
    address: str | None = None,
    shards: int | None = None,
    limit: int | None = None,
    out: str | os.PathLike[str] | None = None,
    jobs: int = 0,
    retries: int = 3,
) -> pa.Table:
    """Runs a plan and returns its table, sorted by run.

    Parameters
    ----------
    plan
        The plan's file.
    address
        Of a Ray cluster, ``"auto"`` or ``"local"`` for one that is started on this machine; without it, this process
        does everything on its threads. Every node must see the plan, and what it names, at the same paths.
    shards
        Parts of the campaign. With Ray, a task each; default: four per core of the cluster. What comes out does not
        depend on it.
    limit
        Only the first runs of the plan.
    out
        Folder for the parts' tables and the table of all, ``campaign.parquet``. A part that is there is not run again.
        Default: a folder that is taken away again.
    jobs
        Threads of a part; 0: all cores, with Ray one.
    retries
        How often Ray runs a part again whose worker was lost.
    """
    import pyarrow.parquet as pq

    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(out if out is not None else temporary).absolute()
        folder.mkdir(parents=True, exist_ok=True)
        file = Path(plan).absolute()
        if address is None:
            count = shards or 1
            for index in range(1, count + 1):
                _wbqp._campaign_shard(file, index, count, folder, limit, jobs)
        else:
            _run_on_ray(file, address, shards, limit, folder, jobs, retries)
        merged = folder / "campaign.parquet"
        _wbqp._campaign_merge(folder, merged)
        return pq.read_table(merged)


def connected(address: str) -> tuple[Any, int]:
    """Ray, with a cluster, and the cores of that."""
    import ray

    if not ray.is_initialized():
        ray.init(address=None if address == "local" else address, log_to_driver=False)
    return ray, int(ray.cluster_resources().get("CPU", 1))


def _run_on_ray(
    plan: Path, address: str, shards: int | None, limit: int | None, folder: Path, jobs: int, retries: int
) -> None:
    ray, cores = connected(address)
    count = shards or 4 * cores

    # A lost worker or node is no fault of the part: Ray runs it again, and where the folder is shared it goes on.
    @ray.remote(max_retries=retries, num_cpus=max(jobs, 1))
    def part(index: int) -> tuple[str, bytes]:
        return _part(plan, index, count, folder, limit, max(jobs, 1))

    waiting = [part.remote(index) for index in range(1, count + 1)]
    while waiting:
        done, waiting = ray.wait(waiting)
        for name, table in ray.get(done):
            target = folder / name
            if not target.exists():
                target.write_bytes(table)


def _part(plan: Path, index: int, count: int, folder: Path, limit: int | None, jobs: int) -> tuple[str, bytes]:
    """Runs a part where this is called; the name and the contents of its table."""
    if folder.is_dir():
        table = _wbqp._campaign_shard(plan, index, count, folder, limit, jobs)
        return table.name, table.read_bytes()
    # A node that does not see the folder.
    with tempfile.TemporaryDirectory() as own:
        table = _wbqp._campaign_shard(plan, index, count, Path(own), limit, jobs)
        return table.name, table.read_bytes()


def outcomes(
    plan: str | os.PathLike[str],
    *,
    set: Mapping[str, Any] | None = None,  # noqa: A002
    change: Mapping[str, Any] | None = None,
    limit: int | None = None,
    jobs: int = 0,
) -> dict[str, Any]:
    """Runs a plan with other values in all its variants, and returns what became of it, without a file.

    ``set`` has values of the controller and ``change`` of the scenario, as :func:`wbqp.simulate` takes them.

    Returns
    -------
    dict
        ``variant``, ``point``, ``status``, ``holds`` and, by name, ``factors``, ``measures``, ``verdicts`` and, of
        measures with ``gaps``, ``covered``, the share of the window that is there: arrays in the order of the runs.
        ``holds`` and ``verdicts`` are 1, 0 or NaN; ``holds`` is NaN where a run was refused and never simulated: the
        share that holds is ``np.nanmean(found["holds"])``.

    A factor with an end of whose range the scenario is refused is warned of (``UserWarning``).
    """
    given = (None if values is None else dict(values) for values in (set, change))
    return dict(_wbqp._campaign_outcomes(Path(plan), *given, limit, jobs))


def first_order_indices(table: pa.Table, measure: str, variant: str | None = None) -> dict[str, tuple[float, float]]:
    """Sobol's first-order and total indices of a measure, by factor, from a plan with Saltelli's design (wants SALib).

    A run without a value has the mean of the others. The default variant is the first.
    """
    import numpy as np
    from SALib.analyze import sobol

    description = json.loads(table.schema.metadata[b"wbqp.campaign"])
    factors = [factor["name"] for factor in description["factors"]]
    chosen = variant or description["variants"][0]
    values: np.ndarray = np.array(
        [
            np.nan if value is None else value
            for value, name in zip(table[f"measure.{measure}"].to_pylist(), table["variant"].to_pylist())
            if name == chosen
        ]
    )
    group = len(factors) + 2
    if len(values) < group or len(values) % group:
        raise ValueError(
            f"{len(values)} runs are no whole groups of {group}: the design must be Saltelli's, with one repetition, "
            "and its runs complete"
        )
    values = np.where(np.isnan(values), np.nanmean(values), values)
    problem = {"num_vars": len(factors), "names": factors, "bounds": [[0, 1]] * len(factors)}
    found = sobol.analyze(problem, values, calc_second_order=False, print_to_console=False, seed=0)
    return {name: (float(found["S1"][i]), float(found["ST"][i])) for i, name in enumerate(factors)}


def write_indices(
    table: pa.Table,
    file: str | os.PathLike[str],
    measures: Iterable[str] | None = None,
    variant: str | None = None,
) -> Path:
    """Writes the indices of :func:`first_order_indices` into a JSON file, for ``wbqp campaign report --indices``.

    Without ``measures``, those of all measures. A measure that is the same in all runs, or has no value, has no indices
    and is left out.

    Returns
    -------
    Path
        The file.
    """
    import pyarrow.compute as pc

    description = json.loads(table.schema.metadata[b"wbqp.campaign"])
    chosen = variant or description["variants"][0]
    runs = table.filter(pc.equal(table["variant"], chosen))
    names = [measure["name"] for measure in description["measures"]] if measures is None else list(measures)
    varied = [name for name in names if pc.count_distinct(runs[f"measure.{name}"]).as_py() > 1]
    indices = {name: first_order_indices(runs, name, chosen) for name in varied}
    path = Path(file)
    path.write_text(json.dumps(indices, indent=1, allow_nan=False), encoding="utf-8")
    return path
