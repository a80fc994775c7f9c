"""The examples run, and do what their pictures show."""

from __future__ import annotations

import re
import subprocess
import sys
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path

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
