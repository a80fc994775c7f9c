//! What `bind` accepts and how it refuses.

use wbqp::{
    constraint::Constraint,
    contact::ContactKind,
    layout::Layout,
    setup::{BindError, Setup},
    task::Task,
};
use wbqp_tasks::{
    ActuatorLimits, BaseOrientation, BasePosition, ContactForce, ContactMotion, FreeMotion,
    FrictionPyramid, Hold, MinJerk, Posture, PropellerRegularisation, SurfaceAxis,
};

use crate::robot::{contacts, small};

fn with_setup<T>(bind: impl FnOnce(&mut Setup<'_>) -> T) -> T {
    let (robot, mut contacts, mut frames) = (small(), contacts(), Vec::new());
    let mut tilt = contacts[0].clone();
    "tilting".clone_into(&mut tilt.name);
    tilt.kind = ContactKind::NormalTilt;
    contacts.push(tilt);
    bind(&mut Setup::new(&robot, &contacts, 0.004, &mut frames))
}

fn task(mut task: impl Task) -> Result<Layout, BindError> {
    with_setup(|setup| task.bind(setup))
}

fn constraint(mut constraint: impl Constraint) -> Result<Layout, BindError> {
    with_setup(|setup| constraint.bind(setup))
}

fn rows(layout: Result<Layout, BindError>) -> usize {
    layout.unwrap_or_else(|e| panic!("{e}")).len()
}

#[test]
fn row_counts() {
    assert_eq!(rows(task(BasePosition::new(1.0, [1.0, 2.0, 3.0]))), 3);
    assert_eq!(rows(task(BaseOrientation::new(1.0, 1.0))), 3);
    assert_eq!(rows(task(Posture::new([1.0], 1.0).only(["elbow"]))), 1);
    assert_eq!(rows(task(FreeMotion::new("sliding", 1.0, 1.0))), 2);
    assert_eq!(rows(task(FreeMotion::new("tilting", 1.0, 1.0))), 2);
    let along_y = FreeMotion::new("sliding", [1.0], 1.0).along([SurfaceAxis::Y]);
    assert_eq!(rows(task(along_y)), 1);
    assert_eq!(rows(task(ContactForce::new("sliding", 5.0))), 1);
    assert_eq!(rows(task(ContactForce::new("point", 5.0))), 3);
    assert_eq!(rows(task(PropellerRegularisation::new())), 5);
    assert_eq!(rows(constraint(ActuatorLimits::new())), 0);
    assert_eq!(rows(constraint(FrictionPyramid::new("sliding"))), 0);
    assert_eq!(
        rows(constraint(FrictionPyramid::new("point").with_sides(6))),
        6
    );
    assert_eq!(rows(constraint(ContactMotion::new("point"))), 3);
    assert_eq!(rows(constraint(ContactMotion::new("sliding"))), 1);
}

#[test]
fn refusals_name_the_key() {
    let sliding = || FreeMotion::new("sliding", 1.0, 1.0);
    let mut limit = BasePosition::new(1.0, 1.0);
    limit.integral_limit = 0.0;
    for (start, refused) in [
        (
            "`kp` has 2 entries",
            task(BasePosition::new([1.0, 2.0], 1.0)),
        ),
        ("`kd` contains -1", task(BasePosition::new(1.0, -1.0))),
        ("`integral_limit` is 0", task(limit)),
        (
            "`kd` contains NaN",
            task(BaseOrientation::new(1.0, f64::NAN)),
        ),
        (
            "`reference.to` has 2 entries",
            task(BaseOrientation::new(1.0, 1.0).following(MinJerk::new([0.0, 0.0], 1.0))),
        ),
        (
            "`reference.duration` is 0",
            task(Posture::new(1.0, 1.0).following(MinJerk::new([0.0], 0.0))),
        ),
        (
            "`reference.value` contains NaN",
            task(Posture::new(1.0, 1.0).following(Hold::at([f64::NAN]))),
        ),
        (
            "joint `elbov` does not exist; did you mean `elbow`?",
            task(Posture::new(1.0, 1.0).only(["elbov"])),
        ),
        (
            "`joints` names `elbow` twice",
            task(Posture::new(1.0, 1.0).only(["elbow", "elbow"])),
        ),
        (
            "`joints` has 0 entries",
            task(Posture::new(1.0, 1.0).only::<&str>([])),
        ),
        (
            "`contact` `point` leaves no translation free",
            task(FreeMotion::new("point", 1.0, 1.0)),
        ),
        (
            "`axes` contains `x`, which `point` constrains",
            task(FreeMotion::new("point", 1.0, 1.0).along([SurfaceAxis::X])),
        ),
        (
            "`axes` names `y` twice",
            task(sliding().along([SurfaceAxis::Y, SurfaceAxis::Y])),
        ),
        ("`axes` has 0 entries", task(sliding().along([]))),
        (
            "`kp` is 1, must be below 1",
            task(ContactForce::new("sliding", 5.0).with_gains(1.0, 1.0)),
        ),
        (
            "`ki` is -1",
            task(ContactForce::new("sliding", 5.0).with_gains(0.1, -1.0)),
        ),
        (
            "contact `slidin` does not exist; did you mean `sliding`?",
            task(ContactForce::new("slidin", 5.0)),
        ),
        (
            "`sides` is 2",
            constraint(FrictionPyramid::new("point").with_sides(2)),
        ),
        (
            "`damping` is inf",
            constraint(ContactMotion::new("point").damped(f64::INFINITY)),
        ),
    ] {
        let error = refused.expect_err(start).to_string();
        assert!(error.starts_with(start), "{error} / {start}");
    }
}
