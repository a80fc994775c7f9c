//! Rows that give: the same answers as with a variable for what each of them gives.

use rand::{Rng as _, SeedableRng};
use rand_chacha::ChaCha8Rng;
use wbqp_qp::{ActiveSet, Budget, Capacity, Qp, QpError, QpSolver, Solution, Status, VarId};

/// A random problem and what its rows give. Most contradict one another.
fn problem(seed: u64) -> (Qp, Vec<f64>) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let n = rng.random_range(1..=10_usize);
    let m = rng.random_range(1..=3 * n);
    let mut draw = || rng.random_range(-1.0..1.0_f64);
    let root: Vec<f64> = (0..n * n).map(|_| draw()).collect();
    let mut h = vec![0.0; n * n];
    for i in 0..n {
        for j in 0..n {
            h[i * n + j] = (0..n).map(|k| root[i * n + k] * root[j * n + k]).sum();
        }
        h[i * n + i] += 0.1;
    }
    let g: Vec<f64> = (0..n).map(|_| draw()).collect();
    let a: Vec<f64> = (0..m * n).map(|_| draw()).collect();
    let middle: Vec<f64> = (0..m).map(|_| 3.0 * draw()).collect();
    let mut limits = (Vec::new(), Vec::new());
    let mut compliance = Vec::new();
    for middle in middle {
        let width = match rng.random_range(0..4) {
            0 => 0.0,
            1 => f64::INFINITY,
            _ => rng.random_range(0.0..2.0),
        };
        limits.0.push(middle);
        limits.1.push(middle + width);
        let is_soft = rng.random_range(0..4) > 0;
        compliance.push(if is_soft {
            10_f64.powf(rng.random_range(-8.0..0.0))
        } else {
            0.0
        });
    }
    let bounds = (vec![-2.0; n], vec![2.0; n]);
    let qp = Qp::dense(&h, &g, &a, (&limits.0, &limits.1), (&bounds.0, &bounds.1));
    (qp.expect("the shapes fit"), compliance)
}

/// The same with a variable for what each row gives.
fn with_variables(qp: &Qp, compliance: &[f64]) -> Qp {
    let (n, m) = (qp.n(), qp.m());
    let soft: Vec<usize> = (0..m).filter(|i| compliance[*i] > 0.0).collect();
    let wide = n + soft.len();
    let mut out = Qp::new(Capacity {
        vars: wide,
        rows: m,
    });
    out.reset((0..wide as u32).map(VarId::new)).expect("fits");
    for i in 0..n {
        out.h_mut()[i * wide..i * wide + n].copy_from_slice(&qp.h()[i * n..(i + 1) * n]);
    }
    for (k, i) in soft.iter().enumerate() {
        out.h_mut()[(n + k) * wide + n + k] = 1.0 / compliance[*i];
    }
    out.g_mut()[..n].copy_from_slice(qp.g());
    for i in 0..m {
        let row = out
            .push(qp.row_lower()[i], qp.row_upper()[i])
            .expect("fits");
        row[..n].copy_from_slice(qp.row(i));
        if let Some(k) = soft.iter().position(|soft| *soft == i) {
            row[n + k] = 1.0;
        }
    }
    let (lower, upper) = out.bounds_mut();
    lower[..n].copy_from_slice(qp.lower());
    upper[..n].copy_from_slice(qp.upper());
    out
}

fn answer(qp: &Qp) -> Solution {
    let mut solver = ActiveSet::by_reflections();
    solver.bind(qp.capacity()).expect("is good");
    let mut out = Solution::new(qp.capacity());
    solver
        .solve(qp, Budget::Configured, &mut out)
        .expect("fits");
    out
}

#[test]
fn rows_give_as_with_variables() {
    let (mut optimal, mut infeasible, mut stalled) = (0, 0, 0);
    for seed in 0..4000 {
        let (qp, compliance) = problem(seed);
        let (n, m) = (qp.n(), qp.m());
        let expected = answer(&with_variables(&qp, &compliance));
        let room = Capacity {
            vars: n + m,
            rows: m,
        };
        let mut solver = ActiveSet::by_reflections();
        solver.bind(room).expect("is good");
        let mut out = Solution::new(room);
        // Cold, and from where that ended.
        for start in ["cold", "warm"] {
            let status = solver.solve_soft(&qp, &compliance, &mut out).expect("fits");
            if status == Status::Stalled {
                stalled += 1;
                continue;
            }
            assert_eq!(status, expected.status, "seed {seed}, {start}");
            if status != Status::Optimal {
                infeasible += 1;
                continue;
            }
            optimal += 1;
            for (a, b) in out.x[..n].iter().zip(&expected.x) {
                assert!((a - b).abs() < 1e-7, "seed {seed}, {start}: {a} {b}");
            }
            let scale = 1.0 + expected.y.iter().fold(0.0, |a: f64, y| a.max(y.abs()));
            for (a, b) in out.y[..m].iter().zip(&expected.y) {
                assert!(
                    (a - b).abs() < 1e-7 * scale,
                    "seed {seed}, {start}: {a} {b}"
                );
            }
        }
    }
    println!("{optimal} optimal, {infeasible} infeasible, {stalled} stalled");
    assert!(optimal > 3000 && infeasible > 300 && stalled < 20);
}

