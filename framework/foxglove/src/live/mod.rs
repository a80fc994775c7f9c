//! A controller that is watched and tuned while it runs.

mod exchange;
mod parameters;
mod topics;

use std::{
    collections::BTreeSet,
    sync::{
        Arc, Mutex, MutexGuard, PoisonError,
        atomic::{AtomicBool, Ordering},
    },
    thread::{self, JoinHandle},
    time::{Duration, Instant},
};

use foxglove::{
    Context, FoxgloveError, WebSocketServer, WebSocketServerHandle,
    websocket::{
        AnyClient, ChannelView, Client, GetParametersResponder, Parameter, ParameterHandler,
        ServerListener, SetParametersResponder, Status,
    },
};
use wbqp::{Controller, Measurement};
use wbqp_log::{ChannelId, ControllerLog, JsonWriter, LogError, LogSink, TrueContact, schema};

use crate::SceneLog;
use exchange::{Exchange, Outcome};
use parameters::Parameters;
use topics::Topics;

/// How long the view's thread sleeps when there is nothing to show.
const REST: Duration = Duration::from_millis(4);
/// How often clients hear of changed parameters, refusals and dropped ticks, at most: a server disconnects whoever has
/// more than some hundreds of such messages to read.
const NEWS: Duration = Duration::from_millis(50);
/// How long the end waits for clients to say good-bye.
const FAREWELL: Duration = Duration::from_millis(300);
/// Characters of a text that a client has sent, where it is repeated to others.
const QUOTED: usize = 80;
/// Messages that the server keeps for a client that is slow; older ones are dropped.
const BACKLOG: usize = 512;

/// Texts for clients that wait to be sent.
const NOTES: usize = 4;

