//! An examination for a terminal.

use std::{collections::HashMap, fmt::Write as _, path::Path};

use wbqp::robot::{Diagnostic, Severity, SourceLocation};

use super::{
    examination::{BodyFacts, ControllerFacts, Examination, JointFacts, MimicFacts, Robot},
    holding::{FirstTick, Holding, Means, SPENT},
};
use crate::text::{indented, number, per_cent, quantity, table, wrapped};

/// Characters that a line of names may have.
const WIDTH: usize = 100;

/// Everything but the errors, which belong on standard error; where the frames are only if that is asked for.
pub(super) fn text(examination: &Examination, with_places: bool) -> String {
    let mut out = String::new();
    let Some(robot) = &examination.robot else {
        return out;
    };
    let joints = robot.joints.len();
    let mimics = match robot.mimics.len() {
        0 => String::new(),
        n => format!(", {n} more that mimic them"),
    };
    let freedom = match robot.base {
        "floating" => format!(
            "floating base, nv = {} (6 + {joints} joints{mimics})",
            robot.nv
        ),
        _ => format!("fixed base, nv = {} ({joints} joints{mimics})", robot.nv),
    };
    let _ = writeln!(
        out,
        "{}: robot `{}`, {freedom}, {} actuators, {} kg",
        examination.file,
        robot.name,
        robot.nu,
        number(robot.total_mass)
    );
    if let Some(controller) = &examination.controller {
        controller_text(controller, &mut out);
    }
    diagnostics_text(&robot.diagnostics, &mut out);
    tree_text(robot, &mut out);
    frames_text(robot, &mut out);
    if with_places {
        places_text(robot, &mut out);
    }
    if let Some(holding) = &examination.holding {
        holding_text(holding, &mut out);
    }
    if let Some(remark) = &examination.remark {
        let _ = writeln!(out, "\nNo controller can be made for it: {remark}");
    }
    out
}

fn controller_text(controller: &ControllerFacts, out: &mut String) {
    let _ = writeln!(out, "\nController, {} Hz", number(controller.rate));
    for (what, names) in [
        ("cases", &controller.cases),
        ("contacts", &controller.contacts),
        ("tasks", &controller.tasks),
        ("constraints", &controller.constraints),
    ] {
        if !names.is_empty() {
            let names = wrapped(names, ",", 15, WIDTH - 15);
            let _ = writeln!(out, "  {what:12} {names}");
        }
    }
}

/// Warnings before notes; what is the same of several elements once, with all their places.
fn diagnostics_text(diagnostics: &[Diagnostic], out: &mut String) {
    for (severity, title) in [(Severity::Warning, "Warnings"), (Severity::Note, "Notes")] {
        let of_it: Vec<&Diagnostic> = diagnostics
            .iter()
            .filter(|d| d.severity == severity)
            .collect();
        if of_it.is_empty() {
            continue;
        }
        let _ = writeln!(out, "\n{title} ({})", of_it.len());
        let mut groups: Vec<Vec<&Diagnostic>> = Vec::new();
        for each in of_it {
            let same = |group: &&mut Vec<&Diagnostic>| {
                group.first().is_some_and(|first| first.found == each.found)
            };
            match groups.iter_mut().find(same) {
                Some(group) => group.push(each),
                None => groups.push(vec![each]),
            }
        }
        for group in groups {
            group_text(&group, out);
        }
    }
}

/// What is the same of all once, what differs behind each.
fn group_text(group: &[&Diagnostic], out: &mut String) {
    let Some(first) = group.first() else {
        return;
    };
    let one_is_done = group.iter().all(|each| each.done == first.done);
    let _ = if one_is_done {
        writeln!(out, "  {}: {}", first.found, first.done)
    } else {
        writeln!(out, "  {}", first.found)
    };
    for each in group {
        let place = short_place(&each.place);
        let _ = if one_is_done {
            writeln!(out, "    {place}: {}", each.element)
        } else {
            writeln!(out, "    {place}: {}: {}", each.element, each.done)
        };
    }
    if !first.remedy.is_empty() {
        let others = if group.iter().all(|each| each.remedy == first.remedy) {
            ""
        } else {
            ", and so on"
        };
        let _ = writeln!(out, "    → {}{others}", first.remedy);
    }
}

/// Without the folders, which the first line has and which are longer than the rest.
fn short_place(place: &SourceLocation) -> SourceLocation {
    let name = Path::new(&place.file).file_name();
    let file = name.map(|name| name.to_string_lossy().into_owned());
    SourceLocation {
        file: file.unwrap_or_else(|| place.file.clone()),
        position: place.position,
    }
}

/// Columns from which on branches are not drawn any further to the right.
const DEEPEST: usize = 60;

