//! From the text of a file to a [`ControllerConfig`].

use std::{
    path::{Path, PathBuf},
    sync::OnceLock,
};

use schemars::SchemaGenerator;
use serde::Deserialize;
use serde_json::Value as Json;

use super::{
    ConfigError, ConfigErrorKind as Kind, ConfigErrors, ControllerConfig, Keeping,
    MeasurementLimits, Overrides, Settings, defaults,
    document::Document,
    entry,
    expand::{self, Reading, Texts},
    meaning, origin,
    overrides::OverrideText,
    report::{At, Report},
    table::{self, Section},
};
use crate::{
    contact::ContactSpec,
    controller::Dump,
    error::BindError,
    input,
    plugin::{AnyConstraint, AnyFallbackLaw, AnyTask, ENTRY_KEYS, Entry, Hardness},
    qp::Solver,
    registry::{self, PluginKind, schema::Node},
};
use wbqp_robot_model::{Robot, SourceFile, SourceLocation};

impl ControllerConfig {
    /// Reads a controller's file; relative paths in it count from its directory.
    ///
    /// # Errors
    /// All mistakes of the file, in its order.
    pub fn from_file(path: impl AsRef<Path>) -> Result<Self, ConfigErrors> {
        Self::from_file_with(path, &Overrides::default())
    }

    /// Reads a controller's file with some values replaced.
    ///
    /// # Errors
    /// All mistakes of the file and of the overrides, which are called by their names.
    pub fn from_file_with(
        path: impl AsRef<Path>,
        overrides: &Overrides,
    ) -> Result<Self, ConfigErrors> {
        let path = path.as_ref();
        let name = path.display().to_string();
        let source = input::read_text(path).map_err(|error| {
            ConfigErrors::new(vec![ConfigError {
                kind: Kind::Read,
                place: Some(SourceLocation::file(&name)),
                subject: String::new(),
                message: format!("cannot be read: {error}"),
            }])
        })?;
        let directory = path.parent().unwrap_or_else(|| Path::new(""));
        Self::from_str_with(&source, &name, directory, overrides)
    }

    /// Reads the text of a controller's file. `file_name` is what errors call it; relative paths count from
    /// `directory`.
    ///
    /// # Errors
    /// All mistakes of the text, in its order.
    pub fn from_str(
        source: &str,
        file_name: &str,
        directory: impl Into<PathBuf>,
    ) -> Result<Self, ConfigErrors> {
        Self::from_str_with(source, file_name, directory, &Overrides::default())
    }

    /// Reads the text of a controller's file with some values replaced.
    ///
    /// # Errors
    /// All mistakes of the text and of the overrides, which are called by their names.
    pub fn from_str_with(
        source: &str,
        file_name: &str,
        directory: impl Into<PathBuf>,
        overrides: &Overrides,
    ) -> Result<Self, ConfigErrors> {
        Self::read(
            source,
            Reading::File,
            file_name,
            directory.into(),
            overrides,
        )
    }

    /// The configuration of recorded ticks. Relative paths count from `directory` if it is given, else from where they
    /// counted when the ticks were recorded.
    ///
    /// # Errors
    /// All mistakes of its text: of plug-ins that the program does not link, for example.
    pub fn from_dump(dump: &Dump, directory: Option<&Path>) -> Result<Self, ConfigErrors> {
        // The controller may have been made in code without what a file has without saying it.
        Self::read(
            &dump.configuration,
            Reading::Record,
            "configuration",
            directory.unwrap_or(Path::new(&dump.directory)).to_owned(),
            &Overrides::default(),
        )
    }

