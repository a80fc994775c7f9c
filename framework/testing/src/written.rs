//! What holds for the rows of every plug-in.

use nalgebra::DMatrix;

use crate::{
    Check,
    bench::{Bench, Inputs, Written},
    report::Report,
    subject::Subject,
};
use wbqp::{controller::WrittenRows, plugin::Layout};

/// Largest difference of coefficients that should be the same, relative.
const SAME: f64 = 1e-9;

/// Labels and units.
pub(crate) fn check_layout<P: Subject + ?Sized>(
    bench: &Bench<'_>,
    layout: &Layout,
    report: &mut Report,
) {
    let mut fail = |message: String| report.fail(Check::Layout, bench.name(), message);
    let rows: Vec<_> = layout.row_labels().collect();
    let bounds: Vec<_> = layout.bound_labels().collect();
    for (what, list) in [("row", rows), ("bound", bounds)] {
        for (k, &(label, unit)) in list.iter().enumerate() {
            if label.is_empty() || unit.is_empty() {
                fail(format!(
                    "{what} {k} has the label `{label}` and the unit `{unit}`"
                ));
            }
            if let Some(first) = list[..k].iter().position(|&(other, _)| other == label) {
                fail(format!(
                    "{what}s {first} and {k} have the same label, `{label}`"
                ));
            }
        }
    }
    if P::IS_TASK && layout.unit_of_error().is_empty() {
        fail("the error has no unit".into());
    }
    if layout.is_empty() && layout.bound_labels().next().is_none() {
        fail("it declares neither rows nor bounds".into());
    }
}

/// Checks what is written; false if no sense can be made of it.
pub(crate) fn check_rows<P: Subject + ?Sized>(
    bench: &Bench<'_>,
    here: &Inputs,
    there: &Inputs,
    report: &mut Report,
) -> bool {
    let robot = bench.name();
    let Ok(mut bound) = bench.bind::<P>(&here.state) else {
        report.fail(
            Check::Layout,
            robot,
            "it refuses the robot with another home posture",
        );
        return false;
    };
    let fresh = bound.update(here);
    if fresh.undeclared {
        let message = "it writes a block of coefficients that its layout does not declare dense";
        report.fail(Check::Layout, robot, message);
    }
    let sound = match fault::<P>(bound.probe.layout(), &fresh) {
        Some((check, message)) => {
            report.fail(check, robot, message);
            false
        }
        None => true,
    };
    // The same configuration, everything else different.
    let mut other = there.clone();
    let v = std::mem::replace(&mut other.state, here.state.clone()).v;
    other.state.v = v;
    let mut compare = |what: &str, written: &Written| {
        if let Some(message) = different(bound.probe.layout(), &fresh, written) {
            report.fail(Check::Coefficients, robot, format!("{message} {what}"));
        }
    };
    if let Some(written) = bench.write::<P>(&here.state, there, here) {
        compare(
            "with the state of the tick before: is an old entry left in place?",
            &written,
        );
    }
    if let Some(written) = bench.write::<P>(&here.state, &other, &other) {
        compare(
            "with the velocity, the measured forces or the last solution",
            &written,
        );
    }
    let last = bound.update(there);
    if last.allocated > 0 {
        let message = format!("two updates allocate {} times", last.allocated);
        report.fail(Check::Allocation, robot, message);
    }
    sound
}

/// Whether all coefficients are zero in a state.
pub(crate) fn is_zero<P: Subject + ?Sized>(bench: &Bench<'_>, here: &Inputs) -> bool {
    let Some(written) = bench.write::<P>(&here.state, here, here) else {
        return false;
    };
    let forces = written.forces.iter().map(|(_, block)| Some(block));
    let blocks = [written.vdot.as_ref(), written.effort.as_ref()].into_iter();
    blocks
        .chain(forces)
        .flatten()
        .all(|block| block.iter().all(|x| *x == 0.0))
}

