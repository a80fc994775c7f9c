//! Mimic joints: everything is what the free tree's is, seen through `v_free = G v`.
#![allow(non_snake_case)]

use proptest::prelude::*;
use wbqp::{
    dynamics::{Data, FrameKinematics},
    model::{Base, Joint, JointKind, JointLimits, Model, ModelBuilder},
    nalgebra::{DMatrix, Isometry3, Vector3},
    state::State,
};
use wbqp_tests::{
    properties::cases,
    random_model::{Scatter, coupled_model, freed, random_state},
};

/// The same configuration and velocity of the free tree.
fn freed_state(model: &Model, state: &State) -> (Model, DMatrix<f64>, State) {
    let (free, G, g) = freed(model);
    let offset = model.joint_offset();
    let joints = G.view(
        (offset, offset),
        (free.joints().len(), model.joints().len()),
    );
    let state = State {
        q: joints * &state.q + g,
        v: &G * &state.v,
        ..state.clone()
    };
    (free, G, state)
}

proptest! {
    #![proptest_config(cases(200))]

    #[test]
    fn everything_is_the_free_trees_through_g(seed: u64, floating: bool, joints in 2_usize..=12) {
        let base = if floating { Base::Floating } else { Base::Fixed };
        let model = coupled_model(seed, base, joints);
        prop_assert!(!model.mimics().is_empty());
        let state = random_state(seed, &model, 2.0);
        let (free, G, free_state) = freed_state(&model, &state);
        let (mut data, mut expected) = (Data::new(&model), Data::new(&free));
        data.update(&model, &state);
        expected.update(&free, &free_state);
        let same = |a: &DMatrix<f64>, b: &DMatrix<f64>| (a - b).amax() <= 1e-12 * (1.0 + b.amax());
        prop_assert!(same(data.mass_matrix(), &(G.transpose() * expected.mass_matrix() * &G)));
        let column = |v: &[f64]| DMatrix::from_column_slice(v.len(), 1, v);
        let h = G.transpose() * expected.bias();
        prop_assert!(same(&column(data.bias().as_slice()), &column(h.as_slice())));
        let g = G.transpose() * expected.gravity();
        prop_assert!(same(&column(data.gravity().as_slice()), &column(g.as_slice())));
        prop_assert!((data.center_of_mass() - expected.center_of_mass()).norm() < 1e-12);
        prop_assert!((data.centroidal_momentum() - expected.centroidal_momentum()).norm() < 1e-11);
        prop_assert!((data.center_of_mass_bias() - expected.center_of_mass_bias()).norm() < 1e-11);
        let com = expected.center_of_mass_jacobian() * &G;
        prop_assert!((data.center_of_mass_jacobian() - com).norm() < 1e-12);
        let (mut own, mut theirs) = (FrameKinematics::new(&model), FrameKinematics::new(&free));
        for i in 0..model.bodies().len() {
            let name = format!("tool{i}");
            own.update(&model, &data, model.frame(&name).expect("made"));
            theirs.update(&free, &expected, free.frame(&name).expect("made"));
            prop_assert!((own.p_WF - theirs.p_WF).norm() < 1e-12);
            prop_assert!((own.v_WF - theirs.v_WF).norm() + (own.w_WF - theirs.w_WF).norm() < 1e-11);
            prop_assert!((&own.J - &theirs.J * &G).norm() < 1e-12);
            prop_assert!((own.Jdot_v - theirs.Jdot_v).norm() < 1e-10 * (1.0 + theirs.Jdot_v.norm()));
        }
    }

    /// A leader is within its limits if and only if it and its followers are within theirs.
    #[test]
    fn the_tighter_limit_counts(seed: u64) {
        let mut s = Scatter::new(seed);
        let range = |s: &mut Scatter| {
            let middle = s.number(-0.5, 0.5);
            [middle - s.number(0.3, 2.0), middle + s.number(0.3, 2.0)]
        };
        let limits = |s: &mut Scatter| {
            let [lower, upper] = range(s);
            JointLimits { lower, upper, velocity: s.number(0.1, 2.0), effort: s.number(0.1, 2.0) }
        };
        let (own, followers) = (limits(&mut s), limits(&mut s));
        let multiplier = if s.chance(0.5) { s.number(0.3, 2.0) } else { -s.number(0.3, 2.0) };
        let offset = s.number(-0.2, 0.2);
        let build = gripper(own, followers, [multiplier, offset]);
        let feasible = |q: f64| {
            let follower = multiplier * q + offset;
            q >= own.lower && q <= own.upper && follower >= followers.lower && follower <= followers.upper
        };
        let grid = || (0..=4000).map(|k| f64::from(k).mul_add(1e-3, -2.0));
        match build {
            Ok(model) => {
                let both = model.joints()[0].limits;
                for q in grid() {
                    let near = (q - both.lower).abs().min((q - both.upper).abs()) < 1e-9;
                    prop_assert!(near || feasible(q) == (q >= both.lower && q <= both.upper), "{q}");
                }
                let ratio = multiplier.abs();
                prop_assert_eq!(both.velocity, own.velocity.min(followers.velocity / ratio));
                prop_assert_eq!(both.effort, own.effort.min(followers.effort * ratio));
            }
            Err(error) => {
                prop_assert!(grid().all(|q| !feasible(q)));
                prop_assert!(error.to_string().contains("never both within their ranges"), "{error}");
            }
        }
    }
}

