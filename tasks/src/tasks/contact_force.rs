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
    contact::{COMPONENTS, ContactKind},
    plugin::{ForceReport, VectorReference},
    prelude::*,
};

use crate::{Hold, check};

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
/// `x`, `y`, `normal` for `point`; `normal`, `moment x`, `moment y` for `normal_tilt`; `x`, `y`, `normal`, `moment x`,
/// `moment y`, `moment z` for `full`. Per-row weights of the entry are in this order. Feedback acts on the normal
/// alone; moments are asked to be zero.
///
/// # Switching
/// When the contact or the task comes on, the set point starts at the measured force and goes to `f^d` with the ramp,
/// and the integrator starts at zero. When the contact goes off with a ramp, the feedback stops and `f*` goes from the
/// solution at that moment to zero with the ramp. When the task alone goes off, its weight fades.
///
/// Exists while the contact is on. Error: `f^m − f^d`, N or N·m.
#[wbqp::task("contact_force")]
pub struct ContactForce {
    /// The contact, by name.
    pub contact: String,
    /// Set point `f^d` of the normal force: a reference with one component, N.
    #[wbqp(unit = "N")]
    pub reference: Box<dyn AnyReference>,
    /// Whether the measured force is fed back.
    #[wbqp(default)]
    pub feedback: Feedback,
    /// Proportional gain `K_P`, N/N, below 1: in a stiff contact the measured force follows `f*` within a period, and
    /// the loop would oscillate at 1.
    #[wbqp(default = 0.2, unit = "1")]
    pub kp: f64,
    /// Integral gain `K_I`, 1/s.
    #[wbqp(default = 1.5, unit = "1/s")]
    pub ki: f64,
    /// Back-calculation gain `k_aw`, 1/s. 0 leaves only the clamp against wind-up.
    #[wbqp(default = 0.5, unit = "1/s")]
    pub anti_windup: f64,
    /// Largest magnitude of the integrator's state ξ, N. The report says when it is reached.
    #[wbqp(default = 2.0, unit = "N")]
    pub clamp: f64,
    /// What is asked of the tangential forces, where the contact constrains them.
    #[wbqp(default)]
    pub tangential: Tangential,
}

/// Feedback of the measured normal force.
#[wbqp::parameters]
#[derive(Copy, Default, PartialEq, Eq)]
pub enum Feedback {
    /// None: `f* = f^d`.
    Off,
    /// Proportional and integral.
    #[default]
    Pi,
}

/// What is asked of tangential forces.
#[wbqp::parameters]
#[derive(Copy, Default, PartialEq, Eq)]
pub enum Tangential {
    /// Zero: as little friction as possible.
    #[default]
    Zero,
    /// What is measured: friction is taken as it is.
    Measured,
}

impl ContactForce {
    /// Pushes with a constant normal force in N, with feedback and the default gains.
    pub fn new(contact: impl Into<String>, force: f64) -> Self {
        Self {
            contact: contact.into(),
            reference: Box::new(Hold::at([force])),
            feedback: Feedback::default(),
            kp: Self::default_kp(),
            ki: Self::default_ki(),
            anti_windup: Self::default_anti_windup(),
            clamp: Self::default_clamp(),
            tangential: Tangential::default(),
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

/// What runs of a [`ContactForce`].
#[derive(Debug)]
pub struct RunningContactForce {
    contact: ContactId,
    kind: ContactKind,
    reference: VectorReference,
    feedback_loop: Loop,
    ramp: Ramp,
}

impl Task for ContactForce {
    type Running = RunningContactForce;

    fn bind(&self, setup: &mut Setup<'_>) -> Result<(Layout, RunningContactForce), BindError> {
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
        if self.anti_windup * setup.period() >= 1.0 {
            let most = 1.0 / setup.period();
            let problem = format!(
                "is {}, must be below the rate of {most} Hz",
                self.anti_windup
            );
            return Err(BindError::value("anti_windup", problem));
        }
        check::positive("clamp", self.clamp)?;
        let running = RunningContactForce {
            contact,
            kind,
            reference: setup.follow_normal_force("reference", &*self.reference, contact)?,
            feedback_loop: Loop::default(),
            ramp: Ramp::default(),
        };
        let rows = kind.constrained();
        let layout = Layout::rows(rows.iter().map(|&row| COMPONENTS[row]))
            .error_unit(if kind.has_moments() { "N or N·m" } else { "N" })
            .force_unit(contact, 0..rows.len())
            .while_contact(contact);
        Ok((layout, running))
    }

    fn update(&self, running: &mut RunningContactForce, tick: &Tick<'_>, rows: &mut Rows<'_>) {
        let contact = tick.contact(running.contact);
        let (measured, solution) = (contact.measured[2], contact.solution[2]);
        let settings = self.settings();
        let [target, ..] = tick.vector(running.reference).component(0);
        let now = Now {
            contact: contact.alpha,
            task: tick.alpha,
            target,
            measured,
            solution,
        };
        let (set_point, virtual_input) = match running.ramp.update(&now) {
            SetPoint::Follow(force) => {
                let feedback = &mut running.feedback_loop;
                let input = feedback.step(&settings, tick.elapsed, force, measured, solution);
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
        for (k, &row) in running.kind.constrained().iter().enumerate() {
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
        rows.report_force(ForceReport {
            contact: running.contact,
            reference,
            virtual_input: input,
            clamped: running.feedback_loop.clamped(),
        });
    }

    fn activate(&self, running: &mut RunningContactForce) {
        running.feedback_loop = Loop::default();
        running.ramp = Ramp::default();
    }

    fn remembered(&self, running: &mut Self::Running, numbers: &mut Remembered<'_>) {
        running.feedback_loop.remembered(numbers);
        running.ramp.remembered(numbers);
    }
}
