//! Thrusts near a value.

use wbqp::prelude::*;

use crate::{
    effort::{Efforts, chosen},
    follow::stay,
};

/// Keeps the thrusts of rotors near a value, by default near zero.
///
/// One row per rotor, N:
///
/// `f_i = f_d`.
///
/// In contrast to [`PropellerRegularisation`](crate::PropellerRegularisation) each thrust is weighed by itself, so the
/// solution does not depend on the order of the rotors; the minimum of `Σ f_i²` is the allocation of the
/// pseudo-inverse.
///
/// Error: thrust as sent last minus `f_d`, N.
#[wbqp::task("thrust_regularisation")]
pub struct ThrustRegularisation {
    /// Which rotors, by name; rows and reference are in this order. Default: all, in the order of the actuators.
    pub rotors: Option<Vec<String>>,
    /// The thrusts wanted: one per rotor, N. Default: zero.
    #[wbqp(default = stay(), unit = "N")]
    pub reference: Box<dyn AnyReference>,
}

impl ThrustRegularisation {
    /// All rotors, towards zero.
    pub fn new() -> Self {
        Self {
            rotors: None,
            reference: stay(),
        }
    }

    /// Towards other thrusts: one per rotor, N.
    pub fn following(mut self, reference: impl AnyReference) -> Self {
        self.reference = Box::new(reference);
        self
    }
}

impl Default for ThrustRegularisation {
    fn default() -> Self {
        Self::new()
    }
}

/// The rotors that a list names, as positions in `u`; all of them without a list.
pub(crate) fn chosen_rotors(
    setup: &Setup<'_>,
    rotors: Option<&[String]>,
) -> Result<Vec<ActuatorId>, BindError> {
    let all = setup.rotors();
    if all.is_empty() {
        return Err(BindError::Other(format!(
            "`{}` has no rotors",
            setup.model().name()
        )));
    }
    let name = |id: ActuatorId| setup.robot().actuators[id.index()].name.as_str();
    let known: Vec<&str> = all.iter().map(|&id| name(id)).collect();
    chosen(
        "rotors",
        rotors,
        || all.clone(),
        |wanted| {
            let found = all.iter().copied().find(|&id| name(id) == wanted);
            found.ok_or_else(|| BindError::Unknown {
                kind: "rotor",
                name: wanted.to_owned(),
                hint: String::new(),
                known: known.join(", "),
            })
        },
    )
}

impl Task for ThrustRegularisation {
    type Running = Efforts;

    fn bind(&self, setup: &mut Setup<'_>) -> Result<(Layout, Efforts), BindError> {
        let rotors = chosen_rotors(setup, self.rotors.as_deref())?;
        let name = |id: &ActuatorId| setup.robot().actuators[id.index()].name.as_str();
        let layout = Layout::rows(rotors.iter().map(|id| (name(id), "N")))
            .error_unit("N")
            .effort_unit(rotors.iter().copied());
        let efforts = Efforts::bind(setup, &*self.reference, rotors)?;
        Ok((layout, efforts))
    }

    fn update(&self, efforts: &mut Efforts, tick: &Tick<'_>, rows: &mut Rows<'_>) {
        efforts.update(tick, rows);
    }

    fn remembered(&self, _: &mut Self::Running, _: &mut Remembered<'_>) {}
}
