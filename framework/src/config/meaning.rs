//! Whether numbers can be meant, by what they are of: the unit that the schema says, the rate of the loop, and one
//! another.
//!
//! What a key allows is its plug-in's business. Here is what no key allows, wherever it is: numbers whose products
//! overflow or that no robot has are refused, those that are next to it are taken with a warning. A number without a
//! unit in its schema is not looked at, nor is one that is infinite: a plug-in that takes it says what it means.
//!
//! | of | warning | refused |
//! |---|---|---|
//! | `weight` | the largest is above 10¹² × the smallest that is not zero | below 1e-100, above 1e100 |
//! | gains, 1/s, 1/s², 1/s³ | above (2 rate)ⁿ: no discrete loop is stable with that | a million times as much |
//! | `rate`, Hz | below 1 | below 0.1: a period |
//! | anything else with a unit | as in [`plausible`](super::plausible) | |

use std::sync::OnceLock;

use serde_json::Value;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::{
    ConfigErrorKind as Kind,
    document::Document,
    entry,
    expand::{schema as short, value},
    plausible::{FAR, MOST_APART, Remark, WEIGHTS, of_unit, unusual},
    report::{At, Path, Report, Span, Step},
    table::Section,
};
use crate::{
    config::json_schema::schema_of,
    contact::ContactSpec,
    plugin::{AnyConstraint, AnyFallbackLaw, AnyReference, AnyTask},
    qp::Solver,
    registry::{self, PluginKind, schema::Node},
    settings::Settings,
};
use wbqp_robot_model::{Diagnostic, Robot, Severity};

/// Nobody controls a robot less often, Hz.
const SLOW: f64 = 1.0;
/// Below this a rate is a period, Hz.
const PERIOD: f64 = 0.1;

/// Looks at every number of a document whose unit its schema knows. What cannot be meant goes to the report, what may
/// be a mistake is given back.
pub(super) fn check(document: &Document<'_>, report: &mut Report<'_>) -> Vec<Diagnostic> {
    // The same for every file.
    static SETTINGS: OnceLock<Value> = OnceLock::new();
    static CONTACT: OnceLock<Value> = OnceLock::new();
    let rate = document.controller.as_ref();
    let rate = rate.and_then(|section| number(section.keys.get("rate")?));
    let mut check = Check {
        // Without a rate that is one, the loader says so.
        rate: rate.filter(|rate| *rate > 0.0 && *rate < 1e9),
        report,
        warnings: Vec::new(),
        weights: Vec::new(),
    };
    let settings = SETTINGS.get_or_init(schema_of::<Settings>);
    if let Some(section) = &document.controller {
        check.slow_rate(section);
        let at = At::subject("controller");
        check.table(&at, Node::root(settings), &section.keys, None);
    }
    check.single::<dyn Robot>(document.robot.as_ref());
    check.single::<dyn Solver>(document.solver.as_ref());
    check.single::<dyn AnyFallbackLaw>(document.fallback.as_ref());
    let contact = CONTACT.get_or_init(schema_of::<ContactSpec>);
    for (index, section) in document.contacts.iter().enumerate() {
        let at = At::subject(entry::subject("contact", Some(index), section));
        check.table(&at, Node::root(contact), &section.keys, None);
    }
    check.entries::<dyn AnyTask>(&document.tasks);
    check.entries::<dyn AnyConstraint>(&document.constraints);
    check.compare_weights();
    check.warnings
}

/// Looks at the numbers of a reference as they would be looked at in a file; `unit` is that of its task's values.
/// Gives back what may be a mistake.
///
/// # Errors
/// What cannot be meant, with its key.
pub fn check_reference(reference: &toml::Table, unit: &str) -> Result<Vec<String>, String> {
    let text = reference.to_string();
    // What is no table of a file is none of a reference: whoever reads it says so.
    let Ok(keys) = DeTable::parse(&text) else {
        return Ok(Vec::new());
    };
    let mut report = Report::new("", &text, Vec::new());
    let mut check = Check {
        rate: None,
        report: &mut report,
        warnings: Vec::new(),
        weights: Vec::new(),
    };
    check.plugin::<dyn AnyReference>(&At::default(), keys.get_ref(), Some(unit));
    let warnings = check.warnings;
    report.finish().map_err(|errors| {
        let first = errors.iter().next();
        first.map_or_else(String::new, |error| error.message.clone())
    })?;
    let words = |warning: &Diagnostic| format!("{}; {}", warning.found, warning.remedy);
    Ok(warnings.iter().map(words).collect())
}

