//! The observer of velocities and of the unknown wrench, in closed loop with the plant.

use std::fs;

use wbqp::{
    Controller,
    contact::ContactSpec,
    nalgebra::{Vector3, Vector6},
};
use wbqp_sim::{CaseRun, ClosedLoop, Requests, Scenario};
use wbqp_tests::{
    files::scenarios,
    scenes::{Kind, Scene, observer},
    small::controller_of,
};

const SECONDS: usize = 8;

/// A case of the push, without its approach: the robot hovers. `changes` of the scenario's text, and what is seen of
/// each tick of the last two seconds.
fn hover(case: &str, changes: &[(&str, &str)], mut see: impl FnMut(&Controller)) {
    let folder = scenarios();
    let mut text = fs::read_to_string(folder.join("push_with_disturbance.toml")).expect("ships");
    for (from, to) in changes {
        assert!(text.contains(from), "{from}");
        text = text.replace(from, to);
    }
    let scenario = Scenario::from_text(&text, "push.toml", &folder).expect("is good");
    let case = scenario.case(case).expect("ships");
    let (mut controller, _) = CaseRun::controller(case).expect("fits");
    let mut plant = ClosedLoop::new(case, &controller, 3).expect("fits");
    for tick in 0..250 * SECONDS {
        let (command, _) = controller.tick(plant.measure());
        plant.advance(command).expect("is finite");
        if tick >= 250 * (SECONDS - 2) {
            see(&controller);
        }
    }
}

/// Mean estimate of the last two seconds, N and N·m, and mean efforts.
fn estimate(changes: &[(&str, &str)]) -> (Vector6<f64>, Vec<f64>) {
    let mut sum = Vector6::zeros();
    let mut efforts = vec![0.0; 9];
    let mut count = 0.0;
    hover("robust", changes, |controller| {
        sum += controller.report().disturbance;
        for (sum, effort) in efforts.iter_mut().zip(&controller.command().effort) {
            *sum += effort;
        }
        count += 1.0;
    });
    for effort in &mut efforts {
        *effort /= count;
    }
    (sum / count, efforts)
}

#[test]
fn a_force_at_the_base_is_found() {
    let pushed = [
        ("force = [-3.5, 0.0, 0.0]", "force = [-1.5, 1.0, 0.5]"),
        ("from = 12.0", "from = 0.5"),
    ];
    let (found, _) = estimate(&pushed);
    let force = Vector3::new(-1.5, 1.0, 0.5);
    let wrong = found - Vector6::new(force.x, force.y, force.z, 0.0, 0.0, 0.0);
    assert!(wrong.fixed_rows::<3>(0).norm() < 0.05, "{found}");
    assert!(wrong.fixed_rows::<3>(3).norm() < 0.02, "{found}");
}

#[test]
fn nothing_is_found_where_the_model_is_right() {
    let (found, _) = estimate(&[]);
    assert!(found.norm() < 0.03, "{found}");
}

/// Thrusts that are 5 % short are a wrench of −5 % of what was commanded: at rest that balances gravity, and the
/// weight is what is left.
#[test]
fn thrusts_that_fall_short_are_an_unknown_wrench() {
    let weak = [("[plant]\n", "[plant]\nmismatch = { thrust_scale = 0.95 }\n")];
    let (found, weak) = estimate(&weak);
    let (_, right) = estimate(&[]);
    let weight = 2.9193 * 9.81;
    // The commanded thrusts carry weight / 0.95, of which 5 % are not there.
    let short = weight * (1.0 - 1.0 / 0.95);
    assert!((found[2] - short).abs() < 0.05, "{found}, {short}");
    for (weak, right) in weak.iter().zip(&right).take(6) {
        assert!((weak * 0.95 / right - 1.0).abs() < 0.01, "{weak} {right}");
    }
}

/// The observer looks at the state alone: a tick whose wrenches are unusable knows as much as one whose are not.
#[test]
fn a_tick_without_wrenches_reports_its_own_estimate() {
    let folder = scenarios();
    let file = folder.join("push_with_disturbance.toml");
    let text = fs::read_to_string(file).expect("ships");
    let scenario = Scenario::from_text(&text, "push.toml", &folder).expect("is good");
    let case = scenario.case("robust").expect("ships");
    let mut twins = [(); 2].map(|()| CaseRun::controller(case).expect("fits").0);
    let mut plant = ClosedLoop::new(case, &twins[0], 3).expect("fits");
    for _ in 0..50 {
        let measurement = plant.measure().clone();
        let commands = twins
            .each_mut()
            .map(|twin| twin.tick(&measurement).0.clone());
        assert_eq!(commands[0], commands[1]);
        plant.advance(&commands[0]).expect("is finite");
    }
    let before = twins[0].report().disturbance;
    let mut measurement = plant.measure().clone();
    let expected = twins[0].tick(&measurement).1.disturbance;
    measurement.wrenches[0][2] = f64::NAN;
    let report = twins[1].tick(&measurement).1;
    assert!(report.fault.is_some(), "the wrench is no number");
    assert_eq!(report.disturbance, expected);
    assert!(expected != before, "{before}: noise moves it in every tick");
}

