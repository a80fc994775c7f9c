//! What the kit does alike with tasks and constraints.

use toml::{Spanned, Table, Value, de::DeValue};

use wbqp::{
    plugin::{AnyConstraint, AnyPlugin, AnyTask},
    registry::{self, PluginKind},
};

/// A task or a constraint.
pub(crate) trait Subject: PluginKind + AnyPlugin {
    /// The plug-in with its `type`.
    fn save(&self) -> Result<Table, String>;
    fn to_json(&self) -> Result<String, String>;
    fn from_json(text: &str) -> Result<Box<Self>, String>;
}

macro_rules! subject {
    ($kind:ident) => {
        impl Subject for dyn $kind {
            fn save(&self) -> Result<Table, String> {
                match Value::try_from(self) {
                    Ok(Value::Table(table)) => Ok(table),
                    Ok(other) => Err(format!("it is saved as {other}, not as a table")),
                    Err(error) => Err(error.to_string()),
                }
            }

            fn to_json(&self) -> Result<String, String> {
                serde_json::to_string(self).map_err(|error| error.to_string())
            }

            fn from_json(text: &str) -> Result<Box<Self>, String> {
                serde_json::from_str(text).map_err(|error| error.to_string())
            }
        }
    };
}

subject!(AnyTask);
subject!(AnyConstraint);

/// Makes a plug-in from a table with its `type`, as the loader of configurations does.
pub(crate) fn load<P: Subject + ?Sized>(table: &Table) -> Result<Box<P>, String> {
    let Some(Value::String(tag)) = table.get("type") else {
        return Err("key `type` is missing".into());
    };
    let plugin = registry::find::<P>(tag).ok_or_else(|| {
        let known: Vec<_> = P::plugins().iter().map(|plugin| plugin.tag).collect();
        format!(
            "no {} type `{tag}` is linked; linked are: {}",
            P::NAME,
            known.join(", ")
        )
    })?;
    let mut own = table.clone();
    own.remove("type");
    let text = own.to_string();
    let keys = toml::de::DeTable::parse(&text).map_err(|error| error.to_string())?;
    let value = Spanned::new(keys.span(), DeValue::Table(keys.into_inner()));
    (plugin.load)(value.into()).map_err(|error| error.message().to_owned())
}
