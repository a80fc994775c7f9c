//! Motion along the free directions of a contact (p_f).
//!
//! # Notation
//! W world, C the surface's frame (z its outward normal), S the origin of surface coordinates, E the robot's frame
//! that touches. All vectors in C axes, which do not turn.
#![allow(non_snake_case)]

use wbqp::{contact::ContactSpec, plugin::VectorReference, prelude::*};

use crate::{
    follow::stay,
    integral::{Integral, Settings},
};

/// Slides the contact point along the surface, the paper's p_f.
///
/// Fourth row of (11), one row per axis in C axes, m/s², with `p` the contact point on the robot in surface
/// coordinates and `v` its velocity relative to the surface:
///
/// `J_f v̇ = v̇_d − K_D (v − v_d) − K_P (p − p_d) − ξ + a_S − J̇_f v`, `ξ̇ = K_I (p − p_d) + k_aw (a* − a_QP)`.
///
/// `J_f` is made of rows of the contact's Jacobian in C axes. The paper turns the Jacobian with the end effector
/// instead, which lets the normal direction leak into this task when the tool tilts, and its (8) prints `J_f v` for
/// the bias `J̇_f v`. `a_S` is the acceleration of a moving surface, with Coriolis'.
///
/// The integral ξ is not in the paper and off by default; it removes what a wrong mass or thrust leaves. It is clamped
/// per axis and starts at zero whenever the contact or the task is switched on. Its second part is back-calculation
/// against wind-up: `a*` is what the row asked for in the last tick, `a_QP` what limits and other tasks left of it:
/// `J_f` of this tick times the last solution's `v̇`. Where `J_f` has turned in between, as it does in fast motion
/// while the limits are reached, a little of that is counted as left out.
///
/// The axes are translations. Free rotations are not controlled by this task.
///
/// Exists while the contact is on. Error: `p − p_d`, m.
#[wbqp::task("free_motion")]
pub struct FreeMotion {
    /// The contact, by name.
    pub contact: String,
    /// Stiffness `K_P`, 1/s²: one number, or one per axis.
    #[wbqp(unit = "1/s²")]
    pub kp: PerRow,
    /// Damping `K_D`, 1/s: one number, or one per axis. Default: critical, `2 √K_P`.
    #[wbqp(unit = "1/s", critical = "kp")]
    pub kd: PerRow,
    /// Integral gain `K_I`, 1/s³: one number, or one per axis. 0, the default, is the paper's law.
    #[wbqp(default = 0.0, unit = "1/s³")]
    pub ki: PerRow,
    /// Largest acceleration that the integral may ask for on each axis, m/s².
    #[wbqp(default = 2.0, unit = "m/s²")]
    pub integral_limit: f64,
    /// Back-calculation gain `k_aw` of the integral, 1/s: one number, or one per axis. Default `K_I/K_P`, with which
    /// the integral stays out of conflicts with limits and other tasks; 0 leaves only `integral_limit`.
    #[wbqp(unit = "1/s")]
    pub anti_windup: Option<PerRow>,
    /// Which axes of the surface; rows, gains and reference are in this order. Default: all translations that the
    /// contact leaves free, x before y.
    pub axes: Option<Vec<SurfaceAxis>>,
    /// Where the reference counts from.
    #[wbqp(default)]
    pub origin: Origin,
    /// Where to go: one position per axis, m, from `origin`. Default: hold.
    #[wbqp(default = stay(), unit = "m")]
    pub reference: Box<dyn AnyReference>,
}

/// A tangential axis of the surface's frame C.
#[wbqp::parameters]
#[derive(Copy, PartialEq, Eq)]
pub enum SurfaceAxis {
    /// The surface's `x_axis`, projected.
    X,
    /// `z × x`, z the outward normal.
    Y,
}

impl SurfaceAxis {
    /// Row of the contact's six.
    fn row(self) -> usize {
        match self {
            Self::X => 0,
            Self::Y => 1,
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::X => "x",
            Self::Y => "y",
        }
    }
}

/// Where positions on a surface count from.
#[wbqp::parameters]
#[derive(Copy, Default, PartialEq, Eq)]
pub enum Origin {
    /// The surface's `origin`. Holding without a value means staying where the contact point is measured at the
    /// start.
    #[default]
    Surface,
    /// Where the contact point was when the contact (or the task) was last switched on. Holding without a value means
    /// staying where it touched.
    Touch,
}

/// What runs of a [`FreeMotion`].
#[derive(Debug)]
pub struct RunningFreeMotion {
    contact: ContactId,
    axes: Vec<SurfaceAxis>,
    /// Where the reference was bound to count from.
    origin: Origin,
    reference: VectorReference,
    integral: Integral,
    /// Position that the reference counts from, m, surface coordinates; unknown until the first update.
    base: Option<Vector3<f64>>,
}