    fn read(
        source: &str,
        reading: Reading,
        file_name: &str,
        directory: PathBuf,
        overrides: &Overrides,
    ) -> Result<Self, ConfigErrors> {
        if let Err(what) = input::check_toml(source) {
            return Err(ConfigErrors::new(vec![ConfigError {
                kind: Kind::Read,
                place: Some(SourceLocation::file(file_name)),
                subject: String::new(),
                message: what,
            }]));
        }
        let appendix = OverrideText::new(overrides, source.len());
        let mut report = Report::new(file_name, source, appendix.applied(overrides));
        for message in registry_faults() {
            let at = At::subject("internal error");
            report.add(Kind::Internal, None, &at, message);
        }
        let texts = Texts::default();
        let (document, _) =
            expand::read(source, reading, overrides, &appendix, &texts, &mut report);
        let warnings = meaning::check(&document, &mut report);
        let parts = Parts::read(document, &mut report);
        report.finish()?;
        match parts {
            Some(parts) => Ok(Self {
                settings: parts.settings,
                robot: parts.robot,
                solver: parts.solver,
                fallback: parts.fallback,
                measurement: parts.measurement,
                contacts: parts.contacts,
                tasks: parts.tasks,
                constraints: parts.constraints,
                directory,
                overrides: overrides.clone(),
                warnings,
                keeping: Keeping::default(),
                source: Some(SourceFile {
                    name: file_name.to_owned(),
                    contents: source.to_owned(),
                }),
            }),
            // Whatever is not there was reported; this is for a reader that forgot to.
            None => Err(ConfigErrors::new(vec![ConfigError {
                kind: Kind::Internal,
                place: Some(SourceLocation::file(file_name)),
                subject: String::new(),
                message: "internal error: something is wrong that has no message".to_owned(),
            }])),
        }
    }
}

/// Mistakes of the linked plug-ins themselves: the same in every load.
fn registry_faults() -> &'static [String] {
    static FAULTS: OnceLock<Vec<String>> = OnceLock::new();
    FAULTS.get_or_init(|| {
        let mut faults = Vec::new();
        for duplicate in registry::duplicates() {
            faults.push(format!(
                "{} type `{}` is registered more than once: {}",
                duplicate.kind,
                duplicate.tag,
                duplicate.origins.join(", ")
            ));
        }
        let mut entry = vec!["type"];
        entry.extend_from_slice(&ENTRY_KEYS);
        reserved_keys::<dyn AnyTask>(&entry, &mut faults);
        reserved_keys::<dyn AnyConstraint>(&entry, &mut faults);
        reserved_keys::<dyn crate::plugin::AnyReference>(&["type"], &mut faults);
        reserved_keys::<dyn Robot>(&["type"], &mut faults);
        reserved_keys::<dyn Solver>(&["type"], &mut faults);
        reserved_keys::<dyn AnyFallbackLaw>(&["type"], &mut faults);
        faults
    })
}

fn reserved_keys<P: PluginKind + ?Sized>(reserved: &[&str], faults: &mut Vec<String>) {
    for plugin in P::plugins() {
        let schema = plugin.described();
        for key in Node::root(schema.as_value()).property_names() {
            if reserved.contains(&key) {
                faults.push(format!(
                    "{} type `{}` ({}) has the key `{key}`, which belongs to the framework",
                    P::NAME,
                    plugin.tag,
                    plugin.origin
                ));
            }
        }
    }
}

/// Everything that is read; there if nothing is wrong.
struct Parts {
    settings: Settings,
    robot: Box<dyn Robot>,
    solver: Box<dyn Solver>,
    fallback: Box<dyn AnyFallbackLaw>,
    measurement: MeasurementLimits,
    contacts: Vec<ContactSpec>,
    tasks: Vec<Entry<dyn AnyTask>>,
    constraints: Vec<Entry<dyn AnyConstraint>>,
}

impl Parts {
    fn read(document: Document<'_>, report: &mut Report<'_>) -> Option<Self> {
        let settings = settings(document.controller, report);
        let robot = document
            .robot
            .and_then(|section| single::<dyn Robot>(section, report));
        let solver: Option<Box<dyn Solver>> = match document.solver {
            Some(section) => single::<dyn Solver>(section, report),
            None => Some(defaults::solver()),
        };
        let fallback: Option<Box<dyn AnyFallbackLaw>> = match document.fallback {
            Some(section) => single::<dyn AnyFallbackLaw>(section, report),
            None => Some(defaults::fallback()),
        };
        let measurement = match document.measurement {
            Some(section) => {
                let rate = settings.as_ref().map(|settings| settings.rate);
                measurement(section, rate, report)
            }
            None => Some(MeasurementLimits::default()),
        };
        let contacts = contacts(document.contacts, report);
        let mut names = entry::Names::default();
        let tasks = each(document.tasks, |index, section| {
            entry::read::<dyn AnyTask>(index, section, Hardness::Soft, &mut names, report)
        });
        let constraints = constraints(document.constraints, &mut names, report);
        Some(Self {
            settings: settings?,
            robot: robot?,
            solver: solver?,
            fallback: fallback?,
            measurement: measurement?,
            contacts: contacts?,
            tasks: tasks?,
            constraints: constraints?,
        })
    }
}

