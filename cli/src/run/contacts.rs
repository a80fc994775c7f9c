//! What the contacts of a run bore.

use anyhow::Result;
use serde::Serialize;
use wbqp::Controller;
use wbqp_measures::{Recording, Series, log::Log};

use super::{tasks::END, traces::columns};

/// What a contact bore.
#[derive(Clone, Debug, Serialize)]
pub struct ContactSummary {
    /// Its name.
    pub name: String,
    /// Share of the run during which it was on.
    pub on: f64,
    /// Share of the run during which a surface pushed it.
    pub touched: f64,
    /// The longest time, s, from when it comes on, or lets go, to when it touches or goes off, as far as it was planned
    /// to push in it.
    pub in_the_air: f64,
    /// Mean real normal force over the last tenth of the run, N; absent if it was not on for all of that.
    pub end_real: Option<f64>,
    /// Mean of what its force task wanted then, N; absent without such a task.
    pub end_wanted: Option<f64>,
    /// Largest planned normal force, N.
    pub peak_planned: Option<f64>,
    /// Largest real normal force, N.
    pub peak_real: Option<f64>,
    /// The least, N: below zero if something pressed from behind the contact's surface.
    pub least_real: Option<f64>,
}

impl ContactSummary {
    /// Of all contacts, in the configuration's order.
    ///
    /// # Errors
    /// A log that cannot be read.
    pub(super) fn of_all(log: &Log, controller: &Controller) -> Result<Vec<Self>> {
        let mut contacts = Vec::new();
        for name in controller.contact_names() {
            let pointers = ["/active", "/reference/z", "/solution/z", "/truth/z"];
            let pointers = pointers.map(str::to_owned);
            let columns = columns(log, &format!("/contact/{name}"), &pointers)?;
            if let [on, wanted, planned, real] = columns.as_slice() {
                let at_end =
                    |series: &Series| series.window(log.end() * (1.0 - END), f64::INFINITY);
                // What is NaN, of a tick without a solution, says nothing else.
                let stays_on = at_end(on).min() == Some(1.0);
                let mean_at_end = |series| at_end(series).mean().filter(|_| stays_on);
                contacts.push(Self {
                    name: name.to_owned(),
                    on: on.mean().unwrap_or(0.0),
                    touched: share_above_zero(real),
                    in_the_air: longest_in_the_air(on, planned, real),
                    end_real: mean_at_end(real),
                    end_wanted: mean_at_end(wanted),
                    peak_planned: planned.max(),
                    peak_real: real.max(),
                    least_real: real.min(),
                });
            }
        }
        Ok(contacts)
    }

    /// What it bore at the end, and what it should have borne, in words.
    pub(super) fn at_end(&self) -> String {
        match (self.end_real, self.end_wanted) {
            (Some(real), Some(wanted)) => format!("{real:.2} of {wanted:.2} N"),
            (Some(real), None) => format!("{real:.1} N"),
            (None, _) => "–".to_owned(),
        }
    }
}

/// Of a contact's three series, which have the same times.
fn longest_in_the_air(on: &Series, planned: &Series, real: &Series) -> f64 {
    let (mut longest, mut time, mut last) = (0.0_f64, 0.0, f64::NAN);
    let forces = planned.y.iter().zip(&real.y);
    for ((t, on), (planned, real)) in on.t.iter().zip(&on.y).zip(forces) {
        // In a tick without a solution nothing is known of the plan, and the contact is as it was.
        if *on == 0.0 || *real > 0.0 {
            time = 0.0;
        } else if *planned > 0.0 && last.is_finite() {
            time += t - last;
        }
        longest = longest.max(time);
        last = *t;
    }
    longest
}

/// Of the samples.
fn share_above_zero(series: &Series) -> f64 {
    let count = series.y.iter().filter(|y| **y > 0.0).count();
    count as f64 / series.y.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use wbqp_measures::Series;

    use super::longest_in_the_air;

    #[test]
    fn a_plan_of_nothing_is_no_touch() {
        let series = |y: [f64; 8]| -> Series { (0..8).map(f64::from).zip(y).collect() };
        let on = series([1.0; 8]);
        let planned = series([3.0, 3.0, 0.0, 3.0, f64::NAN, 3.0, 3.0, 3.0]);
        let real = series([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 9.0, 0.0]);
        assert_eq!(longest_in_the_air(&on, &planned, &real), 3.0);
        let off = series([0.0; 8]);
        assert_eq!(longest_in_the_air(&off, &planned, &real), 0.0);
    }
}
