//! Which variables are on, and where they stand in the packed problem.

use crate::qp::VarId;

/// Positions of the live variables: v̇ (explicit only), u, the forces of live contacts, slacks of live soft
/// inequalities, in id order. The layout depends on what is on and not on history.
#[derive(Clone, Debug)]
pub(crate) struct Live {
    /// First of the nv accelerations, in the explicit formulation.
    pub(crate) vdot: Option<usize>,
    /// First of the nu efforts.
    pub(crate) effort: usize,
    /// First force component of each contact that is live.
    pub(crate) forces: Vec<Option<usize>>,
    /// Slack of each group that has a live one.
    pub(crate) slacks: Vec<Option<usize>>,
    /// Variables before the slacks.
    pub(crate) n_physical: usize,
    /// Identities, ascending.
    pub(crate) vars: Vec<VarId>,
}

/// Sizes and first ids of the blocks of variables.
#[derive(Clone, Debug)]
pub(crate) struct Variables {
    pub(crate) nv: usize,
    pub(crate) nu: usize,
    /// Number of force components of each contact.
    pub(crate) nf: Vec<usize>,
    pub(crate) first_vdot: u32,
    pub(crate) first_effort: u32,
    /// First id of each contact's force.
    pub(crate) first_force: Vec<u32>,
}

impl Live {
    pub(crate) fn new(contacts: usize, groups: usize, capacity: usize) -> Self {
        Self {
            vdot: None,
            effort: 0,
            forces: vec![None; contacts],
            slacks: vec![None; groups],
            n_physical: 0,
            vars: Vec::with_capacity(capacity),
        }
    }

    /// Lays out the live variables.
    pub(crate) fn refresh(
        &mut self,
        variables: &Variables,
        with_vdot: bool,
        contact_is_live: impl Fn(usize) -> bool,
        live_slack: impl Fn(usize) -> Option<VarId>,
    ) {
        self.vars.clear();
        self.vdot = None;
        if with_vdot {
            self.vdot = Some(0);
            self.push(variables.first_vdot, variables.nv);
        }
        self.effort = self.vars.len();
        self.push(variables.first_effort, variables.nu);
        for contact in 0..self.forces.len() {
            self.forces[contact] = None;
            if contact_is_live(contact) {
                self.forces[contact] = Some(self.vars.len());
                self.push(variables.first_force[contact], variables.nf[contact]);
            }
        }
        self.n_physical = self.vars.len();
        for group in 0..self.slacks.len() {
            self.slacks[group] = None;
            if let Some(slack) = live_slack(group) {
                self.slacks[group] = Some(self.vars.len());
                self.vars.push(slack);
            }
        }
    }

    fn push(&mut self, first: u32, count: usize) {
        self.vars.extend((first..first + count as u32).map(VarId));
    }
}
