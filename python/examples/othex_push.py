"""The OTHex pushes a wall with 5 N while it is pushed away: ``python python/examples/othex_push.py [film.webp]``.

The scenario, the controller, noise, delays and filters are those of the paper's experiment B, which come with wbqp.
"""

import sys
import tempfile
from pathlib import Path

import mujoco
import numpy as np
from film import BLACK, BLUE, GREEN, RED, Film

import wbqp
from wbqp.mujoco import Case, Contacts

SCALE = 0.05  # m of an arrow per N


def main(picture: str | None = None) -> dict[str, float]:
    """Runs the 25 s; returns what the tip does while the robot is disturbed, N and degrees."""
    with tempfile.TemporaryDirectory() as folder:
        log = Path(folder) / "push.mcap"
        case = Case(wbqp.scenarios()["push_with_disturbance"], "with_ft", log)
        film = Film(picture, case.run.mjcf["text"], lookat=[0.0, 0.0, 1.0], distance=1.7, azimuth=65.0, elevation=-18.0,
                    every=0.25, speed=3.0)
        body = mujoco.mj_name2id(case.model, mujoco.mjtObj.mjOBJ_BODY, "arm_link3")
        contacts = Contacts(case.model, [body])
        while case.period():
            if 4.0 < case.data.time < 21.0 and film.due(case.data.time):
                draw(film, case, contacts)
        assert case.finish()["diverged"] is None
        run = wbqp.read_log(log)
    film.save()
    tip, base = run["/contact/tip"], run["/plant"]
    pushed = (tip.t > run.marks["disturbance_start"]) & (tip.t < run.marks["disturbance_end"])
    force = tip["truth/z"]
    # A second after the disturbance has begun the integral has found it.
    late = pushed & (tip.t > run.marks["disturbance_start"] + 1.0)
    w, x, y, z = base["base/orientation"].T
    tilt = np.degrees(np.arccos(np.clip(1.0 - 2.0 * (x**2 + y**2), -1.0, 1.0)))
    return {
        "least": float(force[pushed].min()),
        "most": float(force[pushed].max()),
        "mean": float(force[late].mean()),
        "tilt": float(tilt[pushed].max()),
    }


def draw(film: Film, case: Case, contacts: Contacts) -> None:
    """A frame with the forces: the wall's on the tip, the disturbance, the thrusts."""
    data, arrows, force = case.data, [], 0.0
    text = [(f"t = {data.time:4.1f} s", BLACK), ("thrusts", BLUE)]
    for push, _, place in contacts.forces(data, 0):
        # What the tip does to the wall.
        arrows.append((place, -SCALE * push, RED))
        force = float(-push[0])
    text.append((f"on the wall {force:.1f} N", RED))
    for frame, push, _, start, end in case.run.disturbances:
        if start <= data.time < end:
            arrows.append((data.site(frame).xpos, SCALE * np.array(push), GREEN))
            text.append((f"disturbance {np.linalg.norm(push):.1f} N", GREEN))
    for k in range(1, 7):
        site = data.site(f"rotor_{k}")
        thrust = data.actuator(f"rotor_{k}").force[0] * site.xmat.reshape(3, 3)[:, 2]
        arrows.append((site.xpos, 0.5 * SCALE * thrust, BLUE))
    film.take(data, text, arrows)


if __name__ == "__main__":
    found = main(*sys.argv[1:])
    print(f"while it is pushed away with 3.5 N, the tip pushes with {found['least']:.1f} to {found['most']:.1f} N,"
          f" after a second with {found['mean']:.2f} N; it tilts by {found['tilt']:.1f} degrees")
