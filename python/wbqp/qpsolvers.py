"""The quadratic program's solver in the form of the package ``qpsolvers``.

``wbqp.qpsolvers.solve_qp(P, q, G, h, A, b, lb, ub)`` has the arguments of ``qpsolvers.solve_qp``. After
``wbqp.qpsolvers.register()``, ``qpsolvers.solve_qp(..., solver="wbqp")`` finds it too.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from . import _wbqp

Array = Any


def _dense(matrix: Array) -> np.ndarray:
    return np.asarray(matrix.toarray() if hasattr(matrix, "toarray") else matrix, dtype=float)


def _solve(P: Array, q: Array, G: Array, h: Array, A: Array, b: Array, lb: Array, ub: Array) -> _wbqp.QpSolution:
    n = np.shape(q)[0]
    rows, lower, upper = [np.zeros((0, n))], [np.zeros(0)], [np.zeros(0)]
    if G is not None:
        limit = np.asarray(h, dtype=float)
        rows.append(np.atleast_2d(_dense(G)))
        lower.append(np.full(limit.shape, -np.inf))
        upper.append(limit)
    if A is not None:
        value = np.atleast_1d(np.asarray(b, dtype=float))
        rows.append(np.atleast_2d(_dense(A)))
        lower.append(value)
        upper.append(value)
    limits = np.concatenate(lower), np.concatenate(upper)
    return _wbqp.solve_qp(_dense(P), np.asarray(q, dtype=float), np.vstack(rows), *limits, lb, ub)


def solve_qp(
    P: Array,
    q: Array,
    G: Array = None,
    h: Array = None,
    A: Array = None,
    b: Array = None,
    lb: Array = None,
    ub: Array = None,
    solver: str | None = "wbqp",
    initvals: Array = None,
    verbose: bool = False,
    **_: Any,
) -> np.ndarray | None:
    """Solves ``min ½ xᵀ P x + qᵀ x`` subject to ``G x ≤ h``, ``A x = b``, ``lb ≤ x ≤ ub``.

    Parameters
    ----------
    P : array (n, n)
        Symmetric, positive semidefinite; dense, or anything with ``toarray()``.
    q : array (n,)
    G, h, A, b, lb, ub : arrays, optional
    solver, initvals, verbose
        As of ``qpsolvers.solve_qp``; only ``"wbqp"`` is known, the others have no effect.

    Returns
    -------
    array (n,) or None
        The optimum, or None if there is none.
    """
    if solver not in (None, "wbqp"):
        raise ValueError(f"solver {solver!r}: here is only 'wbqp'; qpsolvers.solve_qp knows others")
    solution = _solve(P, q, G, h, A, b, lb, ub)
    return np.array(solution.x) if solution.is_optimal else None


def register() -> None:
    """Makes ``solver="wbqp"`` known to the package ``qpsolvers``."""
    import qpsolvers
    from qpsolvers import Solution, solvers

    def solve_problem(problem: Any, initvals: Any = None, verbose: bool = False, **_: Any) -> Any:
        solution = _solve(*problem.unpack())
        found = Solution(problem)
        found.found = solution.is_optimal
        if not solution.is_optimal:
            return found
        inequalities = 0 if problem.G is None else np.atleast_2d(problem.G).shape[0]
        multipliers = np.array(solution.y)
        found.x = np.array(solution.x)
        found.obj = solution.objective
        found.z, found.y = multipliers[:inequalities], multipliers[inequalities:]
        found.z_box = np.array(solution.z)
        return found

    solvers.solve_function["wbqp"] = solve_problem
    for names in (solvers.available_solvers, solvers.dense_solvers, qpsolvers.available_solvers):
        if "wbqp" not in names:
            names.append("wbqp")
