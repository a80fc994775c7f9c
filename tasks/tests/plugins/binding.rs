//! What `bind` accepts and how it refuses.

use wbqp::{
    contact::ContactKind,
    controller::Probe,
    error::BindError,
    plugin::{AnyConstraint, AnyPlugin, AnyTask, Layout},
};
use wbqp_tasks::{
    ActuatorLimits, Axis, BaseOrientation, BasePosition, CentroidalAngularMomentum, Com,
    ConstantForce, ContactForce, ContactMotion, ContactWrench, FrameOrientation, FramePose,
    FramePosition, FreeMotion, FrictionPyramid, Hold, JointLimits, JointTorqueRegularisation,
    MinJerk, PlaneDistance, Posture, PropellerRegularisation, RelativePose, SurfaceAxis,
    ThrustRateLimits, ThrustRegularisation, TiltLimit, Waypoint, Waypoints,
};

use crate::robot::{contacts, small};

fn bind<P: AnyPlugin + ?Sized>(plugin: &P) -> Result<Layout, BindError> {
    let (robot, mut contacts) = (small(), contacts());
    let mut tilt = contacts[0].clone();
    "tilting".clone_into(&mut tilt.name);
    tilt.kind = ContactKind::NormalTilt;
    contacts.push(tilt);
    let probe = Probe::new(plugin, &robot, &contacts, 0.004)?;
    Ok(probe.layout().clone())
}

fn task(task: impl AnyTask) -> Result<Layout, BindError> {
    let task: Box<dyn AnyTask> = Box::new(task);
    bind(&*task)
}

