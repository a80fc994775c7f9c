//! What a run has of a measure's window: the values, and what is missing.
//!
//! A tick without a solution has no reference, no task and no planned force. What is left out in silence would make a
//! measure better the longer its run has no solution, so every tick of the window is looked at.

use wbqp_measures::Series;

/// A signal of a measure over a whole run.
#[derive(Debug)]
pub(super) struct Channel {
    /// As the plan has it, for who reads why there is no value: `d` (/contact/tip.reference.z).
    pub(super) called: String,
    pub(super) series: Series,
}

/// What becomes of a tick in which a signal has no value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Otherwise {
    /// It has none.
    Nothing,
    /// The signal's last value goes on.
    Last,
}

/// The ticks of a window.
#[derive(Debug, Default)]
pub(super) struct Window {
    /// From when until when, s: of the run where nothing else was asked for.
    pub(super) ends: [f64; 2],
    /// Values of the ticks that have one.
    pub(super) values: Series,
    /// Number of ticks.
    pub(super) ticks: usize,
    /// How many of them have a value of their own, nothing of it from an earlier tick.
    pub(super) own: usize,
    /// Whether the last tick has a value.
    pub(super) has_last: bool,
    /// What has no value of its own first, and when, s.
    lack: Option<(String, f64)>,
}

/// Times come from nanoseconds: half a microsecond decides nothing but keeps the ends in.
const SLACK: f64 = 5e-7;

impl Window {
    /// Computes an expression of the channels in every tick from `from` until `until`.
    pub(super) fn of(
        ticks: &[f64],
        channels: &[Channel],
        otherwise: Otherwise,
        [from, until]: [f64; 2],
        compute: impl Fn(&[f64]) -> f64,
    ) -> Self {
        let mut next = vec![0; channels.len()];
        let mut last: Vec<Option<f64>> = vec![None; channels.len()];
        let mut values = Vec::with_capacity(channels.len());
        let end = ticks.last().copied().unwrap_or(0.0);
        let mut window = Self {
            ends: [
                if from.is_finite() { from } else { 0.0 },
                if until.is_finite() { until } else { end },
            ],
            ..Self::default()
        };
        // An earlier tick may have the value that goes on.
        for &time in ticks.iter().take_while(|time| **time <= until + SLACK) {
            values.clear();
            let mut lacking = None;
            for (channel, (next, last)) in channels.iter().zip(next.iter_mut().zip(&mut last)) {
                let own = at(&channel.series, time, next);
                if own.is_none() {
                    lacking.get_or_insert(channel.called.as_str());
                }
                let kept = if otherwise == Otherwise::Last {
                    *last
                } else {
                    None
                };
                *last = own.or(*last);
                values.extend(own.or(kept));
            }
            if time < from - SLACK {
                continue;
            }
            window.ticks += 1;
            let value = (values.len() == channels.len()).then(|| compute(&values));
            let value = value.filter(|value| value.is_finite());
            if value.is_none() {
                lacking.get_or_insert("its expression");
            }
            window.has_last = value.is_some();
            match lacking {
                None => window.own += 1,
                Some(what) if window.lack.is_none() => window.lack = Some((what.to_owned(), time)),
                Some(_) => {}
            }
            if let Some(value) = value {
                window.values.t.push(time);
                window.values.y.push(value);
            }
        }
        window
    }

    /// Share of the ticks that have a value of their own; of none, none.
    pub(super) fn covered(&self) -> f64 {
        self.own as f64 / self.ticks.max(1) as f64
    }

    /// What is missing, in words.
    pub(super) fn lack(&self) -> Option<String> {
        let (what, time) = self.lack.as_ref()?;
        let missing = self.ticks - self.own;
        Some(format!(
            "{what} has no value in {missing} of the {} ticks of its window ({:.3} to {:.3} s), first at {time:.3} s",
            self.ticks, self.ends[0], self.ends[1]
        ))
    }
}

/// The value of a series at a time, if it has one; `next` is where to look on, for times that ascend.
fn at(series: &Series, time: f64, next: &mut usize) -> Option<f64> {
    while series.t.get(*next).is_some_and(|u| *u < time - 1e-9) {
        *next += 1;
    }
    let is_there = (series.t.get(*next)? - time).abs() < 1e-9;
    let value = series.y.get(*next).filter(|value| value.is_finite());
    value.copied().filter(|_| is_there)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn channel(name: &str, samples: &[(f64, f64)]) -> Channel {
        Channel {
            called: format!("`{name}`"),
            series: samples.iter().copied().collect(),
        }
    }

    fn window(otherwise: Otherwise, ends: [f64; 2]) -> Window {
        let ticks = [0.0, 1.0, 2.0, 3.0, 4.0];
        let every = ticks.map(|t| (t, 10.0 + t));
        let channels = [
            channel("f", &every),
            // One message is missing, and one has no such field.
            channel("d", &[(0.0, 1.0), (1.0, 2.0), (3.0, f64::NAN), (4.0, 5.0)]),
        ];
        Window::of(&ticks, &channels, otherwise, ends, |x| x[0] - x[1])
    }

    #[test]
    fn every_tick_of_the_window_counts() {
        let part = window(Otherwise::Nothing, [1.0, 3.0]);
        assert_eq!((part.ticks, part.own, part.has_last), (3, 1, false));
        assert_eq!(part.values.y, [9.0]);
        assert_eq!(
            part.lack().unwrap(),
            "`d` has no value in 2 of the 3 ticks of its window (1.000 to 3.000 s), first at 2.000 s"
        );
        let whole = window(Otherwise::Nothing, [0.0, 1.0]);
        assert_eq!((whole.ticks, whole.own, whole.lack()), (2, 2, None));
        let none = window(Otherwise::Nothing, [7.0, 9.0]);
        assert_eq!((none.ticks, none.covered()), (0, 0.0));
    }

    #[test]
    fn the_last_value_goes_on_also_from_before_the_window() {
        let held = window(Otherwise::Last, [2.0, f64::INFINITY]);
        assert_eq!(held.values.y, [10.0, 11.0, 9.0]);
        assert_eq!((held.ticks, held.own, held.ends), (3, 1, [2.0, 4.0]));
        assert!(held.lack().unwrap().contains("in 2 of the 3 ticks"));
    }

    #[test]
    fn what_cannot_be_computed_is_missing_too() {
        let ticks = [0.0, 1.0];
        let channels = [channel("f", &[(0.0, 1.0), (1.0, -1.0)])];
        let roots = Window::of(&ticks, &channels, Otherwise::Last, [0.0, 1.0], |x| {
            x[0].sqrt()
        });
        assert!(
            roots
                .lack()
                .unwrap()
                .starts_with("its expression has no value in 1 of the 2")
        );
        assert_eq!(roots.values.len(), 1);
    }
}
