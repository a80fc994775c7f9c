"""Made by generate_stubs.py from the registry's JSON Schema: do not edit."""

from collections.abc import Sequence
from typing import Any, Literal

from wbqp._plugins import Plugin

class ActiveSet(Plugin):
    """A dense dual active-set method, warm-started from the tick before; allocates nothing.

    `min ½xᵀHx + gᵀx` subject to `l ≤ A x ≤ u`.

    Parameters
    ----------
    budget : float, optional
        Time that a solve may take before it ends without a solution, s; unlimited if absent. Needs a clock: without
        the caller's stopwatch it has no effect.
    max_iterations : int, optional
        Cap on the number of changes of the active set, of all attempts together; if absent, twenty times the number of
        variables and rows of the largest problem, and at least 2000.
    tolerance : float, default 1e-12
        Violation of a row or bound that is accepted, relative to the numbers it is computed from. [1]
    """
    def __init__(
        self,
        *,
        budget: float | None = ...,
        max_iterations: int | None = ...,
        tolerance: float | None = ...,
    ) -> None: ...

class Clarabel(Plugin):
    """The interior-point solver Clarabel, made exact by a polish; allocates in every solve.

    `min ½xᵀHx + gᵀx` subject to `l ≤ A x ≤ u`.

    Parameters
    ----------
    max_iterations : int, default 200
        Iteration cap.
    tolerance : float, default 1e-12
        Tolerance on the duality gap, feasibility and infeasibility certificates. [1]
    """
    def __init__(
        self,
        *,
        max_iterations: int | None = ...,
        tolerance: float | None = ...,
    ) -> None: ...

__all__ = [
    "ActiveSet",
    "Clarabel",
]