impl FreeMotion {
    /// Holds the contact point along all free translations with these gains (1/s², 1/s), without integral.
    pub fn new(contact: impl Into<String>, kp: impl Into<PerRow>, kd: impl Into<PerRow>) -> Self {
        Self {
            contact: contact.into(),
            kp: kp.into(),
            kd: kd.into(),
            ki: Self::default_ki(),
            integral_limit: Self::default_integral_limit(),
            anti_windup: None,
            axes: None,
            origin: Origin::default(),
            reference: stay(),
        }
    }

    /// Follows a trajectory: one position per axis, m, from an origin.
    pub fn following(mut self, reference: impl AnyReference, origin: Origin) -> Self {
        self.reference = Box::new(reference);
        self.origin = origin;
        self
    }

    /// Adds the integral (1/s³), clamped to an acceleration in m/s².
    pub fn with_integral(mut self, ki: impl Into<PerRow>, limit: f64) -> Self {
        (self.ki, self.integral_limit) = (ki.into(), limit);
        self
    }

    /// Moves only along these axes.
    pub fn along(mut self, axes: impl Into<Vec<SurfaceAxis>>) -> Self {
        self.axes = Some(axes.into());
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

    fn resolve(&self, spec: &ContactSpec) -> Result<Vec<SurfaceAxis>, BindError> {
        let free = |axis: &SurfaceAxis| spec.kind.free().contains(&axis.row());
        let Some(axes) = &self.axes else {
            let axes = [SurfaceAxis::X, SurfaceAxis::Y];
            let axes: Vec<_> = axes.into_iter().filter(free).collect();
            if axes.is_empty() {
                let problem = format!("`{}` leaves no translation free", spec.name);
                return Err(BindError::value("contact", problem));
            }
            return Ok(axes);
        };
        if axes.is_empty() {
            return Err(BindError::length("axes", 0, "at least one"));
        }
        for (i, axis) in axes.iter().enumerate() {
            let problem = if !free(axis) {
                format!(
                    "contains `{}`, which `{}` constrains",
                    axis.name(),
                    spec.name
                )
            } else if axes[..i].contains(axis) {
                format!("names `{}` twice", axis.name())
            } else {
                continue;
            };
            return Err(BindError::value("axes", problem));
        }
        Ok(axes.clone())
    }
}

impl Task for FreeMotion {
    type Running = RunningFreeMotion;

    fn bind(&self, setup: &mut Setup<'_>) -> Result<(Layout, RunningFreeMotion), BindError> {
        let contact = setup.contact(&self.contact)?;
        let axes = self.resolve(setup.contact_spec(contact))?;
        let n = axes.len();
        self.kp.validate("kp", n)?;
        self.kd.validate("kd", n)?;
        self.integral_settings().validate(n, setup.period())?;
        let key = "reference";
        let reference = match self.origin {
            Origin::Surface => {
                let axes = axes.clone();
                let measured = move |tick: &Tick<'_>, out: &mut [f64]| {
                    for (out, axis) in out.iter_mut().zip(&axes) {
                        *out = tick.contact(contact).p_SC[axis.row()];
                    }
                };
                setup.follow_vector(key, &*self.reference, n, measured)?
            }
            // Where it touches is zero, wherever that is.
            Origin::Touch => setup.follow_from_zero(key, &*self.reference, n)?,
        };
        let layout = Layout::rows(axes.iter().map(|axis| (axis.name(), "m/s²")))
            .error_unit("m")
            .vdot_contact(contact, axes.iter().map(|axis| axis.row()))
            .while_contact(contact);
        let running = RunningFreeMotion {
            contact,
            axes,
            origin: self.origin,
            reference,
            integral: Integral::new(n),
            base: None,
        };
        Ok((layout, running))
    }

    fn update(&self, running: &mut RunningFreeMotion, tick: &Tick<'_>, rows: &mut Rows<'_>) {
        let contact = tick.contact(running.contact);
        let desired = tick.vector(running.reference);
        let base = *running.base.get_or_insert(match running.origin {
            Origin::Surface => Vector3::zeros(),
            Origin::Touch => contact.p_SC,
        });
        let settings = self.integral_settings();
        for (k, axis) in running.axes.iter().enumerate() {
            let i = axis.row();
            let [value, rate, acceleration] = desired.component(k);
            let error = contact.p_SC[i] - base[i] - value;
            let rate = contact.V[i] - rate;
            let row = contact.J.row(i);
            let given = row.iter().zip(tick.last_vdot).map(|(j, a)| j * a).sum();
            let integral = &mut running.integral;
            let xi = integral.step(k, settings.law(k), error, given, tick.elapsed);
            let wanted = acceleration - self.kd.row(k) * rate - self.kp.row(k) * error - xi
                + contact.surface_acceleration[i];
            rows.acceleration(k, wanted);
            integral.ask(k, rows.b()[k]);
            rows.error()[k] = error;
        }
    }

    fn activate(&self, running: &mut RunningFreeMotion) {
        running.integral.reset();
        running.base = None;
    }

    fn remembered(&self, running: &mut Self::Running, numbers: &mut Remembered<'_>) {
        running.integral.remembered(numbers);
        numbers.option(&mut running.base, Vector3::zeros(), |numbers, base| {
            numbers.numbers(base.iter_mut());
        });
    }
}
