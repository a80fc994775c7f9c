"""Made by generate_stubs.py from the registry's JSON Schema: do not edit."""

from collections.abc import Sequence
from typing import Any, Literal

from wbqp._plugins import Plugin

class BaseOrientation(Plugin):
    """Turns a floating base, the paper's R_R.

    Second row of (11), three rows in world axes, rad/s²:

    `ẇ_WR = ẇ_WD − K_D (w_WR − w_WD) − K_P e`, with `e = log(R_WR R_WDᵀ)∨` or `e = ½[R_WR R_WDᵀ − R_WD R_WRᵀ]∨`.

    The error printed below (11) has the wrong sign, and is in body axes while the velocities are in world axes; the
    forms here are the stable ones (derivation: with `R_WR = exp(S(d)) R_WD` both give `e = d` to first order).

    Error: `e`, rad, world axes.

    Parameters
    ----------
    kp : float | Sequence[float]
        Stiffness `K_P`, 1/s²: one number, or one per axis of `axes`.
    active : bool, default true
        Whether it is on at the start.
    axes : Literal['world', 'body'], default "world"
        Along which axes the gains count.
    error : Literal['logarithm', 'matrix'], default "logarithm"
        How the difference of two orientations is measured.
    hardness : str | dict[str, Any], optional
        "hard", "soft" or { exact = λ }.
    kd : float | Sequence[float], optional
        Damping `K_D`, 1/s: one number, or one per axis of `axes`. Default: critical, `2 √K_P`.
    name : str, optional
        Unique name: how logs, reports, errors and events call it. Default: `<frame>_<type>`, `<contact>_<type>` or
        `<type>`.
    reference : Plugin | dict[str, Any], default {"type": "hold"}
        Where to go: orientation of the base in the world, `[roll, pitch, yaw]` in rad. Default: hold what is
        measured at the start.
    transition : float, default 0.0
        Duration of the ramp when it is switched or gets another weight, s.
    weight : float | Sequence[float], default 10.0
        Weight, a number or one per row, 0 or more: a row costs weight × residual². A hard entry needs none.
    """
    def __init__(
        self,
        *,
        kp: float | Sequence[float],
        active: bool | None = ...,
        axes: Literal['world', 'body'] | None = ...,
        error: Literal['logarithm', 'matrix'] | None = ...,
        hardness: str | dict[str, Any] | None = ...,
        kd: float | Sequence[float] | None = ...,
        name: str | None = ...,
        reference: Plugin | dict[str, Any] | None = ...,
        transition: float | None = ...,
        weight: float | Sequence[float] | None = ...,
    ) -> None: ...

class BasePosition(Plugin):
    """Moves the origin of a floating base, the paper's p_R.

    First row of (11), three rows in world axes, m/s²:

    `v̇_WR = v̇_WD − K_D (v_WR − v_WD) − K_P (p_WR − p_WD) − ξ`, `ξ̇ = K_I (p_WR − p_WD) + k_aw (a* − a_QP)`.

    The integral ξ is not in the paper and off by default; it removes the sag that a wrong mass or thrust leaves. It is
    clamped per axis and starts at zero whenever the task is switched on. Its second part is back-calculation against
    wind-up: `a*` is what the task asked for in the last tick, `a_QP` what limits and other tasks left of it.

    Error: `p_WR − p_WD`, m. Gains are along world axes.

    Parameters
    ----------
    kp : float | Sequence[float]
        Stiffness `K_P`, 1/s²: one number, or one per world axis.
    active : bool, default true
        Whether it is on at the start.
    anti_windup : Any, optional
        Back-calculation gain `k_aw` of the integral, 1/s: one number, or one per world axis. Default `K_I/K_P`, with
        which the integral stays out of conflicts with limits and other tasks; 0 leaves only `integral_limit`.
    hardness : str | dict[str, Any], optional
        "hard", "soft" or { exact = λ }.
    integral_limit : float, default 2.0
        Largest acceleration that the integral may ask for on each axis, m/s².
    kd : float | Sequence[float], optional
        Damping `K_D`, 1/s: one number, or one per world axis. Default: critical, `2 √K_P`.
    ki : float | Sequence[float], default 0.0
        Integral gain `K_I`, 1/s³: one number, or one per world axis. 0, the default, is the paper's law.
    name : str, optional
        Unique name: how logs, reports, errors and events call it. Default: `<frame>_<type>`, `<contact>_<type>` or
        `<type>`.
    reference : Plugin | dict[str, Any], default {"type": "hold"}
        Where to go: position of the base's origin in the world, m. Default: hold what is measured at the start.
    transition : float, default 0.0
        Duration of the ramp when it is switched or gets another weight, s.
    weight : float | Sequence[float], default 100.0
        Weight, a number or one per row, 0 or more: a row costs weight × residual². A hard entry needs none.
    """
    def __init__(
        self,
        *,
        kp: float | Sequence[float],
        active: bool | None = ...,
        anti_windup: Any = ...,
        hardness: str | dict[str, Any] | None = ...,
        integral_limit: float | None = ...,
        kd: float | Sequence[float] | None = ...,
        ki: float | Sequence[float] | None = ...,
        name: str | None = ...,
        reference: Plugin | dict[str, Any] | None = ...,
        transition: float | None = ...,
        weight: float | Sequence[float] | None = ...,
    ) -> None: ...

