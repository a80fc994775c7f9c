"""Made by generate_stubs.py from the registry's JSON Schema: do not edit."""

from collections.abc import Sequence
from typing import Any, Literal

from wbqp._plugins import Plugin

class DampedHover(Plugin):
    """Damped hover with the joints held: without an optimisation that can fail, in a fixed amount of arithmetic.

    `v̇_R = −k_v v_R`, `ω̇_R = k_R (up × z_d) − k_ω ω_R`, `q̈ = −k_q² (q − q_0) − 2 k_q q̇`, `τ = M v̇ + g`

    A base with rotors hovers; one without stands on the contacts that are on or going; joints are held where they were
    when the law took over. Feedback on an old state fades away.

    Parameters
    ----------
    attitude_weight : float, default 100000.0
        Weight of roll and pitch, beside 100 of the thrust: what is kept where rotors are at their limits.
    damping : float, default 2.0
        Damping `k_v` of the base's velocity, 1/s.
    effort_price : float, default 1e-06
        Price of an effort beside a miss of the same size. [1]
    fading : float, default 0.1
        Time within which feedback on an old state fades, s. No damping may overshoot within it: half its rate times
        this is less than one.
    joint_damping : float, default 0.5
        Share of a joint's velocity that damping may take on a robot that stands, before the velocity is measured again:
        in a period, or, where the state is old, while the feedback fades. [1]
    lean : float, default 0.268
        How far a base that cannot push sideways leans against its velocity: the tangent of the angle; 0.268 is 15°.
    levelling : float, default 25.0
        Stiffness `k_R` of the base's levelling, 1/s².
    max_angular : float, default 40.0
        Largest angular acceleration that is asked of the base, rad/s².
    max_linear : float, default 4.0
        Largest acceleration that is asked of the base, m/s².
    posture : float, default 8.0
        Bandwidth `k_q` of the joints' posture, rad/s.
    rank : float, default 1e-06
        Singular value below which a direction of the rotors' wrench is missing, relative to the largest. [1]
    rotation_damping : float, default 10.0
        Damping `k_ω` of the base's rotation, 1/s. The default is critical.
    tangential_price : float, default 0.01
        The same of a contact's tangential force. [1]
    yaw_weight : float, default 10.0
        Weight of yaw, beside 1 of sideways forces, in what is left.
    """
    def __init__(
        self,
        *,
        attitude_weight: float | None = ...,
        damping: float | None = ...,
        effort_price: float | None = ...,
        fading: float | None = ...,
        joint_damping: float | None = ...,
        lean: float | None = ...,
        levelling: float | None = ...,
        max_angular: float | None = ...,
        max_linear: float | None = ...,
        posture: float | None = ...,
        rank: float | None = ...,
        rotation_damping: float | None = ...,
        tangential_price: float | None = ...,
        yaw_weight: float | None = ...,
    ) -> None: ...

__all__ = [
    "DampedHover",
]
