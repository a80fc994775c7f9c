//! Quantiles of single solves of the sequences of [`qp.rs`](qp.rs), solvers in turn: Criterion gives means of many.
//! `cargo bench -p wbqp-tests --bench qp_medians`.

use std::{hint::black_box, time::Instant};

use wbqp::qp::{ActiveSet, Budget, Clarabel, Qp, QpSolver, Solution, Status};
use wbqp_tests::qp_sequences::{Demand, aerial, humanoid};

/// Problems per sequence.
const TICKS: usize = 1000;
/// How often it is gone through.
const ROUNDS: usize = 20;
/// Problems that a solver takes in one go.
const BLOCK: usize = 100;
/// The interior point takes every so many of them.
const SPARSE: usize = 50;

/// A solver and what its solves took, µs.
struct Entrant {
    name: &'static str,
    solver: Box<dyn QpSolver>,
    solution: Solution,
    every: usize,
    is_cold: bool,
    times: Vec<f64>,
    /// Those of them in which at most two constraints became active or ceased to be.
    alike: Vec<f64>,
    active: Vec<bool>,
}

impl Entrant {
    fn new(name: &'static str, mut solver: Box<dyn QpSolver>, problems: &[Qp]) -> Self {
        let capacity = problems[0].capacity();
        solver.bind(capacity).expect("settings are good");
        Self {
            name,
            solver,
            solution: Solution::new(capacity),
            every: 1,
            is_cold: false,
            times: Vec::new(),
            alike: Vec::new(),
            active: Vec::new(),
        }
    }

    fn solve(&mut self, qp: &Qp) {
        if self.is_cold {
            self.solver.reset();
        }
        let start = Instant::now();
        let status = self
            .solver
            .solve(black_box(qp), Budget::Configured, &mut self.solution);
        let time = start.elapsed().as_secs_f64() * 1e6;
        assert_eq!(status, Ok(Status::Optimal));
        self.times.push(time);
        let multipliers = self.solution.y.iter().chain(&self.solution.z);
        let active: Vec<bool> = multipliers.map(|multiplier| *multiplier != 0.0).collect();
        let changes = active.iter().zip(&self.active).filter(|(a, b)| a != b);
        if active.len() == self.active.len() && changes.count() <= 2 {
            self.alike.push(time);
        }
        self.active = active;
    }
}

fn race(name: &str, problems: &[Qp]) {
    let native = || Box::<ActiveSet>::default();
    let mut entrants = [
        Entrant::new("active set, warm", native(), problems),
        Entrant {
            is_cold: true,
            ..Entrant::new("active set, cold", native(), problems)
        },
        Entrant {
            every: SPARSE,
            ..Entrant::new("Clarabel", Box::<Clarabel>::default(), problems)
        },
    ];
    for round in 0..ROUNDS {
        let forwards = round % 2 == 0;
        // In turn by blocks: each has its data in the caches, and what disturbs the machine disturbs all.
        for block in (0..problems.len()).step_by(BLOCK) {
            for entrant in &mut entrants {
                for turn in (block..block + BLOCK).step_by(entrant.every) {
                    let back = problems.len() - 1 - turn;
                    entrant.solve(&problems[if forwards { turn } else { back }]);
                }
            }
        }
    }
    println!("{name}, µs");
    let warm = quantiles(&mut entrants[0].times)[0];
    for entrant in &mut entrants {
        let [p50, p90, p99] = quantiles(&mut entrant.times);
        let ratio = p50 / warm;
        let name = entrant.name;
        println!(
            "  {name:<18} p50 {p50:>9.2}  p90 {p90:>9.2}  p99 {p99:>9.2}  {ratio:>6.1} × warm"
        );
    }
    let share = 100.0 * entrants[0].alike.len() as f64 / entrants[0].times.len() as f64;
    let [p50, p90, p99] = quantiles(&mut entrants[0].alike);
    println!(
        "  warm, ± 2 active   p50 {p50:>9.2}  p90 {p90:>9.2}  p99 {p99:>9.2}  {share:>6.1} % of them"
    );
}

fn quantiles(times: &mut [f64]) -> [f64; 3] {
    times.sort_by(f64::total_cmp);
    [0.5, 0.9, 0.99].map(|share| times[(share * (times.len() - 1) as f64) as usize])
}

fn main() {
    race("12 variables, 5 rows", &aerial(TICKS, Demand::Swelling));
    race(
        "60 variables, 18 equalities, 70 rows",
        &humanoid(TICKS, Demand::Swelling),
    );
}
