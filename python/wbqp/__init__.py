"""Whole-body QP control: describe a robot, list tasks and constraints, call ``tick``.

SI units and radians, world z up. Velocities are world-aligned, ``v = [v_WR; w_WR; q̇]``, linear first. Forces are what
the environment does to the robot. Weights are linear: a row costs ``w r²``.
"""

from ._arrays import NamedArray
from ._errors import ConfigError, Mistake
from ._wbqp import (
    Command,
    ContactReport,
    Controller,
    Measurement,
    Report,
    Robot,
    TaskReport,
    __version__,
)

__all__ = [
    "Command",
    "ConfigError",
    "ContactReport",
    "Controller",
    "Measurement",
    "Mistake",
    "NamedArray",
    "Report",
    "Robot",
    "TaskReport",
    "__version__",
]
