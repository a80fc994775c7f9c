#!/usr/bin/env python3
"""Writes small robots with mimic joints, and what Pinocchio says of them, into `fixtures/mimic`.

    target/oracles-venv/bin/python tests/oracles/mimic_robots.py

Last run with Python 3.11.7, pin 4.1.0 and numpy 2.4.6; `pinocchio.json` also records them. Its keys, and how the
figures are computed, are those of `robot_collection.py` and `tree.py`; `robots` is a list with `file`, `what` and
`models`, per base the model itself.

Each robot has one habit; the last are random trees. Pinocchio has mimic joints of its own, but refuses them where the
leading joint comes later in its tree, where a mimic joint follows a mimic joint, and where only one of two is
continuous. Of these the key `mimic` says so, and the figures are G' M G of the free tree.
"""

import json
import platform
from pathlib import Path

import numpy as np
import pinocchio as pin

from tree import Tree, plain, state_entry

FIXTURES = Path(__file__).resolve().parent.parent / "fixtures" / "mimic"
SEED = 12
STATES = 2
FRAMES = 3


class Urdf:
    """A URDF in the making; what is not said about links and joints is random, in round figures."""

    def __init__(self, name, rng):
        self.rng, self.names = rng, []
        self.lines = [f'<robot name="{name}">']
        self.link("base")

    def numbers(self, low, high, count=3):
        return " ".join(f"{x:.2f}" for x in self.rng.uniform(low, high, count))

    def link(self, name):
        mass = self.rng.uniform(0.2, 2)
        x, y, z = (s * s * mass / 12 for s in self.rng.uniform(0.1, 0.4, 3))
        self.names.append(name)
        self.lines += [
            f'  <link name="{name}">',
            "    <inertial>",
            f'      <origin xyz="{self.numbers(-0.1, 0.1)}" rpy="{self.numbers(-1, 1)}"/>',
            f'      <mass value="{mass:.3f}"/>',
            f'      <inertia ixx="{y + z:.6f}" ixy="0" ixz="0" iyy="{x + z:.6f}" iyz="0" izz="{x + y:.6f}"/>',
            "    </inertial>",
            "  </link>",
        ]

    def joint(self, name, parent, kind="revolute", mimic=None):
        """The joint of the link `name`; `mimic` are the attributes beside it."""
        self.link(name)
        lower, upper = (-1, 1.5) if kind == "prismatic" else (-1.5, 2)
        range_ = "" if kind == "continuous" else f'lower="{lower}" upper="{upper}" '
        self.lines += [
            f'  <joint name="{name}_joint" type="{kind}">',
            f'    <parent link="{parent}"/>',
            f'    <child link="{name}"/>',
            f'    <origin xyz="{self.numbers(-0.3, 0.3)}" rpy="{self.numbers(-2, 2)}"/>',
            f'    <axis xyz="{self.numbers(-1, 1)}"/>',
            f'    <limit {range_}effort="20" velocity="5"/>',
        ]
        if mimic:
            leader, *numbers = mimic
            given = "".join(f' {key}="{x}"' for key, x in zip(["multiplier", "offset"], numbers) if x is not None)
            self.lines.append(f'    <mimic joint="{leader}_joint"{given}/>')
        self.lines.append("  </joint>")

    def text(self):
        return "\n".join([*self.lines, "</robot>"]) + "\n"


def leader_first(u):
    """a follower below its leader, with neither multiplier nor offset, another one on another branch, backwards"""
    u.joint("arm", "base")
    u.joint("elbow", "arm", mimic=("arm",))
    u.joint("tool", "elbow")
    u.joint("twin", "base", mimic=("arm", -1.5, 0.2))


def leader_later(u):
    """followers before their leaders: on an earlier branch, and as the leader's own parent"""
    u.joint("a_finger", "base", mimic=("b_finger", 0.8, -0.3))
    u.joint("b_finger", "base")
    u.joint("shoulder", "base", mimic=("elbow", -0.5, 0.1))
    u.joint("elbow", "shoulder")


def gripper(u):
    """two followers of one leader, prismatic, and one on a fixed joint, which follows nothing"""
    u.joint("wrist", "base")
    u.joint("left", "wrist", "prismatic")
    u.joint("right", "wrist", "prismatic", mimic=("left", -1))
    u.joint("third", "wrist", "prismatic", mimic=("left", 0.5, 0.05))
    u.joint("pad", "third", "fixed", mimic=("left", 2))


def mixed(u):
    """a slide that follows a hinge, in m/rad, a hinge that follows a slide, in rad/m"""
    u.joint("crank", "base")
    u.joint("piston", "crank", "prismatic", mimic=("crank", 0.12, 0.03))
    u.joint("slide", "base", "prismatic")
    u.joint("pinion", "slide", mimic=("slide", -9.5, -0.4))
    u.joint("tip", "pinion")


