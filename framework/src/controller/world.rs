//! The measured world of one tick: state, dynamics, frames and contacts, computed once.
//!
//! # Notation
//! W world, R base, E a contact's frame on the robot, C the surface's frame at the contact point.
#![allow(non_snake_case)]

use std::sync::Arc;

use nalgebra::{
    DVector, Isometry3, Matrix3, Matrix6xX, Rotation3, Translation3, UnitQuaternion, Vector3,
    Vector6,
};

use super::{measurement::Measurement, observer::Observer, record::ContactMemory};
use crate::{
    contact::{
        ContactSpec, ContactState, FreeForce, SurfaceMotion,
        sensor_zero::{CUTOFF, SensorZero},
    },
    error::BindError,
    plugin::{EntryState, PreviousSolution, Tick},
    problem::{BoundEntry, DynamicsTerms, Problem},
    robot::RobotModel,
    switch::Switch,
};
use wbqp_dynamics::{
    Data, FrameKinematics,
    model::{BodyId, FrameId, Model},
    state::State,
};

/// State, dynamics, requested frames and contacts.
#[derive(Debug)]
pub(crate) struct World {
    pub(crate) model: Arc<Model>,
    pub(crate) period: f64,
    /// Time that this tick stands for, s, see [`elapsed`](super::elapsed).
    pub(crate) elapsed: f64,
    /// Time for which `slew` counts in this tick, s.
    pub(crate) slew_time: f64,
    /// Time since the first tick, s.
    pub(crate) time: f64,
    /// The measurement's time at the first tick.
    pub(crate) origin: Option<f64>,
    pub(crate) state: State,
    pub(crate) data: Data,
    pub(crate) frame_ids: Vec<FrameId>,
    pub(crate) frames: Vec<FrameKinematics>,
    pub(crate) contacts: Vec<ContactState>,
    pub(crate) last: PreviousSolution,
    pub(crate) bindings: Vec<ContactBinding>,
    pub(crate) observer: Option<Observer>,
}

/// What a contact needs besides its state.
#[derive(Clone, Debug)]
pub(crate) struct ContactBinding {
    pub(crate) spec: ContactSpec,
    pub(crate) switch: Switch,
    /// Whether it is switched on in this tick.
    pub(crate) switched_on: bool,
    body: BodyId,
    X_BC: Isometry3<f64>,
    kinematics: FrameKinematics,
    /// Normal force of the solution when the contact was switched off.
    exit_force: f64,
    /// Ramp at that moment.
    exit_alpha: f64,
    /// Low-passed force in the free directions, C axes, N.
    filtered: Vector3<f64>,
    pub(crate) zero: SensorZero,
    motion: SurfaceMotion,
    /// Shares of a new sample in the low-passes of the free force and of the sensor's mean reading, one period after
    /// the one before.
    shares: [f64; 2],
    period: f64,
}

impl ContactBinding {
    pub(crate) fn new(spec: &ContactSpec, model: &Model, period: f64) -> Result<Self, BindError> {
        spec.validate()?;
        let id = model.frame(&spec.frame).ok_or_else(|| {
            let known = model.frames().iter().map(|f| f.name.as_str());
            BindError::unknown("frame", &spec.frame, known)
        })?;
        let frame = &model.frames()[id.index()];
        let offset = Translation3::from(Vector3::from(spec.offset));
        Ok(Self {
            switch: Switch::new(spec.active, spec.transition),
            switched_on: false,
            body: frame.body,
            X_BC: frame.X_BF * offset,
            kinematics: FrameKinematics::new(model),
            exit_force: 0.0,
            exit_alpha: 1.0,
            filtered: Vector3::zeros(),
            zero: SensorZero::default(),
            motion: SurfaceMotion::fixed(
                spec.surface.rotation()?,
                Vector3::from(spec.surface.origin),
            ),
            shares: [spec.free_force_cutoff, CUTOFF].map(|cutoff| low_pass(cutoff, period)),
            period,
            spec: spec.clone(),
        })
    }

