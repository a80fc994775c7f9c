"""A robot from a compiled MuJoCo model: MuJoCo reads the file, this reads MuJoCo's arrays."""

from __future__ import annotations

from typing import Any

import mujoco  # type: ignore[import-untyped, import-not-found, unused-ignore]
import numpy as np

_JOINT, _BODY, _SITE = mujoco.mjtObj.mjOBJ_JOINT, mujoco.mjtObj.mjOBJ_BODY, mujoco.mjtObj.mjOBJ_SITE
_FREE, _BALL = int(mujoco.mjtJoint.mjJNT_FREE), int(mujoco.mjtJoint.mjJNT_BALL)
_SLIDE = int(mujoco.mjtJoint.mjJNT_SLIDE)
_LAGS = {int(mujoco.mjtDyn.mjDYN_FILTER), int(mujoco.mjtDyn.mjDYN_FILTEREXACT)}
_NONE, _INTEGRATOR = int(mujoco.mjtDyn.mjDYN_NONE), int(mujoco.mjtDyn.mjDYN_INTEGRATOR)
_TRN = {int(kind): kind.name for kind in mujoco.mjtTrn.__members__.values()}

INTEGRAL = "_integral"
"""What is behind a joint's name in the name of the second actuator of an exported velocity servo."""


class UnsupportedModel(ValueError):
    """A MuJoCo model that cannot be a robot: ``reasons`` has everything that stands against it, by name."""

    reasons: list[str]

    def __init__(self, reasons: list[str]) -> None:
        self.reasons = list(reasons)
        super().__init__("\n".join(self.reasons))


def name_of(model: mujoco.MjModel, kind: mujoco.mjtObj, index: int) -> str:
    """The name of an object; its kind and number if it has none."""
    name = mujoco.mj_id2name(model, kind, index)
    return name or f"{kind.name.removeprefix('mjOBJ_').lower()}_{index}"


def robot_table(
    model: mujoco.MjModel, *, root: str | None = None, key: str | None = None, name: str | None = None
) -> dict[str, Any]:
    """The robot of a compiled model as plain data: a table ``[robot]`` with ``type = "tree"``.

    Parameters
    ----------
    model : mujoco.MjModel
        Compiled; every format that MuJoCo reads will do.
    root : str, optional
        The body that is the robot's base. By default the one body with a free joint, or the world if there is none.
        Joints elsewhere are no part of the robot then.
    key : str, optional
        The key frame that is the home posture: ``home`` if there is one, else ``qpos0``.
    name : str, optional
        The robot's name.

    Returns
    -------
    dict
        For ``wbqp.Robot`` or the key ``robot`` of a controller.

    Raises
    ------
    UnsupportedModel
        For closed loops, tendons, flexes, muscles, ball joints and what else a tree of hinges and slides with linear
        couplings, motors and rotors cannot say; everything by name, at once.
    """
    return _Reader(model, root, key, name).table()