/// Rows over again with limits of their own, and rows and variables in units up to a million times as large: the same
/// cost as with variables.
#[test]
fn doubled_rows_and_other_units_change_nothing() {
    let (mut optimal, mut stalled) = (0, 0);
    for seed in 0..1500 {
        let (qp, compliance) = problem(seed);
        let (n, m) = (qp.n(), qp.m());
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut unit = || 10_f64.powi(rng.random_range(-3..=3));
        let units: Vec<f64> = (0..n).map(|_| unit()).collect();
        let scaled = |i: usize| -> Vec<f64> {
            let row = qp.row(i).iter().zip(&units);
            row.map(|(a, unit)| a * unit).collect()
        };
        let capacity = Capacity {
            vars: n,
            rows: 2 * m,
        };
        let mut double = Qp::new(capacity);
        double.reset((0..n as u32).map(VarId::new)).expect("fits");
        for i in 0..n {
            for j in 0..n {
                double.h_mut()[i * n + j] = qp.h()[i * n + j] * units[i] * units[j];
            }
            double.g_mut()[i] = qp.g()[i] * units[i];
        }
        let mut gives = Vec::new();
        for i in 0..2 * m {
            let (at, by) = (i % m, unit());
            // The second time it asks for something else, and gives.
            let beyond = if i < m { 0.0 } else { 0.5 };
            let lower = (qp.row_lower()[at] + beyond) * by;
            let row = double.push(lower, (qp.row_upper()[at] + beyond) * by);
            let row = row.expect("fits");
            for (to, a) in row.iter_mut().zip(scaled(at)) {
                *to = a * by;
            }
            let c = if i < m {
                compliance[at]
            } else {
                compliance[at].max(1e-6)
            };
            gives.push(c * by * by);
        }
        let (lower, upper) = double.bounds_mut();
        for j in 0..n {
            (lower[j], upper[j]) = (-2.0 / units[j], 2.0 / units[j]);
        }
        let wide = with_variables(&double, &gives);
        let expected = answer(&wide);
        let room = Capacity {
            vars: n + 2 * m,
            rows: 2 * m,
        };
        let mut solver = ActiveSet::default();
        solver.bind(room).expect("is good");
        let mut out = Solution::new(room);
        let status = solver.solve_soft(&double, &gives, &mut out).expect("fits");
        if status == Status::Stalled {
            stalled += 1;
            continue;
        }
        assert_eq!(status, expected.status, "seed {seed}");
        if status != Status::Optimal {
            continue;
        }
        optimal += 1;
        let soft: Vec<usize> = (0..2 * m).filter(|i| gives[*i] > 0.0).collect();
        for (k, i) in soft.iter().enumerate() {
            out.x[n + k] = -gives[*i] * out.y[*i];
        }
        let (cost, least) = (wide.objective(&out.x), wide.objective(&expected.x));
        let size = 1.0 + least.abs();
        assert!(
            (cost - least).abs() < 1e-7 * size,
            "seed {seed}: {cost} {least}"
        );
    }
    println!("{optimal} optimal, {stalled} stalled");
    assert!(optimal > 1000 && stalled < 30);
}

#[test]
fn what_rows_give_is_finite_and_not_negative() {
    let (qp, compliance) = problem(1);
    let mut solver = ActiveSet::default();
    let mut out = Solution::new(qp.capacity());
    let unbound = solver.solve_soft(&qp, &compliance, &mut out);
    assert_eq!(unbound, Err(QpError::NotBound));
    solver.bind(qp.capacity()).expect("is good");
    let short = solver.solve_soft(&qp, &compliance[1..], &mut out);
    assert!(matches!(short, Err(QpError::Shape { .. })));
    for wrong in [-1.0, f64::NAN, f64::INFINITY] {
        let mut compliance = compliance.clone();
        compliance[0] = wrong;
        let refused = solver.solve_soft(&qp, &compliance, &mut out);
        assert!(matches!(refused, Err(QpError::Setting { .. })));
    }
}