fn constraint(constraint: impl AnyConstraint) -> Result<Layout, BindError> {
    let constraint: Box<dyn AnyConstraint> = Box::new(constraint);
    bind(&*constraint)
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
fn row_counts_beyond_the_paper() {
    assert_eq!(rows(task(FramePosition::new("tip", 1.0, 1.0))), 3);
    let level = FramePosition::new("tip", [1.0, 2.0], 1.0).along([Axis::X, Axis::Y]);
    assert_eq!(rows(task(level)), 2);
    assert_eq!(rows(task(FrameOrientation::new("tip", 1.0, 1.0))), 3);
    assert_eq!(rows(task(FramePose::new("tip", [1.0; 6], 1.0))), 6);
    assert_eq!(rows(task(RelativePose::new("tip", "base", 1.0, 1.0))), 6);
    assert_eq!(rows(task(Com::new(1.0, 1.0).along([Axis::Z]))), 1);
    assert_eq!(rows(task(CentroidalAngularMomentum::new(1.0))), 3);
    assert_eq!(rows(task(JointTorqueRegularisation::new())), 1);
    assert_eq!(rows(task(ThrustRegularisation::new())), 6);
    assert_eq!(rows(task(ConstantForce::new("tilting", 5.0))), 3);
    assert_eq!(rows(constraint(JointLimits::new(10.0))), 1);
    assert_eq!(rows(constraint(ThrustRateLimits::new(10.0))), 0);
    let plane = PlaneDistance::new("tip", [0.0; 3], [0.0, 0.0, 2.0]);
    assert_eq!(rows(constraint(plane)), 1);
    assert_eq!(rows(constraint(TiltLimit::new(0.3))), 8);
    let sole = ContactWrench::new("tilting", 0.1, 0.05);
    assert_eq!(rows(constraint(sole)), 4);
}

#[test]
fn refusals_beyond_the_paper_name_the_key() {
    let mut sideways = ConstantForce::new("sliding", 5.0);
    sideways.tangential = [0.0, 1.0];
    let plane = |normal| PlaneDistance::new("tip", [0.0; 3], normal);
    for (start, refused) in [
        (
            "frame `tp` does not exist; did you mean `tip`?",
            task(FramePosition::new("tp", 1.0, 1.0)),
        ),
        (
            "`axes` names `x` twice",
            task(Com::new(1.0, 1.0).along([Axis::X, Axis::X])),
        ),
        ("`axes` has 0 entries", task(Com::new(1.0, 1.0).along([]))),
        (
            "`kd` has 3 entries",
            task(FramePose::new("tip", 1.0, [1.0; 3])),
        ),
        (
            "`position.duration` is 0",
            task(FramePose::new("tip", 1.0, 1.0).moving(MinJerk::new([0.0; 3], 0.0))),
        ),
        (
            "`orientation.value` has 2 entries",
            task(RelativePose::new("tip", "base", 1.0, 1.0).turning(Hold::at([0.0; 2]))),
        ),
        (
            "`relative_to` is `tip`, the frame itself",
            task(RelativePose::new("tip", "tip", 1.0, 1.0)),
        ),
        (
            "`reference.value` has 2 entries",
            task(JointTorqueRegularisation::new().following(Hold::at([0.0; 2]))),
        ),
        (
            "`joints` names `elbow` twice",
            task(JointTorqueRegularisation::new().only(["elbow", "elbow"])),
        ),
        ("`tangential` has y = 1", task(sideways)),
        ("`normal` is -1", task(ConstantForce::new("sliding", -1.0))),
        ("`acceleration` is 0", constraint(JointLimits::new(0.0))),
        (
            "`margin` is 2.5, which leaves joint `elbow` no range",
            constraint(JointLimits::new(1.0).with_margin(2.5)),
        ),
        ("`rise` is 0", constraint(ThrustRateLimits::new(0.0))),
        (
            "rotor `rotor0` has no `slew`",
            constraint(ThrustRateLimits::default()),
        ),
        ("`normal` is zero", constraint(plane([0.0; 3]))),
        (
            "`a2` is 300 1/s, must be at most 250",
            constraint(plane([0.0, 0.0, 1.0]).with_rates(1.0, 300.0)),
        ),
        ("`max_tilt` is 1.6 rad", constraint(TiltLimit::new(1.6))),
        (
            "`half_length_x` is 0",
            constraint(ContactWrench::new("tilting", 0.0, 0.1)),
        ),
        (
            "`contact` `point` has no moments to limit; use `friction_pyramid`",
            constraint(ContactWrench::new("point", 0.1, 0.1)),
        ),
    ] {
        let error = refused.expect_err(start).to_string();
        assert!(error.starts_with(start), "{error} / {start}");
    }
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
        ("`kd` is -1", task(BasePosition::new(1.0, -1.0))),
        ("`integral_limit` is 0", task(limit)),
        ("`kd` is NaN", task(BaseOrientation::new(1.0, f64::NAN))),
        (
            "`reference.to` has 2 entries",
            task(BaseOrientation::new(1.0, 1.0).following(MinJerk::new([0.0, 0.0], 1.0))),
        ),
        (
            "`reference.duration` is 0",
            task(Posture::new(1.0, 1.0).following(MinJerk::new([0.0], 0.0))),
        ),
        (
            "`reference.value[0]` is NaN",
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

#[test]
fn a_force_that_a_surface_would_have_to_pull_with_is_refused() {
    let pull = "a surface pushes and never pulls, a normal force is 0 or more";
    let force = || ContactForce::new("sliding", 5.0);
    for (asked, key, number) in [
        (ContactForce::new("sliding", -5.0), "reference.value", -5.0),
        (
            force().following(MinJerk::new([-2.0], 1.0)),
            "reference.to",
            -2.0,
        ),
        (
            force().following(MinJerk::new([2.0], 1.0).starting_at([-1.0])),
            "reference.from",
            -1.0,
        ),
        (
            force().following(Waypoints::new([
                Waypoint::new(0.0, [0.0]),
                Waypoint::new(1.0, [-3.0]),
            ])),
            "reference.points[1].value",
            -3.0,
        ),
    ] {
        let refused = task(asked).expect_err("pulls");
        let expected = BindError::value(key, format!("is {number} N: {pull}"));
        assert_eq!(refused, expected);
    }
    task(ContactForce::new("sliding", 0.0)).expect("asks for nothing");
    let refused = task(ContactForce::new("sliding", 1e9)).expect_err("more than the contact bears");
    let most = "is 1000000000 N, more than the contact's `force_max` of 20 N";
    assert_eq!(refused, BindError::value("reference.value", most));
}
