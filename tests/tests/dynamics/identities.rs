//! The equations that M, h, J, J̇v, inverse and forward dynamics have to satisfy, on random trees.
//!
//! # Notation
//! World-aligned `v = [v_WR; w_WR; q̇]`; finite differences move the configuration with `State::advance`.
#![allow(non_snake_case)]

use std::fmt;

use proptest::prelude::*;
use wbqp::{
    dynamics::{
        Data, FrameKinematics, JointDrive, Wrenches, energy, forward_dynamics,
        forward_dynamics_of_servos, frame_motion, inverse_dynamics, point_motion,
    },
    model::{Base, FrameId, Model},
    nalgebra::{DVector, Point3, Quaternion, UnitQuaternion, Vector3, Vector6},
    spatial,
    state::State,
};
use wbqp_tests::{
    properties::cases,
    random_model::{Scatter, coupled_model, random_model, random_state},
};

/// Forward dynamics, of either kind.
type Solve = fn(&Model, &mut Data, &[JointDrive], &Wrenches, &mut DVector<f64>, &mut DVector<f64>);

/// A random tree and a random state of it.
struct Case {
    seed: u64,
    model: Model,
    state: State,
}

/// Enough to build the case again.
impl fmt::Debug for Case {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let joints = self.model.joints().len();
        write!(
            f,
            "{}_model({}, {:?}, {joints})",
            self.model.name(),
            self.seed,
            self.model.base()
        )
    }
}

fn robots() -> impl Strategy<Value = Case> {
    (any::<u64>(), any::<bool>(), 0_usize..=12).prop_map(|(seed, floating, joints)| {
        let (base, joints) = if floating {
            (Base::Floating, joints)
        } else {
            (Base::Fixed, joints.max(1))
        };
        // Every third tree has mimic joints.
        let model = match seed % 3 {
            0 => coupled_model(seed, base, joints),
            _ => random_model(seed, base, joints),
        };
        let state = random_state(seed, &model, 2.0);
        Case { seed, model, state }
    })
}

fn updated(model: &Model, state: &State) -> Data {
    let mut data = Data::new(model);
    data.update(model, state);
    data
}

/// The configuration after `dt` of motion with `v`, at the velocity of `state`.
fn moved(model: &Model, state: &State, v: &DVector<f64>, dt: f64) -> State {
    let mut moved = state.clone();
    moved.advance(model, v, dt);
    moved
}

fn tools(model: &Model) -> Vec<FrameId> {
    let names = (0..model.bodies().len()).map(|i| format!("tool{i}"));
    names
        .map(|n| model.frame(&n).expect("made by the generator"))
        .collect()
}

/// `‖a − b‖ ≤ tolerance (1 + ‖a‖ + ‖b‖)`.
fn close(a: &DVector<f64>, b: &DVector<f64>, tolerance: f64) -> Result<(), TestCaseError> {
    let error = (a - b).norm();
    prop_assert!(
        error <= tolerance * (1.0 + a.norm() + b.norm()),
        "off by {error:e}:\n{a}{b}"
    );
    Ok(())
}

fn dynamic(x: &[f64]) -> DVector<f64> {
    DVector::from_row_slice(x)
}

