"""What every controller of the comparison from Python is asked to do: the file that from_python.py writes."""

import json
from types import SimpleNamespace

import numpy as np


# Tables whose keys are joints stay dicts.
BY_JOINT = ("home", "effort", "velocity")


def read_job(file):
    return _named(json.loads(file.read_text()))


def _named(value):
    if isinstance(value, list):
        return [_named(each) for each in value]
    if isinstance(value, dict):
        return SimpleNamespace(**{key: v if key in BY_JOINT else _named(v) for key, v in value.items()})
    return value


def path(job, times):
    """Value, rate and acceleration of the ellipse, one row per time: that of wbqp's reference `ellipse`.

    The angle goes from `phase` around `turns` times as a move of least jerk, from rest to rest.
    """
    p = job.path
    s = np.clip(np.asarray(times) / p.duration, 0.0, 1.0)
    moves = (s < 1.0) / p.duration
    turn = 2.0 * np.pi * p.turns
    angle = p.phase + turn * (10 * s**3 - 15 * s**4 + 6 * s**5)
    rate = turn * (30 * s**2 - 60 * s**3 + 30 * s**4) * moves
    acceleration = turn * (60 * s - 180 * s**2 + 120 * s**3) * moves**2
    value = np.tile(np.array(p.start, dtype=float), (len(s), 1))
    first, second = np.zeros_like(value), np.zeros_like(value)
    for axis, half, f, df, ddf in (
        (p.axes[0], p.semi_axes[0], np.cos(angle), -np.sin(angle), -np.cos(angle)),
        (p.axes[1], p.semi_axes[1], np.sin(angle), np.cos(angle), -np.sin(angle)),
    ):
        value[:, axis] += half * (f - f[0])
        first[:, axis] = half * df * rate
        second[:, axis] = half * (df * acceleration + ddf * rate**2)
    return value, first, second
