"""The examples run, and do what their pictures show."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path

import numpy as np
import pytest

EXAMPLES = Path(__file__).parent.parent / "examples"


def needs_robots() -> None:
    """Skips where the robots of others are not installed."""
    try:
        distribution("example-robot-data")
    except PackageNotFoundError:
        pytest.skip("example-robot-data is not installed: the extra `examples`")


def printed(name: str, *arguments: str) -> list[float]:
    """The numbers that an example prints."""
    pytest.importorskip("mujoco", reason="MuJoCo is not installed: the extra `mujoco`")
    pytest.importorskip("PIL", reason="Pillow is not installed: the extra `examples`")
    command = [sys.executable, str(EXAMPLES / name), *arguments]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return [float(number) for number in re.findall(r"-?\d+\.?\d*", done.stdout)]


def test_an_aerial_manipulator_pushes_against_a_disturbance() -> None:
    pushed, least, most, late, tilt = printed("othex_push.py")
    assert pushed == 3.5
    # The reference is 5 N.
    assert 4.5 < least < most < 5.5 and abs(late - 5.0) < 0.05
    assert tilt < 6.0


def test_a_hexarotor_flies_a_circle_without_tilting() -> None:
    error, tilt, least, most = printed("hexarotor_circle.py")
    assert error < 8.0 and tilt < 0.2
    # Inside of the thrusts' limits: what is promised is the controller's, not the clamp's.
    assert 0.1 < least < most < 8.0


def test_an_arm_draws_a_circle() -> None:
    needs_robots()
    (millimetres,) = printed("ur5_circle.py")
    assert millimetres < 1.0


def test_a_quadruped_lifts_a_foot() -> None:
    needs_robots()
    com, lift = printed("solo12_shift.py")
    assert com < 5.0
    assert 55.0 < lift < 65.0


def test_a_humanoid_reaches() -> None:
    needs_robots()
    hand, slip, inside, beyond = printed("talos_reach.py")
    assert hand < 1.0 and slip < 0.1
    assert 80.0 < inside < 100.0
    assert beyond < 0.1


FRAME = """
import mujoco, sys, wbqp.mujoco
from film import RED, Film

mjcf = wbqp.mujoco.export(wbqp.Robot({"type": "othex"}))
data = mujoco.MjData(mujoco.MjModel.from_xml_string(mjcf))
data.qpos[2] = 1.0
arrows = [((0.0, 0.0, 1.2), (0.0, 0.0, 0.4), RED)]
for file, drawn in zip(sys.argv[1:], ([], arrows)):
    film = Film(file, mjcf, lookat=[0.0, 0.0, 1.0], distance=2.0, azimuth=60.0, elevation=-15.0)
    film.take(data, [], drawn)
    film.save()
"""


def test_films_show_the_robot_and_forces(tmp_path: Path) -> None:
    pytest.importorskip("mujoco", reason="MuJoCo is not installed: the extra `mujoco`")
    image = pytest.importorskip("PIL.Image", reason="Pillow is not installed: the extra `examples`")
    files = [tmp_path / "without.png", tmp_path / "with.png"]
    for engine in ("egl", "osmesa"):
        environment = {**os.environ, "MUJOCO_GL": engine, "PYTHONPATH": str(EXAMPLES)}
        command = [sys.executable, "-c", FRAME, *map(str, files)]
        done = subprocess.run(command, capture_output=True, text=True, check=False, env=environment)
        if done.returncode == 0:
            break
    else:
        pytest.skip(f"MuJoCo can draw neither with EGL nor with OSMesa here: {done.stderr.strip().splitlines()[-1]}")

    def count(file: Path, low: tuple[int, int, int], high: tuple[int, int, int]) -> int:
        pixels = np.asarray(image.open(file).convert("RGB"))
        return int(((pixels >= low) & (pixels <= high)).all(axis=2).sum())

    orange, red = ((140, 75, 0), (255, 170, 90)), ((170, 0, 0), (255, 60, 60))
    assert count(files[0], *orange) > 500
    assert count(files[0], *red) == 0 and count(files[1], *red) > 100


def test_the_notebook_runs_and_is_kept_without_outputs() -> None:
    pytest.importorskip("mujoco", reason="MuJoCo is not installed: the extra `mujoco`")
    pytest.importorskip("matplotlib", reason="matplotlib is not installed: the extra `examples`")
    pytest.importorskip("ipykernel", reason="ipykernel is not installed: the extra `examples`")
    nbclient = pytest.importorskip("nbclient", reason="nbclient is not installed: the extra `examples`")
    import nbformat

    file = EXAMPLES / "push.ipynb"
    for cell in json.loads(file.read_text(encoding="utf-8"))["cells"]:
        assert cell["cell_type"] == "markdown" or (cell["outputs"] == [] and cell["execution_count"] is None)
    notebook = nbformat.read(file, as_version=4)
    nbclient.NotebookClient(notebook, timeout=300, kernel_name="python3").execute()
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", [])]
    assert any("image/png" in output.get("data", {}) for output in outputs)
    text = "".join(output.get("text", "") for output in outputs)
    touched, blow, two, three, least, most = map(float, re.findall(r"\d+\.\d+", text))
    assert 2.5 < touched < 3.5 and blow < 15.0
    assert two == pytest.approx(2.0, abs=0.02) and three == pytest.approx(3.0, abs=0.01)
    # The plot shows limits that are reached.
    assert least == 0.1 and most == 6.0
