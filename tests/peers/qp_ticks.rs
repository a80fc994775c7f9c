//! Writes the problems on which `qp.sh` compares solvers: `qp_ticks FOLDER [NAME…]`.
//!
//! Up to `humanoid_60_swelling` they are of the [sequences](wbqp_tests::qp_sequences): with 3 to 8 active limits, or,
//! of those that are called swelling, all of the problems that the benchmarks have. The others are from closed loops,
//! of ticks in which limits are active:
//! * `push_away`: experiment D's contact from the beginning of the move to its release, where the force climbs to its
//!   peak on the friction pyramid; of several runs with different noise,
//! * `quadruped_slip`, `humanoid_slip`: the standing robots' scenarios, pushed sideways until feet slip; of several
//!   forces, the ticks that are optimal and have an active limit.

use std::{
    env,
    error::Error,
    fs::{self, File},
    io::BufWriter,
    ops::RangeInclusive,
    path::{Path, PathBuf},
};

use wbqp::{
    controller::FallbackLevel,
    qp::{ActiveSet, Budget, Capacity, Qp, QpSolver, Solution},
};
use wbqp_sim::{ClosedLoop, Requests, Scenario, Variation};
use wbqp_tests::{
    qp_sequences::{Demand, aerial, drifting, humanoid, quadruped},
    qp_ticks::{Tick, write},
};

type Result<T> = std::result::Result<T, Box<dyn Error>>;

type Maker<'a> = &'a dyn Fn() -> Result<Vec<Tick>>;

/// Problems per file.
const TICKS: usize = 1000;
/// Active limits, equalities not counted.
const SOME: RangeInclusive<usize> = 3..=8;
const ANY: RangeInclusive<usize> = 0..=usize::MAX;

