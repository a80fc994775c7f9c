"""MuJoCo beside wbqp: the same mechanics in both directions, walls and rotors as they are meant, and an experiment."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import wbqp

mujoco = pytest.importorskip("mujoco")

import wbqp.mujoco as bridge  # noqa: E402

OBJ = mujoco.mjtObj


def couplings(model: mujoco.MjModel, data: mujoco.MjData, G: np.ndarray) -> np.ndarray:
    """Puts joints that follow others where they belong, and adds their rows to ``qvel = G v``."""
    for equality in range(model.neq):
        first, second = int(model.eq_obj1id[equality]), int(model.eq_obj2id[equality])
        a = model.eq_data[equality, :2]
        at, to = model.jnt_qposadr[first], model.jnt_qposadr[second]
        if second < 0:
            data.qpos[at] = model.qpos0[at] + a[0]
            continue
        data.qpos[at] = model.qpos0[at] + a[0] + a[1] * (data.qpos[to] - model.qpos0[to])
        G[model.jnt_dofadr[first]] = a[1] * G[model.jnt_dofadr[second]]
    return G


def assert_same_mechanics(model: mujoco.MjModel, robot: wbqp.Robot, frames: dict[str, str] | None = None) -> None:
    """M (projected where joints are coupled), h and Jacobians of sites at random states, relative to the largest."""
    rng = np.random.default_rng(7)
    data = mujoco.MjData(model)
    state = bridge.State(model, robot)
    dynamics = wbqp.Dynamics(robot)
    home = data.qpos.copy()
    for _ in range(5):
        data.qpos[:] = home
        position, quaternion = rng.normal(size=3), rng.normal(size=4)
        quaternion /= np.linalg.norm(quaternion)
        if robot.base == "fixed":
            position, quaternion = base_pose(model, robot)
        q, v = rng.uniform(-1.2, 1.2, len(robot.joints)), rng.normal(size=robot.nv)
        state.write(data, position, quaternion, q, v)
        G = couplings(model, data, state.velocity_map(data))
        data.qvel[:] = G @ v
        mujoco.mj_forward(model, data)
        dynamics.update(q=q, v=v, position=position, quaternion=quaternion)
        M = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, data, M)
        expected, found = G.T @ M @ G, dynamics.mass_matrix()
        assert np.abs(found - expected).max() < 1e-9 * np.abs(expected).max()
        expected, found = G.T @ data.qfrc_bias, dynamics.bias()
        assert np.abs(found - expected).max() < 1e-9 * max(np.abs(expected).max(), 1.0)
        for name, site in (frames or {}).items():
            index = mujoco.mj_name2id(model, OBJ.mjOBJ_SITE, site)
            J = np.zeros((6, model.nv))
            mujoco.mj_jacSite(model, data, J[:3], J[3:], index)
            frame = dynamics.frame(name)
            assert np.abs(frame.position - data.site_xpos[index]).max() < 1e-9
            assert np.abs(frame.rotation - data.site_xmat[index].reshape(3, 3)).max() < 1e-9
            assert np.abs(frame.J - J @ G).max() < 1e-9
        # And back: what MuJoCo has is what was put in.
        read = np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0]), np.zeros_like(q), np.zeros_like(v)
        state.read(data, *read)
        assert np.allclose(read[2], q) and np.allclose(read[3], v, atol=1e-12)


def base_pose(model: mujoco.MjModel, robot: wbqp.Robot) -> tuple[np.ndarray, np.ndarray]:
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    body = mujoco.mj_name2id(model, OBJ.mjOBJ_BODY, robot.frames[0])
    return data.xpos[max(body, 0)].copy(), data.xquat[max(body, 0)].copy()


GRIPPER = """<robot name="gripper">
  <link name="stand"/>
  <link name="arm"><inertial><origin xyz="0.1 0 0.05" rpy="0.3 0 0"/><mass value="1.2"/>
    <inertia ixx="0.01" ixy="0.001" ixz="0" iyy="0.02" iyz="0" izz="0.015"/></inertial>
    <visual><origin xyz="0.1 0 0" rpy="0 1.57 0"/><geometry><cylinder radius="0.03" length="0.2"/></geometry></visual>
  </link>
  <link name="finger"><inertial><origin xyz="0 0.02 0.01"/><mass value="0.2"/>
    <inertia ixx="1e-4" ixy="0" ixz="0" iyy="1e-4" iyz="0" izz="1e-4"/></inertial>
    <visual><geometry><box size="0.02 0.02 0.05"/></geometry></visual></link>
  <link name="thumb"><inertial><origin xyz="0 -0.02 0.01"/><mass value="0.3"/>
    <inertia ixx="1e-4" ixy="0" ixz="0" iyy="2e-4" iyz="0" izz="2e-4"/></inertial></link>
  <joint name="swing" type="revolute"><parent link="stand"/><child link="arm"/><origin xyz="0 0 1" rpy="0.2 0.1 0"/>
    <axis xyz="0 1 0.3"/><limit lower="-3" upper="3" effort="20" velocity="5"/><dynamics damping="0.3"/></joint>
  <joint name="grip" type="revolute"><parent link="arm"/><child link="finger"/><origin xyz="0.2 0.03 0"/>
    <axis xyz="0 0 1"/><limit lower="-2" upper="2" effort="3" velocity="5"/></joint>
  <joint name="close" type="prismatic"><parent link="arm"/><child link="thumb"/><origin xyz="0.2 -0.03 0"/>
    <axis xyz="0 1 0"/><limit lower="-2" upper="2" effort="3" velocity="5"/><mimic joint="grip" multiplier="-0.4" offset="0.1"/>
  </joint>
