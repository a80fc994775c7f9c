"""MuJoCo beside wbqp: robots from compiled models, models from robots, and a second plant for every scenario.

The extra ``wbqp[mujoco]`` installs the engine; nothing else of wbqp needs it.
"""

from __future__ import annotations

from .._wbqp import CaseRun, Robot, export_robot
from ._bridge import Actuators, Bridge, Contacts, State
from ._case import STEP, Case, run_case
from ._robot import UnsupportedModel, robot_table

__all__ = [
    "STEP",
    "Actuators",
    "Bridge",
    "Case",
    "CaseRun",
    "Contacts",
    "State",
    "UnsupportedModel",
    "export",
    "robot_table",
    "run_case",
]


def export(robot: Robot, *, step: float = STEP) -> str:
    """A robot at home, alone in the world, as MJCF: the text of a file.

    ``wbqp export-mjcf`` writes the plants of controllers and scenarios too, and says what could not be written as it
    is.

    Parameters
    ----------
    robot : wbqp.Robot
        Of whatever origin.
    step : float
        Integration step that is written into it, s.
    """
    text: str = export_robot(robot, step)["text"]
    return text
