//! Motion along the free directions of a contact (p_f).
//!
//! # Notation
//! W world, C the surface's frame (z its outward normal), S the origin of surface coordinates, E the robot's frame
//! that touches. All vectors in C axes, which do not turn.
#![allow(non_snake_case)]

use wbqp::{
    contact::{ContactId, ContactSpec},
    dynamics::{Data, frame_motion},
    error::BindError,
    nalgebra::Vector3,
    plugin::{
        Layout, AnyReference, Rows, Sample, Setup, Space, Task, Tick,
        reference::{ReferenceSlot, begin, begin_at},
    },
    schemars::JsonSchema,
    serde::{Deserialize, Serialize},
};

use crate::{
    follow::{component, stay},
    gain::Gain,
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
/// the bias `J̇_f v`. `a_S` is the acceleration of a moving surface.
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
#[derive(Debug, Serialize, Deserialize, JsonSchema)]
#[serde(crate = "wbqp::serde", deny_unknown_fields)]
#[schemars(crate = "wbqp::schemars")]
pub struct FreeMotion {
    /// The contact, by name.
    pub contact: String,
    /// Stiffness `K_P`, 1/s²: one number, or one per axis.
    #[schemars(extend("x-unit" = "1/s²"))]
    pub kp: Gain,
    /// Damping `K_D`, 1/s: one number, or one per axis. Default: critical, `2 √K_P`.
    #[schemars(extend("x-unit" = "1/s", "x-critical" = "kp"))]
    pub kd: Gain,
    /// Integral gain `K_I`, 1/s³: one number, or one per axis. 0, the default, is the paper's law.
    #[serde(default = "no_integral")]
    #[schemars(extend("x-unit" = "1/s³"))]
    pub ki: Gain,
    /// Largest acceleration that the integral may ask for on each axis, m/s².
    #[serde(default = "default_integral_limit")]
    #[schemars(extend("x-unit" = "m/s²"))]
    pub integral_limit: f64,
    /// Back-calculation gain `k_aw` of the integral, 1/s: one number, or one per axis. Default `K_I/K_P`, with which
    /// the integral stays out of conflicts with limits and other tasks; 0 leaves only `integral_limit`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-unit" = "1/s"))]
    pub anti_windup: Option<Gain>,
    /// Which axes of the surface; rows, gains and reference are in this order. Default: all translations that the
    /// contact leaves free, x before y.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub axes: Option<Vec<SurfaceAxis>>,
    /// Where the reference counts from.
    #[serde(default)]
    pub origin: Origin,
    /// Where to go: one position per axis, m, from `origin`. Default: hold.
    #[serde(default = "stay")]
    #[schemars(extend("x-unit" = "m"))]
    pub reference: Box<dyn AnyReference>,
    #[serde(skip)]
    sample: Sample,
    #[serde(skip)]
    integral: Integral,
    #[serde(skip)]
    bound: Option<Bound>,
}

/// A tangential axis of the surface's frame C.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(crate = "wbqp::serde", rename_all = "snake_case")]
#[schemars(crate = "wbqp::schemars")]
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
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(crate = "wbqp::serde", rename_all = "snake_case")]
#[schemars(crate = "wbqp::schemars")]
pub enum Origin {
    /// The surface's `origin`. Holding without a value means staying where the contact point is measured at the
    /// start.
    #[default]
    Surface,
    /// Where the contact point was when the contact (or the task) was last switched on. Holding without a value means
    /// staying where it touched.
    Touch,
}

/// What `bind` resolved, and where the contact was made.
#[derive(Clone, Debug)]
struct Bound {
    contact: ContactId,
    axes: Vec<SurfaceAxis>,
    /// Position that the reference counts from, m, surface coordinates; unknown until the first update.
    base: Option<Vector3<f64>>,
}

fn no_integral() -> Gain {
    Gain::Uniform(0.0)
}
fn default_integral_limit() -> f64 {
    2.0
}

impl FreeMotion {
    /// Holds the contact point along all free translations with these gains (1/s², 1/s), without integral.
    pub fn new(contact: impl Into<String>, kp: impl Into<Gain>, kd: impl Into<Gain>) -> Self {
        Self {
            contact: contact.into(),
            kp: kp.into(),
            kd: kd.into(),
            ki: no_integral(),
            integral_limit: default_integral_limit(),
            anti_windup: None,
            axes: None,
            origin: Origin::default(),
            reference: stay(),
            sample: Sample::default(),
            integral: Integral::default(),
            bound: None,
        }
    }

    /// Follows a trajectory: one position per axis, m, from an origin.
    pub fn following(mut self, reference: impl AnyReference, origin: Origin) -> Self {
        self.reference = Box::new(reference);
        self.origin = origin;
        self
    }

