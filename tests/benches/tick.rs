//! Whole ticks of recorded closed loops, with the native solver and with Clarabel.
//! `cargo bench -p wbqp-tests --bench tick`.

mod common;

use criterion::{Criterion, criterion_group, criterion_main};

use common::{Recording, WORKLOADS};

fn tick(c: &mut Criterion) {
    let mut group = c.benchmark_group("tick");
    for (name, robot, contact) in WORKLOADS {
        for solver in ["active_set", "clarabel"] {
            let mut recording = Recording::new(robot, contact, solver);
            group.bench_function(format!("{name}/{solver}"), |b| {
                b.iter(|| {
                    recording.tick();
                });
            });
        }
    }
    group.finish();
}

criterion_group!(benches, tick);
criterion_main!(benches);