    /// The state before the first tick.
    pub(crate) fn initial_state(&self, model: &Model) -> ContactState {
        let spec = &self.spec;
        ContactState {
            kind: spec.kind,
            live: spec.active,
            alpha: if spec.active { 1.0 } else { 0.0 },
            since: f64::NEG_INFINITY,
            R_WC: self.motion.R_WC,
            p_WS: self.motion.p_WS,
            p_SC: Vector3::zeros(),
            R_CE: Rotation3::identity(),
            V: Vector6::zeros(),
            J: Matrix6xX::zeros(model.nv()),
            Jdot_v: Vector6::zeros(),
            surface_acceleration: Vector6::zeros(),
            friction: spec.friction,
            force_limits: [spec.force_min, spec.force_max],
            measured: Vector6::zeros(),
            measured_at_switch: Vector6::zeros(),
            free_force: Vector6::zeros(),
            set_point: Vector3::zeros(),
            solution: Vector6::zeros(),
        }
    }

    /// Begins a switch that was asked for, at the time of this tick and with its measurement.
    fn settle(&mut self, now: f64, c: &mut ContactState) {
        let exit_alpha = self.switch.alpha(now).max(1e-9);
        let switched = self.switch.settle(now);
        self.switched_on = switched == Some(true);
        match switched {
            Some(true) => {
                c.measured_at_switch = c.measured;
                self.filtered = Vector3::new(c.measured[0], c.measured[1], c.measured[2]);
            }
            Some(false) => {
                self.exit_force = c.solution[2];
                self.exit_alpha = exit_alpha;
            }
            None => {}
        }
    }

    /// Moves the surface from the next tick on.
    pub(crate) fn move_surface(&mut self, motion: &SurfaceMotion) {
        self.motion = *motion;
    }

    /// What an earlier tick at this time knew of the contact, for a state that is there again.
    pub(crate) fn place_again(
        &mut self,
        time: f64,
        model: &Model,
        data: &Data,
        c: &mut ContactState,
    ) {
        self.place(model, data, c);
        c.alpha = self.switch.alpha(time);
        c.live = self.switch.is_live(time);
        c.since = self.switch.since();
    }

    /// Where the contact is, and how it moves.
    fn place(&mut self, model: &Model, data: &Data, c: &mut ContactState) {
        let k = &mut self.kinematics;
        k.update_at(model, data, self.body, &self.X_BC);
        c.R_WC = self.motion.R_WC;
        c.p_WS = self.motion.p_WS;
        let R_CW = c.R_WC.inverse();
        c.p_SC = R_CW * (k.p_WF - c.p_WS);
        c.R_CE = R_CW * k.R_WF;
        let rotate = |v: &Vector6<f64>| {
            let linear = R_CW * Vector3::new(v[0], v[1], v[2]);
            let angular = R_CW * Vector3::new(v[3], v[4], v[5]);
            Vector6::new(
                linear.x, linear.y, linear.z, angular.x, angular.y, angular.z,
            )
        };
        let velocity = Vector6::new(k.v_WF.x, k.v_WF.y, k.v_WF.z, k.w_WF.x, k.w_WF.y, k.w_WF.z);
        c.V = rotate(&(velocity - self.motion.velocity_at(&k.p_WF)));
        c.surface_acceleration = rotate(&self.motion.acceleration_at(&k.p_WF));
        c.Jdot_v = rotate(&k.Jdot_v);
        let (columns, _) = k.J.as_slice().as_chunks::<6>();
        let (rotated, _) = c.J.as_mut_slice().as_chunks_mut::<6>();
        for (out, column) in rotated.iter_mut().zip(columns) {
            // Joints that do not carry the contact.
            *out = if *column == [0.0; 6] {
                [0.0; 6]
            } else {
                rotate(&Vector6::from(*column)).into()
            };
        }
    }

