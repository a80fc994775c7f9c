//! An attitude that points the thrust where a force is needed.
//!
//! # Notation
//! W world (z up), R base, C a contact's surface frame. All vectors in world axes.
//!
//! # Mathematics
//! A robot whose rotors all push along the base's z moves sideways, and pushes against a wall, by tilting. Newton's law
//! for the whole robot says which force its rotors have to produce,
//!
//! `F = m (a_R* − g) − Σ_c R_WC f_c^d − f̂`,
//!
//! where m is the robot's mass, g gravity (a vector), `a_R*` what the tasks ask of the base's linear acceleration,
//! `f_c^d` the set point of the force that contact c exerts on the robot, and f̂ the unknown force of an observer. So
//! that the measurement noise in `a_R*` does not shake the attitude, F passes two equal first-order low-passes, one
//! after the other. The thrust axis follows,
//!
//! `z_R = F/‖F‖`, turned back towards the vertical if it is tilted by more than a limit,
//!
//! and the heading ψ the rest: `x_R ∝ (−sin ψ, cos ψ, 0)ᵀ × z_R`, `y_R = z_R × x_R`, which is the attitude with yaw ψ
//! in `R_z(yaw) R_y(pitch) R_x(roll)`. Its rate is the difference of two samples, its acceleration zero.
//!
//! `a_R*` and `f^d` are those of the tick before. It is the set point that counts and not the solver's force: that one
//! follows from the attitude, and the two would chase each other.
//!
//! Example: level flight with a mass of 2.92 kg, and 5 N against a wall: the tilt is `atan(5/28.64)`, 9.90°.
#![allow(non_snake_case)]

use std::f64::consts::FRAC_PI_2;

use wbqp::{
    dynamics::elementary,
    model::Base,
    nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3},
    plugin::RotationSample,
    prelude::*,
    spatial,
};

use crate::check;

/// Points the base's z where force is needed: for robots whose thrust has that one direction.
///
/// A reference for [`BaseOrientation`](crate::BaseOrientation). It tilts the base as far as the accelerations that
/// tasks ask of it and the set points of its contacts need:
///
/// `F = m (a_R* − g) − Σ_c R_WC f_c^d − f̂`, `z_R = F/‖F‖`, with F low-passed and the tilt limited.
///
/// Nothing has to be named: `a_R*` is the
/// [virtual input](wbqp::plugin::Tick::last_virtual_input) of whatever task moves the base, and
/// [`f_c^d`](wbqp::contact::ContactState::set_point) that of every contact with a force task, both of the tick before.
/// It begins with the attitude where it takes over, apart from the yaw.
///
/// With a steady position error the base tilts for what its stiffness asks, too: a base that is pulled into a wall by
/// its position reference pushes with more than the set point.
#[wbqp::reference("thrust_attitude")]
pub struct ThrustAttitude {
    /// Yaw of the base, rad. Without it, what the task followed before; at the start, the measured one.
    #[wbqp(unit = "rad")]
    pub yaw: Option<f64>,
    /// Largest angle between the base's z and the vertical, rad, below π/2.
    #[wbqp(default = 0.35, unit = "rad")]
    pub max_tilt: f64,
    /// Cut-off of each of the two low-passes on the force, Hz; `inf` for none.
    #[wbqp(default = 2.0, unit = "Hz")]
    pub cutoff: f64,
}

/// Where it took over, and where its filters are.
#[derive(Debug)]
pub struct Filter {
    /// Yaw, rad.
    heading: f64,
    /// Thrust axis where it takes over, unit length.
    start: Vector3<f64>,
    last: Option<Last>,
}

/// What the last sample leaves for the next.
#[derive(Clone, Debug)]
struct Last {
    /// s.
    time: f64,
    /// The force behind the first and the second low-pass, N.
    stages: [Vector3<f64>; 2],
    rotation: UnitQuaternion<f64>,
    /// rad/s.
    rate: Vector3<f64>,
}

impl Default for ThrustAttitude {
    fn default() -> Self {
        Self {
            yaw: None,
            max_tilt: Self::default_max_tilt(),
            cutoff: Self::default_cutoff(),
        }
    }
}

impl ThrustAttitude {
    /// Keeps the yaw, with the default limit of the tilt and the default filter.
    pub fn new() -> Self {
        Self::default()
    }

    /// Faces a yaw, rad.
    pub fn facing(mut self, yaw: f64) -> Self {
        self.yaw = Some(yaw);
        self
    }

