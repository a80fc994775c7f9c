//! Equal thrusts (r_a).

use wbqp::{
    error::BindError,
    plugin::{Layout, Rows, Setup, Task, Tick},
    schemars::JsonSchema,
    serde::{Deserialize, Serialize},
};

/// Balances the rotors' thrusts, the paper's r_a.
///
/// Sixth row of (11), one row less than there are rotors, N:
///
/// `f_i − f_{i+1} = 0` for neighbours in the order of the actuators.
///
/// That is `D f = 0` with 1 on the diagonal of D and −1 right above. The paper writes `D ω²`; here the rows are
/// in newtons, as its text says ("a function of the propeller forces"). Its weight of 1e-5 makes sense only so: in
/// (rad/s)² the term would drown the others.
///
/// The task is zero if and only if all thrusts are equal, but it punishes differences of neighbours alone: the
/// solution depends on the order of the rotors.
///
/// Error: `f_i − f_{i+1}` of the last solution, N.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(crate = "wbqp::serde", deny_unknown_fields)]
#[schemars(crate = "wbqp::schemars")]
pub struct PropellerRegularisation {
    #[serde(skip)]
    rotors: Vec<usize>,
}

impl PropellerRegularisation {
    /// For all rotors.
    pub fn new() -> Self {
        Self::default()
    }
}

#[wbqp::task("propeller_regularisation")]
impl Task for PropellerRegularisation {
    fn bind(&mut self, setup: &mut Setup<'_>) -> Result<Layout, BindError> {
        self.rotors = setup.rotors();
        if self.rotors.len() < 2 {
            return Err(BindError::Other(format!(
                "needs at least two rotors, `{}` has {}",
                setup.model().name(),
                self.rotors.len()
            )));
        }
        let name = |i: usize| setup.actuators()[i].name.as_str();
        let rows = self
            .rotors
            .windows(2)
            .map(|pair| (format!("{} - {}", name(pair[0]), name(pair[1])), "N"));
        Ok(Layout::rows(rows).error_unit("N").effort_dense())
    }

    fn update(&mut self, tick: &Tick<'_>, rows: &mut Rows<'_>) {
        let thrust = |i: usize| tick.last.effort.get(i).copied().unwrap_or(0.0);
        let mut effort = rows.effort();
        for (k, pair) in self.rotors.windows(2).enumerate() {
            effort[(k, pair[0])] = 1.0;
            effort[(k, pair[1])] = -1.0;
        }
        for (k, pair) in self.rotors.windows(2).enumerate() {
            rows.b()[k] = 0.0;
            rows.error()[k] = thrust(pair[0]) - thrust(pair[1]);
        }
    }
}