    /// The measured force and moment, in C axes about the contact point.
    fn sense(&self, wrench: &Vector6<f64>, c: &mut ContactState) -> Vector3<f64> {
        let wrench = self.zero.correct(wrench);
        // The sensor speaks in E about E's origin; the contact point is the offset away.
        let force = Vector3::new(wrench[0], wrench[1], wrench[2]);
        let moment = Vector3::new(wrench[3], wrench[4], wrench[5])
            - Vector3::from(self.spec.offset).cross(&force);
        let (force, moment) = (c.R_CE * force, c.R_CE * moment);
        c.measured = Vector6::new(force.x, force.y, force.z, moment.x, moment.y, moment.z);
        force
    }

    fn update(
        &mut self,
        time: f64,
        elapsed: f64,
        model: &Model,
        data: &Data,
        wrench: &Vector6<f64>,
        c: &mut ContactState,
    ) {
        self.place(model, data, c);
        let [free, mean] = if elapsed == self.period {
            self.shares
        } else {
            [self.spec.free_force_cutoff, CUTOFF].map(|cutoff| low_pass(cutoff, elapsed))
        };
        self.zero.follow(wrench, mean);
        let force = self.sense(wrench, c);
        self.filtered += (force - self.filtered) * free;
        self.settle(time, c);
        c.alpha = self.switch.alpha(time);
        c.live = self.switch.is_live(time);
        c.since = self.switch.since();
        c.free_force = Vector6::zeros();
        if c.live && self.spec.free_force == FreeForce::Measured {
            let limit = self.spec.free_force_limit;
            for &direction in self.spec.kind.free().iter().filter(|&&d| d < 3) {
                c.free_force[direction] = c.alpha * self.filtered[direction].clamp(-limit, limit);
            }
        }
        c.force_limits = if self.switch.is_on() {
            [c.alpha * self.spec.force_min, c.alpha * self.spec.force_max]
        } else {
            // From the force at the switch to zero, whichever ramp was under way.
            let ramp = c.alpha / self.exit_alpha;
            let force = self.exit_force.max(0.0);
            [c.alpha * self.spec.force_min.min(force), ramp * force]
        };
        if !c.live {
            c.solution = Vector6::zeros();
            c.set_point = Vector3::zeros();
        }
    }
}

/// Share of a new sample in a low-pass with this cutoff, Hz, so many seconds after the one before.
pub(super) fn low_pass(cutoff: f64, seconds: f64) -> f64 {
    1.0 - (-std::f64::consts::TAU * cutoff * seconds).exp()
}

/// For records of ticks.
impl ContactBinding {
    /// Writes what is remembered from one tick to the next.
    pub(crate) fn remember(&self, out: &mut ContactMemory) {
        out.switch = self.switch;
        out.exit_force = self.exit_force;
        out.exit_alpha = self.exit_alpha;
        out.filtered = self.filtered.into();
        out.mean_reading = self.zero.mean.map(Into::into);
        out.sensor_zero = self.zero.offset.into();
        for (out, r) in out.rotation.iter_mut().zip(self.motion.R_WC.matrix()) {
            *out = *r;
        }
        let m = &self.motion;
        out.motion = [m.p_WS, m.v_WS, m.w_WC, m.a_WS, m.alpha_WC].map(Into::into);
    }

