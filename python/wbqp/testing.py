"""The author's kit: does a plug-in do what its documentation says, on any robot?"""

from __future__ import annotations

from typing import Any

from . import _wbqp


def check(plugin: Any, *, semantics: str | None = None, states: int = 5, seed: int = 1) -> None:
    """Runs the kit on a task or constraint: its form, layout, finite rows, and finite differences of its error.

    Parameters
    ----------
    plugin : object
        Of a class that `wbqp.task` or `wbqp.constraint` has registered, or of `wbqp.tasks` and `wbqp.constraints`. It
        may name what the kit's robots have: the joints ``shoulder``, ``elbow`` and ``wrist``, the frames ``base``,
        ``upper``, ``fore``, ``hand`` and ``tool``, the contacts ``point``, ``normal``, ``full`` and ``normal_tilt``.
    semantics : str, optional
        What the rows mean, where the assumption is wrong: ``position``, ``velocity``, ``motion``, ``barrier``,
        ``affine`` or ``other``.
    states : int
        Random states per robot.
    seed : int

    Raises
    ------
    AssertionError
        With everything that fails, and the first traceback.
    """
    kind = getattr(plugin, "_wbqp_kind", None)
    if kind is None:
        kind = {"wbqp.tasks": "task", "wbqp.constraints": "constraint"}.get(type(plugin).__module__)
    if kind not in ("task", "constraint"):
        raise TypeError(f"{type(plugin).__name__} is no task and no constraint")
    failed = _wbqp._check(kind, _wbqp._to_toml(plugin._wbqp_table()), semantics, states, seed)
    if failed is not None:
        raise AssertionError(failed)
