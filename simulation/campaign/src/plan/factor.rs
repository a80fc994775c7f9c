//! A quantity that is varied, and how its value gets into a case.

use std::fmt::Write as _;

use toml::{Spanned, Table, Value};
use wbqp::suggestion::suggestion;
use wbqp_sim::{ScenarioError, scenario::Case};

use super::{
    check_name,
    distribution::Distribution,
    file::{FactorKeys, Paths},
};

/// A quantity that is varied.
#[derive(Clone, Debug)]
pub struct Factor {
    name: String,
    paths: Vec<Path>,
    relation: Relation,
    distribution: Distribution,
    /// Where it begins in the plan.
    start: usize,
}

/// What the factor's number is to the scenario's value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Relation {
    Value,
    Scale,
    Shift,
}

/// Where the value is: a key as in a case's `change` or `set`, and an entry of a list there.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Path {
    key: String,
    entry: Option<usize>,
}

impl Factor {
    pub(super) fn new(entry: &Spanned<FactorKeys>) -> Result<Self, String> {
        let keys = entry.get_ref();
        let name = &keys.name;
        check_name("factor", name)?;
        let refuse = |what: String| Err(format!("factor `{name}`: {what}"));
        let given = [
            (Relation::Value, &keys.value),
            (Relation::Scale, &keys.scale),
            (Relation::Shift, &keys.shift),
        ];
        let mut given = given
            .into_iter()
            .filter_map(|(relation, d)| Some((relation, d.as_ref()?)));
        let (Some((relation, distribution)), None) = (given.next(), given.next()) else {
            return refuse("wants one of `value`, `scale` and `shift`".to_owned());
        };
        if let Some(problem) = distribution.problem() {
            return refuse(problem);
        }
        let paths = match &keys.path {
            Paths::One(path) => std::slice::from_ref(path),
            Paths::Several(paths) => paths,
        };
        if paths.is_empty() {
            return refuse("has no path".to_owned());
        }
        let paths = paths.iter().map(|path| Path::new(path));
        Ok(Self {
            name: name.clone(),
            paths: paths
                .collect::<Result<_, _>>()
                .map_err(|what| format!("factor `{name}`: {what}"))?,
            relation,
            distribution: distribution.clone(),
            start: entry.span().start,
        })
    }

    /// Refuses a path that an earlier factor, or this one, has already, and one that writes over an entry of a list.
    pub(super) fn writes_apart_from(&self, others: &[Self]) -> Result<(), String> {
        for (index, path) in self.paths.iter().enumerate() {
            let own = self.paths.iter().take(index).map(|other| (self, other));
            let earlier = others
                .iter()
                .flat_map(|other| other.paths.iter().map(move |p| (other, p)));
            let twice = own.chain(earlier).find(|(_, other)| {
                let is_lost = path.entry.is_none() && self.relation == Relation::Value;
                other.key == path.key && (other.entry == path.entry || is_lost)
            });
            if let Some((other, _)) = twice {
                return Err(format!(
                    "factor `{}`: the path `{}` is taken by factor `{}`: a value is varied by one factor, once",
                    self.name,
                    path.text(),
                    other.name
                ));
            }
        }
        Ok(())
    }

