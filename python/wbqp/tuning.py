"""Gains that find themselves: :func:`tune` looks for values of a controller with which the runs of a plan go best.

By samplers, which ask nothing of the objective, and by steps against a gradient from sensitivities (:class:`Descent`).

Wants Optuna (``pip install './python[tune]'``); with ``address``, trials run on a Ray cluster
(``pip install './python[ray]'``).
"""

from __future__ import annotations

import html
import logging
import math
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from . import campaign

if TYPE_CHECKING:
    import optuna


logger = logging.getLogger(__name__)


@dataclass(frozen=True)
class Parameter:
    """A value of the controller (``set.…``) or of the scenario (``change.…``) that is looked for.

    ``log``: by orders of magnitude. ``start`` is tried first, with the others' starts.
    """

    path: str
    low: float
    high: float
    log: bool = False
    start: float | None = None

    def __post_init__(self) -> None:
        if not self.low < self.high:
            raise ValueError(f"{self.path}: the range from {self.low} to {self.high} is empty")
        if self.log and self.low <= 0.0:
            raise ValueError(f"{self.path}: a logarithmic range begins above 0")
        if self.start is not None and not self.low <= self.start <= self.high:
            raise ValueError(f"{self.path}: the start, {self.start}, is not between {self.low} and {self.high}")
        if self.path.split(".")[0] not in ("set", "change"):
            raise ValueError(f"{self.path}: must begin with `set.` or `change.`, as in a case of a scenario")


@dataclass(frozen=True)
class Objective:
    """What is to be small: a measure of the plan, over all its runs.

    Parameters
    ----------
    measure
        Name of the measure.
    over
        ``"mean"``, ``"worst"``, or a quantile between 0 and 1. Runs without a value count as infinite, for a mean as a
        failure of its own: see ``share``.
    share
        Share of the runs that must hold (all measures that count are within what is accepted). What has less is worse
        than anything that has it, the more the more is missing. A run that is refused counts as one that does not hold:
        values with which runs are not simulated would look better by that.
    """

    measure: str
    over: Literal["mean", "worst"] | float = "mean"
    share: float = 1.0

    def __post_init__(self) -> None:
        if not (self.over in ("mean", "worst") or (isinstance(self.over, float | int) and 0.0 <= self.over <= 1.0)):
            raise ValueError(f"over is 'mean', 'worst', or a quantile between 0 and 1, not {self.over!r}")
        if not 0.0 <= self.share <= 1.0:
            raise ValueError(f"the share of the runs that must hold is between 0 and 1, not {self.share}")

    def value(self, found: Mapping[str, Any]) -> float:
        """Of the outcomes of some runs."""
        values = found["measures"].get(self.measure)
        if values is None:
            known = ", ".join(map(repr, found["measures"]))
            raise KeyError(f"the plan has no measure {self.measure!r}; it has {known}")
        missing = self.share - float(np.mean(np.nan_to_num(found["holds"])))
        if missing > 1e-12:
            return FAILED * (1.0 + missing)
        there = np.where(np.isnan(values), np.inf, values)
        if self.over == "mean":
            return float(np.mean(there[np.isfinite(there)])) if np.isfinite(there).any() else 2 * FAILED
        value = float(np.max(there) if self.over == "worst" else np.quantile(there, float(self.over)))
        return value if math.isfinite(value) else 2 * FAILED


@dataclass(frozen=True)
class Descent:
    """Steps against the gradient, from the best trial on: for a measure that grows with a task's error.

    The gradient is that of the mean square of the error in the plan's scenario as it is, from one run and the
    sensitivities of its ticks: a linearisation without actuators' lags, a wall that gives way, and what integrals
    remember, and only for controllers without an observer. So it is a direction, and a step is taken only if the
    objective itself is smaller there.

    ``rows``: of the error; all if there are none. ``start`` and ``end``: expressions of the scenario's marks, as in a
    measure of a plan. ``variant`` and ``case``: by position. ``reach``: by how much a value changes at most in a step,
    as a share of itself.
    """

    task: str
    steps: int = 5
    rows: tuple[int, ...] = ()
    start: str = ""
    end: str = ""
    variant: int = 0
    case: int = 0
    reach: float = 0.3

    def slopes(self, plan: str | os.PathLike[str], values: Mapping[str, float]) -> dict[str, float]:
        """Derivatives of the logarithm of the mean square by the logarithms of values; 0 for what has none.

        ``values`` are by path, as those of :class:`Parameter`.
        """
        from . import _wbqp

        found = _wbqp._campaign_gradient(
            Path(plan),
            self.task,
            list(self.rows),
            self.variant,
            self.case,
            self.start,
            self.end,
            _nested(values, "set"),
            _nested(values, "change"),
        )
        scale = found["mean_square"] or 1.0

        def slope(path: str, value: float) -> float:
            root, *owner = path.split(".")
            if root != "set" or len(owner) < 3 or owner[0] not in ("task", "constraint"):
                return 0.0
            name = ".".join(owner[1:])
            # One number for all rows is as many weights, or gains, as there are rows.
            own = (s for key, s in found["slopes"].items() if key == name or key.startswith(f"{name}["))
            return sum(own) * value / scale

        return {path: slope(path, value) for path, value in values.items()}


