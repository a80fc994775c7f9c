//! What a run that went to its end should be looked at for: nobody asked for a robot that lies on the ground.

use anyhow::Result;
use wbqp::{
    Controller,
    dynamics::{Data, frame_motion},
    model::Base,
    nalgebra::{Quaternion, UnitQuaternion, Vector3},
};
use wbqp_measures::{Series, log::Log};
use wbqp_sim::{Summary, scenario::Case};

use super::{contacts::ContactSummary, tasks::TaskSummary, traces::columns};
use crate::{
    check::undeclared,
    text::{number, per_cent, quantity},
};

/// Nobody asks a robot to end further from where it should be than this share of its size …
const LOST: f64 = 0.5;
/// … or, where it is large, than this, m.
const LOST_AT_MOST: f64 = 1.0;
/// Nor turned away by more than this, rad.
const TURNED: f64 = 1.0;
/// A base that leans by more than this, rad, from how it stood at the beginning, lies rather than stands.
pub(crate) const FALLEN: f64 = 1.0;
/// A controller that had no optimum in more than this share of its ticks was busy with something else.
const OFTEN: f64 = 0.5;
/// Blows and switches last no longer than this share of a run: a plant that was beyond its tolerance for longer is not
/// as near to the truth as was asked for.
const COARSE: f64 = 0.01;
/// A contact that a detector switches is expected to be on for more than this share of the time in which it touches …
const SELDOM: f64 = 0.1;
/// … if that is more than this share of a run.
const TOUCHED: f64 = 0.01;
/// Bounces are shorter, s: a contact that is on for longer while nothing is there pushes against nothing.
const BOUNCE: f64 = 0.5;
/// A run that diverged before this time, s, says nothing of what touches what.
const AT_ONCE: f64 = 0.1;
/// What a force task asks for beyond its set point by more than this, N, is no rounding.
const FED: f64 = 1e-6;
/// A force that differs from what its task wants by more than this share of it, and by more than this, N, is not what
/// was asked for.
const OFF: (f64, f64) = (0.1, 0.05);
/// What presses from behind with more than this, N, is no rounding.
const BEHIND: f64 = 0.1;

/// A sentence for everything.
///
/// # Errors
/// A log that cannot be read.
pub(super) fn of(
    run: &Summary,
    log: &Log,
    controller: &Controller,
    case: &Case,
    (tasks, contacts): (&[TaskSummary], &[ContactSummary]),
) -> Result<Vec<String>> {
    let mut words = Vec::new();
    let lost = (LOST * size(controller)).min(LOST_AT_MOST);
    let fallen = match controller.robot().model.base() {
        Base::Floating => fall(&lean(log)?),
        Base::Fixed => None,
    };
    for task in tasks {
        let far = match (task.unit.as_str(), task.rows) {
            ("m", _) => lost,
            // Of more rows, postures: they give way to everything else.
            ("rad", ..=3) if fallen.is_none() => TURNED,
            _ => continue,
        };
        if task.end.is_some_and(|end| end > far) {
            words.push(format!(
                "`{}` ended {} from its reference",
                task.name,
                quantity(task.end, &task.unit)
            ));
        }
    }
    words.extend(run.undeclared.as_deref().map(undeclared));
    // What diverged at once came to nothing.
    let length = run.ticks as f64 / controller.settings().rate;
    let is_short = run.diverged.is_some() && length < AT_ONCE;
    let untouched = contacts.iter().filter(|_| !is_short);
    words.extend(untouched.filter_map(|contact| never_touched(contact, controller, case)));
    words.extend(contacts.iter().filter_map(in_the_air));
    words.extend(
        contacts
            .iter()
            .filter_map(never_on(contacts, controller, case)),
    );
    let of_forces = contacts.iter().filter(|_| fallen.is_none());
    words.extend(of_forces.filter_map(off_its_set_point));
    for contact in contacts {
        words.extend(fed_with_nothing(contact, log, controller, case)?);
    }
    words.extend(
        contacts
            .iter()
            .filter_map(|contact| seldom_on(contact, case)),
    );
    if let Some((angle, since)) = fallen {
        words.push(format!(
            "the base ended leaning by {} rad from how it began, and by more than {FALLEN} rad from {since:.3} s on: \
             has the robot fallen?",
            number(angle)
        ));
    }
    let share = run.held as f64 / run.ticks.max(1) as f64;
    if share > OFTEN {
        words.push(format!(
            "{} of the ticks had no optimum",
            per_cent(Some(share))
        ));
    }
    if run.beyond_tolerance > COARSE * length {
        words.push(format!(
            "for {} s, {} of the run, the plant's steps could not get as short as `plant.tolerance` asks for: take \
             a smaller `plant.step`, or a larger tolerance",
            number(run.beyond_tolerance),
            per_cent(Some(run.beyond_tolerance / length))
        ));
    }
    Ok(words)
}