/// By name of a body, those that it carries.
fn children(robot: &Robot) -> HashMap<&str, Vec<usize>> {
    let mut children: HashMap<&str, Vec<usize>> = HashMap::new();
    for (index, body) in robot.bodies.iter().enumerate() {
        if let Some(parent) = &body.parent {
            children.entry(parent).or_default().push(index);
        }
    }
    children
}

/// The tree by bodies: a child that is the only one stands below its parent, several are drawn as branches.
fn tree_text(robot: &Robot, out: &mut String) {
    let mut rows = table(
        &[
            "body", "mass", "joint", "kind", "range", "speed", "effort", "armature",
        ],
        &[1],
    );
    let children = children(robot);
    let carried = robot
        .joints
        .iter()
        .map(|joint| (joint.body.as_str(), joint));
    let joints: HashMap<&str, &JointFacts> = carried.collect();
    let followers = robot
        .mimics
        .iter()
        .map(|mimic| (mimic.body.as_str(), mimic));
    let mimics: HashMap<&str, &MimicFacts> = followers.collect();
    let mut stack: Vec<(usize, String, String)> = vec![(0, String::new(), String::new())];
    while let Some((index, prefix, below)) = stack.pop() {
        let Some(body) = robot.bodies.get(index) else {
            continue;
        };
        let joint = joints.get(body.name.as_str()).copied();
        let mut cells = row(body, joint, &prefix);
        if let Some(mimic) = mimics.get(body.name.as_str()) {
            let mut law = format!("{} × {}", number(mimic.multiplier), mimic.leader);
            if mimic.offset != 0.0 {
                let _ = write!(law, " + {}", number(mimic.offset));
            }
            cells.extend([mimic.name.clone(), "mimic".to_owned(), law]);
        }
        rows.add_row(cells);
        let children = children.get(body.name.as_str());
        let children = children.map_or(&[][..], Vec::as_slice);
        let count = children.len();
        let is_deep = below.chars().count() >= DEEPEST;
        for (i, &child) in children.iter().enumerate().rev() {
            let (mark, line) = match (count, i + 1 == count) {
                (1, _) => ("", ""),
                _ if is_deep => ("", ""),
                (_, true) => ("└ ", "  "),
                (_, false) => ("├ ", "│ "),
            };
            stack.push((child, format!("{below}{mark}"), format!("{below}{line}")));
        }
    }
    let _ = write!(out, "\n{}", indented(&rows.to_string(), ""));
}

fn row(body: &BodyFacts, joint: Option<&JointFacts>, prefix: &str) -> Vec<String> {
    let mut cells = vec![
        format!("{prefix}{}", body.name),
        format!("{} kg", number(body.mass)),
    ];
    let Some(joint) = joint else {
        return cells;
    };
    let range = match (joint.lower, joint.upper) {
        (None, None) => "unlimited".to_owned(),
        (lower, upper) => {
            let side = |x: Option<f64>| x.map_or_else(|| "∞".to_owned(), short);
            format!("{} … {} {}", side(lower), side(upper), joint.unit)
        }
    };
    let (force, inertia) = match joint.unit {
        "m" => ("N", "kg"),
        _ => ("N·m", "kg·m²"),
    };
    let effort = if joint.passive {
        "no motor".to_owned()
    } else {
        quantity(joint.effort, force)
    };
    let armature = Some(joint.armature).filter(|a| *a != 0.0);
    cells.extend([
        joint.name.clone(),
        joint.kind.to_owned(),
        range,
        quantity(joint.velocity, &format!("{}/s", joint.unit)),
        effort,
        quantity(armature, inertia),
    ]);
    cells
}

