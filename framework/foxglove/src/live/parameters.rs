//! What can be changed of a running controller, as Foxglove's parameters.

use std::collections::BTreeMap;

use foxglove::websocket::{Parameter, ParameterType, ParameterValue};
use wbqp::{
    Controller,
    controller::Change,
    plugin::{AnyReference, PerRow, Sample},
    toml,
};

/// What can be changed, and what it is now as far as is known.
#[derive(Debug)]
pub(super) struct Parameters {
    /// By name, as clients see it.
    known: BTreeMap<String, Known>,
    /// Keys of each entry as in its file: a change of a nested key replaces the whole key that it is in.
    tables: BTreeMap<String, toml::Table>,
    tasks: Vec<String>,
}

#[derive(Clone, Debug)]
struct Known {
    what: What,
    /// What was asked for last.
    value: Value,
    /// What the controller has.
    confirmed: Value,
    /// Requests that the controller has not answered.
    pending: u32,
}

/// What a parameter stands for; the text is the name of an entry or contact.
#[derive(Clone, Debug, PartialEq)]
enum What {
    /// A key of an entry, and the keys inside it.
    Key(String, Vec<String>),
    Weight(String),
    Entry(String),
    Contact(String),
    /// Where a task stays: the value of its first reference.
    Reference(String),
}

/// The values that parameters have; a change does not change the kind.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Value {
    Number(f64),
    Integer(i64),
    Switch(bool),
    Text(String),
    Numbers(Vec<f64>),
}

/// A change that a client asked for.
#[derive(Debug)]
pub(super) struct Request {
    pub(super) name: String,
    pub(super) change: Change,
    value: Value,
}

impl Parameters {
    pub(super) fn of(controller: &Controller) -> Self {
        let mut parameters = Self {
            known: BTreeMap::new(),
            tables: BTreeMap::new(),
            tasks: controller.task_names().map(str::to_owned).collect(),
        };
        for name in controller.entry_names() {
            let weights = controller.weight(name).unwrap_or_default();
            let is_uniform = weights.windows(2).all(|pair| pair[0] == pair[1]);
            let weight = match weights.first() {
                Some(first) if is_uniform => Value::Number(*first),
                _ => Value::Numbers(weights.to_vec()),
            };
            // Bounds and hard limits have none.
            if !weights.is_empty() {
                let what = What::Weight(name.to_owned());
                parameters.add(format!("{name}.weight"), what, weight);
            }
            let active = Value::Switch(controller.is_on(name).unwrap_or_default());
            parameters.add(
                format!("{name}.active"),
                What::Entry(name.to_owned()),
                active,
            );
            if let Ok(sample) = controller.followed(name) {
                let value = Value::Numbers(standing(sample));
                let what = What::Reference(name.to_owned());
                parameters.add(format!("{name}.reference"), what, value);
            }
            if let Ok(table) = controller.parameters(name) {
                parameters.add_keys(name, &table, &mut Vec::new());
                parameters.tables.insert(name.to_owned(), table);
            }
        }
        for name in controller.contact_names() {
            let is_on = controller.is_contact_on(name).unwrap_or_default();
            let what = What::Contact(name.to_owned());
            parameters.add(format!("contact.{name}.active"), what, Value::Switch(is_on));
        }
        parameters
    }

    fn add(&mut self, mut name: String, what: What, value: Value) {
        // A task may be called `contact.tip`.
        while self.known.contains_key(&name) {
            name.push('\'');
        }
        let confirmed = value.clone();
        let known = Known {
            what,
            value,
            confirmed,
            pending: 0,
        };
        self.known.insert(name, known);
    }

