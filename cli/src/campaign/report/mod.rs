//! `wbqp campaign report`: a page of what a campaign found.

mod figures;
mod lines;
mod statistics;

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
};

use anyhow::{Context, Result};
use clap::Args;
use maud::{DOCTYPE, Markup, PreEscaped, html};
use wbqp_campaign::{Column, table::Table};
use wbqp_measures::number;
use wbqp_terminal::say;

use lines::Lines;
use statistics::{Share, groups, quantile};

const STYLE: &str = include_str!("style.css");

/// Writes a page: which share of the runs holds, which factor breaks what, and the worst runs
#[derive(Args, Debug)]
pub(super) struct Arguments {
    /// The table of a campaign, or of one of its shards
    #[arg(value_name = "TABLE")]
    table: PathBuf,
    /// The page; default: beside the table
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// The plan's file, for the commands that do a run again
    #[arg(long, value_name = "PLAN", default_value = "PLAN")]
    plan: PathBuf,
    /// Sobol's indices as the Python package writes them: measure, factor, first-order and total index
    #[arg(long, value_name = "JSON")]
    indices: Option<PathBuf>,
}

/// Runs that are listed as the worst of a variant.
const WORST: usize = 10;
/// Groups of a factor's values.
const GROUPS: usize = 5;

/// By measure and factor: first-order and total index.
type Indices = BTreeMap<String, BTreeMap<String, [f64; 2]>>;

impl Arguments {
    pub(super) fn run(&self) -> Result<()> {
        let table = Table::open(&self.table)?;
        let lines = Lines::read(&table)?;
        let indices: Option<Indices> = match &self.indices {
            Some(path) => {
                let text = wbqp::input::read_text(path);
                let text = text.with_context(|| path.display().to_string())?;
                let read = wbqp::serde_json::from_str(&text);
                Some(read.with_context(|| path.display().to_string())?)
            }
            None => None,
        };
        let out = match &self.out {
            Some(out) => out.clone(),
            None => self.table.with_extension("html"),
        };
        let beside = out.parent().unwrap_or(Path::new(""));
        let page = page(&lines, &self.plan, beside, indices.as_ref()).into_string();
        fs::write(&out, page).with_context(|| out.display().to_string())?;
        say!("{}", out.display());
        Ok(())
    }
}

fn page(lines: &Lines, plan: &Path, beside: &Path, indices: Option<&Indices>) -> Markup {
    let about = &lines.description;
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { "wbqp: campaign " (about.name) }
                style { (PreEscaped(STYLE)) }
            }
            body {
                h1 { "Campaign " (about.name) }
                p.lead {
                    (lines.run.len()) " runs of " (about.points) " points in " (about.variants.len())
                    " variants. A run holds if it reaches its end and every measure that counts is within what is \
                     accepted. Intervals are Wilson's, with a confidence of 95 %."
                }
                (overview(lines))
                @for variant in &about.variants { (section(lines, variant, plan, beside)) }
                @if let Some(indices) = indices { (indices_section(indices)) }
                h2 { "Plan" }
                pre { (about.plan) }
                footer {
                    "wbqp " (env!("CARGO_PKG_VERSION")) ", fingerprint "
                    code { (about.fingerprint.chars().take(16).collect::<String>()) }
                    ". The same plan gives the same table on every machine and in any number of shards."
                }
            }
        }
    }
}

/// How many runs of each variant hold, and how the others ended.
fn overview(lines: &Lines) -> Markup {
    html! {
        h2 { "What holds" }
        div.scroll { table {
            thead { tr { th { "variant" } th { "runs" } th { "holds" } th { "completed" }
                th { "diverged" } th { "refused" } th { "failed" } } }
            tbody {
                @for variant in &lines.description.variants {
                    @let all = lines.of(variant);
                    @let count = |status: &str| all.iter().filter(|l| lines.status[**l] == status).count();
                    tr {
                        td { (variant) }
                        td.number { (all.len()) }
                        td.number { (Share::of_lines(&all, |l| lines.holds[l]).words()) }
                        @for status in ["completed", "diverged", "refused", "failed"] {
                            td.number { (count(status)) }
                        }
                    }
                }
            }
        } }
    }
}

