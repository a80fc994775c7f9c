//! The registry as a page of the documentation.

use wbqp::registry::{Key, PluginInfo};
// The plug-ins that the page is about.
use wbqp_robots as _;
use wbqp_tasks as _;

const HEAD: &str = "\
# Plug-ins

Everything that `type = \"…\"` can name, with equations and parameters.
Generated from the registry by `cargo run --bin plugins > docs/plugins.md`; the texts are those of the code.
A crate of your own is listed by `wbqp::registry()` in the same way.

In the columns *default*, \"–\" means that the key must be given, and a blank that the text says what happens \
without it.
";

const KINDS: [(&str, &str); 6] = [
    ("task", "Tasks"),
    ("constraint", "Constraints"),
    ("reference", "References"),
    ("robot", "Robots"),
    ("solver", "Solvers"),
    ("fallback", "Fallback laws"),
];

/// The page.
pub fn markdown(plugins: &[PluginInfo]) -> String {
    let mut page = HEAD.to_owned();
    for (kind, title) in KINDS {
        page.push_str(&format!("\n## {title}\n\n"));
        let has_equations =
            of_kind(plugins, kind).any(|plugin| plugin.equations().next().is_some());
        page.push_str(&overview(plugins, kind, has_equations));
        for plugin in of_kind(plugins, kind) {
            page.push_str(&section(plugin));
        }
    }
    page
}

fn of_kind<'a>(plugins: &'a [PluginInfo], kind: &'a str) -> impl Iterator<Item = &'a PluginInfo> {
    plugins.iter().filter(move |plugin| plugin.kind == kind)
}

/// One row per plug-in.
fn overview(plugins: &[PluginInfo], kind: &str, has_equations: bool) -> String {
    let (head, line) = if has_equations {
        ("| `type` | | equations |", "|---|---|---|")
    } else {
        ("| `type` | |", "|---|---|")
    };
    let mut table = format!("{head}\n{line}\n");
    for plugin in of_kind(plugins, kind) {
        let tag = plugin.tag;
        table.push_str(&format!(
            "| [`{tag}`](#{tag}) | {} |",
            cell(plugin.summary())
        ));
        if has_equations {
            let equations: Vec<String> = plugin.equations().map(cell).collect();
            table.push_str(&format!(" {} |", equations.join("<br>")));
        }
        table.push('\n');
    }
    table
}

fn section(plugin: &PluginInfo) -> String {
    let tag = plugin.tag;
    // The outline is the page's.
    let lines = plugin
        .description
        .lines()
        .map(|line| match line.strip_prefix("# ") {
            Some(heading) => format!("**{heading}**\n"),
            None => line.to_owned(),
        });
    let description = lines.collect::<Vec<_>>().join("\n");
    let mut text = format!("\n### {tag}\n\n{description}\n");
    if let Some(weight) = &plugin.weight {
        text.push_str(&format!("\nWeight, if the entry has none: `{weight}`.\n"));
    }
    if plugin.parameters.is_empty() {
        text.push_str("\nNo parameters.\n");
        return text;
    }
    text.push_str("\n| key | value | unit | default | meaning |\n|---|---|---|---|---|\n");
    for parameter in &plugin.parameters {
        text.push_str(&row(parameter));
    }
    text
}

fn row(parameter: &Key) -> String {
    let default = match (&parameter.default, parameter.is_required) {
        (_, true) => "–".to_owned(),
        (Some(default), _) => format!("`{default}`"),
        (None, _) => String::new(),
    };
    format!(
        "| `{}` | {} | {} | {} | {} |\n",
        parameter.key,
        cell(&parameter.expected),
        parameter.unit.as_deref().unwrap_or_default(),
        cell(&default),
        cell(&parameter.description),
    )
}

/// A text in a cell of a table: one line, without the character that ends a cell.
fn cell(text: &str) -> String {
    let line: Vec<&str> = text.split_whitespace().collect();
    line.join(" ").replace('|', "\\|")
}
