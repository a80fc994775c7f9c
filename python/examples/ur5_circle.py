"""A UR5 draws a circle with its tool, in MuJoCo: ``python python/examples/ur5_circle.py [film.webp]``."""

import sys
from dataclasses import dataclass

import mujoco
import numpy as np
from film import BLACK, GREY, RED, Film
from robots import urdf

import wbqp.mujoco

RATE, RADIUS, TURN = 500.0, 0.1, 4.0  # Hz, m, s


def main(picture: str | None = None) -> dict[str, float]:
    """Runs two turns; returns the largest error after the first second, m."""
    controller = wbqp.Controller(
        rate=RATE,
        robot={"file": str(urdf("ur5_robot.urdf")), "base": "fixed", "home": {
            "shoulder_lift_joint": -1.2, "elbow_joint": 1.6, "wrist_1_joint": -2.0, "wrist_2_joint": -1.57}},
        tasks=[
            wbqp.tasks.FramePose(name="tool", frame="tool0", kp=400.0, weight=[100.0] * 3 + [10.0] * 3),
            wbqp.tasks.Posture(kp=20.0, weight=0.01),
        ],
    )
    # A reference of one's own, in each period: the centre is what is measured in the first.
    mjcf = wbqp.mujoco.export(controller.robot, step=1e-3)
    model = mujoco.MjModel.from_xml_string(mjcf)
    data = mujoco.MjData(model)
    bridge = wbqp.mujoco.Bridge(model, controller)
    m = controller.measurement()
    bridge.state.write(data, m.position, m.quaternion, m.q, m.v)
    mujoco.mj_forward(model, data)
    centre = data.site("tool0").xpos.copy()
    controller.follow("tool", Circle(centre=list(centre)))
    film = Film(picture, mjcf, lookat=[0.3, 0.15, 0.32], distance=1.4, azimuth=150.0, elevation=-18.0, tube=0.045,
                every=0.1, speed=1.2)
    trace = []
    for k in range(int(2 * TURN * RATE)):
        bridge.measure(data, m)
        m.time = k / RATE
        command, report = controller.tick(m)
        assert report.level == "optimal", controller.explain()
        bridge.apply(command, data)
        for _ in range(round(1.0 / RATE / model.opt.timestep)):
            mujoco.mj_step(model, data)
        wanted = centre + circle(m.time + 1.0 / RATE)[0]
        trace.append([m.time, *data.site("tool0").xpos, *wanted])
        if film.due(data.time):
            draw(film, data, centre, trace)
    film.save()
    trace = np.array(trace)
    error = np.linalg.norm(trace[:, 1:4] - trace[:, 4:], axis=1)
    return {"error": float(error[trace[:, 0] > 1.0].max())}


def circle(t: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Value, rate and acceleration of a circle that begins at rest, m."""
    # The angle speeds up over the first second.
    w = 2.0 * np.pi / TURN
    s = min(t, 1.0)
    angle = w * (s**3 - 0.5 * s**4 + max(t - 1.0, 0.0))
    rate, acceleration = w * (3.0 * s**2 - 2.0 * s**3), w * (6.0 * s - 6.0 * s**2)
    out, along = np.array([0.0, np.sin(angle), 1.0 - np.cos(angle)]), np.array([0.0, np.cos(angle), np.sin(angle)])
    inward = np.array([0.0, -np.sin(angle), np.cos(angle)])
    return RADIUS * out, RADIUS * rate * along, RADIUS * (acceleration * along + rate**2 * inward)


@wbqp.reference("example.circle")
@dataclass
class Circle:
    """A circle in the plane across x."""

    centre: list[float]

    def sample(self, time):
        value, rate, acceleration = circle(time)
        return np.asarray(self.centre) + value, rate, acceleration


def draw(film: Film, data: mujoco.MjData, centre: np.ndarray, trace: list) -> None:
    """A frame with the wanted circle and where the tool was."""
    dots = [(centre + RADIUS * np.array([0.0, np.sin(a), 1.0 - np.cos(a)]), GREY) for a in np.linspace(0.0, 6.28, 90)]
    dots += [(row[1:4], RED) for row in trace[-1000::20]]
    error = 1e3 * np.linalg.norm(np.subtract(trace[-1][1:4], trace[-1][4:]))
    film.take(data, [(f"t = {data.time:3.1f} s", BLACK), (f"{error:.2f} mm off the circle", RED)], dots=dots)


if __name__ == "__main__":
    found = main(*sys.argv[1:])
    print(f"largest error after the first second: {1e3 * found['error']:.2f} mm")
