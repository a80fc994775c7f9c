//! Robots and controllers of a few lines, for what has nothing to do with a real one.

use wbqp::{Controller, ControllerConfig};

use crate::files::Temporary;

/// A link of 2 kg on a motor that turns it about y; its centre of mass is 0.5 m from the axis, its `tip` 1 m.
pub const PENDULUM: &str = r#"<robot name="pendulum">
<link name="base"><inertial><mass value="1"/>
<inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="arm"><inertial><origin xyz="0.5 0 0"/><mass value="2"/>
<inertia ixx="0.01" iyy="0.05" izz="0.05" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="tip"/>
<joint name="hinge" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 1 0"/>
<limit lower="-2" upper="2" effort="200" velocity="10"/></joint>
<joint name="end" type="fixed"><parent link="arm"/><child link="tip"/><origin xyz="1 0 0"/></joint>
</robot>"#;

/// One body, which no actuator moves.
pub const BODY: &str = r#"<robot name="body"><link name="base"><inertial><mass value="1"/>
<inertia ixx="0.01" iyy="0.02" izz="0.03" ixy="0" ixz="0" iyz="0"/></inertial></link></robot>"#;

/// A controller at 250 Hz. `settings` are keys of `[controller]`, `robot` of `[robot]`, `rest` are further tables.
///
/// # Panics
/// If something is wrong with it.
pub fn controller(urdf: &str, settings: &str, robot: &str, rest: &str) -> Controller {
    let folder = Temporary::new("small");
    std::fs::write(folder.file("robot.urdf"), urdf).expect("can be written");
    controller_in(
        &folder,
        &format!(
            "[controller]\nrate = 250.0\n{settings}\n[robot]\nfile = \"robot.urdf\"\n{robot}\n{rest}"
        ),
    )
}

/// A controller from the text of its file, of robots that ship.
///
/// # Panics
/// If something is wrong with it.
pub fn controller_of(text: &str) -> Controller {
    controller_in(&Temporary::new("small"), text)
}

fn controller_in(folder: &Temporary, text: &str) -> Controller {
    let config = ControllerConfig::from_str(text, "small.toml", folder.path());
    let config = config.unwrap_or_else(|e| panic!("{e}"));
    Controller::new(config).unwrap_or_else(|e| panic!("{e}"))
}
