//! Random problems whose answers are known by construction. `WBQP_QP_PROBLEMS` sets how many of each family and range
//! of units, `WBQP_QP_LARGER` the same of larger ones, `WBQP_QP_FIRST` the first seed, `WBQP_QP_FAMILY` one family
//! alone.

use wbqp_qp::{
    ActiveSet, Budget, ConstraintId, Held, Optimality, Qp, QpSolver, Solution, Status, WarmStart,
};

use crate::{
    families::{FAMILIES, Family, Known, Truth, draw},
    judge::judge,
};

/// Exponents of the units.
const EXPONENTS: [f64; 3] = [0.0, 4.0, 8.0];

/// What was answered wrongly once, among some million: an optimum where the cost falls for ever, a ray with rounding of
/// a variable in a large unit, constraints let go by multipliers compared without their units; rays along which the
/// cost bends by the root of rounding, equalities at an angle of 1e-9, a limit violated because others implied it, a
/// proof of infeasibility that the rounding of its multipliers outweighs, limits at zero that contradicted one another
/// by rounding and were widened too far or not at all, equalities that did and hid that the cost falls for ever, and a
/// cost whose unit was that of the variables that move alone.
const ONCE_WRONG: [(Family, u64, f64); 28] = [
    (Family::Unbounded, 22034, 4.0),
    (Family::Unbounded, 539, 8.0),
    (Family::Unbounded, 214_994, 8.0),
    (Family::Regular, 19624, 4.0),
    (Family::Regular, 19624, 8.0),
    (Family::Degenerate, 6439, 4.0),
    (Family::Degenerate, 6439, 8.0),
    (Family::Semidefinite, 781, 4.0),
    (Family::Semidefinite, 781, 8.0),
    (Family::Unbounded, 289_792, 0.0),
    (Family::Unbounded, 83541, 4.0),
    (Family::Unbounded, 119_149, 4.0),
    (Family::Unbounded, 1_215_474, 4.0),
    (Family::Unbounded, 187_394, 8.0),
    (Family::NearlyDependent, 8067, 0.0),
    (Family::NearlyDependent, 28611, 4.0),
    (Family::NearlyDependent, 50_026_428, 4.0),
    (Family::NearlyDependent, 50_261_655, 0.0),
    (Family::AtZero, 91_014_276, 4.0),
    (Family::AtZero, 91_014_276, 8.0),
    (Family::AtZero, 50_052_333, 8.0),
    (Family::AtZero, 61_033_483, 4.0),
    (Family::AtZero, 61_033_483, 8.0),
    (Family::AtZero, 61_054_168, 8.0),
    (Family::AtZero, 61_071_196, 8.0),
    (Family::AtZero, 104_041_674, 8.0),
    (Family::Unbounded, 50_073_100, 4.0),
    (Family::Unbounded, 980_019_765, 8.0),
];

/// What is wrong with the answer to a random problem, and its iterations.
fn answer(family: Family, seed: u64, exponent: f64) -> (u32, Option<String>) {
    answer_of(
        &draw(family, seed, 16, exponent),
        &format!("{family:?} 1e±{exponent} {seed}"),
    )
}

fn answer_of(known: &Known, name: &str) -> (u32, Option<String>) {
    answer_as(&known.qp, known, name)
}

/// The same of the same problem in other numbers.
fn answer_as(qp: &Qp, known: &Known, name: &str) -> (u32, Option<String>) {
    let solution = solved(qp);
    let wrong = judge(known, &solution).err().map(|what| {
        let (n, m) = (known.qp.n(), known.qp.m());
        format!("{name} (n {n}, m {m}): {what}")
    });
    (solution.iterations, wrong)
}

/// A number from the environment.
fn number(key: &str, missing: u64) -> u64 {
    std::env::var(key).map_or(missing, |text| text.parse().expect("a number"))
}

/// Whether a family is to be run: `WBQP_QP_FAMILY` names one alone.
fn is_wanted(family: Family) -> bool {
    std::env::var("WBQP_QP_FAMILY").map_or(true, |name| format!("{family:?}") == name)
}

