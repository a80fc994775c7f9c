//! `report.html`: everything that a replication found, in one file that needs nothing else.

mod parameters;
mod svg;
mod sweep;

use std::{
    fs,
    path::{Path, PathBuf},
};

use anyhow::{Context, Result};
use maud::{DOCTYPE, Markup, PreEscaped, html};
use wbqp_measures::{Row, number, promises};

use crate::{
    experiment::{Outcome, Picture},
    mujoco::{self, Mujoco},
    sweep::Sweep,
};

const STYLE: &str = include_str!("style.css");

/// Writes `<out>/report.html`, and returns where that is; with `<out>/sweep.json` if it belongs to these outcomes.
///
/// # Errors
/// If a figure or a log cannot be read or the file not written.
pub fn write(outcomes: &[Outcome], out: &Path) -> Result<PathBuf> {
    let path = out.join("report.html");
    let sweep = Sweep::read_for(outcomes, out);
    let page = page(outcomes, sweep.as_ref())?.into_string();
    fs::write(&path, page).with_context(|| path.display().to_string())?;
    Ok(path)
}

fn page(outcomes: &[Outcome], sweep: Option<&Sweep>) -> Result<Markup> {
    let mut sections = Vec::new();
    for outcome in outcomes {
        let name = outcome.experiment.measures.name;
        sections.push(section(outcome).with_context(|| format!("report of {name}"))?);
    }
    Ok(html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { "wbqp: replication report" }
                style { (PreEscaped(STYLE)) }
            }
            body {
                h1 { "Force feedback and online optimisation for aerial manipulators: replication" }
                p.lead {
                    "The experiments of G. Nava, Q. Sablé, M. Tognon, D. Pucci and A. Franchi, "
                    i { "Direct Force Feedback Control and Online Multi-task Optimization for Aerial Manipulators" }
                    ", IEEE Robotics and Automation Letters, 2020, with the controller of this repository on a \
                     simulated robot. Every figure and number below is computed from the logs of the runs, which lie \
                     beside this page; paper is what the paper reports, accepted is this project's own tolerance."
                }
                (verdict(outcomes))
                nav {
                    @for outcome in outcomes {
                        a href={ "#" (outcome.experiment.measures.name) } { (outcome.experiment.measures.title) }
                    }
                    a href="#sweep" { "Variation" }
                }
                (overview(outcomes))
                @for section in &sections { (section) }
                (sweep::section(sweep))
                footer {
                    "wbqp " (env!("CARGO_PKG_VERSION")) ". Same scenario, same seed, same numbers: "
                    code { "cargo run --release" }
                    " makes this page again. The logs (MCAP) open in Foxglove and PlotJuggler and have these files and \
                     the robot's attached."
                }
            }
        }
    })
}

/// Whether everything is as promised, and if not, what.
fn verdict(outcomes: &[Outcome]) -> Markup {
    let rows = || outcomes.iter().flat_map(|o| &o.rows);
    let met = rows().filter(|row| row.pass == Some(true)).count();
    let missed = rows().filter(|row| row.pass == Some(false)).count();
    if outcomes.iter().all(Outcome::is_as_promised) {
        return html! {
            div.verdict {
                b { "All " (met) " promised rows are met." }
                @if missed > 0 { " " (missed) " are missed, each with its reason below." }
            }
        };
    }
    html! {
        div.verdict.broken {
            b { "Not as promised." }
            ul {
                @for outcome in outcomes {
                    @for (case, time) in outcome.runs.diverged() {
                        li {
                            (outcome.experiment.measures.title) ": case " code { (case) }
                            " diverged at " (number(time)) " s"
                        }
                    }
                    @for breach in &outcome.breaches {
                        li { (outcome.experiment.measures.title) ": " (breach.to_string()) }
                    }
                }
            }
        }
    }
}

/// One line per experiment.
fn overview(outcomes: &[Outcome]) -> Markup {
    let count = |rows: &[Row], pass| rows.iter().filter(|r| r.pass == pass).count();
    let total = |pass| -> usize { outcomes.iter().map(|o| count(&o.rows, pass)).sum() };
    html! {
        div.scroll {
            table {
                thead {
                    tr {
                        th { "experiment" }
                        th { "cases" }
                        th.n { "rows met" }
                        th.n { "missed" }
                        th.n { "informative" }
                    }
                }
                tbody {
                    @for outcome in outcomes {
                        tr {
                            td {
                                a href={ "#" (outcome.experiment.measures.name) } {
                                    (outcome.experiment.measures.title)
                                }
                            }
                            td { (outcome.runs.cases().collect::<Vec<_>>().join(", ")) }
                            td.n { (count(&outcome.rows, Some(true))) }
                            td.n { (count(&outcome.rows, Some(false))) }
                            td.n { (count(&outcome.rows, None)) }
                        }
                    }
                    tr.sum {
                        td { "all" }
                        td {}
                        td.n { (total(Some(true))) }
                        td.n { (total(Some(false))) }
                        td.n { (total(None)) }
                    }
                }
            }
        }
    }
}