    /// Its name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// What its number is: `value`, `scale` or `shift` of the scenario's own.
    pub fn relation(&self) -> &'static str {
        match self.relation {
            Relation::Value => "value",
            Relation::Scale => "scale",
            Relation::Shift => "shift",
        }
    }

    /// Where it begins in the plan.
    pub(crate) fn start(&self) -> usize {
        self.start
    }

    pub(crate) fn distribution(&self) -> &Distribution {
        &self.distribution
    }

    /// Whether it scales nothing but zeros in a case, and no other factor makes anything of them.
    pub(crate) fn scales_zeros_of(&self, nominal: &Nominal, others: &[&Self]) -> bool {
        let is_zero = |path: &Path| {
            let is_written = |other: &&Self| other.paths.iter().any(|p| p.key == path.key);
            if others.iter().any(is_written) {
                return false;
            }
            let Some(value) = nominal.value(&path.key) else {
                return false;
            };
            match (path.entry, &value) {
                (Some(entry), Value::Array(entries)) => entries.get(entry).is_some_and(is_zero),
                _ => is_zero(&value),
            }
        };
        self.relation == Relation::Scale && self.paths.iter().all(is_zero)
    }

    /// What is wrong with one that does, in words.
    pub(crate) fn scales_nothing(&self) -> String {
        let paths: Vec<String> = self.paths.iter().map(Path::text).collect();
        format!(
            "factor `{}`: `scale` of `{}`, which is 0 in the scenario, is always 0, and has no effect: give the \
             numbers themselves, as `value = {{ uniform = [lowest, highest] }}` in place of `scale`",
            self.name,
            paths.join("`, `")
        )
    }

    fn is_written_over(&self, nominal: &Nominal, path: &Path) -> Result<Value, String> {
        nominal.value(&path.key).ok_or_else(|| {
            let begin = format!(
                "factor `{}`: the scenario has no value at `{}` to {}",
                self.name,
                path.key,
                self.relation(),
            );
            match nominal.meant(&path.key) {
                Some(hint) => format!("{begin}: {hint}"),
                None => format!("{begin}; give the factor's `value`"),
            }
        })
    }

    /// Writes its number into a case's values.
    fn write(&self, number: f64, nominal: &Nominal, changed: &mut Changed) -> Result<(), String> {
        for path in &self.paths {
            let known = changed.values.iter().position(|(key, _)| *key == path.key);
            let current = match known {
                Some(index) => Some(changed.values[index].1.clone()),
                None => nominal.value(&path.key),
            };
            let value = match (current, path.entry) {
                (Some(Value::Array(mut entries)), Some(entry)) => {
                    let count = entries.len();
                    let Some(own) = entries.get_mut(entry) else {
                        return Err(format!(
                            "factor `{}`: `{}` has {count} entries, none with number {entry}",
                            self.name, path.key
                        ));
                    };
                    *own = self.of(number, own)?;
                    Value::Array(entries)
                }
                (current, Some(entry)) => {
                    let own = current.as_ref();
                    return Err(format!(
                        "factor `{}`: {}",
                        self.name,
                        path.no_list(own, entry)
                    ));
                }
                (None, None) if self.relation == Relation::Value => self.number(number, None),
                (None, None) => self.is_written_over(nominal, path)?,
                (Some(own), None) => self.of(number, &own)?,
            };
            match known {
                Some(index) => changed.values[index].1 = value,
                None => changed.values.push((path.key.clone(), value)),
            }
        }
        Ok(())
    }

    /// What becomes of the scenario's own value.
    fn of(&self, number: f64, own: &Value) -> Result<Value, String> {
        let combine = |own: f64| match self.relation {
            Relation::Value => number,
            Relation::Scale => number * own,
            Relation::Shift => number + own,
        };
        match own {
            // One number for a list: where a list may be, a number may be.
            Value::Array(_) if self.relation == Relation::Value => Ok(self.number(number, None)),
            Value::Array(entries) => {
                let entries = entries.iter().map(|entry| self.of(number, entry));
                Ok(Value::Array(entries.collect::<Result<_, _>>()?))
            }
            Value::Float(x) => Ok(Value::Float(combine(*x))),
            Value::Integer(i) => Ok(self.number(combine(*i as f64), Some(*i))),
            other if self.relation != Relation::Value => Err(format!(
                "factor `{}`: cannot {} a {}",
                self.name,
                self.relation(),
                other.type_str()
            )),
            _ => Ok(self.number(number, None)),
        }
    }

    /// As a whole number where the scenario has one and the result is one, or where there are no others.
    fn number(&self, number: f64, own: Option<i64>) -> Value {
        let is_whole = number.fract() == 0.0 && number.abs() < 9e15;
        if is_whole && (own.is_some() || self.distribution.is_whole()) {
            Value::Integer(number as i64)
        } else {
            Value::Float(number)
        }
    }
}

/// Whether a value is the number 0, or a list of nothing else.
fn is_zero(value: &Value) -> bool {
    match value {
        Value::Float(x) => *x == 0.0,
        Value::Integer(i) => *i == 0,
        Value::Array(entries) => entries.iter().all(is_zero),
        _ => false,
    }
}

impl Path {
    /// What is wrong with a value that is none, or a number, where an entry of a list is wanted; and what to write.
    fn no_list(&self, own: Option<&Value>, entry: usize) -> String {
        let key = &self.key;
        let (what, filler) = match own {
            Some(Value::Float(_) | Value::Integer(_)) => {
                let number = own.map_or_else(String::new, Value::to_string);
                (
                    format!("`{key}` is the number {number}, no list with entry {entry}"),
                    number,
                )
            }
            Some(other) => {
                return format!(
                    "`{key}` is a {}, no list with entry {entry}",
                    other.type_str()
                );
            }
            None => {
                let what = format!("the scenario has no list at `{key}` to take entry {entry} of");
                (what, "1.0".to_owned())
            }
        };
        let entries = vec![filler; entry + 1].join(", ");
        format!(
            "{what}; write it out first, with all its entries: `{key} = [{entries}, …]` at the beginning of the plan"
        )
    }

    fn text(&self) -> String {
        match self.entry {
            Some(entry) => format!("{}[{entry}]", self.key),
            None => self.key.clone(),
        }
    }

