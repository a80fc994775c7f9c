//! Derivatives of a tick's optimum allocate once, when their storage is made, and again only for keys that were
//! changed.

use wbqp::{
    Controller,
    controller::{FallbackLevel, Sensitivity},
    settings::Formulation,
    toml,
};
use wbqp_tests::scenes::{KINDS, Kind, Scene, observer};

use crate::allocations;

pub(crate) fn derivatives_allocate_nothing() {
    for kind in KINDS {
        for formulation in [Formulation::TorqueEliminated, Formulation::Explicit] {
            let mut scene = Scene::new(kind, 11, u32::MAX, 0b1111);
            scene.formulation = formulation;
            scene.hard_contacts = true;
            scene.soft_cones = true;
            let mut config = scene.config();
            if kind != Kind::Quadruped {
                config.settings.observer = Some(observer(kind));
            }
            for contact in &mut config.contacts {
                contact.transition = 0.02;
            }
            let mut controller = Controller::new(config).expect("the scene is valid");
            let mut sensitivity = Sensitivity::new(&mut controller);
            let mut measurement = scene.measurement();
            let (mut inside, mut filled) = (0, 0);
            for tick in 0..40_u32 {
                measurement.time = f64::from(tick) * 0.004;
                measurement.state.v[0] = (f64::from(tick) * 0.1).sin();
                match tick {
                    5 => controller.deactivate_contact("contact_0"),
                    15 => controller.deactivate("posture"),
                    20 => controller.activate_contact("contact_0"),
                    25 => controller.reweight("posture", 0.5),
                    _ => Ok(()),
                }
                .expect("the names exist");
                let before = allocations();
                let level = controller.tick(&measurement).1.level;
                let outcome = controller.sensitivity(&mut sensitivity);
                inside += allocations() - before;
                assert_eq!(outcome.is_ok(), level == FallbackLevel::Optimal, "{kind:?}");
                filled += u32::from(outcome.is_ok());
            }
            assert!(
                filled > 30,
                "{kind:?}: only {filled} ticks have derivatives"
            );
            assert_eq!(inside, 0, "{kind:?}, {formulation:?}");

            let keys = toml::toml! { kp = 21.0 };
            controller.set("posture", keys).expect("has that key");
            measurement.time += 0.004;
            controller.tick(&measurement);
            for is_first in [true, false] {
                let before = allocations();
                let outcome = controller.sensitivity(&mut sensitivity);
                outcome.expect("an optimum");
                assert_eq!(allocations() > before, is_first, "of changed keys, once");
            }
        }
    }
}