/// The label of a row.
pub(crate) fn label(layout: &Layout, k: usize) -> &str {
    layout.row_labels().nth(k).map_or("", |(label, _)| label)
}

/// The first number that cannot be.
fn fault<P: Subject + ?Sized>(layout: &Layout, w: &Written) -> Option<(Check, String)> {
    let row = |k: usize| format!("row {k} `{}`", label(layout, k));
    let blocks = [("v̇", w.vdot.as_ref()), ("u", w.effort.as_ref())].into_iter();
    let blocks = blocks.chain(w.forces.iter().map(|(_, block)| ("f", Some(block))));
    for (what, block) in blocks {
        let Some(block) = block else { continue };
        if let Some((k, j)) = position(block, |x| !x.is_finite()) {
            let message = format!("{}: coefficient {j} on {what} is {}", row(k), block[(k, j)]);
            return Some((Check::Finite, message));
        }
    }
    for k in 0..layout.len() {
        let values: &[(&str, f64)] = if P::IS_TASK {
            &[("b", w.lower[k]), ("the error", w.error[k])]
        } else {
            &[("its limit", w.lower[k])]
        };
        if let Some((what, _)) = values.iter().find(|(_, x)| WrittenRows::is_unwritten(*x)) {
            return Some((Check::Layout, format!("{}: {what} is not written", row(k))));
        }
        let (lower, upper) = (w.lower[k], w.upper[k]);
        let problem = if P::IS_TASK {
            let bad = values.iter().find(|(_, x)| !x.is_finite());
            bad.map(|(what, x)| format!("{what} is {x}"))
        } else if layout.is_equality() {
            let sound = lower.is_finite() && lower == upper;
            (!sound).then(|| format!("an equality with the limits {lower} and {upper}"))
        } else {
            limits(lower, upper)
        };
        if let Some(problem) = problem {
            return Some((Check::Finite, format!("{}: {problem}", row(k))));
        }
    }
    for (k, (label, _)) in layout.bound_labels().enumerate() {
        let (lower, upper) = (w.bound_lower[k], w.bound_upper[k]);
        if WrittenRows::is_unwritten(lower) || WrittenRows::is_unwritten(upper) {
            return Some((Check::Layout, format!("bound {k} `{label}` is not written")));
        }
        if let Some(problem) = limits(lower, upper) {
            return Some((Check::Finite, format!("bound {k} `{label}`: {problem}")));
        }
    }
    None
}

fn limits(lower: f64, upper: f64) -> Option<String> {
    let sound = lower <= upper && lower < f64::INFINITY && upper > f64::NEG_INFINITY;
    (!sound).then(|| format!("its limits are {lower} and {upper}"))
}

fn position(block: &DMatrix<f64>, bad: impl Fn(f64) -> bool) -> Option<(usize, usize)> {
    (0..block.nrows())
        .flat_map(|k| (0..block.ncols()).map(move |j| (k, j)))
        .find(|&at| bad(block[at]))
}

/// The first coefficient that is not the same.
fn different(layout: &Layout, a: &Written, b: &Written) -> Option<String> {
    let pair = |what, a: Option<&DMatrix<f64>>, b: Option<&DMatrix<f64>>| {
        let (a, b) = (a?, b?);
        let scale = SAME * (1.0 + a.amax());
        let (k, j) = position(&(a - b), |x| x.abs() > scale)?;
        let label = label(layout, k);
        Some(format!(
            "row {k} `{label}`: coefficient {j} on {what} changes"
        ))
    };
    pair("v̇", a.vdot.as_ref(), b.vdot.as_ref())
        .or_else(|| pair("u", a.effort.as_ref(), b.effort.as_ref()))
        .or_else(|| {
            let mut forces = a.forces.iter().zip(&b.forces);
            forces.find_map(|((_, a), (_, b))| pair("f", Some(a), Some(b)))
        })
}
