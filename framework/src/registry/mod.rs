//! Everything that can be named by `type = "…"` in a configuration: what the linker brought in, and what
//! was [added](add) while the program ran.
//!
//! A plug-in registers itself through its attribute; a crate that no code names is not linked, so a binary
//! writes `use my_plugins as _;`. Order of registration is not defined; lists are sorted by tag.
//!
//! ```
//! use wbqp::{prelude::*, registry};
//!
//! /// Grows with a constant rate.
//! #[wbqp::reference("example.drift")]
//! struct Drift {
//!     /// Rate of every component, unit of the value per second.
//!     rate: f64,
//! }
//!
//! impl Reference for Drift {
//!     type Running = ();
//!
//!     fn bind(&self, _: Space) -> Result<(), BindError> {
//!         Ok(())
//!     }
//!
//!     fn start(&self, (): &mut (), _: f64, _: &Sample) {}
//!
//!     fn sample(&self, (): &mut (), _: &Tick<'_>, out: &mut Sample) {
//!         match out {
//!             Sample::Vector(out) => out.rate.fill(self.rate),
//!             Sample::Rotation(out) => out.rate.fill(self.rate),
//!         }
//!     }
//! }
//!
//! let plugin = registry::find::<dyn AnyReference>("example.drift").expect("it is linked: it is here");
//! assert_eq!(plugin.tag, "example.drift");
//! assert!(registry::find::<dyn AnyReference>("example.drft").is_none());
//! ```
//!
//! The attribute takes the tag, and goes on a struct:
//!
//! ```compile_fail
//! # use wbqp::prelude::*;
//! #[wbqp::reference]
//! struct Drift {}
//! # impl Reference for Drift {
//! #     type Running = ();
//! #     fn bind(&self, _: Space) -> Result<(), BindError> { Ok(()) }
//! #     fn start(&self, (): &mut (), _: f64, _: &Sample) {}
//! #     fn sample(&self, (): &mut (), _: &Tick<'_>, _: &mut Sample) {}
//! # }
//! ```
//! ```compile_fail
//! # use wbqp::prelude::*;
//! #[wbqp::reference("example.drift")]
//! enum Drift { Up, Down }
//! # impl Reference for Drift {
//! #     type Running = ();
//! #     fn bind(&self, _: Space) -> Result<(), BindError> { Ok(()) }
//! #     fn start(&self, (): &mut (), _: f64, _: &Sample) {}
//! #     fn sample(&self, (): &mut (), _: &Tick<'_>, _: &mut Sample) {}
//! # }
//! ```

mod added;
mod listing;
pub(crate) mod schema;
mod tagged;

use std::{
    collections::BTreeMap,
    fmt,
    sync::{PoisonError, RwLock},
};

use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::de::DeserializeOwned;
use toml::de::ValueDeserializer;

use crate::{
    plugin::{AnyConstraint, AnyFallbackLaw, AnyReference, AnyTask},
    qp::Solver,
};
use wbqp_robot_model::Robot;

pub use added::add;
pub use listing::{Key, PluginInfo, list};

/// Makes a plug-in from its own keys.
pub type Load<P> = dyn Fn(ValueDeserializer<'_>) -> Result<Box<P>, toml::de::Error> + Sync;

/// A plug-in of one kind: registered by its attribute, or to be [added](add).
pub struct Plugin<P: ?Sized + 'static> {
    /// What `type` must be.
    pub tag: &'static str,
    /// Crate, file and line of the registration, for messages.
    pub origin: &'static str,
    /// What defines one that is [added](add), such as a class's qualified name, if it may be defined anew: it takes the
    /// place of an earlier one with the same tag and definition, for controllers that are made afterwards. Without it,
    /// and in place of one that has none or another, it is refused.
    pub definition: Option<&'static str>,
    /// Makes the JSON Schema of the plug-in's own keys, an object with `properties`, `required` and
    /// `additionalProperties = false`; [`Plugin::described`] does so once.
    pub schema: &'static (dyn Fn() -> Schema + Sync),
    /// Makes the plug-in from its own keys.
    pub load: &'static Load<P>,
}

impl<P: ?Sized> fmt::Debug for Plugin<P> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut out = f.debug_struct("Plugin");
        out.field("tag", &self.tag).field("origin", &self.origin);
        out.finish_non_exhaustive()
    }
}

impl<P: ?Sized + 'static> Plugin<P> {
    /// The JSON Schema of the plug-in's own keys, made when it is first asked for: a file may name a plug-in ten
    /// thousand times.
    pub fn described(&'static self) -> &'static Schema {
        // A plug-in is a constant, which can hold no memory of its own. Made once each, for as long as the program; one
        // that takes another's place has an address of its own, where all else may be the same.
        static MADE: RwLock<BTreeMap<usize, &Schema>> = RwLock::new(BTreeMap::new());
        let key = std::ptr::from_ref(self).addr();
        let made = MADE.read().unwrap_or_else(PoisonError::into_inner);
        if let Some(schema) = made.get(&key) {
            return schema;
        }
        drop(made);
        let schema = Box::leak(Box::new((self.schema)()));
        let mut made = MADE.write().unwrap_or_else(PoisonError::into_inner);
        made.entry(key).or_insert(schema)
    }
}

