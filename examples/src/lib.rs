//! What the examples have in common: `--live [PORT]`.

use std::{
    env,
    error::Error,
    thread,
    time::{Duration, Instant},
};

use wbqp::{Controller, Measurement};
use wbqp_foxglove::LiveView;

/// The port of `--live [PORT]`, if that is among the program's arguments.
///
/// # Errors
/// A port that is none.
pub fn live_port() -> Result<Option<u16>, Box<dyn Error>> {
    let mut arguments = env::args().skip_while(|argument| argument != "--live");
    if arguments.next().is_none() {
        return Ok(None);
    }
    match arguments.next() {
        Some(port) => Ok(Some(
            port.parse()
                .map_err(|_| format!("`--live {port}`: no port"))?,
        )),
        None => Ok(Some(LiveView::PORT)),
    }
}

/// A live view of a program's loop, if `--live` is among its arguments: the loop then goes at the speed of real time.
#[derive(Debug)]
pub struct Live {
    view: Option<LiveView>,
    start: Instant,
}

impl Live {
    /// Starts it, and says where.
    ///
    /// # Errors
    /// A port that is none, or taken.
    pub fn from_args(controller: &Controller) -> Result<Self, Box<dyn Error>> {
        let view = live_port()?.map(|port| LiveView::on_port(controller, port));
        let view = view.transpose()?;
        if let Some(view) = &view {
            println!("live on ws://127.0.0.1:{}", view.port());
        }
        Ok(Self {
            view,
            start: Instant::now(),
        })
    }

    /// Whether there is one.
    pub fn is_on(&self) -> bool {
        self.view.is_some()
    }

    /// After a tick: shows it, applies what was asked for, and waits for real time.
    pub fn update(&mut self, controller: &mut Controller, measurement: &Measurement) {
        if let Some(view) = &mut self.view {
            view.update(controller, measurement);
            let time = Duration::try_from_secs_f64(measurement.time).unwrap_or_default();
            thread::sleep(time.saturating_sub(self.start.elapsed()));
        }
    }
}

/// The code of the book's page on live views is compiled with the tests.
#[cfg(doctest)]
#[doc = include_str!("../../docs/foxglove.md")]
struct Foxglove;
