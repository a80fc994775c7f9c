//! wbqp's side of the comparison with other libraries on the same robots (`robots.py`).
//!
//! ```text
//! wbqp_peer record SCENARIO STATES   lets the scenario run in its closed loop and writes what every tick was given
//! wbqp_peer serve SCENARIO STATES    ticks through such a file as standard input asks, and measures
//! ```
//!
//! What is recorded is the state that was measured, the contacts that are on and the references at that time: all that
//! a tick depends on. One line per tick, numbers separated by blanks, in SI units: time; base position, quaternion
//! x y z w, joints; velocities, world-aligned; of the centre of mass the reference, its rate and its acceleration; of
//! the base's orientation the same, as a quaternion and two vectors in world axes; and for each contact whether it is
//! on and where the foot is asked to be while it is not, with rate and acceleration.
//!
//! `serve` reads lines: `start` begins anew, `run A B` ticks from A to B and answers `done` with the sizes of the
//! largest problem (variables, equalities, rows), `write FILE` writes of every tick whether it was optimal, the
//! accelerations (world-aligned) and the torques, the times in ns, and how many limits of torques and of contacts are
//! active. Ticks are timed as they are everywhere else here: from outside, with nothing else between the two readings
//! of the clock but what the scenario switches.

use std::{
    error::Error,
    fs::File,
    io::{BufRead, BufWriter, Write, stdin, stdout},
    path::Path,
    time::Instant,
};

use wbqp::{
    Controller, Measurement,
    controller::FallbackLevel,
    input,
    nalgebra::{Quaternion, UnitQuaternion, Vector3},
    plugin::{Sample, VectorSample},
};
use wbqp_bench::workload::{Player, Workload};

type Result<T> = std::result::Result<T, Box<dyn Error>>;

/// The case of the scenario that is compared.
const CASE: &str = "peers";

fn main() -> Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [command, scenario, states] = arguments.as_slice() else {
        return Err("usage: wbqp_peer record|serve SCENARIO STATES".into());
    };
    // The number of contacts counts for other measurements alone.
    let workload = Workload::of_scenario(Path::new(scenario), CASE, 0, None, None)?;
    match command.as_str() {
        "record" => record(&workload, Path::new(states)),
        "serve" => serve(&workload, Path::new(states)),
        other => Err(format!("`{other}` is neither `record` nor `serve`").into()),
    }
}

/// The closed loop from beginning to end.
fn record(workload: &Workload, file: &Path) -> Result<()> {
    let mut run = workload.start(1)?;
    let mut out = BufWriter::new(File::create(file)?);
    let (mut lines, mut ticks, mut not_optimal) = (Vec::new(), 0_usize, 0_usize);
    let mut limited = [0_usize; 2];
    while run.left() > 0 {
        let mut line = Ok(Vec::new());
        run.step(|controller, measurement| {
            let report = controller.tick(measurement).1;
            not_optimal += usize::from(report.level != FallbackLevel::Optimal);
            let active = active(controller);
            limited = [0, 1].map(|i| limited[i] + usize::from(active[i] > 0));
            line = describe(controller, measurement);
        })?;
        lines.push(line?);
        ticks += 1;
    }
    header(&mut out, &mut run.player.controller)?;
    for line in lines {
        writeln!(out, "{}", words(&line))?;
    }
    out.flush()?;
    eprintln!(
        "{}: {ticks} ticks, {not_optimal} not optimal; with a torque at its limit {}, with a contact at one of its {}",
        file.display(),
        limited[0],
        limited[1],
    );
    Ok(())
}

/// What the lines are about: names, and the posture, which does not change.
fn header(out: &mut impl Write, controller: &mut Controller) -> Result<()> {
    let joints = controller.robot().model.joints();
    let names: Vec<&str> = joints.iter().map(|joint| joint.name.as_str()).collect();
    writeln!(out, "joints {}", names.join(" "))?;
    let contacts: Vec<String> = controller.contact_names().map(str::to_owned).collect();
    writeln!(out, "contacts {}", contacts.join(" "))?;
    let posture = vector(controller.followed("posture")?)?;
    writeln!(out, "posture {}", words(&posture.value))?;
    Ok(())
}

/// What the tick that has just been was given.
fn describe(controller: &mut Controller, measurement: &Measurement) -> Result<Vec<f64>> {
    let state = &measurement.state;
    let mut line = vec![measurement.time];
    line.extend(state.p_WR.iter());
    line.extend(state.R_WR.coords.iter());
    line.extend(state.q.iter());
    line.extend(state.v.iter());
    let com = vector(controller.followed("com")?)?;
    line.extend(com.value.iter().chain(&com.rate).chain(&com.acceleration));
    let Sample::Rotation(base) = controller.followed("base")? else {
        return Err("`base` follows no orientation".into());
    };
    line.extend(base.rotation.coords.iter());
    line.extend(base.rate.iter().chain(&base.acceleration));
    let contacts: Vec<String> = controller.contact_names().map(str::to_owned).collect();
    for (name, report) in contacts.iter().zip(controller.report().contacts.clone()) {
        line.push(f64::from(u8::from(report.on)));
        let sample = match controller.followed(&format!("swing_{name}")) {
            Ok(swing) => vector(swing)?.clone(),
            // A foot that never leaves the ground.
            Err(_) => VectorSample::at_rest([0.0; 3]),
        };
        let numbers = sample.value.iter().chain(&sample.rate);
        line.extend(numbers.chain(&sample.acceleration));
    }
    Ok(line)
}

