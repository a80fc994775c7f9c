//! The page of plug-ins is that of the code, and says something of everything.

use std::fs;

use wbqp::registry::{self, PluginInfo};
use wbqp_cli::plugin_table;
use wbqp_tests::files::workspace;

/// What is linked but the tests' own plug-ins.
fn shipped() -> Vec<PluginInfo> {
    let mut plugins = wbqp::registry();
    let is_ours = |origin: &str| origin.starts_with("wbqp-tests ");
    plugins.retain(|plugin| !is_ours(plugin.origin));
    plugins
}

#[test]
fn page_is_up_to_date() {
    let path = workspace("docs/plugins.md");
    let page = fs::read_to_string(path).expect("the page is there");
    assert!(
        page == plugin_table::markdown(&shipped()),
        "docs/plugins.md is not that of the code; `cargo run --bin plugins > docs/plugins.md` writes it"
    );
}

#[test]
fn every_task_and_constraint_states_its_equation() {
    let has_one = |plugin: &&PluginInfo| ["task", "constraint"].contains(&plugin.kind);
    for plugin in shipped().iter().filter(has_one) {
        let kind = plugin.kind;
        assert!(
            plugin.equations().next().is_some(),
            "the documentation of {kind} `{}` has no paragraph that begins with an equation in backticks",
            plugin.tag
        );
    }
}

#[test]
fn every_key_is_described() {
    for plugin in &shipped() {
        assert!(!plugin.description.is_empty(), "{}", plugin.tag);
        for parameter in &plugin.parameters {
            let (tag, key) = (plugin.tag, &parameter.key);
            assert!(!parameter.description.is_empty(), "{tag}.{key}");
            assert_ne!(parameter.expected, "anything", "{tag}.{key}");
        }
    }
}

#[test]
fn every_plug_in_names_its_origin() {
    let listing = wbqp::registry();
    assert_eq!(registry::duplicates(), []);
    for (kind, tag, origin) in [
        ("task", "posture", "wbqp-tasks "),
        ("robot", "othex", "wbqp-robots "),
        ("solver", "active_set", "wbqp "),
    ] {
        let mut all = listing.iter();
        let plugin = all.find(|plugin| (plugin.kind, plugin.tag) == (kind, tag));
        let plugin = plugin.expect("is linked");
        assert!(plugin.origin.starts_with(origin), "{}", plugin.origin);
    }
}
