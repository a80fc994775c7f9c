#!/usr/bin/env python3
"""The judge itself: right answers pass, and each way of being wrong is called so.

    target/oracles/venv/bin/python tests/oracles/test_qp_judge.py
"""

import unittest

import numpy as np
from qp_judge import Answer, judge, solved
from qp_problem import INF, Problem


def problem(H, g, A=(), row_lower=(), row_upper=(), lower=None, upper=None, **expected):
    n, m = len(g), len(row_lower)
    array = lambda v: np.array(v, dtype=float)  # noqa: E731
    A = np.reshape(array(A), (m, n))
    lower = np.full(n, -INF) if lower is None else array(lower)
    upper = np.full(n, INF) if upper is None else array(upper)
    return Problem(n, m, array(H), array(g), A, array(row_lower), array(row_upper), lower, upper, expected=expected)


def kind(p, status, **answer):
    return judge(p, Answer({"status": status} | answer)).kind


# min 1/2 |x|^2 - x1 - 2 x2, x1 + x2 <= 1, x2 <= 0.75: x = (0.25, 0.75), y = 0.75, z2 = 0.5.
SMALL = problem(np.eye(2), [-1, -2], [1, 1], [-INF], [1], upper=[INF, 0.75])
RIGHT = {"x": [0.25, 0.75], "y": [0.75], "z": [0, 0.5]}


class Optimal(unittest.TestCase):
    def test_right(self):
        self.assertEqual(kind(SMALL, "optimal", **RIGHT), "right")

    def test_wrong_point(self):
        self.assertEqual(kind(SMALL, "optimal", **RIGHT | {"x": [0.2, 0.75]}), "wrong")

    def test_violations_of_a_row_and_a_bound(self):
        self.assertEqual(kind(SMALL, "optimal", **RIGHT | {"x": [0.2501, 0.75]}), "wrong")
        self.assertEqual(kind(SMALL, "optimal", **RIGHT | {"x": [0.2499, 0.7501]}), "wrong")

    def test_wrong_multipliers(self):
        self.assertEqual(kind(SMALL, "optimal", **RIGHT | {"y": [0.7]}), "unproven")
        self.assertEqual(kind(SMALL, "optimal", **RIGHT | {"y": [-0.75]}), "unproven")
        self.assertEqual(kind(SMALL, "optimal", **RIGHT | {"z": [0.1, 0.5]}), "unproven")

    def test_without_multipliers_the_cost_decides(self):
        self.assertEqual(kind(SMALL, "optimal", x=RIGHT["x"]), "unproven")
        self.assertEqual(kind(SMALL, "optimal", x=[0.2, 0.7]), "wrong")

    def test_nan_and_shape(self):
        self.assertEqual(kind(SMALL, "optimal", **RIGHT | {"x": ["nan", 0.75]}), "wrong")
        self.assertEqual(kind(SMALL, "optimal", **RIGHT | {"x": [0.25]}), "wrong")

    def test_scales_of_rows_and_variables(self):
        for exponent in (-20, 20):
            s = 2.0**exponent
            scaled = problem(np.eye(2), [-1, -2], [s, s], [-INF], [s], upper=[INF, 0.75])
            self.assertEqual(kind(scaled, "optimal", **RIGHT | {"y": [0.75 / s]}), "right")
            self.assertEqual(kind(scaled, "optimal", **RIGHT | {"x": [0.25001, 0.75], "y": [0.75 / s]}), "wrong")

    def test_a_large_variable_excuses_nothing(self):
        p = problem([[1e7, 0], [0, 1e-7]], [-1e11, -1.0001e-7], upper=[INF, 1], x=[1e4, 1.0])
        self.assertEqual(kind(p, "optimal", x=[1e4, 1.0001], y=[], z=[0, 0]), "wrong")
        self.assertEqual(kind(p, "optimal", x=[1e4, 0.9], y=[], z=[0, 1e-12]), "wrong")

    def test_small_costs_count(self):
        p = problem(np.zeros((2, 2)), [1e-10, -1e-10], lower=[-1, -1], upper=[1, 1])
        self.assertEqual(kind(p, "optimal", x=[-1, 1], y=[], z=[-1e-10, 1e-10]), "right")
        self.assertEqual(kind(p, "optimal", x=[-0.01, 0.01], y=[], z=[-1e-10, 1e-10]), "wrong")
        self.assertEqual(kind(p, "optimal", x=[-0.01, 0.01], y=[], z=[0, 0]), "wrong")

    def test_rows_of_rounding(self):
        p = problem(np.eye(2), [-1, -2], [0, 0], [-INF], [-7e-18])
        self.assertEqual(kind(p, "optimal", x=[1, 2], y=[0], z=[0, 0]), "right")
        self.assertEqual(kind(p, "infeasible"), "wrong")

    def test_a_huge_stationary_point_of_an_unbounded_cost(self):
        p = problem([[5, 5], [5, 5]], [5, 0])
        self.assertEqual(kind(p, "optimal", x=[-2e9, 2e9], y=[], z=[0, 0]), "wrong")
        self.assertEqual(kind(p, "optimal", x=[-0.5, 0], y=[], z=[0, 0]), "wrong")

    def test_little_curvature_is_some(self):
        # The minimum is at 1 / (H[1, 1] - 1) in the direction (-1, 1), along which H d is 1e-11.
        far = problem([[1, 1], [1, 1 + 1e-11]], [0, -1])
        x = 1 / ((1 + 1e-11) - 1)
        without = {"y": [], "z": [0, 0]}
        self.assertEqual(kind(far, "optimal", x=[-x, x], **without), "right")
        self.assertEqual(kind(far, "optimal", x=[-1.001 * x, 1.001 * x], **without), "wrong")
        self.assertEqual(kind(far, "unbounded", x=[-1, 1]), "doubtful")
        self.assertEqual(kind(problem([[1, 1], [1, 1 + 1e-9]], [0, -1]), "unbounded", x=[-1, 1]), "wrong")

    def test_what_the_file_knows(self):
        p = problem(np.eye(1), [-1.0], objective=-0.5, status="optimal", x=[1.0])
        right = Answer({"status": "optimal", "x": [1.0], "y": [], "z": [0]})
        off = Answer({"status": "optimal", "x": [1.01], "y": [], "z": [0]})
        self.assertTrue(solved(p, right))
        self.assertFalse(solved(p, off))
        self.assertEqual(judge(p, right).kind, "right")
        self.assertEqual(judge(p, off).kind, "wrong")


