"""MuJoCo's state as a measurement, a command as ``ctrl``."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import mujoco  # type: ignore[import-untyped, import-not-found, unused-ignore]
import numpy as np

from ._robot import INTEGRAL, UnsupportedModel, is_velocity_servo

if TYPE_CHECKING:
    from .. import Command, Controller, Measurement, Robot

_OBJ = mujoco.mjtObj
_FREE = int(mujoco.mjtJoint.mjJNT_FREE)


class State:
    """Where a robot's base, joints and velocities are in the arrays of a MuJoCo model.

    Parameters
    ----------
    model : mujoco.MjModel
        Compiled.
    robot : wbqp.Robot
        Its joints have the names of the model's; a floating base is the body with the name of its first frame.

    Notes
    -----
    A free joint's angular velocity is in the body's axes in MuJoCo and in the world's axes here.
    """

    def __init__(self, model: mujoco.MjModel, robot: Robot) -> None:
        self.model = model
        reasons = []
        joints = []
        for name in robot.joints:
            joint = mujoco.mj_name2id(model, _OBJ.mjOBJ_JOINT, name)
            if joint < 0:
                reasons.append(f"the model has no joint {name!r}")
            joints.append(joint)
        self.free: tuple[int, int] | None = None
        if robot.base == "floating":
            name = robot.frames[0]
            body = mujoco.mj_name2id(model, _OBJ.mjOBJ_BODY, name)
            first = int(model.body_jntadr[body]) if body >= 0 else -1
            if first < 0 or int(model.jnt_type[first]) != _FREE:
                reasons.append(f"the model has no body {name!r} with a free joint: the robot's base floats")
            else:
                self.free = (int(model.jnt_qposadr[first]), int(model.jnt_dofadr[first]))
        if reasons:
            raise UnsupportedModel(reasons)
        self.joints = np.array(joints, dtype=int)
        self.qpos = model.jnt_qposadr[self.joints].astype(int)
        self.dofs = model.jnt_dofadr[self.joints].astype(int)
        self._turned = np.zeros(3)
        self._inverse = np.zeros(4)

    @property
    def offset(self) -> int:
        """Where the joints begin in ``v``."""
        return 6 if self.free else 0

    def read(
        self,
        data: mujoco.MjData,
        position: np.ndarray,
        quaternion: np.ndarray,
        q: np.ndarray,
        v: np.ndarray,
    ) -> None:
        """Writes MuJoCo's state into arrays: base position (3,) m, quaternion (4,) w-x-y-z, q (joints,), v (nv,)."""
        if self.free:
            at, dof = self.free
            position[:] = data.qpos[at : at + 3]
            quaternion[:] = data.qpos[at + 3 : at + 7]
            v[:3] = data.qvel[dof : dof + 3]
            mujoco.mju_rotVecQuat(self._turned, data.qvel[dof + 3 : dof + 6], data.qpos[at + 3 : at + 7])
            v[3:6] = self._turned
        q[:] = data.qpos[self.qpos]
        v[self.offset :] = data.qvel[self.dofs]

    def write(
        self,
        data: mujoco.MjData,
        position: np.ndarray,
        quaternion: np.ndarray,
        q: np.ndarray,
        v: np.ndarray,
    ) -> None:
        """The opposite of ``read``. Joints that follow others are not moved."""
        if self.free:
            at, dof = self.free
            data.qpos[at : at + 3] = position
            data.qpos[at + 3 : at + 7] = quaternion
            data.qvel[dof : dof + 3] = v[:3]
            mujoco.mju_negQuat(self._inverse, np.asarray(quaternion, dtype=float))
            mujoco.mju_rotVecQuat(self._turned, np.asarray(v[3:6], dtype=float), self._inverse)
            data.qvel[dof + 3 : dof + 6] = self._turned
        data.qpos[self.qpos] = q
        data.qvel[self.dofs] = v[self.offset :]

    def velocity_map(self, data: mujoco.MjData) -> np.ndarray:
        """``G``, shape (model.nv, nv): ``qvel = G v`` at the present pose.

        Without the rows of joints that follow others: those are the caller's, who knows the couplings.
        """
        G = np.zeros((self.model.nv, self.offset + len(self.dofs)))
        if self.free:
            at, dof = self.free
            rotation = np.zeros(9)
            mujoco.mju_quat2Mat(rotation, data.qpos[at + 3 : at + 7])
            G[dof : dof + 3, :3] = np.eye(3)
            G[dof + 3 : dof + 6, 3:6] = rotation.reshape(3, 3).T
        G[self.dofs, self.offset + np.arange(len(self.dofs))] = 1.0
        return G


