"""The quadratic program's solver alone, and as a solver of qpsolvers."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import wbqp
import wbqp.qpsolvers


def problem(seed: int, n: int = 8, m: int = 5) -> tuple[np.ndarray, ...]:
    random = np.random.default_rng(seed)
    root = random.normal(size=(n, n))
    A = random.normal(size=(m, n))
    inside = A @ random.normal(size=n)
    return root @ root.T, random.normal(size=n), A, inside - random.uniform(0, 1, m), inside + random.uniform(0, 1, m)


@pytest.mark.parametrize("seed", range(20))
def test_the_optimum_satisfies_its_conditions(seed: int) -> None:
    H, g, A, lower, upper = problem(seed)
    solution = wbqp.solve_qp(H, g, A, lower, upper, -2 * np.ones(8), np.full(8, np.inf))
    if solution.status == "infeasible":
        y, z = solution.y, solution.z
        np.testing.assert_allclose(A.T @ y + z, 0, atol=1e-8)
        return
    assert solution.is_optimal and max(solution.certificate) < 1e-8
    np.testing.assert_allclose(H @ solution.x + g + A.T @ solution.y + solution.z, 0, atol=1e-8)
    assert (A @ solution.x >= lower - 1e-9).all() and (A @ solution.x <= upper + 1e-9).all()
    again = wbqp.solve_qp(H, g, A, lower, upper, -2 * np.ones(8), warm_start=solution)
    assert again.iterations <= solution.iterations
    np.testing.assert_allclose(again.x, solution.x, atol=1e-9)


def test_outcomes_are_statuses() -> None:
    one = np.ones(1)
    infeasible = wbqp.solve_qp(np.eye(1), one, [[1.0]], [2.0], [3.0], ub=[1.0])
    assert infeasible.status == "infeasible"
    assert infeasible.y[0] * 2.0 + infeasible.z[0] * 1.0 < 0 and infeasible.y[0] + infeasible.z[0] == 0
    unbounded = wbqp.solve_qp(np.zeros((1, 1)), one)
    assert unbounded.status == "unbounded" and unbounded.x[0] < 0
    invalid = wbqp.solve_qp([[np.nan]], one)
    assert invalid.status == "invalid" and invalid.defect == "H[0, 0] is not finite"


def test_wrong_shapes_are_refused() -> None:
    with pytest.raises(ValueError, match=r"H: has the shape \(2, 3\), must have \(2, 2\)"):
        wbqp.solve_qp(np.zeros((2, 3)), np.zeros(2))
    with pytest.raises(ValueError, match="lower: has 1 numbers, must have 2"):
        wbqp.solve_qp(np.eye(1), np.zeros(1), np.zeros((2, 1)), lower=[0.0])
    with pytest.raises(ValueError, match="g: must have one dimension"):
        wbqp.solve_qp(np.eye(1), np.zeros((1, 1)))
    with pytest.raises((TypeError, ValueError), match="g: "):
        wbqp.solve_qp(np.eye(1), ["many"])


@pytest.mark.parametrize(
    "layout",
    [
        np.array,
        list,
        lambda x: np.array(x, dtype=int),
        lambda x: np.array(x, dtype="f4"),
        lambda x: np.array(x, dtype=">f8"),
        lambda x: np.repeat(np.array(x), 2)[::2],
        lambda x: np.array(x[::-1])[::-1],
    ],
    ids=["as they are read", "list", "int", "single", "other bytes", "every second", "backwards"],
)
def test_vectors_are_read_however_they_lie(layout: Callable[[list[float]], Any]) -> None:
    solution = wbqp.solve_qp(np.eye(3), layout([-1.0, -2.0, -3.0]))
    np.testing.assert_allclose(solution.x, [1.0, 2.0, 3.0], atol=1e-12)


def test_arguments_of_qpsolvers() -> None:
    P, q = np.array([[2.0, 0.0], [0.0, 2.0]]), np.array([-2.0, -6.0])
    G, h, A, b = np.array([[1.0, 0.0]]), np.array([0.5]), np.array([1.0, 1.0]), np.array([2.0])
    x = wbqp.qpsolvers.solve_qp(P, q, G, h, A, b, lb=np.zeros(2), solver="wbqp")
    np.testing.assert_allclose(x, [0.0, 2.0], atol=1e-9)
    assert wbqp.qpsolvers.solve_qp(P, q, lb=np.ones(2), ub=np.zeros(2)) is None
    with pytest.raises(ValueError, match="only 'wbqp'"):
        wbqp.qpsolvers.solve_qp(P, q, solver="osqp")


def test_qpsolvers_finds_it() -> None:
    qpsolvers = pytest.importorskip("qpsolvers")
    wbqp.qpsolvers.register()
    H, g, A, lower, upper = problem(3)
    x = qpsolvers.solve_qp(H, g, np.vstack([A, -A]), np.concatenate([upper, -lower]), solver="wbqp")
    np.testing.assert_allclose(x, wbqp.solve_qp(H, g, A, lower, upper).x, atol=1e-8)
    solution = qpsolvers.solve_problem(qpsolvers.Problem(H, g, A, upper), solver="wbqp")
    assert solution.is_optimal(1e-6)