# x1 + x2 >= 3 within x <= 1.
INFEASIBLE = problem(np.eye(2), [0, 0], [1, 1], [3], [INF], upper=[1, 1])


class Infeasible(unittest.TestCase):
    def test_certificate(self):
        self.assertEqual(kind(INFEASIBLE, "infeasible", y=[-1], z=[1, 1]), "right")

    def test_no_certificate_or_a_wrong_one(self):
        self.assertEqual(kind(INFEASIBLE, "infeasible"), "unproven")
        self.assertEqual(kind(INFEASIBLE, "infeasible", y=[1], z=[-1, -1]), "unproven")
        # The residual of variables with a bound is moved there.
        self.assertEqual(kind(INFEASIBLE, "infeasible", y=[-1], z=[0, 0]), "right")

    def test_free_variables_need_the_sum_to_vanish(self):
        p = problem(np.eye(2), [0, 0], [1, 1, 1, 1], [3, -INF], [INF, 1])
        self.assertEqual(kind(p, "infeasible", y=[-1, 1], z=[0, 0]), "right")
        self.assertEqual(kind(p, "infeasible", y=[-1, 0.999], z=[0, 0]), "unproven")

    def test_a_feasible_problem(self):
        self.assertEqual(kind(SMALL, "infeasible", y=[1], z=[-1, -1]), "wrong")
        self.assertEqual(kind(SMALL, "infeasible"), "wrong")

    def test_by_rounding_only(self):
        p = problem(np.eye(1), [0], [1, 1], [1, -INF], [INF, 1 - 1e-11])
        self.assertEqual(kind(p, "infeasible", y=[-1, 1], z=[0]), "doubtful")
        crossed = problem(np.eye(1), [0], [1], [0.30000000000000004], [0.3])
        self.assertEqual(kind(crossed, "infeasible", y=[0], z=[0]), "wrong")

    def test_limits_that_cross(self):
        self.assertEqual(kind(problem(np.eye(1), [0], [1], [1], [0]), "infeasible", y=[0], z=[0]), "right")


class Unbounded(unittest.TestCase):
    def test_ray(self):
        p = problem([[5, 5], [5, 5]], [5, 0])
        self.assertEqual(kind(p, "unbounded", x=[-1, 1]), "right")
        self.assertEqual(kind(p, "unbounded", x=[1, -1]), "unproven")
        self.assertEqual(kind(p, "unbounded", x=[-1, 0]), "unproven")

    def test_bounded_by_a_bound_or_a_row(self):
        p = problem([[5, 5], [5, 5]], [5, 0], upper=[INF, 7])
        self.assertEqual(kind(p, "unbounded", x=[-1, 1]), "wrong")
        p = problem([[5, 5], [5, 5]], [5, 0], [0, 1], [-INF], [7])
        self.assertEqual(kind(p, "unbounded", x=[-1, 1]), "wrong")

    def test_without_a_feasible_point(self):
        p = problem(np.zeros((2, 2)), [-1, 0], [0, 1, 0, 1], [1, -INF], [INF, 0])
        self.assertEqual(kind(p, "unbounded", x=[1, 0]), "doubtful")


class Invalid(unittest.TestCase):
    def test_entries(self):
        p = problem(np.eye(1), [0], ["nan"], [0], [1])
        self.assertEqual(kind(p, "invalid"), "right")
        self.assertEqual(kind(p, "optimal", x=[0], y=[0], z=[0]), "wrong")
        self.assertEqual(kind(SMALL, "invalid"), "wrong")

    def test_indefinite(self):
        p = problem([[0, 1], [1, 0]], [0, 0], lower=[-1, -1], upper=[1, 1])
        self.assertEqual(kind(p, "invalid"), "right")
        self.assertEqual(kind(p, "optimal", x=[0, 0], y=[], z=[0, 0]), "wrong")

    def test_unreadable(self):
        self.assertEqual(judge(None, Answer({"status": "invalid"})).kind, "right")
        self.assertEqual(judge(None, Answer({"status": "optimal"})).kind, "wrong")

    def test_no_status(self):
        self.assertEqual(kind(SMALL, "almost_optimal", **RIGHT), "wrong")
        self.assertEqual(kind(SMALL, "stalled"), "unsolved")


if __name__ == "__main__":
    unittest.main()
