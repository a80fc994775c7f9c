"""What Pinocchio says of a robot given as the text of a URDF, in this project's conventions.

Notation
--------
World W has z up, the base frame R is the root link. Our velocity is world-aligned, `v = [v_WR; w_WR; qdot]`, linear
first; Pinocchio's free flyer is LOCAL, `v_L = X v` with `X = blkdiag(R', R', 1)`. Its derivative is
`a_L = X vdot + c` with `c = (-w_L x v_L, 0, 0)`, hence

    M = X' M_L X      h = X' (h_L + M_L c)      J = J_L X      Jdot v = Jdot_L v_L + J_L c

A fixed-base robot has v = qdot, X = 1, c = 0.

Mimic joints are no degrees of freedom: with `q_m = m q_l + o` for each, the velocities of the *free* tree (mimic joints
moving on their own) are `G v`, and `M = G' M_free G`, `h = G' h_free`, `J = J_free G`, `Jdot v` as it is. Pinocchio has
mimic joints of its own (`mimic=True`), which it refuses if the leading joint comes later in its tree. All quantities
are computed in the free tree, and where Pinocchio takes the mimic joints in its own one as well: the two have to agree.

`verify` compares with finite differences along a motion of our own parametrisation.
"""

import re
import xml.etree.ElementTree as ElementTree

import numpy as np
import pinocchio as pin

GRAVITY = np.array([0, 0, -9.81])
# Of a quantity's largest entry: what two ways to the same quantity may differ by.
AGREEMENT = 1e-10


class State:
    """Position p and attitude R of the base, q of the joints that are degrees of freedom, our v."""

    def __init__(self, p, R, q, v):
        self.p, self.R, self.q, self.v = p, R, q, v

    def moved(self, dt):
        """Where the constant velocity leads in dt: the base turns by a multiplication on the left."""
        if self.p is None:
            return State(None, None, self.q + dt * self.v, self.v)
        v = self.v
        return State(self.p + dt * v[:3], pin.exp3(dt * v[3:6]) @ self.R, self.q + dt * v[6:], v)


class Relation:
    """A joint's coordinate is multiplier * q[index] + offset."""

    def __init__(self, index, multiplier, offset):
        self.index, self.multiplier, self.offset = index, multiplier, offset


