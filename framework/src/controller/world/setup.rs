//! Sets the measured world up: at home before the first tick, and where a request or a record puts the robot.

use nalgebra::{DVector, UnitQuaternion, Vector6};

use super::{super::measurement::Measurement, World};
use crate::{contact::ContactBinding, plugin::PreviousSolution};
use wbqp_dynamics::{Data, FrameKinematics, model::FrameId};
use wbqp_robot_model::RobotModel;

impl World {
    /// The robot at home and at rest, before the first tick; nothing is computed yet.
    pub(crate) fn new(
        robot: &RobotModel,
        period: f64,
        bindings: Vec<ContactBinding>,
        frame_ids: Vec<FrameId>,
    ) -> Self {
        let model = robot.model.clone();
        let contacts = bindings.iter().map(|b| b.initial_state(&model));
        Self {
            period,
            elapsed: period,
            is_continuous: false,
            slew_time: period,
            time: 0.0,
            origin: None,
            state: robot.home.clone(),
            data: Data::new(&model),
            frames: frame_ids
                .iter()
                .map(|_| FrameKinematics::new(&model))
                .collect(),
            frame_ids,
            contacts: contacts.collect(),
            last: PreviousSolution {
                virtual_input: DVector::zeros(model.nv()),
                vdot: DVector::zeros(model.nv()),
                effort: DVector::zeros(robot.nu()),
            },
            bindings,
            observer: None,
            model,
        }
    }

    /// The same with everything computed that depends on the home posture, for what is asked while plug-ins are bound.
    pub(crate) fn at_home(robot: &RobotModel, period: f64, bindings: &[ContactBinding]) -> Self {
        let mut world = Self::new(robot, period, bindings.to_vec(), Vec::new());
        world.update_bodies();
        let contacts = world.contacts.iter_mut().zip(&mut world.bindings);
        for (contact, binding) in contacts {
            binding.place(&world.model, &world.data, contact);
        }
        world
    }

    /// Computes what it has not computed yet of these frames, of which it knows the first ones.
    pub(crate) fn look_at(&mut self, frame_ids: &[FrameId]) {
        for &id in frame_ids.iter().skip(self.frame_ids.len()) {
            let mut frame = FrameKinematics::new(&self.model);
            frame.update(&self.model, &self.data, id);
            self.frames.push(frame);
            self.frame_ids.push(id);
        }
    }

    /// Computes everything that depends on the state alone, for a state that was recorded; what contacts remember is
    /// void afterwards.
    pub(crate) fn refresh(&mut self) {
        self.update_bodies();
        let contacts = self.contacts.iter_mut().zip(&mut self.bindings);
        for (contact, binding) in contacts {
            binding.update(
                self.time,
                self.period,
                &self.model,
                &self.data,
                &Vector6::zeros(),
                contact,
            );
        }
    }

    /// The robot is elsewhere: everything that depends on its state, and filters without a past.
    pub(crate) fn restart(&mut self, m: &Measurement) {
        self.state.copy_from(&m.state);
        self.state.R_WR = UnitQuaternion::new_normalize(*m.state.R_WR.quaternion());
        self.update_bodies();
        let contacts = self.contacts.iter_mut().zip(&mut self.bindings);
        for ((contact, binding), wrench) in contacts.zip(&m.wrenches) {
            binding.place(&self.model, &self.data, contact);
            binding.zero.mean = Some(*wrench);
            binding.filtered = binding.sense(wrench, contact);
        }
    }

    /// Goes on counting from a clock that was set.
    pub(crate) fn rebase(&mut self, stamp: f64) {
        self.origin = Some(stamp - self.next_time());
    }

    /// When the next tick is expected, s: what is asked for between two ticks counts from there.
    pub(crate) fn next_time(&self) -> f64 {
        match self.origin {
            Some(_) => self.time + self.period,
            None => 0.0,
        }
    }
}