class CentroidalAngularMomentum(Plugin):
    """Controls the angular momentum of the whole robot about its centre of mass: zero keeps limbs from winding it up.

    Three rows in world axes, N·m, the rate of the momentum:

    `A v̇ = L̇_d − K (L_G − L_d) − Ȧ v`.

    `A` is the angular part of the centroidal momentum matrix (Orin, Goswami and Lee, *Centroidal dynamics of a humanoid
    robot*, Autonomous Robots 35, 2013). With a floating base it is read off the mass matrix: its first three
    rows are the linear momentum and the next three the angular one about R, so `A = M_w − S(r) M_v`; likewise
    `Ȧ v = n − r × f` with the force `f` and the moment `n` about R that the velocities alone need at the base.

    The reference is a momentum, its rate `L̇_d`. Rotors that spin have no part in `L_G`. Floating base only.

    Error: `L_G − L_d`, kg·m²/s.

    Parameters
    ----------
    k : float | Sequence[float]
        Gain `K`, 1/s: one number, or one per world axis.
    active : bool, default true
        Whether it is on at the start.
    hardness : str | dict[str, Any], optional
        "hard", "soft" or { exact = λ }.
    name : str, optional
        Unique name: how logs, reports, errors and events call it. Default: `<frame>_<type>`, `<contact>_<type>` or
        `<type>`.
    reference : Plugin | dict[str, Any], default {"type": "hold"}
        The momentum wanted: three numbers, kg·m²/s, world axes. Default: none, as in the home posture at rest.
    transition : float, default 0.0
        Duration of the ramp when it is switched or gets another weight, s.
    weight : float | Sequence[float], optional
        Weight, a number or one per row, 0 or more: a row costs weight × residual². A hard entry needs none.
    """
    def __init__(
        self,
        *,
        k: float | Sequence[float],
        active: bool | None = ...,
        hardness: str | dict[str, Any] | None = ...,
        name: str | None = ...,
        reference: Plugin | dict[str, Any] | None = ...,
        transition: float | None = ...,
        weight: float | Sequence[float] | None = ...,
    ) -> None: ...

class Com(Plugin):
    """Moves the robot's centre of mass: balance of a legged robot, the point that thrust has to carry of a flying one.

    One row per axis, world axes, m/s²:

    `J_G v̇ = p̈_d − K_D (ṗ_G − ṗ_d) − K_P (p_G − p_d) − J̇_G v`

    (Jacobian of the centre of mass: Sugihara, Nakamura and Inoue, *Real-time humanoid motion generation through ZMP
    manipulation based on inverted pendulum control*, ICRA 2002).

    All links count, also those of a fixed base, which do not move: they pull the point towards themselves.

    Error: `p_G − p_d`, m.

    Parameters
    ----------
    kp : float | Sequence[float]
        Stiffness `K_P`, 1/s²: one number, or one per axis.
    active : bool, default true
        Whether it is on at the start.
    axes : Sequence[Literal['x', 'y', 'z']], optional
        Which axes of the world; rows, gains and reference are in this order. Default: x, y, z.
    hardness : str | dict[str, Any], optional
        "hard", "soft" or { exact = λ }.
    kd : float | Sequence[float], optional
        Damping `K_D`, 1/s: one number, or one per axis. Default: critical, `2 √K_P`.
    name : str, optional
        Unique name: how logs, reports, errors and events call it. Default: `<frame>_<type>`, `<contact>_<type>` or
        `<type>`.
    reference : Plugin | dict[str, Any], default {"type": "hold"}
        Where to go: one position per axis, m, world. Default: hold what is measured at the start.
    transition : float, default 0.0
        Duration of the ramp when it is switched or gets another weight, s.
    weight : float | Sequence[float], default 100.0
        Weight, a number or one per row, 0 or more: a row costs weight × residual². A hard entry needs none.
    """
    def __init__(
        self,
        *,
        kp: float | Sequence[float],
        active: bool | None = ...,
        axes: Sequence[Literal['x', 'y', 'z']] | None = ...,
        hardness: str | dict[str, Any] | None = ...,
        kd: float | Sequence[float] | None = ...,
        name: str | None = ...,
        reference: Plugin | dict[str, Any] | None = ...,
        transition: float | None = ...,
        weight: float | Sequence[float] | None = ...,
    ) -> None: ...

