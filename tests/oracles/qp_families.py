#!/usr/bin/env python3
"""Random quadratic programs of many kinds as lines of JSON, for qp_judge.py.

    target/oracles/venv/bin/python tests/oracles/qp_families.py 10000 --seed 1 >target/oracles/qp/random.jsonl
    target/oracles/venv/bin/python tests/oracles/qp_judge.py target/oracles/qp/random.jsonl \\
        --solver target/release/examples/solve_json --quiet

The kinds follow one another, the note has the kind and the seed, with which a problem can be made alone (`--only`).
Where the construction leaves no doubt, `expected` has the status. Coefficients are often small whole numbers: ties,
degeneracy and dependent rows are then exact.
"""

import argparse
import sys

import numpy as np
from qp_problem import INF, Problem

SIZES = (1, 2, 3, 5, 8, 12, 20, 30)


class Draft:
    """A problem under construction, with a point that keeps all limits."""

    def __init__(self, rng, whole):
        self.rng, self.whole = rng, whole
        self.n = int(rng.choice(SIZES))
        self.x = self.draw(self.n)
        self.H, self.g = np.zeros((self.n, self.n)), np.zeros(self.n)
        self.A, self.low, self.high = np.zeros((0, self.n)), np.zeros(0), np.zeros(0)
        self.lower, self.upper = np.full(self.n, -INF), np.full(self.n, INF)
        self.status = None

    def draw(self, *shape):
        if self.whole:
            return self.rng.integers(-3, 4, shape).astype(float)
        return self.rng.standard_normal(shape)

    def gap(self, count):
        """Distances from limits: often none at all."""
        some = self.rng.integers(0, 3, count).astype(float) if self.whole else self.rng.exponential(1.0, count)
        return some * (self.rng.random(count) < 0.7)

    def cost(self, rank, shift=True):
        """H of a rank, g such that the cost is bounded below: H's part towards some point."""
        root = self.draw(rank, self.n)
        self.H = root.T @ root
        if shift:
            self.g = -self.H @ (self.x + self.draw(self.n))

    def rows(self, count, equal=0.2):
        new = self.draw(count, self.n)
        value = new @ self.x
        low, high = value - self.gap(count), value + self.gap(count)
        kind = self.rng.random(count)
        low[kind < 0.35] = -INF
        high[(kind >= 0.35) & (kind < 0.7)] = INF
        is_equal = self.rng.random(count) < equal
        low[is_equal] = high[is_equal] = value[is_equal]
        self.push(new, low, high)

    def push(self, rows, low, high):
        self.A = np.vstack([self.A, rows])
        self.low, self.high = np.append(self.low, low), np.append(self.high, high)

    def bounds(self, share):
        chosen = self.rng.random(self.n) < share
        self.lower = np.where(chosen, self.x - self.gap(self.n), self.lower)
        chosen = self.rng.random(self.n) < share
        self.upper = np.where(chosen, self.x + self.gap(self.n), self.upper)

    def scale(self, rows, variables, cost):
        """Other units by powers of two: the numbers stay what they are, exactly."""
        s = 2.0 ** self.rng.integers(-variables, variables + 1, self.n)
        r = 2.0 ** self.rng.integers(-rows, rows + 1, len(self.low))
        c = 2.0 ** self.rng.integers(-cost, cost + 1)
        self.H, self.g = c * self.H * s[:, None] * s[None, :], c * self.g * s
        self.A = self.A * s[None, :] * r[:, None]
        self.low, self.high = self.low * r, self.high * r
        self.lower, self.upper = self.lower / s, self.upper / s

    def problem(self, name):
        expected = {"status": self.status} if self.status else None
        return Problem(self.n, len(self.low), self.H, self.g, self.A, self.low, self.high, self.lower, self.upper,
                       name=name, expected=expected)


def regular(d):
    d.cost(d.n + 2)
    d.H += 0.1 * np.eye(d.n)
    d.rows(int(d.rng.integers(0, 2 * d.n + 2)))
    d.bounds(0.4)
    d.status = "optimal"


def semidefinite(d):
    d.cost(int(d.rng.integers(0, d.n)))
    d.rows(int(d.rng.integers(0, 2 * d.n + 2)))
    d.bounds(0.4)
    d.status = "optimal"


def linear(d):
    """Bounded: the cost is a combination of the limits' normals with multipliers on their sides."""
    d.rows(int(d.rng.integers(1, 2 * d.n + 2)))
    d.bounds(0.6)
    supported(d)


def nearly_linear(d):
    """The same with very little curvature."""
    linear(d)
    d.H = np.eye(d.n) * 10.0 ** d.rng.uniform(-14, -4)


