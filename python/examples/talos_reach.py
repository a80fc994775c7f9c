"""Talos stands on both soles in MuJoCo and reaches forwards: ``python python/examples/talos_reach.py [film.webp]``."""

import sys

import mujoco
import numpy as np
from film import BLACK, BLUE, GREEN, RED, Film
from robots import urdf

import wbqp.mujoco

RATE, SOLES, HAND = 1000.0, ("left_sole_link", "right_sole_link"), "gripper_right_base_link"
CORNERS = [np.array([x, y, 0.0]) for x in (-0.1, 0.1) for y in (-0.06, 0.06)]  # m
REACH = [0.5, -0.05, 0.35]  # m, from where the hand is


def scene(robot: wbqp.Robot) -> str:
    """The robot on a floor that the corners of its soles touch."""
    spec = mujoco.MjSpec.from_string(wbqp.mujoco.export(robot, step=5e-4))
    spec.worldbody.add_geom(name="floor", type=mujoco.mjtGeom.mjGEOM_PLANE, size=[2, 2, 0.1], friction=[0.8, 0.0, 0.0])
    for sole in map(spec.site, SOLES):
        sole.parent.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=[0.1, 0.06, 0.001], pos=sole.pos, quat=sole.quat,
                             friction=[0.8, 0.0, 0.0], mass=0.0)
    return spec.to_xml()


def main(picture: str | None = None) -> dict[str, float]:
    """Returns the hand's error, slip of the soles, margin of the centre of mass, m, and joints beyond limits, rad."""
    tasks = wbqp.tasks
    controller = wbqp.Controller(
        rate=RATE,
        robot={"file": str(urdf("talos_reduced.urdf")), "srdf": str(urdf("talos.srdf")), "home": "half_sitting",
               # The file's friction of joints is the plant's business.
               "options": {"ignore_joint_friction": True}},
        contacts=[wbqp.Contact(frames=list(SOLES), motion="hard", size=[0.2, 0.12], friction=0.6)],
        tasks=[
            tasks.Com(kp=60.0, weight=100.0),
            tasks.BaseOrientation(kp=100.0, weight=1.0),
            tasks.FramePosition(name="hand", frame=HAND, kp=100.0, weight=100.0),
            tasks.CentroidalAngularMomentum(k=5.0, weight=1e-2),
            tasks.Posture(kp=40.0, weight=2e-2),
        ],
        constraints=[wbqp.constraints.JointLimits(), wbqp.constraints.ActuatorLimits()],
    )
    mjcf = scene(controller.robot)
    model = mujoco.MjModel.from_xml_string(mjcf)
    data = mujoco.MjData(model)
    bridge = wbqp.mujoco.Bridge(model, controller)
    m = controller.measurement()
    bridge.state.write(data, m.position, m.quaternion, m.q, m.v)
    mujoco.mj_forward(model, data)
    dynamics = wbqp.Dynamics(controller.robot)
    goal = data.site(HAND).xpos + REACH
    feet = np.array([data.site(name).xpos for name in SOLES])
    lowest, highest = np.array(controller.robot.joint_range).T
    film = Film(picture, mjcf, lookat=[-0.1, -0.15, 0.82], distance=2.8, azimuth=140.0, elevation=-14.0,
                every=0.08, dot=0.02)
    trace = []
    for k in range(int(4.0 * RATE)):
        bridge.measure(data, m)
        m.time = k / RATE
        if k == int(0.5 * RATE):
            controller.follow("hand", wbqp.references.MinJerk(to=list(goal), duration=2.0))
        command, report = controller.tick(m)
        assert report.level == "optimal", controller.explain()
        bridge.apply(command, data)
        for _ in range(round(1.0 / RATE / model.opt.timestep)):
            mujoco.mj_step(model, data)
        dynamics.update(m.q, m.v, position=m.position, quaternion=m.quaternion)
        com = dynamics.center_of_mass().copy()
        now = np.array([data.site(name).xpos for name in SOLES])
        corners = np.array([foot + corner for foot in now for corner in CORNERS])[:, :2]
        margin = np.minimum(com[:2] - corners.min(0), corners.max(0) - com[:2]).min()
        trace.append([np.linalg.norm(data.site(HAND).xpos - goal), np.abs(now - feet)[:, :2].max(), margin,
                      np.maximum(lowest - m.q, m.q - highest).max()])
        if film.due(data.time):
            draw(film, data, bridge, com, goal, trace[-1])
    film.save()
    least, most = np.min(trace, axis=0), np.max(trace, axis=0)
    return {"hand": trace[-1][0], "slip": most[1], "margin": least[2], "joints": most[3]}


def draw(film, data, bridge, com: np.ndarray, goal: np.ndarray, now: list[float]) -> None:
    """A frame with the floor's force on each sole, the centre of mass over the floor, and where the hand shall go."""
    arrows, text = [], [(f"t = {data.time:3.1f} s", BLACK), (f"hand {1e3 * now[0]:3.0f} mm from its goal", GREEN),
                        (f"centre of mass {1e3 * now[2]:.0f} mm inside", BLUE)]
    for which, name in enumerate(SOLES):
        pushes, _, places = map(np.array, zip(*bridge.contacts.forces(data, which)))
        force, place = pushes.sum(0), pushes[:, 2] @ places / pushes[:, 2].sum()
        # Beside the foot, which would hide it.
        arrows.append((place + [0.0, 0.15 - 0.3 * which, 0.0], 0.001 * force, RED))
        text.append((f"{name[:-10]} sole {force[2]:.0f} N", RED))
    film.take(data, text, arrows, [(goal, GREEN), ([*com[:2], 0.0], BLUE)])


if __name__ == "__main__":
    found = main(*sys.argv[1:])
    print(f"hand {1e3 * found['hand']:.1f} mm from its goal, soles slip {1e3 * found['slip']:.2f} mm, centre of mass"
          f" {1e3 * found['margin']:.0f} mm inside of the soles, joints {1e3 * found['joints']:.3f} mrad beyond limits")
