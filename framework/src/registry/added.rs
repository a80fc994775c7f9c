//! Plug-ins that no linker brought in: added while the program runs, by what another language has.

use std::sync::PoisonError;

use super::{Plugin, PluginKind, schema::Node};
use crate::error::BindError;

/// Adds a plug-in, from now on as if it were linked. It is never freed, also if another takes its place: controllers
/// that were made from it keep it. What of it is made while the program runs is leaked (`Box::leak`).
///
/// ```
/// use wbqp::{plugin::AnyReference, registry::{self, Plugin}, schemars::json_schema};
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
/// let new = || Plugin::<dyn AnyReference> {
///     tag: "example.added.pause",
///     origin: "this example",
///     definition: None,
///     schema: &|| json_schema!({ "type": "object", "properties": {}, "additionalProperties": false }),
///     load: &|_| Ok(Box::new(Rest {})),
/// };
/// registry::add(new())?;
/// assert!(registry::find::<dyn AnyReference>("example.added.pause").is_some());
/// assert!(registry::add(new()).is_err());
///
/// // What says where it is defined may be defined anew.
/// let named = |tag| Plugin { tag, definition: Some("notebook.Breath"), ..new() };
/// registry::add(named("example.added.breath"))?;
/// registry::add(named("example.added.breath"))?;
/// assert!(registry::add(named("example.added.pause")).is_err());
/// # Ok::<(), wbqp::error::BindError>(())
/// ```
///
/// # Errors
/// [`BindError::Other`]: the tag is taken, and not by the same [definition](Plugin::definition); it is empty or has
/// other characters than letters, digits, `_`, `-` and `.`; or a key of the schema belongs to the framework.
pub fn add<P: PluginKind + ?Sized>(plugin: Plugin<P>) -> Result<(), BindError> {
    let (kind, tag) = (P::NAME, plugin.tag);
    let refuse = |problem: String| Err(BindError::Other(problem));
    let plain = |c: char| c.is_ascii_alphanumeric() || "._-".contains(c);
    if tag.is_empty() || !tag.chars().all(plain) {
        return refuse(format!(
            "`{tag}` is no name of a {kind}: it must be made of letters, digits, `_`, `-` and `.`"
        ));
    }
    let reserved: &[&str] = match kind {
        "task" | "constraint" => &crate::plugin::ENTRY_KEYS,
        _ => &[],
    };
    let schema = (plugin.schema)();
    for key in Node::root(schema.as_value()).property_names() {
        if key == "type" || reserved.contains(&key) {
            return refuse(format!(
                "{kind} type `{tag}` has the key `{key}`, which belongs to the framework; call it something else"
            ));
        }
    }
    // Whoever asks first makes the list.
    P::plugins();
    let mut place = P::shelf().0.write().unwrap_or_else(PoisonError::into_inner);
    let all = place.unwrap_or_default();
    let found = all.binary_search_by(|plugin| plugin.tag.cmp(tag));
    let earlier = found.ok().and_then(|at| all.get(at));
    if let Some(earlier) = earlier
        && (earlier.definition.is_none() || earlier.definition != plugin.definition)
    {
        let origin = earlier.origin;
        return refuse(format!(
            "{kind} type `{tag}` is there already, from {origin}; give it another name"
        ));
    }
    let plugin: &'static Plugin<P> = Box::leak(Box::new(plugin));
    let mut changed = all.to_vec();
    match found {
        Ok(at) => changed[at] = plugin,
        Err(at) => changed.insert(at, plugin),
    }
    *place = Some(changed.leak());
    Ok(())
}