    fn new(text: &str) -> Result<Self, String> {
        let refuse = |what: &str| Err(format!("path `{text}` {what}"));
        let (key, entry) = match text.strip_suffix(']').and_then(|t| t.rsplit_once('[')) {
            None => (text, None),
            Some((key, entry)) => match entry.parse::<usize>() {
                Ok(entry) => (key, Some(entry)),
                Err(_) => return refuse("ends in `[…]` that is not the number of an entry"),
            },
        };
        let first = key.split('.').next().unwrap_or_default();
        if !["change", "set"].contains(&first) || key.split('.').any(str::is_empty) {
            return refuse(
                "must begin with `change.` (the scenario's values) or `set.` (the controller's), as in \
                 `change.plant.mismatch.mass_scale`",
            );
        }
        if format!("{key} = 0").parse::<Table>().is_err() {
            return refuse("is not a key of a TOML file");
        }
        Ok(Self {
            key: key.to_owned(),
            entry,
        })
    }
}

/// A case's own values, where factors look for them.
#[derive(Clone, Debug)]
pub(crate) struct Nominal {
    scenario: Table,
    controller: Table,
    /// The controller's, Hz.
    rate: f64,
}

/// Why a factor's number cannot be written.
#[derive(Clone, Debug)]
pub(crate) struct Misfit {
    /// Where the factor begins in the plan.
    pub(crate) start: usize,
    /// What is wrong, with the factor's name.
    pub(crate) what: String,
}

/// Values of a case that differ from its own, in the order in which they were changed.
#[derive(Clone, Debug, Default)]
struct Changed {
    values: Vec<(String, Value)>,
}

impl Nominal {
    /// Those of a case.
    pub(crate) fn of(case: &Case) -> Result<Self, ScenarioError> {
        let config = case.controller_config()?;
        // What cannot be written has no values to be scaled.
        let controller = config.to_toml().ok().and_then(|text| text.parse().ok());
        let rate = config.settings.rate;
        let mut scenario = case.values();
        let mismatch = scenario
            .get_mut("plant")
            .and_then(|p| p.get_mut("mismatch"));
        if let Some(mismatch) = mismatch.and_then(Value::as_table_mut) {
            // How many there are is the robot's matter: a scenario without any means all 1.
            let rotors = case.make_controller(config)?.robot().rotors().count();
            let scales = Value::from(vec![1.0; rotors]);
            mismatch.entry("rotor_scales").or_insert(scales);
        }
        Ok(Self {
            scenario,
            controller: controller.unwrap_or_default(),
            rate,
        })
    }

    /// Control periods of a case like this one, and no more than a million.
    pub(crate) fn ticks(&self, case: &Case) -> usize {
        case.ticks(self.rate).min(1_000_000)
    }

    /// The value at a key such as `change.plant.wall.NAME.friction`.
    fn value(&self, key: &str) -> Option<Value> {
        let (side, path) = key.split_once('.')?;
        let table = match side {
            "change" => &self.scenario,
            _ => &self.controller,
        };
        let mut value = table.get(path.split('.').next()?)?;
        for name in path.split('.').skip(1) {
            value = match value {
                Value::Table(table) => table.get(name)?,
                Value::Array(entries) => entries.iter().find(|entry| is_called(entry, name))?,
                _ => return None,
            };
        }
        Some(value.clone())
    }

    /// What a key that there is not may be meant for, in words: the first of its names that is not there, if there is
    /// one much like it.
    fn meant(&self, key: &str) -> Option<String> {
        let (side, path) = key.split_once('.')?;
        let mut value = &Value::Table(match side {
            "change" => self.scenario.clone(),
            _ => self.controller.clone(),
        });
        for name in path.split('.') {
            let (known, inner): (Vec<&str>, _) = match value {
                Value::Table(table) => {
                    (table.keys().map(String::as_str).collect(), table.get(name))
                }
                Value::Array(entries) => (
                    entries.iter().filter_map(called).collect(),
                    entries.iter().find(|entry| is_called(entry, name)),
                ),
                _ => return None,
            };
            let Some(inner) = inner else {
                let hint = suggestion(name, &known);
                let is_near = hint.contains("did you mean");
                return is_near.then(|| format!("there is no `{name}`{hint}"));
            };
            value = inner;
        }
        None
    }

    /// What a point changes in the case: lines of TOML, as in a case of the scenario's file.
    pub(crate) fn changes(
        &self,
        factors: &[Factor],
        point: &[Option<f64>],
    ) -> Result<String, Misfit> {
        let mut changed = Changed::default();
        for (factor, number) in factors.iter().zip(point) {
            if let Some(number) = number {
                let written = factor.write(*number, self, &mut changed);
                written.map_err(|what| Misfit {
                    start: factor.start,
                    what,
                })?;
            }
        }
        let lines = changed.values.iter();
        Ok(lines.fold(String::new(), |mut text, (key, value)| {
            // A text takes everything.
            let _ = writeln!(text, "{key} = {value}");
            text
        }))
    }
}

/// The name of an entry of a list: the keys by which lists of scenarios and controllers name their entries.
fn called(entry: &Value) -> Option<&str> {
    let keys = ["name", "mark", "frame", "contact"];
    keys.iter().find_map(|key| entry.get(*key)?.as_str())
}

fn is_called(entry: &Value, name: &str) -> bool {
    called(entry) == Some(name)
}
