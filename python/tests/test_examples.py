"""The examples run, and do what their pictures show."""

from __future__ import annotations

import re
import subprocess
import sys
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parent.parent / "examples"


def printed(name: str) -> list[float]:
    """The numbers that an example prints."""
    pytest.importorskip("mujoco")
    try:
        distribution("example-robot-data")
    except PackageNotFoundError:
        pytest.skip("example-robot-data is not installed: the extra `examples`")
    done = subprocess.run([sys.executable, EXAMPLES / name], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return [float(number) for number in re.findall(r"-?\d+\.?\d*", done.stdout)]


def test_an_arm_draws_a_circle() -> None:
    (millimetres,) = printed("ur5_circle.py")
    assert millimetres < 1.0


def test_a_quadruped_lifts_a_foot() -> None:
    com, lift = printed("solo12_shift.py")
    assert com < 5.0
    assert 55.0 < lift < 65.0