#: What misses its share is above this, what has it below.
FAILED = 1e9


@dataclass
class Tuned:
    """What was found."""

    plan: Path
    objective: Objective
    #: Values by path.
    best: dict[str, float]
    #: Outcomes as the plan is, and with the best values.
    before: dict[str, Any]
    after: dict[str, Any]
    #: Objective of every trial, in their order, steps of a descent last; above :data:`FAILED` where too few runs hold.
    history: list[float] = field(default_factory=list)
    #: What was looked for.
    parameters: list[Parameter] = field(default_factory=list)

    @property
    def patch(self) -> str:
        """The values as TOML: lines for a case of a scenario, or for a variant of a plan."""
        return "".join(f"{path} = {value!r}\n" for path, value in self.best.items())

    def write(self, folder: str | os.PathLike[str]) -> Path:
        """Writes ``patch.toml`` and a page, ``tuned.html``, that compares before and after; the page's path."""
        folder = Path(folder)
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "patch.toml").write_text(self.patch, encoding="utf-8")
        page = folder / "tuned.html"
        page.write_text(_page(self), encoding="utf-8")
        return page


def _nested(values: Mapping[str, float], root: str) -> dict[str, Any] | None:
    """The values below ``root`` as nested tables."""
    table: dict[str, Any] = {}
    for path, value in values.items():
        first, *keys, last = path.split(".")
        if first != root:
            continue
        inner = table
        for key in keys:
            inner = inner.setdefault(key, {})
        inner[last] = value
    return table or None


def _outcomes(plan: Path, values: Mapping[str, float], limit: int | None, jobs: int) -> dict[str, Any]:
    return campaign.outcomes(
        plan, set=_nested(values, "set"), change=_nested(values, "change"), limit=limit, jobs=jobs
    )


def _value(plan: Path, values: Mapping[str, float], objective: Objective, limit: int | None, jobs: int) -> float:
    from ._errors import ConfigError

    try:
        return objective.value(_outcomes(plan, values, limit, jobs))
    except ConfigError:
        # Values that the controller refuses, or with which the scenario as it is does not reach its end.
        return 3 * FAILED


def _sampler(name: str, seed: int) -> optuna.samplers.BaseSampler:
    import optuna

    if name == "tpe":
        return optuna.samplers.TPESampler(seed=seed, multivariate=True)
    if name == "cmaes":
        return optuna.samplers.CmaEsSampler(seed=seed)
    raise ValueError(f"there is no sampler {name!r}; there are 'tpe' and 'cmaes', or give one of Optuna's")


