"""One library's side of the comparison from Python: its controller in the common closed loop.

    python worker.py JOB MODULE CLASS

Lines of standard input, each answered by `done`: `start` begins anew, `run A B` takes the steps from A to B and measures
them, `write FILE` writes of every step the state it began with, the motion and the torques that were computed, whether
the solution was optimal, and the times of all rounds in ns. What is timed is `step`, all that a user does in a period:
state in, reference in, solve, command out. The state is put into the library's order and axes before the clock starts.
"""

import gc
import importlib
import os
import sys
from pathlib import Path
from time import perf_counter_ns

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

import numpy as np  # noqa: E402

from job import path, read_job  # noqa: E402
from motion import State  # noqa: E402


class Loop:
    """A controller, and what it has made of the robot."""

    def __init__(self, job, make):
        self.job, self.make = job, make
        n, moves = len(job.joints), len(job.joints) + (0 if job.kind == "arm" else 6)
        self.states = np.zeros((job.steps, 13 + 2 * n))
        self.motions, self.torques = np.zeros((job.steps, moves)), np.full((job.steps, n), np.nan)
        self.optimal = np.zeros(job.steps, dtype=bool)
        self.times = []

    def start(self):
        self.controller = self.make(self.job)
        self.convention = self.controller.convention(self.job)
        self.state = State(self.job)
        # A velocity takes the robot to where it shall be at the end of the period.
        ahead = 1 if self.controller.velocity_level else 0
        self.wanted = path(self.job, (np.arange(self.job.steps) + ahead) * self.job.dt)
        self.times.append(np.zeros(self.job.steps, dtype=np.int64))

    def run(self, first, last):
        step, convention, state, dt = self.controller.step, self.convention, self.state, self.job.dt
        times = self.times[-1]
        gc.collect()
        gc.disable()
        for k in range(first, min(last, self.job.steps)):
            wanted, given, time = tuple(w[k] for w in self.wanted), convention.take(state), k * dt
            start = perf_counter_ns()
            torque, motion, optimal = step(time, *given, wanted)
            times[k] = perf_counter_ns() - start
            self.states[k] = state.numbers()
            self.motions[k] = motion = convention.give(state, np.array(motion))
            self.optimal[k] = optimal
            if torque is not None:
                self.torques[k] = convention.torques(np.array(torque))
            if self.controller.velocity_level:
                state.glide(motion, dt)
            else:
                state.accelerate(motion, dt)
        gc.enable()

    def write(self, file):
        np.savez(file, states=self.states, motions=self.motions, torques=self.torques, optimal=self.optimal,
                 times=np.array(self.times))


def main():
    file, module, name = sys.argv[1:]
    # What a library prints while it is imported or solves is not an answer.
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)
    loop = Loop(read_job(Path(file)), getattr(importlib.import_module(module), name))
    for line in sys.stdin:
        asked, *rest = line.split()
        if asked == "start":
            loop.start()
        elif asked == "run":
            loop.run(*map(int, rest))
        else:
            loop.write(*rest)
        print("done", file=answers, flush=True)


if __name__ == "__main__":
    main()