def supported(d):
    everything = np.vstack([d.A, np.eye(d.n)])
    low, high = np.append(d.low, d.lower), np.append(d.high, d.upper)
    weights = np.abs(d.draw(len(low))) * (d.rng.random(len(low)) < 0.6)
    side = np.where(np.isfinite(high) & (~np.isfinite(low) | (d.rng.random(len(low)) < 0.5)), 1.0, -1.0)
    weights = np.where(np.isfinite(low) | np.isfinite(high), weights * side, 0)
    d.g = -everything.T @ weights
    d.status = "optimal"


def redundant(d):
    """Rows twice, sums of rows, multiples, rows of zeros."""
    d.cost(int(d.rng.integers(0, d.n + 3)))
    d.rows(int(d.rng.integers(1, d.n + 2)), equal=0.5)
    d.bounds(0.3)
    for _ in range(int(d.rng.integers(1, d.n + 2))):
        mix = d.rng.integers(-2, 3, len(d.low)).astype(float) * (d.rng.random(len(d.low)) < 0.4)
        row = mix @ d.A
        value = row @ d.x
        slack = d.gap(2)
        equal = np.all((d.low == d.high) | (mix == 0)) and d.rng.random() < 0.5
        d.push(row[None, :], value - (0 if equal else slack[0]), value + (0 if equal else slack[1]))
    d.status = "optimal"


def rounding_rows(d):
    """Rows that are zero up to rounding, with limits that are."""
    d.cost(d.n + 1)
    d.rows(int(d.rng.integers(0, d.n + 1)))
    count = int(d.rng.integers(1, 4))
    tiny = 10.0 ** d.rng.uniform(-20, -16, (count, d.n)) * d.rng.integers(-1, 2, (count, d.n))
    sign = d.rng.choice([-1.0, 1.0], count)
    limit = sign * 10.0 ** d.rng.uniform(-20, -16, count)
    d.push(tiny, np.where(sign > 0, -INF, limit), np.where(sign > 0, limit, INF))
    d.status = "optimal"


def degenerate(d):
    """All limits go through one point, which is optimal."""
    d.cost(int(d.rng.integers(0, d.n + 2)), shift=False)
    rows = d.draw(int(d.rng.integers(d.n, 3 * d.n + 2)), d.n)
    value = rows @ d.x
    one_sided = d.rng.random(len(value)) < 0.8
    d.push(rows, np.where(one_sided, -INF, value - 1), value)
    supported(d)
    d.g = d.g - d.H @ d.x


def box(d):
    d.cost(int(d.rng.integers(0, d.n + 1)))
    d.g += d.draw(d.n)
    d.lower, d.upper = d.x - d.gap(d.n), d.x + d.gap(d.n)
    d.status = "optimal"


def simplex(d):
    d.cost(int(d.rng.integers(0, d.n + 1)))
    d.g += d.draw(d.n)
    d.lower = np.zeros(d.n)
    d.push(np.ones((1, d.n)), 1.0, 1.0)
    d.status = "optimal"


def unbounded(d):
    """Along a direction of whole numbers that costs less and that no limit ends."""
    ray = d.rng.integers(-2, 3, d.n).astype(float)
    ray[d.rng.integers(d.n)] = 1.0
    root = d.rng.integers(-3, 4, (int(d.rng.integers(0, d.n + 1)), d.n)).astype(float)
    # Orthogonal to the ray, exactly.
    root = root * (ray @ ray) - np.outer(root @ ray, ray)
    d.H = root.T @ root
    d.g = d.H @ d.rng.integers(-3, 4, d.n).astype(float) - ray * float(d.rng.choice([1.0, 1e-3, 1e3]))
    d.rows(int(d.rng.integers(0, d.n + 3)))
    rows = d.A @ ray
    d.low = np.where(rows < 0, -INF, d.low)
    d.high = np.where(rows > 0, INF, d.high)
    d.bounds(0.5)
    d.lower = np.where(ray < 0, -INF, d.lower)
    d.upper = np.where(ray > 0, INF, d.upper)
    if not np.all((rows == 0) | ~np.isfinite(np.where(rows < 0, d.low, d.high))):
        return
    d.status = "unbounded" if np.abs(d.A @ ray)[np.isfinite(d.low) & np.isfinite(d.high)].sum() == 0 else None


def infeasible(d):
    """By 1e-6 to 1e3, beside rows of size one."""
    d.cost(int(d.rng.integers(0, d.n + 2)))
    d.rows(int(d.rng.integers(1, d.n + 2)))
    d.bounds(0.3)
    limits = [(i, s) for i in range(len(d.low)) for s in (-1, 1) if np.isfinite((d.low, d.high)[s > 0][i])]
    chosen = [limits[k] for k in d.rng.permutation(len(limits))[: int(d.rng.integers(1, 4))]]
    weights = d.rng.integers(1, 4, len(chosen)).astype(float)
    # The weighted sum of these rows may be at most `most`: ask for more.
    row = sum(w * s * d.A[i] for w, (i, s) in zip(weights, chosen))
    most = sum(w * (d.high[i] if s > 0 else -d.low[i]) for w, (i, s) in zip(weights, chosen))
    d.push(row[None, :], most + 10.0 ** d.rng.uniform(-6, 3), INF)
    d.status = "infeasible" if np.any(row != 0) else None


