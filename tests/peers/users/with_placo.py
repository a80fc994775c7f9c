"""What a user of PlaCo writes for the jobs of the comparison from Python."""

import numpy as np
import placo
from motion import Pinocchio


class Arm:
    velocity_level = False

    def __init__(self, job):
        self.robot = placo.RobotWrapper(job.urdf, placo.Flags.ignore_collisions)
        self.solver = placo.DynamicsSolver(self.robot)
        self.solver.dt = job.dt
        self.solver.mask_fbase(True)
        self.solver.torque_cost = 0.0
        for joint in job.joints:
            self.robot.set_velocity_limit(joint, job.velocity[joint])
            self.solver.set_torque_limit(joint, job.effort[joint])
            self.solver.set_qdd_safe(joint, job.acceleration)
        self.solver.enable_torque_limits(True)
        self.solver.enable_velocity_limits(True)
        self.solver.enable_joint_limits(True)
        T = np.eye(4)
        T[:3, :3] = job.rotation
        tool = self.solver.add_frame_task(job.frame, T)
        tool.configure("tool", "soft", job.tool.weight[0], job.tool.weight[3])
        self.tool = tool.position()
        for part in (self.tool, tool.orientation()):
            part.kp, part.kd = job.tool.kp, job.tool.kd
        posture = self.solver.add_joints_task()
        posture.configure("posture", "soft", job.posture.weight)
        posture.kp, posture.kd = job.posture.kp, job.posture.kd
        posture.set_joints(job.home)

    def step(self, time, q, v, wanted):
        self.robot.state.q, self.robot.state.qd = q, v
        self.robot.update_kinematics()
        self.tool.target_world, self.tool.dtarget_world, self.tool.ddtarget_world = wanted
        result = self.solver.solve()
        return result.tau, result.qdd, result.success

    def convention(self, job):
        return Pinocchio([job.joints.index(joint) for joint in self.robot.joint_names()])


class Kinematics:
    velocity_level = True

    def __init__(self, job):
        self.dt = job.dt
        self.robot = placo.RobotWrapper(job.urdf, placo.Flags.ignore_collisions)
        self.solver = placo.KinematicsSolver(self.robot)
        self.solver.dt = job.dt
        self.solver.mask_fbase(True)
        for joint in job.joints:
            self.robot.set_velocity_limit(joint, job.velocity[joint])
        self.solver.enable_velocity_limits(True)
        self.solver.enable_joint_limits(True)
        T = np.eye(4)
        T[:3, :3] = job.rotation
        tool = self.solver.add_frame_task(job.frame, T)
        tool.configure("tool", "soft", job.tool.weight[0], job.tool.weight[3])
        self.tool = tool.position()
        posture = self.solver.add_joints_task()
        posture.configure("posture", "soft", job.posture.weight * job.posture.kp / job.tool.kp)
        posture.set_joints(job.home)

    def step(self, time, q, v, wanted):
        self.robot.state.q = q
        self.robot.update_kinematics()
        self.tool.target_world = wanted[0]
        return None, self.solver.solve(False) / self.dt, True

    def convention(self, job):
        return Pinocchio([job.joints.index(joint) for joint in self.robot.joint_names()])


class Stand:
    velocity_level = False

    def __init__(self, job):
        self.robot = placo.RobotWrapper(job.urdf, placo.Flags.ignore_collisions)
        self.solver = placo.DynamicsSolver(self.robot)
        self.solver.torque_cost = 0.0
        self.solver.enable_torque_limits(True)
        for joint in job.joints:
            self.solver.set_torque_limit(joint, job.effort[joint])
        self.com = self.solver.add_com_task(np.zeros(3))
        base = self.solver.add_orientation_task(job.base.frame, np.eye(3))
        posture = self.solver.add_joints_task()
        posture.set_joints({joint: job.home.get(joint, 0.0) for joint in job.joints})
        for name, task in (("com", self.com), ("base", base), ("posture", posture)):
            gains = getattr(job, name)
            task.configure(name, "soft", gains.weight)
            task.kp, task.kd = gains.kp, gains.kd
        for c in job.contacts:
            if c.kind == "full":
                task = self.solver.add_frame_task(c.frame, np.eye(4))
                task.configure(c.name, "hard", 1.0, 1.0)
                for part in (task.position(), task.orientation()):
                    part.kp, part.kd = 0.0, c.damping
                contact = self.solver.add_planar_contact(task)
                contact.length, contact.width = 2 * c.half_length_x, 2 * c.half_length_y
                contact.weight_forces, contact.weight_moments = c.weight[0], c.weight[3]
            else:
                task = self.solver.add_position_task(c.frame, np.zeros(3))
                task.configure(c.name, "hard")
                task.kp, task.kd = 0.0, c.damping
                contact = self.solver.add_unilateral_point_contact(task)
                contact.weight_forces = c.weight
            contact.mu, contact.weight_tangentials = c.friction, 0.0

    def step(self, time, q, v, wanted):
        self.robot.state.q, self.robot.state.qd = q, v
        self.robot.update_kinematics()
        self.com.target_world, self.com.dtarget_world, self.com.ddtarget_world = wanted
        result = self.solver.solve()
        return result.tau, result.qdd, result.success

    def convention(self, job):
        return Pinocchio([job.joints.index(joint) for joint in self.robot.joint_names()])
