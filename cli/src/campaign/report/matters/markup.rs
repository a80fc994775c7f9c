//! What the page says of what matters.

use maud::{Markup, html};

use super::{Line, Matters, Told};

/// Of all runs that were looked at; or why there are none, in words.
pub(in super::super) fn section(all: &Result<Vec<Matters>, String>) -> Markup {
    html! {
        h2 { "What matters in a tick" }
        @match all {
            Err(why) => p { (why) },
            Ok(all) => {
                p { "Which weights and gains decide what the robot does where a run goes worst: the derivatives of the \
                     optimum of a single tick, by the logarithm of a weight or gain. One that is 1 % larger moves an \
                     output by a hundredth of what stands here, as long as the same limits are active. Of efforts, \
                     contact forces and accelerations it is the one that moves most; bars are the norm over all \
                     efforts. References are off by as much as they say, and move the outputs by what stands there." }
                p { "This is what the tick would have commanded, with the same past. It is not how a measure of the \
                     whole run changes: for that, make the weight a factor of the plan." }
                @for matters in all { (of_run(matters)) }
            }
        }
    }
}

fn of_run(matters: &Matters) -> Markup {
    let largest = |told: &Told| told.effects.first().map_or(0.0, |line| line.effort);
    let by_largest = |a: &&(_, Told), b: &&(_, Told)| largest(&a.1).total_cmp(&largest(&b.1));
    let most = matters.told.iter().max_by(by_largest);
    let most = most.map(|(moment, _)| moment.tick);
    html! {
        h3 {
            "Variant " (matters.variant)
            @if matters.case != matters.variant { ", case " (matters.case) }
            ": "
            @match matters.run {
                Some(number) => { "run " (number) ", the worst that reached its end" }
                None => "the scenario as it is",
            }
        }
        @for (moment, told) in &matters.told {
            details open[Some(moment.tick) == most] {
                summary { b { (format!("{:.2} s", moment.time)) } ", " (moment.why) (strongest(told)) }
                (of_tick(told))
            }
        }
    }
}

/// What matters most, for who does not open it.
fn strongest(told: &Told) -> Markup {
    html! {
        @if told.refused.is_some() { ": no derivatives" }
        @if let [first, second, ..] = told.effects.as_slice() {
            ": " em { (first.name) ", " (second.name) }
        }
    }
}

fn of_tick(told: &Told) -> Markup {
    html! {
        @if let Some(why) = &told.refused {
            p { "There are no derivatives here: " (why) "." }
        }
        @if !told.effects.is_empty() { (lines(&told.effects, "weight or gain")) }
        @if !told.references.is_empty() {
            (lines(&told.references, "reference"))
        }
        @if !told.limits.is_empty() {
            p { "Limits that hold the optimum back, the most expensive first: " (told.limits.join("; ")) "." }
        }
        @if !told.notes.is_empty() {
            p { "Where these derivatives do not hold as they stand: "
                (told.notes.join("; ")) "." }
        }
    }
}

fn lines(lines: &[Line], what: &str) -> Markup {
    let largest = lines.iter().map(|line| line.effort).fold(0.0, f64::max);
    html! {
        div.scroll { table {
            thead { tr { th { (what) } th { "" } th { "effort" } th { "force" } th { "acceleration" } } }
            tbody { @for line in lines {
                @let [acceleration, effort, force] = &line.strongest;
                tr {
                    td.line { (line.name) }
                    td { div.size style={ "width:" (format!("{:.1}", 6.0 * line.effort / largest)) "rem" } {} }
                    @for most in [effort, force, acceleration] { td.line { (most) } }
                }
            } }
        } }
    }
}
