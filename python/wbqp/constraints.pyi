"""Made by generate_stubs.py from the registry's JSON Schema: do not edit."""

from collections.abc import Sequence
from typing import Any, Literal

from wbqp._plugins import Plugin

class ActuatorLimits(Plugin):
    """Keeps every effort within its actuator's limits, the paper's (10b).

    `u_l ≤ u ≤ u_u`, N for rotors and prismatic joints, N·m for revolute ones.

    The limits are the robot's (`lower` and `upper` of each actuator). The paper prints bounds on ω that act on its
    input ω²; here the variable is the thrust itself, and so are its bounds. Where an actuator has a `slew`, the effort
    also stays within `slew` × T of the last one that was sent, where T is the time since then, at most a period.

    Bounds on single efforts, rows only where the formulation has no variable for one; always hard, and another
    `hardness` is refused.

    Parameters
    ----------
    active : bool, default true
        Whether it is on at the start.
    hardness : str | dict[str, Any], optional
        "hard", "soft" or { exact = λ }.
    name : str, optional
        Unique name: how logs, reports, errors and events call it. Default: `<frame>_<type>`, `<contact>_<type>` or
        `<type>`.
    transition : float, default 0.0
        Duration of the ramp when it is switched or gets another weight, s.
    weight : float | Sequence[float], optional
        Weight, a number or one per row, 0 or more: a row costs weight × residual². A hard entry needs none.
    """
    def __init__(
        self,
        *,
        active: bool | None = ...,
        hardness: str | dict[str, Any] | None = ...,
        name: str | None = ...,
        transition: float | None = ...,
        weight: float | Sequence[float] | None = ...,
    ) -> None: ...

class ContactMotion(Plugin):
    """Keeps the contact point from moving in the constrained directions, the paper's (10e) with a damping that stops
    what motion there is:

    `J_c v̇ = −k_d V − J̇_c v + a_S`, m/s² or rad/s²,

    V the velocity relative to the surface and `a_S` the surface's acceleration, with Coriolis', both in the constrained
    directions.
    The printed (10e) has `J_c v` for the bias `J̇_c v`.

    An entry with `hardness = "soft"` and a large weight is the paper's section IV-A: a task instead of a constraint.

    Exists while the contact is on.

    Parameters
    ----------
    contact : str
        The contact, by name.
    active : bool, default true
        Whether it is on at the start.
    damping : float, default 4.0
        Damping `k_d`, 1/s; 0 is the paper's equation.
    hardness : str | dict[str, Any], optional
        "hard", "soft" or { exact = λ }.
    name : str, optional
        Unique name: how logs, reports, errors and events call it. Default: `<frame>_<type>`, `<contact>_<type>` or
        `<type>`.
    transition : float, default 0.0
        Duration of the ramp when it is switched or gets another weight, s.
    weight : float | Sequence[float], default 10000.0
        Weight, a number or one per row, 0 or more: a row costs weight × residual². A hard entry needs none.
    """
    def __init__(
        self,
        *,
        contact: str,
        active: bool | None = ...,
        damping: float | None = ...,
        hardness: str | dict[str, Any] | None = ...,
        name: str | None = ...,
        transition: float | None = ...,
        weight: float | Sequence[float] | None = ...,
    ) -> None: ...

