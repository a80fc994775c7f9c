//! How exact and how fast closed loops are with other steps of the plant's integrator:
//! `cargo run --release --bin plant_stats -- push_with_disturbance with_ft --tolerance 1e-7`.

use anyhow::Result;
use clap::Parser;
use wbqp_bench::plant::{Differences, Noise, Sample, Steps, run, scenario, trajectory};

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
    /// A line for every period that differs by more, in m, of the base.
    #[arg(long)]
    above: Option<f64>,
}

fn main() -> Result<()> {
    let args = CommandLine::parse();
    let (name, case) = (args.scenario.as_str(), args.case.as_str());
    let path = |steps| -> Result<Vec<Sample>> {
        trajectory(scenario(name, steps, Noise::Without)?.case(case)?)
    };
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
