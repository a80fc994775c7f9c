"""Made by generate_stubs.py from the registry's JSON Schema: do not edit."""

from collections.abc import Sequence
from typing import Any, Literal

from wbqp._plugins import Plugin

class Contact(Plugin):
    """A contact between a frame of the robot and a surface of the world.

    Parameters
    ----------
    active : bool, default false
        Whether the contact is on at the start.
    force_max : float, default 1000.0
        Largest normal force, N.
    force_min : float, default 0.0
        Smallest normal force while on, N.
    frame : str, optional
        Frame E of the robot that touches.
    frames : Sequence[str], optional
        A contact at each of these frames, called by its frame; in place of `frame` and `name`.
    free_force : Literal['zero', 'measured'], default "zero"
        What is assumed of the force in the free directions.
    free_force_cutoff : float, default 15.0
        Cut-off of the first-order low-pass on the measured free force, Hz; `inf` for no filter.
    free_force_limit : float, default 20.0
        Clip of the measured free force, N, per axis.
    friction : float, default 0.5
        Coulomb friction coefficient that the controller assumes. [1]
    kind : Literal['full', 'point', 'normal', 'normal_tilt'], optional
        Which motions are constrained.
    motion : Literal['hard', 'soft', 'free'], optional
        How the contact's motion is kept. With this key the contact brings its own constraints, is on at the start, and
        touches the ground unless it says otherwise.
    name : str, optional
        How tasks, constraints, logs and events call it.
    offset : Sequence[float], default [0.0, 0.0, 0.0]
        Contact point in E, m.
    size : Sequence[float], optional
        Lengths of the sole along the surface's x and y, m; with `motion`. The contact is then of kind `full`.
    surface : dict[str, Any], optional
        The surface's frame.
    transition : float, default 0.0
        Duration of the ramp when it is switched on or off, s.
    """
    def __init__(
        self,
        *,
        active: bool | None = ...,
        force_max: float | None = ...,
        force_min: float | None = ...,
        frame: str | None = ...,
        frames: Sequence[str] | None = ...,
        free_force: Literal['zero', 'measured'] | None = ...,
        free_force_cutoff: float | None = ...,
        free_force_limit: float | None = ...,
        friction: float | None = ...,
        kind: Literal['full', 'point', 'normal', 'normal_tilt'] | None = ...,
        motion: Literal['hard', 'soft', 'free'] | None = ...,
        name: str | None = ...,
        offset: Sequence[float] | None = ...,
        size: Sequence[float] | None = ...,
        surface: dict[str, Any] | None = ...,
        transition: float | None = ...,
    ) -> None: ...