    /// Tilts by no more than an angle, rad.
    pub fn limited_to(mut self, max_tilt: f64) -> Self {
        self.max_tilt = max_tilt;
        self
    }

    /// Filters the force with another cut-off, Hz.
    pub fn filtered_at(mut self, cutoff: f64) -> Self {
        self.cutoff = cutoff;
        self
    }

    /// Writes the sample for a force that the rotors have to produce, N, world axes. `weight` is the robot's, N.
    fn step(
        &self,
        filter: &mut Filter,
        time: f64,
        force: &Vector3<f64>,
        weight: f64,
        out: &mut RotationSample,
    ) {
        let heading = filter.heading;
        let limit = self.max_tilt;
        let attitude = |force: &Vector3<f64>| facing(&thrust_axis(force, limit), heading);
        let start = filter.start;
        let last = filter.last.get_or_insert_with(|| {
            // The force whose vertical part is the weight, along the axis where it takes over.
            let begin = thrust_axis(&start, limit);
            let begin = begin * (weight / begin.z);
            Last {
                time,
                stages: [begin; 2],
                rotation: attitude(&begin),
                rate: Vector3::zeros(),
            }
        });
        let elapsed = time - last.time;
        if elapsed > 0.0 && force.iter().all(|f| f.is_finite()) {
            let gain = elementary::low_pass(self.cutoff, elapsed);
            let [first, second] = &mut last.stages;
            *first += (force - *first) * gain;
            *second += (*first - *second) * gain;
            let rotation = attitude(second);
            last.rate = spatial::log(&(rotation * last.rotation.inverse())) / elapsed;
            last.rotation = rotation;
            last.time = time;
        }
        out.rotation = last.rotation;
        out.rate = last.rate;
        out.acceleration.fill(0.0);
    }
}

/// Direction of a force, tilted from the vertical by no more than `limit` (rad, below π/2). Up, if there is no force.
fn thrust_axis(force: &Vector3<f64>, limit: f64) -> Vector3<f64> {
    let sideways = force.xy().norm();
    if sideways <= f64::MIN_POSITIVE {
        return Vector3::z();
    }
    let (sin, cos) = elementary::sin_cos(elementary::atan2(sideways, force.z).min(limit));
    let direction = force.xy() / sideways;
    Vector3::new(sin * direction.x, sin * direction.y, cos)
}

/// The attitude with this z axis (unit length, less than 90° from the vertical) and this yaw.
fn facing(z: &Vector3<f64>, yaw: f64) -> UnitQuaternion<f64> {
    let (sin, cos) = elementary::sin_cos(yaw);
    let left = Vector3::new(-sin, cos, 0.0);
    // Not parallel: z has an upward part, `left` is level.
    let x = left.cross(z).normalize();
    let R = Matrix3::from_columns(&[x, z.cross(&x), *z]);
    UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(R))
}

/// `m (a_R* − g) − Σ_c R_WC f_c^d − f̂`, N, world axes.
fn needed_force(tick: &Tick<'_>) -> Vector3<f64> {
    // Without a base that moves nothing is asked of it.
    let asked = match tick.model.base() {
        Base::Floating => tick.last_virtual_input.fixed_rows::<3>(0).into_owned(),
        Base::Fixed => Vector3::zeros(),
    };
    let inertial = (asked - tick.model.gravity()) * tick.model.mass();
    let unknown = tick.disturbance.fixed_rows::<3>(0);
    let contacts = tick.contacts().iter();
    contacts.fold(inertial - unknown, |force, contact| {
        force - contact.R_WC * contact.set_point
    })
}

impl Reference for ThrustAttitude {
    type Running = Filter;

    fn bind(&self, space: Space) -> Result<Filter, BindError> {
        if space != Space::Rotation {
            return Err(BindError::Other(
                "`thrust_attitude` is an orientation: it is for `base_orientation`".to_owned(),
            ));
        }
        if let Some(yaw) = self.yaw {
            check::finite_number("yaw", yaw)?;
        }
        check::positive("max_tilt", self.max_tilt)?;
        if self.max_tilt >= FRAC_PI_2 {
            let problem = format!("is {} rad, must be below π/2", self.max_tilt);
            return Err(BindError::value("max_tilt", problem));
        }
        if self.cutoff.is_nan() || self.cutoff <= 0.0 {
            let problem = format!("is {} Hz, must be positive", self.cutoff);
            return Err(BindError::value("cutoff", problem));
        }
        Ok(Filter {
            heading: 0.0,
            start: Vector3::z(),
            last: None,
        })
    }

