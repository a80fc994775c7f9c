"""Quadratic programs as lines of JSON, and what can be said of a proposed answer with less rounding than its own.

    minimise   1/2 x'Hx + g'x
    subject to row_lower <= A x <= row_upper,   lower <= x <= upper

One object per line: `n`, `m`, `H` (n x n) and `A` (m x n) row by row, `g`, `row_lower`, `row_upper`, `lower`, `upper`;
"inf", "-inf" and "nan" as strings. Of H the lower triangle counts. Multipliers y of rows and z of bounds are positive
on an active upper side, negative on an active lower side: H x + g + A'y + z = 0 at the optimum.

Everything below is computed in long double (64 bits of mantissa on x86-64).
"""

import json

import numpy as np

LONG = np.longdouble
INF = np.inf
# Below this share of the numbers a sum is made of, nothing is known of its sign: they are given to 53 bits.
ROUNDING = 1e-15


def number(value):
    return float(value)


def numbers(values):
    return np.array([number(value) for value in values], dtype=float)


def written(values):
    """The way back: a list that JSON can hold."""
    return [float(v) if np.isfinite(v) else str(float(v)) for v in np.asarray(values, dtype=float).ravel()]


class Problem:
    """A quadratic program; `expected` is what the file says of it, `name` its note."""

    def __init__(self, n, m, H, g, A, row_lower, row_upper, lower, upper, name="", expected=None):
        self.n, self.m, self.name, self.expected = n, m, name, expected or {}
        self.H, self.A = np.reshape(H, (n, n)), np.reshape(A, (m, n))
        self.g, self.row_lower, self.row_upper, self.lower, self.upper = g, row_lower, row_upper, lower, upper
        for vector, size in ((g, n), (row_lower, m), (row_upper, m), (lower, n), (upper, n)):
            if np.shape(vector) != (size,):
                raise ValueError(f"{name}: {np.shape(vector)} instead of {size} numbers")

    @classmethod
    def parse(cls, data):
        data = json.loads(data) if isinstance(data, str) else data
        arrays = {key: numbers(data[key]) for key in ("H", "g", "A", "row_lower", "row_upper", "lower", "upper")}
        name = data.get("note", data.get("name", ""))
        return cls(data["n"], data["m"], **arrays, name=name, expected=data.get("expected"))

    def line(self):
        arrays = ("H", "g", "A", "row_lower", "row_upper", "lower", "upper")
        data = {"note": self.name, "expected": self.expected, "n": self.n, "m": self.m}
        return json.dumps(data | {key: written(getattr(self, key)) for key in arrays})

    def bad_entry(self):
        """Why the problem means nothing, or None. Coefficients are finite, limits are numbers on their right side."""
        for key in ("H", "g", "A"):
            values = np.tril(self.H).ravel() if key == "H" else getattr(self, key).ravel()
            bad = np.flatnonzero(~np.isfinite(values))
            if bad.size:
                return f"{key}[{bad[0]}] is {values[bad[0]]}"
        for low, high in (("row_lower", "row_upper"), ("lower", "upper")):
            for key, wrong in ((low, INF), (high, -INF)):
                values = getattr(self, key)
                bad = np.flatnonzero(np.isnan(values) | (values == wrong))
                if bad.size:
                    return f"{key}[{bad[0]}] is {values[bad[0]]}"
        return None

    def least_curvature(self):
        """The least eigenvalue of H, made scale-free by its diagonal; negative beyond rounding: not convex."""
        H = self.symmetric().astype(float)
        diagonal = np.diag(H)
        scale = np.where(diagonal > 0, 1 / np.sqrt(np.where(diagonal > 0, diagonal, 1)), 1.0)
        scaled = H * scale[:, None] * scale[None, :]
        if np.any(diagonal < 0):
            return float(diagonal.min())
        # A variable without curvature of its own may not have any with others.
        none = diagonal == 0
        if np.any(none) and np.any(H[none] != 0):
            return -float(np.abs(H[none]).max())
        return float(np.linalg.eigvalsh(scaled)[0]) if self.n else 0.0

    def symmetric(self):
        lower = np.tril(self.H.astype(LONG))
        return lower + np.tril(lower, -1).T

    def cost(self, x):
        x = np.asarray(x, dtype=LONG)
        return 0.5 * (x @ (self.symmetric() @ x)) + self.g.astype(LONG) @ x

    def cost_size(self, x):
        """The sum of the sizes of all that the cost is made of."""
        x = np.abs(np.asarray(x, dtype=LONG))
        return 0.5 * (x @ (np.abs(self.symmetric()) @ x)) + np.abs(self.g.astype(LONG)) @ x


def excess(values, lower, upper):
    """By how much values are outside of limits; never negative."""
    low = np.where(np.isfinite(lower), np.asarray(lower, LONG) - values, -INF)
    high = np.where(np.isfinite(upper), values - np.asarray(upper, LONG), -INF)
    return np.maximum(0, np.maximum(low, high))


