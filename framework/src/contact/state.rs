//! A contact in a tick: what is known of it, and how that follows from where the robot is and what its sensor reads.
//!
//! # Notation
//! W world, B the body that carries the contact, E the contact's frame on it, S the surface's origin, a material point
//! of the surface, C the surface's frame at the contact point.
//!
//! # Mathematics
//! A first-order low-pass follows what is read in the free directions. Another one, with a time constant of 0.25 s,
//! follows the reading m, `m̄ += (m − m̄) s`, and [`SensorZero::take`] makes it the zero m₀: from then on `m − m₀`
//! counts as the wrench.
#![allow(non_snake_case)]

use nalgebra::{Isometry3, Matrix6xX, Rotation3, Vector3, Vector6};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{ContactSpec, FreeForce};
use crate::switch::Switch;
use wbqp_dynamics::{
    Data, FrameKinematics, elementary,
    model::{BodyId, Model},
};

/// A contact's kinematics, switch and forces in one tick. Vectors of six are `[linear; angular]` in C axes.
#[derive(Clone, Debug)]
pub struct ContactState {
    /// Which motions are constrained.
    pub kind: ContactKind,
    /// Whether its forces and rows are in the problem (true during both ramps).
    pub live: bool,
    /// Ramp: 0 off, 1 fully on.
    pub alpha: f64,
    /// Time of the tick of the last switch, s; −∞ before.
    pub since: f64,
    /// Orientation of the surface frame in the world.
    pub R_WC: Rotation3<f64>,
    /// Origin of surface coordinates, m, world.
    pub p_WS: Vector3<f64>,
    /// Contact point on the robot, m, **surface coordinates**: C axes from the surface's origin.
    pub p_SC: Vector3<f64>,
    /// Orientation of the robot's frame E relative to C.
    pub R_CE: Rotation3<f64>,
    /// Velocity of the contact point and of E relative to the surface, m/s and rad/s.
    pub V: Vector6<f64>,
    /// Jacobian of the contact point, 6 × nv, C axes.
    pub J: Matrix6xX<f64>,
    /// Bias acceleration `J̇ v` of the contact point.
    pub Jdot_v: Vector6<f64>,
    /// Acceleration of a moving surface at the contact point; zero for a wall.
    pub surface_acceleration: Vector6<f64>,
    /// Friction coefficient assumed.
    pub friction: f64,
    /// Normal force limits now, N, the ramp applied.
    pub force_limits: [f64; 2],
    /// Measured wrench on the robot about the contact point, N and N·m.
    pub measured: Vector6<f64>,
    /// Measured wrench in the tick in which the contact was last switched on.
    pub measured_at_switch: Vector6<f64>,
    /// Wrench put into the dynamics for the free directions.
    pub free_force: Vector6<f64>,
    /// Set point `f^d` of the contact's force task in the last tick, N, on the robot, C axes; zero without one and
    /// while the contact is off.
    pub set_point: Vector3<f64>,
    /// Wrench of the last solution, zero in the free directions.
    pub solution: Vector6<f64>,
}

