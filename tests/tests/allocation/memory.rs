//! What a controller is going to take is said before it is taken, and it is about that.

use stats_alloc::Region;
use wbqp::{ControllerConfig, config::Plan};
use wbqp_robots as _;
use wbqp_tasks as _;
use wbqp_tests::hostile;

use crate::ALLOCATOR;

/// Bytes that are held more after a call than before.
fn held<T>(make: impl FnOnce() -> T) -> (T, f64) {
    let region = Region::new(ALLOCATOR);
    let made = make();
    let change = region.change();
    let bytes = change.bytes_allocated as f64 - change.bytes_deallocated as f64;
    (made, bytes)
}

fn check(name: &str, text: &str) {
    let config =
        ControllerConfig::from_str(text, "x.toml", "").unwrap_or_else(|e| panic!("{name}: {e}"));
    let robot = config
        .load_robot()
        .unwrap_or_else(|e| panic!("{name}: {e}"));
    let (plan, planned) = held(|| Plan::new(config, robot));
    let plan = plan.unwrap_or_else(|e| panic!("{name}: {e}"));
    let said = plan.memory();
    let (controller, made) = held(|| plan.make());
    let controller = controller.unwrap_or_else(|e| panic!("{name}: {e}"));
    println!(
        "{name}: said {said}; the plan takes {planned:.0} bytes, the controller {made:.0} more"
    );
    let bytes = said.bytes as f64;
    // What is said counts matrices, not names.
    assert!(made <= 1.2 * bytes, "{name}: more than was said");
    assert!(bytes <= 4.0 * made, "{name}: much less than was said");
    assert!(planned <= 0.5 * made, "{name}: before it was said");
    drop(controller);
}

pub(crate) fn a_controller_takes_about_what_is_said() {
    check("stand", &hostile::stand());
    for count in [10, 100, 1000] {
        check(&format!("{count} tasks"), &hostile::tasks(count));
    }
    for count in [3, 10, 30] {
        check(
            &format!("{count} constraints"),
            &hostile::constraints(count),
        );
    }
    for formulation in ["condensed", "torque_eliminated", "explicit"] {
        let line = format!("rate = 500.0\nformulation = \"{formulation}\"");
        check(
            formulation,
            &hostile::stand().replace("rate = 500.0", &line),
        );
    }
}
