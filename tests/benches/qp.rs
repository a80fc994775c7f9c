//! One solve of a quadratic program, of a sequence as consecutive ticks pose it: the active set, warm (it begins with
//! what was active in the problem before) and cold (it begins with nothing), beside the interior point.
//! `cargo bench -p wbqp-tests --bench qp`.

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use wbqp::qp::{ActiveSet, Budget, Clarabel, Qp, QpSolver, Solution, Status};
use wbqp_tests::qp_sequences::{Demand, aerial, humanoid};

/// Problems per sequence.
const TICKS: usize = 1000;

#[derive(Clone, Copy, PartialEq)]
enum Start {
    Warm,
    Cold,
}

fn solves(c: &mut Criterion) {
    let sequences = [
        ("12 variables, 5 rows", aerial(TICKS, Demand::Swelling)),
        (
            "60 variables, 18 equalities, 70 rows",
            humanoid(TICKS, Demand::Swelling),
        ),
    ];
    for (name, problems) in sequences {
        let mut group = c.benchmark_group(name);
        let mut bench = |id: &str, mut solver: Box<dyn QpSolver>, start: Start| {
            let capacity = problems[0].capacity();
            solver.bind(capacity).expect("settings are good");
            let mut solution = Solution::new(capacity);
            let mut turn = there_and_back(&problems);
            group.bench_function(id, |b| {
                b.iter(|| {
                    if start == Start::Cold {
                        solver.reset();
                    }
                    let qp = black_box(turn.next().expect("never ends"));
                    let status = solver.solve(qp, Budget::Configured, &mut solution);
                    assert_eq!(status, Ok(Status::Optimal));
                });
            });
        };
        bench("active set, warm", Box::<ActiveSet>::default(), Start::Warm);
        bench("active set, cold", Box::<ActiveSet>::default(), Start::Cold);
        bench("Clarabel", Box::<Clarabel>::default(), Start::Cold);
        group.finish();
    }
}

/// To the end of a sequence and back again, so that it never jumps.
fn there_and_back(problems: &[Qp]) -> impl Iterator<Item = &Qp> {
    problems.iter().chain(problems.iter().rev()).cycle()
}

criterion_group!(benches, solves);
criterion_main!(benches);