    /// Numbers, switches and texts of an entry's table; other plug-ins in it are replaced as a whole, not by key.
    fn add_keys(&mut self, entry: &str, table: &toml::Table, path: &mut Vec<String>) {
        for (key, value) in table {
            if path.is_empty() && key == "type" {
                continue;
            }
            path.push(key.clone());
            match value {
                toml::Value::Table(inner) if inner.contains_key("type") => {}
                toml::Value::Table(inner) => self.add_keys(entry, inner, path),
                other => {
                    if let Some(value) = Value::from_toml(other) {
                        let name = format!("{entry}.{}", path.join("."));
                        self.add(name, What::Key(entry.to_owned(), path.clone()), value);
                    }
                }
            }
            path.pop();
        }
    }

    /// Takes over what tasks follow, in the order of the tasks.
    pub(super) fn follow(&mut self, references: &[Vec<Sample>]) {
        for (task, references) in self.tasks.iter().zip(references) {
            let known = self.known.get_mut(&format!("{task}.reference"));
            // While a request waits, what is followed is what was followed before.
            if let (Some(known), Some(sample)) = (known, references.first())
                && known.what == What::Reference(task.clone())
                && known.pending == 0
            {
                known.value = Value::Numbers(standing(sample));
                known.confirmed = known.value.clone();
            }
        }
    }

    /// Those of these names; all if none is given.
    pub(super) fn get(&self, names: &[String]) -> Vec<Parameter> {
        let wanted = |name: &String| names.is_empty() || names.contains(name);
        let known = self.known.iter().filter(|(name, _)| wanted(name));
        known
            .map(|(name, known)| known.value.published(name))
            .collect()
    }

    /// Takes over what a client wants, and says what the controller has to do for it.
    ///
    /// # Errors
    /// In words: no such parameter, or a value of another kind.
    pub(super) fn request(&mut self, wanted: &Parameter) -> Result<Request, String> {
        let name = &wanted.name;
        let known = self.known.get_mut(name);
        let known = known.ok_or_else(|| {
            let quoted: String = name.chars().take(super::QUOTED).collect();
            format!("there is no parameter `{quoted}`")
        })?;
        let given = wanted.value.as_ref();
        let value = given.and_then(|value| known.value.like(value));
        let value = value.ok_or_else(|| format!("`{name}` must be {}", known.value.kind()))?;
        let change = change(&known.what, &value, &mut self.tables)?;
        known.value = value.clone();
        known.pending += 1;
        Ok(Request {
            name: name.clone(),
            change,
            value,
        })
    }

    /// The controller has done it.
    pub(super) fn confirm(&mut self, request: &Request) {
        if let Some(known) = self.known.get_mut(&request.name) {
            known.confirmed = request.value.clone();
            known.pending = known.pending.saturating_sub(1);
        }
    }

    /// The controller has refused it, or never heard of it: what it has is shown again, unless something else was asked
    /// for meanwhile.
    pub(super) fn undo(&mut self, request: &Request) {
        let Some(known) = self.known.get_mut(&request.name) else {
            return;
        };
        known.pending = known.pending.saturating_sub(1);
        if known.value == request.value {
            // The table of the entry's keys is set back by asking for the value that it had.
            let _ = change(&known.what, &known.confirmed, &mut self.tables);
            known.value = known.confirmed.clone();
        }
    }
}