/// What a contact needs besides its state.
#[derive(Clone, Debug)]
pub(crate) struct ContactBinding {
    pub(crate) spec: ContactSpec,
    pub(crate) switch: Switch,
    /// Whether it is switched on in this tick.
    pub(crate) switched_on: bool,
    pub(super) body: BodyId,
    pub(super) X_BC: Isometry3<f64>,
    pub(super) kinematics: FrameKinematics,
    /// Normal force of the solution when the contact was switched off.
    pub(crate) exit_force: f64,
    /// Ramp at that moment.
    pub(crate) exit_alpha: f64,
    /// Low-passed force in the free directions, C axes, N.
    pub(crate) filtered: Vector3<f64>,
    pub(crate) zero: SensorZero,
    pub(crate) motion: SurfaceMotion,
    /// Shares of a new sample in the low-passes of the free force and of the sensor's mean reading, one period after
    /// the one before.
    pub(super) shares: [f64; 2],
    pub(super) period: f64,
}

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
                self.exit_force = c.solution[2];
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
    pub(crate) fn sense(&self, wrench: &Vector6<f64>, c: &mut ContactState) -> Vector3<f64> {
        let wrench = self.zero.correct(wrench);
        // The sensor speaks in E about E's origin; the contact point is the offset away.
        let force = Vector3::new(wrench[0], wrench[1], wrench[2]);
        let moment = Vector3::new(wrench[3], wrench[4], wrench[5])
            - Vector3::from(self.spec.offset).cross(&force);
        let (force, moment) = (c.R_CE * force, c.R_CE * moment);
        c.measured = Vector6::new(force.x, force.y, force.z, moment.x, moment.y, moment.z);
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

/// Index of a contact, in the order of the configuration.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct ContactId(pub(crate) u32);

impl ContactId {
    /// Position in the configuration's list.
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// Which motions the surface forbids: the four kinds of the paper, section II-A.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ContactKind {
    /// Position and orientation: six constrained directions. Needs a constraint that limits its moments.
    Full,
    /// Position, the end effector may turn: a point with friction, three forces.
    Point,
    /// The normal translation alone: a frictionless (or sliding) point, one force.
    Normal,
    /// The normal translation and the two tilts: a foot that slides, one force and two moments. Needs a constraint
    /// that limits its moments.
    NormalTilt,
}

impl ContactKind {
    /// Rows of the six that are constrained (`S_c`): 0–2 translations, 3–5 rotations, C axes.
    pub fn constrained(self) -> &'static [usize] {
        match self {
            Self::Full => &[0, 1, 2, 3, 4, 5],
            Self::Point => &[0, 1, 2],
            Self::Normal => &[2],
            Self::NormalTilt => &[2, 3, 4],
        }
    }

    /// The complementary rows (`S_f`).
    pub fn free(self) -> &'static [usize] {
        match self {
            Self::Full => &[],
            Self::Point => &[3, 4, 5],
            Self::Normal => &[0, 1, 3, 4, 5],
            Self::NormalTilt => &[0, 1, 5],
        }
    }

    /// Whether moments are among the constrained components.
    pub fn has_moments(self) -> bool {
        self.constrained().iter().any(|&row| row > 2)
    }

    /// Position of the normal force among the constrained components.
    pub fn normal(self) -> usize {
        match self {
            Self::Full | Self::Point => 2,
            Self::Normal | Self::NormalTilt => 0,
        }
    }

    /// Positions of the two tangential forces among the constrained components, if they are constrained.
    pub fn tangential(self) -> Option<[usize; 2]> {
        match self {
            Self::Full | Self::Point => Some([0, 1]),
            Self::Normal | Self::NormalTilt => None,
        }
    }
}

/// Pose, twist and acceleration of a surface, given to
/// [`Controller::move_surface`](crate::controller::Controller::move_surface).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceMotion {
    /// Orientation: z is the outward normal.
    pub R_WC: Rotation3<f64>,
    /// Position of the origin, m, world.
    pub p_WS: Vector3<f64>,
    /// Velocity of the origin, m/s, world axes.
    pub v_WS: Vector3<f64>,
    /// Angular velocity, rad/s, world axes.
    pub w_WC: Vector3<f64>,
    /// Acceleration of the origin, m/s², world axes.
    pub a_WS: Vector3<f64>,
    /// Angular acceleration, rad/s², world axes.
    pub alpha_WC: Vector3<f64>,
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

fn stack(linear: &Vector3<f64>, angular: &Vector3<f64>) -> Vector6<f64> {
    Vector6::new(
        linear.x, linear.y, linear.z, angular.x, angular.y, angular.z,
    )
}

/// Of the mean reading, Hz: a time constant of 0.25 s.
pub(crate) const CUTOFF: f64 = 4.0 / std::f64::consts::TAU;

/// The mean reading, and what of a reading counts as zero. `[force; moment]`, N and N·m, in the sensor's axes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct SensorZero {
    /// None before the first reading.
    pub(crate) mean: Option<Vector6<f64>>,
    pub(crate) offset: Vector6<f64>,
}

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

/// Share of a new sample in a low-pass with this cutoff, Hz, so many seconds after the one before.
pub(crate) fn low_pass(cutoff: f64, seconds: f64) -> f64 {
    1.0 - elementary::exp(-std::f64::consts::TAU * cutoff * seconds)
}
