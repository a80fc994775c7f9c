#!/usr/bin/env python3
"""Writes quadruped/quadruped.urdf and humanoid/humanoid.urdf, beside this file.

    python3 robots/files/generate.py

The numbers and their sources are below and are repeated in the files. Needs the standard library only.
"""

from math import pi
from pathlib import Path

HERE = Path(__file__).parent
X, Y, Z = (1, 0, 0), (0, 1, 0), (0, 0, 1)


class Robot:
    """The lines of a URDF."""

    def __init__(self, name, comment):
        self.name = name
        self.lines = ['<?xml version="1.0"?>', "<!--", *comment.strip("\n").splitlines(), "-->",
                      f'<robot name="{name}">']

    def link(self, name, mass, com, inertia):
        """`inertia`: ixx, iyy, izz about the centre of mass, kg m^2; no products."""
        ixx, iyy, izz = inertia
        self.lines += [
            f'  <link name="{name}">',
            "    <inertial>",
            f'      <origin {vec("xyz", com)} rpy="0 0 0"/>',
            f'      <mass value="{num(mass)}"/>',
            f'      <inertia ixx="{num(ixx)}" ixy="0" ixz="0" iyy="{num(iyy)}" iyz="0" izz="{num(izz)}"/>',
            "    </inertial>",
            "  </link>",
        ]

    def joint(self, name, parent, child, xyz, axis, limits, effort, velocity):
        lower, upper = limits
        self.lines += [
            f'  <joint name="{name}" type="revolute">',
            f'    <parent link="{parent}"/>',
            f'    <child link="{child}"/>',
            f'    <origin {vec("xyz", xyz)} rpy="0 0 0"/>',
            f'    <axis {vec("xyz", axis)}/>',
            f'    <limit lower="{num(lower)}" upper="{num(upper)}" effort="{num(effort)}" velocity="{num(velocity)}"/>',
            "  </joint>",
        ]

    def frame(self, name, parent, xyz):
        """A link without mass on a fixed joint."""
        self.lines += [
            f'  <link name="{name}"/>',
            f'  <joint name="{name}_mount" type="fixed">',
            f'    <parent link="{parent}"/>',
            f'    <child link="{name}"/>',
            f'    <origin {vec("xyz", xyz)} rpy="0 0 0"/>',
            "  </joint>",
        ]

    def write(self):
        path = HERE / self.name / f"{self.name}.urdf"
        path.parent.mkdir(exist_ok=True)
        path.write_text("\n".join(self.lines + ["</robot>"]) + "\n")


def num(value):
    return f"{value + 0.0:.9g}"  # + 0.0: no minus zero


def vec(key, values):
    return f'{key}="{" ".join(num(v) for v in values)}"'


def box(mass, size):
    """Moments of inertia of a solid box, kg m^2."""
    x, y, z = (mass * s * s / 12 for s in size)
    return (y + z, x + z, x + y)


def ball(mass, density=1000.0):
    """Of a solid ball of that density, kg/m^3."""
    radius = (3 * mass / (4 * pi * density)) ** (1 / 3)
    return (0.4 * mass * radius**2,) * 3


QUADRUPED = """
  A quadruped with the published figures of Solo12. Written by robots/files/generate.py: edit that.

  Solo12: F. Grimminger, A. Meduri, M. Khadiv, J. Viereck, M. Wuethrich, M. Naveau, V. Berenz, S. Heim,
  F. Widmaier, T. Flayols, J. Fiene, A. Badri-Sproewitz, L. Righetti, "An Open Torque-Controlled Modular Robot
  Architecture for Legged Locomotion Research", RA-L 2020; drawings and masses of the Open Dynamic Robot Initiative.
  * mass 2.5 kg: trunk 1.161, hip and thigh 0.1485 each, shank 0.0307, foot 0.0069;
  * thigh and shank 0.16 m; hips 0.1946 m ahead of and behind the middle, 0.0875 m to the sides; from the axis
    of hip roll to that of the knee 0.0515 m, from there to the foot 0.008 m;
  * joint torque at most 2.7 N m.
  No third party's file was copied. Assumed: every link is a solid box of its outer size, its centre of mass in the
  middle; no rotor inertia; ranges of the joints; velocity limit 30 rad/s.

  SI units, radians. trunk: x forward, y left, z up, origin in the middle of the hips. At 0 the legs hang straight.
"""