proptest! {
    #![proptest_config(cases(200))]

    #[test]
    fn mass_matrix_is_symmetric_positive_definite(Case { model, state, .. } in robots()) {
        let data = updated(&model, &state);
        let M = data.mass_matrix();
        prop_assert_eq!((M - M.transpose()).amax(), 0.0);
        prop_assert!(M.clone().cholesky().is_some());
        let kinetic = 0.5 * state.v.dot(&(M * &state.v));
        let sum = energy(&model, &data).kinetic;
        prop_assert!((kinetic - sum).abs() <= 1e-12 * (1.0 + sum));
    }

    #[test]
    fn inverse_dynamics_is_mass_matrix_and_bias(Case { seed, model, state } in robots()) {
        let mut data = updated(&model, &state);
        let mut s = Scatter::new(seed);
        let vdot = s.vector(model.nv(), 5.0);
        let mut wrenches = Wrenches::new(&model);
        let mut expected = data.mass_matrix() * &vdot + data.bias();
        let mut tool = FrameKinematics::new(&model);
        for frame in tools(&model) {
            tool.update(&model, &data, frame);
            let (force, moment) = (s.vector3(10.0), s.vector3(3.0));
            let body = model.frames()[frame.index()].body;
            wrenches.add_wrench(&data, body, &tool.p_WF, &force, &moment);
            let w = dynamic(Vector6::from_fn(|i, _| if i < 3 { force[i] } else { moment[i - 3] }).as_slice());
            expected -= tool.J.transpose() * w;
        }
        let mut tau = DVector::zeros(model.nv());
        inverse_dynamics(&model, &mut data, &vdot, &wrenches, &mut tau);
        close(&tau, &expected, 1e-12)?;
    }

    #[test]
    fn gravity_is_the_bias_at_rest(Case { model, mut state, .. } in robots()) {
        let moving = updated(&model, &state);
        state.v.fill(0.0);
        let still = updated(&model, &state);
        close(still.bias(), moving.gravity(), 1e-13)?;
    }

    #[test]
    fn gravity_is_minus_the_slope_of_potential_energy(Case { model, state, .. } in robots()) {
        let data = updated(&model, &state);
        let dt = 1e-5;
        for i in 0..model.nv() {
            let mut v = DVector::zeros(model.nv());
            v[i] = 1.0;
            let at = |dt| {
                let data = updated(&model, &moved(&model, &state, &v, dt));
                energy(&model, &data).potential
            };
            let slope = (at(dt) - at(-dt)) / (2.0 * dt);
            prop_assert!((data.gravity()[i] - slope).abs() < 1e-7 * (1.0 + data.gravity().norm()));
        }
    }

    #[test]
    fn frame_velocity_is_jacobian_times_v(Case { model, state, .. } in robots()) {
        let data = updated(&model, &state);
        let mut k = FrameKinematics::new(&model);
        for frame in tools(&model) {
            k.update(&model, &data, frame);
            let Jv = &k.J * &state.v;
            close(&dynamic(Jv.as_slice()), &dynamic(&[k.v_WF.as_slice(), k.w_WF.as_slice()].concat()), 1e-13)?;
            let motion = frame_motion(&model, &data, frame);
            prop_assert_eq!((motion.p_WF, motion.R_WF, motion.v_WF, motion.w_WF), (k.p_WF, k.R_WF, k.v_WF, k.w_WF));
            let body = model.frames()[frame.index()].body;
            let X_WF = data.body_pose(body) * model.frames()[frame.index()].X_BF;
            prop_assert!((X_WF.translation.vector - k.p_WF).norm() < 1e-14);
            prop_assert!((X_WF.rotation.to_rotation_matrix().matrix() - k.R_WF.matrix()).norm() < 1e-14);
        }
    }

    #[test]
    fn jacobian_is_the_derivative_of_the_pose(Case { model, state, .. } in robots()) {
        let dt = 1e-5;
        let mut k = FrameKinematics::new(&model);
        let data = updated(&model, &state);
        let pairs: Vec<_> = (0..model.nv()).map(|i| {
            let mut v = DVector::zeros(model.nv());
            v[i] = 1.0;
            [-dt, dt].map(|dt| updated(&model, &moved(&model, &state, &v, dt)))
        }).collect();
        for frame in tools(&model) {
            k.update(&model, &data, frame);
            for (i, pair) in pairs.iter().enumerate() {
                let [before, after] = pair.each_ref().map(|d| frame_motion(&model, d, frame));
                let linear = (after.p_WF - before.p_WF) / (2.0 * dt);
                let angular = spatial::vee((after.R_WF * before.R_WF.inverse()).matrix()) / (2.0 * dt);
                prop_assert!((k.J.column(i).fixed_rows::<3>(0) - linear).norm() < 1e-8);
                prop_assert!((k.J.column(i).fixed_rows::<3>(3) - angular).norm() < 1e-8);
            }
        }
    }

    #[test]
    fn bias_acceleration_is_the_derivative_of_velocity(Case { model, state, .. } in robots()) {
        let dt = 1e-5;
        let data = updated(&model, &state);
        let [before, after] = [-dt, dt].map(|dt| updated(&model, &moved(&model, &state, &state.v, dt)));
        let mut k = FrameKinematics::new(&model);
        for frame in tools(&model) {
            k.update(&model, &data, frame);
            let [b, a] = [&before, &after].map(|d| frame_motion(&model, d, frame));
            let linear = (a.v_WF - b.v_WF) / (2.0 * dt);
            let angular = (a.w_WF - b.w_WF) / (2.0 * dt);
            let size = 1.0 + k.Jdot_v.norm();
            prop_assert!((k.Jdot_v.fixed_rows::<3>(0) - linear).norm() < 1e-6 * size);
            prop_assert!((k.Jdot_v.fixed_rows::<3>(3) - angular).norm() < 1e-6 * size);
        }
    }

    #[test]
    fn centre_of_mass_moves_as_its_jacobian_says(Case { model, state, .. } in robots()) {
        let dt = 1e-5;
        let data = updated(&model, &state);
        let [before, after] = [-dt, dt].map(|dt| updated(&model, &moved(&model, &state, &state.v, dt)));
        let v_com = data.center_of_mass_velocity();
        let Jv = data.center_of_mass_jacobian() * &state.v;
        prop_assert!((Jv - v_com).norm() < 1e-12 * (1.0 + v_com.norm()));
        prop_assert!((v_com * model.mass() - data.centroidal_momentum().fixed_rows::<3>(0)).norm() < 1e-11);
        let velocity = (after.center_of_mass() - before.center_of_mass()) / (2.0 * dt);
        prop_assert!((velocity - v_com).norm() < 1e-7 * (1.0 + v_com.norm()));
        let rate = (after.center_of_mass_velocity() - before.center_of_mass_velocity()) / (2.0 * dt);
        let bias = data.center_of_mass_bias();
        prop_assert!((rate - bias).norm() < 1e-6 * (1.0 + bias.norm()));
    }

    /// With a floating base the external wrench alone changes the momentum, whatever the joints do.
    #[test]
    fn momentum_changes_by_gravity_and_wrenches(Case { seed, model, state } in robots()) {
        if model.base() == Base::Fixed {
            return Ok(());
        }
        let mut data = updated(&model, &state);
        let mut s = Scatter::new(seed);
        let joints = model.joints().len();
        let drives: Vec<_> = (0..joints).map(|_| JointDrive::Acceleration(s.number(-5.0, 5.0))).collect();
        let mut wrenches = Wrenches::new(&model);
        let last = model.body_id(joints).expect("last body");
        let (point, force) = (s.vector3(1.0), s.vector3(10.0));
        wrenches.add_force(&data, last, &point, &force);
        let (mut vdot, mut effort) = (DVector::zeros(model.nv()), DVector::zeros(joints));
        forward_dynamics(&model, &mut data, &drives, &wrenches, &mut vdot, &mut effort);

        let dt = 1e-5;
        let [before, after] = [-dt, dt].map(|dt| {
            let mut state = moved(&model, &state, &state.v, dt);
            state.v += &vdot * dt;
            updated(&model, &state).centroidal_momentum()
        });
        let rate = (after - before) / (2.0 * dt);
        let linear = force + model.gravity() * model.mass();
        let angular: Vector3<f64> = (point - data.center_of_mass()).cross(&force);
        let size = 1.0 + rate.norm() + data.centroidal_momentum().norm();
        prop_assert!((rate.fixed_rows::<3>(0) - linear).norm() < 1e-5 * size);
        prop_assert!((rate.fixed_rows::<3>(3) - angular).norm() < 1e-5 * size, "{} {}", rate, angular);
    }

    #[test]
    fn forward_dynamics_inverts_inverse_dynamics(Case { seed, model, state } in robots(), servo in 0.0..1.0) {
        let mut data = Data::new(&model);
        data.update_kinematics(&model, &state);
        let mut s = Scatter::new(seed);
        let (nv, joints) = (model.nv(), model.joints().len());
        let drives: Vec<_> = (0..joints).map(|_| if s.chance(servo) {
            JointDrive::Acceleration(s.number(-20.0, 20.0))
        } else {
            JointDrive::Effort(s.number(-5.0, 5.0))
        }).collect();
        let mut wrenches = Wrenches::new(&model);
        for i in 0..=joints {
            let body = model.body_id(i).expect("within the model");
            wrenches.add_wrench(&data, body, &s.vector3(1.0), &s.vector3(10.0), &s.vector3(2.0));
        }
        let (mut vdot, mut effort) = (DVector::zeros(nv), DVector::zeros(joints));
        forward_dynamics(&model, &mut data, &drives, &wrenches, &mut vdot, &mut effort);
        let offset = model.joint_offset();
        for (i, drive) in drives.iter().enumerate() {
            match drive {
                JointDrive::Effort(tau) => prop_assert_eq!(effort[i], *tau),
                JointDrive::Acceleration(a) => prop_assert_eq!(vdot[offset + i], *a),
            }
        }
        let mut tau = DVector::zeros(nv);
        inverse_dynamics(&model, &mut data, &vdot, &wrenches, &mut tau);
        let mut expected = DVector::zeros(nv);
        expected.rows_mut(offset, joints).copy_from(&effort);
        close(&tau, &expected, 1e-9)?;
    }

    /// With servos at all joints, or some, or none.
    #[test]
    fn servoed_robots_move_as_the_general_ones(Case { seed, model, state } in robots(), servos in 0.0..4.0) {
        let mut data = Data::new(&model);
        data.update_kinematics(&model, &state);
        let mut s = Scatter::new(seed);
        let (nv, joints) = (model.nv(), model.joints().len());
        let drives: Vec<_> = (0..joints).map(|_| if s.chance(f64::min(servos, 1.0)) {
            JointDrive::Acceleration(s.number(-20.0, 20.0))
        } else {
            JointDrive::Effort(s.number(-5.0, 5.0))
        }).collect();
        let [mut wrenches, mut of_bodies] = [(); 2].map(|()| Wrenches::new(&model));
        for i in 0..=joints {
            let body = model.body_id(i).expect("within the model");
            let (point, force, moment) = (s.vector3(1.0), s.vector3(10.0), s.vector3(2.0));
            wrenches.add_wrench(&data, body, &point, &force, &moment);
            // The same in the body's own axes, about its origin.
            let pose = data.body_pose(body);
            let moment = moment + (point - pose.translation.vector).cross(&force);
            let [force, moment] = [force, moment].map(|x| pose.rotation.inverse() * x);
            of_bodies.add_body_wrench(&data, body, &force, &moment);
            let at = point_motion(&data, body, &(pose.inverse() * Point3::from(point)).coords);
            prop_assert!((at.p_WQ - point).norm() < 1e-12 * (1.0 + pose.translation.vector.norm()));
        }
        let solve = |data: &mut Data, wrenches: &Wrenches, dynamics: Solve| {
            let (mut vdot, mut effort) = (DVector::zeros(nv), DVector::zeros(joints));
            dynamics(&model, data, &drives, wrenches, &mut vdot, &mut effort);
            (vdot, effort)
        };
        let (vdot, effort) = solve(&mut data, &wrenches, forward_dynamics);
        let (own, own_effort) = solve(&mut data, &of_bodies, forward_dynamics_of_servos);
        close(&own, &vdot, 1e-9)?;
        close(&own_effort, &effort, 1e-9)?;
    }

    #[test]
    fn a_point_of_a_body_moves_like_a_frame_there(Case { model, state, .. } in robots()) {
        let mut data = Data::new(&model);
        data.update_kinematics(&model, &state);
        for frame in model.frames() {
            let id = model.frame(&frame.name).expect("has it");
            let at = frame_motion(&model, &data, id);
            let own = point_motion(&data, frame.body, &frame.X_BF.translation.vector);
            prop_assert!((own.p_WQ - at.p_WF).norm() < 1e-12 * (1.0 + at.p_WF.norm()));
            prop_assert!((own.v_WQ - at.v_WF).norm() < 1e-12 * (1.0 + at.v_WF.norm()));
        }
    }

    #[test]
    fn not_a_number_comes_out_where_it_went_in(Case { model, mut state, .. } in robots()) {
        let joints = model.joints().len();
        let mut data = Data::new(&model);
        let (mut vdot, mut effort) = (DVector::zeros(model.nv()), DVector::zeros(joints));
        let drives = vec![JointDrive::Effort(f64::NAN); joints];
        data.update(&model, &state);
        forward_dynamics(&model, &mut data, &drives, &Wrenches::new(&model), &mut vdot, &mut effort);
        prop_assert!(vdot.iter().any(|x| x.is_nan()) || joints == 0);

        state.v[0] = f64::NAN;
        data.update(&model, &state);
        prop_assert!(data.center_of_mass_velocity().iter().any(|x| x.is_nan()));
        state.R_WR = UnitQuaternion::new_unchecked(Quaternion::new(f64::NAN, 0.0, 0.0, 0.0));
        data.update(&model, &state);
        prop_assert!(data.bias().iter().any(|x| x.is_nan()));
        forward_dynamics(&model, &mut data, &drives, &Wrenches::new(&model), &mut vdot, &mut effort);
        prop_assert!(vdot.iter().any(|x| x.is_nan()));
    }
}

