"""What a user of TSID writes for the jobs of the comparison from Python."""

import warnings

import numpy as np
import pinocchio as pin
from motion import Joints, Pinocchio

with warnings.catch_warnings():
    # Of a converter that is registered twice.
    warnings.simplefilter("ignore", RuntimeWarning)
    # The package of version 1.7.1 has its `__init__` a folder too deep.
    import tsid.tsid_pywrap as tsid


class Arm:
    velocity_level = False

    def __init__(self, job):
        self.robot = robot = tsid.RobotWrapper(job.urdf, pin.StdVec_StdString(), False)
        self.formulation = formulation = tsid.InverseDynamicsFormulationAccForce("arm", robot, False)
        n, zero, names = robot.nv, np.zeros(robot.nv), list(robot.model().names)[1:]
        formulation.computeProblemData(0.0, np.array([job.home[joint] for joint in names]), zero)

        self.tool = tsid.TaskSE3Equality("tool", robot, job.frame)
        self.tool.setKp(np.full(6, job.tool.kp))
        self.tool.setKd(np.full(6, job.tool.kd))
        self.tool.useLocalFrame(False)
        # One weight per task: the two halves of a pose are two tasks.
        self.turning = tsid.TaskSE3Equality("turning", robot, job.frame)
        self.turning.setKp(np.full(6, job.tool.kp))
        self.turning.setKd(np.full(6, job.tool.kd))
        self.turning.useLocalFrame(False)
        self.tool.setMask(np.array([1.0, 1, 1, 0, 0, 0]))
        self.turning.setMask(np.array([0.0, 0, 0, 1, 1, 1]))
        formulation.addMotionTask(self.tool, job.tool.weight[0], 1, 0.0)
        formulation.addMotionTask(self.turning, job.tool.weight[3], 1, 0.0)
        self.sample = tsid.TrajectorySample(12, 6)
        self.pose, self.rate, self.acceleration = np.zeros(12), np.zeros(6), np.zeros(6)
        self.pose[3:] = np.array(job.rotation).T.ravel()
        self.sample.value(self.pose)
        self.turning.setReference(self.sample)

        self.posture = tsid.TaskJointPosture("posture", robot)
        self.posture.setKp(np.full(n, job.posture.kp))
        self.posture.setKd(np.full(n, job.posture.kd))
        formulation.addMotionTask(self.posture, job.posture.weight, 1, 0.0)
        rest = tsid.TrajectorySample(n)
        rest.value(np.array([job.home[joint] for joint in names]))
        rest.derivative(zero)
        rest.second_derivative(zero)
        self.posture.setReference(rest)

        self.torques = tsid.TaskActuationBounds("torques", robot)
        effort = np.array([job.effort[joint] for joint in names])
        self.torques.setBounds(-effort, effort)
        formulation.addActuationTask(self.torques, 1.0, 0, 0.0)
        self.limits = tsid.TaskJointPosVelAccBounds("limits", robot, job.dt, False)
        model = robot.model()
        self.limits.setPositionBounds(model.lowerPositionLimit, model.upperPositionLimit)
        self.limits.setVelocityBounds(np.array([job.velocity[joint] for joint in names]))
        self.limits.setAccelerationBounds(np.full(n, job.acceleration))
        self.limits.setImposeBounds(True, True, True, True)
        formulation.addMotionTask(self.limits, 1.0, 0, 0.0)

        self.solver = tsid.SolverHQuadProgFast("solver")
        self.solver.resize(formulation.nVar, formulation.nEq, formulation.nIn)

    def step(self, time, q, v, wanted):
        self.pose[:3], self.rate[:3], self.acceleration[:3] = wanted
        self.sample.value(self.pose)
        self.sample.derivative(self.rate)
        self.sample.second_derivative(self.acceleration)
        self.tool.setReference(self.sample)
        solution = self.solver.solve(self.formulation.computeProblemData(time, q, v))
        acceleration = self.formulation.getAccelerations(solution)
        return self.formulation.getActuatorForces(solution), acceleration, solution.status == 0

    def convention(self, job):
        return Joints([job.joints.index(joint) for joint in list(self.robot.model().names)[1:]])


