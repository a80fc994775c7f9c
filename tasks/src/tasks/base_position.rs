//! Position of the floating base (p_R).
//!
//! # Notation
//! W world, R base, D desired base. All vectors in world axes.
#![allow(non_snake_case)]

use wbqp::{
    error::BindError,
    model::Base,
    nalgebra::Vector3,
    plugin::{
        Layout, AnyReference, Rows, Sample, Setup, Space, Task, Tick,
        reference::{ReferenceSlot, begin, begin_at},
    },
    schemars::JsonSchema,
    serde::{Deserialize, Serialize},
};

use crate::{
    follow::stay,
    gain::Gain,
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
#[derive(Debug, Serialize, Deserialize, JsonSchema)]
#[serde(crate = "wbqp::serde", deny_unknown_fields)]
#[schemars(crate = "wbqp::schemars", extend("x-weight" = 100.0))]
pub struct BasePosition {
    /// Stiffness `K_P`, 1/s²: one number, or one per world axis.
    #[schemars(extend("x-unit" = "1/s²"))]
    pub kp: Gain,
    /// Damping `K_D`, 1/s: one number, or one per world axis. Default: critical, `2 √K_P`.
    #[schemars(extend("x-unit" = "1/s", "x-critical" = "kp"))]
    pub kd: Gain,
    /// Integral gain `K_I`, 1/s³: one number, or one per world axis. 0, the default, is the paper's law.
    #[serde(default = "no_integral")]
    #[schemars(extend("x-unit" = "1/s³"))]
    pub ki: Gain,
    /// Largest acceleration that the integral may ask for on each axis, m/s².
    #[serde(default = "default_integral_limit")]
    #[schemars(extend("x-unit" = "m/s²"))]
    pub integral_limit: f64,
    /// Back-calculation gain `k_aw` of the integral, 1/s: one number, or one per world axis. Default `K_I/K_P`, with
    /// which the integral stays out of conflicts with limits and other tasks; 0 leaves only `integral_limit`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-unit" = "1/s"))]
    pub anti_windup: Option<Gain>,
    /// Where to go: position of the base's origin in the world, m. Default: hold what is measured at the start.
    #[serde(default = "stay")]
    #[schemars(extend("x-unit" = "m"))]
    pub reference: Box<dyn AnyReference>,
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
    /// Holds the position of the start with these gains (1/s², 1/s), without integral.
    pub fn new(kp: impl Into<Gain>, kd: impl Into<Gain>) -> Self {
        Self {
            kp: kp.into(),
            kd: kd.into(),
            ki: no_integral(),
            integral_limit: default_integral_limit(),
            anti_windup: None,
            reference: stay(),
            sample: Sample::default(),
            integral: Integral::default(),
        }
    }

    /// Follows a trajectory: position in the world, m.
    pub fn following(mut self, reference: impl AnyReference) -> Self {
        self.reference = Box::new(reference);
        self
    }

    /// Adds the integral (1/s³), clamped to an acceleration in m/s².
    pub fn with_integral(mut self, ki: impl Into<Gain>, limit: f64) -> Self {
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

#[wbqp::task("base_position")]
impl Task for BasePosition {
    fn bind(&mut self, setup: &mut Setup<'_>) -> Result<Layout, BindError> {
        require_floating(setup)?;
        self.kp.validate("kp", 3)?;
        self.kd.validate("kd", 3)?;
        self.integral_settings().validate(3, setup.period())?;
        let home = Sample::at_rest(setup.robot().home.p_WR.iter().copied());
        self.sample = begin("reference", self.reference.as_mut(), Space::Vector(3), home)?;
        self.integral = Integral::new(3);
        Ok(Layout::rows([("x", "m/s²"), ("y", "m/s²"), ("z", "m/s²")])
            .error_unit("m")
            .vdot_unit([0, 1, 2]))
    }

    fn begin(&mut self, tick: &Tick<'_>) {
        let measured = tick.state.p_WR.iter().copied();
        begin_at(self.reference.as_mut(), &mut self.sample, measured);
    }

    fn update(&mut self, tick: &Tick<'_>, rows: &mut Rows<'_>) {
        self.reference.sample(tick, &mut self.sample);
        let v_WR = Vector3::from_fn(|i, _| tick.state.v[i]);
        let error = tick.state.p_WR - self.sample.value3();
        let rate = v_WR - self.sample.rate3();
        let mut acceleration =
            self.sample.acceleration3() - self.kd.times(&rate) - self.kp.times(&error);
        for i in 0..3 {
            let law = self.integral_settings().law(i);
            let given = tick.last.vdot[i];
            acceleration[i] -= self.integral.step(i, law, error[i], given, tick.elapsed);
            self.integral.ask(i, acceleration[i]);
        }
        rows.b().copy_from(&acceleration);
        rows.error().copy_from(&error);
    }

    fn activate(&mut self) {
        self.integral.reset();
    }

    fn follow(&mut self) -> Option<ReferenceSlot<'_>> {
        Some(ReferenceSlot {
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
