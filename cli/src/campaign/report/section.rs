//! What the page says of a variant.

use std::path::Path;

use maud::{Markup, html};
use wbqp_campaign::{Gaps, table::Description};
use wbqp_measures::number;

use super::{
    figures,
    findings::{ENDS, Findings, Measured, REFUSED},
    reasons::Reason,
    statistics::Share,
};

/// How many runs of each variant hold, and how the others ended.
pub(super) fn overview(all: &[Findings]) -> Markup {
    let others = || ENDS.iter().enumerate().filter(|(end, _)| *end != REFUSED);
    html! {
        h2 { "What holds" }
        div.scroll { table {
            thead { tr { th { "variant" } th { "runs" } th { "refused" } th { "simulated" } th { "of these hold" }
                @for (_, end) in others() { th { (end) } } } }
            tbody {
                @for found in all {
                    tr {
                        td { (found.variant) }
                        td.number { (found.ended.iter().sum::<usize>()) }
                        td.number.refused[found.ended[REFUSED] > 0] { (found.ended[REFUSED]) }
                        td.number { (found.holds.of) }
                        td.number { (found.holds.words()) }
                        @for (end, _) in others() { td.number { (found.ended[end]) } }
                    }
                }
            }
        } }
    }
}

/// A variant's part of the page; `plan` is the plan's file, `beside` the page's folder.
pub(super) fn section(found: &Findings, about: &Description, plan: &Path, beside: &Path) -> Markup {
    html! {
        h2 { "Variant " (found.variant) }
        (refused(found))
        (measures(found, about))
        (reasons(found))
        (effects(found, about))
        (worst(found, about, plan, beside))
    }
}

/// Each measure: share that holds, and its values.
fn measures(found: &Findings, about: &Description) -> Markup {
    html! {
        div.scroll { table {
            thead { tr { th { "measure" } th { "accepted" } th { "holds" } th { "5 %" }
                th { "median" } th { "95 %" } th { "unit" } th { "without a value" } } }
            tbody {
                @for (column, measured) in about.measures.iter().zip(&found.measures) {
                    tr.aside[!column.counts] {
                        td { (column.name) (covered(column.gaps, measured)) }
                        td { (column.tolerance) }
                        td.number { (measured.holds.map_or("–".to_owned(), Share::words)) }
                        @for value in measured.quantiles {
                            td.number { (value.map_or("–".to_owned(), number)) }
                        }
                        td { (column.unit) }
                        td.number { (measured.without) }
                    }
                }
            }
        } }
    }
}

/// Of a measure that may be of less than its window: of how much.
fn covered(gaps: Gaps, measured: &Measured) -> Markup {
    let what = match gaps {
        Gaps::NoValue => return html! {},
        Gaps::Hold => "the last value goes on in gaps",
        Gaps::Skip => "gaps are left out",
    };
    html! {
        @if let Some(least) = measured.least_covered {
            br; small { (what) "; at least " (format!("{:.1} %", floored(100.0 * least))) " of the window is there" }
        }
    }
}

/// With one digit, never more than it is: what is not all does not look like it.
fn floored(percent: f64) -> f64 {
    (10.0 * percent).floor() / 10.0
}

/// Runs that were not simulated, if there are any: what is not known of the variant.
fn refused(found: &Findings) -> Markup {
    let count = found.ended[REFUSED];
    html! {
        @if let Some((run, why)) = &found.reasons.first_refused {
            p.refused {
                b { (count) " of " (found.ended.iter().sum::<usize>()) " runs were refused" }
                ": they were never simulated, say nothing of the controller, and are in no share, no effect and no map \
                 below. The first, run " (run) ": " (why)
            }
            @if found.reasons.refused.len() > 1 { (reason_table(&found.reasons.refused)) }
        }
    }
}

/// Why runs ended early or lack a value, alike reasons together: without their numbers.
fn reasons(found: &Findings) -> Markup {
    html! {
        @if !found.reasons.simulated.is_empty() {
            h3 { "Why runs ended early, or have no value of a measure" }
            (reason_table(&found.reasons.simulated))
        }
    }
}

