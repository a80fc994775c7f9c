//! A signal over time and what is measured of it.

/// A signal: times in s, ascending, and values. Samples that a log does not have are NaN.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Series {
    /// Times, s.
    pub t: Vec<f64>,
    /// Values.
    pub y: Vec<f64>,
}

impl Series {
    /// The samples with `from ≤ t ≤ until` that exist.
    pub fn window(&self, from: f64, until: f64) -> Self {
        // Times come from nanoseconds: half a microsecond decides nothing but keeps the ends in.
        let slack = 5e-7;
        let inside = |t: f64| t >= from - slack && t <= until + slack;
        self.samples().filter(|(t, _)| inside(*t)).collect()
    }

    /// Another signal, value by value.
    pub fn map(&self, f: impl Fn(f64) -> f64) -> Self {
        Self {
            t: self.t.clone(),
            y: self.y.iter().map(|&y| f(y)).collect(),
        }
    }

    /// The samples of both at the same times (to 1 ns), subtracted.
    pub fn minus(&self, other: &Self) -> Self {
        let mut others = other.samples().peekable();
        let same = |t: f64, u: f64| (t - u).abs() < 1e-9;
        self.samples()
            .filter_map(|(t, y)| {
                while others.next_if(|(u, _)| *u < t && !same(t, *u)).is_some() {}
                let (_, other) = others.next_if(|(u, _)| same(t, *u))?;
                Some((t, y - other))
            })
            .collect()
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.t.len()
    }

    /// Whether there is no sample.
    pub fn is_empty(&self) -> bool {
        self.t.is_empty()
    }

    /// The samples that exist.
    pub fn samples(&self) -> impl Iterator<Item = (f64, f64)> {
        let all = self.t.iter().copied().zip(self.y.iter().copied());
        all.filter(|(_, y)| y.is_finite())
    }

    fn values(&self) -> impl Iterator<Item = f64> {
        self.samples().map(|(_, y)| y)
    }

    /// Mean; `None` without samples.
    pub fn mean(&self) -> Option<f64> {
        let n = self.values().count();
        (n > 0).then(|| self.values().sum::<f64>() / n as f64)
    }

    /// Root of the mean squared difference from `target`.
    pub fn rmse(&self, target: f64) -> Option<f64> {
        self.map(|y| (y - target).powi(2)).mean().map(f64::sqrt)
    }

    /// Largest value.
    pub fn max(&self) -> Option<f64> {
        self.values().reduce(f64::max)
    }

    /// Smallest value.
    pub fn min(&self) -> Option<f64> {
        self.values().reduce(f64::min)
    }

    /// The value that is farthest from `target`.
    pub fn farthest_from(&self, target: f64) -> Option<f64> {
        let distance = |y: &f64| (y - target).abs();
        self.values()
            .max_by(|a, b| distance(a).total_cmp(&distance(b)))
    }

    /// The value below which a fraction `p` of the samples lies.
    pub fn quantile(&self, p: f64) -> Option<f64> {
        let mut sorted: Vec<f64> = self.values().collect();
        sorted.sort_unstable_by(f64::total_cmp);
        let last = sorted.len().checked_sub(1)?;
        sorted.get((p * last as f64).round() as usize).copied()
    }

    /// Fraction of the samples for which `condition` holds.
    pub fn fraction(&self, condition: impl Fn(f64) -> bool) -> Option<f64> {
        self.map(|y| {
            if y.is_nan() {
                y
            } else {
                f64::from(u8::from(condition(y)))
            }
        })
        .mean()
    }

    /// First-order low pass with corner frequency `hz`, causal, starting at the first sample.
    pub fn low_pass(&self, hz: f64) -> Self {
        let mut last: Option<(f64, f64)> = None;
        self.samples()
            .map(|(t, y)| {
                let filtered = match last {
                    Some((t0, y0)) => {
                        y0 + (y - y0) * (1.0 - (-std::f64::consts::TAU * hz * (t - t0)).exp())
                    }
                    None => y,
                };
                last = Some((t, filtered));
                (t, filtered)
            })
            .collect()
    }

    /// Time of the last sample outside `target ± band`; `None` if none is outside.
    pub fn last_exit(&self, target: f64, band: f64) -> Option<f64> {
        let outside = self.samples().filter(|(_, y)| (y - target).abs() > band);
        outside.last().map(|(t, _)| t)
    }

    /// The stretches of time in which `condition` holds, from first to last sample of each.
    pub fn stretches(&self, condition: impl Fn(f64) -> bool) -> Vec<(f64, f64)> {
        let mut stretches: Vec<(f64, f64)> = Vec::new();
        let mut inside = false;
        for (t, y) in self.samples() {
            let now = condition(y);
            match stretches.last_mut() {
                Some(stretch) if inside && now => stretch.1 = t,
                _ if now => stretches.push((t, t)),
                _ => {}
            }
            inside = now;
        }
        stretches
    }
}

impl FromIterator<(f64, f64)> for Series {
    fn from_iter<I: IntoIterator<Item = (f64, f64)>>(samples: I) -> Self {
        let (t, y) = samples.into_iter().unzip();
        Self { t, y }
    }
}

#[cfg(test)]
mod tests {
    use super::Series;

    fn ramp() -> Series {
        (0..=100)
            .map(|k| (0.1 * f64::from(k), f64::from(k)))
            .collect()
    }

    #[test]
    fn windows_and_statistics() {
        let mut s = ramp();
        s.y[21] = f64::NAN;
        let w = s.window(2.0, 2.2);
        assert_eq!(w.y, [20.0, 22.0]);
        assert_eq!(w.mean(), Some(21.0));
        assert_eq!(w.rmse(21.0), Some(1.0));
        assert_eq!((w.min(), w.max()), (Some(20.0), Some(22.0)));
        assert_eq!(w.farthest_from(21.9), Some(20.0));
        assert_eq!(ramp().quantile(0.5), Some(50.0));
        assert_eq!(Series::default().mean(), None);
        assert_eq!(w.fraction(|y| y > 21.0), Some(0.5));
    }

    #[test]
    fn the_low_pass_forgets_with_its_time_constant() {
        let step: Series = (0..2000)
            .map(|k| (1e-3 * f64::from(k), if k == 0 { 0.0 } else { 1.0 }))
            .collect();
        let time_constant = 1.0 / (std::f64::consts::TAU * 2.0);
        let after = step.low_pass(2.0).window(time_constant, 2.0).y[0];
        assert!((after - (1.0 - (-1.0_f64).exp())).abs() < 0.01, "{after}");
    }

    #[test]
    fn exits_and_stretches() {
        let s = ramp();
        assert_eq!(s.last_exit(100.0, 50.0), Some(4.9));
        assert_eq!(s.last_exit(50.0, 50.0), None);
        let twice = s.stretches(|y| (y > 9.0 && y < 20.0) || y >= 99.0);
        assert_eq!(twice.len(), 2);
        assert!((twice[0].0 - 1.0).abs() < 1e-9 && (twice[1].1 - 10.0).abs() < 1e-9);
    }
}