fn gripper(
    own: JointLimits,
    followers: JointLimits,
    relation: [f64; 2],
) -> Result<Model, wbqp::model::ModelError> {
    let mut s = Scatter::new(1);
    let joint = |name: &str, limits| {
        Joint::new(
            name,
            JointKind::Prismatic,
            Vector3::y_axis(),
            Isometry3::identity(),
            limits,
        )
    };
    let mut builder = ModelBuilder::new("gripper", Base::Fixed, "palm", s.inertia());
    let palm = builder.base();
    builder.mimic_body(
        palm,
        joint("right", followers),
        "left",
        relation,
        "right_pad",
        s.inertia(),
    );
    builder.body(palm, joint("left", own), "left_pad", s.inertia());
    builder.build()
}

#[test]
fn followers_of_followers_follow_the_first_and_circles_are_refused() {
    let free = JointLimits {
        lower: f64::NEG_INFINITY,
        upper: f64::INFINITY,
        velocity: f64::INFINITY,
        effort: f64::INFINITY,
    };
    let mut s = Scatter::new(2);
    let joint = |name: &str| {
        Joint::new(
            name,
            JointKind::Revolute,
            Vector3::x_axis(),
            Isometry3::identity(),
            free,
        )
    };
    let mut builder = ModelBuilder::new("finger", Base::Fixed, "palm", s.inertia());
    let palm = builder.base();
    let tip = builder.mimic_body(palm, joint("tip"), "middle", [3.0, 0.5], "t", s.inertia());
    builder.mimic_body(tip, joint("middle"), "root", [-2.0, 0.1], "m", s.inertia());
    builder.body(palm, joint("root"), "r", s.inertia());
    let mut circle = builder.clone();
    let model = builder.build().expect("a chain");
    let tip = &model.mimics()[0];
    assert_eq!(model.joints()[tip.leader.index()].name, "root");
    assert!((tip.multiplier + 6.0).abs() < 1e-15 && (tip.offset - 0.8).abs() < 1e-15);

    circle.mimic_body(palm, joint("a"), "b", [1.0, 0.0], "a", s.inertia());
    circle.mimic_body(palm, joint("b"), "a", [1.0, 0.0], "b", s.inertia());
    let error = circle.build().expect_err("a circle").to_string();
    assert!(error.contains("joint `a`: follows itself"), "{error}");
}