/// A fast observer while the tip pushes, whose sensor breaks at 9 s for 1.5 s: how far the base goes from where it was
/// until 11 s, m, and the largest force that is taken for unknown before the sensor breaks, N. `others` are contacts
/// that are never on, at the frame of the one that pushes and before it; the first `untold` are not told what is
/// measured there.
fn pushing_without_a_sensor(others: &[&str], untold: usize) -> (f64, f64) {
    let folder = scenarios();
    let text = fs::read_to_string(folder.join("push_with_disturbance.toml")).expect("ships");
    let text = text.replace(
        "velocity = 3.0, wrench = 0.25",
        "velocity = 20.0, wrench = 1.0",
    );
    let scenario = Scenario::from_text(&text, "push.toml", &folder).expect("is good");
    let case = scenario.case("robust").expect("ships");
    let mut config = case.controller_config().expect("is good");
    for name in others {
        let other = ContactSpec {
            name: (*name).to_owned(),
            active: false,
            ..config.contacts[0].clone()
        };
        config.contacts.insert(0, other);
    }
    let mut controller = case.make_controller(config).expect("fits");
    let mut plant = ClosedLoop::new(case, &controller, 3).expect("fits");
    let mut requests = Requests::new(case, 250.0);
    let (mut place, mut farthest, mut largest) = (None, 0.0_f64, 0.0_f64);
    for _ in 0..250 * 11 {
        let mut measurement = plant.measure().clone();
        while let Some(event) = requests.due(measurement.time) {
            event.apply(&mut controller).expect("fits");
        }
        requests.detect(&mut controller, &measurement);
        measurement.wrenches[..untold].fill(Vector6::zeros());
        if (9.0..10.5).contains(&measurement.time) {
            measurement.wrenches.fill(Vector6::repeat(f64::NAN));
        }
        let (command, report) = controller.tick(&measurement);
        let place = match place {
            None if measurement.time < 9.0 => {
                if measurement.time > 8.0 {
                    let force = report.disturbance.fixed_rows::<3>(0);
                    largest = largest.max(force.norm());
                }
                None
            }
            _ => Some(*place.get_or_insert(plant.plant().state().p_WR)),
        };
        plant.advance(command).expect("is finite");
        if let Some(place) = place {
            farthest = farthest.max((plant.plant().state().p_WR - place).norm());
        }
    }
    (farthest, largest)
}

/// What is measured no longer is no reason to take its contrary for a force that nobody knows.
#[test]
fn a_force_that_is_not_measured_any_more_does_not_throw_the_robot_away() {
    let (farthest, _) = pushing_without_a_sensor(&[], 0);
    assert!(farthest < 0.15, "{farthest}");
}

/// A sensor is one, however many contacts its frame has.
#[test]
fn two_contacts_of_one_frame_push_once() {
    let (_, alone) = pushing_without_a_sensor(&[], 0);
    assert!(alone < 1.0, "{alone}");
    for untold in 0..2 {
        let (_, beside) = pushing_without_a_sensor(&["floor"], untold);
        assert!((beside - alone).abs() < 0.1, "{untold}: {alone} {beside}");
    }
}

/// From one tick to the next, where velocities are differences of noisy poses.
#[test]
fn thrusts_are_calmer_than_measured_velocities_are() {
    let differences = [(
        "position_sd = 0.0005\nrotation_sd = 0.001\n",
        "position_sd = 0.0005\nrotation_sd = 0.001\nvelocity_cutoff = 30.0\n",
    )];
    let unrest = |case: &str| {
        let mut last: Option<Vec<f64>> = None;
        let mut sum = 0.0;
        hover(case, &differences, |controller| {
            let now = controller.command().effort[..6].to_vec();
            if let Some(last) = last.replace(now.clone()) {
                sum += last
                    .iter()
                    .zip(&now)
                    .map(|(a, b)| (a - b).powi(2))
                    .sum::<f64>();
            }
        });
        sum.sqrt()
    };
    let (without, with) = (unrest("with_ft"), unrest("robust"));
    assert!(4.0 * with < without, "{with} {without}");
}

