//! The smallest problems that a solver, this one or another, answered wrongly. `expected` in each file is what Clarabel
//! at 1e-12, DAQP and HiGHS agree on, or what can be computed by hand where they do not.

use std::{fs, path::Path};

use serde_json::Value;
use wbqp_qp::{ActiveSet, Budget, Qp, QpSolver, Solution, Status};

/// Iterations that are enough for any of them.
const ITERATIONS: u32 = 250;

fn numbers(case: &Value, key: &str) -> Vec<f64> {
    let number = |value: &Value| match value.as_str() {
        None => value.as_f64().expect("a number"),
        Some(text) => text.parse().expect("inf, -inf or nan"),
    };
    case[key]
        .as_array()
        .expect("a list")
        .iter()
        .map(number)
        .collect()
}

/// What is left of an entry of `H x + g + Aᵀ y + z`, as a part of the largest sum of sizes of an entry's terms, in
/// units in which the diagonal of H is one, or the range of a variable without curvature.
fn rest_of_the_gradient(qp: &Qp, s: &Solution) -> f64 {
    let n = qp.n();
    let unit = |j: usize| match (qp.h()[j * n + j], qp.upper()[j] - qp.lower()[j]) {
        (curvature, _) if curvature > 0.0 => 1.0 / curvature.sqrt(),
        (_, range) if range > 0.0 && range.is_finite() => range,
        _ => 1.0,
    };
    let entry = |j: usize| {
        let curved = qp.h()[j * n..(j + 1) * n]
            .iter()
            .zip(&s.x)
            .map(|(h, x)| h * x);
        let limited =
            s.y.iter()
                .take(qp.m())
                .enumerate()
                .map(|(i, y)| qp.row(i)[j] * y);
        let terms = curved
            .chain(limited)
            .chain([qp.g()[j], s.z[j]])
            .map(|term| term * unit(j));
        terms.fold((0.0, 0.0), |(sum, size): (f64, f64), term| {
            (sum + term, size + term.abs())
        })
    };
    let worse = |(rest, largest): (f64, f64), (sum, size): (f64, f64)| {
        (rest.max(sum.abs()), largest.max(size))
    };
    let (rest, largest) = (0..n).map(entry).fold((0.0, 0.0), worse);
    rest / largest.max(f64::MIN_POSITIVE)
}

fn answer(case: &Value) -> (Qp, Status, Solution) {
    let [h, g, a] = ["H", "g", "A"].map(|key| numbers(case, key));
    let rows = ["row_lower", "row_upper"].map(|key| numbers(case, key));
    let bounds = ["lower", "upper"].map(|key| numbers(case, key));
    let qp = Qp::dense(&h, &g, &a, (&rows[0], &rows[1]), (&bounds[0], &bounds[1]));
    let qp = qp.expect("has one shape");
    let (mut solver, mut solution) = (ActiveSet::default(), Solution::new(qp.capacity()));
    solver.bind(qp.capacity()).expect("is good");
    let status = solver
        .solve(&qp, Budget::Configured, &mut solution)
        .expect("fits");
    (qp, status, solution)
}

/// Rays of coefficients that are rounding, 1000 rounds in the same steps before; where a ray is looked for, constraints
/// of another problem are held.
#[test]
fn what_leads_nowhere_ends_soon() {
    let text = include_str!("../unanswered/ray_beside_rounding.json");
    let case: Value = serde_json::from_str(text).expect("is JSON");
    let (_, status, solution) = answer(&case);
    assert!(
        matches!(status, Status::Optimal | Status::Stalled),
        "{status:?}"
    );
    assert!(solution.iterations < ITERATIONS, "{}", solution.iterations);
}

#[test]
fn the_smallest_cases_are_answered_rightly() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cases");
    let mut count = 0;
    for entry in fs::read_dir(folder).expect("is there") {
        let path = entry.expect("is there").path();
        let text = fs::read_to_string(&path).expect("is text");
        let case: Value = serde_json::from_str(&text).expect("is JSON");
        let name = path.file_stem().expect("has a name").to_string_lossy();
        let (qp, status, solution) = answer(&case);
        let expected = &case["expected"];
        assert_eq!(Some(status.as_str()), expected["status"].as_str(), "{name}");
        assert!(
            solution.iterations < ITERATIONS,
            "{name}: {}",
            solution.iterations
        );
        count += 1;
        if status != Status::Optimal {
            continue;
        }
        let rest = rest_of_the_gradient(&qp, &solution);
        assert!(rest <= 1e-9, "{name}: {rest:e} of the gradient is left");
        let bounds = solution.x.iter().zip(qp.lower().iter().zip(qp.upper()));
        for (x, (lower, upper)) in bounds {
            let excess = (lower - x).max(x - upper);
            let allowed = 1e-10 * (x.abs() + lower.abs().min(upper.abs()));
            assert!(excess <= allowed, "{name}: {lower} ≤ {x} ≤ {upper}");
        }
        let tolerance = expected["relative_tolerance"].as_f64().expect("a number");
        if let Some(least) = expected["objective"].as_f64() {
            let cost = qp.objective(&solution.x);
            let error = (cost - least).abs();
            assert!(
                error <= tolerance * least.abs() + 1e-12,
                "{name}: {cost} for {least}"
            );
        }
        for (x, y) in solution
            .x
            .iter()
            .zip(expected["x"].as_array().into_iter().flatten())
        {
            let y = y.as_f64().expect("a number");
            assert!(
                (x - y).abs() <= tolerance * y.abs().max(1.0),
                "{name}: {x} for {y}"
            );
        }
    }
    assert_eq!(count, 49);
}

/// The multiplier of a bound beside another that is the rounding of zero, which says nothing about the variable's unit.
#[test]
fn a_bound_has_its_price_beside_a_rounded_one() {
    let text = include_str!("../cases/price_of_a_rounded_bound.json");
    let (_, status, solution) = answer(&serde_json::from_str(text).expect("is JSON"));
    assert_eq!(status, Status::Optimal);
    assert!((solution.z[0] + 1.0).abs() < 1e-9, "{:?}", solution.z);
}

/// A vertex of a flow through a network at which more bounds meet than there are variables: what depends on the others
/// up to rounding changes places with them for ever.
#[test]
fn constraints_that_change_places_are_given_up_soon() {
    let case = serde_json::json!({
        "n": 5, "m": 2, "H": vec![0.0; 25], "g": [0.0, -3.0, 0.0, 2.0, 1.0],
        "A": [-1.0, -1.0, 0.0, 1.0, 0.0, 1.0, 1.0, -1.0, 0.0, 1.0],
        "row_lower": [-3.0, 5.0], "row_upper": [-3.0, "inf"],
        "lower": [0.0, "-inf", 0.0, 0.0, "-inf"], "upper": [3.0, 3.0, 1.0, 2.0, "inf"],
    });
    let (_, status, solution) = answer(&case);
    assert_eq!(status, Status::Optimal);
    assert!(solution.iterations < 80, "{}", solution.iterations);
}