</robot>"""


@pytest.mark.parametrize("name", ["othex", "othex_vertical", "quadruped", "humanoid"])
def test_exported_robots_have_the_same_mass_matrix_and_bias(name: str) -> None:
    robot = wbqp.Robot({"type": name})
    model = mujoco.MjModel.from_xml_string(bridge.export(robot))
    assert_same_mechanics(model, robot, {robot.frames[-1]: robot.frames[-1]})


@pytest.mark.parametrize("base", ["fixed", "floating"])
def test_an_exported_arm_with_coupled_joints_has_the_same_mass_matrix_and_bias(base: str, tmp_path: Path) -> None:
    (tmp_path / "gripper.urdf").write_text(GRIPPER)
    options = {"armature": {"grip": 0.02, "close": 0.1}}
    table = {"file": str(tmp_path / "gripper.urdf"), "base": base, "options": options}
    robot = wbqp.Robot(table)
    model = mujoco.MjModel.from_xml_string(bridge.export(robot))
    assert_same_mechanics(model, robot, {"finger": "finger", "thumb": "thumb"})
    # Damping, visuals and limits are there as well, each with the joint that has it.
    joint = mujoco.mj_name2id(model, OBJ.mjOBJ_JOINT, "swing")
    assert model.dof_damping[model.jnt_dofadr[joint]] == pytest.approx(0.3)
    grip = mujoco.mj_name2id(model, OBJ.mjOBJ_JOINT, "grip")
    assert model.dof_armature[model.jnt_dofadr[grip]] == pytest.approx(0.02)
    assert model.ngeom == 2
    assert not model.geom_contype.any() and not model.geom_conaffinity.any()
    # There and back.
    again = wbqp.Robot(bridge.robot_table(model))
    assert again.joints == robot.joints and again.actuators == robot.actuators
    assert_same_mechanics(model, again, {"finger": "finger"})


FREE = "<freejoint/>"
STYLES = {
    "default classes and capsules with density": """
      <default><geom density="500"/><default class="link"><joint axis="0 1 0" damping="0.2" armature="0.01"/></default>
      </default><worldbody><body name="base" pos="0 0 1">{base}<geom type="capsule" size="0.1" fromto="0 0 0 0.3 0 0"/>
      <body name="a" childclass="link" pos="0.3 0 0"><joint name="j"/>
      <geom type="capsule" size="0.05" fromto="0 0 0 0.2 0.1 0"/><site name="tip" pos="0.2 0.1 0" euler="10 20 30"/>
      </body></body></worldbody>""",
    "fullinertia": """
      <worldbody><body name="base">{base}<inertial pos="0.1 0 0" mass="2" fullinertia="0.03 0.04 0.05 0.001 0.002 -0.003"/>
      <body name="a" pos="0 0.1 0.2"><joint name="j" axis="1 2 3"/>
      <inertial pos="0 0 0.1" mass="1" fullinertia="0.01 0.02 0.015 0.001 -0.002 0.003"/><site name="tip" pos="0 0 0.3"/>
      </body></body></worldbody>""",
    "diaginertia, quaternions": """
      <worldbody><body name="base" quat="1 2 3 4">{base}
      <inertial pos="0 0 0" quat="1 1 0 0" mass="1" diaginertia="0.01 0.02 0.025"/>
      <body name="a" pos="0.1 0 0" quat="1 0 1 0.5"><joint name="j" axis="0 0 1" pos="0.05 0.02 0"/>
      <inertial pos="0.1 0 0" quat="1 2 0 1" mass="0.5" diaginertia="0.01 0.02 0.025"/><site name="tip" pos="0.3 0 0"/>
      </body></body></worldbody>""",
    "euler in another order, degrees": """
      <compiler angle="degree" eulerseq="ZYX"/><worldbody><body name="base" euler="10 20 30">{base}
      <geom size="0.1"/><body name="a" pos="0.2 0 0" euler="30 -40 50"><joint name="j" axis="0 1 0" range="-170 170"/>
      <geom type="box" size="0.1 0.05 0.2" pos="0.1 0 0" euler="20 0 0"/><site name="tip" pos="0.3 0 0" axisangle="1 1 0 40"/>
      </body></body></worldbody>""",
    "a slide with armature": """
      <worldbody><body name="base">{base}<geom size="0.1"/><body name="a" pos="0 0 0.2">
      <joint name="j" type="slide" axis="1 0 1" armature="0.5" frictionloss="0.1"/><geom size="0.05" pos="0.1 0 0"/>
      <site name="tip" pos="0.1 0.2 0"/></body></body></worldbody>""",
    "several joints in one body": """
      <worldbody><body name="base">{base}<geom size="0.1"/><body name="a" pos="0 0 0.2" euler="0 30 0">
      <joint name="x" type="slide" axis="1 0 0"/><joint name="z" axis="0 0 1" pos="0.1 0 0"/>
      <joint name="y" axis="0 1 0" pos="0 0.1 0.05"/><geom type="ellipsoid" size="0.1 0.2 0.05" pos="0.1 0 0"/>
      <site name="tip" pos="0.1 0.2 0"/></body></body></worldbody>""",
    "positions counted from a reference": """
      <compiler angle="radian"/><worldbody><body name="base">{base}<geom size="0.1"/><body name="a" pos="0 0 0.2">
      <joint name="j" axis="0 1 0" ref="0.7" pos="0.1 0 0.1"/><geom size="0.05" pos="0.1 0 0"/>
      <body name="b" pos="0.3 0 0"><joint name="s" type="slide" axis="0 0 1" ref="-0.2"/><geom size="0.05"/>
      <site name="tip" pos="0.1 0 0"/></body></body></body></worldbody>""",
    "fixed links": """
      <worldbody><body name="base">{base}<geom size="0.1"/><body name="plate" pos="0 0 0.1" euler="10 0 0">
      <geom type="cylinder" size="0.1 0.02"/><body name="a" pos="0 0.1 0"><joint name="j" axis="0 0 1"/>
      <geom size="0.05" pos="0.1 0 0"/><body name="hand" pos="0.2 0 0"><geom type="box" size="0.02 0.03 0.04" mass="0.3"/>
      <site name="tip" pos="0.1 0 0"/></body></body></body></body></worldbody>""",
    "coupled joints": """
      <worldbody><body name="base">{base}<geom size="0.1"/><body name="a" pos="0 0 0.2">
      <joint name="j" axis="0 1 0" armature="0.1"/><geom size="0.05" pos="0.1 0 0"/><body name="b" pos="0.2 0 0">
      <joint name="k" axis="0 0 1" armature="0.02"/><geom size="0.05" pos="0.1 0 0"/><site name="tip" pos="0.1 0 0"/>
      </body></body></body></worldbody><equality><joint joint1="k" joint2="j" polycoef="0.3 -0.5 0 0 0"/></equality>""",
    "a joint that an equality holds": """
      <worldbody><body name="base">{base}<geom size="0.1"/><body name="a" pos="0 0 0.2">
      <joint name="j" axis="0 1 0"/><geom size="0.05" pos="0.1 0 0"/><body name="b" pos="0.2 0 0">
      <joint name="k" axis="0 0 1" pos="0.1 0 0"/><geom size="0.05" pos="0.1 0.1 0"/><site name="tip" pos="0.1 0 0"/>
      </body></body></body></worldbody><equality><joint joint1="k" polycoef="0.4 0 0 0 0"/></equality>""",
    "a scene around the robot, other gravity": """
      <option gravity="0.5 0 -3.7"/><worldbody><geom type="plane" size="1 1 1"/><body name="table" pos="1 0 0">
      <geom type="box" size="0.1 0.1 0.1"/></body><body name="base" pos="0 0 1">{base}<geom size="0.1"/>
      <body name="a" pos="0 0 0.2"><joint name="j" axis="0 1 0"/><geom size="0.05" pos="0.1 0 0"/>
      <site name="tip" pos="0.1 0 0"/></body></body></worldbody>""",
    "mass and inertia from a mesh, balanced": """
      <compiler balanceinertia="true" boundmass="0.1" boundinertia="0.001"/>
      <asset><mesh name="wedge" vertex="0 0 0  0.2 0 0  0 0.1 0  0 0 0.3"/></asset>
      <worldbody><body name="base">{base}<geom type="mesh" mesh="wedge"/><body name="a" pos="0 0 0.2">
      <joint name="j" axis="0 1 1"/><geom type="mesh" mesh="wedge" mass="0.2"/><site name="tip" pos="0.1 0 0"/>
      </body></body></worldbody>""",
}


@pytest.mark.parametrize("base", ["fixed", "floating"])
@pytest.mark.parametrize("style", STYLES)
def test_every_style_of_mjcf_is_the_same_robot(style: str, base: str) -> None:
    text = STYLES[style].format(base=FREE if base == "floating" else "")
    model = mujoco.MjModel.from_xml_string(f"<mujoco>{text}</mujoco>")
    robot = wbqp.Robot.from_mujoco(model)
    assert robot.base == base
    assert_same_mechanics(model, robot, {"tip": "tip"})


ACTUATED = """<mujoco><compiler autolimits="true"/><worldbody><body name="base">{base}<geom size="0.1"/><site name="r" euler="0 30 0"/>
  <body name="a" pos="0 0 0.2"><joint name="j" axis="0 1 0" range="-90 90" actuatorfrcrange="-4 3"/><geom size="0.05" pos="0.1 0 0"/>
  <body name="b" pos="0.2 0 0">{joint}<geom size="0.05" pos="0.1 0 0"/><site name="tip"/></body></body></body></worldbody>
  {more}<actuator>{actuators}</actuator></mujoco>"""


def actuated(
    actuators: str = "", *, base: str = "", joint: str = '<joint name="k" axis="0 0 1"/>', more: str = ""
) -> mujoco.MjModel:
    text = ACTUATED.format(base=base, joint=joint, actuators=actuators, more=more)
    return mujoco.MjModel.from_xml_string(text)


def test_actuators_have_their_limits_and_get_what_gives_the_effort() -> None:
    model = actuated(
        """<motor name="m" joint="j" gear="5" ctrlrange="-1 1"/>
        <position name="p" joint="k" kp="20" kv="1" forcerange="-6 7"/>
        <general name="up" site="r" gear="0 0 2 0 0 -0.1" ctrlrange="0 3" dyntype="filterexact" dynprm="0.03"/>
        <general name="side" site="r" gear="1 0 0 0.05 0 0" ctrlrange="0 3"/>""",
        base=FREE,
    )
    robot = wbqp.Robot.from_mujoco(model)
    assert robot.actuators == ["up", "side", "m", "p"]
    assert robot.effort_limits == [(0.0, 6.0), (0.0, 3.0), (-4.0, 3.0), (-6.0, 7.0)]
    data = mujoco.MjData(model)
    rng = np.random.default_rng(3)
    data.qpos[7:], data.qvel[:] = rng.normal(size=2), rng.normal(size=8)
    mujoco.mj_forward(model, data)
    actuators = bridge.Actuators(model, robot)
    effort = np.array([4.0, 1.5, 2.0, -3.0])
    actuators.write(effort, np.zeros(2), data)
    data.act[:] = data.ctrl[2]
    mujoco.mj_forward(model, data)
    # The generalised force is that of wbqp's actuation.
    state, dynamics = bridge.State(model, robot), wbqp.Dynamics(robot)
    position, quaternion, q, v = np.zeros(3), np.zeros(4), np.zeros(2), np.zeros(8)
    state.read(data, position, quaternion, q, v)
    dynamics.update(q=q, v=v, position=position, quaternion=quaternion)
    G = state.velocity_map(data)
    assert np.allclose(G.T @ data.qfrc_actuator, dynamics.actuation() @ effort, atol=1e-12)


@pytest.mark.parametrize(
    ("changes", "name"),
    [
        ({"joint": '<joint name="k" type="ball"/>'}, "'k' is a ball joint"),
        ({"more": '<tendon><fixed name="t"><joint joint="j" coef="1"/></fixed></tendon>'}, "tendon 't'"),
        ({"more": '<equality><connect name="loop" body1="b" body2="base" anchor="0 0 0"/></equality>'}, "'loop' closes a loop"),
        ({"more": '<equality><weld name="bar" body1="b" body2="base"/></equality>'}, "'bar' closes a loop"),
        ({"more": '<equality><joint name="cam" joint1="k" joint2="j" polycoef="0 1 2 0 0"/></equality>'}, "'cam' couples 'k'"),
        ({"actuators": '<muscle name="biceps" joint="j"/>'}, "'biceps' is no motor"),
        ({"actuators": '<motor name="m1" joint="j"/><motor name="m2" joint="j"/>'}, "'m1' and 'm2' drive the same joint"),
        ({"actuators": '<general name="fan" site="r" gear="0 0 1 1 0 0" ctrlrange="0 1"/>'}, "'fan': the moment"),
        ({"actuators": '<general name="fan" site="r" gear="0 0 1 0 0 0"/>'}, "'fan': a rotor needs"),
    ],
)
def test_what_a_tree_cannot_say_is_refused_by_name(changes: dict[str, str], name: str) -> None:
    with pytest.raises(bridge.UnsupportedModel, match=name):
        wbqp.Robot.from_mujoco(actuated(**changes))


def test_several_floating_bodies_need_a_word_which_is_the_robot() -> None:
    text = """<mujoco><worldbody><body name="ball"><freejoint/><geom size="0.1"/></body>
      <body name="robot"><freejoint/><geom size="0.1"/><body name="a" pos="0.2 0 0"><joint name="j"/><geom size="0.1"/>
      <site name="tip" pos="1 0 0"/></body></body></worldbody></mujoco>"""
    model = mujoco.MjModel.from_xml_string(text)
    with pytest.raises(bridge.UnsupportedModel, match="several bodies have a free joint .ball, robot."):
        wbqp.Robot.from_mujoco(model)
    robot = wbqp.Robot.from_mujoco(model, root="robot")
    assert robot.joints == ["j"] and robot.frames[0] == "robot"


SCENARIO = """name = "wall"
controller = "wall.controller.toml"
duration = 1.0
[initial]
position = [0.0, 0.0, {height}]
[plant]
[[plant.wall]]
name = "floor"
point = [0.0, 0.0, 0.0]
normal = [{lean}, 0.0, 1.0]
stiffness = 2e4
damping = 200.0
friction = 0.5
[[plant.contact_point]]
frame = "tool"
[[sensors.force_torque]]
frame = "tool"
cutoff = inf
[[case]]
name = "only"
"""


def othex_case(tmp_path: Path, *, lean: float = 0.0) -> bridge.Case:
    """The OTHex whose tool is just on the floor, with its controller of experiment B."""
    (tmp_path / "wall.controller.toml").write_text(
        '[controller]\nrate = 250.0\nhover = "unchecked"\n[robot]\ntype = "othex"\n[[task]]\ntype = "posture"\nkp = 10.0\n'
        'weight = 1.0\n[[contact]]\nname = "tip"\nframe = "tool"\nkind = "point"\nforce_min = 0.0\nforce_max = 100.0\n'
        "surface = { normal = [0.0, 0.0, 1.0], x_axis = [1.0, 0.0, 0.0] }\n"
    )
    robot = wbqp.Robot({"type": "othex"})
    dynamics = wbqp.Dynamics(robot)
    dynamics.update(position=[0.0, 0.0, 0.0])
    height = -float(dynamics.frame("tool").position[2])
    scenario = tmp_path / "wall.toml"
    scenario.write_text(SCENARIO.format(height=height, lean=lean))
    return bridge.Case(scenario, "only", tmp_path / "wall.mcap")


def test_a_wall_gives_way_by_force_over_stiffness(tmp_path: Path) -> None:
    case = othex_case(tmp_path)
    model, data = case.model, case.data
    site = mujoco.mj_name2id(model, OBJ.mjOBJ_SITE, "tool")
    data.qpos[2] -= 1e-4
    mujoco.mj_forward(model, data)
    case._observe()
    depth = -data.site_xpos[site][2]
    normal = case._contacts[0, 2]
    assert normal == pytest.approx(2e4 * depth, rel=5e-3)
    # As what the wall does to the robot: outward, and friction within its cone.
    assert normal > 1.0 and np.hypot(*case._contacts[0, :2]) <= 0.5 * normal * (1.0 + 1e-6)


def test_a_bridge_says_what_the_wall_does_in_the_contacts_axes(tmp_path: Path) -> None:
    case = othex_case(tmp_path)
    controller = wbqp.Controller(tmp_path / "wall.controller.toml")
    between = bridge.Bridge(case.model, controller)
    case.data.qpos[2] -= 1e-4
    mujoco.mj_forward(case.model, case.data)
    case._observe()
    m = controller.measurement()
    between.measure(case.data, m)
    site = mujoco.mj_name2id(case.model, OBJ.mjOBJ_SITE, "tool")
    rotation = case.data.site_xmat[site].reshape(3, 3)
    in_world = rotation @ m.wrench["tip"][:3]
    assert in_world[2] == pytest.approx(case._contacts[0, 2], rel=1e-9) and in_world[2] > 1.0
    assert np.allclose(m.position, case.data.qpos[:3])
    command, _ = controller.tick(m)
    between.apply(command, case.data)
    assert np.allclose(case.data.ctrl[:6], command.effort[:6])
    assert np.allclose(case.data.ctrl[6::2], command.joint_velocity)


def test_rotors_lag_and_servos_follow_their_reference(tmp_path: Path) -> None:
    case = othex_case(tmp_path)
    model, data = case.model, case.data
    data.qpos[2] += 10.0
    data.act[:6] = 3.0
    data.ctrl[:6] = 5.0
    data.ctrl[6::2], data.ctrl[7::2] = 0.3, 0.3
    for _ in range(100):
        case.actuators.before_step(data)
        mujoco.mj_step(model, data)
    # Rising with 12.5 ms for 12.5 ms.
    assert np.allclose(data.act[:6], 5.0 - 2.0 * np.exp(-1.0), atol=1e-6)
    for _ in range(1000):
        mujoco.mj_step(model, data)
    robot = wbqp.Robot({"type": "othex"})
    _, _, q, v = np.zeros(3), np.zeros(4), np.zeros(3), np.zeros(9)
    bridge.State(model, robot).read(data, np.zeros(3), np.zeros(4), q, v)
    assert np.allclose(v[6:], 0.3, atol=0.01)


def test_an_experiment_keeps_its_promises(tmp_path: Path) -> None:
    experiments = pytest.importorskip("wbqp.experiments")
    assert experiments.main(["--plant", "mujoco", "--only", "push_away", "--out", str(tmp_path)]) == 0
    assert (tmp_path / "mujoco.json").is_file()


@pytest.mark.parametrize(
    "actuators",
    [
        '<motor name="m" joint="j" ctrlrange="-20 20" gear="2"/><motor name="n" joint="k" ctrlrange="-20 20"/>',
        '<position name="m" joint="j" kp="80" kv="4"/><position name="n" joint="k" kp="50" kv="2"/>',
        '<velocity name="m" joint="j" kv="30"/><velocity name="n" joint="k" kv="30"/>',
    ],
    ids=["motors", "position servos", "velocity servos"],
)
def test_a_users_own_arm_reaches_its_posture(actuators: str) -> None:
    model = actuated(actuators)
    model.jnt_actfrcrange[0] = -60.0, 60.0
    # The servos are stiff for the step.
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    robot = wbqp.Robot.from_mujoco(model)
    wanted = [0.5, -0.7]
    posture = {"type": "posture", "kp": 40.0, "reference": {"type": "hold", "value": wanted}, "weight": 1.0}
    limits = {"type": "actuator_limits"}
    tables = {"tasks": [posture], "constraints": [limits], "max_first_error": {"rotation": 2.0}}
    controller = wbqp.Controller(robot=robot, rate=500.0, **tables)
    between = bridge.Bridge(model, controller)
    data = mujoco.MjData(model)
    m = controller.measurement()
    for _ in range(1000):
        between.measure(data, m)
        command, report = controller.tick(m)
        assert report.fault is None
        between.apply(command, data)
        mujoco.mj_step(model, data)
    # A velocity servo without integral has an error of its own.
    assert np.allclose(data.qpos, wanted, atol=0.05)
