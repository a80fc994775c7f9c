"""Whole-body QP control: describe a robot, list tasks and constraints, call ``tick``.

SI units and radians, world z up. Velocities are world-aligned, ``v = [v_WR; w_WR; q̇]``, linear first. Forces are what
the environment does to the robot. Weights are linear: a row costs ``w r²``.
"""

from ._arrays import NamedArray
from ._errors import ConfigError, Mistake
from ._recording import Recording, Topic, experiment_cases, read_log, rows
from ._simulation import cases, scenarios, simulate
from ._wbqp import (
    Command,
    ContactReport,
    Controller,
    Dynamics,
    FrameState,
    Measurement,
    QpSolution,
    Report,
    Robot,
    TaskReport,
    __version__,
    solve_qp,
)

__all__ = [
    "Command",
    "ConfigError",
    "ContactReport",
    "Controller",
    "Dynamics",
    "FrameState",
    "Measurement",
    "Mistake",
    "NamedArray",
    "QpSolution",
    "Recording",
    "Report",
    "Robot",
    "TaskReport",
    "Topic",
    "__version__",
    "cases",
    "experiment_cases",
    "read_log",
    "rows",
    "scenarios",
    "simulate",
    "solve_qp",
]
