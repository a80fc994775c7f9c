//! Whether an entry and its plug-in's layout fit the problem: nothing that a tick writes can go out of range, and what
//! an entry asks for has a meaning.

use crate::{
    contact::ContactSpec,
    error::BindError,
    plugin::{
        AnyPlugin, Entry, Hardness, Layout,
        layout::{BoundTarget, Relation, VdotBlock},
    },
    problem::{BoundEntry, EntrySpec, Table},
    switch::Switch,
};
use wbqp_robot_model::RobotModel;

/// Sizes of the decision variables.
#[derive(Debug)]
pub(crate) struct Sizes {
    pub(crate) nv: usize,
    pub(crate) nu: usize,
    /// Constrained components of each contact.
    pub(crate) nf: Vec<usize>,
}

impl Sizes {
    pub(super) fn new(robot: &RobotModel, contacts: &[ContactSpec]) -> Self {
        let components = contacts.iter().map(|c| c.kind.constrained().len());
        Self {
            nv: robot.model.nv(),
            nu: robot.nu(),
            nf: components.collect(),
        }
    }
}

/// Contacts with moments that no constraint limits: the solver would pull with moments.
pub(super) fn unlimited_moments(
    contacts: &[ContactSpec],
    constraints: &[BoundEntry],
) -> Vec<(usize, BindError)> {
    let is_limited = |index: usize| {
        let mut limited = constraints.iter().flat_map(|g| &g.layout.moment_limits);
        limited.any(|contact| contact.index() == index)
    };
    let problem = |spec: &ContactSpec| {
        format!(
            "constrains rotations, and no constraint limits this contact's moments: add one of type \
             `contact_wrench` with `contact = \"{}\"` (crate wbqp-tasks), give the contact `motion` and the `size` of \
             its sole, or list one of your own whose layout says `limits_moments`",
            spec.name
        )
    };
    contacts
        .iter()
        .enumerate()
        .filter(|(index, spec)| spec.kind.has_moments() && !is_limited(*index))
        .map(|(index, spec)| (index, BindError::value("kind", problem(spec))))
        .collect()
}

/// Checks the entry and its layout and registers its rows.
pub(super) fn make_entry<P: AnyPlugin + ?Sized>(
    entry: &Entry<P>,
    layout: Layout,
    sizes: &Sizes,
    frames: usize,
    table: &mut Table,
) -> Result<BoundEntry, BindError> {
    check_layout(&layout, sizes, frames)?;
    check_entry(entry, &layout)?;
    let spec = EntrySpec {
        name: &entry.name,
        weight: &entry.weight,
        hardness: entry.hardness,
        switch: Switch::new(entry.active, entry.transition),
        is_task: P::IS_TASK,
    };
    Ok(BoundEntry::new(&spec, layout, table))
}

fn check_entry<P: AnyPlugin + ?Sized>(entry: &Entry<P>, layout: &Layout) -> Result<(), BindError> {
    let rows = layout.len();
    if let crate::plugin::PerRow::Each(weights) = &entry.weight
        && weights.len() != rows
    {
        let expected = format!("one number, or {rows}: one per row");
        return Err(BindError::length("weight", weights.len(), expected));
    }
    if let Some(w) = entry
        .weight
        .values()
        .iter()
        .find(|w| !w.is_finite() || **w < 0.0)
    {
        let problem = format!("is {w}, must be finite and not negative");
        return Err(BindError::value("weight", problem));
    }
    if !entry.transition.is_finite() || entry.transition < 0.0 {
        let problem = format!("is {} s, must be finite and not negative", entry.transition);
        return Err(BindError::value("transition", problem));
    }
    let equality = P::IS_TASK || layout.relation == Relation::Equality;
    let soft = entry.hardness != Hardness::Hard;
    if matches!(entry.hardness, Hardness::Exact(_)) && equality {
        return Err(BindError::value(
            "hardness",
            "an exact penalty is for inequality rows; use `hardness = \"soft\"` with a weight",
        ));
    }
    if soft && !P::IS_TASK && rows == 0 {
        return Err(BindError::value(
            "hardness",
            "bounds are always hard, and the entry has nothing else; leave `hardness` out",
        ));
    }
    if soft && !equality && entry.weight.values().iter().all(|w| *w == 0.0) {
        return Err(BindError::value(
            "weight",
            "is zero: a soft inequality without price limits nothing",
        ));
    }
    if entry.transition > 0.0 && !equality && !soft {
        return Err(BindError::value(
            "transition",
            "hard inequalities and bounds cannot ramp; leave it out, or use `hardness = \"soft\"` with a weight",
        ));
    }
    if let Hardness::Exact(linear) = entry.hardness
        && !(linear.is_finite() && linear > 0.0)
    {
        return Err(BindError::value(
            "hardness",
            format!("exact penalty is {linear}, must be positive"),
        ));
    }
    Ok(())
}

/// Catches a plug-in that declares what does not exist, so that nothing can go out of range in a tick.
pub(crate) fn check_layout(layout: &Layout, sizes: &Sizes, frames: usize) -> Result<(), BindError> {
    let rows = layout.len();
    let columns = |what: &str, list: &[usize], limit: usize| {
        if list.len() != rows {
            return Err(BindError::Other(format!(
                "its layout declares {rows} rows but {} {what}",
                list.len()
            )));
        }
        match list.iter().find(|&&c| c >= limit) {
            Some(c) => Err(BindError::Other(format!(
                "its layout declares {what} {c}, beyond the last, {}",
                limit.saturating_sub(1)
            ))),
            None => Ok(()),
        }
    };
    if rows > 0 && !layout.acts_on_accelerations() && !layout.acts_on_forces() {
        let s = if rows == 1 { "" } else { "s" };
        return Err(BindError::Other(format!(
            "its layout declares {rows} row{s} without coefficients, which ask for nothing: say what they multiply, \
             accelerations (`vdot_…`), efforts (`effort_…`) or forces (`force_…`)"
        )));
    }
    let no_contact = || BindError::Other("its layout declares a contact of another setup".into());
    let nf = |c: crate::contact::ContactId| sizes.nf.get(c.index()).copied().ok_or_else(no_contact);
    match &layout.vdot {
        VdotBlock::Absent | VdotBlock::Dense => {}
        VdotBlock::Unit(list) => columns("acceleration columns", list, sizes.nv)?,
        VdotBlock::Frame(frame, list) => {
            if frame.0 >= frames {
                return Err(BindError::Other(
                    "its layout declares a frame of another setup".into(),
                ));
            }
            columns("frame Jacobian rows", list, 6)?;
        }
        VdotBlock::Contact(contact, list) => {
            nf(*contact)?;
            columns("contact Jacobian rows", list, 6)?;
        }
    }
    if let Some(crate::plugin::layout::Block::Unit(list)) = &layout.effort {
        columns("effort columns", list, sizes.nu)?;
    }
    for (contact, block) in &layout.forces {
        let limit = nf(*contact)?;
        if let crate::plugin::layout::Block::Unit(list) = block {
            columns("force columns", list, limit)?;
        }
    }
    for (_, target) in &layout.bounds {
        let in_range = match *target {
            BoundTarget::Effort(i) => i < sizes.nu,
            BoundTarget::Force(contact, i) => i < nf(contact)?,
        };
        if !in_range {
            return Err(BindError::Other(
                "its layout bounds a variable that does not exist".into(),
            ));
        }
    }
    for contact in layout.contact.iter().chain(&layout.moment_limits) {
        nf(*contact)?;
    }
    Ok(())
}
