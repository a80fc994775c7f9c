//! How a solve ended.

use std::fmt;

/// How a solve ended. An outcome, never an error: every one of them happens on a robot.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "snake_case")
)]
#[non_exhaustive]
pub enum Status {
    /// Optimal within the solver's tolerances: the only one whose `x` may be sent to a robot.
    Optimal,
    /// No point satisfies all rows and bounds; `y` and `z` prove it (Farkas): `Aᵀ y + z = 0`, while the limits on their
    /// sides, weighted with them, have a negative sum. Where the limits of one row or variable are crossed, or a row
    /// without coefficients excludes zero, `y` or `z` is 1 or −1 there and zero elsewhere.
    Infeasible,
    /// The cost falls for ever along the ray in `x`: `H x = 0`, `gᵀ x < 0`, and no limit ends it. H and A are numbers
    /// of 16 digits, and so it is up to rounding: what has to vanish is below 1e-12 of the sum of its terms' sizes, or,
    /// in units in which the diagonal of H and the largest coefficient of every row are one, below 1e-15 of the largest
    /// component for each variable. Curvature beyond that, however little, gives a cost a minimum, however far away.
    Unbounded,
    /// The problem makes no sense: [`Solution::defect`](crate::Solution::defect) says where.
    Invalid,
    /// The cap on iterations ended the solve.
    IterationLimit,
    /// The time was used up.
    TimeLimit,
    /// Rounding does not let the solver come nearer, and what it has is not within the tolerances.
    Stalled,
    /// No solve has been made.
    #[default]
    Unsolved,
}

impl Status {
    /// Its name, for logs.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Optimal => "optimal",
            Self::Infeasible => "infeasible",
            Self::Unbounded => "unbounded",
            Self::Invalid => "invalid",
            Self::IterationLimit => "iteration_limit",
            Self::TimeLimit => "time_limit",
            Self::Stalled => "stalled",
            Self::Unsolved => "unsolved",
        }
    }

    /// Whether a limit on iterations or time ended the solve.
    pub fn was_cut_short(self) -> bool {
        matches!(self, Self::IterationLimit | Self::TimeLimit)
    }
}

/// The first entry that makes a problem meaningless. Positions, not identities.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Defect {
    /// `H[row, column]` is not finite.
    Hessian {
        /// Row of H.
        row: usize,
        /// Column of H.
        column: usize,
    },
    /// `H[row, column]` and `H[column, row]` differ by more than rounding.
    Asymmetric {
        /// Row of H.
        row: usize,
        /// Column of H.
        column: usize,
    },
    /// H has a negative eigenvalue: its factorisation has a negative pivot at this variable, or a diagonal entry of
    /// zero beside entries that are not.
    Indefinite {
        /// The variable.
        variable: usize,
    },
    /// `g` of this variable is not finite.
    Gradient {
        /// The variable.
        variable: usize,
    },
    /// `A[row, variable]` is not finite.
    Coefficient {
        /// The row.
        row: usize,
        /// The variable.
        variable: usize,
    },
    /// A limit of this row is NaN, or infinite on the side where nothing is allowed.
    RowLimit {
        /// The row.
        row: usize,
    },
    /// The same of the bounds of this variable.
    Bound {
        /// The variable.
        variable: usize,
    },
}

impl fmt::Display for Defect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Hessian { row, column } => write!(f, "H[{row}, {column}] is not finite"),
            Self::Asymmetric { row, column } => {
                write!(f, "H[{row}, {column}] and H[{column}, {row}] differ")
            }
            Self::Indefinite { variable } => {
                write!(
                    f,
                    "H is indefinite, as its factorisation shows at variable {variable}"
                )
            }
            Self::Gradient { variable } => write!(f, "g[{variable}] is not finite"),
            Self::Coefficient { row, variable } => {
                write!(f, "A[{row}, {variable}] is not finite")
            }
            Self::RowLimit { row } => write!(f, "the limits of row {row} are no interval"),
            Self::Bound { variable } => {
                write!(f, "the bounds of variable {variable} are no interval")
            }
        }
    }
}
