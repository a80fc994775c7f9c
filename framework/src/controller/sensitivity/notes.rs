//! Where a tick's optimum is not differentiable.

use super::{
    super::Side,
    ParameterKind, Sensitivity,
    effect::{Effect, key},
};
use crate::qp::RowId;

/// Where the optimum of a tick is not differentiable, or not all of it is known: what [`Sensitivity::notes`] says.
///
/// * At a limit that is touched without a multiplier, or is active with none: [`Touching`](Self::Touching).
/// * Where what a plug-in writes has a kink, a clamp or a smallest of several: [`Kink`](Self::Kink).
/// * Where limits become active or cease to be: the derivatives hold up to there, and the next ones are others.
/// * Where a tick has no optimum, or its command is not the optimum: that is an error.
/// * In the largest weight, which the regularisation follows, where several entries have it:
///   [`LargestWeight`](Self::LargestWeight). The same holds for the rows of one entry, if their largest weight is that
///   of several: each has its share, and the sum of their columns is right.
/// * In time: ramps, switches of tasks and contacts, and hard rows that become hard at the end of their ramp. At
///   the moment of a tick their state is given, and the derivatives are those with this state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Note {
    /// A limit is touched and does not push: one way it stays behind, the other way it becomes active. The derivatives
    /// are those without it.
    Touching {
        /// Whose.
        row: RowId,
        /// Which side.
        side: Side,
    },
    /// What a row is made of has other slopes on the two sides of this parameter's value: a clamp, a smallest of
    /// several. The column is the mean of both.
    Kink {
        /// Position in [`Sensitivity::parameters`].
        parameter: usize,
    },
    /// The regularisation follows the largest weight, which several tasks or softened constraints have: the columns of
    /// their weights are right if all of them change by the same factor.
    LargestWeight {
        /// One of them: position among all entries, tasks, then constraints.
        entry: usize,
    },
    /// A task or constraint does not say what it remembers from tick to tick, and is not asked again: its rows count as
    /// constant, and it has no columns but those of its weights.
    Unknown {
        /// Position among all entries: tasks, then constraints.
        entry: usize,
    },
}

impl Sensitivity {
    /// Where the optimum is not differentiable: at a limit that is touched without a multiplier, at a kink of what a
    /// plug-in writes, in the largest weight if several have it; and which entries do not say what they remember, so
    /// that their rows count as constant. A sentence each. Allocates.
    pub fn notes(&self) -> Vec<String> {
        self.notes.iter().map(|note| self.say(note)).collect()
    }

    /// The notes that matter to who looks at some effects and at references: those about other weights and gains, and
    /// about kinks in what is measured, are left out. Allocates.
    pub fn notes_on(&self, effects: &[Effect]) -> Vec<String> {
        let has = |kind: ParameterKind, owner: &str, key: &str| {
            let mut effects = effects.iter();
            effects.any(|e| e.kind == kind && e.owner == owner && e.key == key)
        };
        let matters = |note: &&Note| match note {
            Note::LargestWeight { entry } => {
                let owner = self.entries.get(*entry);
                owner.is_some_and(|owner| has(ParameterKind::Weight, owner, "weight"))
            }
            Note::Kink { parameter } => {
                let parameter = self.parameters().get(*parameter);
                parameter.is_some_and(|p| {
                    p.kind == ParameterKind::Reference || has(p.kind, &p.owner, key(p))
                })
            }
            Note::Touching { .. } | Note::Unknown { .. } => true,
        };
        let matter = self.notes.iter().filter(matters);
        matter.map(|note| self.say(note)).collect()
    }

    fn say(&self, note: &Note) -> String {
        let name = |names: &[String], index: usize| names.get(index).cloned().unwrap_or_default();
        match note {
            Note::Touching { row, side } => format!(
                "`{}` touches its {} limit without a multiplier",
                name(&self.rows, row.index()),
                side.as_str()
            ),
            Note::Kink { parameter } => match self.parameters.get(*parameter) {
                Some(parameter) => format!("a kink at this value of `{parameter}`"),
                None => String::new(),
            },
            Note::LargestWeight { entry } => format!(
                "the regularisation follows the weight of `{}` and of others",
                name(&self.entries, *entry)
            ),
            Note::Unknown { entry } => format!(
                "`{}` does not say what it remembers: its rows count as constant",
                name(&self.entries, *entry)
            ),
        }
    }
}