/// Hundredths are enough for a range on a terminal.
fn short(x: f64) -> String {
    if x.abs() >= 1e4 {
        return format!("{x:.0e}");
    }
    // Without the sign of a zero.
    let text = format!("{:.2}", x + 0.0);
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

fn frames_text(robot: &Robot, out: &mut String) {
    let merged = robot.bodies.iter().filter(|b| !b.merged.is_empty());
    let names: Vec<&BodyFacts> = merged.collect();
    let _ = writeln!(
        out,
        "\nFrames that can be named: {}{}",
        match robot.bodies.len() {
            1 => "the body".to_owned(),
            n => format!("the {n} bodies"),
        },
        if names.is_empty() {
            ""
        } else {
            ", and what is fixed to them, with its mass merged into theirs:"
        }
    );
    let widest = names.iter().map(|b| b.name.chars().count()).max();
    let widest = widest.unwrap_or(0);
    for body in names {
        let frames = wrapped(&body.merged, ",", widest + 4, WIDTH.saturating_sub(widest));
        let _ = writeln!(out, "  {:widest$}  {frames}", body.name);
    }
}

/// Where each frame is at home.
fn places_text(robot: &Robot, out: &mut String) {
    let mut rows = table(
        &["frame", "x", "y", "z", "roll", "pitch", "yaw"],
        &[1, 2, 3, 4, 5, 6],
    );
    for frame in &robot.frames {
        let numbers = frame.position.iter().chain(&frame.rpy);
        let mut cells = vec![frame.name.clone()];
        cells.extend(numbers.map(|x| thousandths(*x)));
        rows.add_row(cells);
    }
    let _ = writeln!(out, "\nFrames at home, in the world (m, rad)");
    out.push_str(&indented(&rows.to_string(), "  "));
}

/// Without the sign of what is rounded to zero.
fn thousandths(x: f64) -> String {
    let text = format!("{x:.3}");
    if text == "-0.000" {
        "0.000".to_owned()
    } else {
        text
    }
}

fn holding_text(holding: &Holding, out: &mut String) {
    let weight = number(holding.weight);
    let title = match holding.means {
        Means::GravityCompensation => "Holding still at home: gravity compensation".to_owned(),
        Means::Hover => format!("Hovering at home: {weight} N of weight"),
        Means::Stand => format!(
            "At home, with the contacts that are on: the first tick's efforts, {weight} N of weight"
        ),
        Means::Nothing => {
            let _ = writeln!(
                out,
                "\nNothing carries the floating base: {weight} N of weight.\n  \
                 A robot that is bolted down: `--base fixed`. One that flies: `--rotors FILE`. One that stands: \
                 a controller with contacts, which `wbqp new` writes."
            );
            return;
        }
    };
    let _ = writeln!(out, "\n{title}");
    let mut rows = table(&["actuator", "effort", "limit", "share"], &[1, 2, 3]);
    for effort in &holding.efforts {
        rows.add_row([
            effort.actuator.clone(),
            format!("{:.3} {}", effort.effort + 0.0, effort.unit),
            quantity(effort.limit, effort.unit),
            per_cent(effort.share.map(|share| share + 0.0)),
        ]);
    }
    out.push_str(&indented(&rows.to_string(), "  "));
    if let Some(largest) = holding.largest_share() {
        let _ = writeln!(
            out,
            "  most loaded: {} at {} of its limit{}",
            largest.actuator,
            per_cent(largest.share),
            if largest.share.is_some_and(|share| share > SPENT) {
                ": nothing is left for motion; is the posture, or the limit, the right one?"
            } else {
                ""
            }
        );
    }
    if let Some((effort, lower)) = holding.nearest_lower() {
        let (unit, left) = (effort.unit, effort.effort - lower);
        let others = holding.efforts.iter().filter(|e| e.near_lower.is_some());
        let others = match others.count() {
            0 | 1 => String::new(),
            n => format!(" ({} more have little left, too)", n - 1),
        };
        let _ = writeln!(
            out,
            "  {} is {} {unit} above its lower limit of {} {unit}{others}: nearly nothing can be thrust less; is the \
             rotors' `thrust.min`, their idling, the right one?",
            effort.actuator,
            number(left + 0.0),
            number(lower)
        );
    }
    if let Some(leaning) = &holding.leaning {
        let _ = writeln!(out, "  {leaning}");
    }
    for missing in &holding.missing {
        let _ = writeln!(
            out,
            "  missing: {} {}, {}",
            number(missing.force),
            missing.unit,
            missing.coordinate
        );
    }
    if let Some(tick) = &holding.first_tick {
        first_tick_text(tick, holding.means, out);
    }
}

fn first_tick_text(tick: &FirstTick, means: Means, out: &mut String) {
    for (name, force) in &tick.contacts {
        let _ = writeln!(out, "  contact `{name}`: {} N normal force", number(*force));
    }
    for (name, above) in &tick.off_surface {
        let _ = writeln!(
            out,
            "  contact `{name}` is {} m above its surface at home{}: it does not touch; is its frame the right \
             one?",
            number(*above),
            match means {
                Means::GravityCompensation => "",
                _ => ", where the others on parallel surfaces are",
            }
        );
    }
    let _ = writeln!(out, "  first tick {}: {}", tick.place, tick.level);
    if let Some(acceleration) = tick.falls {
        let _ = writeln!(
            out,
            "  it does NOT stand: its base accelerates by {} m/s²; are torque and force limits enough, are the \
             contacts below it?",
            number(acceleration)
        );
    }
    if let Some(unheld) = &tick.unheld {
        let _ = writeln!(out, "  nothing holds it up: {unheld}");
    }
    if let Some(why) = &tick.why {
        out.push_str(&indented(why, "    "));
    }
}