class ConstantForce(Plugin):
    """Asks a contact for a constant wrench: no trajectory, no feedback, no integrator. For what carries the robot, as
    the feet of a legged one, or as a regularisation of contact forces.

    One row per constrained component of the contact, C axes, N or N·m:

    `f = α f_d`,

    where the contact's ramp α takes the set point from zero and back to it. As of every task, the weight goes with the
    ramp, too.

    To push with a force that is measured, see `ContactForce`. Exists while the contact is on.

    Error: measured minus `α f_d`, N or N·m; without a sensor it says nothing. The residual is the planned force minus
    `α f_d`.

    Parameters
    ----------
    contact : str
        The contact, by name.
    normal : float
        Normal force, N.
    active : bool, default true
        Whether it is on at the start.
    hardness : str | dict[str, Any], optional
        "hard", "soft" or { exact = λ }.
    moment : Sequence[float], default [0.0, 0.0, 0.0]
        Moment about the contact point, along the surface's x, y and normal, N·m; zero where the contact leaves that
        rotation free.
    name : str, optional
        Unique name: how logs, reports, errors and events call it. Default: `<frame>_<type>`, `<contact>_<type>` or
        `<type>`.
    tangential : Sequence[float], default [0.0, 0.0]
        Tangential force along the surface's x and y, N; zero where the contact leaves that direction free.
    transition : float, default 0.0
        Duration of the ramp when it is switched or gets another weight, s.
    weight : float | Sequence[float], optional
        Weight, a number or one per row, 0 or more: a row costs weight × residual². A hard entry needs none.
    """
    def __init__(
        self,
        *,
        contact: str,
        normal: float,
        active: bool | None = ...,
        hardness: str | dict[str, Any] | None = ...,
        moment: Sequence[float] | None = ...,
        name: str | None = ...,
        tangential: Sequence[float] | None = ...,
        transition: float | None = ...,
        weight: float | Sequence[float] | None = ...,
    ) -> None: ...