/// Of a contact that was on, or that a detector waited for, and bore nothing in the whole run.
fn never_touched(contact: &ContactSummary, controller: &Controller, case: &Case) -> Option<String> {
    let name = &contact.name;
    let is_awaited = case.detectors().iter().any(|d| &d.contact == name);
    if contact.peak_real.is_some_and(|force| force > 0.0) || !(contact.on > 0.0 || is_awaited) {
        return None;
    }
    let frame = &controller
        .contact_spec(controller.contact(name).ok()?)
        .frame;
    let plant = case.plant();
    if let Some(force) = contact.least_real.filter(|force| *force < -BEHIND) {
        return Some(format!(
            "contact `{name}` was pressed from behind, with up to {} N: its `surface.normal`, or the `normal` of the \
             [[plant.wall]], points the wrong way",
            number(-force)
        ));
    }
    let why = if !plant.contact_points.iter().any(|p| &p.frame == frame) {
        format!("the plant has no [[plant.contact_point]] with frame = \"{frame}\"")
    } else if plant.walls.is_empty() {
        "the plant has no [[plant.wall]]".to_owned()
    } else {
        format!("frame `{frame}` did not come to a [[plant.wall]]; is the wall where it goes?")
    };
    let promise = if contact.on > 0.0 {
        format!("was on for {} of the run", per_cent(Some(contact.on)))
    } else {
        "has a [[detector]]".to_owned()
    };
    Some(format!(
        "contact `{name}` {promise} and never touched anything: {why}"
    ))
}

/// Of a contact whose force no sensor measures, and whose force task asks for another force than its set point because
/// of that.
fn fed_with_nothing(
    contact: &ContactSummary,
    log: &Log,
    controller: &Controller,
    case: &Case,
) -> Result<Option<String>> {
    let name = &contact.name;
    let frame = &controller.contact_spec(controller.contact(name)?).frame;
    if case.force_torque_at(frame).is_some() {
        return Ok(None);
    }
    let pointers = ["/virtual_input/z", "/reference/z"].map(str::to_owned);
    let columns = columns(log, &format!("/contact/{name}"), &pointers)?;
    let [asked, wanted] = columns.as_slice() else {
        return Ok(None);
    };
    let differs = asked
        .minus(wanted)
        .samples()
        .any(|(_, force)| force.abs() > FED);
    Ok(differs.then(|| {
        format!(
            "the force task of contact `{name}` feeds back a force that nobody measures, zero: the case has no \
             [[sensors.force_torque]] with frame = \"{frame}\"; give it one, or the task `feedback = \"off\"`"
        )
    }))
}

/// Of a contact that touched, and that was on before or after that for long: the controller counts on a force then that
/// is not there, and the robot goes where nothing pushes back.
fn in_the_air(contact: &ContactSummary) -> Option<String> {
    let is_known = contact.peak_real.is_some_and(|force| force > 0.0);
    (is_known && contact.in_the_air > BOUNCE).then(|| {
        format!(
            "contact `{}` was on for {} s in which nothing was there, with up to {} N planned, and was hit with up to \
             {} N: let a [[detector]] switch it on when it touches",
            contact.name,
            number(contact.in_the_air),
            number(contact.peak_planned.unwrap_or_default()),
            number(contact.peak_real.unwrap_or_default())
        )
    })
}

