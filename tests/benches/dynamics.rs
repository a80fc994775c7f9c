//! Kinematics, M, h, and the Jacobian and J̇v of one frame: what a tick needs of the dynamics.
//! `cargo bench -p wbqp-tests --bench dynamics`.

use std::hint::black_box;

use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use wbqp::{
    dynamics::{Data, FrameKinematics},
    robot::RobotModel,
};
use wbqp_robots::{humanoid, othex, quadruped};

fn dynamics(c: &mut Criterion) {
    let robots = [
        (othex(), "tool"),
        (quadruped(), "fl_foot"),
        (humanoid(), "left_sole"),
    ];
    let mut group = c.benchmark_group("dynamics");
    for (robot, frame) in robots {
        let RobotModel {
            model, home: state, ..
        } = robot.expect("ships");
        let frame = model.frame(frame).expect("exists");
        let mut data = Data::new(&model);
        let mut kinematics = FrameKinematics::new(&model);
        let name = format!("{}, {} dof", model.name(), model.nv());
        group.bench_function(format!("{name}, set"), |b| {
            b.iter(|| {
                data.update(&model, black_box(&state));
                kinematics.update(&model, &data, frame);
                black_box((&data, &kinematics));
            });
        });
        group.bench_function(format!("{name}, kinematics"), |b| {
            b.iter_batched_ref(
                || (),
                |()| data.update_kinematics(&model, black_box(&state)),
                BatchSize::SmallInput,
            );
        });
    }
    group.finish();
}

criterion_group!(benches, dynamics);
criterion_main!(benches);