class ContactWrench(Plugin):
    """Keeps the wrench of a contact with moments (kinds `full` and `normal_tilt`) within what a flat rectangular sole
    can bear:

    `n_kᵀ f_t ≤ μ' f_n` for `k = 0 … N − 1`, N: friction, as in `FrictionPyramid`,

    `|m_x| ≤ l_y f_n`, `|m_y| ≤ l_x f_n`, N·m: the centre of pressure stays inside the sole,

    `|m_z| ≤ μ_t f_n`, N·m: torsion,

    `f_min ≤ f_n ≤ f_max`, N: normal force, a bound on one variable, hard whatever the entry says.

    Friction coefficient and limits are the contact's; its ramp scales the limits. `normal_tilt` has no tangential force
    and no torsion, hence not those rows. Such a contact is refused without this constraint (or one like it): the solver
    would pull with moments.

    The exact cone of a rectangular sole couples torsion with the centre of pressure and friction (Caron, Pham and
    Nakamura, *Stability of surface contacts for humanoid robots: closed-form formulae of the contact wrench cone for
    rectangular support areas*, ICRA 2015); these rows are the usual decoupled form of it.

    Exists while the contact is on.

    Parameters
    ----------
    contact : str
        The contact, by name.
    half_length_x : float
        Half the sole's length `l_x` along the surface's x, m.
    half_length_y : float
        Half the sole's length `l_y` along the surface's y, m.
    active : bool, default true
        Whether it is on at the start.
    approximation : Literal['inner', 'outer'], default "inner"
        Friction pyramid inside the cone or around it.
    hardness : str | dict[str, Any], optional
        "hard", "soft" or { exact = λ }.
    name : str, optional
        Unique name: how logs, reports, errors and events call it. Default: `<frame>_<type>`, `<contact>_<type>` or
        `<type>`.
    sides : int, default 4
        Number of sides N of the friction pyramid, 3 to 64.
    torsional_friction : float, optional
        Torsional friction `μ_t`, m: largest moment about the normal per newton of normal force. Default:
        `μ (l_x + l_y)/3`, which a uniform pressure bears.
    transition : float, default 0.0
        Duration of the ramp when it is switched or gets another weight, s.
    weight : float | Sequence[float], optional
        Weight, a number or one per row, 0 or more: a row costs weight × residual². A hard entry needs none.
    """
    def __init__(
        self,
        *,
        contact: str,
        half_length_x: float,
        half_length_y: float,
        active: bool | None = ...,
        approximation: Literal['inner', 'outer'] | None = ...,
        hardness: str | dict[str, Any] | None = ...,
        name: str | None = ...,
        sides: int | None = ...,
        torsional_friction: float | None = ...,
        transition: float | None = ...,
        weight: float | Sequence[float] | None = ...,
    ) -> None: ...

class FrictionPyramid(Plugin):
    """Keeps the contact force in a pyramid around the normal and the normal force within the contact's limits, the
    paper's (10c):

    `n_kᵀ f_t ≤ μ' f_n` for `k = 0 … N − 1`, `f_min ≤ f_n ≤ f_max`, N,

    `n_k` at the angle `2πk/N` from the surface's x. The inner pyramid, `μ' = μ cos(π/N)`, lies inside the friction
    cone; the outer, `μ' = μ`, around it. Friction coefficient and limits are the contact's; its ramp scales the limits.

    A contact that constrains no tangential force (`normal`, `normal_tilt`) gets the limits of the normal force alone,
    which are bounds on one variable and hard whatever the entry says.

    Exists while the contact is on.

    Parameters
    ----------
    contact : str
        The contact, by name.
    active : bool, default true
        Whether it is on at the start.
    approximation : Literal['inner', 'outer'], default "inner"
        Inside the cone or around it.
    hardness : str | dict[str, Any], optional
        "hard", "soft" or { exact = λ }.
    name : str, optional
        Unique name: how logs, reports, errors and events call it. Default: `<frame>_<type>`, `<contact>_<type>` or
        `<type>`.
    sides : int, default 4
        Number of sides N, 3 to 64.
    transition : float, default 0.0
        Duration of the ramp when it is switched or gets another weight, s.
    weight : float | Sequence[float], optional
        Weight, a number or one per row, 0 or more: a row costs weight × residual². A hard entry needs none.
    """
    def __init__(
        self,
        *,
        contact: str,
        active: bool | None = ...,
        approximation: Literal['inner', 'outer'] | None = ...,
        hardness: str | dict[str, Any] | None = ...,
        name: str | None = ...,
        sides: int | None = ...,
        transition: float | None = ...,
        weight: float | Sequence[float] | None = ...,
    ) -> None: ...

