//! How exact and how fast closed loops are with other steps of the plant's integrator:
//! `cargo run --release --bin plant_stats -- push_with_disturbance with_ft --tolerance 1e-7`.

use std::time::Instant;

use anyhow::Result;
use clap::Parser;
use wbqp_bench::plant::{Differences, Noise, Sample, Steps, run, scenario, trajectory};
use wbqp_sim::{ClosedLoop, Variation};

#[derive(Parser)]
struct CommandLine {
    /// The scenario.
    scenario: String,
    /// Its case.
    case: String,
    /// Tolerances of error-controlled steps.
    #[arg(long, value_delimiter = ',', default_value = "1e-7")]
    tolerance: Vec<f64>,
    /// Steps, s.
    #[arg(long, value_delimiter = ',', default_value = "2.5e-4")]
    step: Vec<f64>,
    /// Of the reference, s; 0 for none.
    #[arg(long, default_value_t = 1e-5)]
    reference: f64,
    /// Runs with noise that are timed, each.
    #[arg(long, default_value_t = 5)]
    runs: u64,
    /// Compares runs with the sensors' noise.
    #[arg(long)]
    noisy: bool,
    /// A line for every period that differs by more, in m, of the base.
    #[arg(long)]
    above: Option<f64>,
}

/// How long it takes to get a case started, ms.
fn set_up(name: &str, case: &str) -> Result<()> {
    let scenario = scenario(name, Steps::Controlled(1e-6), Noise::With)?;
    let variation =
        |i: u32| Variation::new().change("plant.mismatch.mass_scale", 1.0 + 1e-4 * f64::from(i));
    let time = |what: &str, step: &mut dyn FnMut(u32) -> Result<()>| -> Result<()> {
        let mut best = f64::INFINITY;
        for i in 0..20 {
            let begin = Instant::now();
            step(i)?;
            best = best.min(begin.elapsed().as_secs_f64());
        }
        println!("{what}: {:.3} ms", best * 1e3);
        Ok(())
    };
    time("varied", &mut |i| {
        scenario.varied(&variation(i))?;
        Ok(())
    })?;
    time("varied_case", &mut |i| {
        scenario.varied_case(case, &variation(i))?;
        Ok(())
    })?;
    let whole = scenario.case(case)?;
    let varied = scenario.varied_case(case, &variation(1))?;
    time("controller_config", &mut |_| {
        whole.controller_config()?;
        Ok(())
    })?;
    for (what, case) in [("as loaded", whole), ("varied", &varied)] {
        time(&format!("make_controller, {what}"), &mut |_| {
            case.make_controller(case.controller_config()?)?;
            Ok(())
        })?;
    }
    let controller = varied.make_controller(varied.controller_config()?)?;
    time("closed loop", &mut |_| {
        ClosedLoop::new(&varied, &controller, 1)?;
        Ok(())
    })
}

fn main() -> Result<()> {
    let args = CommandLine::parse();
    set_up(&args.scenario, &args.case)?;
    let (name, case) = (args.scenario.as_str(), args.case.as_str());
    let noise = if args.noisy {
        Noise::With
    } else {
        Noise::Without
    };
    let path =
        |steps| -> Result<Vec<Sample>> { trajectory(scenario(name, steps, noise)?.case(case)?) };
    let reference = match args.reference {
        step if step > 0.0 => Some(path(Steps::Equal(step))?),
        _ => None,
    };
    let steps = args.step.iter().map(|step| Steps::Equal(*step));
    let tolerances = args.tolerance.iter().map(|t| Steps::Controlled(*t));
    for steps in steps.chain(tolerances) {
        let noisy = scenario(name, steps, Noise::With)?;
        let mut best = f64::INFINITY;
        for seed in 1..=args.runs {
            best = best.min(run(noisy.case(case)?, seed, |_| ())?);
        }
        print!("{steps:?}: {best:.4} s");
        if let Some(reference) = &reference {
            let own = path(steps)?;
            let Differences {
                position,
                force,
                measured,
                thrust,
            } = Differences::of(reference, &own);
            print!(
                "  position {position:.2e} m, force {force:.2e} N, measured {measured:.2e} N, thrust {thrust:.2e} N"
            );
            for (i, (a, b)) in reference.iter().zip(&own).enumerate() {
                let away = (a.position - b.position).norm();
                if args.above.is_some_and(|above| away > above) {
                    print!("\n{i} {away:e} {} {}", a.force, b.force);
                }
            }
        }
        println!();
    }
    Ok(())
}
