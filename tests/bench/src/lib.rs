//! How long a tick takes, in a closed loop.
//!
//! # Method
//! A controller runs a scenario in the closed loop, with its plant, its noise and its events. What it measures goes to
//! two twins, a thousand ticks at a time: a tick depends on nothing but the controller and the measurements, so they
//! compute the same commands, bit by bit, which is checked. The first twin's ticks are timed from outside, one after
//! another. The second one has a stopwatch, and its stages are timed: the readings of the clock would be in the whole
//! tick otherwise. The tick in the loop is timed too, with whatever of it the plant has pushed out of the caches.
//!
//! Only ticks with the contacts that the workload is about count; the approach to a wall does not. When the scenario is
//! over it begins anew with other noise.

pub mod command;
pub mod plant;
pub mod problems;
mod quantiles;
pub mod workload;

use std::{hint::black_box, time::Instant};

use anyhow::{Result, ensure};
use serde::Serialize;
use wbqp::{
    Controller, Measurement,
    controller::{Command, FallbackLevel},
    dynamics::{Data, FrameKinematics},
    stopwatch::Stopwatch,
};

pub use quantiles::Quantiles;
use workload::{Player, Workload};
// Plug-ins are registered by linking.
use wbqp_robots as _;
use wbqp_tasks as _;

/// Ticks that the twins are behind the loop.
const CHUNK: usize = 1000;
/// In so many parts is the run divided; of each p99 is taken apart.
pub const BATCHES: usize = 5;

/// What a run showed. Times in µs.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Statistics {
    /// Ticks that count.
    pub ticks: usize,
    /// How often the scenario was begun.
    pub runs: u64,
    /// The whole tick, timed from outside.
    pub tick: Quantiles,
    /// The same of each of five parts of the run.
    pub batches: Vec<Quantiles>,
    /// The whole tick in the loop, the plant's simulation between two ticks.
    pub in_loop: Quantiles,
    /// Kinematics, mass matrix, bias, and one frame's Jacobian and J̇v at the states of the run: quantiles of the means
    /// of twenty.
    pub dynamics_set: Quantiles,
    /// Kinematics, mass matrix, bias, frames and contacts.
    pub dynamics: Quantiles,
    /// The plug-ins' rows.
    pub rows: Quantiles,
    /// From rows to the quadratic program.
    pub assembly: Quantiles,
    /// The solver.
    pub solve: Quantiles,
    /// Command and report.
    pub output: Quantiles,
    /// Between two readings of the clock: the least that a stage shows.
    pub clock: f64,
    /// Allocations in all ticks that count, if anybody counts them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub allocations: Option<usize>,
    /// Ticks whose command was not that tick's optimum.
    pub not_optimal: usize,
    /// The solver's iterations.
    pub iterations: Iterations,
    /// The largest problem.
    pub problem: Size,
    /// FNV-1a over the bits of all commands.
    pub hash: String,
}

/// The solver's iterations per tick.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Iterations {
    /// Median.
    pub p50: u32,
    /// 99 %.
    pub p99: u32,
    /// The most.
    pub max: u32,
}

/// Size of a quadratic program.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Size {
    /// Variables.
    pub variables: usize,
    /// Rows with one limit or two different ones.
    pub inequalities: usize,
    /// Rows with equal limits.
    pub equalities: usize,
    /// Variables with a bound.
    pub bounded: usize,
}

impl Statistics {
    /// The stages in their order.
    pub fn stages(&self) -> [(&'static str, Quantiles); 5] {
        [
            ("dynamics", self.dynamics),
            ("rows", self.rows),
            ("assembly", self.assembly),
            ("solve", self.solve),
            ("output", self.output),
        ]
    }

    /// The least p99 of the batches, µs: what is left of it when nothing else disturbs the machine.
    pub fn best_p99(&self) -> f64 {
        let batches = self.batches.iter().map(|batch| batch.p99);
        batches.fold(f64::INFINITY, f64::min)
    }
}

/// FNV-1a over 64-bit words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Hash(u64);

impl Default for Hash {
    fn default() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }
}

impl Hash {
    fn add(&mut self, values: &[f64]) {
        for value in values {
            for byte in value.to_bits().to_le_bytes() {
                self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
            }
        }
    }

    /// Takes every number of a command.
    pub fn add_command(&mut self, command: &Command) {
        self.add(&command.effort);
        self.add(&command.rotor_speed);
        self.add(&command.joint_acceleration);
        self.add(&command.joint_velocity);
    }
}

impl std::fmt::Display for Hash {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{:016x}", self.0)
    }
}

/// The clock of the stages.
#[derive(Debug)]
struct Clock(Instant);

