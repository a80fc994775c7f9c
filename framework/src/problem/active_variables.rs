//! Which variables are on, and where they stand.

use super::Partition;
use crate::qp::VarId;

/// Columns of y of the live variables, see [`Partition`]; the packed problem has those that are not substituted, in id
/// order. The layout depends on what is on and not on history.
#[derive(Clone, Debug)]
pub(crate) struct ActiveVariables {
    /// First force component of each contact that is live.
    pub(crate) forces: Vec<Option<usize>>,
    /// Slack of each entry that has a live one.
    pub(crate) slacks: Vec<Option<usize>>,
    /// Columns before the slacks.
    pub(crate) n_physical: usize,
    /// All columns.
    pub(crate) n: usize,
    /// Identities of the problem's variables, ascending.
    pub(crate) vars: Vec<VarId>,
}

/// First ids of the blocks of variables.
#[derive(Clone, Debug)]
pub(crate) struct FirstIds {
    pub(crate) vdot: u32,
    pub(crate) effort: u32,
    /// First id of each contact's force.
    pub(crate) force: Vec<u32>,
}

impl ActiveVariables {
    pub(crate) fn new(contacts: usize, entries: usize, capacity: usize) -> Self {
        Self {
            forces: vec![None; contacts],
            slacks: vec![None; entries],
            n_physical: 0,
            n: 0,
            vars: Vec::with_capacity(capacity),
        }
    }

    /// Lays out the live variables; true if forces are elsewhere than in the last tick.
    pub(crate) fn refresh(
        &mut self,
        partition: &Partition,
        first: &FirstIds,
        contact_is_live: impl Fn(usize) -> bool,
        live_slack: impl Fn(usize) -> Option<VarId>,
    ) -> bool {
        self.vars.clear();
        let kept = &partition.velocities[partition.substituted..];
        self.vars
            .extend(kept.iter().map(|&v| VarId::new(first.vdot + v as u32)));
        let efforts = &partition.kept;
        self.vars
            .extend(efforts.iter().map(|&u| VarId::new(first.effort + u as u32)));
        let mut column = partition.first_force();
        let mut changed = false;
        for (contact, force) in self.forces.iter_mut().enumerate() {
            let now = contact_is_live(contact).then_some(column);
            changed |= *force != now;
            *force = now;
            if force.is_some() {
                let (id, count) = (first.force[contact], partition.nf[contact]);
                self.vars.extend((id..id + count as u32).map(VarId::new));
                column += count;
            }
        }
        self.n_physical = column;
        for (entry, slack) in self.slacks.iter_mut().enumerate() {
            let id = live_slack(entry);
            *slack = id.map(|_| column);
            if let Some(id) = id {
                self.vars.push(id);
                column += 1;
            }
        }
        self.n = column;
        changed
    }
}