#[test]
fn what_was_wrong_once_is_right() {
    let wrong = |(family, seed, exponent)| answer(family, seed, exponent).1;
    let wrong: Vec<_> = ONCE_WRONG.into_iter().filter_map(wrong).collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn every_answer_is_right() {
    let (count, first) = (number("WBQP_QP_PROBLEMS", 300), number("WBQP_QP_FIRST", 0));
    let mut wrong = Vec::new();
    for family in FAMILIES.into_iter().filter(|family| is_wanted(*family)) {
        for exponent in EXPONENTS {
            let (mut iterations, mut before) = (0_u64, wrong.len());
            for seed in first..first + count {
                let (count, what) = answer(family, seed, exponent);
                iterations += u64::from(count);
                wrong.extend(what);
            }
            before = wrong.len() - before;
            eprintln!(
                "{family:?} 1e±{exponent}: {before} wrong, {:.1} iterations",
                iterations as f64 / count as f64
            );
        }
    }
    let shown = wrong
        .iter()
        .take(60)
        .cloned()
        .collect::<Vec<_>>()
        .join("\n");
    assert!(wrong.is_empty(), "{} wrong:\n{shown}", wrong.len());
}

/// Rows that contradict one another do so however far away the cost leads. By little, a point far away may satisfy them
/// within the tolerance; it is no ray.
#[test]
fn what_contradicts_itself_is_infeasible_where_the_cost_falls_too() {
    let (count, first) = (number("WBQP_QP_PROBLEMS", 300), number("WBQP_QP_FIRST", 0));
    for seed in first..first + count {
        let known = draw(Family::Unbounded, seed, 8, 0.0);
        let (free, n) = (&known.qp, known.qp.n());
        let gap = 10f64.powi(3 - i32::try_from(seed % 10).expect("is small"));
        let row: Vec<f64> = (0..n).map(|j| 1.0 + (j as f64) / 7.0).collect();
        let contradiction: Vec<f64> = row.iter().map(|a| -4.0 * a).collect();
        let a = [free.a(), &row, &contradiction].concat();
        let inf = f64::INFINITY;
        let lower = [free.row_lower(), &[-inf, -inf]].concat();
        let upper = [free.row_upper(), &[1.0, -4.0 - 4.0 * gap]].concat();
        let limits = (lower.as_slice(), upper.as_slice());
        let qp = Qp::dense(free.h(), free.g(), &a, limits, (free.lower(), free.upper()));
        let qp = qp.expect("has one shape");
        let solution = solved(&qp);
        if gap >= 1e-5 {
            assert_ne!(solution.status, Status::Unbounded, "{seed}, by {gap:e}");
        }
        if gap >= 0.1 {
            let units = vec![1.0; qp.m()];
            let known = Known {
                truth: Truth::Infeasible,
                row_units: units,
                qp,
                ..known
            };
            assert_eq!(judge(&known, &solution), Ok(()), "{seed}, by {gap:e}");
        }
    }
}

/// Coefficients, and a curvature, at rounding or not far from it, as the cosine of a right angle makes them: no limit
/// is violated, whatever unit they suggest for a variable that is between two bounds.
#[test]
fn faint_coefficients_let_nothing_be_violated() {
    let (count, first) = (number("WBQP_QP_PROBLEMS", 300), number("WBQP_QP_FIRST", 0));
    let mut unanswered = 0;
    for seed in first..first + count {
        let qp = draw(Family::Faint, seed, 16, 0.0).qp;
        let solution = solved(&qp);
        if matches!(solution.status, Status::Stalled | Status::IterationLimit) {
            unanswered += 1;
            continue;
        }
        assert_eq!(solution.status, Status::Optimal, "{seed}");
        let primal = Optimality::of(&qp, &solution).primal;
        assert!(primal <= 1e-9, "{seed}: {primal:e}");
    }
    assert!(unanswered * 50 <= count, "{unanswered} without an answer");
}

/// The answer of a solver that has solved nothing before.
pub(crate) fn solved(qp: &Qp) -> Solution {
    let mut solver = ActiveSet::default();
    solver.bind(qp.capacity()).expect("is good");
    let mut solution = Solution::new(qp.capacity());
    solver
        .solve(qp, Budget::Configured, &mut solution)
        .expect("fits");
    solution
}

/// The numbers by which other solvers' users say that there is no limit.
#[test]
fn a_limit_of_1e20_is_none() {
    let (count, first) = (number("WBQP_QP_PROBLEMS", 300), number("WBQP_QP_FIRST", 0));
    let mut wrong = Vec::new();
    for family in FAMILIES.into_iter().filter(|family| is_wanted(*family)) {
        for (seed, endless) in (first..first + count)
            .flat_map(|seed| [1e20, 1e30, f64::MAX].map(|endless| (seed, endless)))
        {
            let known = draw(family, seed, 12, 0.0);
            let mut qp = known.qp.clone();
            let (lower, upper) = qp.row_limits_mut();
            let rows = lower.iter_mut().zip(upper);
            rows.for_each(|(lower, upper)| close(lower, upper, endless));
            let (lower, upper) = qp.bounds_mut();
            let bounds = lower.iter_mut().zip(upper);
            bounds.for_each(|(lower, upper)| close(lower, upper, endless));
            let name = format!("{family:?} {seed}, {endless:e} for no limit");
            wrong.extend(answer_as(&qp, &known, &name).1);
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

fn close(lower: &mut f64, upper: &mut f64, endless: f64) {
    (*lower, *upper) = (lower.max(-endless), upper.min(endless));
}

/// More variables than loops of a known length are for, of which normals may touch a part.
#[test]
fn answers_to_larger_problems_are_right() {
    let count = number("WBQP_QP_LARGER", 40);
    let first = number("WBQP_QP_FIRST", 0);
    let mut wrong = Vec::new();
    for family in FAMILIES.into_iter().filter(|family| is_wanted(*family)) {
        for exponent in EXPONENTS {
            for seed in first..first + count {
                let known = draw(family, seed, 48, exponent);
                let name = format!("{family:?} 1e±{exponent} {seed} up to 48");
                wrong.extend(answer_of(&known, &name).1);
            }
        }
    }
    assert!(
        wrong.is_empty(),
        "{} wrong:\n{}",
        wrong.len(),
        wrong.join("\n")
    );
}

/// A row without coefficients has no part that is not zero, whatever the number of variables.
#[test]
fn a_row_without_coefficients_is_no_limit() {
    for n in [3, 12, 24] {
        let mut h = vec![0.0; n * n];
        h.iter_mut().step_by(n + 1).for_each(|h| *h = 1.0);
        let (g, a) = (vec![-1.0; n], vec![0.0; n]);
        let free = (vec![f64::NEG_INFINITY; n], vec![f64::INFINITY; n]);
        for limits in [(0.0, 0.0), (-1.0, 1.0), (1e-18, 1.0)] {
            let rows = (&[limits.0][..], &[limits.1][..]);
            let qp = Qp::dense(&h, &g, &a, rows, (&free.0, &free.1)).expect("the shapes fit");
            let mut solver = ActiveSet::default();
            solver.bind(qp.capacity()).expect("is good");
            let mut solution = Solution::new(qp.capacity());
            let status = solver.solve(&qp, Budget::Configured, &mut solution);
            assert_eq!(status, Ok(Status::Optimal), "{n} {limits:?}");
            assert!(solution.x.iter().all(|x| *x == 1.0), "{n} {limits:?}");
        }
    }
}

/// Whatever is remembered, constraints at any side with multipliers of any sign and size, decides how long a solve
/// takes, not what it answers.
#[test]
fn any_warm_start_ends_at_a_right_answer() {
    let multipliers = [1.0, -1.0, 0.0, 1e-300, 1e300, f64::NAN, f64::INFINITY];
    let mut wrong = Vec::new();
    for family in FAMILIES {
        for seed in 0..200 {
            let known = draw(family, seed, 16, 0.0);
            let qp = &known.qp;
            let rows = qp.rows().iter().map(|row| ConstraintId::Row(*row));
            let bounds = qp.vars().iter().map(|var| ConstraintId::Bound(*var));
            let mut start = WarmStart::with_capacity(qp.n() + qp.m());
            for (i, constraint) in rows.chain(bounds).enumerate() {
                // Some of them, some known; where the seed is a multiple of seven, all multipliers are.
                let draw = (i * 7919 + seed as usize * 104_729) % 101;
                if !draw.is_multiple_of(3) {
                    let side = if draw.is_multiple_of(2) { 1.0 } else { -1.0 };
                    let multiplier = if seed.is_multiple_of(7) {
                        side
                    } else {
                        multipliers[draw % 7]
                    };
                    start.push(Held {
                        constraint,
                        side,
                        multiplier,
                    });
                }
            }
            let mut solver = ActiveSet::default();
            solver.bind(qp.capacity()).expect("is good");
            solver.start_from(&start);
            let mut solution = Solution::new(qp.capacity());
            solver
                .solve(qp, Budget::Configured, &mut solution)
                .expect("fits");
            if let Err(what) = judge(&known, &solution) {
                wrong.push(format!("{family:?} {seed}: {what}"));
            }
        }
    }
    assert!(
        wrong.is_empty(),
        "{} wrong:\n{}",
        wrong.len(),
        wrong.join("\n")
    );
}

/// What relaxed ticks are solved with, and what small problems go to where products of normals lose too many digits.
#[test]
fn answers_by_reflections_are_right() {
    let mut wrong = Vec::new();
    for family in FAMILIES {
        for seed in 0..100 {
            let known = draw(family, seed, 16, 0.0);
            let mut solver = ActiveSet::by_reflections();
            solver.bind(known.qp.capacity()).expect("is good");
            let mut solution = Solution::new(known.qp.capacity());
            solver
                .solve(&known.qp, Budget::Configured, &mut solution)
                .expect("fits");
            if let Err(what) = judge(&known, &solution) {
                wrong.push(format!("{family:?} {seed}: {what}"));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
