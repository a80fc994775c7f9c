//! Contact force with direct feedback (f_c).
//!
//! # Notation
//! Forces are what the environment does to the robot, in C axes (z the surface's outward normal), so that pushing gives
//! `f_n > 0`. Four forces are told apart: `f^d` set point, `f*` virtual input, `f_QP` solution, `f^m` measured.

mod feedback;
mod set_point;

use feedback::{Loop, Settings};
use set_point::{Now, Ramp, SetPoint};
use wbqp::{
    contact::{ContactId, ContactKind},
    error::BindError,
    nalgebra::Vector3,
    plugin::{
        ForceReport, Layout, AnyReference, Rows, Sample, Setup, Space, Task, Tick,
        reference::{ReferenceSlot, begin},
    },
    schemars::JsonSchema,
    serde::{Deserialize, Serialize},
};

use crate::{Hold, check, follow::component};

/// Pushes with a given normal force, the paper's f_c.
///
/// Fifth row of (11), with back-calculation against wind-up, for the normal component:
///
/// `f* = f^d − K_P (f^m − f^d) − ξ`, `ξ̇ = K_I (f^m − f^d) + k_aw (f* − f_QP)`, `|ξ| ≤ clamp`.
///
/// When `f*` asks for more than the solver gives (limits, other tasks), ξ grows and `f*` comes down. The price: as
/// long as `f* ≠ f_QP`, the measured force settles `k_aw/K_I (f* − f_QP)` below the set point.
///
/// One row per constrained component of the contact, N or N·m, in the contact's order: `normal` for kind `normal`;
/// `x`, `y`, `normal` for `point`; `normal`, `moment x`, `moment y` for `normal_tilt`. Per-row weights of the entry
/// are in this order. Feedback acts on the normal alone; moments are asked to be zero.
///
/// # Switching
/// When the contact or the task comes on, the set point starts at the measured force and goes to `f^d` with the ramp,
/// and the integrator starts at zero. When the contact goes off with a ramp, the feedback stops and `f*` goes from the
/// solution at that moment to zero with the ramp. When the task alone goes off, its weight fades.
///
/// Exists while the contact is on. Error: `f^m − f^d`, N or N·m.
#[derive(Debug, Serialize, Deserialize, JsonSchema)]
#[serde(crate = "wbqp::serde", deny_unknown_fields)]
#[schemars(crate = "wbqp::schemars")]
pub struct ContactForce {
    /// The contact, by name.
    pub contact: String,
    /// Set point `f^d` of the normal force: a reference with one component, N.
    #[schemars(extend("x-unit" = "N"))]
    pub reference: Box<dyn AnyReference>,
    /// Whether the measured force is fed back.
    #[serde(default)]
    pub feedback: Feedback,
    /// Proportional gain `K_P`, N/N, below 1: in a stiff contact the measured force follows `f*` within a period, and
    /// the loop would oscillate at 1.
    #[serde(default = "default_kp")]
    #[schemars(extend("x-unit" = "1"))]
    pub kp: f64,
    /// Integral gain `K_I`, 1/s.
    #[serde(default = "default_ki")]
    #[schemars(extend("x-unit" = "1/s"))]
    pub ki: f64,
    /// Back-calculation gain `k_aw`, 1/s. 0 leaves only the clamp against wind-up.
    #[serde(default = "default_anti_windup")]
    #[schemars(extend("x-unit" = "1/s"))]
    pub anti_windup: f64,
    /// Largest magnitude of the integrator's state ξ, N. The report says when it is reached.
    #[serde(default = "default_clamp")]
    #[schemars(extend("x-unit" = "N"))]
    pub clamp: f64,
    /// What is asked of the tangential forces, where the contact constrains them.
    #[serde(default)]
    pub tangential: Tangential,
    #[serde(skip)]
    sample: Sample,
    #[serde(skip)]
    feedback_loop: Loop,
    #[serde(skip)]
    ramp: Ramp,
    #[serde(skip)]
    report: Option<ForceReport>,
    #[serde(skip)]
    bound: Option<(ContactId, ContactKind)>,
}

/// Feedback of the measured normal force.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(crate = "wbqp::serde", rename_all = "snake_case")]
#[schemars(crate = "wbqp::schemars")]
pub enum Feedback {
    /// None: `f* = f^d`.
    Off,
    /// Proportional and integral.
    #[default]
    Pi,
}

/// What is asked of tangential forces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(crate = "wbqp::serde", rename_all = "snake_case")]
#[schemars(crate = "wbqp::schemars")]
pub enum Tangential {
    /// Zero: as little friction as possible.
    #[default]
    Zero,
    /// What is measured: friction is taken as it is.
    Measured,
}

fn default_kp() -> f64 {
    0.2
}
fn default_ki() -> f64 {
    1.5
}
fn default_anti_windup() -> f64 {
    0.5
}
fn default_clamp() -> f64 {
    2.0
}