#[test]
fn what_makes_no_sense_is_refused_by_key() {
    let refused = |kind, change: fn(&mut wbqp::settings::Observer)| {
        let mut config = Scene::new(kind, 1, 0, 0).config();
        let mut settings = observer(kind);
        change(&mut settings);
        config.settings.observer = Some(settings);
        Controller::new(config).expect_err("is refused").to_string()
    };
    for (kind, change, words) in [
        (
            Kind::FixedArm,
            (|o| o.wrench = 1.0) as fn(&mut wbqp::settings::Observer),
            ["observer.wrench", "base is fixed"],
        ),
        (
            Kind::Othex,
            |o| o.wrench = 3.0,
            ["observer.wrench", "a quarter of `velocity`"],
        ),
        (
            Kind::Othex,
            |o| o.velocity = f64::NAN,
            ["observer.velocity", "below half the rate"],
        ),
        (
            Kind::Othex,
            |o| (o.max_force, o.max_moment) = (0.0, 0.0),
            ["observer.wrench", "give `max_force`"],
        ),
        (
            Kind::Othex,
            |o| o.max_moment = -1.0,
            ["observer.max_moment", "not negative"],
        ),
    ] {
        let error = refused(kind, change);
        for word in words {
            assert!(error.contains(word), "{error}");
        }
    }
}

#[test]
fn what_overflowed_is_forgotten() {
    let mut config = Scene::new(Kind::Othex, 1, 0, 0b1).config();
    config.settings.observer = Some(observer(Kind::Othex));
    config.measurement.max_force = Some(f64::INFINITY);
    let mut controller = Controller::new(config).expect("fits");
    let mut measurement = controller.measurement();
    let mut optimal = 0;
    for tick in 0..20 {
        measurement.time = 0.004 * f64::from(tick);
        let force = if tick == 5 { 1e308 } else { 0.0 };
        measurement.wrenches[0][0] = force;
        let (_, report) = controller.tick(&measurement);
        assert!(report.disturbance.iter().all(|w| w.is_finite()));
        optimal += i32::from(tick > 8 && report.fault.is_none());
    }
    assert_eq!(optimal, 11, "{:?}", controller.report().fault);
}

/// Hovers with damping alone, one contact at its tool.
fn damped(forces: &str, free_force: &str) -> Controller {
    controller_of(&format!(
        "[controller]\nrate = 250.0\nobserver = {{ velocity = 3.0, wrench = 0.25, max_force = 8.0, max_moment = 1.5, \
         forces = {forces:?} }}\n[robot]\ntype = \"othex\"\n[[contact]]\nname = \"tip\"\nframe = \"tool\"\n\
         kind = \"normal\"\nsurface = {{ normal = [-1.0, 0.0, 0.0], x_axis = [0.0, 0.0, 1.0] }}\nactive = true\n\
         free_force = {free_force:?}\n[[task]]\ntype = \"base_position\"\nkp = 1e-3\nkd = 6.0\n[[task]]\n\
         type = \"base_orientation\"\nkp = 20.0\n[[task]]\ntype = \"posture\"\nkp = 20.0\n[[task]]\n\
         type = \"constant_force\"\ncontact = \"tip\"\nnormal = 0.0\nweight = 100.0\n[[constraint]]\n\
         type = \"friction_pyramid\"\ncontact = \"tip\"\n"
    ))
}

/// What nobody saw is not explained by a force: after a gap velocities are the measured ones, and the force stays.
#[test]
fn a_gap_is_no_force() {
    let mut controller = damped("measured", "zero");
    let mut measurement = controller.measurement();
    for k in 0..100 {
        measurement.time = 0.004 * f64::from(k);
        controller.tick(&measurement);
    }
    let before = controller.report().disturbance;
    measurement.time += 3.0;
    measurement.state.v[0] = 0.5;
    let (_, report) = controller.tick(&measurement);
    assert_eq!(report.disturbance, before);
    assert!((report.vdot[0] + 3.0).abs() < 0.1, "{}", report.vdot[0]);
}

/// What is measured in the free directions is in the problem already, and no unknown wrench.
#[test]
fn a_free_force_that_is_measured_is_not_unknown_beside_planned_ones() {
    let mut controller = damped("planned", "measured");
    let mut measurement = controller.measurement();
    // 1 N along the wall on a robot that stays where it is: efforts are such that nothing moves.
    measurement.wrenches[0] = Vector6::new(0.0, 1.0, 0.0, 0.0, 0.0, 0.0);
    for k in 0..1000 {
        measurement.time = 0.004 * f64::from(k);
        controller.tick(&measurement);
    }
    let unknown = controller.report().disturbance;
    assert!(unknown.norm() < 0.05, "{unknown}");
}
