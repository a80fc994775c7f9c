//! Whatever is measured, asked or forbidden: a tick returns a command that is finite and within bounds.
//!
//! `WBQP_TICKS` says how many ticks are run, 20 000 if it is not set.

use std::collections::BTreeMap;

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use wbqp::{
    config::ControllerConfig,
    contact::ContactKind,
    controller::{Controller, FallbackLevel},
    plugin::{Entry, Hardness},
    settings::Formulation,
};
use wbqp_tasks::{Hold, JointLimits};
use wbqp_tests::{
    adversary::{Adversary, is_within_bounds, spoil},
    scenes::{KINDS, Kind, Scene},
};

/// Ticks of one controller.
const LIFE: usize = 500;

fn ticks() -> usize {
    let given = std::env::var("WBQP_TICKS").ok();
    given.map_or(20_000, |n| n.parse().expect("a number of ticks"))
}

fn random_config(kind: Kind, seed: u64, rng: &mut ChaCha8Rng) -> (Scene, ControllerConfig) {
    let mut scene = Scene::new(kind, seed, rng.random(), rng.random());
    scene.hard_contacts = rng.random();
    scene.soft_cones = rng.random();
    scene.list_inactive = true;
    scene.formulation = [
        Formulation::TorqueEliminated,
        Formulation::Condensed,
        Formulation::Explicit,
    ][rng.random_range(0..3)];
    if rng.random_bool(0.3) {
        scene.contact_kind = ContactKind::Normal;
    }
    let mut config = scene.config();
    for contact in &mut config.contacts {
        if rng.random_bool(0.3) {
            contact.friction = 0.0;
        }
        contact.transition = if rng.random() { 0.05 } else { 0.0 };
    }
    if rng.random() {
        let limits = Box::new(JointLimits::new(50.0));
        config
            .constraints
            .push(Entry::new("joints", 1.0, Hardness::Hard, limits));
    }
    let harm = [0, 20, 300][rng.random_range(0..3)];
    Adversary::new(seed, harm).join(&mut config, "adversary");
    (scene, config)
}

/// Switches, reweights or redirects something.
fn meddle(controller: &mut Controller, rng: &mut ChaCha8Rng) {
    let names: Vec<String> = controller.task_names().map(str::to_owned).collect();
    let name = &names[rng.random_range(0..names.len())];
    let contacts: Vec<String> = controller.contact_names().map(str::to_owned).collect();
    let contact = &contacts[rng.random_range(0..contacts.len())];
    let done = match rng.random_range(0..6) {
        0 => controller.activate(name),
        1 => controller.deactivate(name),
        2 => controller.activate_contact(contact),
        3 => controller.deactivate_contact(contact),
        4 => {
            let weight = 10f64.powf(rng.random_range(-6.0..4.0));
            controller.reweight(name, weight)
        }
        _ => {
            let far = 10f64.powf(rng.random_range(-2.0..6.0));
            let target = || [far, -far, 0.5 * far];
            // Most tasks follow something of another size, or nothing: refused.
            let _ = controller.follow(name, Hold::at(target()));
            let _ = controller.follow(name, Hold::at([far]));
            Ok(())
        }
    };
    done.expect("the names exist");
}

#[test]
fn every_command_is_finite_and_within_bounds_and_every_rung_is_reached() {
    let total = ticks();
    let lives = total.div_ceil(LIFE).max(KINDS.len());
    let mut levels: BTreeMap<(&str, &str), usize> = BTreeMap::new();
    let mut resolves = [0_usize; 6];
    let (mut changes, mut count) = (0_usize, 0_usize);
    for life in 0..lives {
        let kind = KINDS[life % KINDS.len()];
        let mut rng = ChaCha8Rng::seed_from_u64(life as u64);
        let (scene, config) = random_config(kind, life as u64, &mut rng);
        let mut controller = Controller::new(config).expect("the scene is valid");
        let robot = controller.robot().clone();
        let start = scene.measurement();
        let spoilt = [0.0, 0.02, 0.3][rng.random_range(0..3)];
        let mut outage = 0;
        let mut last = None;
        for tick in 0..LIFE {
            let mut measurement = start.clone();
            measurement.time = tick as f64 * 0.004;
            for v in measurement.state.v.iter_mut() {
                *v += rng.random_range(-0.2..0.2);
            }
            for q in measurement.state.q.iter_mut() {
                *q += rng.random_range(-0.1..0.1);
            }
            if rng.random_bool(0.01) {
                outage = rng.random_range(1..20);
            }
            if rng.random_bool(spoilt) || outage > 0 {
                spoil(&mut measurement, &mut rng);
                outage = usize::saturating_sub(outage, 1);
            }
            if rng.random_bool(0.05) {
                meddle(&mut controller, &mut rng);
            }
            let (command, report) = controller.tick(&measurement);
            let context = || format!("life {life}, tick {tick}, {kind:?}: {report:?}\n{command:?}");
            assert!(is_within_bounds(&robot, command), "{}", context());
            assert_eq!(
                report.fault.is_none(),
                report.level == FallbackLevel::Optimal
            );
            assert!(report.level_ticks > 0 && report.level_since.is_finite());
            assert!(report.level == FallbackLevel::Relaxed || report.relaxed.is_empty());
            let limits = report.conflict.iter().all(|c| c.short > 0.0);
            assert!(limits, "{}", context());
            *levels
                .entry((scene_name(kind), report.level.as_str()))
                .or_default() += 1;
            resolves[report.resolves as usize] += 1;
            changes += usize::from(last.is_some_and(|last| last != report.level));
            last = Some(report.level);
            count += 1;
        }
        if let Some(explanation) = controller.explain() {
            assert!(!explanation.is_empty());
        }
    }
    println!("{count} ticks, {changes} changes of level, relaxed problems per tick {resolves:?}");
    for kind in KINDS {
        for level in FallbackLevel::ALL {
            let found = levels.get(&(scene_name(kind), level.as_str()));
            println!("{kind:?} {}: {}", level.as_str(), found.unwrap_or(&0));
            assert!(found.is_some(), "{kind:?} never was {}", level.as_str());
        }
    }
}

fn scene_name(kind: Kind) -> &'static str {
    match kind {
        Kind::Othex => "othex",
        Kind::OthexVertical => "othex_vertical",
        Kind::Quadruped => "quadruped",
        Kind::FixedArm => "fixed_arm",
    }
}