impl Stopwatch for Clock {
    fn now(&mut self) -> f64 {
        self.0.elapsed().as_secs_f64()
    }
}

/// Hash of all commands of so many ticks of the closed loop, from the scenario's beginning.
///
/// # Errors
/// A plant that diverges.
pub fn hash(workload: &Workload, ticks: usize) -> Result<Hash> {
    let (mut hash, mut seed) = (Hash::default(), 1);
    let mut run = workload.start(seed)?;
    for _ in 0..ticks {
        if run.left() == 0 {
            seed += 1;
            run = workload.start(seed)?;
        }
        run.step(|controller, measurement| hash.add_command(controller.tick(measurement).0))?;
    }
    Ok(hash)
}

/// Durations of the ticks that count, ns.
#[derive(Debug, Default)]
struct Samples {
    tick: Vec<u32>,
    in_loop: Vec<u32>,
    stages: [Vec<u32>; 5],
    dynamics_set: Vec<u32>,
    iterations: Vec<u32>,
}

impl Samples {
    fn with_capacity(ticks: usize) -> Self {
        let new = || Vec::with_capacity(ticks);
        Self {
            tick: new(),
            in_loop: new(),
            stages: std::array::from_fn(|_| new()),
            dynamics_set: Vec::new(),
            iterations: new(),
        }
    }
}

/// What the loop leaves for the twins.
#[derive(Debug)]
struct Chunk {
    measurements: Vec<Measurement>,
    /// Whether the tick counts, and how long it took in the loop, ns.
    ticks: Vec<(bool, u32)>,
}

/// Times so many ticks. `allocations` says how many there have been in this process, if that is known.
///
/// # Errors
/// A plant that diverges, a scenario in which no tick counts, or a twin that computes other commands than the loop.
pub fn measure(
    workload: &Workload,
    ticks: usize,
    allocations: Option<fn() -> usize>,
    mut progress: impl FnMut(f64),
) -> Result<Statistics> {
    let mut statistics = Statistics {
        clock: clock_resolution(),
        allocations: allocations.map(|_| 0),
        ..Statistics::default()
    };
    let mut samples = Samples::with_capacity(ticks);
    let mut hash = Hash::default();
    let home = workload.start(0)?.measurement().clone();
    let mut chunk = Chunk {
        measurements: vec![home; CHUNK],
        ticks: Vec::with_capacity(CHUNK),
    };
    while samples.tick.len() < ticks {
        statistics.runs += 1;
        let mut run = workload.start(statistics.runs)?;
        let mut timed = workload.player()?;
        let clock = Clock(Instant::now());
        let mut staged = workload.player()?.with_stopwatch(Box::new(clock));
        let before = samples.tick.len();
        while run.left() > 0 && samples.tick.len() < ticks {
            chunk.ticks.clear();
            let mut in_loop = Hash::default();
            for slot in chunk.measurements.iter_mut().take(run.left().min(CHUNK)) {
                let mut spent = 0;
                run.step(|controller, measurement| spent = timed_tick(controller, measurement))?;
                copy(run.measurement(), slot);
                in_loop.add_command(run.player.controller.command());
                hash.add_command(run.player.controller.command());
                chunk.ticks.push((run.is_under_way(), spent));
            }
            let twin = replay(&mut timed, &chunk, |controller, measurement, counts| {
                let counted = allocations.map(|count| count());
                let spent = timed_tick(controller, measurement);
                let now = allocations.map(|count| count());
                if counts && samples.tick.len() < ticks {
                    samples.tick.push(spent);
                    if let (Some(all), Some(counted), Some(now)) =
                        (&mut statistics.allocations, counted, now)
                    {
                        *all += now - counted;
                    }
                    note(controller, &mut statistics, &mut samples);
                }
            })?;
            let other = replay(&mut staged, &chunk, |controller, measurement, counts| {
                let times = controller.tick(measurement).1.times;
                let stages = [
                    times.dynamics,
                    times.rows,
                    times.assembly,
                    times.solve,
                    times.output,
                ];
                if counts {
                    for (samples, time) in samples.stages.iter_mut().zip(stages) {
                        samples.push((time * 1e9).round() as u32);
                    }
                }
            })?;
            ensure!(
                twin == in_loop && other == in_loop,
                "the same measurements led to other commands: a tick depends on something else"
            );
            dynamics_set(&timed, &chunk, &mut samples.dynamics_set);
            let counted = chunk.ticks.iter().filter(|(counts, _)| *counts);
            samples.in_loop.extend(counted.map(|(_, spent)| *spent));
            progress(samples.tick.len() as f64 / ticks as f64);
        }
        ensure!(
            samples.tick.len() > before,
            "in the whole scenario the contacts were never on as they should be"
        );
    }
    statistics.summarise(samples);
    statistics.hash = hash.to_string();
    Ok(statistics)
}

