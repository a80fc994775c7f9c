//! What the numbers of a report stand for.

use std::{fmt, sync::Arc};

use wbqp_dynamics::model::Model;
use wbqp_robot_model::RobotModel;

use super::{LimitRow, Report, Side, first::FirstTick};
use crate::{
    contact::ContactBinding,
    fault::{Fault, Quantity},
    problem::{BoundEntry, Named, Table},
    qp::RowId,
};

/// The names that a controller's reports refer to by number. They stay the same for the controller's life.
#[derive(Clone, Debug)]
pub(super) struct Names {
    model: Arc<Model>,
    actuators: Vec<String>,
    contacts: Vec<String>,
    /// Tasks, then constraints.
    entries: Vec<String>,
    rows: Vec<Named>,
    owners: Vec<Owner>,
    first: FirstTick,
}

impl Names {
    pub(super) fn new(
        robot: &RobotModel,
        bindings: &[ContactBinding],
        entries: &[BoundEntry],
        table: &Table,
        tags: &[&'static str],
        first: FirstTick,
    ) -> Self {
        let contacts: Vec<&str> = bindings.iter().map(|b| b.spec.name.as_str()).collect();
        Self {
            model: Arc::clone(&robot.model),
            actuators: robot.actuators.iter().map(|a| a.name.clone()).collect(),
            entries: entries.iter().map(|entry| entry.name.clone()).collect(),
            rows: table.rows.clone(),
            owners: owners(table, entries, tags, &contacts),
            contacts: contacts.into_iter().map(str::to_owned).collect(),
            first,
        }
    }

    /// The position of a task or constraint.
    pub(super) fn entry(&self, name: &str) -> Option<usize> {
        self.entries.iter().position(|n| n == name)
    }

    /// The position of a contact.
    pub(super) fn contact(&self, name: &str) -> Option<usize> {
        self.contacts.iter().position(|n| n == name)
    }

    /// Name and unit of a row.
    pub(super) fn row(&self, row: RowId) -> Option<&Named> {
        self.rows.get(row.index())
    }

    /// A fault with the names of the entries and contacts that it counts.
    pub(super) fn fault(&self, report: &Report, fault: &Fault) -> String {
        let named = match fault {
            Fault::FirstError(task) => {
                let name = self.entries.get(*task);
                name.zip(report.tasks.get(*task))
                    .map(|(name, of)| self.first.error_text(*task, name, &of.error))
            }
            Fault::Rows(index) => {
                let name = self.entries.get(*index);
                name.map(|name| format!("entry `{name}` wrote a number that is not finite"))
            }
            Fault::NotFinite(Quantity::Wrench(contact)) => {
                let name = self.contacts.get(contact.index());
                name.map(|name| format!("measurement not finite: wrench of contact `{name}`"))
            }
            Fault::Implausible {
                quantity,
                value,
                limit,
            } => {
                let contact = |contact: crate::contact::ContactId| {
                    self.contacts.get(contact.index()).map(String::as_str)
                };
                Some(quantity.beyond([*value, *limit], &self.model, contact))
            }
            Fault::CutEffort {
                actuator,
                asked,
                sent,
            } => {
                let (asked, sent) = (Rounded(*asked), Rounded(*sent));
                let name = self.actuators.get(actuator.index());
                name.map(|name| {
                    format!(
                        "the effort of actuator `{name}` had to be cut to its limits: {asked} asked, {sent} sent"
                    )
                })
            }
            Fault::CutVelocity(joint) => {
                let joint = self.model.joints().get(joint.index());
                joint.map(|joint| {
                    let name = &joint.name;
                    format!("the velocity reference of joint `{name}` is not finite")
                })
            }
            _ => None,
        };
        named.unwrap_or_else(|| fault.to_string())
    }

    /// A limit by name, and how much is missing: what this limit alone would have to give, or has given.
    pub(super) fn limit(&self, limit: &LimitRow) -> Option<String> {
        let row = self.row(limit.row)?;
        let of_entry = self.owners.get(limit.row.index());
        let owner = of_entry.map_or_else(|| format!("`{}`", row.owner), |of| of.text.clone());
        let side = match (of_entry.is_some_and(|of| of.is_equality), limit.side) {
            (true, _) => "value",
            (false, Side::Lower) => "lower limit",
            (false, Side::Upper) => "upper limit",
        };
        let (label, unit) = (&row.label, &row.unit);
        let (limit, short) = (Rounded(limit.limit), Rounded(limit.short));
        Some(format!(
            "{owner}, {label}: {side} {limit} {unit}, short by {short} {unit}"
        ))
    }
}

/// Whose a row is, in words.
#[derive(Clone, Debug)]
struct Owner {
    text: String,
    is_equality: bool,
}

/// Whose each row and bound is: of an entry the type of its plug-in, its contact if it has one, and its name.
fn owners(
    table: &Table,
    entries: &[BoundEntry],
    tags: &[&'static str],
    contacts: &[&str],
) -> Vec<Owner> {
    let plain = |info: &Named| Owner {
        text: if contacts.contains(&info.owner.as_str()) {
            format!("contact `{}`", info.owner)
        } else {
            info.owner.clone()
        },
        is_equality: false,
    };
    let mut owners: Vec<Owner> = table.rows.iter().map(plain).collect();
    for (entry, tag) in entries.iter().zip(tags) {
        let contact = entry.layout.contact.or_else(|| {
            let forces = entry.layout.forces.first();
            forces.map(|(contact, _)| *contact)
        });
        let kind = tag.rsplit('.').next().unwrap_or(tag).replace('_', " ");
        let of = contact.and_then(|c| contacts.get(c.index()));
        let of = of.map_or_else(String::new, |name| format!(" of `{name}`"));
        let text = format!("{kind}{of} (`{}`)", entry.name);
        for id in entry.rows.iter().chain(&entry.bounds) {
            if let Some(owner) = owners.get_mut(id.index()) {
                owner.text.clone_from(&text);
                owner.is_equality = entry.rows.contains(id) && entry.is_equality();
            }
        }
    }
    owners
}

/// With about four significant digits and at least one decimal.
struct Rounded(f64);

impl fmt::Display for Rounded {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let size = self.0.abs();
        if size != 0.0 && !(1e-3..1e6).contains(&size) {
            return write!(f, "{:.2e}", self.0);
        }
        let decimals = (0..6).find(|&d| {
            let scale = 10_f64.powi(d);
            ((self.0 * scale).round() / scale - self.0).abs() <= 5e-4 * size
        });
        write!(f, "{:.*}", decimals.unwrap_or(6).max(1) as usize, self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::Rounded;

    #[test]
    fn numbers_are_short_and_never_zero_for_something() {
        for (value, text) in [
            (2.0, "2.0"),
            (1.3, "1.3"),
            (0.0, "0.0"),
            (-9.80665, "-9.81"),
            (0.034567, "0.03457"),
            (1.2345e-7, "1.23e-7"),
            (f64::INFINITY, "inf"),
        ] {
            assert_eq!(Rounded(value).to_string(), text);
        }
    }
}
