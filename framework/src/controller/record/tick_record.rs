//! One tick in numbers: what it depended on and what came out.

use serde::{Deserialize, Serialize};

use crate::{
    controller::FallbackLevel,
    qp::{Status, WarmStart},
};

/// One tick: its inputs, what the controller remembered before it, the rows that plug-ins wrote, and its outcome.
/// SI units, frames as in the types that each part comes from.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Record {
    /// The measurement's time stamp, s.
    pub(crate) time: f64,
    pub(crate) measured: StateRecord,
    /// Numbers of joint positions, velocities and wrenches that the measurement had.
    pub(crate) sizes: [usize; 3],
    /// Per contact, `[force; moment]` in the axes of E, N and N·m.
    pub(crate) wrenches: Vec<[f64; 6]>,
    pub(crate) before: Memory,
    /// One per entry: tasks, then constraints.
    pub(crate) entries: Vec<EntryRecord>,
    /// Whether the plug-ins got as far as writing rows.
    pub(crate) written: bool,
    pub(crate) outcome: Outcome,
}

impl Record {
    /// [`Dump::outcome`](super::Dump::outcome).
    pub(super) fn outcome(&self) -> Vec<(String, String)> {
        let Outcome {
            level,
            status,
            iterations,
            command,
            ..
        } = &self.outcome;
        let mut list = vec![
            ("level".to_owned(), level.as_str().to_owned()),
            ("status".to_owned(), status.as_str().to_owned()),
            ("iterations".to_owned(), iterations.to_string()),
        ];
        let x = &self.outcome.x[..self.outcome.n.min(self.outcome.x.len())];
        for (name, numbers) in [
            ("x", x),
            ("effort", &command.effort),
            ("rotor_speed", &command.rotor_speed),
            ("joint_acceleration", &command.joint_acceleration),
            ("joint_velocity", &command.joint_velocity),
        ] {
            let named =
                |(i, number): (usize, &f64)| (format!("{name}[{i}]"), format!("{number:?}"));
            list.extend(numbers.iter().enumerate().map(named));
        }
        list
    }
}

/// A [`State`](wbqp_dynamics::state::State).
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct StateRecord {
    pub(crate) position: [f64; 3],
    /// w, x, y, z.
    pub(crate) orientation: [f64; 4],
    pub(crate) q: Vec<f64>,
    pub(crate) v: Vec<f64>,
}

/// What the controller remembers from one tick to the next.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Memory {
    /// Since the first tick, s.
    pub(crate) time: f64,
    pub(crate) origin: Option<f64>,
    /// Whether the first tick was behind; it was in all records that do not say so.
    #[serde(default = "yes")]
    pub(crate) has_begun: bool,
    /// The last usable state.
    pub(crate) state: StateRecord,
    pub(crate) contacts: Vec<ContactMemory>,
    /// The unknown wrench on the base; zero in older records.
    #[serde(default)]
    pub(crate) disturbance: [f64; 6],
    /// Whether the wrenches of the last measurement were not usable, for the observer; they were in records without it.
    #[serde(default)]
    pub(crate) is_blind: bool,
    pub(crate) asked: Vec<f64>,
    pub(crate) vdot: Vec<f64>,
    pub(crate) sent: Vec<f64>,
    pub(crate) command: CommandRecord,
    #[serde(alias = "rung")]
    pub(crate) level: FallbackLevel,
    #[serde(alias = "on_rung_since")]
    pub(crate) on_level_since: f64,
    #[serde(alias = "on_rung_ticks")]
    pub(crate) on_level_ticks: u64,
    /// Time stamp and ticks since the last solution; nothing if there was none.
    pub(crate) solved: Option<(f64, u64)>,
    /// The same for the last usable state.
    pub(crate) measured: Option<(f64, u64)>,
    /// The stamp of the tick before, and for how many ticks stamps have gone on regularly from an earlier time.
    pub(crate) stamp: Option<f64>,
    pub(crate) steady: u32,
    /// When the robot was seen last, and for how long it was not since the last usable state, s.
    #[serde(default)]
    pub(crate) seen: Option<f64>,
    #[serde(default)]
    pub(crate) unseen: f64,
    /// What the fallback law remembers.
    pub(crate) held: Vec<f64>,
    pub(crate) warm: WarmStart,
    pub(crate) relaxed_warm: WarmStart,
    /// The limits that contradicted one another last, but for one; how many ticks ago; which levels had to be given up.
    #[serde(default)]
    pub(crate) proof: WarmStart,
    #[serde(default)]
    pub(crate) since_proof: u32,
    #[serde(default)]
    pub(crate) needed: Vec<bool>,
}

fn yes() -> bool {
    true
}

/// A contact's switch, filter and last forces, and its surface.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ContactMemory {
    pub(crate) switch: crate::switch::Switch,
    pub(crate) exit_force: f64,
    pub(crate) exit_alpha: f64,
    pub(crate) filtered: [f64; 3],
    /// Of the force-torque sensor; not in older records.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) mean_reading: Option<[f64; 6]>,
    #[serde(default)]
    pub(crate) sensor_zero: [f64; 6],
    /// `R_WC`, column by column.
    pub(crate) rotation: [f64; 9],
    /// The same and `p_WS` of the last tick, whose forces are in these axes; not in older records.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) last_placed: Option<([f64; 9], [f64; 3])>,
    /// Position, velocity, angular velocity, acceleration, angular acceleration of the surface.
    pub(crate) motion: [[f64; 3]; 5],
    pub(crate) measured: [f64; 6],
    pub(crate) measured_at_switch: [f64; 6],
    pub(crate) set_point: [f64; 3],
    pub(crate) solution: [f64; 6],
}

/// A [`Command`](crate::controller::Command).
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct CommandRecord {
    pub(crate) effort: Vec<f64>,
    pub(crate) rotor_speed: Vec<f64>,
    pub(crate) joint_acceleration: Vec<f64>,
    pub(crate) joint_velocity: Vec<f64>,
}

/// What an entry wrote.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct EntryRecord {
    pub(crate) name: String,
    pub(crate) live: bool,
    pub(crate) alpha: f64,
    pub(crate) weight: Vec<f64>,
    /// Row-major; empty where the block is not dense.
    pub(crate) vdot: Vec<f64>,
    pub(crate) effort: Vec<f64>,
    pub(crate) forces: Vec<Vec<f64>>,
    pub(crate) lower: Vec<f64>,
    pub(crate) upper: Vec<f64>,
    pub(crate) bound_lower: Vec<f64>,
    pub(crate) bound_upper: Vec<f64>,
    pub(crate) error: Vec<f64>,
}

/// What came out.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Outcome {
    #[serde(alias = "rung")]
    pub(crate) level: FallbackLevel,
    pub(crate) status: Status,
    /// Iterations of all solves of the tick.
    pub(crate) iterations: u32,
    /// Iterations of the tick's own problem: where a budget stopped it, if one did.
    pub(crate) solved_in: u32,
    pub(crate) command: CommandRecord,
    /// Valid variables of the solution; none if no problem was solved.
    pub(crate) n: usize,
    pub(crate) x: Vec<f64>,
}
