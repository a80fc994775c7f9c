"""Made by generate_stubs.py from the registry's JSON Schema: do not edit."""

from collections.abc import Sequence
from typing import Any, Literal

from wbqp._plugins import Plugin

class Ellipse(Plugin):
    """Goes around an ellipse once or several times, from rest to rest, beginning where it takes over (or at `from`).
    After a whole number of turns it ends where it began. It holds before and after.

    Two components of the task move: `axes[0]` by `semi_axes[0] cos φ`, `axes[1]` by `semi_axes[1] sin φ` about the
    centre, where the angle φ goes from `phase` to `phase + 2π turns` with the profile of
    `MinJerk`; the others hold. Rates and accelerations are the exact derivatives. Equal
    semi-axes make a circle, a semi-axis of zero a line there and back.

    For tasks on vectors; rotations are refused.

    Parameters
    ----------
    duration : float
        How long it takes, s.
    semi_axes : Sequence[float]
        Half the width along each of the two axes, in the task's unit; not negative, at least one above zero.
    axes : Sequence[int], default [0, 1]
        The two components of the task that move, counted from 0.
    from_ : Sequence[float], optional
        Where it begins, one number per component of the task. Without it, what the task followed before; at the
        start, what is measured. [the task's]
    phase : float, default 0.0
        The angle φ at which it begins, rad: 0 at the positive end of the first axis, π/2 at that of the second.
    start : float, default 0.0
        Delay before it begins, s.
    turns : float, default 1.0
        How often it goes around; a fraction ends elsewhere, a negative number turns from `axes[1]` to `axes[0]`.
    """
    def __init__(
        self,
        *,
        duration: float,
        semi_axes: Sequence[float],
        axes: Sequence[int] | None = ...,
        from_: Sequence[float] | None = ...,
        phase: float | None = ...,
        start: float | None = ...,
        turns: float | None = ...,
    ) -> None: ...

class Hold(Plugin):
    """Stays at a value, or where it takes over. Rate and acceleration are zero.

    Jumps to the value at once; `MinJerk` goes there smoothly.

    Parameters
    ----------
    value : Sequence[float], optional
        The value, in the task's unit (m, rad or N); `[roll, pitch, yaw]` in rad for a rotation. Without it, what
        the task followed before; at the start, what is measured.
    """
    def __init__(
        self,
        *,
        value: Sequence[float] | None = ...,
    ) -> None: ...

class MinJerk(Plugin):
    """Moves once, from rest to rest, with the least jerk. It holds before and after.

    `value = from + s(t/T) (to − from)` with `s(τ) = 10τ³ − 15τ⁴ + 6τ⁵`, and for rotations about one fixed axis, the
    short way, `R = exp(s log(R_to R_fromᵀ)) R_from`.

    Rates and accelerations are the exact derivatives.

    It begins at rest also where it replaces a reference that moves.

    Parameters
    ----------
    duration : float
        How long the move takes, s.
    to : Sequence[float]
        Where it ends, in the task's unit (m, rad or N); `[roll, pitch, yaw]` in rad for a rotation.
    from_ : Sequence[float], optional
        Where it begins, in the unit of `to`. Without it, what the task followed before; at the start, what is
        measured. [the task's]
    start : float, default 0.0
        Delay before the move begins, s.
    """
    def __init__(
        self,
        *,
        duration: float,
        to: Sequence[float],
        from_: Sequence[float] | None = ...,
        start: float | None = ...,
    ) -> None: ...

class ThrustAttitude(Plugin):
    """Points the base's z where force is needed: for robots whose thrust has that one direction.

    A reference for `BaseOrientation`. It tilts the base as far as the accelerations that
    tasks ask of it and the set points of its contacts need:

    `F = m (a_R* − g) − Σ_c R_WC f_c^d − f̂`, `z_R = F/‖F‖`, with F low-passed and the tilt limited.

    Nothing has to be named: `a_R*` is the
    virtual input of whatever task moves the base, and
    `f_c^d` that of every contact with a force task, both of the tick before.
    It begins with the attitude where it takes over, apart from the yaw.

    With a steady position error the base tilts for what its stiffness asks, too: a base that is pulled into a wall by
    its position reference pushes with more than the set point.

    Parameters
    ----------
    cutoff : float, default 2.0
        Cut-off of each of the two low-passes on the force, Hz; `inf` for none.
    max_tilt : float, default 0.35
        Largest angle between the base's z and the vertical, rad, below π/2.
    yaw : float, optional
        Yaw of the base, rad. Without it, what the task followed before; at the start, the measured one.
    """
    def __init__(
        self,
        *,
        cutoff: float | None = ...,
        max_tilt: float | None = ...,
        yaw: float | None = ...,
    ) -> None: ...

class Waypoints(Plugin):
    """Visits points at given times. Between two points it moves as `MinJerk` does, from rest to rest; it leaves a point
    after its `dwell` and reaches the next at that one's `at`. The first move begins where the reference takes over;
    after the last point it holds.

    Parameters
    ----------
    points : Sequence[dict[str, Any]]
        The points, in the order of their times.
    """
    def __init__(
        self,
        *,
        points: Sequence[dict[str, Any]],
    ) -> None: ...

__all__ = [
    "Ellipse",
    "Hold",
    "MinJerk",
    "ThrustAttitude",
    "Waypoints",
]
