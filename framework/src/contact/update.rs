//! A contact in a tick: how what is known of it follows from where the robot is and what its sensor reads.
//!
//! # Notation
//! W world, B the body that carries the contact, E the contact's frame on it, S the surface's origin, a material point
//! of the surface, C the surface's frame at the contact point.
//!
//! # Mathematics
//! For the velocity relative to the surface to stay the same in C axes, the contact point has to be accelerated as the
//! material point of the surface under it, and by `2 w_WC × v` and `w_WC × w_WE` besides (Coriolis). That is the
//! *surface's acceleration* here.
//!
//! A first-order low-pass follows what is read in the free directions. Another one, with a time constant of 0.25 s,
//! follows the reading m, `m̄ += (m − m̄) s`, and [`SensorZero::take`] makes it the zero m₀: from then on `m − m₀`
//! counts as the wrench.
#![allow(non_snake_case)]

use nalgebra::{Vector3, Vector6};

use super::{ContactBinding, ContactState, FreeForce, SensorZero, SurfaceMotion};
use wbqp_dynamics::{Data, elementary::low_pass, model::Model, spatial::stack};

impl ContactBinding {
    /// Begins a switch that was asked for, at the time of this tick and with its measurement.
    pub(crate) fn settle(&mut self, now: f64, c: &mut ContactState) {
        let exit_alpha = self.switch.alpha(now).max(1e-9);
        let switched = self.switch.settle(now);
        self.switched_on = switched == Some(true);
        match switched {
            Some(true) => {
                c.measured_at_switch = c.measured;
                self.filtered = Vector3::new(c.measured[0], c.measured[1], c.measured[2]);
            }
            Some(false) => {
                self.exit_force = c.normal_force(now, self.spec.force_max);
                self.exit_alpha = exit_alpha;
            }
            None => {}
        }
    }

    /// Where the contact is, and how it moves.
    pub(crate) fn place(&mut self, model: &Model, data: &Data, c: &mut ContactState) {
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
            stack(&linear, &angular)
        };
        let velocity = stack(&k.v_WF, &k.w_WF);
        let relative = velocity - self.motion.velocity_at(&k.p_WF);
        c.V = rotate(&relative);
        let w = &self.motion.w_WC;
        let sliding = relative.fixed_rows::<3>(0);
        let turning = stack(&(2.0 * w.cross(&sliding)), &w.cross(&k.w_WF));
        c.surface_acceleration = rotate(&(self.motion.acceleration_at(&k.p_WF) + turning));
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
    pub(crate) fn sense(&self, wrench: &Vector6<f64>, c: &mut ContactState) -> Vector3<f64> {
        let wrench = self.zero.correct(wrench);
        // The sensor speaks in E about E's origin; the contact point is the offset away.
        let force = Vector3::new(wrench[0], wrench[1], wrench[2]);
        let moment = Vector3::new(wrench[3], wrench[4], wrench[5])
            - Vector3::from(self.spec.offset).cross(&force);
        let (force, moment) = (c.R_CE * force, c.R_CE * moment);
        c.measured = stack(&force, &moment);
        force
    }

    pub(crate) fn update(
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
        self.stand(time, c);
        c.force_limits = if self.switch.is_on() {
            [c.alpha * self.spec.force_min, c.alpha * self.spec.force_max]
        } else {
            // From the force at the switch to zero, whichever ramp was under way.
            let ramp = c.alpha / self.exit_alpha;
            let force = self.exit_force.max(0.0);
            [c.alpha * self.spec.force_min.min(force), ramp * force]
        };
    }

    /// How far the contact is switched on, and what follows from that without its wrench.
    pub(crate) fn stand(&self, time: f64, c: &mut ContactState) {
        c.alpha = self.switch.alpha(time);
        c.live = self.switch.is_live(time);
        c.since = self.switch.since();
        c.free_force = self.free_force(c);
        if !c.live {
            c.solution = Vector6::zeros();
            c.set_point = Vector3::zeros();
        }
    }

    /// What is measured in the free directions, as far as it counts.
    pub(crate) fn free_force(&self, c: &ContactState) -> Vector6<f64> {
        let mut force = Vector6::zeros();
        if c.live && self.spec.free_force == FreeForce::Measured {
            let limit = self.spec.free_force_limit;
            for &direction in self.spec.kind.free().iter().filter(|&&d| d < 3) {
                force[direction] = c.alpha * self.filtered[direction].clamp(-limit, limit);
            }
        }
        force
    }
}

impl SurfaceMotion {
    /// Velocity `[linear; angular]` of the material point at `p`, m world; world axes.
    pub fn velocity_at(&self, p: &Vector3<f64>) -> Vector6<f64> {
        stack(&(self.v_WS + self.w_WC.cross(&(p - self.p_WS))), &self.w_WC)
    }

    /// Acceleration `[linear; angular]` of the material point at `p`, m world; world axes.
    pub fn acceleration_at(&self, p: &Vector3<f64>) -> Vector6<f64> {
        let r = p - self.p_WS;
        let linear = self.a_WS + self.alpha_WC.cross(&r) + self.w_WC.cross(&self.w_WC.cross(&r));
        stack(&linear, &self.alpha_WC)
    }
}

/// Of the mean reading, Hz: a time constant of 0.25 s.
pub(crate) const CUTOFF: f64 = 4.0 / std::f64::consts::TAU;

impl SensorZero {
    /// Follows a reading, of which so much is new.
    pub(crate) fn follow(&mut self, reading: &Vector6<f64>, share: f64) {
        let mean = self.mean.get_or_insert(*reading);
        *mean += (reading - *mean) * share;
    }

    /// The wrench that a reading means.
    pub(crate) fn correct(&self, reading: &Vector6<f64>) -> Vector6<f64> {
        reading - self.offset
    }
}
