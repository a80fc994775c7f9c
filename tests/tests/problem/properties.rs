//! Properties of the quadratic program, on random states of several robots with random subsets of tasks.

use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;
use wbqp::{
    actuator::ActuatorKind,
    contact::ContactKind,
    controller::{Controller, FallbackLevel},
    nalgebra,
    qp::{Qp, Solution, Status},
    settings::{Formulation, Hover},
};
use wbqp_tests::{
    properties::cases,
    scenes::{KINDS, Kind, Scene},
};

/// A scene; contacts are points or sliding points.
fn scenes() -> impl Strategy<Value = Scene> {
    let parts = (
        0..KINDS.len(),
        any::<u32>(),
        any::<u32>(),
        0..16_u32,
        any::<[bool; 2]>(),
    );
    parts.prop_map(|(kind, seed, tasks, contacts, [normal, soft_cones])| {
        let mut scene = Scene::new(KINDS[kind], u64::from(seed), tasks, contacts);
        scene.soft_cones = soft_cones;
        if normal {
            scene.contact_kind = ContactKind::Normal;
        }
        scene
    })
}

fn solved(scene: &Scene) -> Controller {
    let mut controller = scene.controller();
    controller.tick(&scene.measurement());
    controller
}

fn formulations() -> impl Strategy<Value = Formulation> {
    prop_oneof![
        Just(Formulation::Condensed),
        Just(Formulation::TorqueEliminated),
        Just(Formulation::Explicit),
    ]
}

/// Jacobi scale of every variable.
fn scales(qp: &Qp) -> Vec<f64> {
    let n = qp.n();
    let scale = |i: usize| match qp.h()[i * n + i] {
        h if h > 0.0 => 1.0 / h.sqrt(),
        _ => 1.0,
    };
    (0..n).map(scale).collect()
}

/// Condition number of the Jacobi-scaled Hessian.
fn condition(qp: &Qp) -> f64 {
    let (n, d) = (qp.n(), scales(qp));
    let scaled = DMatrix::from_fn(n, n, |i, j| qp.h()[i * n + j] * d[i] * d[j]);
    let eigenvalues = scaled.symmetric_eigenvalues();
    eigenvalues.max() / eigenvalues.min().max(1e-300)
}

fn relative(a: f64, b: f64) -> f64 {
    (a - b).abs() / (1.0 + a.abs().max(b.abs()))
}

fn same_vector(a: &DVector<f64>, b: &DVector<f64>) -> f64 {
    (a - b).amax() / (1.0 + a.amax())
}

/// Relative difference of two costs, the second divided by a factor.
fn cost_difference(a: &Controller, b: &Controller, factor: f64) -> f64 {
    relative(a.report().objective, b.report().objective / factor)
}

/// How far two solutions of one problem, put together in different ways, may be apart. The terms whose sum makes H are
/// rounded at 1e-16 of their size, which may be some times that of H, and a solution moves by as much times the
/// condition number, whoever solves for it.
fn tolerance(condition: f64) -> f64 {
    1e-9 + 1000.0 * f64::EPSILON * condition
}

/// Objective, v̇ and, where the problem is well conditioned, the efforts agree.
fn same_solution(a: &Controller, b: &Controller) -> Result<(), TestCaseError> {
    prop_assert_eq!(
        a.report().level,
        FallbackLevel::Optimal,
        "{:?}",
        a.report().status
    );
    prop_assert_eq!(
        b.report().level,
        FallbackLevel::Optimal,
        "{:?}",
        b.report().status
    );
    let cost = cost_difference(a, b, 1.0);
    let condition = condition(a.problem());
    prop_assert!(
        cost < 1e-9,
        "cost differs by {:e} at condition {:e}",
        cost,
        condition
    );
    if condition < 1e8 {
        let tolerance = tolerance(condition);
        let vdot = same_vector(&a.report().vdot, &b.report().vdot);
        prop_assert!(
            vdot < tolerance,
            "v̇ differs by {:e} at condition {:e}",
            vdot,
            condition
        );
        for (a, b) in a.command().effort.iter().zip(&b.command().effort) {
            prop_assert!(
                relative(*a, *b) < tolerance,
                "efforts {} {} at {:e}",
                a,
                b,
                condition
            );
        }
    }
    Ok(())
}