class ContactForce(Plugin):
    """Pushes with a given normal force, the paper's f_c.

    Fifth row of (11), with back-calculation against wind-up, for the normal component:

    `f* = f^d − K_P (f^m − f^d) − ξ`, `ξ̇ = K_I (f^m − f^d) + k_aw (f* − f_QP)`, `|ξ| ≤ clamp`.

    When `f*` asks for more than the solver gives (limits, other tasks), ξ grows and `f*` comes down. The price: as
    long as `f* ≠ f_QP`, the measured force settles `k_aw/K_I (f* − f_QP)` below the set point.

    One row per constrained component of the contact, N or N·m, in the contact's order: `normal` for kind `normal`;
    `x`, `y`, `normal` for `point`; `normal`, `moment x`, `moment y` for `normal_tilt`; `x`, `y`, `normal`, `moment x`,
    `moment y`, `moment z` for `full`. Per-row weights of the entry are in this order. Feedback acts on the normal
    alone; moments are asked to be zero.

    # Switching
    When the contact or the task comes on, the set point starts at the measured force and goes to `f^d` with the ramp,
    and the integrator starts at zero. When the contact goes off with a ramp, the feedback stops and `f*` goes from the
    solution at that moment to zero with the ramp. When the task alone goes off, its weight fades.

    Exists while the contact is on. Error: `f^m − f^d`, N or N·m.

    Parameters
    ----------
    contact : str
        The contact, by name.
    reference : Plugin | dict[str, Any]
        Set point `f^d` of the normal force: a reference with one component, N.
    active : bool, default true
        Whether it is on at the start.
    anti_windup : float, default 0.5
        Back-calculation gain `k_aw`, 1/s. 0 leaves only the clamp against wind-up.
    clamp : float, default 2.0
        Largest magnitude of the integrator's state ξ, N. The report says when it is reached.
    feedback : Literal['off', 'pi'], default "pi"
        Whether the measured force is fed back.
    hardness : str | dict[str, Any], optional
        "hard", "soft" or { exact = λ }.
    ki : float, default 1.5
        Integral gain `K_I`, 1/s.
    kp : float, default 0.2
        Proportional gain `K_P`, N/N, below 1: in a stiff contact the measured force follows `f*` within a period, and
        the loop would oscillate at 1.
    name : str, optional
        Unique name: how logs, reports, errors and events call it. Default: `<frame>_<type>`, `<contact>_<type>` or
        `<type>`.
    tangential : Literal['zero', 'measured'], default "zero"
        What is asked of the tangential forces, where the contact constrains them.
    transition : float, default 0.0
        Duration of the ramp when it is switched or gets another weight, s.
    weight : float | Sequence[float], optional
        Weight, a number or one per row, 0 or more: a row costs weight × residual². A hard entry needs none.
    """
    def __init__(
        self,
        *,
        contact: str,
        reference: Plugin | dict[str, Any],
        active: bool | None = ...,
        anti_windup: float | None = ...,
        clamp: float | None = ...,
        feedback: Literal['off', 'pi'] | None = ...,
        hardness: str | dict[str, Any] | None = ...,
        ki: float | None = ...,
        kp: float | None = ...,
        name: str | None = ...,
        tangential: Literal['zero', 'measured'] | None = ...,
        transition: float | None = ...,
        weight: float | Sequence[float] | None = ...,
    ) -> None: ...

class FrameOrientation(Plugin):
    """Turns a frame of the robot.

    Three rows in world axes, rad/s²:

    `J_F v̇ = ẇ_d − K_D (w_WF − w_d) − K_P e − J̇_F v`, `e = log(R_WF R_WDᵀ)∨` or `½[R_WF R_WDᵀ − R_WD R_WFᵀ]∨`,

    `J_F` the angular rows of the frame's world-aligned Jacobian. Errors as in
    `BaseOrientation`; both forms are derived in Siciliano et al., *Robotics*, 3.7.3.

    Error: `e`, rad, world axes.

    Parameters
    ----------
    frame : str
        The frame, by name.
    kp : float | Sequence[float]
        Stiffness `K_P`, 1/s²: one number, or one per axis of `axes`.
    active : bool, default true
        Whether it is on at the start.
    axes : Literal['world', 'body'], default "world"
        Along which axes the gains count.
    error : Literal['logarithm', 'matrix'], default "logarithm"
        How the difference of two orientations is measured.
    hardness : str | dict[str, Any], optional
        "hard", "soft" or { exact = λ }.
    kd : float | Sequence[float], optional
        Damping `K_D`, 1/s: one number, or one per axis of `axes`. Default: critical, `2 √K_P`.
    name : str, optional
        Unique name: how logs, reports, errors and events call it. Default: `<frame>_<type>`, `<contact>_<type>` or
        `<type>`.
    reference : Plugin | dict[str, Any], default {"type": "hold"}
        Where to go: orientation of the frame in the world, `[roll, pitch, yaw]` in rad. Default: hold what is
        measured at the start.
    transition : float, default 0.0
        Duration of the ramp when it is switched or gets another weight, s.
    weight : float | Sequence[float], default 10.0
        Weight, a number or one per row, 0 or more: a row costs weight × residual². A hard entry needs none.
    """
    def __init__(
        self,
        *,
        frame: str,
        kp: float | Sequence[float],
        active: bool | None = ...,
        axes: Literal['world', 'body'] | None = ...,
        error: Literal['logarithm', 'matrix'] | None = ...,
        hardness: str | dict[str, Any] | None = ...,
        kd: float | Sequence[float] | None = ...,
        name: str | None = ...,
        reference: Plugin | dict[str, Any] | None = ...,
        transition: float | None = ...,
        weight: float | Sequence[float] | None = ...,
    ) -> None: ...