class _Reader:
    def __init__(self, model: mujoco.MjModel, root: str | None, key: str | None, name: str | None) -> None:
        self.model = model
        self.reasons: list[str] = []
        self.base = self._base(root)
        self.qpos = self._home(key)
        self.bodies = self._subtree()
        self.followers: dict[int, dict[str, Any]] = {}
        self.locked: dict[int, float] = {}
        self.name = name or self._model_name()

    def _model_name(self) -> str:
        text = bytes(self.model.names).split(b"\0", 1)[0].decode(errors="replace")
        return text or "robot"

    def refuse(self, reason: str) -> None:
        self.reasons.append(reason)

    def body_name(self, body: int) -> str:
        return name_of(self.model, _BODY, body)

    def joint_name(self, joint: int) -> str:
        return name_of(self.model, _JOINT, joint)

    def joints_of(self, body: int) -> range:
        first = int(self.model.body_jntadr[body])
        return range(first, first + int(self.model.body_jntnum[body])) if first >= 0 else range(0)

    def _base(self, root: str | None) -> int:
        model = self.model
        if root is not None:
            body = int(mujoco.mj_name2id(model, _BODY, root))
            if body < 0:
                raise UnsupportedModel([f"root: there is no body {root!r}"])
            return body
        free = [b for b in range(model.nbody) if any(model.jnt_type[j] == _FREE for j in self.joints_of(b))]
        if len(free) > 1:
            names = ", ".join(map(self.body_name, free))
            raise UnsupportedModel([f"several bodies have a free joint ({names}): say which is the base, root=…"])
        if free:
            inside = {b for b in range(model.nbody) if model.body_rootid[b] == free[0]}
            for joint in range(model.njnt):
                if int(model.jnt_bodyid[joint]) not in inside:
                    self.refuse(
                        f"joint {self.joint_name(joint)!r} is not on the floating robot: "
                        f"say that {self.body_name(free[0])!r} is the base, root=…"
                    )
        return free[0] if free else 0

    def _home(self, key: str | None) -> np.ndarray:
        model = self.model
        wanted = "home" if key is None else key
        index = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_KEY, wanted)
        if index < 0:
            if key is not None:
                raise UnsupportedModel([f"key: there is no key frame {key!r}"])
            return np.array(model.qpos0)
        return np.array(model.key_qpos[index])

    def _subtree(self) -> list[int]:
        model = self.model
        inside = {self.base}
        # Bodies come after their parents.
        for body in range(self.base + 1, model.nbody):
            if int(model.body_parentid[body]) in inside:
                inside.add(body)
        return sorted(inside)

    # What a tree cannot say.

    def _check(self) -> None:
        model = self.model
        for tendon in range(model.ntendon):
            self.refuse(f"tendon {name_of(model, mujoco.mjtObj.mjOBJ_TENDON, tendon)!r}: there are no tendons here")
        for flex in range(model.nflex):
            self.refuse(f"flex {name_of(model, mujoco.mjtObj.mjOBJ_FLEX, flex)!r}: bodies are rigid here")
        for body in self.bodies:
            for joint in self.joints_of(body):
                kind = int(model.jnt_type[joint])
                if kind == _BALL:
                    self.refuse(f"joint {self.joint_name(joint)!r} is a ball joint: write it as three hinges")
                if kind == _FREE and body != self.base:
                    self.refuse(f"joint {self.joint_name(joint)!r} is free inside the robot")
        for equality in range(model.neq):
            if model.eq_active0[equality]:
                self._equality(equality)

    def _equality(self, equality: int) -> None:
        model = self.model
        kind = mujoco.mjtEq(int(model.eq_type[equality]))
        label = name_of(model, mujoco.mjtObj.mjOBJ_EQUALITY, equality)
        first, second = int(model.eq_obj1id[equality]), int(model.eq_obj2id[equality])
        if kind in (mujoco.mjtEq.mjEQ_CONNECT, mujoco.mjtEq.mjEQ_WELD):
            if int(model.eq_objtype[equality]) == int(_SITE):
                touched = [int(model.site_bodyid[first]), int(model.site_bodyid[second])]
            else:
                touched = [first, second]
            if any(body in self.bodies for body in touched):
                names = " and ".join(map(self.body_name, touched))
                self.refuse(f"equality {label!r} closes a loop between {names}: a robot is a tree")
            return
        if kind != mujoco.mjtEq.mjEQ_JOINT:
            self.refuse(f"equality {label!r} is no coupling of joints")
            return
        if int(model.jnt_bodyid[first]) not in self.bodies:
            return
        a = model.eq_data[equality, :5]
        at = float(model.qpos0[model.jnt_qposadr[first]])
        if second < 0 or not np.any(a[1:]):
            self.locked[first] = at + float(a[0])
        elif np.any(a[2:]):
            self.refuse(f"equality {label!r} couples {self.joint_name(first)!r} by a curve: only a line is possible")
        else:
            other = float(model.qpos0[model.jnt_qposadr[second]])
            self.followers[first] = {
                "joint": self.joint_name(second),
                "multiplier": float(a[1]),
                "offset": at + float(a[0]) - float(a[1]) * other,
            }

    # Bodies.

    def _body_entries(self) -> list[dict[str, Any]]:
        entries: list[dict[str, Any]] = []
        for body in self.bodies:
            entry: dict[str, Any] = {"name": self.body_name(body), **self._inertia(body)}
            if body == self.base:
                entries.append(entry)
                if body != 0:
                    for joint in self.joints_of(body):
                        if int(self.model.jnt_type[joint]) != _FREE:
                            self.refuse(
                                f"joint {self.joint_name(joint)!r} moves the base {self.body_name(body)!r}: "
                                "make the body that carries it the base, root=…"
                            )
                continue
            parent = self.body_name(int(self.model.body_parentid[body]))
            pose = (self.model.body_pos[body].copy(), self.model.body_quat[body].copy())
            joints = list(self.joints_of(body))
            # Several joints of one body: bodies without mass between them.
            for joint in joints[:-1]:
                between = f"{entry['name']}.{self.joint_name(joint)}"
                entries.append(self._on_joint({"name": between}, joint, parent, pose))
                parent, pose = between, (np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0]))
            if joints:
                entries.append(self._on_joint(entry, joints[-1], parent, pose))
            else:
                entries.append({**entry, "parent": parent, **_pose(*pose)})
        return entries

    def _inertia(self, body: int) -> dict[str, Any]:
        model = self.model
        mass = float(model.body_mass[body])
        if body == 0 or mass == 0.0:
            return {}
        rotation = np.zeros(9)
        mujoco.mju_quat2Mat(rotation, model.body_iquat[body])
        axes = rotation.reshape(3, 3)
        tensor = (axes * model.body_inertia[body]) @ axes.T
        return {
            "mass": mass,
            "com": model.body_ipos[body].tolist(),
            "moments": np.diag(tensor).tolist(),
            "products": [float(tensor[0, 1]), float(tensor[0, 2]), float(tensor[1, 2])],
        }

    def _on_joint(
        self, entry: dict[str, Any], joint: int, parent: str, pose: tuple[np.ndarray, np.ndarray]
    ) -> dict[str, Any]:
        model = self.model
        axis, anchor = model.jnt_axis[joint], model.jnt_pos[joint]
        qpos, dof = int(model.jnt_qposadr[joint]), int(model.jnt_dofadr[joint])
        is_slide = int(model.jnt_type[joint]) == _SLIDE
        locked = self.locked.get(joint)
        # MuJoCo counts from qpos0, this robot from zero; a locked joint stays where it is.
        shift = -float(model.qpos0[qpos]) + (0.0 if locked is None else locked)
        moved = _moved(pose, is_slide, axis, anchor, shift)
        placed = {**entry, "parent": parent, **_pose(*moved)}
        if locked is not None:
            return placed
        table: dict[str, Any] = {
            "name": self.joint_name(joint),
            "type": "prismatic" if is_slide else "revolute",
            "axis": axis.tolist(),
            "anchor": anchor.tolist(),
            "armature": float(model.dof_armature[dof]),
            "damping": float(model.dof_damping[dof]),
            "friction": float(model.dof_frictionloss[dof]),
        }
        if model.jnt_limited[joint]:
            table["range"] = model.jnt_range[joint].tolist()
        if model.jnt_actfrclimited[joint]:
            table["effort"] = float(np.abs(model.jnt_actfrcrange[joint]).max())
        if joint in self.followers:
            table["follows"] = self.followers[joint]
        return {**placed, "joint": table}

    def _frames(self) -> list[dict[str, Any]]:
        model = self.model
        names = {self.body_name(body) for body in self.bodies}
        frames = []
        for site in range(model.nsite):
            body = int(model.site_bodyid[site])
            if body not in self.bodies:
                continue
            name = name_of(model, _SITE, site)
            if name == self.body_name(body) and _is_identity(model.site_pos[site], model.site_quat[site]):
                continue
            if name in names:
                name += ".site"
            names.add(name)
            pose = _pose(model.site_pos[site], model.site_quat[site])
            frames.append({"name": name, "body": self.body_name(body), **pose})
        return frames

    # Actuators.

    def _actuators(self, frames: list[dict[str, Any]]) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
        model = self.model
        rotors: list[dict[str, Any]] = []
        motors: list[dict[str, Any]] = []
        driven: dict[str, str] = {}
        for index in range(model.nu):
            label = name_of(model, mujoco.mjtObj.mjOBJ_ACTUATOR, index)
            kind = int(model.actuator_trntype[index])
            gain, bias = int(model.actuator_gaintype[index]), int(model.actuator_biastype[index])
            dynamics = int(model.actuator_dyntype[index])
            target = int(model.actuator_trnid[index, 0])
            is_plain = gain == int(mujoco.mjtGain.mjGAIN_FIXED) and bias in (
                int(mujoco.mjtBias.mjBIAS_NONE),
                int(mujoco.mjtBias.mjBIAS_AFFINE),
            )
            if kind in (int(mujoco.mjtTrn.mjTRN_JOINT), int(mujoco.mjtTrn.mjTRN_JOINTINPARENT)):
                if int(model.jnt_bodyid[target]) not in self.bodies:
                    continue
                joint = self.joint_name(target)
                if label == f"{driven.get(joint)}{INTEGRAL}":
                    # The second half of an exported velocity servo.
                    continue
                if not is_plain or dynamics not in (*_LAGS, _NONE, _INTEGRATOR):
                    self.refuse(f"actuator {label!r} is no motor: muscles and the like are not possible")
                elif target in self.followers or target in self.locked:
                    self.refuse(f"actuator {label!r} drives joint {joint!r}, which has no motion of its own")
                elif joint in driven:
                    self.refuse(f"actuators {driven[joint]!r} and {label!r} drive the same joint {joint!r}")
                else:
                    driven[joint] = label
                    motors.append(self._motor(index, label, target))
            elif kind == int(mujoco.mjtTrn.mjTRN_SITE):
                if int(model.site_bodyid[target]) not in self.bodies:
                    continue
                if not is_plain or dynamics not in (*_LAGS, _NONE) or bias != int(mujoco.mjtBias.mjBIAS_NONE):
                    self.refuse(f"actuator {label!r} is no rotor: its force must be proportional to its control")
                else:
                    self._rotor(index, label, target, frames, rotors)
            else:
                transmission = _TRN.get(kind, "mjTRN_?").removeprefix("mjTRN_").lower()
                self.refuse(f"actuator {label!r} acts through {transmission}: only joints and sites are possible")
        return rotors, motors

    def _motor(self, index: int, label: str, joint: int) -> dict[str, Any]:
        model = self.model
        gear, gain = float(model.actuator_gear[index, 0]), float(model.actuator_gainprm[index, 0])
        has_bias = int(model.actuator_biastype[index]) == int(mujoco.mjtBias.mjBIAS_AFFINE)
        lower, upper = -np.inf, np.inf
        if model.actuator_ctrllimited[index] and not has_bias:
            lower, upper = sorted(gain * model.actuator_ctrlrange[index])
        if model.actuator_forcelimited[index]:
            lower = max(lower, float(model.actuator_forcerange[index, 0]))
            upper = min(upper, float(model.actuator_forcerange[index, 1]))
        lower, upper = sorted((gear * lower, gear * upper)) if gear else (0.0, 0.0)
        if model.jnt_actfrclimited[joint]:
            lower = max(lower, float(model.jnt_actfrcrange[joint, 0]))
            upper = min(upper, float(model.jnt_actfrcrange[joint, 1]))
        return {
            "name": label,
            "joint": self.joint_name(joint),
            "limits": [float(lower), float(upper)],
            "drive": "velocity" if is_velocity_servo(model, index) else "torque",
        }

    def _rotor(
        self, index: int, label: str, site: int, frames: list[dict[str, Any]], rotors: list[dict[str, Any]]
    ) -> None:
        model = self.model
        gain = float(model.actuator_gainprm[index, 0])
        force, moment = gain * model.actuator_gear[index, :3], gain * model.actuator_gear[index, 3:]
        strength = float(np.linalg.norm(force))
        if strength == 0.0 or not model.actuator_ctrllimited[index] or int(model.actuator_trnid[index, 1]) >= 0:
            self.refuse(f"actuator {label!r}: a rotor needs a force along its site's axes, and limits of its control")
            return
        direction = force / strength
        coefficient = float(direction @ moment) / strength
        if np.linalg.norm(moment - coefficient * force) > 1e-9 * strength:
            self.refuse(f"actuator {label!r}: the moment of a rotor is along its thrust")
            return
        body = int(model.site_bodyid[site])
        quaternion = np.zeros(4)
        mujoco.mju_quatZ2Vec(quaternion, direction)
        turned = np.zeros(4)
        mujoco.mju_mulQuat(turned, model.site_quat[site], quaternion)
        names = {frame["name"] for frame in frames} | {self.body_name(b) for b in self.bodies}
        name = name_of(model, _SITE, site)
        if name not in names or not np.allclose(quaternion, [1.0, 0.0, 0.0, 0.0]):
            name = f"{label}.thrust"
            frames.append({"name": name, "body": self.body_name(body), **_pose(model.site_pos[site], turned)})
        rotor = {
            "name": label,
            "frame": name,
            "thrust": (strength * model.actuator_ctrlrange[index]).tolist(),
            "moment": coefficient,
        }
        if int(model.actuator_dyntype[index]) in _LAGS:
            lag = float(model.actuator_dynprm[index, 0])
            rise_and_fall = model.actuator_user[index, :2] if model.nuser_actuator >= 2 else np.zeros(2)
            is_given = bool(np.all(rise_and_fall > 0.0))
            rotor["time_constant"] = rise_and_fall.tolist() if is_given else [lag, lag]
        rotors.append(rotor)

    def table(self) -> dict[str, Any]:
        model = self.model
        self._check()
        frames = self._frames()
        bodies = self._body_entries()
        rotors, motors = self._actuators(frames)
        if self.reasons:
            raise UnsupportedModel(self.reasons)
        joints = {}
        for body in self.bodies:
            for joint in self.joints_of(body):
                if int(model.jnt_type[joint]) != _FREE and joint not in self.locked and joint not in self.followers:
                    joints[self.joint_name(joint)] = float(self.qpos[model.jnt_qposadr[joint]])
        is_floating = any(int(model.jnt_type[j]) == _FREE for j in self.joints_of(self.base))
        if is_floating:
            at = int(model.jnt_qposadr[self.joints_of(self.base)[0]])
            position, quaternion = self.qpos[at : at + 3], self.qpos[at + 3 : at + 7]
        else:
            data = mujoco.MjData(model)
            data.qpos[:] = self.qpos
            mujoco.mj_kinematics(model, data)
            position, quaternion = data.xpos[self.base], data.xquat[self.base]
        table = {
            "type": "tree",
            "name": self.name,
            "base": "floating" if is_floating else "fixed",
            "gravity": model.opt.gravity.tolist(),
            "body": bodies,
            "home": {"position": position.tolist(), "quaternion": quaternion.tolist(), "joints": joints},
        }
        for key, entries in (("frame", frames), ("rotor", rotors), ("motor", motors)):
            if entries:
                table[key] = entries
        return table


