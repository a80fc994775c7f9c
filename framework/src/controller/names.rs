//! What the numbers of a report stand for.

use std::sync::Arc;

use wbqp_dynamics::model::Model;

use super::{Controller, Explanation, Limit, Report, Side, explanation::Rounded, first::FirstTick};
use crate::{
    fault::{Fault, Quantity},
    problem::{BoundEntry, Named, Table},
    qp::RowId,
};

/// The names that a controller's reports refer to by number: with them a copied [`Report`] can be read without the
/// controller, in another thread for example. They stay the same for the controller's life.
#[derive(Clone, Debug)]
pub struct Names {
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
    pub(super) fn of(controller: &Controller) -> Self {
        let robot = &controller.robot;
        let bindings = controller.world.bindings.iter();
        let entries = controller.entries.iter();
        Self {
            model: Arc::clone(&robot.model),
            actuators: robot.actuators.iter().map(|a| a.name.clone()).collect(),
            contacts: bindings.map(|b| b.spec.name.clone()).collect(),
            entries: entries.map(|entry| entry.name.clone()).collect(),
            rows: controller.table.rows.clone(),
            owners: controller.fallback.owners.clone(),
            first: controller.first.clone(),
        }
    }

    /// Name and unit of a row.
    pub fn row(&self, row: RowId) -> Option<&Named> {
        self.rows.get(row.index())
    }

    /// Why the tick of this report did not end with the optimum of its problem; nothing if it did. Allocates: not for
    /// inside the loop.
    pub fn explain(&self, report: &Report) -> Option<Explanation> {
        let fault = report.fault.as_ref()?;
        let conflict = report.conflict.iter();
        let conflict = conflict.filter_map(|c| self.limit(c.row, c.side, c.limit, c.short));
        let relaxed = report.relaxed.iter();
        let relaxed = relaxed.filter_map(|r| self.limit(r.row, r.side, r.limit, r.short));
        Some(Explanation {
            level: report.level,
            fault: self.fault(report, fault),
            conflict: conflict.collect(),
            relaxed: relaxed.collect(),
        })
    }

    /// A fault with the names of the entries and contacts that it counts.
    fn fault(&self, report: &Report, fault: &Fault) -> String {
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
            Fault::CutEffort(actuator) => {
                let cut = report.cut.map_or_else(String::new, |cut| {
                    let (asked, sent) = (Rounded(cut.asked), Rounded(cut.sent));
                    format!(": {asked} asked, {sent} sent")
                });
                let name = self.actuators.get(actuator.index());
                name.map(|name| {
                    format!("the effort of actuator `{name}` had to be cut to its limits{cut}")
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

    /// A limit by name.
    fn limit(&self, row: RowId, side: Side, limit: f64, short: f64) -> Option<Limit> {
        let info = self.row(row)?;
        let (owner, is_equality) = match self.owners.get(row.index()) {
            Some(owner) => (owner.text.clone(), owner.is_equality),
            None => (format!("`{}`", info.owner), false),
        };
        Some(Limit {
            owner,
            label: info.label.clone(),
            is_equality,
            side,
            limit,
            short,
            unit: info.unit.clone(),
        })
    }
}

/// Whose a row is, in words.
#[derive(Clone, Debug)]
pub(super) struct Owner {
    text: String,
    is_equality: bool,
}

/// Whose each row and bound is: of an entry the type of its plug-in, its contact if it has one, and its name.
pub(super) fn owners(
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