def quadruped():
    robot = Robot("quadruped", QUADRUPED)
    robot.link("trunk", 1.161, (0, 0, 0), box(1.161, (0.389, 0.175, 0.05)))
    for leg, front, left in [("fl", 1, 1), ("fr", 1, -1), ("hl", -1, 1), ("hr", -1, -1)]:
        hip, thigh, shank = (f"{leg}_{part}" for part in ("hip", "thigh", "shank"))
        robot.link(hip, 0.1485, (0, 0.007 * left, 0), box(0.1485, (0.06, 0.04, 0.05)))
        robot.link(thigh, 0.1485, (0, 0.0187 * left, -0.08), box(0.1485, (0.03, 0.025, 0.16)))
        robot.link(shank, 0.0307, (0, 0.004 * left, -0.08), box(0.0307, (0.015, 0.015, 0.16)))
        robot.link(f"{leg}_foot", 0.0069, (0, 0, 0), ball(0.0069))
        robot.joint(f"{hip}_roll", "trunk", hip, (0.1946 * front, 0.0875 * left, 0), X, (-0.9, 0.9), 2.7, 30)
        robot.joint(f"{hip}_pitch", hip, thigh, (0, 0.014 * left, 0), Y, (-1.6, 1.6), 2.7, 30)
        robot.joint(f"{leg}_knee", thigh, shank, (0, 0.0375 * left, -0.16), Y, (-2.7, 2.7), 2.7, 30)
        robot.lines += [
            f'  <joint name="{leg}_foot_mount" type="fixed">',
            f'    <parent link="{shank}"/>',
            f'    <child link="{leg}_foot"/>',
            f'    <origin {vec("xyz", (0, 0.008 * left, -0.16))} rpy="0 0 0"/>',
            "  </joint>",
        ]
    robot.write()


HUMANOID = """
  A robot with the proportions of an adult: 1.75 m, 75 kg, 31 joints. Written by robots/files/generate.py: edit that.

  Masses, centres of mass and radii of gyration: D. A. Winter, "Biomechanics and Motor Control of Human Movement",
  table of anthropometric data (Dempster via Miller and Nelson, and Plagenhoef); lengths: R. Drillis and R. Contini,
  "Body Segment Parameters", 1966, as fractions of the height.
  * mass / body: foot 0.0145, shank 0.0465, thigh 0.1, pelvis 0.142, abdomen 0.139, thorax 0.216, upper arm 0.028,
    forearm 0.016, hand 0.006, head and neck 0.081;
  * length / height: ankle 0.039 above the ground, shank 0.246, thigh 0.245, hip to shoulder 0.288, upper arm 0.186,
    forearm 0.146, hand 0.108, foot 0.152 by 0.055, hips 0.191 and shoulders 0.259 apart, shoulder to ear 0.118;
  * centre of mass / length from the proximal end: shank and thigh 0.433, upper arm 0.436, forearm 0.430, hand 0.506;
    from the upper end: pelvis 0.105, abdomen 0.44, thorax 0.82;
  * radius of gyration about it / length: shank 0.302, thigh 0.323, upper arm 0.322, forearm 0.303, hand 0.297,
    head and neck 0.495.
  Assumed: hip to shoulder is shared by pelvis, abdomen and thorax as their masses are; trunk segments have
  the inertia of solid boxes of the hips' width (thorax 0.174 of the height), limbs are cylinders about their axis, all
  of 1000 kg/m^3; the ankle is a quarter of the foot's length behind its middle; a joint of several axes is taken apart
  into balls of a tenth of the mass of the segment that follows, which has the rest. Torque limits are of the size of
  TALOS' (O. Stasse et al., "TALOS: A new humanoid research platform targeted for industrial applications", Humanoids
  2017). No rotor inertia.

  SI units, radians. pelvis: x forward, y left, z up, origin midway between the hips. At 0 it stands straight, arms down.
"""