/// Why there is no live view.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LiveError {
    /// The server does not start, because another one has the port for example.
    #[error(
        "live view: no server on port {port}: {source}; give another port, or 0 for any that is free"
    )]
    Server {
        /// Where it was to listen.
        port: u16,
        /// What the server says.
        source: FoxgloveError,
    },
    /// A topic cannot be opened.
    #[error("live view: {0}")]
    Topic(#[from] LogError),
    /// There is no thread for it.
    #[error("live view: no thread: {0}")]
    Thread(#[from] std::io::Error),
}

/// A server that a running controller is watched and tuned with, in [Foxglove](https://foxglove.dev) (*Open
/// connection*, *Foxglove WebSocket*) or any program that speaks its protocol. It listens on the loopback address only;
/// whatever runs on this machine may connect, a page in its browser too: [`watch_only`](Self::watch_only) is for
/// robots whose gains nobody is to change.
///
/// Topics are those of a log: [`ControllerLog`] and [`SceneLog`], and `/view` with the count of ticks that were not
/// shown. Parameters are weights (`<entry>.weight`), keys of tasks and constraints as in their file (`<entry>.kp`),
/// switches (`<entry>.active`, `contact.<name>.active`), and where tasks stay (`<task>.reference`; setting it makes the
/// task `hold` that value). What a client sets holds from the next tick on; what the controller refuses is told to all
/// clients and set back. What the program changes by itself meanwhile, parameters do not show.
///
/// The loop never waits for it: [`update`](Self::update) copies the tick into storage made once and takes changes out
/// of a queue, both without locks. If the view is slow, the oldest ticks are dropped and counted; if a client is, the
/// server drops the oldest of 512 messages for it. Only a change that a client asked for allocates, between two ticks.
///
/// ```no_run
/// # fn run(mut controller: wbqp::Controller) -> Result<(), wbqp_foxglove::LiveError> {
/// use wbqp_foxglove::LiveView;
///
/// let mut view = LiveView::new(&controller)?;
/// let measurement = controller.measurement();
/// loop {
///     controller.tick(&measurement);
///     view.update(&mut controller, &measurement);
/// #   break;
/// }
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct LiveView {
    exchange: Arc<Exchange>,
    thread: Option<JoinHandle<()>>,
    port: u16,
    /// Every so many ticks are shown.
    every: u32,
    /// Ticks until the next one that is shown.
    wait: u32,
}

impl LiveView {
    /// The port that Foxglove proposes.
    pub const PORT: u16 = 8765;
    /// Ticks per second that are shown, at most.
    pub const RATE: f64 = 250.0;

    /// Serves on [`PORT`](Self::PORT).
    ///
    /// # Errors
    /// [`LiveError`].
    pub fn new(controller: &Controller) -> Result<Self, LiveError> {
        Self::on_port(controller, Self::PORT)
    }

    /// Serves on a port; on any that is free for 0.
    ///
    /// # Errors
    /// [`LiveError`].
    pub fn on_port(controller: &Controller, port: u16) -> Result<Self, LiveError> {
        Self::start(controller, port, Access::Tune)
    }

    /// Like [`on_port`](Self::on_port), and takes no changes: clients see no parameters.
    ///
    /// # Errors
    /// [`LiveError`].
    pub fn watch_only(controller: &Controller, port: u16) -> Result<Self, LiveError> {
        Self::start(controller, port, Access::Watch)
    }

    fn start(controller: &Controller, port: u16, access: Access) -> Result<Self, LiveError> {
        let context = Context::new();
        let mut topics = Topics::new(&context);
        let log = ControllerLog::new(controller, &mut topics)?;
        let scene = SceneLog::new(controller, &mut topics)?;
        let count = schema::object(
            "The live view itself",
            [("dropped", schema::integer("Ticks that were not shown"))],
        );
        let view = topics.channel("/view", "wbqp.View", &count)?;
        let exchange = Arc::new(Exchange::new(controller));
        let desk = Arc::new(Desk {
            exchange: Arc::clone(&exchange),
            parameters: Mutex::new(Parameters::of(controller)),
            notes: Mutex::new(Notes::default()),
            newcomer: AtomicBool::new(false),
        });
        let server = context
            .websocket_server()
            .name(format!("wbqp: {}", controller.robot().model.name()))
            .bind("127.0.0.1", port)
            .message_backlog_size(BACKLOG)
            .listener(Arc::clone(&desk) as Arc<dyn ServerListener>);
        let server = match access {
            Access::Watch => server,
            Access::Tune => {
                server.parameter_handler(Arc::clone(&desk) as Arc<dyn ParameterHandler>)
            }
        };
        let server = start(server)?.map_err(|source| LiveError::Server { port, source })?;
        let port = server.port();
        let show = Show {
            topics,
            log,
            scene,
            view,
            desk,
            server,
            time: 0.0,
            changed: BTreeSet::new(),
            told: Instant::now(),
            counted: 0,
            message: Vec::new(),
        };
        let thread = thread::Builder::new().name("wbqp live view".to_owned());
        let rate = controller.settings().rate;
        Ok(Self {
            exchange,
            thread: Some(thread.spawn(move || show.run())?),
            port,
            every: (rate / Self::RATE).ceil().clamp(1.0, 1e6) as u32,
            wait: 0,
        })
    }

    /// Where the server listens.
    pub fn port(&self) -> u16 {
        self.port
    }

    /// Ticks that were not shown because clients, or the server, were slow.
    pub fn dropped(&self) -> u64 {
        self.exchange.dropped()
    }

    /// To be called after every tick: shows it, and applies what clients have asked for. Never waits.
    pub fn update(&mut self, controller: &mut Controller, measurement: &Measurement) {
        self.update_with(controller, measurement, &[]);
    }

    /// Like [`update`](Self::update), with what only a simulator knows of each contact.
    pub fn update_with(
        &mut self,
        controller: &mut Controller,
        measurement: &Measurement,
        truth: &[Option<TrueContact>],
    ) {
        if self.wait == 0 {
            self.exchange.show(controller, measurement, truth);
            self.wait = self.every;
        }
        self.wait -= 1;
        self.exchange.apply(controller);
    }
}

impl Drop for LiveView {
    fn drop(&mut self) {
        self.exchange.stop();
        if let Some(thread) = self.thread.take() {
            // One that has panicked has said so.
            let _ = thread.join();
        }
    }
}

/// What clients may do.
#[derive(Clone, Copy, Debug)]
enum Access {
    Watch,
    Tune,
}

/// Where clients' requests arrive.
struct Desk {
    exchange: Arc<Exchange>,
    parameters: Mutex<Parameters>,
    /// What clients are to be told.
    notes: Mutex<Notes>,
    /// Whether somebody has subscribed to what does not change.
    newcomer: AtomicBool,
}

/// The first few texts, and how many there were besides.
#[derive(Debug, Default)]
struct Notes {
    texts: Vec<String>,
    more: usize,
}

impl Desk {
    fn parameters(&self) -> MutexGuard<'_, Parameters> {
        self.parameters
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }

    fn note(&self, text: String) {
        let mut notes = self.notes();
        if notes.texts.len() < NOTES {
            notes.texts.push(text);
        } else {
            notes.more += 1;
        }
    }

    fn notes(&self) -> MutexGuard<'_, Notes> {
        self.notes.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl ParameterHandler for Desk {
    fn get(
        &self,
        _: AnyClient,
        names: Vec<String>,
        _: Option<String>,
        responder: GetParametersResponder,
    ) {
        responder.respond(self.parameters().get(&names));
    }

    fn set(
        &self,
        _: AnyClient,
        wanted: Vec<Parameter>,
        _: Option<String>,
        responder: SetParametersResponder,
    ) {
        let mut parameters = self.parameters();
        for wanted in &wanted {
            match parameters.request(wanted) {
                Ok(request) => {
                    if let Err(request) = self.exchange.ask(request) {
                        let name = &request.name;
                        self.note(format!("`{name}` is not changed: too many changes wait"));
                        parameters.undo(&request);
                    }
                }
                Err(what) => self.note(what),
            }
        }
        let names: Vec<String> = wanted.into_iter().map(|wanted| wanted.name).collect();
        // Of no name would be of all.
        let now = (!names.is_empty()).then(|| parameters.get(&names));
        responder.respond(now.unwrap_or_default());
    }
}

impl ServerListener for Desk {
    fn on_subscribe(&self, _: Client, channel: ChannelView<'_>) {
        if SceneLog::UNCHANGING.contains(&channel.topic()) {
            self.newcomer.store(true, Ordering::Relaxed);
        }
    }
}

/// The view's thread.
struct Show {
    topics: Topics,
    log: ControllerLog,
    scene: SceneLog,
    view: ChannelId,
    desk: Arc<Desk>,
    server: WebSocketServerHandle,
    /// Of the last tick, s.
    time: f64,
    /// Parameters whose value clients have not heard of.
    changed: BTreeSet<String>,
    /// When they last heard of anything.
    told: Instant,
    /// How many dropped ticks they have heard of.
    counted: u64,
    message: Vec<u8>,
}

impl Show {
    fn run(mut self) {
        let exchange = Arc::clone(&self.desk.exchange);
        while !exchange.is_stopped() {
            let mut idle = true;
            // No more than wait at once: what clients ask for has its turn.
            for _ in 0..exchange::DEPTH {
                let Some(shown) = exchange.next_shown() else {
                    break;
                };
                idle = false;
                let time = shown.snapshot.report.time;
                if time.is_finite() && time >= 0.0 {
                    self.time = time;
                }
                let (snapshot, truth) = (&shown.snapshot, &shown.truth);
                self.desk.parameters().follow(&snapshot.references);
                let logged = self.log.record(snapshot, truth, &mut self.topics);
                let drawn = self.scene.record(snapshot, truth, &mut self.topics);
                exchange.give_back(shown);
                self.report(logged.and(drawn));
            }
            while let Some(outcome) = exchange.next_outcome() {
                self.take(&outcome);
            }
            if self.desk.newcomer.swap(false, Ordering::Relaxed) {
                let described = self.scene.record_description(self.time, &mut self.topics);
                self.report(described);
            }
            if self.told.elapsed() > NEWS {
                self.tell();
            }
            if idle {
                thread::sleep(REST);
            }
        }
        say_goodbye(self.server);
    }

    fn report(&self, result: Result<(), LogError>) {
        if let Err(error) = result {
            self.desk.note(error.to_string());
        }
    }

    /// What became of a request.
    fn take(&mut self, outcome: &Outcome) {
        let Outcome { request, result } = outcome;
        let mut parameters = self.desk.parameters();
        match result {
            Ok(()) => parameters.confirm(request),
            Err(error) => {
                let name = &request.name;
                self.desk.note(format!("`{name}` is not changed: {error}"));
                parameters.undo(request);
            }
        }
        self.changed.insert(request.name.clone());
    }

    /// Lets clients know what has changed, what was refused, and how many ticks were not shown.
    fn tell(&mut self) {
        self.told = Instant::now();
        let Notes { texts, more } = std::mem::take(&mut *self.desk.notes());
        for text in texts {
            self.server.publish_status(Status::warning(text));
        }
        if more > 0 {
            let text = format!("and {more} more");
            self.server.publish_status(Status::warning(text));
        }
        if !self.changed.is_empty() {
            let names: Vec<String> = std::mem::take(&mut self.changed).into_iter().collect();
            let values = self.desk.parameters().get(&names);
            self.server.publish_parameter_values(values);
        }
        let dropped = self.desk.exchange.dropped();
        if dropped != self.counted {
            self.counted = dropped;
            JsonWriter::write(&mut self.message, |o| o.integer("dropped", dropped));
            let written = self.topics.write(self.view, self.time, &self.message);
            self.report(written);
        }
    }
}

/// Starts a server. From a thread of its own, since that of an asynchronous runtime must not block.
fn start(server: WebSocketServer) -> std::io::Result<Result<WebSocketServerHandle, FoxgloveError>> {
    let thread = thread::Builder::new().name("wbqp live view begins".to_owned());
    let started = thread.spawn(move || server.start_blocking())?.join();
    Ok(started.unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
}

/// Stops a server. Who does not read does not keep the program waiting: the connection ends with it, or when they
/// leave.
fn say_goodbye(server: WebSocketServerHandle) {
    let stopping = thread::Builder::new().name("wbqp live view ends".to_owned());
    let Ok(stopping) = stopping.spawn(move || server.stop().wait_blocking()) else {
        return;
    };
    let start = Instant::now();
    while !stopping.is_finished() && start.elapsed() < FAREWELL {
        thread::sleep(REST);
    }
}