class Contacts:
    """Contact forces of a MuJoCo model, as those of the environment on chosen bodies.

    Parameters
    ----------
    model : mujoco.MjModel
        Compiled.
    bodies : sequence of int
        The bodies whose contacts count, each with itself and what is fixed to it.
    """

    def __init__(self, model: mujoco.MjModel, bodies: list[int]) -> None:
        self.model = model
        self.bodies = [int(model.body_weldid[body]) for body in bodies]
        geoms = model.body_weldid[model.geom_bodyid]
        self.of_geom = [np.flatnonzero(geoms == body) for body in self.bodies]
        self._is_of = [np.isin(np.arange(model.ngeom), own) for own in self.of_geom]
        self._wrench = np.zeros(6)

    def forces(self, data: mujoco.MjData, which: int) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
        """Force (3,) N, moment (3,) N·m and place (3,) m of each contact of a body; on the body, world axes."""
        found: list[tuple[np.ndarray, np.ndarray, np.ndarray]] = []
        if data.ncon == 0:
            return found
        is_of = self._is_of[which]
        geoms = data.contact.geom
        for index in range(data.ncon):
            first, second = is_of[geoms[index, 0]], is_of[geoms[index, 1]]
            # Between two geoms of one body there is no force from outside.
            if first == second:
                continue
            mujoco.mj_contactForce(self.model, data, index, self._wrench)
            # The frame's first axis goes from the first geom to the second; so does the force on the second.
            axes = data.contact.frame[index].reshape(3, 3)
            sign = 1.0 if second else -1.0
            force, moment = sign * (self._wrench[:3] @ axes), sign * (self._wrench[3:] @ axes)
            found.append((force, moment, data.contact.pos[index].copy()))
        return found


class Bridge:
    """Between a controller and a MuJoCo model: MuJoCo's state becomes a measurement, a command becomes ``ctrl``.

    Parameters
    ----------
    model : mujoco.MjModel
        An exported model, a robot's own MJCF, or a scene with the robot in it.
    controller : wbqp.Controller
        Its robot's joints and actuators have the names of the model's.
    frames : mapping of str to str, optional
        By contact of the controller, the site or body of the model at which its wrench is measured; the one with the
        name of the contact's frame if not given.

    Examples
    --------
    >>> bridge = wbqp.mujoco.Bridge(model, controller)          # doctest: +SKIP
    >>> m = controller.measurement()                            # doctest: +SKIP
    >>> bridge.measure(data, m)                                 # doctest: +SKIP
    >>> command, report = controller.tick(m)                    # doctest: +SKIP
    >>> bridge.apply(command, data)                             # doctest: +SKIP
    """

    def __init__(
        self, model: mujoco.MjModel, controller: Controller, *, frames: Mapping[str, str] | None = None
    ) -> None:
        self.model = model
        robot = controller.robot
        self.state = State(model, robot)
        self.actuators = Actuators(model, robot)
        self._sites: list[tuple[str, bool, int]] = []
        reasons = []
        for contact, frame in controller.contact_frames.items():
            wanted = (frames or {}).get(contact, frame)
            site = mujoco.mj_name2id(model, _OBJ.mjOBJ_SITE, wanted)
            body = mujoco.mj_name2id(model, _OBJ.mjOBJ_BODY, wanted)
            if site < 0 and body < 0:
                reasons.append(f"contact {contact!r}: the model has neither a site nor a body {wanted!r}: frames=…")
            self._sites.append((contact, site >= 0, site if site >= 0 else body))
        if reasons:
            raise UnsupportedModel(reasons)
        bodies = [int(model.site_bodyid[at]) if is_site else at for _, is_site, at in self._sites]
        self.contacts = Contacts(model, bodies)

    def measure(self, data: mujoco.MjData, measurement: Measurement) -> None:
        """Writes time, state and the wrench at each contact into a measurement.

        The wrench is what all other bodies do to the one that carries the contact, in the axes of its frame and about
        its origin: that of the forces of ``data``, so of its last step.
        """
        measurement.time = data.time
        self.state.read(data, measurement.position, measurement.quaternion, measurement.q, measurement.v)
        for index, (contact, is_site, at) in enumerate(self._sites):
            position = data.site_xpos[at] if is_site else data.xpos[at]
            rotation = (data.site_xmat[at] if is_site else data.xmat[at]).reshape(3, 3)
            force, moment = np.zeros(3), np.zeros(3)
            for f, m, place in self.contacts.forces(data, index):
                force += f
                moment += m + np.cross(place - position, f)
            wrench = measurement.wrench[contact]
            wrench[:3] = rotation.T @ force
            wrench[3:] = rotation.T @ moment

    def apply(self, command: Command, data: mujoco.MjData) -> None:
        """Writes a command into ``data.ctrl``."""
        self.actuators.write(command.effort, command.joint_velocity, data)