fn main() -> Result<()> {
    let mut arguments = env::args().skip(1);
    let folder = arguments.next().ok_or("qp_ticks FOLDER [NAME…]")?;
    let chosen: Vec<String> = arguments.collect();
    let steady = Demand::Steady;
    let makers: [(&str, Maker<'_>); 10] = [
        ("drifting_12", &|| {
            sequence(drifting(2 * TICKS, 12, 0, 10, steady(0.3)), SOME)
        }),
        ("drifting_30", &|| {
            sequence(drifting(2 * TICKS, 30, 18, 32, steady(0.25)), SOME)
        }),
        ("drifting_60", &|| {
            sequence(drifting(2 * TICKS, 60, 18, 70, steady(0.07)), SOME)
        }),
        ("aerial_12", &|| sequence(aerial(TICKS, steady(1.6)), SOME)),
        ("quadruped_30", &|| {
            sequence(quadruped(5 * TICKS, steady(1.0)), SOME)
        }),
        ("aerial_12_swelling", &|| {
            sequence(aerial(TICKS, Demand::Swelling), ANY)
        }),
        ("humanoid_60_swelling", &|| {
            sequence(humanoid(TICKS, Demand::Swelling), ANY)
        }),
        ("push_away", &push_away),
        ("quadruped_slip", &|| {
            slip("quadruped_stand", &[14.0, 18.0, 22.0])
        }),
        ("humanoid_slip", &|| {
            slip("humanoid_stand", &[140.0, 180.0, 220.0])
        }),
    ];
    fs::create_dir_all(&folder)?;
    for (name, make) in makers {
        if chosen.is_empty() || chosen.iter().any(|c| c == name) {
            let ticks = make()?;
            let path = PathBuf::from(&folder).join(format!("{name}.ticks"));
            write(&mut BufWriter::new(File::create(&path)?), &ticks)?;
            let sequences = ticks.iter().filter(|tick| tick.is_first).count();
            println!(
                "{}: {} problems in {sequences} sequences",
                path.display(),
                ticks.len()
            );
        }
    }
    Ok(())
}

/// The first problems of a sequence that have so many active limits.
fn sequence(problems: Vec<Qp>, wanted: RangeInclusive<usize>) -> Result<Vec<Tick>> {
    let capacity = problems[0].capacity();
    let (mut solver, mut solution) = (ActiveSet::default(), Solution::new(capacity));
    solver.bind(capacity)?;
    let (mut ticks, mut follows) = (Vec::new(), false);
    for qp in problems {
        solver.solve(&qp, Budget::Configured, &mut solution)?;
        let keeps = wanted.contains(&active(&qp, &solution.y, &solution.z));
        if keeps && ticks.len() < TICKS {
            ticks.push(Tick {
                is_first: !follows,
                qp,
            });
        }
        follows = keeps;
    }
    Ok(ticks)
}

/// What a closed loop keeps of a tick.
struct Seen {
    time: f64,
    contacts: usize,
    is_optimal: bool,
    active: usize,
}

/// Runs a case until some time and keeps the problems of the ticks that are wanted. A sequence ends where ticks are
/// left out or the problem's shape changes.
fn closed_loop(
    scenario: &Scenario,
    case: &str,
    seed: u64,
    until: f64,
    wanted: impl Fn(&Seen) -> bool,
    ticks: &mut Vec<Tick>,
) -> Result<()> {
    let case = scenario.case(case)?;
    let mut controller = case.make_controller(case.controller_config()?)?;
    let rate = controller.settings().rate;
    let mut requests = Requests::new(case, rate);
    let mut closed_loop = ClosedLoop::new(case, &controller, seed)?;
    let mut follows = false;
    for _ in 0..case.ticks(rate) {
        closed_loop.measure();
        let measurement = closed_loop.measurement();
        while let Some(event) = requests.due(measurement.time) {
            event
                .apply(&mut controller)
                .map_err(|what| format!("event: {what}"))?;
        }
        controller.tick(measurement);
        requests.detect(&mut controller, measurement);
        let time = measurement.time;
        closed_loop.advance(controller.command())?;
        if closed_loop.plant().is_diverged() || time > until || ticks.len() >= TICKS {
            break;
        }
        let qp = controller.problem();
        let report = controller.report();
        let seen = Seen {
            time,
            contacts: report
                .contacts
                .iter()
                .filter(|c| c.on && c.alpha >= 1.0)
                .count(),
            is_optimal: report.level == FallbackLevel::Optimal,
            active: active(qp, &controller.solution().y, &controller.solution().z),
        };
        let keeps = wanted(&seen);
        if keeps {
            let fits = |last: &Qp| last.rows() == qp.rows() && last.vars() == qp.vars();
            follows &= ticks.last().is_some_and(|last| fits(&last.qp));
            let mut copy = Qp::new(Capacity {
                vars: qp.n(),
                rows: qp.m(),
            });
            copy.copy_from(qp)?;
            ticks.push(Tick {
                is_first: !follows,
                qp: copy,
            });
        }
        follows = keeps;
    }
    Ok(())
}

/// Limits with a multiplier that are no equalities.
fn active(qp: &Qp, y: &[f64], z: &[f64]) -> usize {
    let limits = qp.row_lower().iter().zip(qp.row_upper());
    let rows = limits
        .zip(y)
        .filter(|((low, high), y)| low != high && **y != 0.0);
    rows.count() + z.iter().take(qp.n()).filter(|z| **z != 0.0).count()
}

fn scenario(name: &str) -> Result<Scenario> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/scenarios");
    Ok(Scenario::from_file(&folder.join(format!("{name}.toml")))?)
}

fn push_away() -> Result<Vec<Tick>> {
    let scenario = scenario("push_away")?;
    let mut ticks = Vec::new();
    let mut seed = 0;
    while ticks.len() < TICKS {
        seed += 1;
        let in_contact = |seen: &Seen| seen.time >= 5.0 && seen.contacts > 0 && seen.is_optimal;
        closed_loop(&scenario, "contact", seed, 5.3, in_contact, &mut ticks)?;
    }
    Ok(ticks)
}

/// The push of the scenario from 8 s on, with other forces (N) and for a second.
fn slip(name: &str, forces: &[f64]) -> Result<Vec<Tick>> {
    let scenario = scenario(name)?;
    let mut ticks = Vec::new();
    let mut seed = 0;
    while ticks.len() < TICKS {
        seed += 1;
        for force in forces {
            let variation = Variation::new()
                .change("plant.disturbance.aside.force", vec![0.0, *force, 0.0])
                .change("plant.disturbance.aside.until", 9.0);
            let pushed = scenario.varied(&variation)?;
            let at_limits = |seen: &Seen| seen.time >= 8.0 && seen.is_optimal && seen.active > 0;
            // As many of each force as of the others.
            let mut own = Vec::new();
            closed_loop(&pushed, "stand", seed, 9.2, at_limits, &mut own)?;
            own.truncate((TICKS / forces.len() + 1).min(TICKS - ticks.len()));
            ticks.append(&mut own);
        }
    }
    Ok(ticks)
}