/// One step of the classical Runge–Kutta method without drive. The stages move the configuration from the start
/// of the step; the base attitude is integrated in the rotation vector, whose rate is `w` up to the correction
/// `−½ θ × w + θ × (θ × w)/12` (enough for fourth order).
fn runge_kutta(model: &Model, data: &mut Data, state: &State, dt: f64) -> State {
    let nv = model.nv();
    let drives = vec![JointDrive::Effort(0.0); model.joints().len()];
    let wrenches = Wrenches::new(model);
    let mut effort = DVector::zeros(model.joints().len());
    let mut slopes: Vec<(DVector<f64>, DVector<f64>)> = Vec::new();
    for stage in [0.0, 0.5, 0.5, 1.0] {
        let (mut moved, mut theta) = (state.clone(), Vector3::zeros());
        if let Some((rate, vdot)) = slopes.last() {
            moved.advance(model, rate, stage * dt);
            moved.v += vdot * (stage * dt);
            if nv > model.joints().len() {
                theta = rate.fixed_rows::<3>(3) * (stage * dt);
            }
        }
        let mut vdot = DVector::zeros(nv);
        data.update_kinematics(model, &moved);
        forward_dynamics(model, data, &drives, &wrenches, &mut vdot, &mut effort);
        let mut rate = moved.v.clone();
        if nv > model.joints().len() {
            let w: Vector3<f64> = rate.fixed_rows::<3>(3).into_owned();
            let turned = w - theta.cross(&w) * 0.5 + theta.cross(&theta.cross(&w)) / 12.0;
            rate.fixed_rows_mut::<3>(3).copy_from(&turned);
        }
        slopes.push((rate, vdot));
    }
    let mean = |k: [&DVector<f64>; 4]| (k[0] + k[1] * 2.0 + k[2] * 2.0 + k[3]) / 6.0;
    let rate = mean([0, 1, 2, 3].map(|i| &slopes[i].0));
    let vdot = mean([0, 1, 2, 3].map(|i| &slopes[i].1));
    let mut next = state.clone();
    next.advance(model, &rate, dt);
    next.v += vdot * dt;
    next
}