class FramePose(Plugin):
    """Moves and turns a frame of the robot: `FramePosition` and `FrameOrientation` in one entry.

    Six rows in world axes, m/s² and rad/s²:

    `J_F v̇ = [v̇_d; ẇ_d] − K_D ([v_WF; w_WF] − [v_d; w_d]) − K_P [p_WF − p_d; e] − J̇_F v`,

    with the rotation error `e = log(R_WF R_WDᵀ)∨` or `½[R_WF R_WDᵀ − R_WD R_WFᵀ]∨` (Siciliano et al., *Robotics*,
    3.7.3 and 8.6.2). Metres and radians have different units: give the entry one weight per row, or write two tasks.

    Replacing the reference while running replaces that of the position. Error: `[p_WF − p_d; e]`, m and rad.

    Parameters
    ----------
    frame : str
        The frame, by name.
    kp : float | Sequence[float]
        Stiffness `K_P`, 1/s²: one number, or six: x, y, z, then about x, y, z.
    active : bool, default true
        Whether it is on at the start.
    error : Literal['logarithm', 'matrix'], default "logarithm"
        How the difference of two orientations is measured.
    hardness : str | dict[str, Any], optional
        "hard", "soft" or { exact = λ }.
    kd : float | Sequence[float], optional
        Damping `K_D`, 1/s: one number, or six. Default: critical, `2 √K_P`.
    name : str, optional
        Unique name: how logs, reports, errors and events call it. Default: `<frame>_<type>`, `<contact>_<type>` or
        `<type>`.
    orientation : Plugin | dict[str, Any], default {"type": "hold"}
        How to turn: orientation of the frame in the world, `[roll, pitch, yaw]` in rad. Default: hold what is
        measured at the start.
    position : Plugin | dict[str, Any], default {"type": "hold"}
        Where to go: position of the frame's origin in the world, m. Default: hold what is measured at the start.
    transition : float, default 0.0
        Duration of the ramp when it is switched or gets another weight, s.
    weight : float | Sequence[float], default [100.0, 100.0, 100.0, 10.0, 10.0, 10.0]
        Weight, a number or one per row, 0 or more: a row costs weight × residual². A hard entry needs none.
    """
    def __init__(
        self,
        *,
        frame: str,
        kp: float | Sequence[float],
        active: bool | None = ...,
        error: Literal['logarithm', 'matrix'] | None = ...,
        hardness: str | dict[str, Any] | None = ...,
        kd: float | Sequence[float] | None = ...,
        name: str | None = ...,
        orientation: Plugin | dict[str, Any] | None = ...,
        position: Plugin | dict[str, Any] | None = ...,
        transition: float | None = ...,
        weight: float | Sequence[float] | None = ...,
    ) -> None: ...

class FramePosition(Plugin):
    """Moves the origin of a frame of the robot: an end effector, a foot, a camera.

    One row per axis, world axes, m/s²:

    `J_F v̇ = v̇_d − K_D (v_WF − v_d) − K_P (p_WF − p_d) − J̇_F v`,

    `J_F` the linear rows of the frame's world-aligned Jacobian (Siciliano et al., *Robotics: Modelling, Planning and
    Control*, 3.5 and 8.6.2: inverse dynamics in operational space).

    Error: `p_WF − p_d`, m.

    Parameters
    ----------
    frame : str
        The frame, by name.
    kp : float | Sequence[float]
        Stiffness `K_P`, 1/s²: one number, or one per axis.
    active : bool, default true
        Whether it is on at the start.
    axes : Sequence[Literal['x', 'y', 'z']], optional
        Which axes of the world; rows, gains and reference are in this order. Default: x, y, z.
    hardness : str | dict[str, Any], optional
        "hard", "soft" or { exact = λ }.
    kd : float | Sequence[float], optional
        Damping `K_D`, 1/s: one number, or one per axis. Default: critical, `2 √K_P`.
    name : str, optional
        Unique name: how logs, reports, errors and events call it. Default: `<frame>_<type>`, `<contact>_<type>` or
        `<type>`.
    reference : Plugin | dict[str, Any], default {"type": "hold"}
        Where to go: one position per axis, m, world. Default: hold what is measured at the start.
    transition : float, default 0.0
        Duration of the ramp when it is switched or gets another weight, s.
    weight : float | Sequence[float], default 100.0
        Weight, a number or one per row, 0 or more: a row costs weight × residual². A hard entry needs none.
    """
    def __init__(
        self,
        *,
        frame: str,
        kp: float | Sequence[float],
        active: bool | None = ...,
        axes: Sequence[Literal['x', 'y', 'z']] | None = ...,
        hardness: str | dict[str, Any] | None = ...,
        kd: float | Sequence[float] | None = ...,
        name: str | None = ...,
        reference: Plugin | dict[str, Any] | None = ...,
        transition: float | None = ...,
        weight: float | Sequence[float] | None = ...,
    ) -> None: ...

