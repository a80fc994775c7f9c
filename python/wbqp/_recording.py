"""A run as named arrays: of a simulation, or of a log in a file."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _wbqp

if TYPE_CHECKING:
    import pandas
    import polars


class Topic(Mapping[str, np.ndarray]):
    """The messages of one topic over time.

    ``topic.t`` has the times, s, shape (n,); ``topic["measured/z"]`` a number over time, shape (n,), NaN in messages
    that do not have it; ``topic["level"]`` a text over time, an array of objects, ``str`` or None in messages that do
    not have it; ``topic["measured"]`` all numbers below that name, side by side, shape (n, k),
    ``topic.columns("measured")`` what each of them is.
    """

    def __init__(self, name: str, series: Mapping[str, Any]) -> None:
        self.name = name
        arrays = {field: _array(values) for field, values in series.items()}
        self.t: np.ndarray = arrays.pop("t", np.zeros(0))
        self._series: dict[str, np.ndarray] = arrays

    def columns(self, prefix: str = "") -> list[str]:
        """Names of the numbers below a name."""
        start = f"{prefix}/" if prefix else ""
        fields = self._series.items()
        return [field[len(start) :] for field, values in fields if field.startswith(start) and values.dtype != object]

    def __getitem__(self, field: str) -> np.ndarray:
        found = self._series.get(field)
        if found is not None:
            return found
        below = self.columns(field)
        if not below:
            raise KeyError(f"{self.name} has no {field!r}; it has {', '.join(self._series)}")
        return np.column_stack([self._series[f"{field}/{column}"] for column in below])

    def __iter__(self) -> Iterator[str]:
        return iter(self._series)

    def __len__(self) -> int:
        return len(self._series)

    def to_pandas(self) -> pandas.DataFrame:
        """A table with a row for each message, by time."""
        import pandas

        return pandas.DataFrame(dict(self._series), index=pandas.Index(self.t, name="t"))

    def to_polars(self) -> polars.DataFrame:
        """A table with a row for each message; its first column is the time."""
        import polars

        texts = {field: values.tolist() for field, values in self._series.items() if values.dtype == object}
        return polars.DataFrame({"t": self.t, **self._series, **texts})

    def __repr__(self) -> str:
        return f"<wbqp.Topic {self.name}: {len(self.t)} messages, {len(self._series)} fields>"


def _array(values: Any) -> np.ndarray:
    """Numbers as they are; texts in an array of their own kind."""
    return values if isinstance(values, np.ndarray) else np.array(values, dtype=object)


class Recording(Mapping[str, Topic]):
    """A run: ``run["/contact/tip"]["measured/z"]`` is a number over time.

    Attributes
    ----------
    summary : dict
        Of a simulation: ``ticks``, ``held`` (ticks whose command was not their optimum), ``first_held`` (``time`` and
        ``why`` of the first of these, or None), ``diverged`` (s, or None), ``last_level``, ``why``, ``traceback``,
        that of the first exception in a plug-in written in Python, and ``warnings``, of what the loader took and can
        hardly be meant (not of a case in MuJoCo). Empty for a file.
    """

    def __init__(self, log: Any, summary: dict[str, Any] | None = None) -> None:
        self._log = log
        self._topics: dict[str, Topic] = {}
        self._names: list[str] = log.topics()
        self.summary = summary or {}

    @property
    def marks(self) -> dict[str, float]:
        """Named instants, s."""
        return dict(self._log.marks())

    @property
    def configuration(self) -> dict[str, str]:
        """The TOML files that the run was made from, by name."""
        return dict(self._log.configuration())

    def unit(self, topic: str, field: str) -> str | None:
        """The unit of a number."""
        unit: str | None = self._log.unit(topic, field.split("/"))
        return unit

    def __getitem__(self, topic: str) -> Topic:
        if topic not in self._topics:
            self._topics[topic] = Topic(topic, self._log.topic(topic))
        return self._topics[topic]

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)

    def __repr__(self) -> str:
        return f"<wbqp.Recording of {', '.join(self._names)}>"


def read_log(file: str | os.PathLike[str]) -> Recording:
    """Reads the MCAP file of a run.

    Parameters
    ----------
    file : path
        As `simulate`, ``wbqp run`` and the replication of the paper write it.
    """
    return Recording(_wbqp._read_log(os.fspath(file)))


def rows(experiment: str, runs: Mapping[str, Recording]) -> list[dict[str, Any]]:
    """The rows of an experiment, measured from the runs of its cases as the replication of the paper does.

    Parameters
    ----------
    experiment : str
        One of `experiment_cases()`.
    runs : dict
        A recording for each case that `experiment_cases()` names.

    Returns
    -------
    list of dict
        With ``id``, ``quantity``, ``unit``, ``paper``, ``measured``, ``tolerance``, ``pass``, ``promised`` and
        ``reason``.
    """
    found: list[dict[str, Any]] = _wbqp._rows(experiment, {case: run._log for case, run in runs.items()})
    return found


def experiment_cases() -> dict[str, list[str]]:
    """Names of the experiments with rows, each with the cases that these need."""
    found: dict[str, list[str]] = _wbqp._experiments()
    return found
