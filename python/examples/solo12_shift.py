"""Solo12 stands, shifts its weight and lifts a foot: ``python python/examples/solo12_shift.py [film.webp]``."""

import sys

import mujoco
import numpy as np
from film import BLACK, BLUE, GREY, RED, Film
from robots import urdf

import wbqp.mujoco

RATE = 1000.0  # Hz
FEET = ["FL_FOOT", "FR_FOOT", "HR_FOOT", "HL_FOOT"]  # in turn around the robot


def scene(robot: wbqp.Robot) -> str:
    """The robot on a floor that its feet touch: a sphere of 1 mm at each foot's frame."""
    spec = mujoco.MjSpec.from_string(wbqp.mujoco.export(robot, step=5e-4))
    spec.worldbody.add_geom(name="floor", type=mujoco.mjtGeom.mjGEOM_PLANE, size=[2, 2, 0.1], friction=[0.8, 0.0, 0.0])
    for foot in FEET:
        body = spec.body(foot) or spec.site(foot).parent
        at = spec.site(foot).pos if spec.site(foot) is not None else [0.0, 0.0, 0.0]
        body.add_geom(name=foot.lower(), type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[0.001, 0, 0], pos=at,
                      friction=[0.8, 0.0, 0.0], mass=0.0)
    return spec.to_xml()


def main(picture: str | None = None) -> dict[str, float]:
    """Returns the largest error of the centre of mass, m, and how high the foot was lifted, m."""
    bent = {f"{side}_{joint}": angle for side, sign in (("FL", 1), ("FR", 1), ("HL", -1), ("HR", -1))
            for joint, angle in (("HFE", 0.8 * sign), ("KFE", -1.6 * sign))}
    controller = wbqp.Controller(
        rate=RATE,
        robot={"file": str(urdf("solo12.urdf")), "home": bent},
        contacts=[wbqp.Contact(frames=FEET, motion="hard", friction=0.6, transition=0.2)],
        tasks=[
            wbqp.tasks.Com(kp=100.0, weight=100.0),
            wbqp.tasks.BaseOrientation(kp=100.0, weight=10.0),
            wbqp.tasks.FramePosition(name="lift", frame="FL_FOOT", kp=200.0, weight=10.0, active=False),
            wbqp.tasks.Posture(kp=30.0, weight=1e-2),
        ],
    )
    mjcf = scene(controller.robot)
    model = mujoco.MjModel.from_xml_string(mjcf)
    data = mujoco.MjData(model)
    bridge = wbqp.mujoco.Bridge(model, controller)
    m = controller.measurement()
    bridge.state.write(data, m.position, m.quaternion, m.q, m.v)
    mujoco.mj_forward(model, data)
    dynamics = wbqp.Dynamics(controller.robot)
    film = Film(picture, mjcf, lookat=[0.0, 0.05, 0.13], distance=0.85, azimuth=140.0, elevation=-22.0, every=0.1,
                dot=0.006)
    trace = []
    for k in range(int(6.0 * RATE)):
        bridge.measure(data, m)
        m.time = k / RATE
        if k == int(1.0 * RATE):
            # Backwards and to the right, over the other three feet.
            away = np.array([-0.03, -0.025, 0.0])
            controller.follow("com", wbqp.references.MinJerk(to=list(com + away), duration=1.0))
        if k == int(2.5 * RATE):
            controller.deactivate_contact("FL_FOOT")
        if k == int(2.8 * RATE):
            start = data.site("FL_FOOT").xpos.copy()
            controller.activate("lift")
            controller.follow("lift", wbqp.references.MinJerk(to=list(start + [0.0, 0.0, 0.06]), duration=1.0))
        command, report = controller.tick(m)
        assert report.level in ("optimal", "relaxed"), controller.explain()
        bridge.apply(command, data)
        for _ in range(round(1.0 / RATE / model.opt.timestep)):
            mujoco.mj_step(model, data)
        dynamics.update(m.q, m.v, position=m.position, quaternion=m.quaternion)
        com = dynamics.center_of_mass().copy()
        trace.append([m.time, *com, data.site("FL_FOOT").xpos[2], float(np.abs(report.tasks["com"].error).max())])
        if film.due(data.time):
            draw(film, data, bridge, com, trace[-1])
    film.save()
    trace = np.array(trace)
    return {"com": float(trace[trace[:, 0] > 0.5, -1].max()), "lift": float(trace[-1, 4] - trace[0, 4])}


def draw(film: Film, data: mujoco.MjData, bridge: wbqp.mujoco.Bridge, com: np.ndarray, row: list) -> None:
    """A frame with the force on each foot, and the centre of mass over the floor between the feet that stand."""
    arrows = [(at, 0.015 * force, RED) for which in range(4) for force, _, at in bridge.contacts.forces(data, which)]
    stand = [data.site(foot).xpos for foot in FEET if data.site(foot).xpos[2] < 0.005]
    edges = [a + s * (b - a) for a, b in zip(stand, stand[1:] + stand[:1]) for s in np.linspace(0.0, 1.0, 16)]
    dots = [([*edge[:2], 0.0], GREY) for edge in edges] + [([*com[:2], 0.0], BLUE), (com, BLUE)]
    film.take(data, [(f"t = {data.time:3.1f} s", BLACK), ("forces on the feet", RED), ("centre of mass", BLUE),
                     (f"foot {1e3 * max(row[4], 0.0):.0f} mm up", BLACK)], arrows, dots)


if __name__ == "__main__":
    found = main(*sys.argv[1:])
    print(f"centre of mass off by {1e3 * found['com']:.1f} mm at most; foot lifted by {1e3 * found['lift']:.0f} mm")
