//! From the plug-ins' rows to the quadratic program: the stage of a tick in a recorded closed loop.
//! `cargo bench -p wbqp-tests --bench assembly`.

mod common;

use std::time::Duration;

use criterion::{Criterion, criterion_group, criterion_main};

use common::{Recording, WORKLOADS, duration};

fn assembly(c: &mut Criterion) {
    let mut group = c.benchmark_group("assembly");
    for (name, robot, contact) in WORKLOADS {
        let mut recording = Recording::new(robot, contact, "active_set").with_stopwatch();
        group.bench_function(name, |b| {
            // The stage is not public: what the tick's own stopwatch says of it.
            b.iter_custom(|ticks| {
                let stages = (0..ticks).map(|_| recording.tick().assembly);
                stages.map(duration).sum::<Duration>()
            });
        });
    }
    group.finish();
}

criterion_group!(benches, assembly);
criterion_main!(benches);