class JointLimits(Plugin):
    """Keeps joints within their range of positions and their speed, by limits on accelerations that can always be kept:

    `a_l(q, q̇) ≤ q̈ ≤ a_u(q, q̇)`, one row per joint, rad/s² or m/s².

    A joint may move towards its limit only as fast as it can still stop before it with the acceleration `A`
    (viability), so the limits never contradict one another, however violent the tasks are. With T the period, `q_l`,
    `q_u` the range and `v_u` the speed, `a_u` is the smallest of

    * `A`,
    * `κ (v_u − q̇)/T`: the speed comes to its limit by the share κ = 1/4 of what is left in each period,
    * the same for a speed that becomes zero at the end, `√(2 A (r − r_0/2))` of the room `r = q_u − q`, and `r/(10 T)`
      where that is less than `r_0 = 100 A T²`,
    * the position, between the ticks as well: `2 (r − T q̇)/T²` while the joint does not turn back within the period,
      else `min(−q̇²/(2 r), −q̇/T)`,
    * viability: the a for which `(q̇ + T a)² = 2 A r⁺`, but at least `−q̇/T`,

    and `a_l` mirrors it. The last two (A. Del Prete, IEEE RA-L 3(1), 2018) matter where the joint comes from elsewhere
    than these limits would have let it. So it comes to its end smoothly, also if commands are a period late; beyond the
    end it is brought back likewise.

    `A` must be within what the motors can do everywhere, or the rows ask for more than there is; then a hard entry
    makes the problem infeasible, `hardness = { exact = … }` does not. Range and speed are the robot's.

    Parameters
    ----------
    acceleration : float | Sequence[float], default 20.0
        Acceleration `A` with which a joint can always brake, and the largest that is allowed, rad/s² or m/s²: one
        number, or one per joint.
    active : bool, default true
        Whether it is on at the start.
    hardness : str | dict[str, Any], optional
        "hard", "soft" or { exact = λ }.
    joints : Sequence[str], optional
        Which joints, by name; rows are in this order. Default: all, in the model's order.
    margin : float, default 0.0
        Distance kept from both ends of the range, rad or m.
    name : str, optional
        Unique name: how logs, reports, errors and events call it. Default: `<frame>_<type>`, `<contact>_<type>` or
        `<type>`.
    transition : float, default 0.0
        Duration of the ramp when it is switched or gets another weight, s.
    weight : float | Sequence[float], optional
        Weight, a number or one per row, 0 or more: a row costs weight × residual². A hard entry needs none.
    """
    def __init__(
        self,
        *,
        acceleration: float | Sequence[float] | None = ...,
        active: bool | None = ...,
        hardness: str | dict[str, Any] | None = ...,
        joints: Sequence[str] | None = ...,
        margin: float | None = ...,
        name: str | None = ...,
        transition: float | None = ...,
        weight: float | Sequence[float] | None = ...,
    ) -> None: ...

class PlaneDistance(Plugin):
    """Keeps a point of a frame at a distance from a plane: ground, ceiling, a wall that is not to be touched.

    With `h = nᵀ (p_WP − p₀) − margin`, one row, m/s²:

    `nᵀ J_P v̇ ≥ −(a₁ + a₂) ḣ − a₁ a₂ h − nᵀ J̇_P v`, that is `ḧ + (a₁ + a₂) ḣ + a₁ a₂ h ≥ 0`,

    an exponential control barrier function (Nguyen and Sreenath, ACC 2016): the point comes no nearer than `margin` if
    it starts further away and not too fast (`ḣ ≥ −a₁ h`). Larger rates let it come nearer before it is slowed down; the
    braking that they need is about `a₁ a₂ h`.

    Parameters
    ----------
    frame : str
        The frame, by name.
    normal : Sequence[float]
        Direction `n` from the plane to the side where the point has to be, world axes; normalised when read. [1]
    point : Sequence[float]
        A point `p₀` of the plane, m, world.
    a1 : float, default 10.0
        Rate `a₁`, 1/s, at most one over the control period.
    a2 : float, default 10.0
        Rate `a₂`, 1/s, at most one over the control period.
    active : bool, default true
        Whether it is on at the start.
    hardness : str | dict[str, Any], optional
        "hard", "soft" or { exact = λ }.
    margin : float, default 0.0
        Smallest distance, m.
    name : str, optional
        Unique name: how logs, reports, errors and events call it. Default: `<frame>_<type>`, `<contact>_<type>` or
        `<type>`.
    offset : Sequence[float], default [0.0, 0.0, 0.0]
        The point in the frame, m.
    transition : float, default 0.0
        Duration of the ramp when it is switched or gets another weight, s.
    weight : float | Sequence[float], optional
        Weight, a number or one per row, 0 or more: a row costs weight × residual². A hard entry needs none.
    """
    def __init__(
        self,
        *,
        frame: str,
        normal: Sequence[float],
        point: Sequence[float],
        a1: float | None = ...,
        a2: float | None = ...,
        active: bool | None = ...,
        hardness: str | dict[str, Any] | None = ...,
        margin: float | None = ...,
        name: str | None = ...,
        offset: Sequence[float] | None = ...,
        transition: float | None = ...,
        weight: float | Sequence[float] | None = ...,
    ) -> None: ...