/// One of the kinds of plug-in: `dyn AnyTask`, `dyn AnyConstraint`, `dyn AnyReference`, `dyn Robot`,
/// `dyn Solver`, `dyn AnyFallbackLaw`.
pub trait PluginKind: 'static {
    /// What it is called in messages: `task`, `constraint`, `reference`, `robot`, `solver`, `fallback`.
    const NAME: &'static str;

    /// All plug-ins of the kind, sorted by tag: those that are linked, and those that were added since.
    fn plugins() -> &'static [&'static Plugin<Self>];

    /// Where they are listed; made when it is first asked for.
    #[doc(hidden)]
    fn shelf() -> &'static Shelf<Self>;
}

/// The plug-ins of a kind. A list that was handed out stays as it is; a longer one takes its place.
#[doc(hidden)]
pub struct Shelf<P: ?Sized + 'static>(RwLock<Option<&'static [&'static Plugin<P>]>>);

impl<P: ?Sized + 'static> Shelf<P> {
    const fn new() -> Self {
        Self(RwLock::new(None))
    }

    fn plugins(
        &self,
        linked: impl FnOnce() -> Vec<&'static Plugin<P>>,
    ) -> &'static [&'static Plugin<P>] {
        if let Some(all) = *self.0.read().unwrap_or_else(PoisonError::into_inner) {
            return all;
        }
        let mut all = linked();
        all.sort_by_key(|p| (p.tag, p.origin));
        let mut place = self.0.write().unwrap_or_else(PoisonError::into_inner);
        place.get_or_insert_with(|| all.leak())
    }
}

/// The plug-in of that tag, linked or added, if there is one; of several with the same tag the first by origin.
pub fn find<P: PluginKind + ?Sized>(tag: &str) -> Option<&'static Plugin<P>> {
    let all = P::plugins();
    let first = all.partition_point(|plugin| plugin.tag < tag);
    all.get(first).copied().filter(|plugin| plugin.tag == tag)
}

/// A tag that more than one linked plug-in of a kind claims: no configuration can name it.
#[doc(hidden)] // loading a configuration says so
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Duplicate {
    /// The kind, as [`PluginKind::NAME`].
    pub kind: &'static str,
    /// The tag.
    pub tag: &'static str,
    /// Crate, file and line of every registration, sorted.
    pub origins: Vec<&'static str>,
}

macro_rules! plugin_kinds {
    ($($wrapper:ident, $kind:ident, $list:ident, $what:literal;)*) => {
        $(
            #[doc = concat!("A registered ", $what, ": made by the attribute.")]
            #[doc(hidden)]
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
                        definition: None,
                        schema: &|| SchemaGenerator::default().into_root_schema_for::<T>(),
                        load: &|value| Ok(Box::new(T::deserialize(value)?)),
                    })
                }
            }

            inventory::collect!($wrapper);

            impl PluginKind for dyn $kind {
                const NAME: &'static str = $what;

                fn plugins() -> &'static [&'static Plugin<Self>] {
                    $list()
                }

                fn shelf() -> &'static Shelf<Self> {
                    static SHELF: Shelf<dyn $kind> = Shelf::new();
                    &SHELF
                }
            }

            #[doc = concat!("All ", $what, "s, sorted by tag: those that are linked, and those that were added since.")]
            pub fn $list() -> &'static [&'static Plugin<dyn $kind>] {
                <dyn $kind>::shelf().plugins(|| {
                    inventory::iter::<$wrapper>.into_iter().map(|p| &p.0).collect()
                })
            }
        )*

        /// Tags that are claimed more than once, over all kinds.
        pub fn duplicates() -> Vec<Duplicate> {
            let mut all = Vec::new();
            $(duplicates_of::<dyn $kind>(&mut all);)*
            all
        }
    };
}

plugin_kinds! {
    TaskPlugin, AnyTask, tasks, "task";
    ConstraintPlugin, AnyConstraint, constraints, "constraint";
    ReferencePlugin, AnyReference, references, "reference";
    RobotPlugin, Robot, robots, "robot";
    SolverPlugin, Solver, solvers, "solver";
    FallbackLawPlugin, AnyFallbackLaw, fallback_laws, "fallback";
}

fn duplicates_of<P: PluginKind + ?Sized>(all: &mut Vec<Duplicate>) {
    for same in P::plugins().chunk_by(|a, b| a.tag == b.tag) {
        if let [first, _, ..] = same {
            all.push(Duplicate {
                kind: P::NAME,
                tag: first.tag,
                origins: same.iter().map(|plugin| plugin.origin).collect(),
            });
        }
    }
}
