//! What can be wrong with a rigid-body tree.

/// Why a tree was refused. Messages name the element; the loader that read a file adds the file's name.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ModelError {
    /// Two elements of one kind share a name.
    #[error("{kind} `{name}` is defined twice; give each a name of its own")]
    Duplicate {
        /// `link`, `joint` or `frame`.
        kind: &'static str,
        /// The name.
        name: String,
    },
    /// A name refers to nothing.
    #[error("{by} refers to {kind} `{name}`, which does not exist")]
    Unknown {
        /// Who refers.
        by: String,
        /// `link`, `joint` or `frame`.
        kind: &'static str,
        /// The name.
        name: String,
    },
    /// Inertial parameters that no rigid body has.
    #[error("link `{body}`: inertia {what}")]
    Inertia {
        /// The link.
        body: String,
        /// What is wrong, with numbers.
        what: String,
    },
    /// A joint that cannot be used.
    #[error("joint `{joint}`: {what}")]
    Joint {
        /// The joint.
        joint: String,
        /// What is wrong.
        what: String,
    },
    /// The links and joints do not form one tree.
    #[error("{0}")]
    Topology(String),
}
