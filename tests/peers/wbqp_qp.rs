//! wbqp's solver on the problems of a file, as `qp.py` asks: the counterpart of `qp_peer.cpp`.
//!
//! ```text
//! wbqp_qp FILE
//! ```
//!
//! reads lines from standard input: `warm A B` and `cold A B` solve the problems from A to B in order and answer with
//! the nanoseconds of each; `write FILE` writes what the last solve of every problem has found: whether it says
//! optimal, iterations, the number of active limits that are no equalities, x. A warm start begins anew where a
//! sequence does.

use std::{
    env,
    error::Error,
    fs::File,
    hint::black_box,
    io::{BufWriter, Write, stdin, stdout},
    path::Path,
    time::Instant,
};

use wbqp::input;
use wbqp::qp::{ActiveSet, Budget, Capacity, Qp, QpSolver, Solution, Status};
use wbqp_tests::qp_ticks::{self, Tick};

type Result<T> = std::result::Result<T, Box<dyn Error>>;

/// What a solve has found.
#[derive(Clone, Debug, Default)]
struct Outcome {
    is_optimal: bool,
    iterations: u32,
    active: usize,
    x: Vec<f64>,
}

impl Outcome {
    fn of(qp: &Qp, solution: &Solution) -> Self {
        let equal = qp
            .row_lower()
            .iter()
            .zip(qp.row_upper())
            .map(|(l, u)| l == u);
        let rows = solution.y.iter().zip(equal);
        let rows = rows.filter(|(y, is_equality)| **y != 0.0 && !is_equality);
        let bounds = solution.z.iter().take(qp.n()).filter(|z| **z != 0.0);
        Self {
            is_optimal: solution.status == Status::Optimal,
            iterations: solution.iterations,
            active: rows.count() + bounds.count(),
            x: solution.x[..qp.n()].to_vec(),
        }
    }
}

fn solver(capacity: Capacity) -> Result<ActiveSet> {
    let mut solver = ActiveSet::default();
    solver.bind(capacity)?;
    Ok(solver)
}

/// Reads all of a problem, as whoever has just assembled it has it in the caches.
fn touch(qp: &Qp) -> f64 {
    let limits = [qp.row_lower(), qp.row_upper(), qp.lower(), qp.upper()];
    let lists = [qp.h(), qp.g(), qp.a()].into_iter().chain(limits);
    lists.flatten().sum()
}

fn main() -> Result<()> {
    let path = env::args().nth(1).ok_or("wbqp_qp FILE")?;
    let bytes = input::read(Path::new(&path), input::LARGEST_RECORD)?;
    let ticks = qp_ticks::read(&mut bytes.as_slice())?;
    let capacity = ticks
        .first()
        .ok_or("the file has no problem")?
        .qp
        .capacity();
    // Each has its own memory: a cold solve must not disturb what the warm one starts from.
    let (mut warm, mut cold) = (solver(capacity)?, solver(capacity)?);
    let mut solution = Solution::new(capacity);
    let mut outcomes = vec![Outcome::default(); ticks.len()];
    for line in stdin().lines() {
        let line = line?;
        let words: Vec<&str> = line.split_whitespace().collect();
        let answer = match words[..] {
            ["write", file] => {
                write(&mut BufWriter::new(File::create(file)?), &outcomes)?;
                "done".to_owned()
            }
            [method @ ("warm" | "cold"), from, to] => {
                let (from, to) = (from.parse()?, to.parse()?);
                let range: &[Tick] = ticks.get(from..to).ok_or("no such problems")?;
                let mut spent = String::new();
                for (Tick { is_first, qp }, outcome) in range.iter().zip(&mut outcomes[from..to]) {
                    let solver = if method == "warm" {
                        &mut warm
                    } else {
                        &mut cold
                    };
                    if *is_first || method == "cold" {
                        solver.reset();
                    }
                    black_box(touch(qp));
                    let start = Instant::now();
                    let solved = solver.solve(black_box(qp), Budget::Configured, &mut solution);
                    spent += &format!("{} ", start.elapsed().as_nanos());
                    solved?;
                    *outcome = Outcome::of(qp, &solution);
                }
                spent
            }
            _ => {
                return Err(
                    format!("`METHOD A B` or `write FILE` is expected, not `{line}`").into(),
                );
            }
        };
        writeln!(stdout(), "{answer}")?;
        stdout().flush()?;
    }
    Ok(())
}

fn write(to: &mut impl Write, outcomes: &[Outcome]) -> Result<()> {
    for o in outcomes {
        write!(
            to,
            "{} {} {}",
            u8::from(o.is_optimal),
            o.iterations,
            o.active
        )?;
        for x in &o.x {
            write!(to, " {x:e}")?;
        }
        writeln!(to)?;
    }
    Ok(to.flush()?)
}
