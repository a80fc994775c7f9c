//! From the plug-ins' rows to the quadratic program: the stage of a tick in a recorded closed loop.
//! `cargo bench -p wbqp-tests --bench assembly`.

mod common;

use std::time::{Duration, Instant};

use criterion::{Criterion, criterion_group, criterion_main};
use wbqp::stopwatch::Stopwatch;

use common::{Recording, WORKLOADS};

#[derive(Debug)]
struct Clock(Instant);

impl Stopwatch for Clock {
    fn now(&mut self) -> f64 {
        self.0.elapsed().as_secs_f64()
    }
}

fn assembly(c: &mut Criterion) {
    let mut group = c.benchmark_group("assembly");
    for (name, robot, contact) in WORKLOADS {
        let mut recording = Recording::new(robot, contact, "active_set");
        let clock = Box::new(Clock(Instant::now()));
        recording.controller = recording.controller.with_stopwatch(clock);
        group.bench_function(name, |b| {
            // The stage is not public: what the tick's own stopwatch says of it.
            b.iter_custom(|ticks| {
                let stages: f64 = (0..ticks).map(|_| recording.tick().assembly).sum();
                Duration::from_secs_f64(stages)
            });
        });
    }
    group.finish();
}

criterion_group!(benches, assembly);
criterion_main!(benches);
