"""A hexarotor flies a circle and stays level: ``python python/examples/hexarotor_circle.py [film.webp]``.

The robot is described here, as data. Its rotors are tilted by 25° about their arms, in turn to one side and the other,
so that they push sideways too: a hexarotor with flat rotors would have to tilt by 11° for the same circle.
"""

import sys

import mujoco
import numpy as np
from film import BLACK, BLUE, GREY, RED, Film

import wbqp.mujoco

RATE, RADIUS, DURATION, HEIGHT = 500.0, 0.8, 15.0, 1.2  # Hz, m, s, m


def hexarotor(tilt: float) -> wbqp.robots.Tree:
    """1.5 kg, rotors at the ends of six arms of 30 cm, tilted by ``tilt`` degrees."""
    frames, rotors = [], []
    for k in range(6):
        angle, side = np.radians(60.0 * k + 30.0), (-1.0) ** k
        # About the vertical to the arm, then about the arm.
        c, s = np.cos(angle / 2.0), np.sin(angle / 2.0)
        a, b = np.cos(side * np.radians(tilt) / 2.0), np.sin(side * np.radians(tilt) / 2.0)
        place = [0.3 * np.cos(angle), 0.3 * np.sin(angle), 0.03]
        name = f"rotor_{k}"
        frames.append({"name": name, "body": "base", "position": place, "quaternion": [c * a, c * b, s * b, s * a]})
        rotors.append({"name": name, "frame": name, "thrust": [0.1, 8.0], "moment": 0.016 * side,
                       "time_constant": [0.0125, 0.025]})
    base = {"name": "base", "mass": 1.5, "moments": [0.02, 0.02, 0.035]}
    return wbqp.robots.Tree(name="hexarotor", body=[base], frame=frames, rotor=rotors)


def main(picture: str | None = None) -> dict[str, float]:
    """Flies two turns, from rest to rest; returns the largest error, m, and tilt, degrees, and all thrusts, N."""
    controller = wbqp.Controller(
        rate=RATE,
        robot=hexarotor(25.0),
        tasks=[
            wbqp.tasks.BasePosition(kp=16.0, reference=wbqp.references.Ellipse(
                semi_axes=[RADIUS, RADIUS], duration=DURATION, turns=2.0, start=0.5)),
            wbqp.tasks.BaseOrientation(kp=60.0, weight=1.0),
        ],
        constraints=[wbqp.constraints.ActuatorLimits()],
    )
    mjcf = wbqp.mujoco.export(controller.robot, step=1e-3)
    model = mujoco.MjModel.from_xml_string(mjcf)
    data = mujoco.MjData(model)
    bridge = wbqp.mujoco.Bridge(model, controller)
    m = controller.measurement()
    m.position[:] = [RADIUS, 0.0, HEIGHT]
    bridge.state.write(data, m.position, m.quaternion, m.q, m.v)
    mujoco.mj_forward(model, data)
    film = Film(picture, mjcf, lookat=[0.0, 0.0, 0.95], distance=2.7, azimuth=100.0, elevation=-28.0, speed=2.2,
                every=0.18)
    trace = []
    for k in range(int((DURATION + 1.0) * RATE)):
        bridge.measure(data, m)
        m.time = k / RATE
        command, report = controller.tick(m)
        assert report.level == "optimal", controller.explain()
        bridge.apply(command, data)
        if k == 0:
            bridge.actuators.settle(data)
        for _ in range(round(1.0 / RATE / model.opt.timestep)):
            bridge.actuators.before_step(data)
            mujoco.mj_step(model, data)
        tilt = np.degrees(np.arccos(data.body("base").xmat[8]))
        error = float(np.linalg.norm(report.tasks["base_position"].error))
        trace.append([error, tilt, min(command.effort), max(command.effort), *data.qpos[:3]])
        if film.due(data.time):
            draw(film, data, np.array(trace))
    film.save()
    trace = np.array(trace)
    most = trace.max(axis=0)
    return {"error": most[0], "tilt": most[1], "least": trace[:, 2].min(), "most": most[3]}


def draw(film: Film, data: mujoco.MjData, trace: np.ndarray) -> None:
    """A frame with the thrusts and the path."""
    rotors = [data.site(f"rotor_{k}") for k in range(6)]
    axes = [site.xmat.reshape(3, 3)[:, 2] for site in rotors]
    arrows = [(site.xpos, 0.08 * data.actuator(site.name).force[0] * axis, BLUE) for site, axis in zip(rotors, axes)]
    angles = np.linspace(0.0, 2.0 * np.pi, 90)
    dots = [((RADIUS * np.cos(a), RADIUS * np.sin(a), HEIGHT), GREY) for a in angles]
    dots += [(place, RED) for place in trace[-750::15, 4:]]
    film.take(data, [(f"t = {data.time:4.1f} s", BLACK), (f"tilt {trace[-1, 1]:4.2f}°", BLACK),
                     (f"thrusts {trace[-1, 2]:.1f} to {trace[-1, 3]:.1f} N", BLUE),
                     (f"{1e3 * trace[-1, 0]:4.1f} mm off the circle", RED)], arrows, dots)


if __name__ == "__main__":
    found = main(*sys.argv[1:])
    print(f"at most {1e3 * found['error']:.1f} mm off the circle, tilted by {found['tilt']:.2f} degrees,"
          f" thrusts {found['least']:.1f} to {found['most']:.1f} N")
