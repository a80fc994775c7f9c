"""Solo12 stands in MuJoCo, shifts its weight and lifts a foot: ``python python/examples/solo12_shift.py [picture.png]``."""

import sys

import mujoco
import numpy as np
from robots import urdf

import wbqp.mujoco

RATE = 1000.0  # Hz
FEET = ["FL_FOOT", "FR_FOOT", "HL_FOOT", "HR_FOOT"]


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


def main() -> dict[str, float]:
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
    model = mujoco.MjModel.from_xml_string(scene(controller.robot))
    data = mujoco.MjData(model)
    bridge = wbqp.mujoco.Bridge(model, controller)
    m = controller.measurement()
    bridge.state.write(data, m.position, m.quaternion, m.q, m.v)
    mujoco.mj_forward(model, data)
    dynamics = wbqp.Dynamics(controller.robot)
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
        trace.append([m.time, *com, data.site("FL_FOOT").xpos[2], *(data.site(foot).xpos[2] for foot in FEET[1:]),
                      float(np.abs(report.tasks["com"].error).max())])
    trace = np.array(trace)
    if len(sys.argv) > 1:
        draw(trace, sys.argv[1])
    return {"com": float(trace[trace[:, 0] > 0.5, -1].max()), "lift": float(trace[-1, 4] - trace[0, 4])}


def draw(trace: np.ndarray, file: str) -> None:
    """Where the centre of mass and the feet are."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot as plt

    figure, (com, feet) = plt.subplots(2, 1, figsize=(8, 5), sharex=True, layout="constrained")
    com.plot(trace[:, 0], 100.0 * (trace[:, 1:3] - trace[0, 1:3]), label=["x", "y"])
    com.set(ylabel="centre of mass [cm]")
    feet.plot(trace[:, 0], 100.0 * trace[:, 4:8], label=FEET)
    feet.set(xlabel="time [s]", ylabel="height of feet [cm]")
    for axes in (com, feet):
        axes.legend()
    figure.savefig(file, dpi=120)


if __name__ == "__main__":
    found = main()
    print(f"largest error of the centre of mass: {1e3 * found['com']:.1f} mm; foot lifted by {1e3 * found['lift']:.0f} mm")
