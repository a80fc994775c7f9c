//! Position of the centre of mass.
//!
//! # Notation
//! W world, G the centre of mass of the whole robot. All vectors in world axes.
#![allow(non_snake_case)]

use wbqp::{plugin::VectorReference, prelude::*};

use crate::{axis::Axis, follow::stay};

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
#[wbqp::task("com", weight = 100.0)]
pub struct Com {
    /// Stiffness `K_P`, 1/s²: one number, or one per axis.
    #[wbqp(unit = "1/s²")]
    pub kp: PerRow,
    /// Damping `K_D`, 1/s: one number, or one per axis. Default: critical, `2 √K_P`.
    #[wbqp(unit = "1/s", critical = "kp")]
    pub kd: PerRow,
    /// Which axes of the world; rows, gains and reference are in this order. Default: x, y, z.
    pub axes: Option<Vec<Axis>>,
    /// Where to go: one position per axis, m, world. Default: hold what is measured at the start.
    #[wbqp(default = stay(), unit = "m")]
    pub reference: Box<dyn AnyReference>,
}

impl Com {
    /// Holds the centre of mass where it is at the start with these gains (1/s², 1/s).
    pub fn new(kp: impl Into<PerRow>, kd: impl Into<PerRow>) -> Self {
        Self {
            kp: kp.into(),
            kd: kd.into(),
            axes: None,
            reference: stay(),
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

impl Task for Com {
    type Running = (Vec<Axis>, VectorReference);

    fn bind(&self, setup: &mut Setup<'_>) -> Result<(Layout, Self::Running), BindError> {
        let axes = Axis::chosen(self.axes.as_deref())?;
        let n = axes.len();
        self.kp.validate("kp", n)?;
        self.kd.validate("kd", n)?;
        let measured = axes.clone();
        let measured = move |tick: &Tick<'_>, out: &mut [f64]| {
            let p = tick.dynamics.center_of_mass();
            for (out, axis) in out.iter_mut().zip(&measured) {
                *out = p[axis.index()];
            }
        };
        let reference = setup.follow_vector("reference", &*self.reference, n, measured)?;
        let rows = axes.iter().map(|axis| (axis.name(), "m/s²"));
        let layout = Layout::rows(rows).error_unit("m").vdot_dense();
        Ok((layout, (axes, reference)))
    }

    fn update(&self, (axes, reference): &mut Self::Running, tick: &Tick<'_>, rows: &mut Rows<'_>) {
        let desired = tick.vector(*reference);
        let data = tick.dynamics;
        let (p, v) = (data.center_of_mass(), data.center_of_mass_velocity());
        let (jacobian, bias) = (data.center_of_mass_jacobian(), data.center_of_mass_bias());
        for (k, axis) in axes.iter().enumerate() {
            let i = axis.index();
            rows.jacobian(k, jacobian.row(i).iter(), bias[i]);
            let [value, rate, acceleration] = desired.component(k);
            rows.motion(
                k,
                MotionRow {
                    error: p[i] - value,
                    rate: v[i] - rate,
                    acceleration,
                    kp: self.kp.row(k),
                    kd: self.kd.row(k),
                },
            );
        }
    }

    fn remembered(&self, _: &mut Self::Running, _: &mut Remembered<'_>) {}
}
