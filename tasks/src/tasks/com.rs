//! Position of the centre of mass.
//!
//! # Notation
//! W world, G the centre of mass of the whole robot. All vectors in world axes.
#![allow(non_snake_case)]

use wbqp::{
    error::BindError,
    plugin::{
        Layout, AnyReference, Rows, Sample, Setup, Space, Task, Tick,
        reference::{ReferenceSlot, begin, begin_at},
    },
    schemars::JsonSchema,
    serde::{Deserialize, Serialize},
};

use crate::{
    axis::Axis,
    follow::{component, stay},
    gain::Gain,
    home,
};

/// Moves the robot's centre of mass: balance of a legged robot, the point that thrust has to carry of a flying one.
///
/// One row per axis, world axes, m/s²:
///
/// `J_G v̇ = p̈_d − K_D (ṗ_G − ṗ_d) − K_P (p_G − p_d) − J̇_G v`
///
/// (Jacobian of the centre of mass: Sugihara, Nakamura and Inoue, *Real-time humanoid motion generation through ZMP
/// manipulation based on inverted pendulum control*, ICRA 2002).
///
/// All links count, also those of a fixed base, which do not move: they pull the point towards themselves.
///
/// Error: `p_G − p_d`, m.
#[derive(Debug, Serialize, Deserialize, JsonSchema)]
#[serde(crate = "wbqp::serde", deny_unknown_fields)]
#[schemars(crate = "wbqp::schemars", extend("x-weight" = 100.0))]
pub struct Com {
    /// Stiffness `K_P`, 1/s²: one number, or one per axis.
    #[schemars(extend("x-unit" = "1/s²"))]
    pub kp: Gain,
    /// Damping `K_D`, 1/s: one number, or one per axis. Default: critical, `2 √K_P`.
    #[schemars(extend("x-unit" = "1/s", "x-critical" = "kp"))]
    pub kd: Gain,
    /// Which axes of the world; rows, gains and reference are in this order. Default: x, y, z.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub axes: Option<Vec<Axis>>,
    /// Where to go: one position per axis, m, world. Default: hold what is measured at the start.
    #[serde(default = "stay")]
    #[schemars(extend("x-unit" = "m"))]
    pub reference: Box<dyn AnyReference>,
    #[serde(skip)]
    sample: Sample,
    #[serde(skip)]
    moved: Vec<Axis>,
}

impl Com {
    /// Holds the centre of mass where it is at the start with these gains (1/s², 1/s).
    pub fn new(kp: impl Into<Gain>, kd: impl Into<Gain>) -> Self {
        Self {
            kp: kp.into(),
            kd: kd.into(),
            axes: None,
            reference: stay(),
            sample: Sample::default(),
            moved: Vec::new(),
        }
    }

    /// Follows a trajectory: one position per axis, m, world.
    pub fn following(mut self, reference: impl AnyReference) -> Self {
        self.reference = Box::new(reference);
        self
    }

    /// Moves only along these axes.
    pub fn along(mut self, axes: impl Into<Vec<Axis>>) -> Self {
        self.axes = Some(axes.into());
        self
    }
}

#[wbqp::task("com")]
impl Task for Com {
    fn bind(&mut self, setup: &mut Setup<'_>) -> Result<Layout, BindError> {
        let axes = Axis::chosen(self.axes.as_deref())?;
        let n = axes.len();
        self.kp.validate("kp", n)?;
        self.kd.validate("kd", n)?;
        let home = home::center_of_mass(setup);
        let home = Sample::at_rest(axes.iter().map(|axis| home[axis.index()]));
        self.sample = begin("reference", self.reference.as_mut(), Space::Vector(n), home)?;
        let rows = axes.iter().map(|axis| (axis.name(), "m/s²"));
        let layout = Layout::rows(rows).error_unit("m").vdot_dense();
        self.moved = axes;
        Ok(layout)
    }

    fn begin(&mut self, tick: &Tick<'_>) {
        let p = tick.dynamics.center_of_mass();
        let measured = self.moved.iter().map(|axis| p[axis.index()]);
        begin_at(self.reference.as_mut(), &mut self.sample, measured);
    }

    fn update(&mut self, tick: &Tick<'_>, rows: &mut Rows<'_>) {
        self.reference.sample(tick, &mut self.sample);
        let data = tick.dynamics;
        let (p, v) = (data.center_of_mass(), data.center_of_mass_velocity());
        let bias = data.center_of_mass_bias();
        let mut vdot = rows.vdot();
        for (k, axis) in self.moved.iter().enumerate() {
            let jacobian = data.center_of_mass_jacobian();
            vdot.row_mut(k).copy_from(&jacobian.row(axis.index()));
        }
        for (k, axis) in self.moved.iter().enumerate() {
            let i = axis.index();
            let error = p[i] - component(&self.sample.value, k);
            rows.b()[k] = component(&self.sample.acceleration, k)
                - self.kd.axis(k) * (v[i] - component(&self.sample.rate, k))
                - self.kp.axis(k) * error
                - bias[i];
            rows.error()[k] = error;
        }
    }

    fn follow(&mut self) -> Option<ReferenceSlot<'_>> {
        Some(ReferenceSlot {
            reference: &mut self.reference,
            sample: &self.sample,
            space: Space::Vector(self.moved.len()),
        })
    }
}
