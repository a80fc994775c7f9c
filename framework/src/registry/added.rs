//! Plug-ins that no linker brought in: added while the program runs, by what another language has.

use std::sync::PoisonError;

use schemars::Schema;

use super::{Load, Plugin, PluginKind, schema::Node};

/// A plug-in to be [added](add).
pub struct NewPlugin<P: ?Sized + 'static> {
    /// What `type` shall be.
    pub tag: String,
    /// Where it comes from: file and line, for messages.
    pub origin: String,
    /// What defines it, such as a class's qualified name, if it may be defined anew: it takes the place of an earlier
    /// one with the same tag and definition, for controllers that are made afterwards. Without it, and in place of one
    /// that has none or another, it is refused.
    pub definition: Option<String>,
    /// The JSON Schema of its own keys: an object with `properties`, `required` and `additionalProperties = false`.
    pub schema: Schema,
    /// Makes it from its own keys.
    pub load: Box<Load<P>>,
}

impl<P: ?Sized> std::fmt::Debug for NewPlugin<P> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let mut out = f.debug_struct("NewPlugin");
        out.field("tag", &self.tag).field("origin", &self.origin);
        out.finish_non_exhaustive()
    }
}

/// Why a plug-in cannot be added.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum AddError {
    /// The tag is taken.
    #[error("{kind} type `{tag}` is there already, from {origin}; give it another name")]
    Taken {
        /// The kind, as [`PluginKind::NAME`].
        kind: &'static str,
        /// The tag.
        tag: String,
        /// Where the other one was registered.
        origin: &'static str,
    },
    /// The tag is empty or has other characters than letters, digits, `_`, `-` and `.`.
    #[error("`{tag}` is no name of a {kind}: it must be made of letters, digits, `_`, `-` and `.`")]
    Tag {
        /// The kind, as [`PluginKind::NAME`].
        kind: &'static str,
        /// The tag.
        tag: String,
    },
    /// A key belongs to the framework.
    #[error(
        "{kind} type `{tag}` has the key `{key}`, which belongs to the framework; call it something else"
    )]
    Reserved {
        /// The kind, as [`PluginKind::NAME`].
        kind: &'static str,
        /// The tag.
        tag: String,
        /// The key.
        key: String,
    },
}

/// Adds a plug-in, from now on as if it were linked. Its memory is never freed, also if another takes its place:
/// controllers that were made from it keep it.
///
/// ```
/// use wbqp::{plugin::AnyReference, registry::{self, NewPlugin}, schemars::json_schema};
///
/// // Another name for a reference that is there.
/// # use wbqp::prelude::*;
/// # #[wbqp::reference("example.added.rest")]
/// # struct Rest {}
/// # impl Reference for Rest {
/// #     type Running = ();
/// #     fn bind(&self, _: Space) -> Result<(), BindError> { Ok(()) }
/// #     fn start(&self, (): &mut (), _: f64, _: &Sample) {}
/// #     fn sample(&self, (): &mut (), _: &Tick<'_>, _: &mut Sample) {}
/// # }
/// let new = || NewPlugin::<dyn AnyReference> {
///     tag: "example.added.pause".to_owned(),
///     origin: "this example".to_owned(),
///     definition: None,
///     schema: json_schema!({ "type": "object", "properties": {}, "additionalProperties": false }),
///     load: Box::new(|_| Ok(Box::new(Rest {}))),
/// };
/// registry::add(new())?;
/// assert!(registry::find::<dyn AnyReference>("example.added.pause").is_some());
/// assert!(registry::add(new()).is_err());
///
/// // What says where it is defined may be defined anew.
/// let named = |tag: &str| NewPlugin {
///     tag: tag.to_owned(),
///     definition: Some("notebook.Breath".to_owned()),
///     ..new()
/// };
/// registry::add(named("example.added.breath"))?;
/// registry::add(named("example.added.breath"))?;
/// assert!(registry::add(named("example.added.pause")).is_err());
/// # Ok::<(), registry::AddError>(())
/// ```
///
/// # Errors
/// [`AddError`].
pub fn add<P: PluginKind + ?Sized>(new: NewPlugin<P>) -> Result<(), AddError> {
    let NewPlugin {
        tag,
        origin,
        definition,
        schema,
        load,
    } = new;
    let kind = P::NAME;
    let plain = |c: char| c.is_ascii_alphanumeric() || "._-".contains(c);
    if tag.is_empty() || !tag.chars().all(plain) {
        return Err(AddError::Tag { kind, tag });
    }
    let reserved: &[&str] = match kind {
        "task" | "constraint" => &crate::plugin::ENTRY_KEYS,
        _ => &[],
    };
    for key in Node::root(schema.as_value()).property_names() {
        if key == "type" || reserved.contains(&key) {
            let key = key.to_owned();
            return Err(AddError::Reserved { kind, tag, key });
        }
    }
    // Whoever asks first makes the list.
    P::plugins();
    let mut place = P::shelf().0.write().unwrap_or_else(PoisonError::into_inner);
    let all = place.unwrap_or_default();
    let found = all.binary_search_by(|plugin| plugin.tag.cmp(&tag));
    let earlier = found.ok().and_then(|at| all.get(at).copied());
    if let Some(earlier) = earlier {
        let same = earlier.definition.is_some() && earlier.definition == definition.as_deref();
        if !same {
            let origin = earlier.origin;
            return Err(AddError::Taken { kind, tag, origin });
        }
    }
    let plugin: &'static Plugin<P> = Box::leak(Box::new(Plugin {
        tag: earlier.map_or_else(|| &*tag.leak(), |earlier| earlier.tag),
        origin: origin.leak(),
        definition: definition.map(|definition| &*definition.leak()),
        schema: Box::leak(Box::new(move || schema.clone())),
        load: Box::leak(load),
    }));
    let mut changed = all.to_vec();
    match found {
        Ok(at) => changed[at] = plugin,
        Err(at) => changed.insert(at, plugin),
    }
    *place = Some(changed.leak());
    Ok(())
}
