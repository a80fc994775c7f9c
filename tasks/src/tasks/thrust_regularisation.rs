//! Thrusts near a value.

use wbqp::{
    error::BindError,
    plugin::{Layout, AnyReference, Rows, Setup, Space, Task, Tick, reference::ReferenceSlot},
    schemars::JsonSchema,
    serde::{Deserialize, Serialize},
};

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
/// Error: thrust of the last solution minus `f_d`, N.
#[derive(Debug, Serialize, Deserialize, JsonSchema)]
#[serde(crate = "wbqp::serde", deny_unknown_fields)]
#[schemars(crate = "wbqp::schemars")]
pub struct ThrustRegularisation {
    /// Which rotors, by name; rows and reference are in this order. Default: all, in the order of the actuators.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rotors: Option<Vec<String>>,
    /// The thrusts wanted: one per rotor, N. Default: zero.
    #[serde(default = "stay")]
    #[schemars(extend("x-unit" = "N"))]
    pub reference: Box<dyn AnyReference>,
    #[serde(skip)]
    efforts: Efforts,
}

impl ThrustRegularisation {
    /// All rotors, towards zero.
    pub fn new() -> Self {
        Self {
            rotors: None,
            reference: stay(),
            efforts: Efforts::default(),
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
) -> Result<Vec<usize>, BindError> {
    let all = setup.rotors();
    if all.is_empty() {
        return Err(BindError::Other(format!(
            "`{}` has no rotors",
            setup.model().name()
        )));
    }
    let name = |index: usize| setup.actuators()[index].name.as_str();
    let known: Vec<&str> = all.iter().map(|&index| name(index)).collect();
    chosen(
        "rotors",
        rotors,
        || all.clone(),
        |wanted| {
            let found = all.iter().copied().find(|&index| name(index) == wanted);
            found.ok_or_else(|| BindError::Unknown {
                kind: "rotor",
                name: wanted.to_owned(),
                hint: String::new(),
                known: known.join(", "),
            })
        },
    )
}

#[wbqp::task("thrust_regularisation")]
impl Task for ThrustRegularisation {
    fn bind(&mut self, setup: &mut Setup<'_>) -> Result<Layout, BindError> {
        let rotors = chosen_rotors(setup, self.rotors.as_deref())?;
        let names = rotors
            .iter()
            .map(|&index| (setup.actuators()[index].name.as_str(), "N"));
        let layout = Layout::rows(names)
            .error_unit("N")
            .effort_unit(rotors.iter().copied());
        self.efforts.bind(self.reference.as_mut(), rotors)?;
        Ok(layout)
    }

    fn update(&mut self, tick: &Tick<'_>, rows: &mut Rows<'_>) {
        self.efforts.update(self.reference.as_mut(), tick, rows);
    }

    fn follow(&mut self) -> Option<ReferenceSlot<'_>> {
        Some(ReferenceSlot {
            reference: &mut self.reference,
            sample: &self.efforts.sample,
            space: Space::Vector(self.efforts.indices.len()),
        })
    }
}