    /// Adds the integral (1/s³), clamped to an acceleration in m/s².
    pub fn with_integral(mut self, ki: impl Into<Gain>, limit: f64) -> Self {
        (self.ki, self.integral_limit) = (ki.into(), limit);
        self
    }

    /// Moves only along these axes.
    pub fn along(mut self, axes: impl Into<Vec<SurfaceAxis>>) -> Self {
        self.axes = Some(axes.into());
        self
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

/// The contact point in the home posture, m, surface coordinates.
fn at_home(setup: &Setup<'_>, spec: &ContactSpec) -> Result<Vector3<f64>, BindError> {
    let model = setup.model();
    let mut data = Data::new(model);
    data.update(model, &setup.robot().home);
    // The controller has checked the contact's frame; a test may not have.
    let frame = model.frame(&spec.frame).ok_or_else(|| {
        BindError::value(
            "contact",
            format!("`{}` is on no frame of the robot", spec.name),
        )
    })?;
    let X_WE = frame_motion(model, &data, frame);
    let p_WC = X_WE.p_WF + X_WE.R_WF * Vector3::from(spec.offset);
    let p_WS = Vector3::from(spec.surface.origin);
    Ok(spec.surface.rotation()?.inverse() * (p_WC - p_WS))
}

#[wbqp::task("free_motion")]
impl Task for FreeMotion {
    fn bind(&mut self, setup: &mut Setup<'_>) -> Result<Layout, BindError> {
        let contact = setup.contact(&self.contact)?;
        let spec = setup.contact_spec(contact);
        let axes = self.resolve(spec)?;
        let n = axes.len();
        self.kp.validate("kp", n)?;
        self.kd.validate("kd", n)?;
        Settings {
            kp: &self.kp,
            ki: &self.ki,
            anti_windup: self.anti_windup.as_ref(),
            limit: self.integral_limit,
        }
        .validate(n, setup.period())?;
        let from = match self.origin {
            Origin::Surface => at_home(setup, spec)?,
            Origin::Touch => Vector3::zeros(),
        };
        let from = Sample::at_rest(axes.iter().map(|axis| from[axis.row()]));
        self.sample = begin("reference", self.reference.as_mut(), Space::Vector(n), from)?;
        self.integral = Integral::new(n);
        let layout = Layout::rows(axes.iter().map(|axis| (axis.name(), "m/s²")))
            .error_unit("m")
            .vdot_contact(contact, axes.iter().map(|axis| axis.row()))
            .while_contact(contact);
        self.bound = Some(Bound {
            contact,
            axes,
            base: None,
        });
        Ok(layout)
    }

    fn begin(&mut self, tick: &Tick<'_>) {
        // Where it touches is zero, wherever that is.
        if let (Some(bound), Origin::Surface) = (&self.bound, self.origin) {
            let p_SC = tick.contact(bound.contact).p_SC;
            let measured = bound.axes.iter().map(|axis| p_SC[axis.row()]);
            begin_at(self.reference.as_mut(), &mut self.sample, measured);
        }
    }

    fn update(&mut self, tick: &Tick<'_>, rows: &mut Rows<'_>) {
        let Some(bound) = &mut self.bound else {
            return;
        };
        self.reference.sample(tick, &mut self.sample);
        let contact = tick.contact(bound.contact);
        let base = *bound.base.get_or_insert(match self.origin {
            Origin::Surface => Vector3::zeros(),
            Origin::Touch => contact.p_SC,
        });
        let settings = Settings {
            kp: &self.kp,
            ki: &self.ki,
            anti_windup: self.anti_windup.as_ref(),
            limit: self.integral_limit,
        };
        for (k, axis) in bound.axes.iter().enumerate() {
            let i = axis.row();
            let error = contact.p_SC[i] - base[i] - component(&self.sample.value, k);
            let rate = contact.V[i] - component(&self.sample.rate, k);
            let row = contact.J.row(i);
            let given = row.iter().zip(&tick.last.vdot).map(|(j, a)| j * a).sum();
            let integral = self
                .integral
                .step(k, settings.law(k), error, given, tick.elapsed);
            let asked = component(&self.sample.acceleration, k)
                - self.kd.axis(k) * rate
                - self.kp.axis(k) * error
                - integral
                + contact.surface_acceleration[i]
                - contact.Jdot_v[i];
            self.integral.ask(k, asked);
            rows.b()[k] = asked;
            rows.error()[k] = error;
        }
    }

    fn activate(&mut self) {
        self.integral.reset();
        if let Some(bound) = &mut self.bound {
            bound.base = None;
        }
    }

    fn follow(&mut self) -> Option<ReferenceSlot<'_>> {
        let bound = self.bound.as_ref()?;
        Some(ReferenceSlot {
            reference: &mut self.reference,
            sample: &self.sample,
            space: Space::Vector(bound.axes.len()),
        })
    }
}
