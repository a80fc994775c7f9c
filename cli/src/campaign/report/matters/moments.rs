//! The ticks of a run that are looked at.

use anyhow::Result;
use wbqp_campaign::Measure;
use wbqp_measures::Columns;
use wbqp_sim::scenario::Case;

use super::follow::Tracking;

/// What is shorter than this between two events is no phase of its own, s.
const SHORTEST: f64 = 0.25;
/// The first ticks are the start's, s: references and filters settle.
const SETTLING: f64 = 0.1;

/// A tick, and why it is looked at.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Moment {
    /// From 0.
    pub(super) tick: usize,
    /// Of that tick, s.
    pub(super) time: f64,
    pub(super) why: String,
}

/// Where each measure is found, and of each phase between two events the tick in which tasks are farthest from what
/// they follow; in the order of time.
pub(super) fn of(
    case: &Case,
    tracking: &Tracking,
    measures: &[&Measure],
    recorded: &Columns,
) -> Result<Vec<Moment>> {
    let mut moments = Vec::new();
    for measure in measures {
        let at = measure.moment(recorded)?;
        if let Some(tick) = at.and_then(|at| tracking.tick_at(at)) {
            let why = format!("where what {} measures is largest", measure.name());
            moments.push(Moment {
                tick,
                time: tracking.times[tick],
                why,
            });
        }
    }
    let boundaries = boundaries(case, tracking);
    for pair in boundaries.windows(2) {
        let [(from, begin), (until, end)] = pair else {
            continue;
        };
        if let Some(tick) = tracking.worst(from.max(SETTLING)..*until) {
            moments.push(Moment {
                tick,
                time: tracking.times[tick],
                why: format!("the largest tracking errors between {begin} and {end}"),
            });
        }
    }
    moments.sort_by_key(|moment| moment.tick);
    // Two reasons for one tick.
    moments.dedup_by(|next, first| {
        let is_same = next.tick == first.tick;
        if is_same {
            first.why = format!("{}; {}", first.why, next.why);
        }
        is_same
    });
    Ok(moments)
}

/// Times at which something happens, with names: events, disturbances, contacts that begin or end.
fn boundaries(case: &Case, tracking: &Tracking) -> Vec<(f64, String)> {
    let end = tracking.times.last().copied().unwrap_or(0.0);
    let mut boundaries = vec![(0.0, "the start".to_owned())];
    for event in case.events() {
        let name = event.mark.clone();
        let name = name.unwrap_or_else(|| "an event".to_owned());
        boundaries.push((event.at, name));
    }
    for disturbance in &case.plant().disturbances {
        let name = &disturbance.name;
        boundaries.push((disturbance.from, format!("the start of {name}")));
        boundaries.push((disturbance.until, format!("the end of {name}")));
    }
    boundaries.extend(tracking.switched.iter().cloned());
    boundaries.retain(|(at, _)| (0.0..end).contains(at));
    boundaries.sort_by(|a, b| a.0.total_cmp(&b.0));
    boundaries.dedup_by(|next, first| next.0 - first.0 < SHORTEST);
    boundaries.push((end, "the end".to_owned()));
    for (at, name) in &mut boundaries {
        *name = format!("{name} ({at:.2} s)");
    }
    boundaries
}
