//! Which way weights and gains would have to change for a task to follow better: a gradient from one run.
//!
//! # Notation
//! `z = (δp, δφ, δq; δv)` is a small displacement of the state, world axes; θ a weight or a gain, e the task's error.
//!
//! # Mathematics
//! The accelerations that a tick decides on are a function of the state and of θ, and [`Sensitivity`] has its
//! derivatives. With the acceleration held for a period h, as the robot holds it, a change of θ moves the states of the
//! following ticks by
//! ```text
//! δv̇ = ∂v̇/∂z z + ∂v̇/∂θ
//! δv ← δv + h δv̇
//! (δp, δφ, δq) ← (δp, δφ, δq) + h δv + ½ h² δv̇ + h (0, ω × δφ, 0)
//! ```
//! and the mean of e² by the mean of `2 e ∂e/∂z z`: a linearisation of the closed loop along a run in which the model
//! is right. What actuators lag, what a wall gives way, and what integrals and filters remember is not in it: it is a
//! direction of descent, which a run confirms. (DiffTune, Cheng et al., arXiv 2209.10021, does the same with
//! derivatives of controllers that are written by hand.)
#![allow(non_snake_case)]

use nalgebra::{DMatrix, DVector, Vector3};

use wbqp::{
    controller::{Controller, ParameterKind, RequestError, Sensitivity, Snapshot},
    model::Base,
};
use wbqp_log::{LogError, LogSink, TrueContact};

use crate::Watcher;

/// Follows a run, and says how the mean square of a task's error changes with each weight and gain.
///
/// Every tick costs a [`Controller::sensitivity`], hundreds of ticks' time.
#[derive(Debug)]
pub struct ErrorGradient {
    task: String,
    /// Rows of the task's error; all if there are none.
    rows: Vec<usize>,
    along: Option<Along>,
    ticks: Vec<Tick>,
    skipped: usize,
}

/// A tick's part.
#[derive(Debug)]
struct Tick {
    time: f64,
    /// Sum of the rows' squares.
    square: f64,
    /// Its derivatives, one per parameter.
    slopes: Vec<f64>,
}

/// What is carried along the run.
#[derive(Debug)]
struct Along {
    sensitivity: Sensitivity,
    period: f64,
    /// Columns of the sensitivities: weights and gains, and the state.
    columns: Vec<usize>,
    state: Vec<usize>,
    /// Rows of all errors that are the task's.
    errors: Vec<usize>,
    index: usize,
    floating: bool,
    /// Positions above velocities, one column per weight and gain.
    z: DMatrix<f64>,
    vdot: DMatrix<f64>,
}

/// Of a weight or a gain.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct GradientEntry {
    /// The task or constraint.
    pub owner: String,
    /// Which number: `weight[x]`, `kp`.
    pub label: String,
    /// Its value at the end of the run.
    pub value: f64,
    /// Derivative of the mean square of the error, the error's unit squared per unit of the number.
    pub slope: f64,
}

/// What a run says.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Gradient {
    /// Mean over the ticks of the sum of the rows' squares.
    pub mean_square: f64,
    /// All weights and gains.
    pub entries: Vec<GradientEntry>,
    /// Ticks without derivatives, over which the state's displacement coasted.
    pub skipped: usize,
}

impl ErrorGradient {
    /// Of a task's error, of some of its rows or, if none is named, of all.
    pub fn new(task: &str, rows: &[usize]) -> Self {
        Self {
            task: task.to_owned(),
            rows: rows.to_vec(),
            along: None,
            ticks: Vec::new(),
            skipped: 0,
        }
    }

    /// How many rows of the task's error are followed, after a run.
    pub fn rows(&self) -> usize {
        self.along.as_ref().map_or(0, |along| along.errors.len())
    }

    /// Over the ticks from one time to another, s; nothing if there is no such tick, or no such task.
    pub fn between(&self, from: f64, until: f64) -> Option<Gradient> {
        let along = self.along.as_ref()?;
        let ticks = || {
            let inside = |tick: &&Tick| (from..=until).contains(&tick.time);
            self.ticks.iter().filter(inside)
        };
        let count = ticks().count();
        if count == 0 {
            return None;
        }
        let mean = |of: &dyn Fn(&Tick) -> f64| ticks().map(of).sum::<f64>() / count as f64;
        let parameters = along.sensitivity.parameters();
        let entry = |(i, column): (usize, &usize)| {
            let parameter = parameters.get(*column)?;
            Some(GradientEntry {
                owner: parameter.owner.clone(),
                label: parameter.label.clone(),
                value: parameter.value,
                slope: mean(&|tick| tick.slopes.get(i).copied().unwrap_or(0.0)),
            })
        };
        Some(Gradient {
            mean_square: mean(&|tick| tick.square),
            entries: along.columns.iter().enumerate().filter_map(entry).collect(),
            skipped: self.skipped,
        })
    }
}

