//! What the kit does alike with tasks and constraints.

use toml::{Spanned, Table, Value, de::DeValue};

use crate::{
    error::BindError,
    plugin::{Constraint, ConstraintRows, Layout, Rows, Setup, Task, Tick, rows::RowStore},
    registry::{self, PluginKind},
};

/// A task or a constraint.
pub(super) trait Subject: PluginKind {
    const IS_TASK: bool;

    fn bind(&mut self, setup: &mut Setup<'_>) -> Result<Layout, BindError>;
    fn update(&mut self, tick: &Tick<'_>, layout: &Layout, store: &mut RowStore);
    /// The plug-in with its `type`.
    fn save(&self) -> Result<Table, String>;
    fn to_json(&self) -> Result<String, String>;
    fn from_json(text: &str) -> Result<Box<Self>, String>;
}

macro_rules! subject {
    ($kind:ident, $rows:ident, $is_task:literal) => {
        impl Subject for dyn $kind {
            const IS_TASK: bool = $is_task;

            fn bind(&mut self, setup: &mut Setup<'_>) -> Result<Layout, BindError> {
                $kind::bind(self, setup)
            }

            fn update(&mut self, tick: &Tick<'_>, layout: &Layout, store: &mut RowStore) {
                $kind::update(self, tick, &mut $rows::new(layout, store));
            }

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

subject!(Task, Rows, true);
subject!(Constraint, ConstraintRows, false);

/// Makes a plug-in from a table with its `type`, as the loader of configurations does.
pub(super) fn load<P: Subject + ?Sized>(table: &Table) -> Result<Box<P>, String> {
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
