//! Equal thrusts (r_a).

use wbqp::prelude::*;

/// Balances the rotors' thrusts, the paper's r_a.
///
/// Sixth row of (11), one row less than there are rotors, N:
///
/// `f_i − f_{i+1} = 0` for neighbours in the order of the actuators.
///
/// That is `D f = 0` with 1 on the diagonal of D and −1 right above. The paper writes `D ω²`; here the rows are
/// in newtons, as its text says ("a function of the propeller forces"). The paper's weight of 1e-5 makes sense only so:
/// in (rad/s)² the term would drown the others. It is no default: the entry gives its weight.
///
/// The task is zero if and only if all thrusts are equal, but it punishes differences of neighbours alone: the
/// solution depends on the order of the rotors.
///
/// Error: `f_i − f_{i+1}` as sent last, N.
#[wbqp::task("propeller_regularisation")]
#[derive(Default)]
pub struct PropellerRegularisation {}

impl PropellerRegularisation {
    /// For all rotors.
    pub fn new() -> Self {
        Self::default()
    }
}

impl Task for PropellerRegularisation {
    /// The rotors.
    type Running = Vec<ActuatorId>;

    fn bind(&self, setup: &mut Setup<'_>) -> Result<(Layout, Vec<ActuatorId>), BindError> {
        let rotors = setup.rotors();
        if rotors.len() < 2 {
            return Err(BindError::Other(format!(
                "needs at least two rotors, `{}` has {}",
                setup.model().name(),
                rotors.len()
            )));
        }
        let name = |id: ActuatorId| setup.robot().actuators[id.index()].name.as_str();
        let rows = rotors
            .windows(2)
            .map(|pair| (format!("{} - {}", name(pair[0]), name(pair[1])), "N"));
        let layout = Layout::rows(rows).error_unit("N").effort_dense();
        Ok((layout, rotors))
    }

    fn update(&self, rotors: &mut Vec<ActuatorId>, tick: &Tick<'_>, rows: &mut Rows<'_>) {
        let thrust = |id: ActuatorId| tick.last_effort.get(id.index()).copied().unwrap_or(0.0);
        let mut effort = rows.effort();
        for (k, pair) in rotors.windows(2).enumerate() {
            effort[(k, pair[0].index())] = 1.0;
            effort[(k, pair[1].index())] = -1.0;
        }
        for (k, pair) in rotors.windows(2).enumerate() {
            rows.b()[k] = 0.0;
            rows.error()[k] = thrust(pair[0]) - thrust(pair[1]);
        }
    }

    fn remembered(&self, _: &mut Self::Running, _: &mut Remembered<'_>) {}
}
