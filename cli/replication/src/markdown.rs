//! `docs/replication.md`: what was measured, for readers who have not run it.
//!
//! Times of the wall clock are left out, and numbers have three digits, so that the page is the same wherever it is
//! made. The acceptance tests compare it with what they measure.

use std::{fs, path::Path};

use anyhow::{Context, Result};

use wbqp_measures::{
    Row,
    promises::{self, PromiseError},
    rounded,
};

use crate::{
    experiment::Outcome,
    mujoco::{self, Mujoco},
};

const HEAD: &str = "\
# Replication

What the paper reports and what the experiments here measure. This page is written by

```sh
cargo run --release -- --docs
```

and the acceptance tests compare every row with what they measure; do not edit it. `cargo run --release` prints the same
tables with more digits and writes figures, logs and a report with all gains and parameters, `out/report.html`.

*Accepted* is this project's tolerance, not the paper's. ✓ is met, ✗ missed, and · only informs. Everything is measured
from the logs, seed 1. Which rows are promised is in `simulation/measures/promised_rows.toml`: the exit code follows it.

*MuJoCo* is the same scenario, controller, sensors and measures with another engine as the plant:
`python -m wbqp.experiments --plant mujoco` measures it, and `--record cli/replication/mujoco_rows.json` keeps it for
this page. [What differs between the plants](mujoco.md#the-experiments) is said there.
";

/// Writes the page.
///
/// # Errors
/// If an experiment diverged or the file cannot be written.
pub fn write(outcomes: &[Outcome], path: &Path) -> Result<()> {
    let mut text = HEAD.to_owned();
    for outcome in outcomes {
        anyhow::ensure!(
            outcome.completed(),
            "{} diverged: its rows cannot be documented",
            outcome.experiment.measures.name
        );
        text.push('\n');
        text.push_str(&section(outcome)?);
    }
    fs::write(path, text).with_context(|| path.display().to_string())
}

/// The part of the page that is about one experiment.
///
/// # Errors
/// [`PromiseError`] if the list of promised rows is wrong.
pub fn section(outcome: &Outcome) -> Result<String, PromiseError> {
    let experiment = &outcome.experiment.measures;
    let promises = promises::of(experiment.name)?;
    let mut text = format!("## {}\n\n{}\n\n", experiment.title, experiment.about);
    text.push_str("| | row | quantity | paper | measured | MuJoCo | unit | accepted |\n");
    text.push_str("|---|---|---|--:|--:|--:|---|---|\n");
    for row in outcome.rows.iter().filter(|row| !row.is_wall_clock()) {
        let other = Mujoco::shipped().and_then(|other| other.row(experiment.name, row));
        let other = mujoco::cell(other, |x| rounded(x, 3));
        text.push_str(&line(row, &other));
    }
    let mut notes = Vec::new();
    for row in outcome.rows.iter().filter(|row| row.pass == Some(false)) {
        if let Some(reason) = promises.reason(row) {
            let (id, quantity) = (&row.id, escaped(&row.quantity));
            notes.push(format!(
                "- {id}, {quantity}, is missed: {}\n",
                escaped(reason)
            ));
        }
    }
    for remark in &promises.remark {
        let quantity = escaped(&remark.quantity);
        let text = escaped(&remark.text);
        notes.push(format!("- {}, {quantity}: {text}\n", remark.id));
    }
    if !notes.is_empty() {
        text.push('\n');
        text.push_str(&notes.concat());
    }
    text.push_str("\nFigures:\n\n");
    for picture in &outcome.pictures {
        text.push_str(&format!("- `{}`: {}\n", picture.file, picture.caption));
    }
    Ok(text)
}

fn line(row: &Row, mujoco: &str) -> String {
    let mark = match row.pass {
        Some(true) => "✓",
        Some(false) => "✗",
        None => "·",
    };
    let value = |value: Option<f64>| value.map_or_else(|| "–".to_owned(), |v| rounded(v, 3));
    format!(
        "| {mark} | {} | {} | {} | {} | {mujoco} | {} | {} |\n",
        row.id,
        escaped(&row.quantity),
        value(row.paper),
        value(row.measured),
        row.unit,
        escaped(&row.tolerance),
    )
}

/// What means something in a Markdown table, as itself.
fn escaped(text: &str) -> String {
    let mut escaped = String::new();
    for c in text.chars() {
        if matches!(c, '|' | '*' | '_' | '<' | '\\') {
            escaped.push('\\');
        }
        escaped.push(c);
    }
    escaped
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_one_line_of_a_table() {
        let row = Row::judged(
            "B6",
            ("|mean error| of f*", "N"),
            1.0,
            Some(0.74251),
            "0.6…1.4 N",
            |_| true,
        );
        assert_eq!(
            line(&row, "0.75 ✓"),
            "| ✓ | B6 | \\|mean error\\| of f\\* | 1 | 0.743 | 0.75 ✓ | N | 0.6…1.4 N |\n"
        );
    }
}