impl ContactForce {
    /// Pushes with a constant normal force in N, with feedback and the default gains.
    pub fn new(contact: impl Into<String>, force: f64) -> Self {
        Self {
            contact: contact.into(),
            reference: Box::new(Hold::at([force])),
            feedback: Feedback::default(),
            kp: default_kp(),
            ki: default_ki(),
            anti_windup: default_anti_windup(),
            clamp: default_clamp(),
            tangential: Tangential::default(),
            sample: Sample::default(),
            feedback_loop: Loop::default(),
            ramp: Ramp::default(),
            report: None,
            bound: None,
        }
    }

    /// Follows a trajectory of the normal force, N.
    pub fn following(mut self, reference: impl AnyReference) -> Self {
        self.reference = Box::new(reference);
        self
    }

    /// Does not feed the measured force back.
    pub fn without_feedback(mut self) -> Self {
        self.feedback = Feedback::Off;
        self
    }

    /// Feeds back with these gains (N/N, 1/s).
    pub fn with_gains(mut self, kp: f64, ki: f64) -> Self {
        (self.feedback, self.kp, self.ki) = (Feedback::Pi, kp, ki);
        self
    }

    fn settings(&self) -> Settings {
        let (kp, ki, anti_windup) = match self.feedback {
            Feedback::Off => (0.0, 0.0, 0.0),
            Feedback::Pi => (self.kp, self.ki, self.anti_windup),
        };
        Settings {
            kp,
            ki,
            anti_windup,
            clamp: self.clamp,
        }
    }
}

/// Labels and units of a contact's six components.
pub(super) const COMPONENTS: [(&str, &str); 6] = [
    ("x", "N"),
    ("y", "N"),
    ("normal", "N"),
    ("moment x", "N·m"),
    ("moment y", "N·m"),
    ("moment z", "N·m"),
];

#[wbqp::task("contact_force")]
impl Task for ContactForce {
    fn bind(&mut self, setup: &mut Setup<'_>) -> Result<Layout, BindError> {
        let contact = setup.contact(&self.contact)?;
        let kind = setup.contact_spec(contact).kind;
        check::not_negative("kp", self.kp)?;
        if self.kp >= 1.0 {
            return Err(BindError::value(
                "kp",
                format!("is {}, must be below 1: the loop would oscillate", self.kp),
            ));
        }
        check::not_negative("ki", self.ki)?;
        check::not_negative("anti_windup", self.anti_windup)?;
        check::positive("clamp", self.clamp)?;
        self.sample = begin(
            "reference",
            self.reference.as_mut(),
            Space::Vector(1),
            Sample::at_rest([0.0]),
        )?;
        self.bound = Some((contact, kind));
        self.activate();
        let rows = kind.constrained();
        let moments = rows.iter().any(|&row| row > 2);
        Ok(Layout::rows(rows.iter().map(|&row| COMPONENTS[row]))
            .error_unit(if moments { "N or N·m" } else { "N" })
            .force_unit(contact, 0..rows.len())
            .while_contact(contact))
    }

    fn update(&mut self, tick: &Tick<'_>, rows: &mut Rows<'_>) {
        let Some((id, kind)) = self.bound else {
            return;
        };
        self.reference.sample(tick, &mut self.sample);
        let contact = tick.contact(id);
        let (measured, solution) = (contact.measured[2], contact.solution[2]);
        let settings = self.settings();
        let now = Now {
            contact: contact.alpha,
            task: tick.entry.alpha,
            target: component(&self.sample.value, 0),
            measured,
            solution,
        };
        let (set_point, virtual_input) = match self.ramp.update(&now) {
            SetPoint::Follow(force) => {
                let input =
                    self.feedback_loop
                        .step(&settings, tick.elapsed, force, measured, solution);
                (force, input)
            }
            SetPoint::Release(force) => (force, force),
        };
        let tangential = |row: usize| match self.tangential {
            Tangential::Zero => 0.0,
            Tangential::Measured => contact.measured[row],
        };
        let mut reference = Vector3::new(0.0, 0.0, set_point);
        let mut input = Vector3::new(0.0, 0.0, virtual_input);
        for (k, &row) in kind.constrained().iter().enumerate() {
            let (asked, wanted) = match row {
                0 | 1 => {
                    reference[row] = tangential(row);
                    input[row] = tangential(row);
                    (input[row], reference[row])
                }
                2 => (virtual_input, set_point),
                _ => (0.0, 0.0),
            };
            rows.b()[k] = asked;
            rows.error()[k] = contact.measured[row] - wanted;
        }
        self.report = Some(ForceReport {
            contact: id,
            reference,
            virtual_input: input,
            clamped: self.feedback_loop.clamped(),
        });
    }

    fn activate(&mut self) {
        self.feedback_loop = Loop::default();
        self.ramp = Ramp::default();
        self.report = None;
    }

    fn follow(&mut self) -> Option<ReferenceSlot<'_>> {
        Some(ReferenceSlot {
            reference: &mut self.reference,
            sample: &self.sample,
            space: Space::Vector(1),
        })
    }

    fn pushes(&self) -> Option<ContactId> {
        self.bound.map(|(contact, _)| contact)
    }

    fn force_report(&self) -> Option<ForceReport> {
        self.report
    }
}