    /// Takes it over again.
    pub(crate) fn recall(&mut self, memory: &ContactMemory) {
        self.switch = memory.switch;
        self.exit_force = memory.exit_force;
        self.exit_alpha = memory.exit_alpha;
        self.filtered = memory.filtered.into();
        self.zero = SensorZero {
            mean: memory.mean_reading.map(Into::into),
            offset: memory.sensor_zero.into(),
        };
        let [p_WS, v_WS, w_WC, a_WS, alpha_WC] = memory.motion.map(Vector3::from);
        let rotation = Matrix3::from_column_slice(&memory.rotation);
        self.motion = SurfaceMotion {
            R_WC: Rotation3::from_matrix_unchecked(rotation),
            p_WS,
            v_WS,
            w_WC,
            a_WS,
            alpha_WC,
        };
    }
}

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

    fn update_bodies(&mut self) {
        self.data.update(&self.model, &self.state);
        for (frame, id) in self.frames.iter_mut().zip(&self.frame_ids) {
            frame.update(&self.model, &self.data, *id);
        }
    }

    /// Takes a measurement over and computes everything that depends on it.
    pub(crate) fn measure(&mut self, m: &Measurement) {
        self.take_state(m);
        for ((binding, contact), wrench) in self
            .bindings
            .iter_mut()
            .zip(&mut self.contacts)
            .zip(&m.wrenches)
        {
            binding.update(
                self.time,
                self.elapsed,
                &self.model,
                &self.data,
                wrench,
                contact,
            );
        }
    }

    /// Takes the state of a measurement over, whose wrenches are not usable: what contacts measured stays what it was.
    /// Contacts are switched off, but not on, for which the measured force would be needed.
    pub(crate) fn look(&mut self, m: &Measurement) {
        self.take_state(m);
        let contacts = self.contacts.iter_mut().zip(&mut self.bindings);
        for (contact, binding) in contacts {
            if !binding.switch.is_wanted() {
                binding.settle(self.time, contact);
            }
            binding.place_again(self.time, &self.model, &self.data, contact);
        }
    }

    fn take_state(&mut self, m: &Measurement) {
        let is_first = self.origin.is_none();
        self.time = m.time - *self.origin.get_or_insert(m.time);
        let observer = self.observer.as_mut().filter(|_| !is_first);
        if let Some(observer) = observer {
            observer.predict(
                &self.state.v,
                &self.data,
                &self.contacts,
                &self.last,
                self.elapsed,
            );
            self.state.copy_from(&m.state);
            observer.correct(&mut self.state.v, &self.data, self.elapsed);
        } else {
            self.state.copy_from(&m.state);
        }
        // Sensors deliver quaternions that are almost of unit length: everything after needs exactly that.
        self.state.R_WR = UnitQuaternion::new_normalize(*m.state.R_WR.quaternion());
        self.update_bodies();
    }

    /// Takes down what the next tick needs of a solution that the problem has recovered.
    pub(crate) fn remember(&mut self, problem: &mut Problem, tasks: &[BoundEntry]) {
        self.last.vdot.copy_from_slice(&problem.solved().vdot);
        problem.collect_asked(tasks, self.last.virtual_input.as_mut_slice());
        for (index, contact) in self.contacts.iter_mut().enumerate() {
            contact.solution.fill(0.0);
            contact.set_point.fill(0.0);
            if let Some(force) = problem.force(index) {
                for (&direction, f) in contact.kind.constrained().iter().zip(force) {
                    contact.solution[direction] = *f;
                }
            }
        }
        for task in tasks {
            if let (true, Some(force)) = (task.live, task.store.force_report)
                && let Some(contact) = self.contacts.get_mut(force.contact.index())
            {
                contact.set_point = force.reference;
            }
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

    /// The unknown wrench on the base; zero without an observer.
    pub(crate) fn disturbance(&self) -> Vector6<f64> {
        let observer = self.observer.as_ref();
        observer.map_or_else(Vector6::zeros, |observer| observer.disturbance)
    }

    /// The terms of the dynamics, borrowed for the problem.
    pub(crate) fn terms(&self) -> DynamicsTerms<'_> {
        DynamicsTerms {
            data: &self.data,
            frames: &self.frames,
            contacts: &self.contacts,
            disturbance: self.disturbance(),
        }
    }

    /// What a plug-in sees.
    pub(crate) fn tick(&self, entry: EntryState) -> Tick<'_> {
        Tick {
            time: self.time,
            period: self.period,
            elapsed: self.elapsed,
            slew_time: self.slew_time,
            model: &self.model,
            state: &self.state,
            dynamics: &self.data,
            last: &self.last,
            disturbance: self.disturbance(),
            entry,
            frames: &self.frames,
            contacts: &self.contacts,
            references: &[],
        }
    }
}
