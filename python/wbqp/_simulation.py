"""Scenarios: those that come with the package, and simulations of them."""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

from . import _wbqp
from ._recording import Recording


def scenarios() -> dict[str, Path]:
    """Names and files of the scenarios that come with the package."""
    folder = Path(__file__).parent / "scenarios"
    files = sorted(folder.glob("*.toml"))
    controllers = [file for file in files if file.name.endswith(".controller.toml")]
    # What scenarios share is no scenario.
    found = [file for file in files if file not in controllers and "[[case]]" in file.read_text(encoding="utf-8")]
    return {file.stem: file for file in found}


def _file(scenario: str | os.PathLike[str]) -> Path:
    path = Path(scenario)
    if path.exists():
        return path
    shipped = scenarios()
    found = shipped.get(path.name.removesuffix(".toml"))
    if found is None or path.parent != Path("."):
        known = ", ".join(shipped)
        raise FileNotFoundError(f"there is no scenario {os.fspath(scenario)!r}; with the package come {known}")
    return found


def cases(scenario: str | os.PathLike[str]) -> dict[str, float]:
    """Names of a scenario's cases, each with the time that it simulates, s."""
    return dict(_wbqp._cases(_file(scenario)))


def _progress(
    show: bool | Callable[[float], None], label: str
) -> tuple[Callable[[float], None] | None, Callable[[], None]]:
    def nothing() -> None:
        pass

    if callable(show):
        return show, nothing
    if not show:
        return None, nothing
    try:
        from tqdm.auto import tqdm
    except ImportError:
        return None, nothing
    bar = tqdm(total=100, desc=label, unit="%", leave=False)

    def tell(fraction: float) -> None:
        bar.update(round(100 * fraction) - bar.n)

    return tell, bar.close


def simulate(
    scenario: str | os.PathLike[str],
    *,
    seed: int = 1,
    case: str | None = None,
    set: dict[str, Any] | None = None,
    change: dict[str, Any] | None = None,
    log: str | os.PathLike[str] | None = None,
    progress: bool | Callable[[float], None] = True,
) -> Recording:
    """Simulates a case of a scenario, without the interpreter's lock; Ctrl-C ends it.

    Parameters
    ----------
    scenario : path or str
        A scenario's file, or the name of one of `scenarios()`.
    seed : int
        Of the sensors' noise: the same seed gives the same numbers.
    case : str, optional
        One of `cases(scenario)`; the first.
    set : dict, optional
        Values of the controller's file: ``{"task": {"tip_force": {"ki": 2.0}}}``.
    change : dict, optional
        Values of the scenario's file: ``{"plant": {"mismatch": {"mass_scale": 1.05}}}``.
    log : path, optional
        An MCAP file to be written.
    progress : bool or callable
        A bar, if tqdm is installed; or what is called with the finished fraction.

    Returns
    -------
    Recording
        Named arrays over time.

    Warns
    -----
    UserWarning
        Of what the loader took and can hardly be meant, as ``wbqp check`` tells it; ``warnings`` in the recording's
        `summary`.

    Raises
    ------
    ConfigError
        If the scenario or its controller is refused.
    KeyboardInterrupt
        If it is interrupted.
    """
    path = _file(scenario)
    if case is None:
        case = next(iter(cases(path)))
    tell, close = _progress(progress, f"{path.stem} {case}")
    try:
        target = None if log is None else os.fspath(log)
        made, summary = _wbqp._simulate(path, case, seed, set, change, target, tell)
    finally:
        close()
    for words in summary["warnings"]:
        warnings.warn(f"{path.stem} {case}: {words}", stacklevel=2)
    return Recording(made, summary)