class Actuators:
    """How a robot's efforts and joint velocities become the controls of a MuJoCo model.

    A rotor's or motor's control is what gives the effort, whatever gear, gain and bias the actuator has: a position
    servo gives it at the time of the command. A velocity servo gets the joint's velocity.
    """

    def __init__(self, model: mujoco.MjModel, robot: Robot) -> None:
        self.model = model
        reasons = []
        servoed, joints = set(robot.servoed_joints), list(robot.joints)
        efforts: list[tuple[int, int]] = []
        velocities: list[tuple[int, int]] = []
        for u, name in enumerate(robot.actuators):
            index = mujoco.mj_name2id(model, _OBJ.mjOBJ_ACTUATOR, name)
            if index < 0:
                reasons.append(f"the model has no actuator {name!r}")
            elif name in servoed:
                joint = mujoco.mj_id2name(model, _OBJ.mjOBJ_JOINT, int(model.actuator_trnid[index, 0]))
                if not is_velocity_servo(model, index):
                    reasons.append(f"actuator {name!r} of the model is no velocity servo, the robot's is")
                    continue
                velocities.append((joints.index(joint), index))
                second = mujoco.mj_name2id(model, _OBJ.mjOBJ_ACTUATOR, name + INTEGRAL)
                if second >= 0:
                    velocities.append((joints.index(joint), second))
            else:
                efforts.append((u, index))
        if reasons:
            raise UnsupportedModel(reasons)
        self._from_effort, self._to_effort = _columns(efforts)
        self._from_velocity, self._to_velocity = _columns(velocities)
        to = self._to_effort
        site = model.actuator_trntype[to] == int(mujoco.mjtTrn.mjTRN_SITE)
        gear = np.where(site, np.linalg.norm(model.actuator_gear[to, :3], axis=1), model.actuator_gear[to, 0])
        gain = model.actuator_gainprm[to, 0].copy()
        self._gain = gain
        affine = model.actuator_biastype[to] == int(mujoco.mjtBias.mjBIAS_AFFINE)
        self._bias = np.where(affine[:, None], model.actuator_biasprm[to, :3], 0.0)
        self._has_bias = bool(np.any(self._bias))
        # Rotors of an exported model, whose lag differs between rise and fall.
        lag = np.zeros((model.nu, 2))
        if model.nuser_actuator >= 2:
            lag = model.actuator_user[:, :2].copy()
        self._lagging = np.flatnonzero(
            (model.actuator_dyntype == int(mujoco.mjtDyn.mjDYN_FILTEREXACT)) & np.all(lag > 0.0, axis=1)
        )
        # What they produce beside what is commanded is a mismatch of the plant's: nobody knows of it.
        is_exported = np.isin(to, self._lagging)
        self._scale = np.where(is_exported, 1.0, gear * gain)
        self._rise, self._fall = lag[self._lagging, 0], lag[self._lagging, 1]
        self._act = model.actuator_actadr[self._lagging].astype(int)
        self._range = model.actuator_ctrlrange[self._lagging].copy()

    def write(self, effort: np.ndarray, joint_velocity: np.ndarray, data: mujoco.MjData) -> None:
        """Writes efforts (nu,) and velocities of servoed joints (joints,) into ``data.ctrl``."""
        force = np.asarray(effort)[self._from_effort] / self._scale
        if self._has_bias:
            to = self._to_effort
            bias = self._bias[:, 0] + self._bias[:, 1] * data.actuator_length[to]
            bias += self._bias[:, 2] * data.actuator_velocity[to]
            force -= bias / self._gain
        data.ctrl[self._to_effort] = force
        data.ctrl[self._to_velocity] = np.asarray(joint_velocity)[self._from_velocity]

    def settle(self, data: mujoco.MjData) -> None:
        """Puts rotors where their controls, held for long, would have brought them."""
        clamped = np.clip(data.ctrl[self._lagging], self._range[:, 0], self._range[:, 1])
        data.act[self._act] = clamped

    def before_step(self, data: mujoco.MjData) -> None:
        """Gives rotors of an exported model the lag of a rising or a falling thrust: MuJoCo has one for both."""
        rising = np.minimum(data.ctrl[self._lagging], self._range[:, 1]) > data.act[self._act]
        self.model.actuator_dynprm[self._lagging, 0] = np.where(rising, self._rise, self._fall)


def _columns(pairs: list[tuple[int, int]]) -> tuple[np.ndarray, np.ndarray]:
    table = np.array(pairs, dtype=int).reshape(-1, 2)
    return table[:, 0], table[:, 1]