class Side:
    """One model of Pinocchio: the free tree, or the tree with Pinocchio's mimic joints."""

    def __init__(self, xml, floating, mimic, relations, joints):
        root = [pin.JointModelFreeFlyer()] if floating else []
        self.model = pin.buildModelFromXML(xml, *root, mimic)
        self.model.gravity.linear = GRAVITY
        assert not np.any(self.model.armature), "a URDF has no armature"
        self.data = self.model.createData()
        self.first = 6 if floating else 0
        moving = [i for i in range(2 if floating else 1, self.model.njoints) if self.model.joints[i].nv]
        assert all(self.model.joints[i].nv == 1 for i in moving), "joints of one degree of freedom"
        self.moving = [(self.model.joints[i], relations[self.model.names[i]]) for i in moving]
        # Velocities of this model are G v.
        self.G = np.zeros((self.model.nv, self.first + joints))
        self.G[: self.first, : self.first] = np.eye(self.first)
        for joint, relation in self.moving:
            self.G[joint.idx_v, self.first + relation.index] = relation.multiplier

    def local(self, s):
        """Pinocchio's q and v, the T of v_L = T v, and c."""
        q, c = pin.neutral(self.model), np.zeros(self.model.nv)
        for joint, relation in self.moving:
            angle = relation.multiplier * s.q[relation.index] + relation.offset
            q[joint.idx_q : joint.idx_q + joint.nq] = [angle] if joint.nq == 1 else [np.cos(angle), np.sin(angle)]
        T = self.G.copy()
        if self.first:
            q[:3], q[3:7] = s.p, pin.Quaternion(s.R).coeffs()
            T[:3, :3] = T[3:6, 3:6] = s.R.T
        v = T @ s.v
        if self.first:
            c[:3] = -np.cross(v[3:6], v[:3])
        return q, v, T, c

    def total_mass(self):
        return sum(inertia.mass for inertia in self.model.inertias)

    def com(self, s):
        """Of all links. Pinocchio's own leaves out the root link of a fixed base, which belongs to its joint 0."""
        q, _, _, _ = self.local(s)
        pin.forwardKinematics(self.model, self.data, q)
        moments = [b.mass * M.act(b.lever) for b, M in zip(self.model.inertias, self.data.oMi)]
        return sum(moments) / self.total_mass()

    def momentum(self, s):
        """Linear, and angular about the centre of mass, of all links."""
        q, v, _, _ = self.local(s)
        com = self.com(s)
        pin.forwardKinematics(self.model, self.data, q, v)
        total = pin.Force.Zero()
        for inertia, pose, velocity in zip(self.model.inertias, self.data.oMi, self.data.v):
            total += pose.act(inertia * velocity)
        return np.concatenate([total.linear, total.angular - np.cross(com, total.linear)])

    def energy(self, s):
        """Kinetic and potential."""
        q, v, _, _ = self.local(s)
        kinetic = pin.computeKineticEnergy(self.model, self.data, q, v)
        return kinetic - self.total_mass() * GRAVITY @ self.com(s)

    def frame(self, link):
        return self.model.getFrameId(link, pin.FrameType.BODY)

    def pose(self, s, link):
        q, _, _, _ = self.local(s)
        pin.framesForwardKinematics(self.model, self.data, q)
        pose = self.data.oMf[self.frame(link)]
        return pose.translation.copy(), pose.rotation.copy()

    def velocity(self, s, link):
        q, v, _, _ = self.local(s)
        pin.forwardKinematics(self.model, self.data, q, v)
        return pin.getFrameVelocity(self.model, self.data, self.frame(link), pin.LOCAL_WORLD_ALIGNED).vector.copy()

    def quantities(self, s, links):
        # New data: with mimic joints, a second crba on the same adds to forces that the first one left behind.
        model, data = self.model, self.model.createData()
        q, v, T, c = self.local(s)
        upper = np.triu(pin.crba(model, data, q))
        M = upper + np.triu(upper, 1).T
        result = dict(
            mass_matrix=T.T @ M @ T,
            h=T.T @ (pin.nonLinearEffects(model, data, q, v) + M @ c),
            com=self.com(s),
            momentum=dict(zip(["linear", "angular"], np.split(self.momentum(s), 2))),
            frames=[],
        )
        poses = [self.pose(s, link) for link in links]
        pin.computeJointJacobians(model, data, q)
        # The classical acceleration with a_L = c is Jdot_L v_L + J_L c.
        pin.forwardKinematics(model, data, q, v, c)
        for link, (p, R) in zip(links, poses):
            frame = self.frame(link)
            # A matrix of one column comes as a vector.
            J = pin.getFrameJacobian(model, data, frame, pin.LOCAL_WORLD_ALIGNED).reshape(6, model.nv) @ T
            bias = pin.getFrameClassicalAcceleration(model, data, frame, pin.LOCAL_WORLD_ALIGNED).vector
            result["frames"].append(dict(name=link, p=p, R=R, jacobian=J, bias=bias.copy()))
        return result