/// What makes a parameter have a value; keys of entries are kept in `tables`.
fn change(
    what: &What,
    value: &Value,
    tables: &mut BTreeMap<String, toml::Table>,
) -> Result<Change, String> {
    Ok(match (what, value) {
        (What::Entry(entry), Value::Switch(on)) => Change::Entry(entry.clone(), *on),
        (What::Contact(contact), Value::Switch(on)) => Change::Contact(contact.clone(), *on),
        (What::Weight(entry), Value::Number(weight)) => {
            Change::Weight(entry.clone(), PerRow::Uniform(*weight))
        }
        (What::Weight(entry), Value::Numbers(weights)) => {
            Change::Weight(entry.clone(), PerRow::Each(weights.clone()))
        }
        (What::Reference(task), Value::Numbers(values)) => {
            let mut hold = toml::Table::new();
            hold.insert("type".to_owned(), "hold".into());
            hold.insert("value".to_owned(), values.clone().into());
            let reference = toml::Value::Table(hold).try_into::<Box<dyn AnyReference>>();
            Change::Follow(task.clone(), reference.map_err(|e| e.message().to_owned())?)
        }
        (What::Key(entry, path), value) => {
            let table = tables.entry(entry.clone()).or_default();
            let Some((first, inner)) = path.split_first() else {
                return Err("has no key".to_owned());
            };
            let mut place = table
                .entry(first.clone())
                .or_insert_with(|| toml::Table::new().into());
            for key in inner {
                let toml::Value::Table(table) = place else {
                    return Err(format!("`{first}` has no keys"));
                };
                place = table
                    .entry(key.clone())
                    .or_insert_with(|| toml::Table::new().into());
            }
            *place = value.to_toml();
            let whole = table.get(first).cloned();
            let whole = whole.ok_or("has no key")?;
            let keys = toml::Table::from_iter([(first.clone(), whole)]);
            Change::Set(entry.clone(), keys)
        }
        _ => return Err("is of another kind".to_owned()),
    })
}

/// What `hold` takes: a vector, or roll, pitch and yaw, rad.
fn standing(sample: &Sample) -> Vec<f64> {
    match sample {
        Sample::Vector(sample) => sample.value.clone(),
        Sample::Rotation(sample) => {
            let (roll, pitch, yaw) = sample.rotation.euler_angles();
            vec![roll, pitch, yaw]
        }
    }
}

impl Value {
    fn from_toml(value: &toml::Value) -> Option<Self> {
        let number = |value: &toml::Value| match value {
            toml::Value::Float(x) => Some(*x),
            toml::Value::Integer(x) => Some(*x as f64),
            _ => None,
        };
        Some(match value {
            toml::Value::Float(x) if x.is_finite() => Self::Number(*x),
            toml::Value::Integer(x) => Self::Integer(*x),
            toml::Value::Boolean(x) => Self::Switch(*x),
            toml::Value::String(x) => Self::Text(x.clone()),
            toml::Value::Array(items) => {
                Self::Numbers(items.iter().map(number).collect::<Option<_>>()?)
            }
            _ => return None,
        })
    }

    fn to_toml(&self) -> toml::Value {
        match self {
            Self::Number(x) => (*x).into(),
            Self::Integer(x) => (*x).into(),
            Self::Switch(x) => (*x).into(),
            Self::Text(x) => x.clone().into(),
            Self::Numbers(x) => x.clone().into(),
        }
    }

    fn kind(&self) -> String {
        match self {
            Self::Number(_) => "a finite number".to_owned(),
            Self::Integer(_) => "a whole number".to_owned(),
            Self::Switch(_) => "true or false".to_owned(),
            Self::Text(_) => "a text".to_owned(),
            Self::Numbers(x) => format!("a list of {} finite numbers", x.len()),
        }
    }

    /// A client's value, if it is of this kind.
    fn like(&self, value: &ParameterValue) -> Option<Self> {
        let number = |value: &ParameterValue| match value {
            ParameterValue::Float64(x) => Some(*x).filter(|x| x.is_finite()),
            ParameterValue::Integer(x) => Some(*x as f64),
            _ => None,
        };
        Some(match (self, value) {
            (Self::Number(_), value) => Self::Number(number(value)?),
            (Self::Integer(_), ParameterValue::Integer(x)) => Self::Integer(*x),
            // Sliders give whole numbers a fraction of zero.
            (Self::Integer(_), ParameterValue::Float64(x))
                if x.fract() == 0.0 && x.abs() < 1e15 =>
            {
                Self::Integer(*x as i64)
            }
            (Self::Switch(_), ParameterValue::Bool(x)) => Self::Switch(*x),
            (Self::Text(_), ParameterValue::String(x)) => Self::Text(x.clone()),
            (Self::Numbers(now), ParameterValue::Array(items)) if items.len() == now.len() => {
                Self::Numbers(items.iter().map(number).collect::<Option<_>>()?)
            }
            _ => return None,
        })
    }

