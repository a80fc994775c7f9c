"""Whole-body QP control: describe a robot, list tasks and constraints, call ``tick``.

SI units and radians, world z up. Velocities are world-aligned, ``v = [v_WR; w_WR; q̇]``, linear first. Forces are what
the environment does to the robot. Weights are linear: a row costs ``w r²``.
"""

from . import campaign, constraints, fallbacks, references, robots, solvers, tasks, testing, tuning
from ._arrays import NamedArray
from ._authoring import Layout, Rows, Tick, constraint, entry, reference, task
from ._contact import Contact
from ._errors import ConfigError, Mistake
from ._recording import Recording, Topic, experiment_cases, read_log, rows
from ._simulation import cases, scenarios, simulate
from ._wbqp import (
    Batch,
    Command,
    ContactReport,
    Controller,
    Dynamics,
    FrameState,
    Measurement,
    QpSolution,
    Report,
    Robot,
    Sensitivity,
    Setup,
    TaskReport,
    __version__,
    solve_qp,
)
from .tuning import tune

__all__ = [
    "Batch",
    "Command",
    "ConfigError",
    "Contact",
    "ContactReport",
    "Controller",
    "Dynamics",
    "FrameState",
    "Layout",
    "Measurement",
    "Mistake",
    "NamedArray",
    "QpSolution",
    "Recording",
    "Report",
    "Robot",
    "Rows",
    "Sensitivity",
    "Setup",
    "TaskReport",
    "Tick",
    "Topic",
    "__version__",
    "campaign",
    "cases",
    "constraint",
    "constraints",
    "entry",
    "experiment_cases",
    "fallbacks",
    "read_log",
    "reference",
    "references",
    "robots",
    "rows",
    "scenarios",
    "simulate",
    "solve_qp",
    "solvers",
    "task",
    "tasks",
    "testing",
    "tune",
    "tuning",
]
