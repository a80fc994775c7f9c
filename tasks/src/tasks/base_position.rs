//! Position of the floating base (p_R).
//!
//! # Notation
//! W world, R base, D desired base. All vectors in world axes.
#![allow(non_snake_case)]

use wbqp::{
    layout::Layout,
    model::Base,
    nalgebra::Vector3,
    reference::{Follow, Reference, Sample, Space},
    rows::Rows,
    schemars::JsonSchema,
    serde::{Deserialize, Serialize},
    setup::{BindError, Setup},
    task::Task,
    tick::Tick,
};

use crate::{
    follow::{at_rest, begin, stay},
    gain::Gain,
    integral::Integral,
};

/// Moves the origin of a floating base, the paper's p_R.
///
/// First row of (11), three rows in world axes, m/s²:
///
/// `v̇_WR = v̇_WD − K_D (v_WR − v_WD) − K_P (p_WR − p_WD) − K_I ∫ (p_WR − p_WD) dt`.
///
/// The integral is not in the paper and off by default; it removes the sag that a wrong mass or thrust leaves. It is
/// clamped per axis and starts at zero whenever the task is switched on.
///
/// Error: `p_WR − p_WD`, m. Gains are along world axes.
#[derive(Debug, Serialize, Deserialize, JsonSchema)]
#[serde(crate = "wbqp::serde", deny_unknown_fields)]
#[schemars(crate = "wbqp::schemars")]
pub struct BasePosition {
    /// Stiffness `K_P`, 1/s²: one number, or one per world axis.
    #[schemars(extend("x-unit" = "1/s²"))]
    pub kp: Gain,
    /// Damping `K_D`, 1/s: one number, or one per world axis.
    #[schemars(extend("x-unit" = "1/s"))]
    pub kd: Gain,
    /// Integral gain `K_I`, 1/s³: one number, or one per world axis. 0, the default, is the paper's law.
    #[serde(default = "no_integral")]
    #[schemars(extend("x-unit" = "1/s³"))]
    pub ki: Gain,
    /// Largest acceleration that the integral may ask for on each axis, m/s².
    #[serde(default = "default_integral_limit")]
    #[schemars(extend("x-unit" = "m/s²"))]
    pub integral_limit: f64,
    /// Where to go: position of the base's origin in the world, m. Default: hold the home posture's.
    #[serde(default = "stay")]
    #[schemars(extend("x-unit" = "m"))]
    pub reference: Box<dyn Reference>,
    #[serde(skip)]
    sample: Sample,
    #[serde(skip)]
    integral: Integral,
}

fn no_integral() -> Gain {
    Gain::Uniform(0.0)
}
fn default_integral_limit() -> f64 {
    2.0
}

impl BasePosition {
    /// Holds the home position with these gains (1/s², 1/s), without integral.
    pub fn new(kp: impl Into<Gain>, kd: impl Into<Gain>) -> Self {
        Self {
            kp: kp.into(),
            kd: kd.into(),
            ki: no_integral(),
            integral_limit: default_integral_limit(),
            reference: stay(),
            sample: Sample::default(),
            integral: Integral::default(),
        }
    }

    /// Follows a trajectory: position in the world, m.
    pub fn following(mut self, reference: impl Reference) -> Self {
        self.reference = Box::new(reference);
        self
    }
}

#[wbqp::task("base_position")]
impl Task for BasePosition {
    fn bind(&mut self, setup: &mut Setup<'_>) -> Result<Layout, BindError> {
        require_floating(setup)?;
        self.kp.validate("kp", 3)?;
        self.kd.validate("kd", 3)?;
        Integral::validate(&self.ki, self.integral_limit, 3)?;
        let home = at_rest(setup.robot().home.p_WR.iter().copied());
        self.sample = begin(self.reference.as_mut(), Space::Vector(3), home)?;
        self.integral = Integral::new(3);
        Ok(Layout::rows([("x", "m/s²"), ("y", "m/s²"), ("z", "m/s²")])
            .error_unit("m")
            .vdot_unit([0, 1, 2]))
    }

    fn update(&mut self, tick: &Tick<'_>, rows: &mut Rows<'_>) {
        self.reference.sample(tick, &mut self.sample);
        let v_WR = Vector3::from_fn(|i, _| tick.state.v[i]);
        let error = tick.state.p_WR - self.sample.value3();
        let rate = v_WR - self.sample.rate3();
        let integral = Vector3::from_fn(|i, _| {
            let growth = self.ki.axis(i) * error[i];
            self.integral
                .step(i, growth, tick.period, self.integral_limit)
        });
        let acceleration =
            self.sample.acceleration3() - self.kd.times(&rate) - self.kp.times(&error) - integral;
        rows.b().copy_from(&acceleration);
        rows.error().copy_from(&error);
    }

    fn activate(&mut self) {
        self.integral.reset();
    }

    fn follow(&mut self) -> Option<Follow<'_>> {
        Some(Follow {
            reference: &mut self.reference,
            sample: &self.sample,
            space: Space::Vector(3),
        })
    }
}

/// Refuses robots that are bolted down.
pub(crate) fn require_floating(setup: &Setup<'_>) -> Result<(), BindError> {
    match setup.model().base() {
        Base::Floating => Ok(()),
        Base::Fixed => Err(BindError::Other(format!(
            "needs a floating base, `{}` has a fixed one",
            setup.model().name()
        ))),
    }
}
