//! Small figures of shares, as SVG.

use maud::{Markup, html};
use wbqp_measures::number;

use super::findings::{Effect, Map};

const WIDTH: f64 = 250.0;
const HEIGHT: f64 = 130.0;
const LEFT: f64 = 34.0;
const TOP: f64 = 8.0;

/// Bars from 0 to 100 % with their intervals.
pub(super) fn effect(effect: &Effect, name: &str, relation: &str) -> Markup {
    let width = (WIDTH - LEFT) / effect.groups.len() as f64;
    let y = |share: f64| TOP + (1.0 - share) * HEIGHT;
    let x = |i: usize| LEFT + width * i as f64;
    let first = effect.groups.first().map_or(0.0, |g| g.0);
    let last = effect.groups.last().map_or(0.0, |g| g.1);
    html! {
        figure {
            figcaption { b { (name) } " (" (relation) ")" }
            svg viewBox={ "0 0 " (WIDTH + 6.0) " " (TOP + HEIGHT + 20.0) }
                role="img" aria-label={ "share that holds over " (name) } {
                @for tick in [0.0, 0.5, 1.0] {
                    line.axis x1=(LEFT) x2=(WIDTH) y1=(y(tick)) y2=(y(tick)) {}
                    text x=(LEFT - 4.0) y=(y(tick) + 4.0) text-anchor="end" { (format!("{:.0} %", 100.0 * tick)) }
                }
                @for (i, (low, high, share)) in effect.groups.iter().enumerate() {
                    rect.bar x=(x(i) + 2.0) width=(width - 4.0) y=(y(share.value())) height=(HEIGHT * share.value()) {
                        title { (number(*low)) " to " (number(*high)) ": " (share.words()) }
                    }
                    line.interval x1=(x(i) + width / 2.0) x2=(x(i) + width / 2.0)
                        y1=(y(share.low)) y2=(y(share.high)) {}
                }
                text x=(LEFT) y=(TOP + HEIGHT + 15.0) { (number(first)) }
                text x=(WIDTH) y=(TOP + HEIGHT + 15.0) text-anchor="end" { (number(last)) }
            }
        }
    }
}

/// The share that holds over two factors of these names.
pub(super) fn map(map: &Map, across: &str, up: &str) -> Markup {
    let side = 74.0;
    let left = 96.0;
    let (width, height) = (
        side * map.columns.len() as f64,
        30.0 * map.rows.len() as f64,
    );
    html! {
        svg.map viewBox={ "0 0 " (left + width + 10.0) " " (height + 46.0) }
            style={ "max-width:" (left + width + 10.0) "px" } role="img" {
            @for (j, ((low, high), cells)) in map.rows.iter().zip(&map.cells).enumerate() {
                @let top = height - 30.0 * (j as f64 + 1.0);
                text x=(left - 6.0) y=(top + 19.0) text-anchor="end" { (range(*low, *high)) }
                @for (i, share) in cells.iter().enumerate() {
                    rect x=(left + side * i as f64) y=(top) width=(side - 1.0) height="29"
                        fill=(if share.of == 0 { "#eee".to_owned() } else { color(share.value()) }) {
                        title { (share.words()) ", " (share.of) " runs" }
                    }
                    @if share.of > 0 {
                        text.cell x=(left + side * (i as f64 + 0.5)) y=(top + 19.0) text-anchor="middle" {
                            (format!("{:.0}", 100.0 * share.value()))
                        }
                    }
                }
            }
            @for (i, (low, high)) in map.columns.iter().enumerate() {
                text x=(left + side * (i as f64 + 0.5)) y=(height + 14.0) text-anchor="middle" font-size="9" {
                    (range(*low, *high))
                }
            }
            text x=(left + width / 2.0) y=(height + 34.0) text-anchor="middle" {
                (across) " →, up: " (up) "; percent that hold"
            }
        }
    }
}

fn range(low: f64, high: f64) -> String {
    if low == high {
        return number(low);
    }
    format!("{}…{}", short(low), short(high))
}

/// Three significant digits.
fn short(value: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    let magnitude = value.abs().log10().floor();
    if (4.0..6.0).contains(&magnitude) {
        return format!("{:.0}k", value / 1e3);
    }
    if !(-4.0..6.0).contains(&magnitude) {
        return format!("{value:.1e}");
    }
    let decimals = (2.0 - magnitude).clamp(0.0, 6.0) as usize;
    format!("{value:.decimals$}")
}

/// From red (none holds) over a light yellow to green (all hold).
fn color(share: f64) -> String {
    let mix = |from: [f64; 3], to: [f64; 3], t: f64| {
        let [r, g, b] = std::array::from_fn(|i| (from[i] + (to[i] - from[i]) * t).round() as u8);
        format!("#{r:02x}{g:02x}{b:02x}")
    };
    let (red, light, green) = (
        [201.0, 84.0, 72.0],
        [246.0, 232.0, 176.0],
        [92.0, 169.0, 120.0],
    );
    if share < 0.5 {
        mix(red, light, 2.0 * share)
    } else {
        mix(light, green, 2.0 * share - 1.0)
    }
}

/// Behind a number from 0 to 1 that is the worse the larger.
pub(super) fn shade(size: f64) -> String {
    format!("rgba(201, 84, 72, {:.2})", 0.7 * size.clamp(0.0, 1.0))
}
