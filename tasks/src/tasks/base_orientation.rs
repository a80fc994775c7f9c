//! Orientation of the floating base (R_R).
//!
//! # Notation
//! W world, R base, D desired base. `w` angular velocities in world axes, so that `Ṙ_WR = S(w) R_WR`.
#![allow(non_snake_case)]

use wbqp::{nalgebra::UnitQuaternion, plugin::RotationReference, prelude::*, spatial};

use crate::follow::stay;

/// Turns a floating base, the paper's R_R.
///
/// Second row of (11), three rows in world axes, rad/s²:
///
/// `ẇ_WR = ẇ_WD − K_D (w_WR − w_WD) − K_P e`, with `e = log(R_WR R_WDᵀ)∨` or `e = ½[R_WR R_WDᵀ − R_WD R_WRᵀ]∨`.
///
/// The error printed below (11) has the wrong sign, and is in body axes while the velocities are in world axes; the
/// forms here are the stable ones (derivation: with `R_WR = exp(S(d)) R_WD` both give `e = d` to first order).
///
/// Error: `e`, rad, world axes.
#[wbqp::task("base_orientation", weight = 10.0)]
pub struct BaseOrientation {
    /// Stiffness `K_P`, 1/s²: one number, or one per axis of `axes`.
    #[wbqp(unit = "1/s²")]
    pub kp: PerRow,
    /// Damping `K_D`, 1/s: one number, or one per axis of `axes`. Default: critical, `2 √K_P`.
    #[wbqp(unit = "1/s", critical = "kp")]
    pub kd: PerRow,
    /// How the difference of two orientations is measured.
    #[wbqp(default)]
    pub error: RotationError,
    /// Along which axes the gains count.
    #[wbqp(default)]
    pub axes: GainAxes,
    /// Where to go: orientation of the base in the world, `[roll, pitch, yaw]` in rad. Default: hold what is
    /// measured at the start.
    #[wbqp(default = stay(), unit = "rad")]
    pub reference: Box<dyn AnyReference>,
}

/// How the difference of two orientations is measured. Both agree for small angles.
#[wbqp::parameters]
#[derive(Copy, Default, PartialEq, Eq)]
pub enum RotationError {
    /// The rotation vector: its length is the angle θ, up to 180°.
    #[default]
    Logarithm,
    /// From the matrices, as in the paper: its length is sin θ up to 90°, and stays 1 beyond, where sin θ would fall
    /// back to nothing.
    Matrix,
}

impl RotationError {
    /// Error `e` in world axes of an orientation `R_WB` against a desired one `R_WD`, rad.
    ///
    /// ```
    /// use wbqp::{nalgebra::Vector3, spatial};
    /// use wbqp_tasks::RotationError;
    /// let desired = spatial::exp(&Vector3::new(0.3, 0.0, 1.0));
    /// let actual = spatial::exp(&Vector3::new(0.0, 0.5, 0.0)) * desired;
    /// let e = RotationError::Logarithm.between(&actual, &desired);
    /// assert!((e - Vector3::new(0.0, 0.5, 0.0)).norm() < 1e-12);
    /// ```
    pub fn between(self, R_WB: &UnitQuaternion<f64>, R_WD: &UnitQuaternion<f64>) -> Vector3<f64> {
        let logarithm = || spatial::error_log(R_WB, R_WD);
        match self {
            Self::Logarithm => logarithm(),
            Self::Matrix if R_WB.angle_to(R_WD) <= std::f64::consts::FRAC_PI_2 => {
                spatial::error_matrix(R_WB, R_WD)
            }
            Self::Matrix => logarithm().normalize(),
        }
    }
}

/// Along which axes gains count.
#[wbqp::parameters]
#[derive(Copy, Default, PartialEq, Eq)]
pub enum GainAxes {
    /// World axes: `K`.
    #[default]
    World,
    /// The turning body's own axes (of a base: roll, pitch, yaw of the robot): `R K Rᵀ`. The rows stay in the axes they
    /// are in.
    Body,
}

impl GainAxes {
    /// `K_D rate + K_P error` for vectors in the axes that `R` turns the body's into, whatever axes the gains are in.
    pub(crate) fn feedback(
        self,
        [kp, kd]: [&PerRow; 2],
        R: &UnitQuaternion<f64>,
        error: &Vector3<f64>,
        rate: &Vector3<f64>,
    ) -> Vector3<f64> {
        match self {
            Self::World => kd.times(rate) + kp.times(error),
            Self::Body => {
                let (rate, error) = (
                    R.inverse_transform_vector(rate),
                    R.inverse_transform_vector(error),
                );
                R * (kd.times(&rate) + kp.times(&error))
            }
        }
    }
}

impl BaseOrientation {
    /// Holds the orientation of the start with these gains (1/s², 1/s), along world axes.
    pub fn new(kp: impl Into<PerRow>, kd: impl Into<PerRow>) -> Self {
        Self {
            kp: kp.into(),
            kd: kd.into(),
            error: RotationError::default(),
            axes: GainAxes::default(),
            reference: stay(),
        }
    }