fn section(lines: &Lines, variant: &str, plan: &Path, beside: &Path) -> Markup {
    let all = lines.of(variant);
    html! {
        h2 { "Variant " (variant) }
        (measures(lines, &all))
        (reasons(lines, &all))
        (effects(lines, &all))
        (worst(lines, &all, plan, beside))
    }
}

/// Each measure: share that holds, and its values.
fn measures(lines: &Lines, all: &[usize]) -> Markup {
    html! {
        div.scroll { table {
            thead { tr { th { "measure" } th { "accepted" } th { "holds" } th { "5 %" }
                th { "median" } th { "95 %" } th { "unit" } } }
            tbody {
                @for (index, column) in lines.measures() {
                    @let values = sorted(all.iter().filter_map(|l| lines.measured[index][*l]));
                    tr.aside[!column.counts] {
                        td { (column.name) }
                        td { (column.tolerance) }
                        td.number {
                            @if column.is_judged {
                                (Share::of_lines(all, |l| lines.verdicts[index][l] == Some(true)).words())
                            } @else { "–" }
                        }
                        @for p in [0.05, 0.5, 0.95] {
                            td.number { (quantile(&values, p).map_or("–".to_owned(), number)) }
                        }
                        td { (column.unit) }
                    }
                }
            }
        } }
    }
}

fn sorted(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut values: Vec<f64> = values.collect();
    values.sort_unstable_by(f64::total_cmp);
    values
}

/// Why runs ended early, alike reasons together: without their numbers.
fn reasons(lines: &Lines, all: &[usize]) -> Markup {
    let mut classes: BTreeMap<(String, String), (usize, i64)> = BTreeMap::new();
    for &line in all {
        if let Some(reason) = &lines.reason[line] {
            let class = (lines.status[line].clone(), without_numbers(reason));
            classes.entry(class).or_insert((0, lines.run[line])).0 += 1;
        }
    }
    let mut classes: Vec<_> = classes.into_iter().collect();
    classes.sort_by_key(|(_, (count, _))| std::cmp::Reverse(*count));
    html! {
        @if !classes.is_empty() {
            h3 { "Why runs ended early" }
            div.scroll { table {
                thead { tr { th { "runs" } th { "ended" } th { "why" } th { "first" } } }
                tbody {
                    @for ((status, class), (count, first)) in classes.iter().take(20) {
                        tr { td.number { (count) } td { (status) } td { (class) } td.number { "run " (first) } }
                    }
                }
            } }
        }
    }
}

/// A text with `#` for every number.
fn without_numbers(text: &str) -> String {
    let mut class = String::new();
    let mut in_number = false;
    let mut last = ' ';
    for c in text.chars() {
        let begins = c.is_ascii_digit() && !last.is_alphanumeric() && last != '_';
        let goes_on = in_number && (c.is_ascii_digit() || "._eE".contains(c));
        if begins && !in_number {
            class.push('#');
        }
        if !begins && !goes_on {
            class.push(c);
        }
        in_number = begins || goes_on;
        last = c;
    }
    class
}

/// Which factor breaks what: the share that holds over each factor's values, the strongest first, and maps over the
/// strongest two.
fn effects(lines: &Lines, all: &[usize]) -> Markup {
    let factors = lines.description.factors.iter().enumerate();
    let mut effects: Vec<figures::Effect<'_>> = factors
        .map(|(index, factor)| {
            let groups = groups(all, |line| lines.factors[index][line], GROUPS);
            let groups = groups.into_iter().map(|(low, high, inside)| {
                (low, high, Share::of_lines(&inside, |l| lines.holds[l]))
            });
            figures::Effect {
                index,
                name: &factor.name,
                relation: &factor.relation,
                groups: groups.collect(),
            }
        })
        .filter(|effect| effect.groups.len() > 1)
        .collect();
    effects.sort_by(|a, b| b.size().total_cmp(&a.size()));
    let failing: Vec<usize> = all.iter().copied().filter(|l| !lines.holds[*l]).collect();
    html! {
        @if !effects.is_empty() && !failing.is_empty() {
            h3 { "Which factor breaks it" }
            p { "The share of runs that hold, over groups of each factor's values; what the other factors are is \
                 averaged out. The strongest factor first." }
            div.grid { @for effect in &effects { (figures::effect(effect)) } }
            (by_measure(lines, all, &effects))
            @if let [first, second, ..] = effects.as_slice() {
                h3 { "Share that holds over " (first.name) " and " (second.name) }
                (figures::map(lines, all, first, second))
            }
        }
    }
}

