//! The attributes that make a type a wbqp plug-in.
//!
//! `#[wbqp::task("posture")] struct Posture { … }` makes the struct the parameters of a task: it derives what files
//! and recordings need, and puts the type into wbqp's registry, where the loader of configurations finds it with its
//! JSON Schema and its origin. What the task does stands in `impl Task for Posture`.

mod implementation;
mod parameters;

use proc_macro::TokenStream;

/// Makes a struct the parameters of a task, registered under a tag: `#[wbqp::task("tag")]`.
///
/// The struct becomes `Clone + Debug + Serialize + Deserialize + JsonSchema`, refuses unknown keys, and can be named
/// by `type = "tag"`. Its doc comment, and those of its fields, are what the schema and the listings say. A field of
/// type `Option` may be left out. More is said of a field by
///
/// | | |
/// |---|---|
/// | `#[wbqp(default)]` | may be left out: the type's default |
/// | `#[wbqp(default = 40.0)]` | may be left out: this value, by `into()`; also in `default_field()` |
/// | `#[wbqp(unit = "1/s²")]` | its unit |
/// | `#[wbqp(critical = "kp")]` | may be left out of a file: critical damping for that stiffness, `2 √kp` |
///
/// and of the struct by `#[wbqp::task("tag", weight = 100.0)]`, the default weight of its entries.
#[proc_macro_attribute]
pub fn task(arguments: TokenStream, item: TokenStream) -> TokenStream {
    parameters::plugin("Task", arguments, item)
}

/// Makes a struct the parameters of a constraint, registered under a tag, as [`macro@task`] does.
#[proc_macro_attribute]
pub fn constraint(arguments: TokenStream, item: TokenStream) -> TokenStream {
    parameters::plugin("Constraint", arguments, item)
}

/// Makes a struct the parameters of a reference, registered under a tag, as [`macro@task`] does.
#[proc_macro_attribute]
pub fn reference(arguments: TokenStream, item: TokenStream) -> TokenStream {
    parameters::plugin("Reference", arguments, item)
}

/// Makes a struct the parameters of a fallback law, registered under a tag, as [`macro@task`] does.
#[proc_macro_attribute]
pub fn fallback_law(arguments: TokenStream, item: TokenStream) -> TokenStream {
    parameters::plugin("FallbackLaw", arguments, item)
}

/// Makes a struct or an enum a part of a plug-in's parameters: the same derives and field attributes as of
/// [`macro@task`], without a tag. Variants of an enum are written `in_snake_case`.
#[proc_macro_attribute]
pub fn parameters(arguments: TokenStream, item: TokenStream) -> TokenStream {
    parameters::part(&arguments, item)
}

/// Registers an `impl Robot for …` under the given tag.
#[proc_macro_attribute]
pub fn robot(tag: TokenStream, item: TokenStream) -> TokenStream {
    implementation::register("Robot", tag, item)
}

/// Registers an `impl Solver for …` under the given tag.
#[proc_macro_attribute]
pub fn solver(tag: TokenStream, item: TokenStream) -> TokenStream {
    implementation::register("Solver", tag, item)
}
