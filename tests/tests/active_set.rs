//! The active-set solver on random problems, judged by certificates: an optimum by the optimality conditions and the
//! cost known by construction, an infeasible problem by a Farkas combination.

use wbqp::qp::{ActiveSet, Optimality, Qp, QpSolver, Solution, Status};
use wbqp_tests::random_qp::{FAMILIES, Family, Known, random_qp};

/// Errors of the optimality conditions relative to the numbers that they are made of.
fn relative_errors(qp: &Qp, s: &Solution) -> [f64; 3] {
    let (n, m) = (qp.n(), qp.m());
    // In the units that make the diagonal of H one.
    let (mut worst, mut size) = (0.0_f64, 1e-12_f64);
    for j in 0..n {
        let h = qp.h()[j * n + j];
        let unit = if h > 0.0 { 1.0 / h.sqrt() } else { 1.0 };
        let hx: f64 = (0..n).map(|i| qp.h()[j * n + i] * s.x[i]).sum();
        let ay: f64 = (0..m).map(|i| qp.row(i)[j] * s.y[i]).sum();
        worst = worst.max(unit * (hx + qp.g()[j] + ay + s.z[j]).abs());
        size = size.max(unit * hx.abs()).max(unit * qp.g()[j].abs());
    }
    let stationarity = worst / size;
    let (mut primal, mut complementarity) = (0.0_f64, 0.0_f64);
    let cost = 1.0 + qp.objective(&s.x).abs();
    let mut side = |value: f64, size: f64, lower: f64, upper: f64, y: f64| {
        for excess in [value - upper, lower - value] {
            if excess > 0.0 {
                primal = primal.max(excess / (size + (value - excess).abs()));
            }
        }
        let distance = if y > 0.0 {
            upper - value
        } else {
            value - lower
        };
        if y != 0.0 {
            complementarity = complementarity.max((y * distance).abs() / cost);
        }
    };
    for i in 0..m {
        let terms = || qp.row(i).iter().zip(&s.x).map(|(a, x)| a * x);
        let size: f64 = terms().map(f64::abs).sum();
        side(
            terms().sum(),
            size,
            qp.row_lower()[i],
            qp.row_upper()[i],
            s.y[i],
        );
    }
    for j in 0..n {
        side(s.x[j], s.x[j].abs(), qp.lower()[j], qp.upper()[j], s.z[j]);
    }
    [stationarity, primal, complementarity]
}

/// Whether the multipliers prove that no point is feasible: `Aᵀ y + z = 0` and the limits that they weight have a
/// negative sum.
fn proves_infeasibility(qp: &Qp, s: &Solution) -> Result<(), String> {
    let (n, m) = (qp.n(), qp.m());
    let largest = s.y[..m]
        .iter()
        .chain(&s.z[..n])
        .fold(0.0_f64, |a, y| a.max(y.abs()));
    for j in 0..n {
        let column = || (0..m).map(|i| qp.row(i)[j]);
        let sum = column().zip(&s.y).map(|(a, y)| a * y).sum::<f64>() + s.z[j];
        let size = largest * column().fold(1.0, |a: f64, b| a.max(b.abs()));
        if sum.abs() > 1e-9 * size {
            return Err(format!("column {j}: {sum:e} of {size:e}"));
        }
    }
    let limits = |y: f64, l: f64, u: f64| {
        if y > 0.0 {
            y * u
        } else if y < 0.0 {
            y * l
        } else {
            0.0
        }
    };
    let rows = (0..m).map(|i| limits(s.y[i], qp.row_lower()[i], qp.row_upper()[i]));
    let bounds = (0..n).map(|j| limits(s.z[j], qp.lower()[j], qp.upper()[j]));
    let (mut sum, mut size) = (0.0, 0.0);
    for term in rows.chain(bounds) {
        sum += term;
        size += f64::abs(term);
    }
    if sum < -1e-9 * size {
        Ok(())
    } else {
        Err(format!("limits sum to {sum:e} of {size:e}"))
    }
}

fn judge(known: &Known, s: &Solution) -> Result<(), String> {
    let Some(x) = &known.x else {
        return if s.status == Status::Infeasible {
            proves_infeasibility(&known.qp, s)
        } else {
            Err(format!("{:?} instead of infeasible", s.status))
        };
    };
    if s.status != Status::Optimal {
        return Err(format!("{:?}", s.status));
    }
    let errors = relative_errors(&known.qp, s);
    if errors.iter().any(|e| !(*e < 1e-8)) {
        return Err(format!("errors {errors:?}"));
    }
    let (cost, best) = (known.qp.objective(&s.x), known.qp.objective(x));
    if (cost - best).abs() > 1e-9 * (1.0 + best.abs()) {
        return Err(format!("cost {cost} instead of {best}"));
    }
    if known.unique {
        let size = x.iter().fold(0.0_f64, |a, x| a.max(x.abs()));
        for (a, b) in s.x.iter().zip(x) {
            if (a - b).abs() > 1e-6 * (1.0 + size) {
                return Err(format!("x {a} instead of {b}"));
            }
        }
    }
    Ok(())
}

#[test]
fn every_status_comes_with_its_proof() {
    let count: u64 =
        std::env::var("WBQP_RANDOM_PROBLEMS").map_or(3000, |c| c.parse().expect("a number"));
    let mut wrong = Vec::new();
    let mut iterations = [0_u64; 6];
    for (f, family) in FAMILIES.into_iter().enumerate() {
        let only: Option<u64> = std::env::var("ONLY").ok().map(|s| s.parse().unwrap());
        for seed in (0..count).filter(|s| only.is_none_or(|o| o == *s)) {
            if only.is_some() && family != Family::Semidefinite {
                continue;
            }
            let known = random_qp(family, seed, 24);
            let mut solver = ActiveSet::default();
            solver.bind(known.qp.capacity()).expect("is good");
            let mut solution = Solution::new(known.qp.capacity());
            solver.solve(&known.qp, &mut solution);
            iterations[f] += u64::from(solution.iterations);
            if let Err(what) = judge(&known, &solution) {
                wrong.push(format!(
                    "{family:?} {seed} (n {}, m {}): {what}",
                    known.qp.n(),
                    known.qp.m()
                ));
            }
        }
    }
    eprintln!(
        "iterations per problem: {:?}",
        iterations.map(|i| i as f64 / count as f64)
    );
    assert!(
        wrong.is_empty(),
        "{} wrong:\n{}",
        wrong.len(),
        wrong.join("\n")
    );
}