class Tree:
    """A robot's joints that are degrees of freedom, in Pinocchio's order, and its quantities in random states."""

    def __init__(self, text, floating, frames):
        robot, xml = ElementTree.fromstring(text.encode()), text
        if robot.get("name") is None:  # urdfdom, which reads for Pinocchio, refuses it
            xml = re.sub(r"<robot(?=[\s>])", '<robot name="unnamed"', text, count=1)
        self.floating = floating
        self.urdf = {e.get("name"): e for e in robot.findall("joint") if e.get("type") != "fixed"}
        names = list(pin.buildModelFromXML(xml, False).names)[1:]
        assert sorted(names) == sorted(self.urdf)
        self.joints = [name for name in names if self.mimic(name) is None]
        self.has_mimics = len(self.joints) < len(names)
        relations = {name: self.relation(name) for name in names}
        self.relations = relations
        self.free = Side(xml, floating, False, relations, len(self.joints))
        try:
            self.coupled = Side(xml, floating, True, relations, len(self.joints)) if self.has_mimics else None
            self.refusal = None
        except ValueError as error:
            self.coupled, self.refusal = None, str(error)
        self.links = spread([e.get("name") for e in robot.findall("link")], robot, frames)

    def mimic(self, name):
        """The <mimic> of a joint, unless it follows a joint that there is not: then it moves on its own."""
        mimic = self.urdf[name].find("mimic")
        return mimic if mimic is not None and mimic.get("joint") in self.urdf else None

    def relation(self, name):
        """Through mimic joints that follow mimic joints, to one that is a degree of freedom."""
        multiplier, offset = 1.0, 0.0
        for _ in range(len(self.urdf) + 1):
            mimic = self.mimic(name)
            if mimic is None:
                return Relation(self.joints.index(name), multiplier, offset)
            offset += multiplier * float(mimic.get("offset", 0))
            multiplier *= float(mimic.get("multiplier", 1))
            name = mimic.get("joint")
        raise ValueError(f"mimic joint {name} follows itself")

    def random_state(self, rng):
        """Joints within their limits, if they have some, and within 4 rad or 1 m; mimic joints where they are led to.

        With mimic joints within 3 rad: Pinocchio knows a continuous joint's angle up to whole turns, which are no whole
        turns of a joint that follows it with another multiplier.
        """
        q, rate = [], []
        for name in self.joints:
            prismatic = self.urdf[name].get("type") == "prismatic"
            limit = self.urdf[name].find("limit")
            range_ = 1.0 if prismatic else 3.0 if self.has_mimics else 4.0
            lower, upper = -range_, range_
            if self.urdf[name].get("type") != "continuous" and limit is not None:
                lower = max(lower, float(limit.get("lower", lower)))
                upper = min(upper, float(limit.get("upper", upper)))
            q.append(rng.uniform(lower, upper) if lower < upper else lower)
            rate.append(rng.uniform(-1, 1) * (0.5 if prismatic else 2))
        if not self.floating:
            return State(None, None, np.array(q), np.array(rate))
        quaternion = rng.normal(size=4)
        R = pin.Quaternion(*(quaternion / np.linalg.norm(quaternion))).toRotationMatrix()
        return State(rng.uniform(-1, 1, 3), R, np.array(q), np.concatenate([rng.uniform(-1.5, 1.5, 6), rate]))

    def quantities(self, s):
        values = self.free.quantities(s, self.links)
        if self.coupled:
            own = self.coupled.quantities(s, self.links)
            for a, b in zip([own, own["momentum"], *own["frames"]], [values, values["momentum"], *values["frames"]]):
                for key in a:
                    if isinstance(a[key], np.ndarray):
                        agree(a[key], b[key], f"Pinocchio's mimic joints: {key}", AGREEMENT)
            values = own
        return values

    def verify(self, s, values):
        """What finite differences along the motion with constant v, and energies, can say of every quantity."""
        side, v = self.free, s.v

        def along(f, dt=1e-4):  # fourth order
            at = lambda k: f(s.moved(k * dt))
            return (8 * (at(1) - at(-1)) - (at(2) - at(-2))) / (12 * dt)

        mass = side.total_mass()
        agree(values["momentum"]["linear"], mass * along(side.com), "linear momentum", 1e-6)
        kinetic = side.energy(s) + mass * GRAVITY @ side.com(s)
        agree(v @ values["mass_matrix"] @ v / 2, kinetic, "kinetic energy", 1e-9)
        # With vdot = 0, the power of the generalised forces h is what the energy gains.
        agree(v @ values["h"], along(side.energy), "power of h", 1e-6)
        for frame in values["frames"]:
            name = frame["name"]
            agree(frame["jacobian"] @ v, side.velocity(s, name), f"J of {name}", 1e-9)
            agree(frame["jacobian"][:3] @ v, along(lambda x: side.pose(x, name)[0]), f"J of {name}", 1e-6)
            agree(frame["bias"], along(lambda x: side.velocity(x, name)), f"bias of {name}", 1e-6)


def spread(links, robot, count):
    """The root link, then leaves and others in turn, evenly over the file: at most count of them."""
    parents = {e.find("parent").get("link") for e in robot.findall("joint")}
    children = {e.find("child").get("link") for e in robot.findall("joint")}
    root = [name for name in links if name not in children]
    leaves = [name for name in links if name in children and name not in parents]
    others = [name for name in links if name in children and name in parents]
    some = lambda names, n: [names[i * len(names) // n] for i in range(n)] if n < len(names) else names
    leaves = some(leaves, max(count * 2 // 3, count - 1 - len(others)))
    return (root + leaves + some(others, count - 1 - len(leaves)))[:count]


def agree(a, b, what, tolerance):
    a, b = np.asarray(a), np.asarray(b)
    error = np.max(np.abs(a - b)) / (1 + np.max(np.abs(b)))
    assert error <= tolerance, f"{what}: off by {error:.1e}"


def plain(value):
    """As JSON has it: matrices are lists of rows."""
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple, np.ndarray)):
        return value.tolist() if isinstance(value, np.ndarray) else [plain(item) for item in value]
    return value.item() if isinstance(value, np.generic) else value


def state_entry(tree, s):
    """A state as JSON, joints by name."""
    base = None
    if tree.floating:
        base = dict(p=s.p, quaternion_wxyz=np.roll(pin.Quaternion(s.R).coeffs(), 1))
    return dict(base=base, q=dict(zip(tree.joints, s.q)), v=s.v)
