"""What a user of wbqp writes for the jobs of the comparison from Python."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import wbqp
from motion import Joints, World


@wbqp.reference("peers.given")
@dataclass
class Given:
    """What is handed over in every step: value, rate and acceleration."""

    now: ClassVar[tuple] = ()

    def sample(self, time):
        return Given.now


class Arm:
    velocity_level = False

    def __init__(self, job):
        self.controller = wbqp.Controller(
            rate=1.0 / job.dt,
            robot={"file": job.urdf, "base": "fixed", "home": job.home,
                   "options": {"effort": job.effort, "velocity": job.velocity}},
            tasks=[
                wbqp.tasks.FramePose(name="tool", frame=job.frame, kp=job.tool.kp, kd=job.tool.kd,
                                     weight=job.tool.weight, position=self.reference(job)),
                wbqp.tasks.Posture(kp=job.posture.kp, kd=job.posture.kd, weight=job.posture.weight),
            ],
            constraints=[wbqp.constraints.ActuatorLimits(),
                         wbqp.constraints.JointLimits(acceleration=job.acceleration)],
        )
        self.m = self.controller.measurement()
        self.q, self.v = np.asarray(self.m.q), np.asarray(self.m.v)

    def reference(self, job):
        return Given()

    def step(self, time, q, v, wanted):
        self.m.time, self.q[:], self.v[:] = time, q, v
        Given.now = wanted
        command, report = self.controller.tick(self.m)
        return command.effort, report.vdot, report.level == "optimal"

    def convention(self, job):
        return Joints([job.joints.index(joint) for joint in self.controller.robot.joints])


class Stand:
    velocity_level = False

    def __init__(self, job):
        tasks = [
            wbqp.tasks.Com(kp=job.com.kp, kd=job.com.kd, weight=job.com.weight, reference=self.reference(job)),
            wbqp.tasks.BaseOrientation(kp=job.base.kp, kd=job.base.kd, weight=job.base.weight),
            wbqp.tasks.Posture(kp=job.posture.kp, kd=job.posture.kd, weight=job.posture.weight),
        ]
        contacts, constraints = [], [wbqp.constraints.ActuatorLimits()]
        for c in job.contacts:
            contacts.append(wbqp.Contact(
                name=c.name, frame=c.frame, kind=c.kind, friction=c.friction, force_max=c.force_max, active=True,
                surface={"normal": [0, 0, 1], "x_axis": [1, 0, 0]}))
            tasks.append(wbqp.tasks.ConstantForce(name=f"force_{c.name}", contact=c.name, normal=0.0, weight=c.weight))
            constraints.append(wbqp.constraints.ContactMotion(contact=c.name, damping=c.damping))
            if c.kind == "full":
                constraints.append(wbqp.constraints.ContactWrench(
                    contact=c.name, half_length_x=c.half_length_x, half_length_y=c.half_length_y,
                    torsional_friction=100.0, approximation="outer"))
            else:
                constraints.append(wbqp.constraints.FrictionPyramid(contact=c.name, approximation="outer"))
        robot = {"file": job.urdf, "home": job.home, "options": {"effort": job.effort}}
        self.controller = wbqp.Controller(
            rate=1.0 / job.dt, robot=robot, contacts=contacts, tasks=tasks, constraints=constraints)
        self.m = self.controller.measurement()
        self.q, self.v = np.asarray(self.m.q), np.asarray(self.m.v)

    def reference(self, job):
        return Given()

    def step(self, time, position, quaternion, q, v, wanted):
        m = self.m
        m.time, m.position, m.quaternion, self.q[:], self.v[:] = time, position, quaternion, q, v
        Given.now = wanted
        command, report = self.controller.tick(m)
        return command.effort, report.vdot, report.level == "optimal"

    def convention(self, job):
        return World([job.joints.index(joint) for joint in self.controller.robot.joints])


def ellipse(job):
    """The path as a reference of wbqp's own: nothing has to be handed over."""
    p = job.path
    return wbqp.references.Ellipse(semi_axes=p.semi_axes, axes=p.axes, phase=p.phase, turns=p.turns,
                                   duration=p.duration, from_=p.start)


class ArmByItself(Arm):
    def reference(self, job):
        return ellipse(job)

    def step(self, time, q, v, wanted):
        self.m.time, self.q[:], self.v[:] = time, q, v
        command, report = self.controller.tick(self.m)
        return command.effort, report.vdot, report.level == "optimal"


class StandByItself(Stand):
    def reference(self, job):
        return ellipse(job)

    def step(self, time, position, quaternion, q, v, wanted):
        m = self.m
        m.time, m.position, m.quaternion, self.q[:], self.v[:] = time, position, quaternion, q, v
        command, report = self.controller.tick(m)
        return command.effort, report.vdot, report.level == "optimal"