def chain(u):
    """mimic joints that follow mimic joints, a later one among them"""
    u.joint("knuckle", "base")
    u.joint("middle", "knuckle", mimic=("knuckle", 0.7, 0.1))
    u.joint("tip", "middle", mimic=("middle", -1.2, 0.25))
    u.joint("aside", "base", mimic=("zeta", 2, 0))
    u.joint("zeta", "base", mimic=("tip", 0.5, -0.1))


def wheels(u):
    """continuous joints: a wheel that follows a wheel"""
    u.joint("left_wheel", "base", "continuous")
    u.joint("right_wheel", "base", "continuous", mimic=("left_wheel", -1, 0.5))


def cam(u):
    """a joint with a range that follows one without, and the reverse"""
    u.joint("drum", "base", "continuous")
    u.joint("arm", "drum", mimic=("drum", 0.25, 0))
    u.joint("lever", "base")
    u.joint("gear", "base", "continuous", mimic=("lever", -4, 0.3))


def random_tree(u):
    """a random tree: about half of its joints follow one another or the others, whatever these are"""
    count = 9
    names = [f"part{i}" for i in u.rng.permutation(count)]
    ranks = u.rng.permutation(count)
    for i, name in enumerate(names):
        leaders = [other for j, other in enumerate(names) if ranks[j] < ranks[i]]
        u.joint(name, parent(u, names, i), kind(u), follower(u, leaders))


def ordered_tree(u):
    """a random tree: about half of its joints follow others nearer to the root, of their kind"""
    kinds, parents, free = {}, {"base": "base"}, set()
    names = [f"part{i}" for i in range(9)]
    for i, name in enumerate(names):
        kinds[name], parents[name] = kind(u), parent(u, names, i)
        leaders, link = [], parents[name]
        while link != "base":
            if link in free and kinds[link] == kinds[name]:
                leaders.append(link)
            link = parents[link]
        mimic = follower(u, leaders)
        if mimic is None:
            free.add(name)
        u.joint(name, parents[name], kinds[name], mimic)


def parent(u, names, i):
    return "base" if i == 0 else str(u.rng.choice(["base", *names[max(0, i - 3) : i]]))


def kind(u):
    return str(u.rng.choice(["revolute", "revolute", "prismatic", "continuous"]))


def follower(u, leaders):
    if not leaders or u.rng.uniform() < 0.45:
        return None
    multiplier = round(float(u.rng.uniform(0.3, 2) * u.rng.choice([-1, 1])), 2)
    return str(u.rng.choice(leaders)), multiplier, round(float(u.rng.uniform(-0.3, 0.3)), 2)


ROBOTS = {f.__name__: f for f in [leader_first, leader_later, gripper, mixed, chain, wheels, cam]}
ROBOTS |= {f"ordered_tree_{i}": ordered_tree for i in range(1, 4)}
ROBOTS |= {f"random_tree_{i}": random_tree for i in range(1, 4)}


def describe(text, floating, rng):
    tree = Tree(text, floating, FRAMES)
    states = []
    for _ in range(STATES):
        s = tree.random_state(rng)
        values = tree.quantities(s)
        tree.verify(s, values)
        states.append(state_entry(tree, s) | values)
    return dict(
        joints=tree.joints,
        mimics=[name for name in tree.relations if name not in tree.joints],
        mimic="coupled" if tree.coupled else tree.refusal.split("hint: ")[-1].strip(),
        total_mass=tree.free.total_mass(),
        states=states,
    )


def main():
    FIXTURES.mkdir(exist_ok=True)
    robots = []
    for index, (name, build) in enumerate(ROBOTS.items()):
        rng = np.random.default_rng([SEED, index])
        urdf = Urdf(name, rng)
        build(urdf)
        text = urdf.text()
        (FIXTURES / f"{name}.urdf").write_text(text)
        models = {base: describe(text, base == "floating", rng) for base in ["floating", "fixed"]}
        for base, model in models.items():
            print(f"{name}, {base}: {len(model['joints'])} + {len(model['mimics'])} joints, {model['mimic']}")
        robots.append(dict(file=f"{name}.urdf", what=build.__doc__, models=models))
    versions = dict(python=platform.python_version(), pinocchio=pin.__version__, numpy=np.__version__)
    # A robot a line.
    lines = ",\n".join(json.dumps(plain(robot)) for robot in robots)
    text = f'{{"versions": {json.dumps(versions)}, "robots": [\n{lines}\n]}}\n'
    (FIXTURES / "pinocchio.json").write_text(text)


if __name__ == "__main__":
    main()