class FreeMotion(Plugin):
    """Slides the contact point along the surface, the paper's p_f.

    Fourth row of (11), one row per axis in C axes, m/s², with `p` the contact point on the robot in surface
    coordinates and `v` its velocity relative to the surface:

    `J_f v̇ = v̇_d − K_D (v − v_d) − K_P (p − p_d) − ξ + a_S − J̇_f v`, `ξ̇ = K_I (p − p_d) + k_aw (a* − a_QP)`.

    `J_f` is made of rows of the contact's Jacobian in C axes. The paper turns the Jacobian with the end effector
    instead, which lets the normal direction leak into this task when the tool tilts, and its (8) prints `J_f v` for
    the bias `J̇_f v`. `a_S` is the acceleration of a moving surface, with Coriolis'.

    The integral ξ is not in the paper and off by default; it removes what a wrong mass or thrust leaves. It is clamped
    per axis and starts at zero whenever the contact or the task is switched on. Its second part is back-calculation
    against wind-up: `a*` is what the row asked for in the last tick, `a_QP` what limits and other tasks left of it:
    `J_f` of this tick times the last solution's `v̇`. Where `J_f` has turned in between, as it does in fast motion
    while the limits are reached, a little of that is counted as left out.

    The axes are translations. Free rotations are not controlled by this task.

    Exists while the contact is on. Error: `p − p_d`, m.

    Parameters
    ----------
    contact : str
        The contact, by name.
    kp : float | Sequence[float]
        Stiffness `K_P`, 1/s²: one number, or one per axis.
    active : bool, default true
        Whether it is on at the start.
    anti_windup : Any, optional
        Back-calculation gain `k_aw` of the integral, 1/s: one number, or one per axis. Default `K_I/K_P`, with which
        the integral stays out of conflicts with limits and other tasks; 0 leaves only `integral_limit`.
    axes : Sequence[Literal['x', 'y']], optional
        Which axes of the surface; rows, gains and reference are in this order. Default: all translations that the
        contact leaves free, x before y.
    hardness : str | dict[str, Any], optional
        "hard", "soft" or { exact = λ }.
    integral_limit : float, default 2.0
        Largest acceleration that the integral may ask for on each axis, m/s².
    kd : float | Sequence[float], optional
        Damping `K_D`, 1/s: one number, or one per axis. Default: critical, `2 √K_P`.
    ki : float | Sequence[float], default 0.0
        Integral gain `K_I`, 1/s³: one number, or one per axis. 0, the default, is the paper's law.
    name : str, optional
        Unique name: how logs, reports, errors and events call it. Default: `<frame>_<type>`, `<contact>_<type>` or
        `<type>`.
    origin : Literal['surface', 'touch'], default "surface"
        Where the reference counts from.
    reference : Plugin | dict[str, Any], default {"type": "hold"}
        Where to go: one position per axis, m, from `origin`. Default: hold.
    transition : float, default 0.0
        Duration of the ramp when it is switched or gets another weight, s.
    weight : float | Sequence[float], optional
        Weight, a number or one per row, 0 or more: a row costs weight × residual². A hard entry needs none.
    """
    def __init__(
        self,
        *,
        contact: str,
        kp: float | Sequence[float],
        active: bool | None = ...,
        anti_windup: Any = ...,
        axes: Sequence[Literal['x', 'y']] | None = ...,
        hardness: str | dict[str, Any] | None = ...,
        integral_limit: float | None = ...,
        kd: float | Sequence[float] | None = ...,
        ki: float | Sequence[float] | None = ...,
        name: str | None = ...,
        origin: Literal['surface', 'touch'] | None = ...,
        reference: Plugin | dict[str, Any] | None = ...,
        transition: float | None = ...,
        weight: float | Sequence[float] | None = ...,
    ) -> None: ...

