"""What an answer costs in the common problem, and what it violates: by Pinocchio's dynamics, independent of all that
are compared."""

import numpy as np
import pinocchio as pin
from scipy.optimize import nnls


class Judge:
    def __init__(self, model, problem, states):
        self.model, self.data = model, model.createData()
        self.problem, self.states = problem, states
        self.index_q = np.array([model.joints[model.getJointId(joint)].idx_q for joint in states.joints])
        self.index_v = np.array([model.joints[model.getJointId(joint)].idx_v for joint in states.joints])
        self.limit = np.array([self.number(f"effort.{joint}") for joint in states.joints])
        self.frames = [model.getFrameId(problem[f"contact.{name}.frame"][0]) for name in states.contacts]

    def number(self, name):
        return float(self.problem[name][0])

    def judge(self, answers):
        """Per tick the cost and the violations: of the dynamics (N, N·m), of contacts' motion (m/s², rad/s²), of
        friction, centre of pressure and unilaterality (N, N·m), of torques (N·m); `margin`, how far the contact that is
        nearest to its limits is beyond them, negative within (N, N·m); and `corners`, by how much the soles'
        wrenches miss what forces at their four corners bear, each in its own friction pyramid (N, N·m): a narrower
        limit, TSID's."""
        keys = ["cost", "dynamics", "motion", "wrench", "torque", "margin", "corners"]
        rows = [self.one(tick, answer) for tick, answer in zip(self.states.ticks, answers)]
        return {key: np.array([row[i] for row in rows]) for i, key in enumerate(keys)}

    def one(self, tick, answer):
        model, data, number = self.model, self.data, self.number
        nv = model.nv
        R, joints = tick.rotation, len(self.index_v)
        q, v, a = np.zeros(model.nq), np.zeros(nv), np.zeros(nv)
        q[:3], q[3:7], q[self.index_q] = tick.position, tick.quaternion, tick.q
        v[:3], v[3:6], v[self.index_v] = R.T @ tick.linear, R.T @ tick.angular, tick.qd
        a[:3] = R.T @ answer[:3] - np.cross(v[3:6], v[:3])
        a[3:6], a[self.index_v] = R.T @ answer[3:6], answer[6 : 6 + joints]
        torque = answer[6 + joints :]
        tau = np.zeros(nv)
        tau[self.index_v] = torque

        # Everything that moves, by the motion that the answer means: no Jacobian's derivative is needed.
        pin.centerOfMass(model, data, q, v, a)
        pin.forwardKinematics(model, data, q, v, a)
        pin.updateFramePlacements(model, data)
        cost = 0.0

        def task(name, error, rate, acceleration, wanted):
            nonlocal cost
            kp, kd, weight = (number(f"{name}.{key}") for key in ("kp", "kd", "weight"))
            residual = acceleration - (wanted - kd * rate - kp * error)
            cost += weight * residual @ residual

        value, rate, wanted = tick.com
        task("com", data.com[0] - value, data.vcom[0] - rate, data.acom[0], wanted)
        rotation, rate, wanted = tick.base
        task("base", -pin.log3(rotation @ R.T), tick.angular - rate, answer[3:6], wanted)
        task("posture", tick.q - self.states.posture, tick.qd, answer[6 : 6 + joints], np.zeros(joints))

        rows, motion = [], 0.0
        axes = pin.LOCAL_WORLD_ALIGNED
        pin.computeJointJacobians(model, data, q)
        kinds = []
        for name, frame, on, swing in zip(self.states.contacts, self.frames, tick.on, tick.swing):
            velocity = pin.getFrameVelocity(model, data, frame, axes)
            acceleration = pin.getFrameClassicalAcceleration(model, data, frame, axes)
            if not on:
                value, rate, wanted = swing
                error = data.oMf[frame].translation - value
                task(f"swing.{name}", error, velocity.linear - rate, acceleration.linear, wanted)
                continue
            n = 6 if self.problem[f"contact.{name}.kind"][0] == "full" else 3
            kinds.append((name, n))
            J = pin.getFrameJacobian(model, data, frame, axes)[:n]
            rows.append(J)
            damping = number(f"contact.{name}.damping")
            motion = max(motion, np.abs(acceleration.vector[:n] + damping * velocity.vector[:n]).max())
        force = pin.rnea(model, data, q, v, a) - tau
        J = np.vstack(rows)
        wrench, *_ = np.linalg.lstsq(J.T, force, rcond=None)
        dynamics = np.abs(J.T @ wrench - force).max()
        margin, corners, first = -np.inf, 0.0, 0
        for name, n in kinds:
            f = wrench[first : first + n]
            first += n
            weight = np.array(self.problem[f"contact.{name}.weight"][:n], dtype=float)
            cost += weight @ (f * f)
            mu = number(f"contact.{name}.friction")
            beyond = [-f[2], abs(f[0]) - mu * f[2], abs(f[1]) - mu * f[2]]
            if n == 6:
                beyond += [abs(f[3]) - number(f"contact.{name}.half_length_y") * f[2],
                           abs(f[4]) - number(f"contact.{name}.half_length_x") * f[2]]
                corners = max(corners, self.beyond_corners(name, mu, f))
            margin = max(margin, *beyond)
        beyond = max(0.0, (np.abs(torque) - self.limit).max())
        return cost, dynamics, motion, max(0.0, margin), beyond, margin, corners

    def beyond_corners(self, name, mu, wrench):
        """Distance of a wrench from the cone that the edges of the pyramids at the corners span."""
        x, y = (self.number(f"contact.{name}.half_length_{axis}") for axis in "xy")
        edges = [np.concatenate([force, np.cross(corner, force)])
                 for corner in np.array([[x, y, 0], [x, -y, 0], [-x, y, 0], [-x, -y, 0]])
                 for force in np.array([[mu, mu, 1], [mu, -mu, 1], [-mu, mu, 1], [-mu, -mu, 1]])]
        return nnls(np.array(edges).T, wrench)[1]