/// Largest change of total energy in 0.5 s of free motion in `steps` steps.
fn energy_drift(model: &Model, start: &State, steps: usize) -> f64 {
    let mut data = updated(model, start);
    let first = energy(model, &data).total();
    let mut state = start.clone();
    let mut drift = 0.0_f64;
    for _ in 0..steps {
        state = runge_kutta(model, &mut data, &state, 0.5 / steps as f64);
        data.update_kinematics(model, &state);
        drift = drift.max((energy(model, &data).total() - first).abs());
    }
    drift
}

/// Free motion keeps kinetic plus potential energy; what the integrator loses falls with the fourth power of
/// the step, so by 16 when it is halved.
#[test]
fn energy_drift_falls_with_the_fourth_power_of_the_step() {
    for base in [Base::Floating, Base::Fixed] {
        for seed in 0..24 {
            let model = random_model(seed, base, 1 + seed as usize % 6);
            let start = random_state(seed, &model, 2.0);
            let [coarse, fine] = [50, 100].map(|n| energy_drift(&model, &start, n));
            assert!(fine < 1e-3, "seed {seed}: {fine:e} J");
            assert!(
                fine < coarse / 8.0 || coarse < 1e-10,
                "seed {seed}: {coarse:e} → {fine:e} J"
            );
        }
    }
}

#[test]
fn new_data_holds_the_neutral_state() {
    let model = random_model(7, Base::Floating, 5);
    let fresh = Data::new(&model);
    let mut used = updated(&model, &random_state(7, &model, 1.0));
    used.update(&model, &State::neutral(&model));
    assert_eq!(fresh.mass_matrix(), used.mass_matrix());
    assert_eq!(fresh.bias(), used.bias());
    assert_eq!(
        fresh.center_of_mass_jacobian(),
        used.center_of_mass_jacobian()
    );
    assert_eq!(fresh.centroidal_momentum(), used.centroidal_momentum());
}