def ratio(amount, of):
    """amount / of; zero of nothing is zero."""
    amount, of = np.asarray(amount, LONG), np.asarray(of, LONG)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(amount == 0, LONG(0), amount / of)


def violations(p, x):
    """Of every row, then every bound: the violation, and the size of what it is the difference of:
    |limit| + sum |a_j x_j|, with the limit that is violated."""
    x = np.asarray(x, LONG)
    A = p.A.astype(LONG)
    values = np.concatenate([A @ x, x])
    sizes = np.concatenate([np.abs(A) @ np.abs(x), np.abs(x)])
    lower, upper = np.concatenate([p.row_lower, p.lower]), np.concatenate([p.row_upper, p.upper])
    limit = np.where(np.isfinite(lower) & (values < lower), lower, np.where(np.isfinite(upper), upper, 0.0))
    return excess(values, lower, upper), sizes + np.abs(limit.astype(LONG))


def stationarity(p, x, y, z):
    """|H x + g + A'y + z| of every variable, and the sum of the sizes of its terms."""
    x, y, z = (np.asarray(v, LONG) for v in (x, y, z))
    H, A, g = p.symmetric(), p.A.astype(LONG), p.g.astype(LONG)
    residual = np.abs(H @ x + g + A.T @ y + z)
    return residual, np.abs(H) @ np.abs(x) + np.abs(g) + np.abs(A).T @ np.abs(y) + np.abs(z)


def support(p, y, z):
    """sum over y > 0 of y u, over y < 0 of y l (rows and bounds), and the sum of the sizes of its terms."""
    multipliers = np.concatenate([np.asarray(y, LONG), np.asarray(z, LONG)])
    lower, upper = np.concatenate([p.row_lower, p.lower]), np.concatenate([p.row_upper, p.upper])
    limit = np.where(multipliers > 0, upper, np.where(multipliers < 0, lower, 0.0)).astype(LONG)
    terms = multipliers * limit
    return terms.sum(), np.abs(terms).sum()


def gap(p, x, y, z):
    """Primal less dual cost, x'Hx + g'x + support, and the sum of the sizes of its terms."""
    x = np.asarray(x, LONG)
    weighted, size = support(p, y, z)
    curvature = x @ (p.symmetric() @ x)
    linear = p.g.astype(LONG) * x
    sizes = np.abs(x) @ (np.abs(p.symmetric()) @ np.abs(x)) + np.abs(linear).sum() + size
    return curvature + linear.sum() + weighted, sizes


def polished(p, x, y, z, rounds=8, active=None):
    """x, y, z improved as the solution of the equations of what is active: iterative refinement, residuals in long
    double. Active is what has a multiplier that counts; an equality always is. None where it does not end."""
    x, y, z = (np.asarray(v, LONG).copy() for v in (x, y, z))
    H, A, g = p.symmetric(), p.A.astype(LONG), p.g.astype(LONG)
    full = np.vstack([A, np.eye(p.n, dtype=LONG)])
    lower, upper = np.concatenate([p.row_lower, p.lower]), np.concatenate([p.row_upper, p.upper])
    multipliers = np.concatenate([y, z])
    if active is None:
        values = full @ x
        # A multiplier counts where it outweighs the distance from its limit, both of their own kind's size.
        distance = np.minimum(np.abs(values - lower), np.abs(values - upper)) / (1 + np.abs(values))
        weight = np.abs(multipliers) / (1 + np.max(np.abs(multipliers), initial=0))
        active = (lower == upper) | (weight > distance)
    active = np.flatnonzero(active)
    side = np.where(lower[active] == upper[active], lower[active],
                    np.where(multipliers[active] > 0, upper[active], lower[active])).astype(LONG)
    if not np.all(np.isfinite(side)):
        return None
    rows, dual, count = full[active], multipliers[active].copy(), len(active)
    matrix = np.block([[H, rows.T], [rows, np.zeros((count, count), LONG)]]).astype(float)
    scale = np.max(np.abs(matrix), axis=0, initial=0)
    scale = 1 / np.sqrt(np.where(scale > 0, scale, 1))
    u, s, v = np.linalg.svd(matrix * scale[:, None] * scale[None, :])
    kept = s > 1e-13 * s[0]
    inverse = (v[kept].T / s[kept]) @ u[:, kept].T
    for _ in range(rounds):
        residual = -np.concatenate([H @ x + g + rows.T @ dual, rows @ x - side])
        step = scale * (inverse @ (scale * residual).astype(float))
        if not np.all(np.isfinite(step)):
            return None
        x, dual = x + step[: p.n], dual + step[p.n :]
    result = np.zeros(p.m + p.n, LONG)
    result[active] = dual
    return x, result[: p.m], result[p.m :]