/// A weight that is not zero.
struct Weight {
    value: f64,
    span: Span,
    subject: String,
}

struct Check<'c, 'r> {
    /// Hz.
    rate: Option<f64>,
    report: &'c mut Report<'r>,
    warnings: Vec<Diagnostic>,
    /// The smallest and the largest so far.
    weights: Vec<Weight>,
}

impl Check<'_, '_> {
    /// A period where a rate belongs. Of gains there is nothing to say beside it.
    fn slow_rate(&mut self, section: &Section<'_>) {
        if let (Some(value), Some(rate)) = (section.keys.get("rate"), self.rate)
            && rate < SLOW
        {
            self.rate = None;
            let remark = Remark {
                found: format!("is {rate} Hz: a tick every {} s", 1.0 / rate),
                remedy: format!(
                    "it counts in Hz: a period of {rate} s is a rate of {}",
                    1.0 / rate
                ),
                is_refused: rate < PERIOD,
            };
            self.say(&At::subject("controller").key("rate"), value.span(), remark);
        }
    }

    fn single<P: PluginKind + ?Sized>(&mut self, section: Option<&Section<'_>>) {
        if let Some(section) = section {
            let at = At::subject(entry::subject(P::NAME, None, section));
            self.plugin::<P>(&at, &section.keys, None);
        }
    }

