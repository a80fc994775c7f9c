//! A solver that has solved other problems answers as a new one does, to the bit: nothing of them is left.

use crate::families::{FAMILIES, draw};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use wbqp_qp::{ActiveSet, Budget, Capacity, Qp, QpSolver, Solution};

const LARGEST: usize = 32;
const ROWS: usize = 96;

fn new_solver() -> ActiveSet {
    let mut solver = ActiveSet::default();
    let capacity = Capacity {
        vars: LARGEST,
        rows: ROWS,
    };
    solver.bind(capacity).expect("the settings make sense");
    solver
}

/// What it answers from a cold start: status, iterations, and the bits of all numbers.
fn answer(solver: &mut ActiveSet, qp: &Qp) -> (String, u32, Vec<u64>) {
    let mut solution = Solution::new(qp.capacity());
    solver.reset();
    let status = solver.solve(qp, Budget::Configured, &mut solution);
    let numbers = solution.x.iter().chain(&solution.y).chain(&solution.z);
    let bits = numbers.map(|number| number.to_bits()).collect();
    (format!("{status:?}"), solution.iterations, bits)
}

/// Definite, of variables in groups that H does not connect, without equalities, and with many limits violated at the
/// minimiser.
fn in_groups(rng: &mut ChaCha8Rng) -> Qp {
    let (n, groups) = (rng.random_range(4..=LARGEST), rng.random_range(1..=4));
    let m = rng.random_range(0..=n);
    let mut h = vec![0.0; n * n];
    for i in 0..n {
        for j in 0..i {
            if i * groups / n == j * groups / n {
                h[i * n + j] = rng.random_range(-0.5..0.5);
                h[j * n + i] = h[i * n + j];
            }
        }
        h[i * n + i] = n as f64;
    }
    let mut number = |size: f64| rng.random_range(-size..size);
    let g: Vec<f64> = (0..n).map(|_| number(3.0 * n as f64)).collect();
    let a: Vec<f64> = (0..m * n).map(|_| number(1.0)).collect();
    let rows = (vec![f64::NEG_INFINITY; m], vec![0.5; m]);
    let bounds = (vec![-1.0; n], vec![1.0; n]);
    Qp::dense(&h, &g, &a, (&rows.0, &rows.1), (&bounds.0, &bounds.1)).expect("the shapes fit")
}

#[test]
fn nothing_of_other_problems_is_left() {
    let mut used = new_solver();
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut check = |qp: &Qp, name: &str| {
        let expected = answer(&mut new_solver(), qp);
        assert_eq!(answer(&mut used, qp), expected, "{name}");
    };
    for seed in 0..150 {
        check(&in_groups(&mut rng), &format!("in groups, {seed}"));
        let family = FAMILIES[seed as usize % FAMILIES.len()];
        let known = draw(family, seed, 24, 0.0);
        if known.qp.m() <= ROWS {
            check(&known.qp, &format!("{family:?} {seed}"));
        }
    }
}
