"""What wbqp_peer.rs records, as the comparison's Python programs read it."""

import numpy as np


def read_problem(file):
    """Lines of a name and words."""
    with open(file) as lines:
        return {words[0]: words[1:] for words in map(str.split, lines)}


def rotation_of(quaternion):
    """Of a quaternion x, y, z, w."""
    x, y, z, w = quaternion
    return np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ])


class Tick:
    """One line; velocities world-aligned."""

    def __init__(self, numbers, joints, contacts):
        self.numbers = numbers
        rest = iter(np.split(numbers, np.cumsum(
            [1, 3, 4, joints, 3, 3, joints, 3, 3, 3, 4, 3, 3] + [1, 3, 3, 3] * contacts)))
        self.time = next(rest)[0]
        self.position, self.quaternion, self.q = next(rest), next(rest), next(rest)
        self.linear, self.angular, self.qd = next(rest), next(rest), next(rest)
        self.rotation = rotation_of(self.quaternion)
        self.com = next(rest), next(rest), next(rest)
        self.base = rotation_of(next(rest)), next(rest), next(rest)
        self.on, self.swing = [], []
        for _ in range(contacts):
            self.on.append(next(rest)[0] != 0.0)
            self.swing.append((next(rest), next(rest), next(rest)))


class States:
    def __init__(self, file):
        with open(file) as lines:
            self.joints, self.contacts = next(lines).split()[1:], next(lines).split()[1:]
            self.posture = np.array(next(lines).split()[1:], dtype=float)
            self.ticks = [
                Tick(np.array(line.split(), dtype=float), len(self.joints), len(self.contacts)) for line in lines
            ]

    def write(self, file):
        with open(file, "w") as out:
            out.write(f"joints {' '.join(self.joints)}\ncontacts {' '.join(self.contacts)}\n")
            out.write(f"posture {' '.join(map(repr, map(float, self.posture)))}\n")
            for tick in self.ticks:
                out.write(" ".join(map(repr, map(float, tick.numbers))) + "\n")