    /// Follows a trajectory: orientation in the world.
    pub fn following(mut self, reference: impl AnyReference) -> Self {
        self.reference = Box::new(reference);
        self
    }
}

impl Task for BaseOrientation {
    type Running = RotationReference;

    fn bind(&self, setup: &mut Setup<'_>) -> Result<(Layout, RotationReference), BindError> {
        let [.., x, y, z] = setup.base_velocities()?;
        self.kp.validate("kp", 3)?;
        self.kd.validate("kd", 3)?;
        let measured = |tick: &Tick<'_>| tick.state.R_WR;
        let reference = setup.follow_rotation("reference", &*self.reference, measured)?;
        let layout = Layout::rows([("x", "rad/s²"), ("y", "rad/s²"), ("z", "rad/s²")])
            .error_unit("rad")
            .vdot_unit([x, y, z]);
        Ok((layout, reference))
    }

    fn update(&self, reference: &mut RotationReference, tick: &Tick<'_>, rows: &mut Rows<'_>) {
        let desired = tick.rotation(*reference);
        let R_WR = &tick.state.R_WR;
        let w_WR = Vector3::from_fn(|i, _| tick.state.v[3 + i]);
        let error = self.error.between(R_WR, &desired.rotation);
        let rate = w_WR - desired.rate;
        let gains = [&self.kp, &self.kd];
        let feedback = self.axes.feedback(gains, R_WR, &error, &rate);
        for k in 0..3 {
            rows.acceleration(k, desired.acceleration[k] - feedback[k]);
        }
        rows.error().copy_from(&error);
    }

    fn remembered(&self, _: &mut Self::Running, _: &mut Remembered<'_>) {}
}

#[cfg(test)]
mod tests {
    use super::*;

    fn turn(x: f64, y: f64, z: f64) -> UnitQuaternion<f64> {
        spatial::exp(&Vector3::new(x, y, z))
    }

    #[test]
    fn both_errors_point_from_desired_to_actual() {
        let desired = turn(0.5, -1.0, 0.7);
        let d = Vector3::new(3e-5, -2e-5, 1e-5);
        let actual = spatial::exp(&d) * desired;
        for error in [RotationError::Logarithm, RotationError::Matrix] {
            assert!((error.between(&actual, &desired) - d).norm() < 1e-12);
        }
    }

    #[test]
    fn matrix_error_grows_to_one_and_stays_there() {
        let desired = turn(0.5, -1.0, 0.7);
        let axis = Vector3::new(2.0, -1.0, 2.0) / 3.0;
        for degrees in [10.0, 60.0, 89.9, 90.1, 120.0, 179.0_f64] {
            let angle = degrees.to_radians();
            let actual = spatial::exp(&(axis * angle)) * desired;
            let length = if degrees < 90.0 { angle.sin() } else { 1.0 };
            let error = RotationError::Matrix.between(&actual, &desired);
            assert!((error - axis * length).norm() < 1e-9, "{degrees}");
        }
        let flipped = turn(std::f64::consts::PI, 0.0, 0.0) * desired;
        let error = RotationError::Matrix.between(&flipped, &desired);
        assert!((error.norm() - 1.0).abs() < 1e-9);
    }

    /// `ẇ = −K_D w − K_P e` from everywhere, also upside down, without help from the linearisation.
    #[test]
    fn the_law_brings_every_orientation_home() {
        let desired = turn(0.5, -1.0, 0.7);
        for (error, axes) in [
            (RotationError::Logarithm, GainAxes::World),
            (RotationError::Logarithm, GainAxes::Body),
            (RotationError::Matrix, GainAxes::World),
            (RotationError::Matrix, GainAxes::Body),
        ] {
            let task = BaseOrientation::new([20.0, 30.0, 10.0], 9.0);
            for start in [
                turn(0.4, 0.0, 0.0),
                turn(0.0, 2.5, 1.0),
                turn(-1.5, 1.0, -2.0),
            ] {
                let (mut R_WR, mut w) = (start * desired, Vector3::new(0.3, 0.0, -0.4));
                let dt = 1e-3;
                for _ in 0..15_000 {
                    let e = error.between(&R_WR, &desired);
                    w -= axes.feedback([&task.kp, &task.kd], &R_WR, &e, &w) * dt;
                    R_WR = spatial::exp(&(w * dt)) * R_WR;
                }
                assert!(R_WR.angle_to(&desired) < 1e-3, "{error:?} {axes:?}");
            }
        }
    }

    #[test]
    fn body_gains_turn_with_the_base() {
        let R_WR = turn(0.0, 0.0, std::f64::consts::FRAC_PI_2);
        let (kp, kd) = (PerRow::from([1.0, 2.0, 3.0]), PerRow::from(0.0));
        let x = Vector3::x();
        let feedback = |axes: GainAxes| axes.feedback([&kp, &kd], &R_WR, &x, &Vector3::zeros());
        assert!((feedback(GainAxes::World) - x).norm() < 1e-12);
        // Yawed by 90°, the world's x is the base's −y.
        assert!((feedback(GainAxes::Body) - 2.0 * x).norm() < 1e-12);
    }
}