    fn published(&self, name: &str) -> Parameter {
        let (kind, value) = match self {
            Self::Number(x) => (Some(ParameterType::Float64), ParameterValue::Float64(*x)),
            Self::Integer(x) => (None, ParameterValue::Integer(*x)),
            Self::Switch(x) => (None, ParameterValue::Bool(*x)),
            Self::Text(x) => (None, ParameterValue::String(x.clone())),
            Self::Numbers(x) => {
                let items = x.iter().map(|x| ParameterValue::Float64(*x));
                let items = ParameterValue::Array(items.collect());
                (Some(ParameterType::Float64Array), items)
            }
        };
        Parameter {
            name: name.to_owned(),
            r#type: kind,
            value: Some(value),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parameters() -> Parameters {
        let inner = [("ki", 1.0), ("clamp", 2.0)].map(|(key, x)| (key.to_owned(), x.into()));
        let inner = toml::Table::from_iter(inner).into();
        let keys = [
            ("kp".to_owned(), 9.0.into()),
            ("integral".to_owned(), inner),
        ];
        let keys = toml::Table::from_iter(keys);
        let mut parameters = Parameters {
            known: BTreeMap::new(),
            tables: BTreeMap::from([("base".to_owned(), keys.clone())]),
            tasks: Vec::new(),
        };
        parameters.add_keys("base", &keys, &mut Vec::new());
        parameters
    }

    fn ask(parameters: &mut Parameters, kp: f64) -> Request {
        let wanted = Parameter::float64("base.kp", kp);
        parameters.request(&wanted).expect("is a number")
    }

    fn kp(parameters: &Parameters) -> Option<ParameterValue> {
        let kp = parameters.get(&["base.kp".to_owned()]);
        kp.first()?.value.clone()
    }

    #[test]
    fn a_key_inside_another_is_asked_for_with_its_neighbours() {
        let mut parameters = parameters();
        let wanted = Parameter::float64("base.integral.ki", -3.0);
        let refused = parameters.request(&wanted).expect("is a number");
        parameters.undo(&refused);
        let wanted = Parameter::float64("base.integral.clamp", 5.0);
        let request = parameters.request(&wanted).expect("is a number");
        let Change::Set(entry, keys) = request.change else {
            panic!("keys are set");
        };
        assert_eq!(entry, "base");
        let integral = keys["integral"].as_table().expect("is a table");
        // What was refused is not sent again.
        assert_eq!(integral["ki"].as_float(), Some(1.0));
        assert_eq!(integral["clamp"].as_float(), Some(5.0));
    }

    #[test]
    fn of_two_that_are_refused_neither_stays() {
        let mut parameters = parameters();
        let both = [ask(&mut parameters, -1.0), ask(&mut parameters, -2.0)];
        for request in &both {
            parameters.undo(request);
        }
        assert_eq!(kp(&parameters), Some(ParameterValue::Float64(9.0)));
    }

    #[test]
    fn what_is_shown_is_what_the_controller_has_in_the_end() {
        let number = |x| Some(ParameterValue::Float64(x));
        // Refused, then done.
        let mut parameters = parameters();
        let (bad, good) = (ask(&mut parameters, -1.0), ask(&mut parameters, 4.0));
        parameters.undo(&bad);
        parameters.confirm(&good);
        assert_eq!(kp(&parameters), number(4.0));
        // Done, then refused.
        let (good, bad) = (ask(&mut parameters, 5.0), ask(&mut parameters, -2.0));
        assert_eq!(
            kp(&parameters),
            number(-2.0),
            "what is asked for is shown at once"
        );
        parameters.confirm(&good);
        parameters.undo(&bad);
        assert_eq!(kp(&parameters), number(5.0));
        assert_eq!(parameters.tables["base"]["kp"].as_float(), Some(5.0));
    }
}