def is_velocity_servo(model: mujoco.MjModel, index: int) -> bool:
    """Whether an actuator takes a velocity: MuJoCo's ``velocity`` and ``intvelocity``, and exported servos."""
    label = name_of(model, mujoco.mjtObj.mjOBJ_ACTUATOR, index)
    if mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_ACTUATOR, label + INTEGRAL) >= 0:
        return True
    gain, bias = float(model.actuator_gainprm[index, 0]), model.actuator_biasprm[index]
    if int(model.actuator_biastype[index]) != int(mujoco.mjtBias.mjBIAS_AFFINE):
        return False
    if int(model.actuator_dyntype[index]) == _INTEGRATOR:
        return True
    return bool(gain > 0.0 and bias[1] == 0.0 and np.isclose(bias[2], -gain))


def _pose(position: np.ndarray, quaternion: np.ndarray) -> dict[str, Any]:
    return {"position": np.asarray(position).tolist(), "quaternion": np.asarray(quaternion).tolist()}


def _is_identity(position: np.ndarray, quaternion: np.ndarray) -> bool:
    return not np.any(position) and bool(quaternion[0] == 1.0)


def _moved(
    pose: tuple[np.ndarray, np.ndarray], is_slide: bool, axis: np.ndarray, anchor: np.ndarray, by: float
) -> tuple[np.ndarray, np.ndarray]:
    """A pose after a motion of the joint that is in it."""
    position, quaternion = pose
    if by == 0.0:
        return pose
    turn = np.array([1.0, 0.0, 0.0, 0.0])
    step = by * axis
    if not is_slide:
        mujoco.mju_axisAngle2Quat(turn, axis, by)
        turned = np.zeros(3)
        mujoco.mju_rotVecQuat(turned, anchor, turn)
        step = anchor - turned
    moved = np.zeros(3)
    mujoco.mju_rotVecQuat(moved, step, quaternion)
    product = np.zeros(4)
    mujoco.mju_mulQuat(product, quaternion, turn)
    return position + moved, product