def humanoid(mass=75.0, height=1.75):
    robot = Robot("humanoid", HUMANOID)
    ankle, shank, thigh = 0.039 * height, 0.246 * height, 0.245 * height
    foot, breadth = 0.152 * height, 0.055 * height
    trunk = {"pelvis": 0.142, "abdomen": 0.139, "thorax": 0.216}
    length = {name: 0.288 * height * share / sum(trunk.values()) for name, share in trunk.items()}

    def trunk_link(name, m, width, com):
        h, w = length[name], width * height
        robot.link(name, m, (0, 0, (1 - com) * h), box(m, (m / (1000 * w * h), w, h)))

    def limb(name, m, extent, com, gyration):
        """A segment that hangs down from its joint."""
        across, along = m * (gyration * extent) ** 2, 0.5 * m * m / (pi * 1000 * extent)
        robot.link(name, m, (0, 0, -com * extent), (across, across, along))

    def compound(names, m):
        """All but the last link of a joint of several axes; what is left of the mass for the last."""
        for name in names:
            robot.link(name, 0.1 * m, (0, 0, 0), ball(0.1 * m))
        return m * (1 - 0.1 * len(names))

    def sided(lower, upper, left):
        return (lower, upper) if left > 0 else (-upper, -lower)

    trunk_link("pelvis", trunk["pelvis"] * mass, 0.191, 0.105)
    m = compound(["waist"], trunk["abdomen"] * mass)
    trunk_link("abdomen", m, 0.191, 0.44)
    trunk_link("thorax", trunk["thorax"] * mass, 0.174, 0.82)
    robot.joint("waist_yaw", "pelvis", "waist", (0, 0, length["pelvis"]), Z, (-1.2, 1.2), 150, 5)
    robot.joint("waist_roll", "waist", "abdomen", (0, 0, 0), X, (-0.4, 0.4), 150, 5)
    robot.joint("waist_pitch", "abdomen", "thorax", (0, 0, length["abdomen"]), Y, (-0.3, 0.8), 150, 5)

    m = compound(["neck"], 0.081 * mass)
    robot.link("head", m, (0, 0, 0.118 * height), (m * (0.495 * 0.118 * height) ** 2,) * 3)
    robot.joint("neck_yaw", "thorax", "neck", (0, 0, length["thorax"]), Z, (-1.3, 1.3), 8, 5)
    robot.joint("neck_pitch", "neck", "head", (0, 0, 0), Y, (-0.4, 0.8), 8, 5)

    for side, left in [("left", 1), ("right", -1)]:
        hip, femur, tibia, sole = (f"{side}_{part}" for part in ("hip", "thigh", "shank", "foot"))
        m = compound([f"{hip}_1", f"{hip}_2"], 0.1 * mass)
        limb(femur, m, thigh, 0.433, 0.323)
        limb(tibia, 0.0465 * mass, shank, 0.433, 0.302)
        m = compound([f"{side}_ankle"], 0.0145 * mass)
        robot.link(sole, m, (foot / 4, 0, -ankle / 2), box(m, (foot, breadth, ankle)))
        at = (0, 0.191 / 2 * height * left, 0)
        robot.joint(f"{hip}_yaw", "pelvis", f"{hip}_1", at, Z, sided(-0.5, 1.0, left), 100, 5)
        robot.joint(f"{hip}_roll", f"{hip}_1", f"{hip}_2", (0, 0, 0), X, sided(-0.5, 0.8, left), 160, 5)
        robot.joint(f"{hip}_pitch", f"{hip}_2", femur, (0, 0, 0), Y, (-2.1, 0.6), 160, 5)
        robot.joint(f"{side}_knee", femur, tibia, (0, 0, -thigh), Y, (0, 2.5), 300, 7)
        robot.joint(f"{side}_ankle_pitch", tibia, f"{side}_ankle", (0, 0, -shank), Y, (-1.2, 0.8), 160, 5)
        robot.joint(f"{side}_ankle_roll", f"{side}_ankle", sole, (0, 0, 0), X, (-0.5, 0.5), 100, 5)
        robot.frame(f"{side}_sole", sole, (foot / 4, 0, -ankle))

    for side, left in [("left", 1), ("right", -1)]:
        shoulder, humerus, forearm, hand = (f"{side}_{part}" for part in ("shoulder", "upper_arm", "forearm", "hand"))
        m = compound([f"{shoulder}_1", f"{shoulder}_2"], 0.028 * mass)
        limb(humerus, m, 0.186 * height, 0.436, 0.322)
        m = compound([f"{side}_elbow_1"], 0.016 * mass)
        limb(forearm, m, 0.146 * height, 0.430, 0.303)
        m = compound([f"{side}_wrist"], 0.006 * mass)
        limb(hand, m, 0.108 * height, 0.506, 0.297)
        at = (0, 0.259 / 2 * height * left, length["thorax"])
        robot.joint(f"{shoulder}_pitch", "thorax", f"{shoulder}_1", at, Y, (-3.0, 1.0), 44, 5)
        robot.joint(f"{shoulder}_roll", f"{shoulder}_1", f"{shoulder}_2", (0, 0, 0), X, sided(-0.3, 2.5, left), 44, 5)
        robot.joint(f"{shoulder}_yaw", f"{shoulder}_2", humerus, (0, 0, 0), Z, (-1.5, 1.5), 22, 5)
        robot.joint(f"{side}_elbow", humerus, f"{side}_elbow_1", (0, 0, -0.186 * height), Y, (-2.4, 0), 22, 5)
        robot.joint(f"{forearm}_yaw", f"{side}_elbow_1", forearm, (0, 0, 0), Z, (-1.5, 1.5), 17, 5)
        robot.joint(f"{side}_wrist_roll", forearm, f"{side}_wrist", (0, 0, -0.146 * height), X, (-0.6, 0.6), 8, 5)
        robot.joint(f"{side}_wrist_pitch", f"{side}_wrist", hand, (0, 0, 0), Y, (-0.8, 0.8), 8, 5)
        robot.frame(f"{side}_palm", hand, (0, 0, -0.054 * height))
    robot.write()


if __name__ == "__main__":
    quadruped()
    humanoid()
