//! What a contact needs besides its state: its surface, its switch, and the filters of its force-torque sensor.
//!
//! # Notation
//! W world, B the body that carries the contact, E the contact's frame on it, S the surface's origin, C the surface's
//! frame at the contact point.
#![allow(non_snake_case)]

use nalgebra::{Isometry3, Matrix3, Matrix6xX, Rotation3, Translation3, Vector3, Vector6};

use super::{low_pass::low_pass, record::ContactMemory};
use crate::{
    contact::{
        ContactSpec, ContactState, FreeForce, SurfaceMotion,
        sensor_zero::{CUTOFF, SensorZero},
    },
    error::BindError,
    switch::Switch,
};
use wbqp_dynamics::{
    Data, FrameKinematics,
    model::{BodyId, Model},
};

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
    pub(super) filtered: Vector3<f64>,
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
    pub(super) fn settle(&mut self, now: f64, c: &mut ContactState) {
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
    pub(super) fn place(&mut self, model: &Model, data: &Data, c: &mut ContactState) {
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
    pub(super) fn sense(&self, wrench: &Vector6<f64>, c: &mut ContactState) -> Vector3<f64> {
        let wrench = self.zero.correct(wrench);
        // The sensor speaks in E about E's origin; the contact point is the offset away.
        let force = Vector3::new(wrench[0], wrench[1], wrench[2]);
        let moment = Vector3::new(wrench[3], wrench[4], wrench[5])
            - Vector3::from(self.spec.offset).cross(&force);
        let (force, moment) = (c.R_CE * force, c.R_CE * moment);
        c.measured = Vector6::new(force.x, force.y, force.z, moment.x, moment.y, moment.z);
        force
    }

    pub(super) fn update(
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
