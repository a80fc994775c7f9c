//! The sweep's part of the report.

use maud::{Markup, html};
use wbqp_measures::number;

use crate::sweep::{Factor, Point, Sweep, Swept, SweptRow, percent};

/// Tables and grids; how to run it if there is no sweep.
pub(super) fn section(sweep: Option<&Sweep>) -> Markup {
    html! {
        section id="sweep" {
            h2 { "How the rows hold up under variation" }
            @match sweep {
                None => p {
                    "The sweep varies thrust limit, friction, mass and a gain by up to 10 %. It was not run for these \
                     results: " code { "cargo run --release -- --sweep" } "."
                },
                Some(sweep) => (found(sweep)),
            }
        }
    }
}

fn found(sweep: &Sweep) -> Markup {
    let points = sweep.points.len();
    let combinations = sweep.combinations().count();
    html! {
        p {
            (points) " variations of every experiment, " (sweep.runs) " runs: as it ships, four quantities one at a \
             time at ± 5 and ± 10 %, and " (combinations) " random combinations of all four within ± 10 %. The largest \
             thrust f_max is the robot's and changes in plant and controller; friction and mass change in the plant \
             alone, so that the controller does not know of them; K_P is that of the base's rotation. The gains are \
             not tuned again."
        }
        p {
            span class="key y" { "✓" } "holds " span class="key n" { "✗" } "does not "
            span class="key x" { "–" } "the run diverged, or the scenario was refused"
        }
        @if combinations > 0 {
            details {
                summary { "The combinations" }
                ul { @for (number, point) in sweep.combinations() { li { (number) ": " (point.words()) } } }
            }
        }
        @for swept in &sweep.experiments {
            h3 { (swept.title) }
            (summary(sweep, swept))
            p {
                @if swept.constant() > 0 {
                    (swept.constant()) " more rows (weights, set points, references) hold with the same value in all "
                    (points) ". "
                }
            }
            @if swept.rows.iter().any(|row| row.count() < points) { (grid(sweep, swept)) }
            @if swept.stopped.iter().any(Option::is_some) {
                ul {
                    @for (point, why) in swept.stopped.iter().enumerate() {
                        @if let Some(why) = why { li { (sweep.name(point)) ": " (why) } }
                    }
                }
            }
        }
    }
}

fn summary(sweep: &Sweep, swept: &Swept) -> Markup {
    html! {
        div.scroll {
            table {
                thead {
                    tr {
                        th { "row" }
                        th { "quantity" }
                        th.n { "holds" }
                        th.n { "unvaried" }
                        th.n { "range" }
                        th { "unit" }
                        th { "accepted" }
                        th.n { "worst failure" }
                        th { "with" }
                    }
                }
                tbody {
                    @for row in swept.varying() {
                        @let worst = row.worst(&swept.stopped);
                        tr {
                            td.id { (row.id) }
                            td { (row.quantity) }
                            td.n { (row.count()) " of " (row.holds.len()) }
                            td.n { (row.measured.first().copied().flatten().map_or("–".to_owned(), number)) }
                            td.n { (row.range_text()) }
                            td { (super::unit(&row.unit)) }
                            td { (row.tolerance) }
                            td.n { (worst.as_ref().map_or("", |w| &w.value)) }
                            td { (worst.as_ref().map(|w| sweep.name(w.point)).unwrap_or_default()) }
                        }
                    }
                }
            }
        }
    }
}

/// Rows that do not always hold, against all variations.
fn grid(sweep: &Sweep, swept: &Swept) -> Markup {
    let alone = |factor: &Factor| {
        let of = |p: &&Point| p.scales.len() == 1 && p.scales.contains_key(factor);
        sweep.points.iter().filter(of).count()
    };
    let combinations = sweep.combinations().count();
    let head = |point: &Point, number: usize| match point.scales.values().next() {
        None => String::new(),
        Some(scale) if point.scales.len() == 1 => percent(*scale).replace(" %", ""),
        Some(_) => number.to_string(),
    };
    let first = sweep.points.len() - combinations;
    html! {
        div.scroll {
            table.grid {
                thead {
                    tr {
                        th {}
                        th { "–" }
                        @for factor in Factor::ALL.iter().filter(|f| alone(f) > 0) {
                            th colspan=(alone(factor)) { (factor.label()) " [%]" }
                        }
                        @if combinations > 0 { th colspan=(combinations) { "combination" } }
                    }
                    tr {
                        th {}
                        @for (i, point) in sweep.points.iter().enumerate() {
                            th title=(point.words()) { (head(point, (i + 1).saturating_sub(first))) }
                        }
                    }
                }
                tbody {
                    @for row in swept.rows.iter().filter(|r| r.count() < r.holds.len()) {
                        tr {
                            td.row title=(row.quantity) { b { (row.id) } " " (row.quantity) }
                            @for i in 0..sweep.points.len() { (cell(sweep, swept, row, i)) }
                        }
                    }
                }
            }
        }
    }
}

fn cell(sweep: &Sweep, swept: &Swept, row: &SweptRow, index: usize) -> Markup {
    let stopped = swept.stopped.get(index).is_some_and(Option::is_some);
    let holds = row.holds.get(index).copied().unwrap_or(false);
    let (class, mark) = match (stopped, holds) {
        (true, _) => ("cell x", "–"),
        (false, true) => ("cell y", "✓"),
        (false, false) => ("cell n", "✗"),
    };
    let class = if is_first_of_group(sweep, index) {
        format!("{class} first")
    } else {
        class.to_owned()
    };
    let value = row.measured.get(index).copied().flatten();
    let value = value.map_or_else(|| "nothing".to_owned(), number);
    let what = sweep.points.get(index).map(Point::words);
    html! {
        td class=(class) title={ (what.unwrap_or_default()) ": " (value) " " (super::unit(&row.unit)) } { (mark) }
    }
}

/// Whether the factors differ from those of the point before.
fn is_first_of_group(sweep: &Sweep, index: usize) -> bool {
    let factors = |i: usize| sweep.points.get(i).map(|p| p.scales.keys());
    let before = index.checked_sub(1).and_then(factors);
    !before.zip(factors(index)).is_some_and(|(a, b)| a.eq(b))
}