/// Both are optimal at the same cost, with the same efforts where these are well determined.
fn same_efforts(a: &Controller, b: &Controller) -> Result<(), TestCaseError> {
    let levels = (a.report().level, b.report().level);
    prop_assert_eq!(levels, (FallbackLevel::Optimal, FallbackLevel::Optimal));
    prop_assert!(cost_difference(a, b, 1.0) < 1e-9);
    let condition = condition(a.problem());
    if condition < 1e8 {
        for (a, b) in a.command().effort.iter().zip(&b.command().effort) {
            prop_assert!(
                relative(*a, *b) < tolerance(condition),
                "efforts {} {}",
                a,
                b
            );
        }
    }
    Ok(())
}

/// The same limits are reached, under the same names, at the same price, where one is noticeable.
fn same_limits(a: &Controller, b: &Controller) -> Result<(), TestCaseError> {
    let condition = condition(a.problem());
    if condition > 1e8 {
        return Ok(());
    }
    let name = |c: &Controller, row| c.row(row).map(ToString::to_string);
    // A price is noticeable beside the terms of the gradient, which differ between formulations.
    let largest = a.problem().g().iter().chain(b.problem().g());
    let largest = largest.fold(0.0, |largest: f64, g| largest.max(g.abs()));
    for (one, other) in [(a, b), (b, a)] {
        for row in &one.report().active {
            if row.multiplier.abs() < 1e-8 * largest {
                continue;
            }
            let twin =
                other.report().active.iter().find(|twin| {
                    name(other, twin.row) == name(one, row.row) && twin.side == row.side
                });
            let price = twin.map_or(0.0, |twin| twin.multiplier);
            prop_assert!(
                (price - row.multiplier).abs() < 100.0 * tolerance(condition) * (1.0 + largest),
                "{:?} costs {} and {}",
                name(one, row.row),
                row.multiplier,
                price
            );
        }
    }
    Ok(())
}

/// Largest violations of the optimality conditions.
#[derive(Debug, Default)]
struct Kkt {
    /// `‖D (H x + g + Aᵀ y + z)‖∞ / (1 + ‖D g‖∞)`.
    stationarity: f64,
    /// Row units.
    primal: f64,
    /// Multiplier times distance to its limit, relative to the cost.
    complementarity: f64,
    /// Multipliers of sides that have no limit.
    sign: f64,
}

fn kkt(qp: &Qp, s: &Solution) -> Kkt {
    let (n, m, d) = (qp.n(), qp.m(), scales(qp));
    let largest_g = (0..n).map(|i| (d[i] * qp.g()[i]).abs()).fold(0.0, f64::max);
    let mut out = Kkt::default();
    for (j, scale) in d.iter().enumerate() {
        let hx: f64 = (0..n).map(|i| qp.h()[j * n + i] * s.x[i]).sum();
        let ay: f64 = (0..m).map(|i| qp.row(i)[j] * s.y[i]).sum();
        let r = scale * (hx + qp.g()[j] + ay + s.z[j]) / (1.0 + largest_g);
        out.stationarity = out.stationarity.max(r.abs());
    }
    let cost = 1.0 + qp.objective(&s.x).abs();
    let mut side = |value: f64, lower: f64, upper: f64, multiplier: f64| {
        out.primal = out.primal.max(lower - value).max(value - upper);
        let distance = if multiplier > 0.0 {
            upper - value
        } else {
            value - lower
        };
        if distance.is_finite() {
            out.complementarity = out
                .complementarity
                .max((multiplier * distance).abs() / cost);
        } else {
            out.sign = out.sign.max(multiplier.abs() / cost);
        }
    };
    for i in 0..m {
        let ax: f64 = qp.row(i).iter().zip(&s.x).map(|(a, x)| a * x).sum();
        side(ax, qp.row_lower()[i], qp.row_upper()[i], s.y[i]);
    }
    for j in 0..n {
        side(s.x[j], qp.lower()[j], qp.upper()[j], s.z[j]);
    }
    out
}

