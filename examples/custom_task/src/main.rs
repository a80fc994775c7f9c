//! Runs `pointing.toml`: the robot does what the controller predicts, and a line per second says how well it points.
//! With `--live [PORT]`, in real time, watched and tuned in Foxglove.

use std::{
    env,
    error::Error,
    path::Path,
    thread,
    time::{Duration, Instant},
};

use wbqp::{Controller, ControllerConfig, Measurement};
use wbqp_foxglove::LiveView;

// Plug-ins are found once their crate is linked, and a crate that no code names is not.
use pointing as _;
use wbqp_robots as _;
use wbqp_tasks as _;

fn main() -> Result<(), Box<dyn Error>> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("pointing.toml");
    let mut controller = Controller::new(ControllerConfig::from_file(&file)?)?;
    let robot = controller.robot().clone();
    let period = 1.0 / controller.settings().rate;
    let mut measurement = Measurement::home(&robot, 0);
    let mut live = env::args().skip_while(|argument| argument != "--live");
    let mut view = match (live.next(), live.next()) {
        (None, _) => None,
        (_, Some(port)) => Some(LiveView::on_port(&controller, port.parse()?)?),
        (_, None) => Some(LiveView::new(&controller)?),
    };
    let start = Instant::now();
    let mut tilt = 0.0_f64;
    println!("  t [s]   pointing error [deg]   largest tilt [deg]");
    for tick in 0..=4000_u32 {
        measurement.time = f64::from(tick) * period;
        let (_, report) = controller.tick(&measurement);
        if let Some(fault) = &report.fault {
            return Err(format!("at {:.3} s: {fault:?}", report.time).into());
        }
        let up = measurement.state.R_WR * wbqp::nalgebra::Vector3::z();
        tilt = tilt.max(up.z.clamp(-1.0, 1.0).acos().to_degrees());
        if tick % 250 == 0 {
            // The first task of the file; its error is the sine of the angle, in two components.
            let [x, y] = [0, 1].map(|k| report.tasks[0].error[k]);
            let error = x.hypot(y).asin().to_degrees();
            println!("{:7.1} {error:22.3} {tilt:20.2}", report.time);
        }
        if let Some(view) = &mut view {
            view.update(&mut controller, &measurement);
            let time = Duration::from_secs_f64(measurement.time);
            thread::sleep(time.saturating_sub(start.elapsed()));
        }
        // A perfect robot: it accelerates as predicted.
        let vdot = &controller.report().vdot;
        let v = &measurement.state.v + vdot * (0.5 * period);
        measurement.state.advance(&robot.model, &v, period);
        measurement.state.v += vdot * period;
    }
    Ok(())
}
