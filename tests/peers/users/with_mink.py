"""What a user of mink writes for the jobs of the comparison from Python."""

import mink
import mujoco
import numpy as np
from motion import Joints


class Kinematics:
    velocity_level = True

    def __init__(self, job):
        self.dt = job.dt
        self.model = mujoco.MjModel.from_xml_path(job.urdf)
        self.configuration = mink.Configuration(self.model)
        cost = np.sqrt(job.tool.weight)
        self.tool = mink.FrameTask(job.frame, "body", position_cost=cost[:3], orientation_cost=cost[3:])
        posture = mink.PostureTask(self.model, cost=np.sqrt(job.posture.weight * job.posture.kp / job.tool.kp))
        posture.set_target(np.array([job.home[self.model.joint(i).name] for i in range(self.model.njnt)]))
        self.tasks = [self.tool, posture]
        self.limits = [mink.ConfigurationLimit(self.model), mink.VelocityLimit(self.model, job.velocity)]
        self.pose = np.concatenate([mink.SO3.from_matrix(np.array(job.rotation)).wxyz, np.zeros(3)])

    def step(self, time, q, v, wanted):
        self.configuration.update(q)
        self.pose[4:] = wanted[0]
        self.tool.set_target(mink.SE3(self.pose))
        velocity = mink.solve_ik(self.configuration, self.tasks, self.dt, "quadprog", limits=self.limits)
        return None, velocity, True

    def convention(self, job):
        return Joints([job.joints.index(self.model.joint(i).name) for i in range(self.model.njnt)])
