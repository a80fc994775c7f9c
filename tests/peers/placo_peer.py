#!/usr/bin/env python3
"""PlaCo's side of the comparison on the same robots (robots.py), through its Python interface.

    python placo_peer.py URDF PROBLEM STATES

PROBLEM, STATES and the lines of standard input are those of tsid_peer.cpp and wbqp_peer.rs. What is timed is
`update_kinematics` and `DynamicsSolver.solve`, which are C++ inside: state, references and contacts are handed over
before the clock starts, since Python would take longer for that than it has to.
"""

import gc
import os
import sys
from time import perf_counter_ns

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

import numpy as np  # noqa: E402
import placo  # noqa: E402

from states import States, read_problem  # noqa: E402


class Controller:
    def __init__(self, urdf, problem, states):
        number = lambda name: float(problem[name][0])  # noqa: E731
        self.states = states
        self.robot = placo.RobotWrapper(urdf, placo.Flags.ignore_collisions)
        self.solver = placo.DynamicsSolver(self.robot)
        # Torques cost nothing of their own in the common problem.
        self.solver.torque_cost = 0.0
        self.solver.enable_torque_limits(True)
        for joint in states.joints:
            self.solver.set_torque_limit(joint, number(f"effort.{joint}"))
        self.index_q = np.array([self.robot.get_joint_offset(joint) for joint in states.joints])
        self.index_v = np.array([self.robot.get_joint_v_offset(joint) for joint in states.joints])

        def soft(task, name):
            task.configure(name, "soft", number(f"{name}.weight"))
            task.kp, task.kd = number(f"{name}.kp"), number(f"{name}.kd")
            return task

        self.com = soft(self.solver.add_com_task(np.zeros(3)), "com")
        self.base = soft(self.solver.add_orientation_task(problem["base.frame"][0], np.eye(3)), "base")
        posture = soft(self.solver.add_joints_task(), "posture")
        posture.set_joints(dict(zip(states.joints, map(float, states.posture))))

        self.contacts = []
        for name in states.contacts:
            key = f"contact.{name}."
            frame, weight = problem[key + "frame"][0], [float(w) for w in problem[key + "weight"]]
            damping = number(key + "damping")
            if problem[key + "kind"][0] == "full":
                task = self.solver.add_frame_task(frame, np.eye(4))
                task.configure(name, "hard", 1.0, 1.0)
                for part in (task.position(), task.orientation()):
                    part.kp, part.kd = 0.0, damping
                contact = self.solver.add_planar_contact(task)
                contact.length, contact.width = 2 * number(key + "half_length_x"), 2 * number(key + "half_length_y")
                contact.weight_moments = weight[3]
                swing = None
            else:
                task = self.solver.add_position_task(frame, np.zeros(3))
                contact = self.solver.add_unilateral_point_contact(task)
                swing = None
                if f"swing.{name}.kp" in problem:
                    swing = [number(f"swing.{name}.{key}") for key in ("weight", "kp", "kd")]
            contact.mu, contact.weight_forces, contact.weight_tangentials = number(key + "friction"), weight[0], 0.0
            self.contacts.append([name, contact, task, damping, swing, None])

    def give(self, tick):
        """State, references and contacts."""
        q, v = np.zeros(7 + len(self.index_q)), np.zeros(6 + len(self.index_v))
        R = tick.rotation
        q[:3], q[3:7], q[self.index_q] = tick.position, tick.quaternion, tick.q
        v[:3], v[3:6], v[self.index_v] = R.T @ tick.linear, R.T @ tick.angular, tick.qd
        self.robot.state.q, self.robot.state.qd = q, v
        self.com.target_world, self.com.dtarget_world, self.com.ddtarget_world = tick.com
        self.base.R_world_frame, self.base.omega_world, self.base.domega_world = tick.base
        for contact, on, follow in zip(self.contacts, tick.on, tick.swing):
            name, force, task, damping, swing, before = contact
            if on != before:
                force.active = bool(on)
                contact[5] = on
                if on and hasattr(task, "target_world"):
                    task.configure(name, "hard")
                    task.kp, task.kd = 0.0, damping
                    task.dtarget_world, task.ddtarget_world = np.zeros(3), np.zeros(3)
                elif not on:
                    task.configure(name, "soft", swing[0])
                    task.kp, task.kd = swing[1], swing[2]
            if not on:
                task.target_world, task.dtarget_world, task.ddtarget_world = follow

    def tick(self):
        start = perf_counter_ns()
        self.robot.update_kinematics()
        result = self.solver.solve()
        return perf_counter_ns() - start, result


def main():
    urdf, problem, states = sys.argv[1], read_problem(sys.argv[2]), States(sys.argv[3])
    controller = Controller(urdf, problem, states)
    times = [[] for _ in states.ticks]
    answers = [None] * len(states.ticks)
    size = [0, 0, 0]
    gc.disable()
    for line in sys.stdin:
        asked = line.split()
        if asked[0] == "start":
            controller = Controller(urdf, problem, states)
        elif asked[0] == "run":
            for i in range(int(asked[1]), min(int(asked[2]), len(states.ticks))):
                tick = states.ticks[i]
                controller.give(tick)
                spent, result = controller.tick()
                times[i].append(spent)
                if result.success:
                    answers[i] = (True, np.array(result.qdd), np.array(result.tau))
                else:
                    answers[i] = (False, np.zeros(6 + len(states.joints)), np.zeros(6 + len(states.joints)))
            p = controller.solver.problem
            size = max(size, [p.n_variables, p.determined_variables, p.n_inequalities])
            gc.collect()
        elif asked[0] == "write":
            with open(asked[1], "w") as out:
                for tick, answer, spent in zip(states.ticks, answers, times):
                    success, qdd, tau = answer
                    R = tick.rotation
                    # From the spatial acceleration in body axes to the classical one in world axes.
                    v, w = R.T @ tick.linear, R.T @ tick.angular
                    a = R @ (qdd[:3] + np.cross(w, v))
                    numbers = [*a, *(R @ qdd[3:6]), *qdd[controller.index_v], *tau[controller.index_v]]
                    words = " ".join(f"{x:.17g}" for x in numbers)
                    out.write(f"{int(success)} {words} | {' '.join(map(str, spent))}\n")
        print("done", *size, flush=True)


if __name__ == "__main__":
    main()