def tune(
    plan: str | os.PathLike[str],
    parameters: list[Parameter],
    objective: Objective,
    *,
    trials: int = 50,
    sampler: str | optuna.samplers.BaseSampler = "tpe",
    seed: int = 0,
    limit: int | None = None,
    jobs: int = 0,
    address: str | None = None,
    descent: Descent | None = None,
) -> Tuned:
    """Looks for the values with which the objective is smallest over the runs of a plan.

    Parameters
    ----------
    plan
        The plan's file. Its points are the plants over which the objective is taken; the values are those of all its
        variants.
    parameters
        What is looked for, and where.
    trials
        How many sets of values are tried.
    sampler
        ``"tpe"``, ``"cmaes"``, or one of Optuna's.
    limit
        Only the first runs of the plan, in the trials; what is compared in the end is the whole plan.
    jobs
        Threads of a trial; 0: all cores, on Ray one.
    address
        Of a Ray cluster, on which trials run side by side, as many as there are cores.
    descent
        Steps against the gradient after the trials, where the objective is smooth.

    Each trial is told to the logger ``wbqp.tuning``, at level INFO.
    """
    import optuna

    if not parameters:
        raise ValueError("there is nothing to look for: no parameter")
    if trials < 1:
        raise ValueError(f"at least one trial is wanted, not {trials}")
    paths = [parameter.path for parameter in parameters]
    if len(set(paths)) < len(paths):
        raise ValueError("a parameter is there twice")
    file = Path(plan).absolute()
    if descent is not None:
        # What it cannot be asked for is said before anything is tried.
        descent.slopes(file, {p.path: p.start for p in parameters if p.start is not None})
    optuna.logging.set_verbosity(optuna.logging.WARNING)
    chosen = _sampler(sampler, seed) if isinstance(sampler, str) else sampler
    study = optuna.create_study(sampler=chosen, direction="minimize")
    starts = {p.path: p.start for p in parameters if p.start is not None}
    if starts:
        study.enqueue_trial(starts)

    def ask() -> tuple[optuna.trial.Trial, dict[str, float]]:
        trial = study.ask()
        return trial, {p.path: trial.suggest_float(p.path, p.low, p.high, log=p.log) for p in parameters}

    if address is None:
        for number in range(trials):
            trial, values = ask()
            study.tell(trial, _value(file, values, objective, limit, jobs))
            logger.info("trial %d of %d: %.5g, best %.5g", number + 1, trials, study.trials[-1].value, study.best_value)
    else:
        _on_ray(study, ask, (file, objective, limit, max(jobs, 1)), trials, address)
    best = {path: float(value) for path, value in study.best_params.items()}
    history = [trial.value for trial in study.trials if trial.value is not None]
    if descent is not None:

        def judged(values: Mapping[str, float]) -> float:
            history.append(_value(file, values, objective, limit, jobs))
            return history[-1]

        best = _descended(file, parameters, descent, best, float(study.best_value), judged)
    return Tuned(
        plan=file,
        objective=objective,
        best=best,
        before=_outcomes(file, {}, None, jobs),
        after=_outcomes(file, best, None, jobs),
        history=history,
        parameters=list(parameters),
    )


def _descended(
    plan: Path,
    parameters: list[Parameter],
    descent: Descent,
    values: dict[str, float],
    least: float,
    judged: Callable[[Mapping[str, float]], float],
) -> dict[str, float]:
    """The values after some steps against the gradient, each as far as the objective falls."""
    for _ in range(descent.steps):
        slopes = descent.slopes(plan, values)
        steepest = max(abs(slope) for slope in slopes.values())
        if not 0.0 < steepest < math.inf:
            break
        for share in (1.0, 0.5, 0.25, 0.125):
            step = math.log1p(descent.reach) * share / steepest
            moved = {p.path: values[p.path] * math.exp(-step * slopes[p.path]) for p in parameters}
            moved = {p.path: float(min(max(moved[p.path], p.low), p.high)) for p in parameters}
            value = judged(moved)
            if value < least:
                values, least = moved, value
                break
        else:
            break
    return values


