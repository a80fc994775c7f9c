//! The plug-ins pass wbqp's test kit.

use pointing as _;
use wbqp_testing::{PluginTest, RowSemantics};

#[test]
fn point_at() {
    let keys = "frame = 'tool'\ntarget = [1.5, 0.3, 1.4]\nkp = 40.0\nkd = 12.0";
    PluginTest::task(format!("type = 'pointing.point_at'\n{keys}")).assert_passes();
}

#[test]
fn max_tilt() {
    PluginTest::constraint("type = 'pointing.max_tilt'\ndegrees = 20.0")
        .semantics(RowSemantics::Barrier)
        .assert_passes();
}