/// How much each factor moves the share with which each measure holds: a table of the largest differences.
fn by_measure(lines: &Lines, all: &[usize], effects: &[figures::Effect<'_>]) -> Markup {
    let failing = lines.measures().filter(|(i, column)| {
        column.counts && all.iter().any(|l| lines.verdicts[*i][*l] != Some(true))
    });
    let failing: Vec<_> = failing.collect();
    html! {
        @if !failing.is_empty() {
            h3 { "Main effects by measure" }
            p { "Difference between the best and the worst group of a factor's values, in percent of the runs." }
            div.scroll { table {
                thead { tr { th { "measure" } @for effect in effects { th { (effect.name) } } } }
                tbody {
                    @for (index, column) in failing {
                        tr {
                            td.words { (column.name) }
                            @for effect in effects {
                                @let parts = groups(all, |l| lines.factors[effect.index][l], GROUPS);
                                @let shares = sorted(parts.iter().map(|(_, _, inside)| {
                                    Share::of_lines(inside, |l| lines.verdicts[index][l] == Some(true)).value()
                                }));
                                @let spread = shares.last().unwrap_or(&0.0) - shares.first().unwrap_or(&0.0);
                                td.number style={ "background:" (figures::shade(spread)) } {
                                    (format!("{:.0}", 100.0 * spread))
                                }
                            }
                        }
                    }
                }
            } }
        }
    }
}

/// The runs that miss most, with what does them again.
fn worst(lines: &Lines, all: &[usize], plan: &Path, beside: &Path) -> Markup {
    let mut failing: Vec<usize> = all.iter().copied().filter(|l| !lines.holds[*l]).collect();
    // Without a single measure a run has missed more than with all of them missed.
    failing.sort_by_key(|l| {
        (
            lines.status[*l] == "completed",
            std::cmp::Reverse(lines.missed(*l).len()),
        )
    });
    html! {
        @if !failing.is_empty() {
            h3 { "The worst runs" }
            p { code { "wbqp campaign " (plan.display()) " --run NUMBER" } " does a run again, with logs for Foxglove \
                 and dumps of the ticks in which the controller left its optimum, for " code { "wbqp replay" } "." }
            div.scroll { table {
                thead { tr { th { "run" } th { "missed" }
                    @for factor in &lines.description.factors { th { (factor.name) } } } }
                tbody {
                    @for &line in failing.iter().take(WORST) {
                        @let folder = format!("run-{}", lines.run[line]);
                        tr {
                            td.number {
                                @if beside.join(&folder).is_dir() {
                                    a href={ (folder) "/" } { (lines.run[line]) }
                                } @else { (lines.run[line]) }
                            }
                            td.words {
                                @match &lines.reason[line] {
                                    Some(reason) => (reason),
                                    None => (names(&lines.missed(line))),
                                }
                            }
                            @for factor in &lines.factors {
                                td.number { (factor[line].map_or("–".to_owned(), number)) }
                            }
                        }
                    }
                }
            } }
        }
    }
}

/// Names in a row.
fn names(columns: &[&Column]) -> String {
    let names: Vec<&str> = columns.iter().map(|column| column.name.as_str()).collect();
    names.join("; ")
}

fn indices_section(indices: &Indices) -> Markup {
    html! {
        h2 { "Sobol's indices" }
        p { "Share of a measure's variance that a factor explains alone (first order), and with all others (total)." }
        @for (measure, factors) in indices {
            h3 { (measure) }
            div.scroll { table {
                thead { tr { th { "factor" } th { "first order" } th { "total" } } }
                tbody { @for (factor, [first, total]) in factors {
                    tr { td { (factor) } td.number { (number(*first)) } td.number { (number(*total)) } }
                } }
            } }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reasons_that_differ_in_numbers_alone_are_one_class() {
        let one = without_numbers("robust: the plant diverged at 12.25 s");
        assert_eq!(one, without_numbers("robust: the plant diverged at 3.5 s"));
        assert_eq!(one, "robust: the plant diverged at # s");
        assert_eq!(
            without_numbers("task_2 asks 1e-3 N of x1"),
            "task_2 asks #-# N of x1"
        );
    }
}