def _on_ray(study: Any, ask: Any, what: tuple[Path, Objective, int | None, int], trials: int, address: str) -> None:
    ray, all_cores = campaign.connected(address)
    file, objective, limit, jobs = what
    value = ray.remote(max_retries=3, num_cpus=jobs)(_value)
    cores = max(1, all_cores // jobs)
    running: dict[Any, Any] = {}
    asked = 0
    while running or asked < trials:
        while asked < trials and len(running) < cores:
            trial, values = ask()
            running[value.remote(file, values, objective, limit, jobs)] = trial
            asked += 1
        for done in ray.wait(list(running))[0]:
            study.tell(running.pop(done), ray.get(done))


STYLE = """
body { margin: 0 auto; max-width: 60rem; padding: 1.5rem 1.1rem; font: 16px/1.5 system-ui, sans-serif; color: #1d2329; }
table { border-collapse: collapse; font-size: .88rem; font-variant-numeric: tabular-nums; }
th, td { text-align: left; padding: .25rem .7rem; border-bottom: 1px solid #d5dae0; }
td.n { text-align: right; } pre { background: #f5f7f9; padding: .8rem; overflow-x: auto; }
svg { width: 100%; height: auto; } .better { color: #17734a; } .worse { color: #b3261e; }
"""


def _page(tuned: Tuned) -> str:
    def share(found: Mapping[str, Any]) -> str:
        simulated = found["holds"][~np.isnan(found["holds"])]
        refused = len(found["holds"]) - len(simulated)
        of = f" of {len(simulated)} that were simulated ({refused} were refused)" if refused else ""
        return f"{100 * float(np.mean(simulated)):.1f} %{of}" if len(simulated) else "none, as all were refused,"

    def number(value: float) -> str:
        return "–" if not math.isfinite(value) or value >= FAILED else f"{value:.4g}"

    rows = []
    plan = campaign.describe(tuned.plan)
    units = {measure["name"]: measure["unit"] for measure in plan["measures"]}
    for name, before in tuned.before["measures"].items():
        after = tuned.after["measures"][name]
        unit = units.get(name, "")
        cells = [f"<td>{html.escape(f'{name}, {unit}' if unit else name)}</td>"]
        for values in (before, after):
            there = values[np.isfinite(values)]
            quantiles = np.quantile(there, [0.5, 0.95]) if len(there) else [math.nan, math.nan]
            cells += [f'<td class="n">{number(float(q))}</td>' for q in quantiles]
        for found in (tuned.before, tuned.after):
            verdicts = found["verdicts"][name]
            judged = not np.isnan(verdicts).all()
            simulated = np.count_nonzero(~np.isnan(found["holds"]))
            held = f"{100 * float(np.nansum(verdicts)) / simulated:.1f} %" if judged else "–"
            cells.append(f'<td class="n">{held}</td>')
        rows.append(f"<tr>{''.join(cells)}</tr>")
    goal = tuned.objective
    title = html.escape(f"{plan['name']}: before and after")
    over = {"mean": "mean of", "worst": "worst"}.get(str(goal.over)) or f"{100 * float(goal.over):g} % quantile of"
    unit = units.get(goal.measure, "")
    values = []
    for parameter in tuned.parameters:
        found = tuned.best[parameter.path]
        near = 1e-6 * (parameter.high - parameter.low)
        at_bound = found - parameter.low <= near or parameter.high - found <= near
        start = math.nan if parameter.start is None else parameter.start
        cells = [number(x) for x in (parameter.low, parameter.high, start, found)]
        numbers = "".join(f'<td class="n">{cell}</td>' for cell in cells)
        note = "at its bound: a wider range may be better" if at_bound else ""
        values.append(f"<tr><td>{html.escape(parameter.path)}</td>{numbers}<td>{note}</td></tr>")
    return f"""<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
<title>{title}</title><style>{STYLE}</style></head><body>
<h1>{title}</h1>
<p>What was to be small: the {over} <em>{html.escape(goal.measure)}</em>, with {100 * goal.share:g} % of the runs
holding. {len(tuned.history)} trials. Over all {len(tuned.before["holds"])} runs of the plan, before:
{number(goal.value(tuned.before))} {html.escape(unit)}, {share(tuned.before)} hold; after:
{number(goal.value(tuned.after))} {html.escape(unit)}, {share(tuned.after)} hold. A dash: too few hold.</p>
<h2>Values</h2>
<table><thead><tr><th>value</th><th>from</th><th>to</th><th>start</th><th>found</th><th></th></tr></thead>
<tbody>{"".join(values)}</tbody></table>
<p>As lines of a variant or a case:</p><pre>{html.escape(tuned.patch)}</pre>
<h2>Measures</h2>
<table><thead><tr><th></th><th colspan="2">before</th><th colspan="2">after</th><th colspan="2">holds</th></tr>
<tr><th>measure</th><th>median</th><th>95 %</th><th>median</th><th>95 %</th><th>before</th><th>after</th></tr></thead>
<tbody>{"".join(rows)}</tbody></table>
<h2>Trials</h2>{_progress(tuned.history)}</body></html>
"""


def _progress(history: list[float]) -> str:
    """The best so far, trial by trial, of those that have their share."""
    good = [value for value in history if value < FAILED]
    if not good:
        return "<p>No trial had its share of runs that hold.</p>"
    width, height = 600.0, 160.0
    low, high = min(good), max(good)
    span = (high - low) or 1.0

    def place(i: int, value: float) -> tuple[float, float]:
        return 75 + (width - 85) * i / max(len(history) - 1, 1), 10 + (height - 30) * (high - value) / span

    dots = [
        '<circle cx="{:.1f}" cy="{:.1f}" r="2.5" fill="#7fb0cf"/>'.format(*place(i, value))
        for i, value in enumerate(history)
        if value < FAILED
    ]
    best = np.minimum.accumulate(history)
    line = " ".join("{:.1f},{:.1f}".format(*place(i, float(v))) for i, v in enumerate(best) if v < FAILED)
    left_out = len(history) - len(good)
    words = f" {left_out} trials with too few runs that hold are not shown." if left_out else ""
    return (
        f"<p>The objective over the runs of a trial, trial by trial, and the best so far.{words}</p>"
        f'<svg viewBox="0 0 {width} {height}" role="img" aria-label="objective of each trial">'
        f'<text x="68" y="14" text-anchor="end" font-size="10">{high:.3g}</text>'
        f'<text x="68" y="{height - 20}" text-anchor="end" font-size="10">{low:.3g}</text>'
        f'<polyline points="{line}" fill="none" stroke="#0a5a8c" stroke-width="1.5"/>{"".join(dots)}</svg>'
    )