fn reason_table(reasons: &[Reason]) -> Markup {
    html! {
        div.scroll { table {
            thead { tr { th { "runs" } th { "ended" } th { "why" } th { "first" } } }
            tbody {
                @for reason in reasons {
                    tr {
                        td.number { (reason.count) }
                        td { (reason.ended) }
                        td { (reason.why) }
                        td.number { "run " (reason.first) }
                    }
                }
            }
        } }
    }
}

/// Which factor breaks what: the share that holds over each factor's values, the strongest first, and maps over the
/// strongest two.
fn effects(found: &Findings, about: &Description) -> Markup {
    let name = |factor: usize| about.factors.get(factor).map_or("", |f| f.name.as_str());
    let relation = |factor: usize| {
        let factor = about.factors.get(factor);
        factor.map_or("", |f| f.relation.as_str())
    };
    html! {
        @if !found.effects.is_empty() {
            h3 { "Which factor breaks it" }
            p { "The share of runs that hold, over groups of each factor's values; what the other factors are is \
                 averaged out. The strongest factor first." }
            div.grid { @for effect in &found.effects {
                (figures::effect(effect, name(effect.factor), relation(effect.factor)))
            } }
            (by_measure(found, &name))
            @if let (Some(map), [first, second, ..]) = (&found.map, found.effects.as_slice()) {
                @let [first, second] = [first, second].map(|effect| name(effect.factor));
                h3 { "Share that holds over " (first) " and " (second) }
                (figures::map(map, first, second))
            }
        }
    }
}

/// How much each factor moves the share with which each measure holds: a table of the largest differences.
fn by_measure<'a>(found: &Findings, name: &impl Fn(usize) -> &'a str) -> Markup {
    html! {
        @if !found.by_measure.is_empty() {
            h3 { "Main effects by measure" }
            p { "Difference between the best and the worst group of a factor's values, in percent of the runs." }
            div.scroll { table {
                thead { tr { th { "measure" } @for effect in &found.effects { th { (name(effect.factor)) } } } }
                tbody {
                    @for (measure, spreads) in &found.by_measure {
                        tr {
                            td.words { (measure) }
                            @for spread in spreads {
                                td.number style={ "background:" (figures::shade(*spread)) } {
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
fn worst(found: &Findings, about: &Description, plan: &Path, beside: &Path) -> Markup {
    html! {
        @if !found.worst.is_empty() {
            h3 { "The worst runs" }
            p { (found.worst.len()) " of " (found.holds.of - found.holds.count) " that do not hold: first those that \
                 did not reach their end, then those with the most measures missed, by most." }
            p { code { "wbqp campaign " (plan.display()) " --run NUMBER" } " does a run again, with logs for Foxglove \
                 and dumps of the ticks in which the controller left its optimum, for " code { "wbqp replay" } "." }
            div.scroll { table {
                thead { tr { th { "run" } th { "missed" }
                    @for factor in &about.factors { th { (factor.name) } } } }
                tbody {
                    @for run in &found.worst {
                        @let folder = format!("run-{}", run.run);
                        tr {
                            td.number {
                                @if beside.join(&folder).is_dir() {
                                    a href={ (folder) "/" } { (run.run) }
                                } @else { (run.run) }
                            }
                            td.words {
                                @if let Some(reason) = &run.reason { (reason) }
                                @if run.reason.is_some() && run.completed { "; " }
                                @if run.reason.is_none() || run.completed { (missed(&run.missed, about)) }
                            }
                            @for value in &run.factors {
                                td.number { (if value.is_nan() { "–".to_owned() } else { number(*value) }) }
                            }
                        }
                    }
                }
            } }
        }
    }
}

/// Measures that do not hold, with their values.
fn missed(missed: &[(String, f64)], about: &Description) -> String {
    let one = |(name, value): &(String, f64)| {
        let unit = about.measures.iter().find(|measure| measure.name == *name);
        let unit = unit.map_or("", |measure| measure.unit.as_str());
        if value.is_nan() {
            format!("{name}: no value")
        } else {
            format!("{name}: {} {unit}", number(*value))
                .trim_end()
                .to_owned()
        }
    };
    missed.iter().map(one).collect::<Vec<_>>().join("; ")
}