/// Reads all sections, also after one that cannot be.
fn each<'t, T>(
    sections: Vec<Section<'t>>,
    mut read: impl FnMut(usize, Section<'t>) -> Option<T>,
) -> Option<Vec<T>> {
    let read: Vec<_> = sections
        .into_iter()
        .enumerate()
        .map(|(index, section)| read(index, section))
        .collect();
    read.into_iter().collect()
}

fn schema_of<T: schemars::JsonSchema>() -> Json {
    SchemaGenerator::default()
        .into_root_schema_for::<T>()
        .to_value()
}

/// The same for every contact of every file.
fn contact_schema() -> &'static Json {
    static SCHEMA: OnceLock<Json> = OnceLock::new();
    SCHEMA.get_or_init(schema_of::<ContactSpec>)
}

fn settings_schema() -> &'static Json {
    static SCHEMA: OnceLock<Json> = OnceLock::new();
    SCHEMA.get_or_init(schema_of::<Settings>)
}

fn measurement_schema() -> &'static Json {
    static SCHEMA: OnceLock<Json> = OnceLock::new();
    SCHEMA.get_or_init(schema_of::<MeasurementLimits>)
}

fn settings(section: Option<Section<'_>>, report: &mut Report<'_>) -> Option<Settings> {
    let section = section?;
    let at = At::subject("controller");
    let keys = section.clone();
    let load = Settings::deserialize::<toml::de::ValueDeserializer<'_>>;
    let settings = table::read(section, settings_schema(), &[], load, &at, report)?;
    let mut valid = true;
    for (key, problem) in settings.problems() {
        origin::report(&BindError::value(key, problem), Some(&keys), &at, report);
        valid = false;
    }
    valid.then_some(settings)
}

fn measurement(
    section: Section<'_>,
    rate: Option<f64>,
    report: &mut Report<'_>,
) -> Option<MeasurementLimits> {
    let at = At::subject("measurement");
    let keys = section.clone();
    let load = MeasurementLimits::deserialize::<toml::de::ValueDeserializer<'_>>;
    let limits = table::read(section, measurement_schema(), &[], load, &at, report)?;
    let mut valid = true;
    for (key, problem) in limits.problems(rate) {
        origin::report(&BindError::value(key, problem), Some(&keys), &at, report);
        valid = false;
    }
    valid.then_some(limits)
}

/// `[robot]`, `[solver]` and `[fallback]`: a plug-in without an entry.
fn single<P: PluginKind + ?Sized>(section: Section<'_>, report: &mut Report<'_>) -> Option<Box<P>> {
    let at = At::subject(entry::subject(P::NAME, None, &section));
    table::plugin::<P>(section, &[], &at, report)
}

pub(super) fn contacts(
    sections: Vec<Section<'_>>,
    report: &mut Report<'_>,
) -> Option<Vec<ContactSpec>> {
    let mut names = entry::Names::default();
    each(sections, |index, section| {
        contact(index, section, &mut names, report)
    })
}

pub(super) fn constraints(
    sections: Vec<Section<'_>>,
    names: &mut entry::Names,
    report: &mut Report<'_>,
) -> Option<Vec<Entry<dyn AnyConstraint>>> {
    each(sections, |index, section| {
        entry::read::<dyn AnyConstraint>(index, section, Hardness::Hard, names, report)
    })
}

fn contact(
    index: usize,
    section: Section<'_>,
    names: &mut entry::Names,
    report: &mut Report<'_>,
) -> Option<ContactSpec> {
    let at = At::subject(entry::subject("contact", Some(index), &section));
    if let Some(name) = section.keys.get("name") {
        names.check("contact", name, expand::remedy(&section), &at, report);
    }
    let keys = section.clone();
    let load = ContactSpec::deserialize::<toml::de::ValueDeserializer<'_>>;
    let short = &expand::schema::SHORT_KEYS;
    let spec: ContactSpec = table::read(section, contact_schema(), short, load, &at, report)?;
    if let Err(error) = spec.validate() {
        origin::report(&error, Some(&keys), &at, report);
        return None;
    }
    Some(spec)
}
