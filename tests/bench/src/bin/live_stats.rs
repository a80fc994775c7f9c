//! Whether a live view with a slow client makes the ticks of a loop late: `cargo run --release --bin live_stats`.
//!
//! A quadruped is controlled at 1 kHz in real time, in turns without a view, with a view that nobody looks at, and with
//! one whose client subscribes to everything and reads one message in 50 ms.

use std::{
    net::TcpStream,
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
    thread,
    time::{Duration, Instant},
};

use anyhow::Result;
use assert_no_alloc::{AllocDisabler, assert_no_alloc, violation_count};
use clap::Parser;
use comfy_table::Table;
use tungstenite::{ClientRequestBuilder, Message, http::Uri, stream::MaybeTlsStream};
use wbqp_bench::{
    Quantiles,
    workload::{Contact, Robot, Run, Workload},
};
use wbqp_foxglove::LiveView;

// Counts the allocations of the loop's thread alone.
#[global_allocator]
static ALLOCATOR: AllocDisabler = AllocDisabler;

const PERIOD: Duration = Duration::from_millis(1);
/// The end of a wait that is spent awake: sleep is not exact.
const AWAKE: Duration = Duration::from_micros(150);

/// Compares the ticks of a loop with and without a live view
#[derive(Parser)]
struct Arguments {
    /// Turns, each of one second without and one second with either view
    #[arg(long, value_name = "N", default_value_t = 30)]
    turns: usize,
}

/// What happened in a period, ns: until the tick and what shows it were done, from the call and from the period's
/// start.
#[derive(Default)]
struct Times {
    tick: Vec<u32>,
    done: Vec<u32>,
}

fn main() -> Result<()> {
    let turns = Arguments::parse().turns;
    let workload = Workload::new(Robot::Quadruped, Contact::None, None, None)?;
    let mut times: [Times; 3] = Default::default();
    let mut dropped = 0;
    let mut run = workload.start(1)?;
    for _ in 0..turns {
        for (kind, times) in times.iter_mut().enumerate() {
            if run.left() < 1000 {
                run = workload.start(1)?;
            }
            let mut view = match kind {
                0 => None,
                _ => Some(LiveView::on_port(&run.player.controller, 0)?),
            };
            let client = view.as_ref().filter(|_| kind == 2);
            let client = client.map(|view| SlowClient::start(view.port()));
            turn(&mut run, view.as_mut(), times)?;
            if let Some(view) = view {
                dropped += view.dropped();
            }
            drop(client);
        }
    }
    let mut table = Table::new();
    table.set_header([
        "1 kHz loop, µs",
        "median",
        "90 %",
        "99 %",
        "99.9 %",
        "longest",
    ]);
    let names = ["no view", "a view, no client", "a view, a slow client"];
    for (name, times) in names.iter().zip(&times) {
        for (what, ns) in [("tick", &times.tick), ("done after", &times.done)] {
            let columns = Quantiles::of(ns).columns().map(|us| format!("{us:.1}"));
            table.add_row([format!("{name}: {what}")].into_iter().chain(columns));
        }
    }
    println!("{table}");
    println!(
        "{} ticks each; {dropped} ticks not shown; {} allocations in ticks and updates",
        times[0].tick.len(),
        violation_count()
    );
    Ok(())
}

/// A second of the loop.
fn turn(run: &mut Run, mut view: Option<&mut LiveView>, times: &mut Times) -> Result<()> {
    let mut due = Instant::now() + PERIOD;
    for tick in 0..1000 {
        let wait = due.saturating_duration_since(Instant::now());
        thread::sleep(wait.saturating_sub(AWAKE));
        while Instant::now() < due {
            std::hint::spin_loop();
        }
        let mut elapsed = [Duration::ZERO; 2];
        run.step(|controller, measurement| {
            let start = Instant::now();
            assert_no_alloc(|| {
                controller.tick(measurement);
                if let Some(view) = &mut view {
                    view.update(controller, measurement);
                }
            });
            elapsed = [start.elapsed(), due.elapsed()];
        })?;
        // The first ticks after a pause find cold caches.
        if tick >= 50 {
            let [took, done] =
                elapsed.map(|time| u32::try_from(time.as_nanos()).unwrap_or(u32::MAX));
            times.tick.push(took);
            times.done.push(done);
        }
        due += PERIOD;
    }
    Ok(())
}

/// Subscribes to everything and reads seldom.
struct SlowClient {
    stop: Arc<AtomicBool>,
    thread: Option<thread::JoinHandle<()>>,
}

impl SlowClient {
    fn start(port: u16) -> Self {
        let stop = Arc::new(AtomicBool::new(false));
        let stopped = Arc::clone(&stop);
        let listen = move || {
            let address: Uri = format!("ws://127.0.0.1:{port}").parse()?;
            let request = ClientRequestBuilder::new(address).with_sub_protocol("foxglove.sdk.v1");
            let (mut client, _) = tungstenite::connect(request)?;
            let all = (1..60).map(|id| format!(r#"{{"id":{id},"channelId":{id}}}"#));
            let all = all.collect::<Vec<_>>().join(",");
            let text = format!(r#"{{"op":"subscribe","subscriptions":[{all}]}}"#);
            client.send(Message::text(text))?;
            if let MaybeTlsStream::Plain(stream) = client.get_ref() {
                let stream: &TcpStream = stream;
                stream.set_read_timeout(Some(Duration::from_millis(50)))?;
            }
            while !stopped.load(Ordering::Relaxed) {
                let _ = client.read();
                thread::sleep(Duration::from_millis(50));
            }
            anyhow::Ok(())
        };
        Self {
            stop,
            thread: Some(thread::spawn(move || {
                if let Err(error) = listen() {
                    eprintln!("the client: {error}");
                }
            })),
        }
    }
}

impl Drop for SlowClient {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}
