//! The scenarios that are inside the module, under the paths that they have in the repository.

use std::path::Path;

use wbqp::input;

/// A scenario that ships with the page.
#[derive(Clone, Copy, Debug)]
pub struct Shipped {
    /// Its name, which is also that of its file.
    pub name: &'static str,
    /// What it is called on the page.
    pub title: &'static str,
    /// What happens in it.
    pub about: &'static str,
    /// The case that is shown first.
    pub case: &'static str,
    /// The scenario's file.
    pub text: &'static str,
    /// The controller's file.
    pub controller: &'static str,
}

macro_rules! ship {
    ($name:literal, $title:literal, $case:literal, $about:literal) => {
        Shipped {
            name: $name,
            title: $title,
            about: $about,
            case: $case,
            text: include_str!(concat!("../../examples/scenarios/", $name, ".toml")),
            controller: include_str!(concat!(
                "../../examples/scenarios/",
                $name,
                ".controller.toml"
            )),
        }
    };
}

static SHIPPED: [Shipped; 6] = [
    ship!(
        "push_with_disturbance",
        "B: push against a wall, disturbed",
        "with_ft",
        "The hexarotor touches the wall and pushes with 5 N. From 12 s to 17 s a force of 3.5 N at its base, which \
         neither controller nor sensors know of, pulls it away."
    ),
    ship!(
        "push_and_slide",
        "C: push and slide",
        "with_ff",
        "The tool's tip touches the wall, pushes with 2.5 N and slides once around an ellipse."
    ),
    ship!(
        "push_away",
        "D: push away from the wall",
        "contact",
        "Away from the wall by 35 cm in half a second; the contact leaves the problem half way."
    ),
    ship!(
        "under_actuated",
        "E: rotors of one direction",
        "attitude_reference",
        "A hexarotor whose thrust has one direction leans against the wall to push with 5 N."
    ),
    ship!(
        "quadruped_stand",
        "Quadruped: sway and pushes",
        "stand",
        "A quadruped stands on four point feet, sways, squats and nods, and is pushed at 8 s and at 14 s."
    ),
    ship!(
        "humanoid_stand",
        "Humanoid: sway and pushes",
        "stand",
        "A humanoid stands on two soles, sways, squats and bows, and is pushed at 8 s and at 14 s."
    ),
];

/// All of them, in the page's order.
pub fn shipped() -> &'static [Shipped] {
    &SHIPPED
}

impl Shipped {
    /// The path of its scenario.
    pub fn path(&self) -> String {
        format!("scenarios/{}.toml", self.name)
    }
}

/// Keeps their files in memory, where scenarios are read from.
pub fn keep_shipped() {
    for shipped in &SHIPPED {
        input::keep(Path::new(&shipped.path()), shipped.text.as_bytes());
        let controller = format!("scenarios/{}.controller.toml", shipped.name);
        input::keep(Path::new(&controller), shipped.controller.as_bytes());
    }
}
