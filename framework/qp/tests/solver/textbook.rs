//! Problems that other fields pose, with data drawn at random: what they have in common is in no family.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use wbqp_qp::{Qp, Solution, Status};

use crate::{known_answers::solved, units::in_other_units};

/// Problems of each kind.
const COUNT: u64 = 1500;

/// The dual of a support vector machine with a linear kernel: curvature of a rank that is much smaller than the number
/// of variables, which are so large that their terms hide what the cost is in all other directions.
fn support_vector_machine(rng: &mut ChaCha8Rng) -> Qp {
    let (n, features) = (rng.random_range(4..30), rng.random_range(1..5));
    let mut symmetric = |_| rng.random_range(-1.0..1.0_f64);
    let points: Vec<Vec<f64>> = (0..n)
        .map(|_| (0..features).map(&mut symmetric).collect())
        .collect();
    // Separable but for some: two labels in any case.
    let labels: Vec<f64> = (0..n)
        .map(|k| {
            let side = points[k][0] + 0.3 * symmetric(k);
            if k == 0 || (k > 1 && side > 0.0) {
                1.0
            } else {
                -1.0
            }
        })
        .collect();
    let kernel = |k: usize| {
        let (i, j) = (k / n, k % n);
        let product: f64 = points[i].iter().zip(&points[j]).map(|(a, b)| a * b).sum();
        labels[i] * labels[j] * product
    };
    let h: Vec<f64> = (0..n * n).map(kernel).collect();
    let most = 10f64.powf(rng.random_range(3.0..5.0));
    Qp::dense(
        &h,
        &vec![-1.0; n],
        &labels,
        (&[0.0], &[0.0]),
        (&vec![0.0; n], &vec![most; n]),
    )
    .expect("has the shapes")
}

/// The cheapest flow through a network, some of whose edges have no capacity.
fn flow(rng: &mut ChaCha8Rng) -> Qp {
    let nodes = rng.random_range(3..9);
    let edges = rng.random_range(nodes..3 * nodes);
    let mut incidence = vec![0.0; nodes * edges];
    for edge in 0..edges {
        let from = rng.random_range(0..nodes);
        let to = (from + rng.random_range(1..nodes)) % nodes;
        incidence[from * edges + edge] = 1.0;
        incidence[to * edges + edge] = -1.0;
    }
    let capacities: Vec<f64> = (0..edges)
        .map(|_| f64::from(rng.random_range(0..5_u8)))
        .collect();
    let some: Vec<f64> = capacities
        .iter()
        .map(|most| f64::from(rng.random_range(0..=*most as u8)))
        .collect();
    let supply: Vec<f64> = incidence
        .chunks_exact(edges)
        .map(|row| row.iter().zip(&some).map(|(a, x)| a * x).sum())
        .collect();
    let costs: Vec<f64> = (0..edges)
        .map(|_| f64::from(rng.random_range(-3..4_i8)))
        .collect();
    Qp::dense(
        &vec![0.0; edges * edges],
        &costs,
        &incidence,
        (&supply, &supply),
        (&vec![0.0; edges], &capacities),
    )
    .expect("has the shapes")
}

/// What is wrong with a solution: a limit that does not hold, a gradient that is left, a multiplier that pushes away
/// from its limit; each relative to its terms.
fn fault(qp: &Qp, solution: &Solution) -> Option<String> {
    let (n, m) = (qp.n(), qp.m());
    if solution.status != Status::Optimal {
        return Some(format!("{:?}", solution.status));
    }
    let x = &solution.x[..n];
    let rows = (0..m).map(|i| {
        let terms = || qp.row(i).iter().zip(x).map(|(a, x)| a * x);
        let size: f64 = terms().map(f64::abs).sum();
        let limits = (qp.row_lower()[i], qp.row_upper()[i]);
        (terms().sum(), size, limits, solution.y[i])
    });
    let bounds = (0..n).map(|j| {
        let limits = (qp.lower()[j], qp.upper()[j]);
        (x[j], x[j].abs(), limits, solution.z[j])
    });
    for (value, size, (lower, upper), multiplier) in rows.chain(bounds) {
        let limit = if multiplier > 0.0 { upper } else { lower };
        let close = 1e-9 * (size + lower.abs().max(upper.abs()));
        if value > upper + close || value < lower - close {
            return Some(format!("{lower} ≤ {value} ≤ {upper}"));
        }
        if multiplier != 0.0 && (value - limit).abs() > close {
            return Some(format!("{multiplier} at {value} of {lower} to {upper}"));
        }
    }
    (0..n).find_map(|j| {
        let curvature = qp.h()[j * n..(j + 1) * n].iter().zip(x);
        let pushes = (0..m).map(|i| qp.row(i)[j] * solution.y[i]);
        let terms: Vec<f64> = curvature
            .map(|(h, x)| h * x)
            .chain(pushes)
            .chain([qp.g()[j], solution.z[j]])
            .collect();
        let (left, size): (f64, f64) = (terms.iter().sum(), terms.iter().map(|t| t.abs()).sum());
        (left.abs() > 1e-9 * size).then(|| format!("gradient {left} of {size} along {j}"))
    })
}

#[test]
fn support_vector_machines_are_trained() {
    for seed in 0..COUNT {
        let qp = support_vector_machine(&mut ChaCha8Rng::seed_from_u64(seed));
        let fault = fault(&qp, &solved(&qp));
        assert_eq!(fault, None, "seed {seed}");
    }
}

#[test]
fn flows_are_found_in_any_units() {
    for seed in 0..COUNT {
        let rng = &mut ChaCha8Rng::seed_from_u64(seed);
        let qp = flow(rng);
        let least = qp.objective(&solved(&qp).x);
        let (scaled, units) = in_other_units(&qp, rng);
        let solution = solved(&scaled);
        assert_eq!(solution.status, Status::Optimal, "seed {seed}");
        let x: Vec<f64> = solution.x.iter().zip(&units).map(|(x, d)| x * d).collect();
        let error = (qp.objective(&x) - least).abs();
        assert!(error <= 1e-8 * least.abs().max(1.0), "seed {seed}: {error}");
    }
}
