//! Where a task's set point comes from: an event, the case, or the controller's file.

use toml::{
    Spanned,
    de::{DeTable, DeValue},
};
use wbqp::robot::SourceFile;

use super::{
    Case,
    text::{Text, place},
};

impl Case {
    /// The event that a task's set point at a time comes from; if none does, what the case puts into the controller's
    /// file, or that file's own reference.
    pub(super) fn place_of_set_point(&self, text: &Text<'_>, task: &str, time: f64) -> String {
        let events = self.contents.events.iter();
        let before =
            events.filter(|(event, _)| event.at <= time && event.follow.contains_key(task));
        let last = before.max_by(|(a, _), (b, _)| a.at.total_cmp(&b.at));
        if let Some((_, span)) = last {
            return text.place(span.start);
        }
        let file = || self.file().to_owned();
        if self.sets_reference(task) {
            return text.place_of_case(self.name()).unwrap_or_else(file);
        }
        let source = self.controller_config().ok().and_then(|c| c.source);
        let own = source.and_then(|source| place_of_reference(&source, task));
        own.unwrap_or_else(file)
    }

    /// Whether the case, or its variation, replaces the reference that the controller's file has.
    fn sets_reference(&self, task: &str) -> bool {
        let set = toml::Value::try_from(self.overrides());
        set.is_ok_and(|set| {
            let task = set.get("task").and_then(|tasks| tasks.get(task));
            task.is_some_and(|task| task.get("reference").is_some())
        })
    }
}

/// The reference of a task in a controller's file, or the task if it has none.
fn place_of_reference(source: &SourceFile, task: &str) -> Option<String> {
    let root = DeTable::parse(&source.contents).ok()?;
    let DeValue::Array(tasks) = root.get_ref().get("task")?.get_ref() else {
        return None;
    };
    let text = |table: &DeTable<'_>, key| Some(table.get(key)?.get_ref().as_str()?.to_owned());
    // A task without a name is called by its type.
    let named = |entry: &&Spanned<DeValue<'_>>| {
        let keys = entry.get_ref().as_table();
        let name = keys.and_then(|keys| text(keys, "name").or_else(|| text(keys, "type")));
        name.as_deref() == Some(task)
    };
    let entry = tasks.iter().find(named)?;
    let reference = entry.get_ref().as_table()?.get_key_value("reference");
    let span = reference.map_or_else(|| entry.span(), |(key, _)| key.span());
    Some(place(&source.name, &source.contents, span.start))
}