class JointTorqueRegularisation(Plugin):
    """Keeps joint torques near a value, by default near zero: the effort that other tasks leave open is then the
    smallest, and a redundant robot has one solution.

    One row per joint motor, N·m for a revolute joint, N for a prismatic one:

    `τ = τ_d`.

    Written as a task of small weight it is Tikhonov's regularisation of the torques; with `1/τ_max²` as the weight of
    each row, shares of what the motors can bear are balanced.

    Error: torque as sent last minus `τ_d`, N·m or N.

    Parameters
    ----------
    active : bool, default true
        Whether it is on at the start.
    hardness : str | dict[str, Any], optional
        "hard", "soft" or { exact = λ }.
    joints : Sequence[str], optional
        Which joints, by name; rows and reference are in this order. Default: all that have a motor, in the order of
        the actuators.
    name : str, optional
        Unique name: how logs, reports, errors and events call it. Default: `<frame>_<type>`, `<contact>_<type>` or
        `<type>`.
    reference : Plugin | dict[str, Any], default {"type": "hold"}
        The torques wanted: one per joint, N·m or N. Default: zero.
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
        joints: Sequence[str] | None = ...,
        name: str | None = ...,
        reference: Plugin | dict[str, Any] | None = ...,
        transition: float | None = ...,
        weight: float | Sequence[float] | None = ...,
    ) -> None: ...

class Posture(Plugin):
    """Moves joints, the paper's q_A.

    Third row of (11), one row per joint, rad/s² or m/s²:

    `q̈ = q̈_d − K_D (q̇ − q̇_d) − K_P (q − q_d)`.

    Error: `q − q_d`, rad or m.

    Parameters
    ----------
    kp : float | Sequence[float]
        Stiffness `K_P`, 1/s²: one number, or one per joint.
    active : bool, default true
        Whether it is on at the start.
    hardness : str | dict[str, Any], optional
        "hard", "soft" or { exact = λ }.
    joints : Sequence[str], optional
        Which joints, by name; rows, gains and reference are in this order. Default: all, in the model's order.
    kd : float | Sequence[float], optional
        Damping `K_D`, 1/s: one number, or one per joint. Default: critical, `2 √K_P`.
    name : str, optional
        Unique name: how logs, reports, errors and events call it. Default: `<frame>_<type>`, `<contact>_<type>` or
        `<type>`.
    reference : Plugin | dict[str, Any], default {"type": "hold"}
        Where to go: one position per joint, rad or m. Default: hold what is measured at the start.
    transition : float, default 0.0
        Duration of the ramp when it is switched or gets another weight, s.
    weight : float | Sequence[float], default 0.01
        Weight, a number or one per row, 0 or more: a row costs weight × residual². A hard entry needs none.
    """
    def __init__(
        self,
        *,
        kp: float | Sequence[float],
        active: bool | None = ...,
        hardness: str | dict[str, Any] | None = ...,
        joints: Sequence[str] | None = ...,
        kd: float | Sequence[float] | None = ...,
        name: str | None = ...,
        reference: Plugin | dict[str, Any] | None = ...,
        transition: float | None = ...,
        weight: float | Sequence[float] | None = ...,
    ) -> None: ...

class PropellerRegularisation(Plugin):
    """Balances the rotors' thrusts, the paper's r_a.

    Sixth row of (11), one row less than there are rotors, N:

    `f_i − f_{i+1} = 0` for neighbours in the order of the actuators.

    That is `D f = 0` with 1 on the diagonal of D and −1 right above. The paper writes `D ω²`; here the rows are
    in newtons, as its text says ("a function of the propeller forces"). The paper's weight of 1e-5 makes sense only so:
    in (rad/s)² the term would drown the others. It is no default: the entry gives its weight.

    The task is zero if and only if all thrusts are equal, but it punishes differences of neighbours alone: the
    solution depends on the order of the rotors.

    Error: `f_i − f_{i+1}` as sent last, N.

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

