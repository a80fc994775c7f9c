//! The active-set solver on random problems, judged by certificates: an optimum by the optimality conditions and the
//! cost known by construction, an infeasible problem by a Farkas combination.

use wbqp::{
    qp::{
        ActiveSet, Budget, Capacity, Clarabel, Optimality, Qp, QpSolver, RowId, Solution, Status,
        VarId, WarmStart,
    },
    stopwatch::Stopwatch,
};
use wbqp_tests::random_qp::{FAMILIES, Family, Known, random_qp};

/// Errors of the optimality conditions relative to the numbers that they are made of. A violation is divided by the
/// largest of the limit, the sum of the terms' magnitudes, and one: a limit near zero is no nearer to the others'
/// rounding.
fn relative_errors(known: &Known, s: &Solution) -> [f64; 3] {
    let qp = &known.qp;
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
        for (excess, limit) in [(value - upper, upper), (lower - value, lower)] {
            if excess > 0.0 {
                primal = primal.max(excess / size.max(limit.abs()));
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
            size.max(known.one.0[i]),
            qp.row_lower()[i],
            qp.row_upper()[i],
            s.y[i],
        );
    }
    for j in 0..n {
        let size = s.x[j].abs().max(known.one.1[j]);
        side(s.x[j], size, qp.lower()[j], qp.upper()[j], s.z[j]);
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
    let errors = relative_errors(known, s);
    let [stationarity, primal, complementarity] = errors;
    if !(stationarity < 1e-8 && primal < 1e-10 && complementarity < 1e-8) {
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
    // WBQP_RANDOM_PROBLEMS sets another number: 140 000 of each family were seen to pass.
    let count: u64 =
        std::env::var("WBQP_RANDOM_PROBLEMS").map_or(3000, |c| c.parse().expect("a number"));
    let mut wrong = Vec::new();
    let mut iterations = [0_u64; FAMILIES.len()];
    for (f, family) in FAMILIES.into_iter().enumerate() {
        for seed in 0..count {
            let known = random_qp(family, seed, 24);
            let mut solver = ActiveSet::default();
            solver.bind(known.qp.capacity()).expect("is good");
            let mut solution = Solution::new(known.qp.capacity());
            solver
                .solve(&known.qp, Budget::Configured, &mut solution)
                .expect("fits");
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

/// What the solver claims of a problem that cannot be computed is true, and it seldom gives up.
#[test]
fn nearly_dependent_rows_are_never_answered_falsely() {
    let count: u64 =
        std::env::var("WBQP_RANDOM_PROBLEMS").map_or(3000, |c| c.parse().expect("a number"));
    let (mut wrong, mut without) = (Vec::new(), 0);
    for seed in 0..count {
        let known = random_qp(Family::NearlyDependent, seed, 24);
        let mut solver = ActiveSet::default();
        solver.bind(known.qp.capacity()).expect("is good");
        let mut solution = Solution::new(known.qp.capacity());
        solver
            .solve(&known.qp, Budget::Configured, &mut solution)
            .expect("fits");
        // Multipliers of 1e7 carry a rounding of their own; the point has none.
        let tolerances = match solution.status {
            Status::Optimal => [1e-6, 1e-10, 1e-5],
            Status::Stalled => {
                without += 1;
                continue;
            }
            status => {
                wrong.push(format!("{seed}: {status:?}"));
                continue;
            }
        };
        let errors = relative_errors(&known, &solution);
        if !errors.iter().zip(tolerances).all(|(e, t)| *e < t) {
            wrong.push(format!("{seed}: {:?}, errors {errors:?}", solution.status));
        }
    }
    assert!(
        wrong.is_empty(),
        "{} wrong:\n{}",
        wrong.len(),
        wrong.join("\n")
    );
    assert!(
        without * 100 < count,
        "{without} of {count} without an answer"
    );
}

/// A problem of two variables; rows are `(id, coefficients, lower, upper)`.
fn small(h: [f64; 4], g: [f64; 2], rows: &[(u32, [f64; 2], f64, f64)]) -> Qp {
    let mut qp = Qp::new(Capacity { vars: 2, rows: 4 });
    qp.reset([0, 1].map(VarId::new)).expect("ascend");
    qp.h_mut().copy_from_slice(&h);
    qp.cost_mut().1.copy_from_slice(&g);
    for (id, a, lower, upper) in rows {
        let row = qp.push_row(RowId::new(*id), *lower, *upper);
        row.expect("fits").copy_from_slice(a);
    }
    qp
}

fn solver(qp: &Qp) -> (ActiveSet, Solution) {
    let mut solver = ActiveSet::default();
    solver.bind(qp.capacity()).expect("is good");
    (solver, Solution::new(qp.capacity()))
}

const INF: f64 = f64::INFINITY;

#[test]
fn a_cost_without_minimum_is_unbounded() {
    // Flat along (1, −1), where the cost falls.
    let qp = small(
        [1.0, 1.0, 1.0, 1.0],
        [1.0, 0.0],
        &[(0, [1.0, 1.0], -1.0, 1.0)],
    );
    let (mut active_set, mut solution) = solver(&qp);
    active_set
        .solve(&qp, Budget::Configured, &mut solution)
        .expect("fits");
    assert_eq!(solution.status, Status::Unbounded);
    // A limit across that direction makes it bounded.
    let qp = small(
        [1.0, 1.0, 1.0, 1.0],
        [1.0, 0.0],
        &[(0, [1.0, -1.0], -4.0, INF)],
    );
    active_set
        .solve(&qp, Budget::Configured, &mut solution)
        .expect("fits");
    assert_eq!(solution.status, Status::Optimal);
    assert!(Optimality::of(&qp, &solution).worst() < 1e-9);
}

#[test]
fn numbers_that_are_not_finite_fail() {
    for bad in [f64::NAN, INF] {
        for place in 0..3 {
            let (mut h, mut g, mut a) = ([2.0, 0.0, 0.0, 2.0], [1.0, 1.0], [1.0, 1.0]);
            match place {
                0 => h[0] = bad,
                1 => g[1] = bad,
                _ => a[0] = bad,
            }
            let qp = small(h, g, &[(0, a, 1.0, 1.0)]);
            let (mut active_set, mut solution) = solver(&qp);
            active_set
                .solve(&qp, Budget::Configured, &mut solution)
                .expect("fits");
            assert_eq!(
                solution.status,
                Status::Invalid,
                "{place} {bad}: {solution:?}"
            );
        }
    }
}

/// The second of two equal rows is found to be implied by the first. What it is then violated by counts.
#[test]
fn rows_that_disagree_a_little_have_no_optimum() {
    let h = [2.0, 0.0, 0.0, 2.0];
    for power in -140..=-60 {
        let gap = 10f64.powf(0.1 * f64::from(power));
        for equal in [true, false] {
            // Either two values, or at most one and at least one and the gap.
            let (lower, upper) = if equal { (1.0, 1.0 + gap) } else { (-INF, INF) };
            let rows = [
                (0, [1.0, 1.0], lower, 1.0),
                (1, [1.0, 1.0], 1.0 + gap, upper),
            ];
            let qp = small(h, [-4.0, -4.0], &rows);
            let (mut active_set, mut solution) = solver(&qp);
            active_set
                .solve(&qp, Budget::Configured, &mut solution)
                .expect("fits");
            let violation = Optimality::of(&qp, &solution).primal;
            match solution.status {
                Status::Optimal => assert!(violation <= 1.01e-10, "{gap:e}: {violation:e}"),
                Status::Infeasible => assert!(gap > 1e-10, "{gap:e}"),
                status => panic!("{gap:e}: {status:?}"),
            }
        }
    }
}

#[test]
fn a_warm_start_survives_rows_that_come_and_go() {
    // The nearest point to (2, 2) below both rows; then a row in front of them goes away.
    let below = |id, a| (id, a, -INF, 1.0);
    let all = [
        below(1, [1.0, 0.1]),
        below(5, [1.0, 0.0]),
        below(7, [0.0, 1.0]),
    ];
    let h = [2.0, 0.0, 0.0, 2.0];
    let qp = small(h, [-4.0, -4.0], &all);
    let (mut active_set, mut solution) = solver(&qp);
    active_set
        .solve(&qp, Budget::Configured, &mut solution)
        .expect("fits");
    let cold = solution.iterations;
    assert!((solution.x[0] - 0.9).abs() < 1e-15 && (solution.x[1] - 1.0).abs() < 1e-15);
    active_set
        .solve(&qp, Budget::Configured, &mut solution)
        .expect("fits");
    assert!(solution.iterations < cold, "{} {cold}", solution.iterations);
    let fewer = small(h, [-4.0, -4.0], &all[1..]);
    active_set
        .solve(&fewer, Budget::Configured, &mut solution)
        .expect("fits");
    assert_eq!((solution.x[0], solution.x[1]), (1.0, 1.0));
    assert!(solution.iterations < cold);
    active_set.reset();
    active_set
        .solve(&fewer, Budget::Configured, &mut solution)
        .expect("fits");
    let (mut fresh, mut other) = solver(&fewer);
    fresh
        .solve(&fewer, Budget::Configured, &mut other)
        .expect("fits");
    assert_eq!(solution.iterations, other.iterations, "forgets");
}

#[test]
fn a_cap_on_iterations_is_kept() {
    let known = random_qp(Family::Degenerate, 44, 24);
    let mut active_set = ActiveSet::default();
    active_set.max_iterations = Some(2);
    active_set.bind(known.qp.capacity()).expect("is good");
    let mut solution = Solution::new(known.qp.capacity());
    active_set
        .solve(&known.qp, Budget::Configured, &mut solution)
        .expect("fits");
    assert_eq!(solution.status, Status::IterationLimit);
    assert!(solution.x.iter().all(|x| x.is_finite()));
    active_set.max_iterations = Some(0);
    assert!(active_set.bind(known.qp.capacity()).is_err());
}

/// A clock on which every look takes a second.
#[derive(Debug, Default)]
struct Ticking(f64);

impl Stopwatch for Ticking {
    fn now(&mut self) -> f64 {
        self.0 += 1.0;
        self.0
    }
}

#[test]
fn what_a_clock_stopped_is_repeated_by_its_iterations() {
    let (mut stopped, mut finished) = (0, 0);
    for family in FAMILIES {
        for seed in 0..60 {
            let known = random_qp(family, seed, 24);
            let capacity = known.qp.capacity();
            let (mut first, mut one) = solver(&known.qp);
            first.budget = Some(4.5);
            // Twice, so that the second begins with what the first held.
            let mut start = WarmStart::with_capacity(capacity.vars);
            first
                .solve(&known.qp, Budget::Configured, &mut one)
                .expect("fits");
            first.warm_start(&mut start);
            if seed % 2 == 0 {
                first.reset();
                start.clear();
            }
            first
                .solve(&known.qp, Budget::Clock(&mut Ticking::default()), &mut one)
                .expect("fits");
            let (mut again, mut other) = solver(&known.qp);
            again.start_from(&start);
            again
                .solve(&known.qp, Budget::Iterations(one.iterations), &mut other)
                .expect("fits");
            assert_eq!(one.status, other.status, "{family:?} {seed}");
            assert_eq!(one.iterations, other.iterations);
            let bits = |s: &Solution| -> Vec<u64> {
                let numbers = s.x.iter().chain(&s.y).chain(&s.z);
                numbers.map(|v| v.to_bits()).collect()
            };
            assert_eq!(bits(&one), bits(&other), "{family:?} {seed}");
            if one.status == Status::TimeLimit {
                stopped += 1;
                assert!(one.x.iter().all(|x| x.is_finite()));
                // What was reached is where the next one goes on.
                first
                    .solve(&known.qp, Budget::Configured, &mut one)
                    .expect("fits");
                assert!(!one.status.was_cut_short());
            } else {
                finished += 1;
            }
        }
    }
    assert!(stopped > 30 && finished > 30, "{stopped} {finished}");
    let mut active_set = ActiveSet::default();
    for budget in [0.0, -1.0, f64::NAN, INF] {
        active_set.budget = Some(budget);
        assert!(active_set.bind(Capacity { vars: 2, rows: 2 }).is_err());
    }
}

#[test]
fn a_problem_without_variables_is_its_limits() {
    for (lower, upper, status) in [(-1.0, 1.0, Status::Optimal), (1.0, 2.0, Status::Infeasible)] {
        let mut qp = Qp::new(Capacity { vars: 2, rows: 1 });
        qp.push_row(RowId::new(0), lower, upper).expect("fits");
        let (mut active_set, mut solution) = solver(&qp);
        active_set
            .solve(&qp, Budget::Configured, &mut solution)
            .expect("fits");
        assert_eq!(solution.status, status);
    }
}

#[test]
fn agrees_with_the_interior_point() {
    for family in FAMILIES {
        for seed in 0..60 {
            let known = random_qp(family, seed, 12);
            let (mut active_set, mut one) = solver(&known.qp);
            active_set
                .solve(&known.qp, Budget::Configured, &mut one)
                .expect("fits");
            let mut clarabel = Clarabel::default();
            clarabel.bind(known.qp.capacity()).expect("is good");
            let mut other = Solution::new(known.qp.capacity());
            clarabel
                .solve(&known.qp, Budget::Configured, &mut other)
                .expect("fits");
            if other.status != Status::Optimal {
                // The interior point's own limits; infeasibility must not be contradicted.
                assert!(other.status != Status::Infeasible || one.status == Status::Infeasible);
                continue;
            }
            assert_eq!(one.status, Status::Optimal, "{family:?} {seed}");
            let (a, b) = (known.qp.objective(&one.x), known.qp.objective(&other.x));
            assert!(
                (a - b).abs() < 1e-8 * (1.0 + a.abs()),
                "{family:?} {seed}: {a} {b}"
            );
        }
    }
}
