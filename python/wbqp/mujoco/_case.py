"""A case of a scenario in MuJoCo: the same controller, sensors, delays, events and log, another engine."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import mujoco  # type: ignore[import-untyped, import-not-found, unused-ignore]
import numpy as np

from .._wbqp import CaseRun
from ._bridge import Actuators, State
from ._robot import INTEGRAL

_OBJ = mujoco.mjtObj

STEP = 1.25e-4
"""Integration step, s: the contact of a light arm needs it."""


class Case:
    """A case of a scenario, simulated by MuJoCo period by period.

    Parameters
    ----------
    scenario : path
        The scenario's file.
    case : str
        The name of the case.
    log : path
        The log (MCAP), with the same topics as that of ``wbqp run``.
    seed : int
        Of the sensors' noise.
    step : float
        MuJoCo's integration step, s.
    variation : str
        TOML with keys ``change.…`` for the scenario and ``set.…`` for the controller, as in a ``[[case]]``.

    Attributes
    ----------
    model, data : mujoco.MjModel, mujoco.MjData
        The world; what is changed in them before the first period is a plant that the controller does not know of.
    """

    def __init__(
        self,
        scenario: str | os.PathLike[str],
        case: str,
        log: str | os.PathLike[str],
        *,
        seed: int = 1,
        step: float = STEP,
        variation: str = "",
    ) -> None:
        Path(log).parent.mkdir(parents=True, exist_ok=True)
        self.run = CaseRun(Path(scenario), case, Path(log), seed=seed, step=step, variation=variation)
        exported = self.run.mjcf
        self.notes: list[str] = exported["notes"]
        self.model = mujoco.MjModel.from_xml_string(exported["text"])
        self.data = mujoco.MjData(self.model)
        mujoco.mj_resetDataKeyframe(self.model, self.data, 0)
        robot = self.run.robot
        self.state = State(self.model, robot)
        self.actuators = Actuators(self.model, robot)
        period = self.run.period
        self.steps = math.ceil(period / step - 1e-9)
        self.model.opt.timestep = period / self.steps
        self.periods = 0

        self._ctrl = _controls(self.model, robot.actuators)
        joints, nv = len(robot.joints), robot.nv
        self._truth = np.zeros(7 + joints + nv)
        self._views = np.split(self._truth, [3, 7, 7 + joints])
        self._walls = {self._geom(name): viscous for name, viscous in zip(exported["walls"], self.run.viscous)}
        self._point_ids = [self._geom(name) for name in exported["points"]]
        self._points = {geom: index for index, geom in enumerate(self._point_ids)}
        self._contacts = np.zeros((len(self._points), 6))
        # Without viscous friction, which MuJoCo does not know of.
        self._elastic = np.zeros((len(self._points), 3))
        self._sites = np.array([self._site(name) for name in self.run.sensor_frames], dtype=int)
        self._frames = np.zeros((len(self._sites), 12))
        self._wrench, self._velocity = np.zeros(6), np.zeros(6)
        self._is_viscous = any(self._walls.values())
        self._disturbances = [
            (self._site(frame), np.array(force), np.array(moment), start, end)
            for frame, force, moment, start, end in self.run.disturbances
        ]
        self._is_pushed = False
        self._control(self.run.due)
        mujoco.mj_forward(self.model, self.data)
        self._observe()

    def _geom(self, name: str) -> int:
        return int(mujoco.mj_name2id(self.model, _OBJ.mjOBJ_GEOM, name))

    def _site(self, name: str) -> int:
        return int(mujoco.mj_name2id(self.model, _OBJ.mjOBJ_SITE, name))

    def _control(self, due: list[float]) -> None:
        """The plant's command as it is: a mismatch of the rotors is the plant's."""
        self.data.ctrl[self._ctrl[0]] = np.array(due)[self._ctrl[1]]

    def period(self) -> bool:
        """One control period: sensors, events, tick, log, and MuJoCo's steps. ``False`` after the last one."""
        due = self.run.tick()
        if due is None:
            return False
        self._control(due)
        for _ in range(self.steps):
            self.actuators.before_step(self.data)
            self._push()
            mujoco.mj_step(self.model, self.data)
            self._observe()
        self.periods += 1
        # Sums of steps are rounded.
        self.data.time = self.periods * self.run.period
        return True

    def _push(self) -> None:
        """Disturbances, at the starts of steps, and the viscous friction of walls."""
        data = self.data
        if self._is_pushed:
            data.xfrc_applied[:] = 0.0
            self._is_pushed = False
        for site, force, moment, start, end in self._disturbances:
            if start - 1e-9 <= data.time < end - 1e-9:
                self._apply(int(self.model.site_bodyid[site]), data.site_xpos[site], force, moment)
        if self._is_viscous:
            for geom, index in self._points.items():
                force = self._contacts[index, :3] - self._elastic[index]
                if force.any():
                    self._apply(int(self.model.geom_bodyid[geom]), self._contacts[index, 3:], force, np.zeros(3))

    def _apply(self, body: int, place: np.ndarray, force: np.ndarray, moment: np.ndarray) -> None:
        wrench = self.data.xfrc_applied[body]
        wrench[:3] += force
        wrench[3:] += moment + np.cross(place - self.data.xipos[body], force)
        self._is_pushed = True

    def _observe(self) -> None:
        data = self.data
        self.state.read(data, *self._views)
        contacts = self._contacts
        contacts[:, :3] = 0.0
        self._elastic[:] = 0.0
        contacts[:, 3:] = data.geom_xpos[self._point_ids]
        if data.ncon:
            geoms = data.contact.geom
            for index in range(data.ncon):
                self._add(index, int(geoms[index, 0]), int(geoms[index, 1]))
        self._frames[:, :3] = data.site_xpos[self._sites]
        self._frames[:, 3:] = data.site_xmat[self._sites]
        self.run.observe(data.time, self._truth, contacts, self._frames)

    def _add(self, contact: int, first: int, second: int) -> None:
        """Adds a contact's force, on the point, to that point's."""
        sign, wall, point = (1.0, first, second) if second in self._points else (-1.0, second, first)
        row = self._contacts[self._points[point]]
        mujoco.mj_contactForce(self.model, self.data, contact, self._wrench)
        axes = self.data.contact.frame[contact].reshape(3, 3)
        row[:3] += sign * (self._wrench[:3] @ axes)
        row[3:] = self.data.contact.pos[contact]
        if self._is_viscous:
            self._elastic[self._points[point]] = row[:3]
            mujoco.mj_objectVelocity(self.model, self.data, _OBJ.mjOBJ_GEOM, point, self._velocity, 0)
            velocity, normal = self._velocity[3:], axes[0]
            along = velocity - (velocity @ normal) * normal
            row[:3] -= self._walls[wall] * along

    def finish(self) -> dict[str, Any]:
        """Ends the log: ``ticks``, ``held`` (commands that were no optimum), ``diverged`` (when, s) and ``why``."""
        return self.run.finish()