proptest! {
    #![proptest_config(cases(500))]

    #[test]
    fn all_formulations_have_the_same_optimum(scene in scenes(), eliminated: bool) {
        let formulation = if eliminated {
            Formulation::TorqueEliminated
        } else {
            Formulation::Explicit
        };
        let other = Scene { formulation, ..scene.clone() };
        let (a, b) = (solved(&scene), solved(&other));
        same_solution(&a, &b)?;
        same_limits(&a, &b)?;
        // Two points whose costs differ by ε lie within ε of one another in the cost's own norm: Σ w Δr² ≤ ε.
        let own = a.problem().objective(&a.solution().x);
        let epsilon = 1e-9 * (1.0 + a.report().objective.abs() + own.abs());
        let condition = condition(a.problem());
        let size = a.report().vdot.amax();
        for (a, b) in a.report().tasks.iter().zip(&b.report().tasks) {
            for ((x, y), cost) in a.residual.iter().zip(&b.residual).zip(&a.cost) {
                let weight = if *x == 0.0 { 0.0 } else { cost / (x * x) };
                prop_assert!(weight * (x - y).powi(2) < epsilon, "residuals {} and {}", x, y);
                let near = (x - y).abs() < tolerance(condition) * (1.0 + size);
                prop_assert!(near || condition > 1e8, "residuals {} and {}", x, y);
            }
        }
    }

    /// Rows in one form, determined accelerations in the other.
    #[test]
    fn hard_contacts_are_the_same_as_rows_and_substituted(scene in scenes()) {
        let scene = Scene { hard_contacts: true, ..scene };
        let formulation = Formulation::TorqueEliminated;
        let other = Scene { formulation, ..scene.clone() };
        let (a, b) = (solved(&scene), solved(&other));
        prop_assert_eq!(a.report().level, b.report().level);
        // Not all contacts can be kept within all limits. Accelerations that rows determine make the cost small beside
        // the terms it is the difference of.
        if a.report().level == FallbackLevel::Optimal {
            let own = a.problem().objective(&a.solution().x).abs();
            let (x, y) = (a.report().objective, b.report().objective);
            let cost = (x - y).abs() / (1.0 + x.abs() + own);
            prop_assert!(cost < 1e-8, "costs {} and {}, own {}", x, y, own);
            if condition(a.problem()) < 1e8 {
                same_solution(&a, &b)?;
                same_limits(&a, &b)?;
            }
        }
    }

    #[test]
    fn passive_joints_and_second_motors_are_the_same_in_all_formulations(
        scene in scenes(),
        picks in any::<[u16; 2]>(),
        eliminated: bool,
    ) {
        let mut robot = scene.robot();
        let is_motor = |i: &usize| matches!(robot.actuators[*i].kind, ActuatorKind::Joint(_));
        let motors: Vec<usize> = (0..robot.nu()).filter(is_motor).collect();
        let [passive, twin] = picks.map(|pick| motors[usize::from(pick) % motors.len()]);
        let mut second = robot.actuators[twin].clone();
        second.name += "_second";
        robot.actuators.push(second);
        robot.actuators.remove(passive);
        let tick = |formulation| {
            let scene = Scene { formulation, ..scene.clone() };
            let mut config = scene.config();
            config.settings.hover = Hover::Unchecked;
            let mut controller =
                Controller::with_robot(config, robot.clone()).expect("the robot is sound");
            controller.tick(&scene.measurement());
            controller
        };
        let other = if eliminated {
            Formulation::TorqueEliminated
        } else {
            Formulation::Explicit
        };
        let (a, b) = (tick(Formulation::Condensed), tick(other));
        prop_assert_eq!(a.report().level, FallbackLevel::Optimal, "{:?}", a.report().status);
        prop_assert_eq!(b.report().level, FallbackLevel::Optimal, "{:?}", b.report().status);
        // Only the regularisation tells two motors of one joint apart: the condition is around 1e16, and neither
        // efforts nor a cost that is far smaller than the numbers it is the difference of can be had to all digits.
        let own = a.problem().objective(&a.solution().x).abs();
        let (x, y) = (a.report().objective, b.report().objective);
        let cost = (x - y).abs() / (1.0 + x.abs() + own);
        prop_assert!(cost < 1e-6, "cost {} and {}, own {}", x, y, own);
    }

    #[test]
    fn the_solution_satisfies_the_optimality_conditions(
        scene in scenes(),
        formulation in formulations(),
    ) {
        let scene = Scene { formulation, ..scene };
        let controller = solved(&scene);
        prop_assert_eq!(controller.report().level, FallbackLevel::Optimal);
        let rows = controller.problem().rows();
        prop_assert!(rows.is_sorted(), "rows are not in the order of their ids");
        let k = kkt(controller.problem(), controller.solution());
        let worst = k.stationarity.max(k.primal).max(k.complementarity).max(k.sign);
        prop_assert!(worst < 1e-8, "{:?}", k);
    }

    #[test]
    fn the_order_of_tasks_does_not_matter(scene in scenes()) {
        let reversed = Scene { reversed: true, ..scene.clone() };
        same_solution(&solved(&scene), &solved(&reversed))?;
    }

    #[test]
    fn scaling_all_weights_changes_nothing_but_the_cost(
        scene in scenes(),
        exponent in -2.0..2.0_f64,
    ) {
        let factor = 10f64.powf(exponent);
        let scaled = Scene { scale: factor, ..scene.clone() };
        let (a, b) = (solved(&scene), solved(&scaled));
        prop_assert_eq!((a.report().level, b.report().level), (FallbackLevel::Optimal, FallbackLevel::Optimal));
        prop_assert!(cost_difference(&a, &b, factor) < 1e-9);
        let condition = condition(a.problem());
        if condition < 1e8 {
            let vdot = same_vector(&a.report().vdot, &b.report().vdot);
            prop_assert!(vdot < tolerance(condition), "v̇ differs by {:e}", vdot);
        }
    }

    #[test]
    fn an_inactive_task_is_as_good_as_none(scene in scenes()) {
        let listed = Scene { list_inactive: true, ..scene.clone() };
        same_solution(&solved(&scene), &solved(&listed))?;
    }

    #[test]
    fn hard_rows_hold_where_the_status_is_optimal(scene in scenes()) {
        let scene = Scene { hard_contacts: true, ..scene };
        let controller = solved(&scene);
        if controller.report().status == Status::Optimal {
            let k = kkt(controller.problem(), controller.solution());
            prop_assert!(k.primal < 1e-8, "{:?}", k);
        } else {
            let status = controller.report().status;
            prop_assert_eq!(status, Status::Infeasible);
        }
    }

    #[test]
    fn turning_everything_about_gravity_turns_the_solution(
        scene in scenes(),
        yaw in -3.0..3.0_f64,
    ) {
        let turned = Scene { yaw, ..scene.clone() };
        same_efforts(&solved(&scene), &solved(&turned))?;
    }

    #[test]
    fn quarter_turns_swap_gains_and_weights_of_world_axes(
        scene in scenes(),
        quarters in 1..4_i32,
    ) {
        let scene = Scene { per_axis: true, ..scene };
        let yaw = f64::from(quarters) * std::f64::consts::FRAC_PI_2;
        let turned = Scene { yaw, ..scene.clone() };
        same_efforts(&solved(&scene), &solved(&turned))?;
    }
}

#[test]
fn contradictory_hard_rows_come_back_as_infeasible() {
    // An arm whose flange must stop at once from high speed: bounds on the torques and the hard contact rows
    // cannot both hold.
    let mut scene = Scene::new(Kind::FixedArm, 3, u32::MAX, 1);
    scene.hard_contacts = true;
    let mut measurement = scene.measurement();
    measurement.state.v.fill(80.0);
    let mut controller = scene.controller();
    let report = controller.tick(&measurement).1;
    assert_eq!(report.status, Status::Infeasible);
    assert_eq!(report.level, FallbackLevel::Relaxed);
    assert!(report.conflict.len() > 1);
    let explanation = controller.explain().expect("is not optimal");
    println!("{explanation}");
}
