//! URDFs for the tests: texts put together of links and joints.

/// An inertial element that nothing is wrong with.
pub(crate) const INERTIAL: &str = concat!(
    r#"<inertial><mass value="2"/>"#,
    r#"<inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial>"#,
);
/// Limits of a joint that nothing is wrong with.
pub(crate) const LIMIT: &str = r#"<limit lower="-1" upper="1" effort="5" velocity="3"/>"#;

pub(crate) fn link(name: &str) -> String {
    format!("<link name=\"{name}\">{INERTIAL}</link>\n")
}

pub(crate) fn joint(name: &str, kind: &str, parent: &str, child: &str, rest: &str) -> String {
    format!(
        "<joint name=\"{name}\" type=\"{kind}\"><parent link=\"{parent}\"/><child link=\"{child}\"/>{rest}</joint>\n"
    )
}

pub(crate) fn robot(body: &str) -> String {
    format!("<robot name=\"r\">\n{body}</robot>")
}

/// A base with one arm, whose joint says `rest`.
pub(crate) fn arm(kind: &str, rest: &str) -> String {
    robot(&(link("base") + &link("arm") + &joint("elbow", kind, "base", "arm", rest)))
}

/// A base with one arm, whose link says `inside`.
pub(crate) fn arm_link(inside: &str) -> String {
    let arm = format!("<link name=\"arm\">{inside}</link>\n");
    robot(&(link("base") + &arm + &joint("elbow", "revolute", "base", "arm", LIMIT)))
}

/// An inertial element without products of inertia.
pub(crate) fn inertial(mass: &str, moments: [&str; 3]) -> String {
    let [ixx, iyy, izz] = moments;
    format!(
        "<inertial><mass value=\"{mass}\"/>\
         <inertia ixx=\"{ixx}\" ixy=\"0\" ixz=\"0\" iyy=\"{iyy}\" iyz=\"0\" izz=\"{izz}\"/></inertial>"
    )
}