class ThrustRateLimits(Plugin):
    """Keeps the rate of every thrust within limits, counted from the thrust that was sent last:

    `f⁻ − r_fall T ≤ f ≤ f⁻ + r_rise T`, N, with T the time since then, at most a period.

    Rotors speed up faster than they slow down, or the other way round: the two rates may differ. Rates that are not
    given are the robot's own (`slew`), which `ActuatorLimits` keeps as well. Thrusts are sent
    within the actuators' limits, so with those the bounds always leave something.

    Bounds on single variables, no rows; they are always hard, and another `hardness` is refused.

    Parameters
    ----------
    active : bool, default true
        Whether it is on at the start.
    fall : float, optional
        Largest rate downwards, N/s. Default: the robot's.
    hardness : str | dict[str, Any], optional
        "hard", "soft" or { exact = λ }.
    name : str, optional
        Unique name: how logs, reports, errors and events call it. Default: `<frame>_<type>`, `<contact>_<type>` or
        `<type>`.
    rise : float, optional
        Largest rate upwards, N/s. Default: the robot's.
    rotors : Sequence[str], optional
        Which rotors, by name. Default: all.
    transition : float, default 0.0
        Duration of the ramp when it is switched or gets another weight, s.
    weight : float | Sequence[float], optional
        Weight, a number or one per row, 0 or more: a row costs weight × residual². A hard entry needs none.
    """
    def __init__(
        self,
        *,
        active: bool | None = ...,
        fall: float | None = ...,
        hardness: str | dict[str, Any] | None = ...,
        name: str | None = ...,
        rise: float | None = ...,
        rotors: Sequence[str] | None = ...,
        transition: float | None = ...,
        weight: float | Sequence[float] | None = ...,
    ) -> None: ...

class TiltLimit(Plugin):
    """Keeps the base's z axis within an angle of the vertical.

    With the horizontal directions `d_k` at `2πk/N` and `h_k = sin(max_tilt) cos(π/N) − d_kᵀ z`, one row per direction,
    1/s²:

    `−(z × d_k)ᵀ ẇ_WR ≥ −(a₁ + a₂) ḣ_k − a₁ a₂ h_k + d_kᵀ (w × (w × z))`, that is `ḧ_k + (a₁ + a₂) ḣ_k + a₁ a₂ h_k ≥ 0`,

    an exponential control barrier function (Nguyen and Sreenath, ACC 2016). The N sides lie inside the cone: the tilt
    never exceeds `max_tilt`, and is stopped at `asin(sin(max_tilt) cos(π/N))` between the corners (8 sides: 92 %).
    The one row with `h = e₃ᵀ z − cos(max_tilt)` would not do: upright, its gradient is zero, and any turning makes it
    infeasible.

    The base must start within the limit. Floating base only.

    Parameters
    ----------
    max_tilt : float
        Largest angle between the base's z and the vertical, rad, below π/2.
    a1 : float, default 10.0
        Rate `a₁`, 1/s, at most one over the control period.
    a2 : float, default 10.0
        Rate `a₂`, 1/s, at most one over the control period.
    active : bool, default true
        Whether it is on at the start.
    hardness : str | dict[str, Any], optional
        "hard", "soft" or { exact = λ }.
    name : str, optional
        Unique name: how logs, reports, errors and events call it. Default: `<frame>_<type>`, `<contact>_<type>` or
        `<type>`.
    sides : int, default 8
        Number of directions N, 3 to 64.
    transition : float, default 0.0
        Duration of the ramp when it is switched or gets another weight, s.
    weight : float | Sequence[float], optional
        Weight, a number or one per row, 0 or more: a row costs weight × residual². A hard entry needs none.
    """
    def __init__(
        self,
        *,
        max_tilt: float,
        a1: float | None = ...,
        a2: float | None = ...,
        active: bool | None = ...,
        hardness: str | dict[str, Any] | None = ...,
        name: str | None = ...,
        sides: int | None = ...,
        transition: float | None = ...,
        weight: float | Sequence[float] | None = ...,
    ) -> None: ...

__all__ = [
    "ActuatorLimits",
    "ContactMotion",
    "ContactWrench",
    "FrictionPyramid",
    "JointLimits",
    "PlaneDistance",
    "ThrustRateLimits",
    "TiltLimit",
]