impl Statistics {
    fn summarise(&mut self, samples: Samples) {
        let Samples {
            tick,
            in_loop,
            stages,
            dynamics_set,
            mut iterations,
        } = samples;
        self.dynamics_set = Quantiles::of(&dynamics_set);
        self.ticks = tick.len();
        self.tick = Quantiles::of(&tick);
        let batch = tick.len().div_ceil(BATCHES).max(1);
        self.batches = tick.chunks(batch).map(Quantiles::of).collect();
        self.in_loop = Quantiles::of(&in_loop);
        let of = |stage: &Vec<u32>| Quantiles::of(stage);
        [
            self.dynamics,
            self.rows,
            self.assembly,
            self.solve,
            self.output,
        ] = std::array::from_fn(|stage| of(&stages[stage]));
        iterations.sort_unstable();
        let at = |share: f64| {
            let rank = (share * iterations.len() as f64).ceil() as usize;
            let rank = rank.clamp(1, iterations.len().max(1));
            iterations.get(rank - 1).copied().unwrap_or(0)
        };
        self.iterations = Iterations {
            p50: at(0.5),
            p99: at(0.99),
            max: at(1.0),
        };
    }
}

/// Mean times of the dynamics at every twenty states of a chunk, ns, with the frame of the controller's first contact.
fn dynamics_set(player: &Player, chunk: &Chunk, out: &mut Vec<u32>) {
    const BLOCK: usize = 20;
    let controller = &player.controller;
    let model = &controller.robot().model;
    let first = controller.contact_names().next();
    let contact = first.and_then(|name| controller.contact(name).ok());
    let frame = contact.and_then(|id| model.frame(&controller.contact_spec(id).frame));
    let mut data = Data::new(model);
    let mut kinematics = FrameKinematics::new(model);
    let measurements = chunk.measurements.get(..chunk.ticks.len());
    for block in measurements.unwrap_or_default().chunks_exact(BLOCK) {
        let start = Instant::now();
        for measurement in block {
            data.update(model, &measurement.state);
            if let Some(frame) = frame {
                kinematics.update(model, &data, frame);
            }
            black_box((&data, &kinematics));
        }
        let spent = start.elapsed().as_nanos() / BLOCK as u128;
        out.push(u32::try_from(spent).unwrap_or(u32::MAX));
    }
}

fn note(controller: &Controller, statistics: &mut Statistics, samples: &mut Samples) {
    let report = controller.report();
    statistics.not_optimal += usize::from(report.level != FallbackLevel::Optimal);
    samples.iterations.push(report.iterations);
    let qp = controller.problem();
    if qp.n() + qp.m() > statistics.problem.rows() {
        let equal = qp.row_lower().iter().zip(qp.row_upper());
        let equalities = equal.filter(|(lower, upper)| lower == upper).count();
        let bounds = qp.lower().iter().zip(qp.upper());
        statistics.problem = Size {
            variables: qp.n(),
            inequalities: qp.m() - equalities,
            equalities,
            bounded: bounds
                .filter(|(lower, upper)| lower.is_finite() || upper.is_finite())
                .count(),
        };
    }
}

impl Size {
    fn rows(&self) -> usize {
        self.variables + self.inequalities + self.equalities
    }
}

fn timed_tick(controller: &mut Controller, measurement: &Measurement) -> u32 {
    let start = Instant::now();
    controller.tick(measurement);
    let spent = start.elapsed();
    u32::try_from(spent.as_nanos()).unwrap_or(u32::MAX)
}

/// Lets a twin tick through a chunk; gives the hash of its commands.
fn replay(
    player: &mut Player,
    chunk: &Chunk,
    mut tick: impl FnMut(&mut Controller, &Measurement, bool),
) -> Result<Hash> {
    let mut hash = Hash::default();
    for (measurement, (counts, _)) in chunk.measurements.iter().zip(&chunk.ticks) {
        player.before(measurement)?;
        tick(&mut player.controller, measurement, *counts);
        player.after(measurement);
        hash.add_command(player.controller.command());
    }
    Ok(hash)
}

fn copy(from: &Measurement, to: &mut Measurement) {
    to.time = from.time;
    to.state.copy_from(&from.state);
    to.wrenches.copy_from_slice(&from.wrenches);
}

/// Median time between two readings of the clock, µs.
fn clock_resolution() -> f64 {
    let readings: Vec<u32> = (0..10_000)
        .map(|_| Instant::now().elapsed().subsec_nanos())
        .collect();
    Quantiles::of(&readings).p50
}