fn section(outcome: &Outcome) -> Result<Markup> {
    let experiment = &outcome.experiment.measures;
    let mut figures = Vec::new();
    for picture in &outcome.pictures {
        figures.push(figure(outcome, picture)?);
    }
    let parameters = parameters::section(&outcome.runs)?;
    Ok(html! {
        section id=(experiment.name) {
            h2 { (experiment.title) }
            p { (experiment.about) }
            @for (case, time) in outcome.runs.diverged() {
                p { "Case " code { (case) } " diverged at " (number(time)) " s: there is nothing to measure." }
            }
            @if !outcome.rows.is_empty() { (rows(outcome.experiment.measures.name, &outcome.rows)) }
            (notes(outcome)?)
            @if !figures.is_empty() { h3 { "Figures" } }
            @for figure in &figures { (figure) }
            h3 { "Gains and parameters" }
            (parameters)
        }
    })
}

fn rows(experiment: &str, rows: &[Row]) -> Markup {
    let shipped = Mujoco::shipped();
    let other = |row: &Row| mujoco::cell(shipped.and_then(|m| m.row(experiment, row)), number);
    let value = |value: Option<f64>| value.map_or_else(|| "–".to_owned(), number);
    html! {
        div.scroll {
            table {
                thead {
                    tr {
                        th {}
                        th { "row" }
                        th { "quantity" }
                        th.n { "paper" }
                        th.n { "measured" }
                        th.n title="the same scenario with MuJoCo as the plant, recorded before" { "MuJoCo" }
                        th { "unit" }
                        th { "accepted" }
                    }
                }
                tbody {
                    @for row in rows {
                        @let (class, mark, word) = match row.pass {
                            Some(true) => ("met", "✓", "met"),
                            Some(false) => ("missed", "✗", "missed"),
                            None => ("informs", "·", "only informs"),
                        };
                        tr class=(class) {
                            td.mark title=(word) { (mark) }
                            td.id { (row.id) }
                            td { (row.quantity) }
                            td.n { (value(row.paper)) }
                            td.n { (value(row.measured)) }
                            td.n { (other(row)) }
                            td { (unit(&row.unit)) }
                            td { (row.tolerance) }
                        }
                    }
                }
            }
        }
    }
}

/// Nothing for a number without unit.
fn unit(unit: &str) -> &str {
    if unit == "1" { "" } else { unit }
}

/// Missed rows with their reasons, and remarks.
fn notes(outcome: &Outcome) -> Result<Markup> {
    let promises = promises::of(outcome.experiment.measures.name)?;
    let missed = |row: &&Row| row.pass == Some(false);
    let reason = |row: &Row| {
        let reason = promises.reason(row);
        reason
            .unwrap_or("promised, and no reason is known")
            .to_owned()
    };
    Ok(html! {
        @if outcome.rows.iter().any(|row| missed(&row)) {
            h3 { "Missed" }
            ul {
                @for row in outcome.rows.iter().filter(missed) {
                    li { b { (row.id) ", " (row.quantity) } ": " (reason(row)) }
                }
            }
        }
        @if !promises.remark.is_empty() {
            h3 { "Where it differs from the paper" }
            ul {
                @for remark in &promises.remark {
                    li { b { (remark.id) ", " (remark.quantity) } ": " (remark.text) }
                }
            }
        }
    })
}

fn figure(outcome: &Outcome, picture: &Picture) -> Result<Markup> {
    let path = outcome.runs.directory().join(&picture.file);
    let file = fs::read_to_string(&path).with_context(|| path.display().to_string())?;
    let stem = picture.file.trim_end_matches(".svg");
    let id = format!("{}-{stem}", outcome.experiment.measures.name);
    Ok(html! {
        figure id=(id) {
            div.scroll { (PreEscaped(svg::inline(&file, &id))) }
            figcaption { (picture.caption) "." }
        }
    })
}