    fn start(&self, filter: &mut Filter, _: f64, from: &Sample) {
        if let Sample::Rotation(from) = from {
            let (_, _, yaw) = from.rotation.euler_angles();
            *filter = Filter {
                heading: self.yaw.unwrap_or(yaw),
                start: from.rotation * Vector3::z(),
                last: None,
            };
        }
    }

    fn sample(&self, filter: &mut Filter, tick: &Tick<'_>, out: &mut Sample) {
        if let Sample::Rotation(out) = out {
            let weight = tick.model.mass() * tick.model.gravity().norm();
            self.step(filter, tick.time, &needed_force(tick), weight, out);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;
    use crate::references::leg::testing::started;

    const WEIGHT: f64 = 2.919_33 * 9.81;
    const PERIOD: f64 = 0.004;

    /// One that has taken over.
    struct Started(ThrustAttitude, Filter);

    impl Started {
        fn step(&mut self, time: f64, force: &Vector3<f64>, weight: f64, out: &mut RotationSample) {
            self.0.step(&mut self.1, time, force, weight, out);
        }
    }

    fn bound(reference: ThrustAttitude, start: UnitQuaternion<f64>) -> Started {
        let filter = started(&reference, 0.0, &Sample::turned(start)).unwrap();
        Started(reference, filter)
    }

    fn level() -> RotationSample {
        RotationSample::at_rest(UnitQuaternion::identity())
    }

    /// Samples at 0, 1, …, `steps` periods under a constant force; the last one.
    fn settle(reference: &mut Started, force: Vector3<f64>, steps: u32) -> RotationSample {
        let mut out = level();
        for k in 0..=steps {
            reference.step(f64::from(k) * PERIOD, &force, WEIGHT, &mut out);
        }
        out
    }

    #[test]
    fn level_without_a_force_to_push_with() {
        let mut reference = bound(ThrustAttitude::new(), UnitQuaternion::identity());
        let out = settle(&mut reference, Vector3::new(0.0, 0.0, WEIGHT), 100);
        assert_eq!(out, level());
    }

    #[test]
    fn nose_down_by_the_angle_of_the_force() {
        // 5 N towards +x and the weight of 2.92 kg: 9.90°, a positive rotation about y.
        let mut reference = bound(ThrustAttitude::new(), UnitQuaternion::identity());
        let out = settle(&mut reference, Vector3::new(5.0, 0.0, WEIGHT), 1000);
        let (roll, pitch, yaw) = out.rotation.euler_angles();
        assert!((pitch.to_degrees() - 9.90).abs() < 5e-3, "{pitch}");
        assert!((pitch.tan() - 5.0 / WEIGHT).abs() < 1e-9);
        assert!(roll.abs() < 1e-12 && yaw.abs() < 1e-12);
        assert!(out.rate.norm() < 1e-9);
    }

    #[test]
    fn the_yaw_is_kept_whatever_the_tilt() {
        for yaw in [-2.5, -0.3, 0.0, 1.0, 3.0] {
            for force in [[4.0, -7.0, 20.0], [-9.0, 1.0, 30.0], [0.0, 6.0, 28.0]] {
                let force = Vector3::from(force);
                let z = thrust_axis(&force, 1.2);
                let R_WR = facing(&z, yaw);
                assert!((R_WR * Vector3::z() - force.normalize()).norm() < 1e-12);
                assert!((R_WR.euler_angles().2 - yaw).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn the_tilt_stops_at_its_limit_also_for_a_force_that_points_down() {
        for force in [
            [30.0, 40.0, 10.0],
            [3e3, 4e3, 0.0],
            [3.0, 4.0, -1.0],
            [3e-9, 4e-9, -10.0],
        ] {
            let z = thrust_axis(&Vector3::from(force), 0.3);
            let expected = Vector3::new(0.6 * 0.3_f64.sin(), 0.8 * 0.3_f64.sin(), 0.3_f64.cos());
            assert!((z - expected).norm() < 1e-12, "{force:?}");
        }
        for up in [[0.0, 0.0, 0.0], [0.0, 0.0, -10.0], [0.0, 0.0, 1e300]] {
            assert_eq!(thrust_axis(&Vector3::from(up), 0.3), Vector3::z());
        }
        let mut reference = bound(
            ThrustAttitude::new().limited_to(0.3),
            UnitQuaternion::identity(),
        );
        let out = settle(&mut reference, Vector3::new(0.0, 50.0, WEIGHT), 1000);
        assert!((out.rotation.euler_angles().0 + 0.3).abs() < 1e-9);
    }

    #[test]
    fn the_force_passes_two_low_passes() {
        // Step response of two equal ones in series: 1 − (1 + t/τ) exp(−t/τ).
        let cutoff = 1.5;
        let mut reference = bound(
            ThrustAttitude::new().filtered_at(cutoff),
            UnitQuaternion::identity(),
        );
        let mut out = level();
        let force = Vector3::new(5.0, 0.0, WEIGHT);
        // In steps so small that discretisation does not show.
        let dt = 1e-5;
        for k in 0..=20_000 {
            reference.step(f64::from(k) * dt, &force, WEIGHT, &mut out);
        }
        let x = 20_000.0 * dt * TAU * cutoff;
        let expected = 5.0 / WEIGHT * (1.0 - (1.0 + x) * (-x).exp());
        let tan = out.rotation.euler_angles().1.tan();
        assert!((tan - expected).abs() < 1e-4 * expected, "{tan} {expected}");
        let mut open = bound(
            ThrustAttitude::new().filtered_at(f64::INFINITY),
            UnitQuaternion::identity(),
        );
        let out = settle(&mut open, force, 1);
        assert!((out.rotation.euler_angles().1.tan() - 5.0 / WEIGHT).abs() < 1e-12);
    }

    #[test]
    fn the_rate_is_that_of_the_attitude() {
        let mut reference = bound(ThrustAttitude::new(), UnitQuaternion::identity());
        let mut out = level();
        let mut before = out;
        for k in 0..500 {
            let time = f64::from(k) * PERIOD;
            let force = Vector3::new(6.0 * (3.0 * time).sin(), 4.0 * time, WEIGHT);
            reference.step(time, &force, WEIGHT, &mut out);
            let moved = spatial::exp(&(out.rate * PERIOD)) * before.rotation;
            assert!(k == 0 || moved.angle_to(&out.rotation) < 1e-9);
            assert!(out.acceleration == Vector3::zeros());
            before = out;
        }
        // A second look at the same time changes nothing.
        reference.step(499.0 * PERIOD, &Vector3::x(), WEIGHT, &mut out);
        assert_eq!(out, before);
    }

    #[test]
    fn begins_where_it_takes_over() {
        let tilted = UnitQuaternion::from_euler_angles(-0.1, 0.15, 0.7);
        let mut reference = bound(ThrustAttitude::new(), tilted);
        let out = settle(&mut reference, Vector3::new(0.0, 0.0, WEIGHT), 0);
        assert!(out.rotation.angle_to(&tilted) < 1e-9);
        let out = settle(&mut reference, Vector3::new(0.0, 0.0, WEIGHT), 1000);
        assert!((out.rotation.angle() - 0.7).abs() < 1e-6);
        let mut turned = bound(ThrustAttitude::new().facing(-1.0), tilted);
        let out = settle(&mut turned, Vector3::new(0.0, 0.0, WEIGHT), 1000);
        assert!((out.rotation.euler_angles().2 + 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_force_that_is_not_finite_is_passed_over() {
        let mut reference = bound(ThrustAttitude::new(), UnitQuaternion::identity());
        let force = Vector3::new(5.0, 0.0, WEIGHT);
        let before = settle(&mut reference, force, 100);
        let mut out = level();
        reference.step(
            101.0 * PERIOD,
            &Vector3::new(f64::NAN, 0.0, 0.0),
            WEIGHT,
            &mut out,
        );
        assert_eq!(out, before);
    }

    #[test]
    fn bad_parameters_are_refused_by_key() {
        for (key, reference) in [
            ("yaw", ThrustAttitude::new().facing(f64::NAN)),
            ("max_tilt", ThrustAttitude::new().limited_to(0.0)),
            ("max_tilt", ThrustAttitude::new().limited_to(1.6)),
            ("max_tilt", ThrustAttitude::new().limited_to(f64::INFINITY)),
            ("cutoff", ThrustAttitude::new().filtered_at(0.0)),
            ("cutoff", ThrustAttitude::new().filtered_at(f64::NAN)),
        ] {
            let error = reference.bind(Space::Rotation).unwrap_err().to_string();
            assert!(error.starts_with(&format!("`{key}`")), "{error}");
        }
        let refused = ThrustAttitude::new().bind(Space::Vector(3));
        let error = refused.unwrap_err().to_string();
        assert!(error.contains("base_orientation"), "{error}");
    }
}