/// Of a contact that ended with another force than its task wants.
fn off_its_set_point(contact: &ContactSummary) -> Option<String> {
    let (real, wanted) = contact.end_real.zip(contact.end_wanted)?;
    let (share, least) = OFF;
    ((real - wanted).abs() > (share * wanted.abs()).max(least)).then(|| {
        format!(
            "contact `{}` was pushed with {} N over the last tenth of the run, and its force task wants {} N",
            contact.name,
            number(real),
            number(wanted)
        )
    })
}

/// Of a contact that touched, and that nothing was there to switch on, nor another one at its frame.
fn never_on(
    contacts: &[ContactSummary],
    controller: &Controller,
    case: &Case,
) -> impl Fn(&ContactSummary) -> Option<String> {
    let frame = |name: &str| {
        let contact = controller.contact(name).ok()?;
        Some(controller.contact_spec(contact).frame.as_str())
    };
    move |contact| {
        let own = frame(&contact.name)?;
        let is_awaited = case.detectors().iter().any(|d| d.contact == contact.name);
        let mut others = contacts.iter().filter(|other| other.on > 0.0);
        let is_counted = others.any(|other| frame(&other.name) == Some(own));
        (contact.touched > TOUCHED && !is_counted && !is_awaited).then(|| {
            format!(
                "contact `{}` touched for {} of the run, with up to {} N, and was never on: let a [[detector]] or an \
                 event (`activate_contact`) switch it on, or give the contact `active = true`",
                contact.name,
                per_cent(Some(contact.touched)),
                number(contact.peak_real.unwrap_or_default())
            )
        })
    }
}

/// Of a contact that touched, and that its detector hardly ever switched on.
fn seldom_on(contact: &ContactSummary, case: &Case) -> Option<String> {
    let mut detectors = case.detectors().iter();
    let detector = detectors.find(|detector| detector.contact == contact.name)?;
    let is_seldom = contact.touched > TOUCHED && contact.on < SELDOM * contact.touched;
    is_seldom.then(|| {
        format!(
            "contact `{}` touched for {} of the run, with up to {} N, and was on for {}: its [[detector]] waits for \
             {} N for {} s; is what brings it there stiff enough to push?",
            contact.name,
            per_cent(Some(contact.touched)),
            number(contact.peak_real.unwrap_or_default()),
            per_cent(Some(contact.on)),
            number(detector.on),
            number(detector.dwell)
        )
    })
}

/// The diagonal of the box around all frames at home, m.
fn size(controller: &Controller) -> f64 {
    let robot = controller.robot();
    let mut data = Data::new(&robot.model);
    data.update(&robot.model, &robot.home);
    let frames = robot.model.frames().iter();
    let places = frames.filter_map(|frame| {
        let id = robot.model.frame(&frame.name)?;
        Some(frame_motion(&robot.model, &data, id).p_WF)
    });
    let (mut least, mut largest) = (robot.home.p_WR, robot.home.p_WR);
    for place in places {
        least = least.inf(&place);
        largest = largest.sup(&place);
    }
    (largest - least).norm()
}

/// The angle between the base's z axis at the beginning and at each time, rad.
fn lean(log: &Log) -> Result<Series> {
    let parts = ["w", "x", "y", "z"].map(|part| format!("/base/orientation/{part}"));
    let columns = columns(log, "/plant", &parts)?;
    let [w, x, y, z] = columns.as_slice() else {
        return Ok(Series::default());
    };
    let up = |k: usize| {
        let part = |c: &Series| c.y.get(k).copied();
        let q = Quaternion::new(part(w)?, part(x)?, part(y)?, part(z)?);
        Some(UnitQuaternion::try_new(q, 0.5)? * Vector3::z())
    };
    let Some(first) = up(0) else {
        return Ok(Series::default());
    };
    let leans = (0..w.len()).filter_map(|k| Some((*w.t.get(k)?, first.angle(&up(k)?))));
    Ok(leans.collect())
}

/// How far a robot leans at the end, rad, and since when, s, if that is as far as if it lay.
fn fall(lean: &Series) -> Option<(f64, f64)> {
    let (_, end) = lean.samples().last()?;
    let (since, _) = lean.stretches(|angle| angle > FALLEN).pop()?;
    (end > FALLEN).then_some((end, since))
}
