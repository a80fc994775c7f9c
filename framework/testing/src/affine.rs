//! Tasks on efforts and forces.
//!
//! Their rows `A x = b` are linear in efforts and forces; the error says how far last tick's were, or the measured
//! ones are, from what is wanted. So it is affine in them. For each row its slope is `A`, or nothing where what is
//! wanted follows what is measured.

use nalgebra::{DVector, Vector6};

use crate::{
    Check,
    bench::{Bench, Inputs},
    report::Report,
    scatter::Scatter,
    subject::Subject,
    written::label,
};

const TOLERANCE: f64 = 1e-9;

pub(crate) fn check<P: Subject + ?Sized>(
    bench: &Bench<'_>,
    here: &Inputs,
    scatter: &mut Scatter,
    report: &mut Report,
) -> Option<()> {
    let mut bound = bench.bind::<P>(&here.state).ok()?;
    let at = bound.update(here);
    let layout = bound.probe.layout();
    let effort = scatter.vector(bench.robot.nu(), 0.1);
    let forces: Vec<Vector6<f64>> = bench
        .contacts
        .iter()
        .map(|contact| {
            let change = scatter.vector(6, 0.1);
            let mut change = Vector6::from_fn(|i, _| change[i]);
            for &free in contact.kind.free() {
                change[free] = 0.0;
            }
            change
        })
        .collect();
    let error = |times: f64| {
        let changed = bound_inputs(bench, here, &effort, &forces, times);
        Some(bench.write::<P>(&here.state, here, &changed)?.rows.error)
    };
    let (start, once, twice) = (error(0.0)?, error(1.0)?, error(2.0)?);
    let slope = &once - &start;
    let mut expected = DVector::zeros(layout.len());
    if let Some(A) = &at.effort {
        expected += A * &effort;
    }
    for (contact, A) in &at.forces {
        let directions = bench.contacts[contact.index()].kind.constrained();
        let change = directions.iter().map(|&row| forces[contact.index()][row]);
        expected += A * DVector::from_iterator(directions.len(), change);
    }
    for k in 0..layout.len() {
        let scale = TOLERANCE * (1.0 + start.amax() + slope.amax());
        let name = format!("row {k} `{}`", label(layout, k));
        if ((&twice - &once)[k] - slope[k]).abs() > scale {
            let message = format!("{name}: the error is not affine in efforts and forces");
            report.fail(Check::Jacobian, bench.name(), message);
        } else if slope[k].abs() > scale && (slope[k] - expected[k]).abs() > scale {
            let message = format!(
                "{name}: the error changes by {:.9} with a random change of efforts and forces, its coefficients say \
                 {:.9}",
                slope[k], expected[k]
            );
            report.fail(Check::Jacobian, bench.name(), message);
        }
    }
    Some(())
}

/// Efforts and forces of the last solution, and measured forces, moved on.
fn bound_inputs(
    bench: &Bench<'_>,
    here: &Inputs,
    effort: &DVector<f64>,
    forces: &[Vector6<f64>],
    times: f64,
) -> Inputs {
    let mut changed = here.clone();
    changed.effort += effort * times;
    for (k, change) in forces.iter().enumerate() {
        changed.forces[k] += change * times;
        changed.wrenches[k] += bench.in_sensor_axes(&here.state, k, &(change * times));
    }
    changed
}
