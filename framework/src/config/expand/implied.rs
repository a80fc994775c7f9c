//! What a file does not say: every value that stands in for it, and why.

use serde_json::Value as Json;

use super::{List, Notes, Reading, Texts, read, value};
use crate::{
    config::{
        ControllerConfig, defaults,
        document::Document,
        entry,
        json_schema::schema_of,
        overrides::OverrideText,
        report::{Report, Span},
        table::Section,
    },
    contact::ContactSpec,
    plugin::{AnyConstraint, AnyFallbackLaw, AnyReference, AnyTask},
    qp::Solver,
    registry::{self, PluginKind, schema::Node},
    settings::{MeasurementLimits, Settings},
};
use wbqp_robot_model::Robot;

impl ControllerConfig {
    /// Every value that the file, and the overrides, do not say: what short forms bring, and the defaults of all keys,
    /// also of plug-ins, in the order of the file's tables. A line each, `section: key = value (why)`, or
    /// `section: key: what happens without it`; lists are counted as they are written out. Empty for a configuration
    /// that was made in code.
    pub fn implied(&self) -> Vec<String> {
        let Some(source) = &self.source else {
            return Vec::new();
        };
        let text = &source.contents;
        let appendix = OverrideText::new(&self.overrides, text.len());
        let applied = appendix.applied(&self.overrides);
        let is_said = |span: &Span| applied.iter().any(|one| one.span.contains(&span.start));
        // The text was accepted before.
        let mut report = Report::new(&source.name, text, appendix.applied(&self.overrides));
        let texts = Texts::default();
        let (document, notes) = read(
            text,
            Reading::File,
            &self.overrides,
            &appendix,
            &texts,
            &mut report,
        );
        let mut lister = Lister {
            notes: &notes,
            is_said: &is_said,
            lines: Vec::new(),
        };
        lister.document(&document);
        lister.lines
    }
}

/// The framework's keys of an entry that have a default.
const ENTRY: [(&str, &str); 2] = [("active", "true"), ("transition", "0.0")];

struct Lister<'a> {
    notes: &'a Notes,
    is_said: &'a dyn Fn(&Span) -> bool,
    lines: Vec<String>,
}

impl Lister<'_> {
    fn document(&mut self, document: &Document<'_>) {
        if let Some(section) = &document.controller {
            self.defaults("controller", &schema_of::<Settings>(), section);
        }
        if let Some(section) = &document.robot {
            let subject = entry::subject("robot", None, section);
            self.noted(List::Robot, 0, &subject, section);
            self.plugin::<dyn Robot>(&subject, section);
        }
        self.optional::<dyn Solver>(document.solver.as_ref(), defaults::solver().typetag_name());
        self.optional::<dyn AnyFallbackLaw>(
            document.fallback.as_ref(),
            defaults::fallback().typetag_name(),
        );
        if let Some(section) = &document.measurement {
            self.defaults("measurement", &schema_of::<MeasurementLimits>(), section);
        }
        let contact = schema_of::<ContactSpec>();
        for (index, section) in document.contacts.iter().enumerate() {
            let subject = entry::subject("contact", Some(index), section);
            self.noted(List::Contact, index, &subject, section);
            self.defaults(&subject, &contact, section);
        }
        self.entries::<dyn AnyTask>(List::Task, &document.tasks, "\"soft\"");
        self.entries::<dyn AnyConstraint>(List::Constraint, &document.constraints, "\"hard\"");
    }

    /// A table of a plug-in that may be left out, and its type then.
    fn optional<P: PluginKind + ?Sized>(&mut self, section: Option<&Section<'_>>, tag: &str) {
        match section {
            Some(section) => {
                let subject = entry::subject(P::NAME, None, section);
                self.plugin::<P>(&subject, section);
            }
            None => self.add(P::NAME, "type", Some(format!("{tag:?}")), "default"),
        }
    }

    fn entries<P: PluginKind + ?Sized>(
        &mut self,
        list: List,
        sections: &[Section<'_>],
        hardness: &str,
    ) {
        for (index, section) in sections.iter().enumerate() {
            let subject = entry::subject(P::NAME, Some(index), section);
            self.noted(list, index, &subject, section);
            for (key, value) in ENTRY.into_iter().chain([("hardness", hardness)]) {
                if !section.keys.contains_key(key) {
                    self.add(&subject, key, Some(value.to_owned()), "default");
                }
            }
            self.plugin::<P>(&subject, section);
        }
    }

    fn add(&mut self, section: &str, key: &str, value: Option<String>, why: &str) {
        self.lines.push(match value {
            Some(value) => format!("{section}: {key} = {value} ({why})"),
            None => format!("{section}: {key}: {why}"),
        });
    }

    /// What short forms brought, unless an override said otherwise.
    fn noted(&mut self, list: List, index: usize, subject: &str, section: &Section<'_>) {
        for note in self.notes.of(list, index) {
            if let Some(value) = section.keys.get(note.key.as_str())
                && !(self.is_said)(&value.span())
            {
                let written = value::written(value.get_ref());
                self.add(subject, &note.key, Some(written), &note.why);
            }
        }
    }

    fn plugin<P: PluginKind + ?Sized>(&mut self, subject: &str, section: &Section<'_>) {
        let tag = value::string(section, "type").unwrap_or_default();
        if let Some(plugin) = registry::find::<P>(tag) {
            self.defaults(subject, plugin.described().as_value(), section);
        }
    }

    fn defaults(&mut self, subject: &str, schema: &Json, section: &Section<'_>) {
        self.table(subject, "", Node::root(schema), &section.keys);
    }

    fn table(&mut self, subject: &str, prefix: &str, node: Node<'_>, keys: &toml::de::DeTable<'_>) {
        for (key, about) in node.properties().into_iter().flatten() {
            let path = format!("{prefix}{key}");
            if let Some(value) = keys.get(key.as_str()) {
                if let Some(inner) = value.get_ref().as_table() {
                    let prefix = format!("{path}.");
                    let node = node.at(about);
                    match node.plugin() {
                        None => self.table(subject, &prefix, node, inner),
                        Some(_) => self.reference(subject, &prefix, inner),
                    }
                }
                continue;
            }
            let default = about.get("default").filter(|value| !value.is_null());
            if let Some(default) = default.and_then(|d| toml::Value::try_from(d).ok()) {
                self.add(subject, &path, Some(default.to_string()), "default");
            } else if let Some(words) = in_words(about) {
                self.add(subject, &path, None, &words);
            }
        }
    }

    /// A trajectory inside a task.
    fn reference(&mut self, subject: &str, prefix: &str, keys: &toml::de::DeTable<'_>) {
        let tag = keys.get("type").and_then(|tag| tag.get_ref().as_str());
        if let Some(plugin) = tag.and_then(registry::find::<dyn AnyReference>) {
            let schema = plugin.described();
            self.table(subject, prefix, Node::root(schema.as_value()), keys);
        }
    }
}

/// What a description says of a key that is absent: the rest of the sentence that begins with "Default" or "Without
/// it".
fn in_words(about: &Json) -> Option<String> {
    let description = about.get("description")?.as_str()?;
    let begin = ["Default", "Without it"]
        .into_iter()
        .find_map(|word| description.find(word))?;
    let sentence = description.get(begin..)?.split(". ").next()?;
    let words: Vec<&str> = sentence.split_whitespace().collect();
    Some(words.join(" ").trim_end_matches('.').to_owned())
}
