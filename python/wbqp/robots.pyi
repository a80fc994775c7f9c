"""Made by generate_stubs.py from the registry's JSON Schema: do not edit."""

from collections.abc import Sequence
from typing import Any, Literal

from wbqp._plugins import Plugin

class Humanoid(Plugin):
    """A robot with the proportions of an adult (1.75 m, 75 kg): 31 torque-driven joints, two flat feet; the file is
    inside this crate. Home stands on z = 0.

    Parameters
    ----------
    """
    def __init__(
        self,
    ) -> None: ...

class Othex(Plugin):
    """The fully actuated OTHex with its 3-DoF arm, from files inside this crate.

    Parameters
    ----------
    thrust_max : float, optional
        Largest thrust of every rotor, N, instead of the rotor parameter file's.
    """
    def __init__(
        self,
        *,
        thrust_max: float | None = ...,
    ) -> None: ...

class OthexVertical(Plugin):
    """The under-actuated twin of `othex`, all rotors thrusting along the base's +z.

    Parameters
    ----------
    thrust_max : float, optional
        Largest thrust of every rotor, N, instead of the rotor parameter file's.
    """
    def __init__(
        self,
        *,
        thrust_max: float | None = ...,
    ) -> None: ...

class Quadruped(Plugin):
    """A quadruped with the published figures of Solo12: twelve torque-driven joints, four point feet; the file is
    inside this crate. Home stands on z = 0.

    Parameters
    ----------
    """
    def __init__(
        self,
    ) -> None: ...

class Tree(Plugin):
    """A robot as plain data, for programs that read other formats: bodies, joints, frames, motors and rotors.

    Parameters
    ----------
    body : Sequence[dict[str, Any]]
        Bodies, the base first, parents before children. One without a joint is part of its parent.
    name : str
        The robot's name.
    base : Literal['floating', 'fixed'], default "floating"
        `"floating"` or `"fixed"`.
    frame : Sequence[dict[str, Any]], optional
        Further named frames; every body is one.
    gravity : Sequence[float], default [0.0, 0.0, -9.81]
        Gravity in world axes, m/s².
    home : dict[str, Any], default {"quaternion": [1.0, 0.0, 0.0, 0.0]}
        The home posture.
    motor : Sequence[dict[str, Any]], optional
        Motors of joints; a joint without one is passive.
    rotor : Sequence[dict[str, Any]], optional
        Rotors, the first of the actuators. Their thrusts may change at any rate: there is no `slew`.
    """
    def __init__(
        self,
        *,
        body: Sequence[dict[str, Any]],
        name: str,
        base: Literal['floating', 'fixed'] | None = ...,
        frame: Sequence[dict[str, Any]] | None = ...,
        gravity: Sequence[float] | None = ...,
        home: dict[str, Any] | None = ...,
        motor: Sequence[dict[str, Any]] | None = ...,
        rotor: Sequence[dict[str, Any]] | None = ...,
    ) -> None: ...

class Urdf(Plugin):
    """Any URDF, with a rotor parameter file if it flies.

    Parameters
    ----------
    file : str
        The URDF file; relative paths count from the configuration's folder.
    base : Any, optional
        `"floating"` or `"fixed"`; as in `options`.
    home : Any, optional
        The home posture: the name of a state in the SRDF file, or positions by joint, rad or m, as in `options`.
    lock : Sequence[str], optional
        Joints that are frozen at home; as in `options`.
    options : dict[str, Any], default {"armature": {}, "base": "floating", "damping": {}, "effort": {}, "friction": {},
            "home": {}, "ignore_joint_friction": false, "inertia": {}, "lock": [], "mimic": {}, "passive": [], "range":
            {}, "servo": [], "strict": false, "velocity": {}}
        What the files do not say.
    root : str, optional
        The link that is the base; as in `options`.
    rotors : str, optional
        The rotor parameter file.
    srdf : str, optional
        An SRDF file with named postures.
    strict : bool, optional
        Refuse what the format or physics do not allow; as in `options`.
    """
    def __init__(
        self,
        *,
        file: str,
        base: Any = ...,
        home: Any = ...,
        lock: Sequence[str] | None = ...,
        options: dict[str, Any] | None = ...,
        root: str | None = ...,
        rotors: str | None = ...,
        srdf: str | None = ...,
        strict: bool | None = ...,
    ) -> None: ...

__all__ = [
    "Humanoid",
    "Othex",
    "OthexVertical",
    "Quadruped",
    "Tree",
    "Urdf",
]