def _controls(model: mujoco.MjModel, actuators: list[str]) -> np.ndarray:
    """Pairs of a control and the actuator that it belongs to, shape (2, …)."""
    pairs = []
    for u, name in enumerate(actuators):
        for label in (name, name + INTEGRAL):
            index = mujoco.mj_name2id(model, _OBJ.mjOBJ_ACTUATOR, label)
            if index >= 0:
                pairs.append((index, u))
    return np.array(pairs, dtype=int).reshape(-1, 2).T


def run_case(
    scenario: str | os.PathLike[str],
    case: str,
    log: str | os.PathLike[str],
    *,
    seed: int = 1,
    step: float = STEP,
    variation: str = "",
    change: Callable[[Case], None] | None = None,
    progress: Callable[[float], None] | None = None,
) -> Mapping[str, Any]:
    """Runs a case to its end; see `Case`.

    Parameters
    ----------
    change : callable, optional
        Called with the `Case` before its first period: changes of the plant that no scenario can say.
    progress : callable, optional
        Hears the finished fraction, 0 to 1, about a hundred times.

    Returns
    -------
    mapping
        ``ticks``, ``held``, ``diverged``, ``why``.
    """
    simulation = Case(scenario, case, log, seed=seed, step=step, variation=variation)
    if change is not None:
        change(simulation)
    ticks = simulation.run.ticks
    often = max(ticks // 100, 1)
    while simulation.period():
        if progress is not None and simulation.periods % often == 0:
            progress(simulation.periods / ticks)
    return simulation.finish()
