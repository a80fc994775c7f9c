//! Position of the floating base (p_R).
//!
//! # Notation
//! W world, R base, D desired base. All vectors in world axes.
#![allow(non_snake_case)]

use wbqp::{plugin::VectorReference, prelude::*};

use crate::{
    follow::stay,
    integral::{Integral, Settings},
};

/// Moves the origin of a floating base, the paper's p_R.
///
/// First row of (11), three rows in world axes, m/s²:
///
/// `v̇_WR = v̇_WD − K_D (v_WR − v_WD) − K_P (p_WR − p_WD) − ξ`, `ξ̇ = K_I (p_WR − p_WD) + k_aw (a* − a_QP)`.
///
/// The integral ξ is not in the paper and off by default; it removes the sag that a wrong mass or thrust leaves. It is
/// clamped per axis and starts at zero whenever the task is switched on. Its second part is back-calculation against
/// wind-up: `a*` is what the task asked for in the last tick, `a_QP` what limits and other tasks left of it.
///
/// Error: `p_WR − p_WD`, m. Gains are along world axes.
#[wbqp::task("base_position", weight = 100.0)]
pub struct BasePosition {
    /// Stiffness `K_P`, 1/s²: one number, or one per world axis.
    #[wbqp(unit = "1/s²")]
    pub kp: PerRow,
    /// Damping `K_D`, 1/s: one number, or one per world axis. Default: critical, `2 √K_P`.
    #[wbqp(unit = "1/s", critical = "kp")]
    pub kd: PerRow,
    /// Integral gain `K_I`, 1/s³: one number, or one per world axis. 0, the default, is the paper's law.
    #[wbqp(default = 0.0, unit = "1/s³")]
    pub ki: PerRow,
    /// Largest acceleration that the integral may ask for on each axis, m/s².
    #[wbqp(default = 2.0, unit = "m/s²")]
    pub integral_limit: f64,
    /// Back-calculation gain `k_aw` of the integral, 1/s: one number, or one per world axis. Default `K_I/K_P`, with
    /// which the integral stays out of conflicts with limits and other tasks; 0 leaves only `integral_limit`.
    #[wbqp(unit = "1/s")]
    pub anti_windup: Option<PerRow>,
    /// Where to go: position of the base's origin in the world, m. Default: hold what is measured at the start.
    #[wbqp(default = stay(), unit = "m")]
    pub reference: Box<dyn AnyReference>,
}

impl BasePosition {
    /// Holds the position of the start with these gains (1/s², 1/s), without integral.
    pub fn new(kp: impl Into<PerRow>, kd: impl Into<PerRow>) -> Self {
        Self {
            kp: kp.into(),
            kd: kd.into(),
            ki: Self::default_ki(),
            integral_limit: Self::default_integral_limit(),
            anti_windup: None,
            reference: stay(),
        }
    }

    /// Follows a trajectory: position in the world, m.
    pub fn following(mut self, reference: impl AnyReference) -> Self {
        self.reference = Box::new(reference);
        self
    }

    /// Adds the integral (1/s³), clamped to an acceleration in m/s².
    pub fn with_integral(mut self, ki: impl Into<PerRow>, limit: f64) -> Self {
        (self.ki, self.integral_limit) = (ki.into(), limit);
        self
    }

    fn integral_settings(&self) -> Settings<'_> {
        Settings {
            kp: &self.kp,
            ki: &self.ki,
            anti_windup: self.anti_windup.as_ref(),
            limit: self.integral_limit,
        }
    }
}

/// What runs of a [`BasePosition`].
#[derive(Debug)]
pub struct RunningBasePosition {
    reference: VectorReference,
    integral: Integral,
}

impl Task for BasePosition {
    type Running = RunningBasePosition;

    fn bind(&self, setup: &mut Setup<'_>) -> Result<(Layout, RunningBasePosition), BindError> {
        let [x, y, z, ..] = setup.base_velocities()?;
        self.kp.validate("kp", 3)?;
        self.kd.validate("kd", 3)?;
        self.integral_settings().validate(3, setup.period())?;
        let measured =
            |tick: &Tick<'_>, p: &mut [f64]| p.copy_from_slice(tick.state.p_WR.as_slice());
        let reference = setup.follow_vector("reference", &*self.reference, 3, measured)?;
        let layout = Layout::rows([("x", "m/s²"), ("y", "m/s²"), ("z", "m/s²")])
            .error_unit("m")
            .vdot_unit([x, y, z]);
        let integral = Integral::new(3);
        Ok((
            layout,
            RunningBasePosition {
                reference,
                integral,
            },
        ))
    }

    fn update(&self, running: &mut RunningBasePosition, tick: &Tick<'_>, rows: &mut Rows<'_>) {
        let desired = tick.vector(running.reference);
        let v_WR = Vector3::from_fn(|i, _| tick.state.v[i]);
        let error = tick.state.p_WR - desired.value3();
        let rate = v_WR - desired.rate3();
        let mut acceleration =
            desired.acceleration3() - self.kd.times(&rate) - self.kp.times(&error);
        for i in 0..3 {
            let law = self.integral_settings().law(i);
            let given = tick.last_vdot[i];
            let integral = &mut running.integral;
            acceleration[i] -= integral.step(i, law, error[i], given, tick.elapsed);
            integral.ask(i, acceleration[i]);
            rows.acceleration(i, acceleration[i]);
        }
        rows.error().copy_from(&error);
    }

    fn activate(&self, running: &mut RunningBasePosition) {
        running.integral.reset();
    }

    fn remembered(&self, running: &mut Self::Running, numbers: &mut Remembered<'_>) {
        running.integral.remembered(numbers);
    }
}