impl Along {
    fn new(controller: &mut Controller, task: &str, rows: &[usize]) -> Option<Self> {
        let sensitivity = Sensitivity::new(controller);
        let of_kind = |kinds: &[ParameterKind]| -> Vec<usize> {
            let all = sensitivity.parameters().iter().enumerate();
            let wanted = all.filter(|(_, p)| kinds.contains(&p.kind));
            wanted.map(|(column, _)| column).collect()
        };
        let columns = of_kind(&[ParameterKind::Weight, ParameterKind::Gain]);
        let state = of_kind(&[ParameterKind::State]);
        let own = sensitivity.error_rows().iter().enumerate();
        let own = own.filter(|(_, row)| row.owner == task).map(|(i, _)| i);
        let is_wanted = |row: &usize| rows.is_empty() || rows.contains(row);
        let errors: Vec<usize> = own
            .enumerate()
            .filter(|(row, _)| is_wanted(row))
            .map(|(_, i)| i)
            .collect();
        let index = controller.entry(task).ok()?.index();
        let model = &controller.robot().model;
        let nv = model.nv();
        Some(Self {
            period: 1.0 / controller.settings().rate,
            floating: matches!(model.base(), Base::Floating),
            z: DMatrix::zeros(2 * nv, columns.len()),
            vdot: DMatrix::zeros(nv, columns.len()),
            columns,
            state,
            errors,
            index,
            sensitivity,
        })
    }

    /// What the tick's errors say, with the states as far as they have moved; then moves them on.
    fn tick(&mut self, controller: &mut Controller, rows: &[usize]) -> Result<Tick, RequestError> {
        controller.sensitivity(&mut self.sensitivity)?;
        let (all, errors) = (self.sensitivity.derivatives(), self.sensitivity.errors());
        let report = controller.report();
        let own = report.tasks.get(self.index);
        let own = own.map_or(&[][..], |task| &task.error);
        let wanted = own.iter().enumerate();
        let wanted = wanted.filter(|(row, _)| rows.is_empty() || rows.contains(row));
        let values: Vec<f64> = wanted.map(|(_, error)| *error).collect();
        let mut slopes = vec![0.0; self.columns.len()];
        for (&row, &error) in self.errors.iter().zip(&values) {
            for (s, &column) in self.state.iter().enumerate() {
                let slope = 2.0 * error * errors[(row, column)];
                for (out, z) in slopes.iter_mut().zip(self.z.row(s).iter()) {
                    *out += slope * z;
                }
            }
        }
        let nv = self.vdot.nrows();
        for (j, &column) in self.columns.iter().enumerate() {
            let mut vdot = DVector::from(all.view((0, column), (nv, 1)).column(0));
            for (s, &by) in self.state.iter().enumerate() {
                vdot.axpy(self.z[(s, j)], &all.view((0, by), (nv, 1)).column(0), 1.0);
            }
            self.vdot.column_mut(j).copy_from(&vdot);
        }
        Ok(Tick {
            time: report.time,
            square: values.iter().map(|e| e * e).sum(),
            slopes,
        })
    }

    /// A period on, with the accelerations that there are.
    fn advance(&mut self, velocity: &DVector<f64>) {
        let (h, nv) = (self.period, self.vdot.nrows());
        let turning = Vector3::from_fn(|i, _| velocity.get(3 + i).copied().unwrap_or(0.0));
        for (mut z, vdot) in self.z.column_iter_mut().zip(self.vdot.column_iter()) {
            if self.floating {
                let turned = turning.cross(&Vector3::new(z[3], z[4], z[5]));
                for i in 0..3 {
                    z[3 + i] += h * turned[i];
                }
            }
            for i in 0..nv {
                z[i] += h * z[nv + i] + 0.5 * h * h * vdot[i];
                z[nv + i] += h * vdot[i];
            }
        }
    }
}

impl Watcher for ErrorGradient {
    fn begin(&mut self, _: &Controller, _: &mut dyn LogSink) -> Result<(), LogError> {
        self.along = None;
        self.ticks.clear();
        self.skipped = 0;
        Ok(())
    }

    fn after_tick(
        &mut self,
        controller: &mut Controller,
        snapshot: &Snapshot,
        _: &[Option<TrueContact>],
        _: &mut dyn LogSink,
    ) -> Result<(), LogError> {
        let Some(along) = &mut self.along else {
            // From the next tick on.
            self.along = Along::new(controller, &self.task, &self.rows);
            return Ok(());
        };
        match along.tick(controller, &self.rows) {
            Ok(tick) => self.ticks.push(tick),
            Err(_) => self.skipped += 1,
        }
        along.advance(&snapshot.measurement.state.v);
        Ok(())
    }
}
