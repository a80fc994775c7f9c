//! Progress bars.

use std::{
    io::{IsTerminal, stderr},
    sync::atomic::{AtomicU32, Ordering},
};

use indicatif::{MultiProgress, ProgressBar, ProgressStyle};

use crate::complain;

/// Progress of things that run side by side: bars below one another on a terminal, a line now and then elsewhere; both
/// on standard error.
#[derive(Debug)]
pub struct ProgressBars {
    bars: Option<MultiProgress>,
    /// Lines per bar where there is no terminal.
    lines: u32,
}

impl ProgressBars {
    /// Without bars yet. `lines` is how often each speaks where there is no terminal.
    pub fn new(lines: u32) -> Self {
        Self {
            bars: stderr().is_terminal().then(MultiProgress::new),
            lines: lines.max(1),
        }
    }

    /// A line that stays, above the bars.
    pub fn say(&self, line: &str) {
        let shown = self.bars.as_ref().map(|bars| bars.println(line));
        if !matches!(shown, Some(Ok(()))) {
            complain!("{line}");
        }
    }

    /// A bar at zero.
    pub fn start(&self, name: &str) -> Progress {
        let bar = self.bars.as_ref().map(|bars| {
            let style = ProgressStyle::with_template("{msg:36} {wide_bar} {percent:>3} %  {eta}")
                .unwrap_or_else(|_| ProgressStyle::default_bar());
            let bar = ProgressBar::new(1000)
                .with_style(style)
                .with_message(name.to_owned());
            bars.add(bar)
        });
        Progress {
            name: name.to_owned(),
            bar,
            lines: self.lines,
            printed: AtomicU32::new(0),
        }
    }
}

/// One bar of [`ProgressBars`].
#[derive(Debug)]
pub struct Progress {
    name: String,
    bar: Option<ProgressBar>,
    lines: u32,
    /// Lines so far.
    printed: AtomicU32,
}

impl Progress {
    /// The finished fraction, 0 to 1.
    pub fn update(&self, fraction: f64) {
        self.update_saying(fraction, "");
    }

    /// The finished fraction, 0 to 1, and what there is to say of it.
    pub fn update_saying(&self, fraction: f64, words: &str) {
        let fraction = fraction.clamp(0.0, 1.0);
        if let Some(bar) = &self.bar {
            bar.set_position((1000.0 * fraction) as u64);
            if !words.is_empty() {
                bar.set_message(format!("{}: {words}", self.name));
            }
            return;
        }
        let reached = (f64::from(self.lines) * fraction + 1e-9) as u32;
        if reached > self.printed.fetch_max(reached, Ordering::Relaxed) {
            let comma = if words.is_empty() { "" } else { ", " };
            let percent = 100 * reached / self.lines;
            complain!("{}: {percent} %{comma}{words}", self.name);
        }
    }

    /// Leaves the bar where it is.
    pub fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.abandon();
        }
    }
}