class Stand:
    velocity_level = False

    def __init__(self, job):
        self.robot = robot = tsid.RobotWrapper(job.urdf, pin.StdVec_StdString(), pin.JointModelFreeFlyer(), False)
        self.formulation = formulation = tsid.InverseDynamicsFormulationAccForce("stand", robot, False)
        names, n = list(robot.model().names)[2:], robot.na
        home = np.array([job.home.get(joint, 0.0) for joint in names])
        start = np.concatenate([job.position, [0.0, 0.0, 0.0, 1.0], home])
        formulation.computeProblemData(0.0, start, np.zeros(robot.nv))

        self.com = tsid.TaskComEquality("com", robot)
        self.com.setKp(np.full(3, job.com.kp))
        self.com.setKd(np.full(3, job.com.kd))
        formulation.addMotionTask(self.com, job.com.weight, 1, 0.0)
        self.sample = tsid.TrajectorySample(3)

        self.base = tsid.TaskSE3Equality("base", robot, job.base.frame)
        self.base.setMask(np.array([0.0, 0, 0, 1, 1, 1]))
        self.base.useLocalFrame(False)
        self.base.setKp(np.full(6, job.base.kp))
        self.base.setKd(np.full(6, job.base.kd))
        formulation.addMotionTask(self.base, job.base.weight, 1, 0.0)
        level = tsid.TrajectorySample(12, 6)
        level.value(pin.SE3.Identity())
        self.base.setReference(level)

        self.posture = tsid.TaskJointPosture("posture", robot)
        self.posture.setKp(np.full(n, job.posture.kp))
        self.posture.setKd(np.full(n, job.posture.kd))
        formulation.addMotionTask(self.posture, job.posture.weight, 1, 0.0)
        rest = tsid.TrajectorySample(n)
        rest.value(home)
        rest.derivative(np.zeros(n))
        rest.second_derivative(np.zeros(n))
        self.posture.setReference(rest)

        self.torques = tsid.TaskActuationBounds("torques", robot)
        effort = np.array([job.effort[joint] for joint in names])
        self.torques.setBounds(-effort, effort)
        formulation.addActuationTask(self.torques, 1.0, 0, 0.0)

        up = np.array([0.0, 0.0, 1.0])
        self.contacts = []
        for c in job.contacts:
            if c.kind == "full":
                x, y = c.half_length_x, c.half_length_y
                corners = np.array([[-x, -x, x, x], [-y, y, -y, y], [0.0] * 4])
                contact = tsid.Contact6d(c.name, robot, c.frame, corners, up, c.friction, c.force_min, c.force_max)
                contact.setRegularizationTaskWeightVector(np.sqrt(c.weight))
                size, force_weight = 6, 1.0
            else:
                contact = tsid.ContactPoint(c.name, robot, c.frame, up, c.friction, c.force_min, c.force_max)
                contact.useLocalFrame(False)
                contact.setRegularizationTaskWeightVector(np.ones(3))
                size, force_weight = 3, c.weight
            contact.setKp(np.zeros(size))
            contact.setKd(np.full(size, c.damping))
            contact.setReference(robot.framePosition(formulation.data(), robot.model().getFrameId(c.frame)))
            formulation.addRigidContact(contact, force_weight)
            self.contacts.append(contact)
        self.solver = tsid.SolverHQuadProgFast("solver")
        self.solver.resize(formulation.nVar, formulation.nEq, formulation.nIn)

    def step(self, time, q, v, wanted):
        value, rate, acceleration = wanted
        self.sample.value(value)
        self.sample.derivative(rate)
        self.sample.second_derivative(acceleration)
        self.com.setReference(self.sample)
        solution = self.solver.solve(self.formulation.computeProblemData(time, q, v))
        acceleration = self.formulation.getAccelerations(solution)
        return self.formulation.getActuatorForces(solution), acceleration, solution.status == 0

    def convention(self, job):
        return Pinocchio([job.joints.index(joint) for joint in list(self.robot.model().names)[2:]])