/// How many torques are at their limit, and how many other limits are active.
fn active(controller: &Controller) -> [usize; 2] {
    let rows = controller.report().active.iter();
    let torques = rows.clone().filter(|a| {
        let row = controller.row(a.row);
        row.is_some_and(|row| row.owner == "torques")
    });
    let torques = torques.count();
    [torques, rows.count() - torques]
}

fn vector(sample: &Sample) -> Result<&VectorSample> {
    match sample {
        Sample::Vector(sample) => Ok(sample),
        Sample::Rotation(_) => Err("an orientation".into()),
    }
}

fn words(numbers: &[f64]) -> String {
    let words: Vec<String> = numbers.iter().map(|x| format!("{x:e}")).collect();
    words.join(" ")
}

/// What a tick has answered.
#[derive(Clone, Debug, Default)]
struct Answer {
    optimal: bool,
    active: [usize; 2],
    vdot: Vec<f64>,
    effort: Vec<f64>,
}

/// Ticks through a file.
struct Peer {
    player: Player,
    measurements: Vec<Measurement>,
    answers: Vec<Answer>,
    /// Of every tick, all times, ns.
    times: Vec<Vec<u128>>,
    /// Changes of the active set, by tick.
    iterations: Vec<u32>,
}

impl Peer {
    fn new(workload: &Workload, file: &Path) -> Result<Self> {
        let player = workload.player()?;
        let measurements = read(&player.controller, file)?;
        let model = &player.controller.robot().model;
        let answer = Answer {
            optimal: false,
            active: [0; 2],
            vdot: vec![0.0; model.nv()],
            effort: vec![0.0; player.controller.robot().nu()],
        };
        Ok(Self {
            answers: vec![answer; measurements.len()],
            times: vec![Vec::new(); measurements.len()],
            iterations: vec![0; measurements.len()],
            player,
            measurements,
        })
    }

    fn run(&mut self, from: usize, to: usize) -> Result<()> {
        for i in from..to.min(self.measurements.len()) {
            let measurement = &self.measurements[i];
            // What is switched in this tick is part of it, as for the others.
            let start = Instant::now();
            self.player.before(measurement)?;
            let (command, report) = self.player.controller.tick(measurement);
            let spent = start.elapsed();
            self.times[i].push(spent.as_nanos());
            let answer = &mut self.answers[i];
            answer.optimal = report.level == FallbackLevel::Optimal;
            answer.vdot.copy_from_slice(report.vdot.as_slice());
            answer.effort.copy_from_slice(&command.effort);
            self.iterations[i] = report.iterations;
            answer.active = active(&self.player.controller);
            self.player.after(measurement);
        }
        Ok(())
    }

    fn write(&self, file: &str) -> Result<()> {
        let mut out = BufWriter::new(File::create(file)?);
        for (i, answer) in self.answers.iter().enumerate() {
            let times: Vec<String> = self.times[i].iter().map(u128::to_string).collect();
            writeln!(
                out,
                "{} {} {} | {} | {} {} {}",
                u8::from(answer.optimal),
                words(&answer.vdot),
                words(&answer.effort),
                times.join(" "),
                answer.active[0],
                answer.active[1],
                self.iterations[i]
            )?;
        }
        out.flush()?;
        Ok(())
    }
}

fn serve(workload: &Workload, file: &Path) -> Result<()> {
    let mut peer = Peer::new(workload, file)?;
    let problem_of = |controller: &Controller| {
        let qp = controller.problem();
        let equal = qp.row_lower().iter().zip(qp.row_upper());
        (
            qp.n(),
            equal.filter(|(lower, upper)| lower == upper).count(),
            qp.m(),
        )
    };
    let mut largest = (0, 0, 0);
    for line in stdin().lock().lines() {
        let line = line?;
        let asked: Vec<&str> = line.split_whitespace().collect();
        match asked.as_slice() {
            ["start"] => peer.player = workload.player()?,
            ["run", from, to] => {
                peer.run(from.parse()?, to.parse()?)?;
                largest = largest.max(problem_of(&peer.player.controller));
            }
            ["write", to] => peer.write(to)?,
            _ => return Err(format!("`{line}` is not understood").into()),
        }
        writeln!(stdout(), "done {} {} {}", largest.0, largest.1, largest.2)?;
        stdout().flush()?;
    }
    Ok(())
}

/// The measurements of a file that [`record`] has written.
fn read(controller: &Controller, file: &Path) -> Result<Vec<Measurement>> {
    let robot = controller.robot();
    let contacts = controller.contact_names().count();
    let (joints, nv) = (robot.model.joints().len(), robot.model.nv());
    let mut measurements = Vec::new();
    let text = input::text(input::read(file, input::LARGEST_RECORD)?)?;
    for (index, line) in text.lines().enumerate().skip(3) {
        let numbers: Vec<f64> = line
            .split_whitespace()
            .map(str::parse)
            .collect::<std::result::Result<_, _>>()?;
        let least = 8 + joints + nv;
        if numbers.len() < least {
            let (line, found) = (index + 1, numbers.len());
            let name = file.display();
            return Err(
                format!("{name}:{line}: has {found} numbers, expected {least} or more").into(),
            );
        }
        let mut measurement = Measurement::home(robot, contacts);
        let (state, rest) = (&mut measurement.state, &numbers[1..]);
        measurement.time = numbers[0];
        state.p_WR = Vector3::from_column_slice(&rest[..3]);
        let [x, y, z, w] = [rest[3], rest[4], rest[5], rest[6]];
        state.R_WR = UnitQuaternion::new_unchecked(Quaternion::new(w, x, y, z));
        state.q.copy_from_slice(&rest[7..7 + joints]);
        state.v.copy_from_slice(&rest[7 + joints..7 + joints + nv]);
        measurements.push(measurement);
    }
    Ok(measurements)
}