def nearly_parallel(d):
    d.cost(d.n + 1)
    d.rows(int(d.rng.integers(1, d.n + 2)))
    base = d.A[d.rng.integers(0, len(d.low), int(d.rng.integers(1, d.n + 2)))]
    tilt = base + 10.0 ** d.rng.uniform(-12, -3) * d.rng.standard_normal(base.shape)
    value = tilt @ d.x
    d.push(tilt, np.full(len(value), -INF), value + d.gap(len(value)))
    d.status = "optimal"


def fixed_variables(d):
    d.cost(int(d.rng.integers(0, d.n + 2)))
    d.rows(int(d.rng.integers(0, d.n + 1)), equal=0.5)
    fixed = d.rng.random(d.n) < 0.5
    d.lower, d.upper = np.where(fixed, d.x, -INF), np.where(fixed, d.x, INF)
    d.status = "optimal"


def nearly_flat(d):
    """Curvature of 1e-12 to 1e-3 of the largest in up to three directions, and none in others: x is far away, if it is
    anywhere."""
    turn, _ = np.linalg.qr(d.rng.standard_normal((d.n, d.n)))
    curvature = 10.0 ** d.rng.uniform(-1, 1, d.n)
    count = int(d.rng.integers(1, min(d.n, 3) + 1))
    curvature[:count] = 10.0 ** d.rng.uniform(-12, -3, count)
    if d.rng.random() < 0.3:
        curvature[count : count + 2] = 0
    d.H = (turn * curvature) @ turn.T
    d.H = (d.H + d.H.T) / 2
    d.g = d.rng.standard_normal(d.n)
    if d.rng.random() < 0.5:
        d.rows(int(d.rng.integers(0, d.n + 2)))
    if d.rng.random() < 0.5:
        d.bounds(0.3)


def far_away(d):
    """Everything happens at 1e6."""
    d.x = d.x + 1e6
    d.cost(d.n + 1)
    d.rows(int(d.rng.integers(0, 2 * d.n + 1)))
    d.bounds(0.4)
    d.status = "optimal"


def soft(d):
    """Slacks with a price, as relaxed levels have them: limits that cross are paid for."""
    half = max(1, d.n // 2)
    rows = max(1, d.n - half)
    root = d.draw(half + 1, half)
    n = half + rows
    d.n, d.x = n, np.zeros(n)
    d.H = np.zeros((n, n))
    d.H[:half, :half] = root.T @ root + 1e-3 * np.eye(half)
    price = 10.0 ** d.rng.uniform(-6, 8)
    d.g = np.append(d.draw(half), np.full(rows, price * float(d.rng.integers(0, 2))))
    d.H[half:, half:] = np.eye(rows) * (price if d.rng.random() < 0.7 else 0.0)
    d.A = np.hstack([d.draw(rows, half), np.eye(rows)])
    d.low, d.high = d.draw(rows) + 2, np.full(rows, INF)
    d.lower = np.append(np.full(half, -1.0), np.zeros(rows))
    d.upper = np.append(np.full(half, 1.0), np.full(rows, INF))
    d.status = "optimal"


KINDS = [regular, semidefinite, linear, nearly_linear, redundant, rounding_rows, degenerate, box, simplex, unbounded,
         infeasible, nearly_parallel, fixed_variables, far_away, soft, nearly_flat]
# Powers of two by which rows, variables and cost are scaled; the first is no scaling.
SCALES = [(0, 0, 0), (0, 0, 0), (20, 0, 0), (0, 20, 0), (0, 0, 20), (20, 10, 10)]


def make(seed):
    """The problem of a seed."""
    rng = np.random.default_rng(seed)
    kind = KINDS[seed % len(KINDS)]
    draft = Draft(rng, whole=rng.random() < 0.5)
    kind(draft)
    scales = SCALES[int(rng.integers(len(SCALES)))]
    # Rows of rounding are so in their own units.
    if kind is not rounding_rows:
        draft.scale(*scales)
    return draft.problem(f"{kind.__name__} {seed} {scales}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("count", type=int)
    parser.add_argument("--seed", type=int, default=0, help="of the first problem")
    parser.add_argument("--only", nargs="*", type=int, help="these seeds instead")
    arguments = parser.parse_args()
    for seed in arguments.only or range(arguments.seed, arguments.seed + arguments.count):
        sys.stdout.write(make(seed).line() + "\n")


if __name__ == "__main__":
    main()
