//! What a run says of itself beside its messages.

use std::{collections::BTreeMap, path::Path};

use wbqp_log::Timeline;

use crate::{MeasureError, RotorLimits};

/// Metadata and attachments of a run.
#[derive(Clone, Debug, Default)]
pub(crate) struct Header {
    pub(crate) metadata: BTreeMap<String, BTreeMap<String, String>>,
    pub(crate) attachments: BTreeMap<String, Vec<u8>>,
}

impl Header {
    pub(crate) fn timeline(&self) -> Timeline {
        let table = self.metadata.get(Timeline::NAME);
        table.map(Timeline::from_metadata).unwrap_or_default()
    }

    pub(crate) fn mark(&self, name: &str) -> Result<f64, MeasureError> {
        let timeline = self.timeline();
        timeline.get(name).ok_or_else(|| MeasureError::Mark {
            name: name.to_owned(),
            known: timeline.names().map(str::to_owned).collect(),
        })
    }

    pub(crate) fn rotors(&self) -> Result<Vec<RotorLimits>, MeasureError> {
        let lacks = |key: &str| MeasureError::Metadata {
            name: "rotors".to_owned(),
            key: key.to_owned(),
        };
        let table = self.metadata.get("rotors").ok_or_else(|| lacks("*.min"))?;
        let number = |key: String| {
            let text = table.get(&key).ok_or_else(|| lacks(&key))?;
            text.parse::<f64>().map_err(|_| lacks(&key))
        };
        let names = table.keys().filter_map(|k| k.strip_suffix(".min"));
        names
            .map(|name| {
                Ok(RotorLimits {
                    name: name.to_owned(),
                    thrust: [
                        number(format!("{name}.min"))?,
                        number(format!("{name}.max"))?,
                    ],
                    speed: [
                        number(format!("{name}.speed_min"))?,
                        number(format!("{name}.speed_max"))?,
                    ],
                    lag: [
                        number(format!("{name}.rise"))?,
                        number(format!("{name}.fall"))?,
                    ],
                })
            })
            .collect()
    }

    pub(crate) fn configuration(&self, key: &str) -> Result<toml::Table, MeasureError> {
        let found = self.attached_tables().find(|table| table.contains_key(key));
        found.ok_or_else(|| MeasureError::Attachment(key.to_owned()))
    }

    /// Names and contents of the attached TOML files.
    pub(crate) fn attached_texts(&self) -> impl Iterator<Item = (&str, &str)> {
        let toml = self.attachments.iter();
        let toml = toml.filter(|(name, _)| has_extension(name, "toml"));
        toml.filter_map(|(name, data)| Some((name.as_str(), std::str::from_utf8(data).ok()?)))
    }

    pub(crate) fn attached_tables(&self) -> impl Iterator<Item = toml::Table> {
        self.attached_texts()
            .filter_map(|(_, text)| text.parse::<toml::Table>().ok())
    }
}

fn has_extension(name: &str, extension: &str) -> bool {
    Path::new(name)
        .extension()
        .is_some_and(|e| e.eq_ignore_ascii_case(extension))
}