    fn entries<P: PluginKind + ?Sized>(&mut self, sections: &[Section<'_>]) {
        for (index, section) in sections.iter().enumerate() {
            let at = At::subject(entry::subject(P::NAME, Some(index), section));
            if let Some(weight) = section.keys.get("weight") {
                self.weights(&at, weight);
            }
            if let Some(transition) = section.keys.get("transition") {
                self.numbers(&at.key("transition"), "s", transition);
            }
            self.plugin::<P>(&at, &section.keys, None);
        }
    }

    /// The keys of a plug-in; `unit` is that of a trajectory's values.
    fn plugin<P: PluginKind + ?Sized>(&mut self, at: &At, keys: &DeTable<'_>, unit: Option<&str>) {
        let tag = keys.get("type").and_then(|tag| tag.get_ref().as_str());
        if let Some(plugin) = tag.and_then(registry::find::<P>) {
            let schema = plugin.described();
            self.table(at, Node::root(schema.as_value()), keys, unit);
        }
    }

    fn table(&mut self, at: &At, node: Node<'_>, keys: &DeTable<'_>, unit: Option<&str>) {
        for (key, value) in keys {
            let key: &str = key.get_ref();
            if short::SHORT_KEYS.contains(&key) {
                continue;
            }
            let properties = node.properties();
            let Some(about) = properties.and_then(|properties| properties.get(key)) else {
                continue;
            };
            let own = match about.get("x-unit").and_then(Value::as_str) {
                Some("the task's") => unit,
                own => own,
            };
            let odd = own.zip(largest_of(value));
            if let Some(remark) = odd.and_then(|(unit, number)| unusual(key, number, unit)) {
                self.say(&at.key(key), value.span(), remark);
            } else {
                self.value(&at.key(key), node.at(about), value, (own, unit));
            }
        }
    }

    /// A value, its unit, and that of the values of the trajectory that it belongs to.
    fn value(
        &mut self,
        at: &At,
        node: Node<'_>,
        value: &Spanned<DeValue<'_>>,
        (unit, followed): (Option<&str>, Option<&str>),
    ) {
        match value.get_ref() {
            DeValue::Table(keys) if node.plugin() == Some("reference") => {
                self.plugin::<dyn AnyReference>(at, keys, unit);
            }
            DeValue::Table(keys) if node.plugin().is_none() => {
                if node.properties().is_some() {
                    self.table(at, node, keys, followed);
                } else if let Some(unit) = unit {
                    // A value by name.
                    for (name, value) in keys {
                        self.numbers(&at.key(name.get_ref()), unit, value);
                    }
                }
            }
            DeValue::Table(_) => {}
            DeValue::Array(elements) => {
                let element = node.element();
                for (index, value) in elements.iter().enumerate() {
                    let at = at.then(&[Step::Index(index)]);
                    match element {
                        Some(node) => self.value(&at, node, value, (unit, followed)),
                        None => {
                            if let Some(unit) = unit {
                                self.numbers(&at, unit, value);
                            }
                        }
                    }
                }
            }
            _ => {
                if let Some(unit) = unit {
                    self.numbers(at, unit, value);
                }
            }
        }
    }

    /// A number of a unit, or a list of them.
    fn numbers(&mut self, at: &At, unit: &str, value: &Spanned<DeValue<'_>>) {
        if let DeValue::Array(elements) = value.get_ref() {
            for (index, value) in elements.iter().enumerate() {
                self.numbers(&at.then(&[Step::Index(index)]), unit, value);
            }
            return;
        }
        let Some(number) = number(value).filter(|number| number.is_finite()) else {
            return;
        };
        if let Some(remark) = self.judge(number, unit) {
            self.say(at, value.span(), remark);
        }
    }

    fn judge(&self, number: f64, unit: &str) -> Option<Remark> {
        let size = number.abs();
        let power = match unit {
            "1/s" => Some(1),
            "1/s²" => Some(2),
            "1/s³" => Some(3),
            _ => None,
        };
        if let Some(power) = power {
            let rate = self.rate?;
            let most = (2.0 * rate).powi(power);
            return (size > most).then(|| Remark {
                found: format!(
                    "is {number:e} {unit}: a loop at {rate} Hz is stable with less than {most:e} {unit} at best"
                ),
                remedy: "make it smaller, or the rate larger".to_owned(),
                is_refused: size > FAR * most,
            });
        }
        of_unit(number, unit)
    }

    fn say(&mut self, at: &At, span: Span, remark: Remark) {
        let Remark {
            found,
            remedy,
            is_refused,
        } = remark;
        if is_refused {
            self.report
                .add(Kind::Value, Some(span), at, format!("{found}; {remedy}"));
            return;
        }
        self.warnings.push(Diagnostic {
            severity: Severity::Warning,
            place: self.report.place(&span),
            element: at.subject.clone(),
            found: format!("{} {found}", Path(&at.path)),
            done: "taken as it is".to_owned(),
            remedy,
        });
    }

    fn weights(&mut self, at: &At, value: &Spanned<DeValue<'_>>) {
        if let DeValue::Array(elements) = value.get_ref() {
            for value in elements {
                self.weights(at, value);
            }
            return;
        }
        // Not a number, infinite or negative: the loader says so.
        let weight = number(value).filter(|weight| *weight > 0.0 && weight.is_finite());
        let Some(weight) = weight else { return };
        if !WEIGHTS.contains(&weight) {
            let remark = Remark {
                found: format!("is {weight:e}: products with it are no numbers any more"),
                remedy: "weights count relative to one another: scale all of them".to_owned(),
                is_refused: true,
            };
            self.say(&at.key("weight"), value.span(), remark);
            return;
        }
        let new = Weight {
            value: weight,
            span: value.span(),
            subject: at.subject.clone(),
        };
        match self.weights.as_mut_slice() {
            [] => self.weights.push(new),
            [only] if only.value <= weight => self.weights.push(new),
            [_] => self.weights.insert(0, new),
            [smallest, ..] if weight < smallest.value => *smallest = new,
            [_, largest, ..] if weight > largest.value => *largest = new,
            _ => {}
        }
    }

    /// Says of the smallest weight that nothing is left of it beside the largest.
    fn compare_weights(&mut self) {
        let [smallest, largest] = self.weights.as_slice() else {
            return;
        };
        if largest.value / smallest.value <= MOST_APART {
            return;
        }
        let found = format!(
            "weight {:e} is {:.0e} of that of {}, {:e}: where both are about the same motion, nothing of it is left in \
             64 bits",
            smallest.value,
            smallest.value / largest.value,
            largest.subject,
            largest.value
        );
        self.warnings.push(Diagnostic {
            severity: Severity::Warning,
            place: self.report.place(&smallest.span),
            element: smallest.subject.clone(),
            found,
            done: "taken as it is".to_owned(),
            remedy: format!(
                "keep weights within {MOST_APART:e} of one another, or make the heavier one `hardness = \"hard\"`"
            ),
        });
    }
}

/// The number, or of a list of numbers the one of the largest size.
fn largest_of(value: &Spanned<DeValue<'_>>) -> Option<f64> {
    match value.get_ref() {
        DeValue::Array(elements) => {
            let numbers = elements.iter().filter_map(number);
            numbers.max_by(|a, b| a.abs().total_cmp(&b.abs()))
        }
        _ => number(value),
    }
}

fn number(value: &Spanned<DeValue<'_>>) -> Option<f64> {
    value::number(value.get_ref())
}
