"""The robot's state in the comparison from Python, how it moves, and how each library wants to be told of it."""

import numpy as np


def rotation_of(quaternion):
    """Of a quaternion x, y, z, w."""
    x, y, z, w = quaternion
    return np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ])


def product(a, b):
    """Of quaternions x, y, z, w."""
    v, w = a[:3], a[3]
    return np.append(w * b[:3] + b[3] * v + np.cross(v, b[:3]), w * b[3] - v @ b[:3])


def turn(vector):
    """The quaternion x, y, z, w of a rotation vector."""
    angle = np.linalg.norm(vector)
    return np.append(0.5 * np.sinc(angle / (2 * np.pi)) * vector, np.cos(0.5 * angle))


class State:
    """Base (position; quaternion x, y, z, w; velocities world-aligned) and joints; of a fixed base the joints count."""

    def __init__(self, job):
        self.fixed = job.kind == "arm"
        self.position, self.quaternion = np.array(job.position, dtype=float), np.array([0.0, 0.0, 0.0, 1.0])
        self.q = np.array([job.home.get(joint, 0.0) for joint in job.joints])
        self.linear, self.angular, self.qd = np.zeros(3), np.zeros(3), np.zeros(len(self.q))

    def numbers(self):
        return np.concatenate([self.position, self.quaternion, self.q, self.linear, self.angular, self.qd])

    def accelerate(self, a, dt):
        """By constant accelerations of base (world axes, classical) and joints over a period."""
        if not self.fixed:
            self.position = self.position + dt * self.linear + 0.5 * dt * dt * a[:3]
            turned = product(turn(dt * self.angular + 0.5 * dt * dt * a[3:6]), self.quaternion)
            self.quaternion = turned / np.linalg.norm(turned)
            self.linear, self.angular = self.linear + dt * a[:3], self.angular + dt * a[3:6]
            a = a[6:]
        self.q = self.q + dt * self.qd + 0.5 * dt * dt * a
        self.qd = self.qd + dt * a

    def glide(self, v, dt):
        """By constant velocities of the joints over a period."""
        self.q, self.qd = self.q + dt * v, v


class Joints:
    """Joints alone, in a library's order."""

    def __init__(self, order):
        self.order = np.asarray(order)

    def take(self, state):
        return state.q[self.order], state.qd[self.order]

    def give(self, state, values):
        mine = np.zeros(len(self.order))
        mine[self.order] = values
        return mine

    def torques(self, values):
        return Joints.give(self, None, values)


class World(Joints):
    """Base and joints; velocities and accelerations in world axes, quaternions w, x, y, z."""

    def take(self, state):
        v = np.concatenate([state.linear, state.angular, state.qd[self.order]])
        return state.position, np.roll(state.quaternion, 1), state.q[self.order], v

    def give(self, state, values):
        return np.concatenate([values[:6], super().give(state, values[6:])])


class Pinocchio(Joints):
    """Base and joints in one vector; velocities in body axes, and spatial accelerations."""

    def take(self, state):
        R = rotation_of(state.quaternion)
        q = np.concatenate([state.position, state.quaternion, state.q[self.order]])
        return q, np.concatenate([R.T @ state.linear, R.T @ state.angular, state.qd[self.order]])

    def give(self, state, values):
        joints = super().give(state, values[6:])
        if state.fixed:
            return joints
        R = rotation_of(state.quaternion)
        v, w = R.T @ state.linear, R.T @ state.angular
        return np.concatenate([R @ (values[:3] + np.cross(w, v)), R @ values[3:6], joints])

    def torques(self, values):
        return super().torques(values[-len(self.order) :])
