//! Everything that can be named by `type = "…"` in a configuration: what the linker brought in.
//!
//! A plug-in registers itself through its attribute; a crate that no code names is not linked, so a binary
//! writes `use my_plugins as _;`. Order of registration is not defined; lists are sorted by tag.

use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::de::DeserializeOwned;
use toml::de::ValueDeserializer;

use crate::{constraint::Constraint, qp::QpSolver, reference::Reference, robot::Robot, task::Task};

/// A registered plug-in of one kind.
#[derive(Debug)]
pub struct Plugin<P: ?Sized + 'static> {
    /// What `type` must be.
    pub tag: &'static str,
    /// Crate, file and line of the registration.
    pub origin: &'static str,
    /// JSON Schema of the plug-in's own keys.
    pub schema: fn() -> Schema,
    /// Makes the plug-in from its own keys.
    pub load: fn(ValueDeserializer<'_>) -> Result<Box<P>, toml::de::Error>,
}

macro_rules! plugin_kinds {
    ($($wrapper:ident, $kind:ident, $list:ident, $what:literal;)*) => {$(
        #[doc = concat!("A registered ", $what, ".")]
        #[derive(Debug)]
        pub struct $wrapper(pub Plugin<dyn $kind>);

        impl $wrapper {
            /// The entry that the attribute submits.
            pub const fn of<T>(tag: &'static str, origin: &'static str) -> Self
            where
                T: $kind + DeserializeOwned + JsonSchema,
            {
                Self(Plugin {
                    tag,
                    origin,
                    schema: || {
                        SchemaGenerator::default().into_root_schema_for::<T>()
                    },
                    load: |value| Ok(Box::new(T::deserialize(value)?)),
                })
            }
        }

        inventory::collect!($wrapper);

        #[doc = concat!("All linked ", $what, "s, sorted by tag.")]
        pub fn $list() -> Vec<&'static Plugin<dyn $kind>> {
            let mut all: Vec<_> = inventory::iter::<$wrapper>.into_iter().map(|p| &p.0).collect();
            all.sort_by_key(|p| (p.tag, p.origin));
            all
        }
    )*};
}

plugin_kinds! {
    TaskPlugin, Task, tasks, "task";
    ConstraintPlugin, Constraint, constraints, "constraint";
    ReferencePlugin, Reference, references, "reference";
    RobotPlugin, Robot, robots, "robot";
    QpSolverPlugin, QpSolver, solvers, "solver";
}