class RelativePose(Plugin):
    """Moves a frame of the robot relative to another one: two hands that hold an object, a camera that follows a tool.

    Six rows in the axes of A = `relative_to`, m/s² and rad/s², with B = `frame`, `r = p_WB − p_WA`:

    `J_AB v̇ = [v̇_d; ẇ_d] − K_D (V_AB − V_d) − K_P [p_AB − p_d; e] − J̇_AB v`,

    `p_AB = R_WAᵀ r`, `v_AB = R_WAᵀ (v_WB − v_WA − w_WA × r)`, `w_AB = R_WAᵀ (w_WB − w_WA)`,

    `J̇_AB v = R_WAᵀ [a_B − a_A − α_A × r − w_A × (w_A × r) − 2 w_A × R_WA v_AB; α_B − α_A − w_A × w_B]`

    where `a`, `α` are the frames' bias accelerations; the rotation error is `e = log(R_AB R_ADᵀ)∨` or its ½ form, in
    A's axes (relative Jacobian: Siciliano et al., *Robotics*, 3.8; relative acceleration: any text on mechanics).

    Gravity and the base's motion have no part in it. Replacing the reference while running replaces that of the
    position. Error: `[p_AB − p_d; e]`, m and rad.

    Parameters
    ----------
    frame : str
        The frame B that is placed, by name.
    kp : float | Sequence[float]
        Stiffness `K_P`, 1/s²: one number, or six: x, y, z, then about x, y, z.
    relative_to : str
        The frame A that it is placed relative to, by name.
    active : bool, default true
        Whether it is on at the start.
    error : Literal['logarithm', 'matrix'], default "logarithm"
        How the difference of two orientations is measured.
    hardness : str | dict[str, Any], optional
        "hard", "soft" or { exact = λ }.
    kd : float | Sequence[float], optional
        Damping `K_D`, 1/s: one number, or six. Default: critical, `2 √K_P`.
    name : str, optional
        Unique name: how logs, reports, errors and events call it. Default: `<frame>_<type>`, `<contact>_<type>` or
        `<type>`.
    orientation : Plugin | dict[str, Any], default {"type": "hold"}
        How to turn: orientation of B in A, `[roll, pitch, yaw]` in rad. Default: hold what is measured at the start.
    position : Plugin | dict[str, Any], default {"type": "hold"}
        Where to go: position of B's origin in A, m. Default: hold what is measured at the start.
    transition : float, default 0.0
        Duration of the ramp when it is switched or gets another weight, s.
    weight : float | Sequence[float], default [100.0, 100.0, 100.0, 10.0, 10.0, 10.0]
        Weight, a number or one per row, 0 or more: a row costs weight × residual². A hard entry needs none.
    """
    def __init__(
        self,
        *,
        frame: str,
        kp: float | Sequence[float],
        relative_to: str,
        active: bool | None = ...,
        error: Literal['logarithm', 'matrix'] | None = ...,
        hardness: str | dict[str, Any] | None = ...,
        kd: float | Sequence[float] | None = ...,
        name: str | None = ...,
        orientation: Plugin | dict[str, Any] | None = ...,
        position: Plugin | dict[str, Any] | None = ...,
        transition: float | None = ...,
        weight: float | Sequence[float] | None = ...,
    ) -> None: ...

class ThrustRegularisation(Plugin):
    """Keeps the thrusts of rotors near a value, by default near zero.

    One row per rotor, N:

    `f_i = f_d`.

    In contrast to `PropellerRegularisation` each thrust is weighed by itself, so the
    solution does not depend on the order of the rotors; the minimum of `Σ f_i²` is the allocation of the
    pseudo-inverse.

    Error: thrust as sent last minus `f_d`, N.

    Parameters
    ----------
    active : bool, default true
        Whether it is on at the start.
    hardness : str | dict[str, Any], optional
        "hard", "soft" or { exact = λ }.
    name : str, optional
        Unique name: how logs, reports, errors and events call it. Default: `<frame>_<type>`, `<contact>_<type>` or
        `<type>`.
    reference : Plugin | dict[str, Any], default {"type": "hold"}
        The thrusts wanted: one per rotor, N. Default: zero.
    rotors : Sequence[str], optional
        Which rotors, by name; rows and reference are in this order. Default: all, in the order of the actuators.
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
        reference: Plugin | dict[str, Any] | None = ...,
        rotors: Sequence[str] | None = ...,
        transition: float | None = ...,
        weight: float | Sequence[float] | None = ...,
    ) -> None: ...

__all__ = [
    "BaseOrientation",
    "BasePosition",
    "CentroidalAngularMomentum",
    "Com",
    "ConstantForce",
    "ContactForce",
    "FrameOrientation",
    "FramePose",
    "FramePosition",
    "FreeMotion",
    "JointTorqueRegularisation",
    "Posture",
    "PropellerRegularisation",
    "RelativePose",
    "ThrustRegularisation",
]
