//! What JavaScript sees: [`Session`] with numbers as views into the module's memory and words as JSON.
#![allow(
    unsafe_code,
    reason = "plug-ins register by constructors, which nobody else calls in a WebAssembly module"
)]

use std::path::Path;

use wasm_bindgen::prelude::*;
use wbqp::{config::json_schema, input, serde_json::json};

use crate::{Board, Session, change, keep_shipped, shipped};

#[wasm_bindgen]
extern "C" {
    #[wasm_bindgen(js_namespace = performance)]
    fn now() -> f64;
}

unsafe extern "C" {
    /// Runs the constructors that the linker collected.
    fn __wasm_call_ctors();
}

/// Runs once, before anything else: registers the plug-ins, and keeps the files of the shipped scenarios.
#[wasm_bindgen(start)]
fn start() {
    // SAFETY: the linker defines it, it takes nothing and is called once.
    unsafe { __wasm_call_ctors() };
    keep_shipped();
}

/// Keeps a file in memory, where scenarios, controllers and robots are read from.
#[wasm_bindgen]
pub fn keep(path: &str, bytes: Vec<u8>) {
    input::keep(Path::new(path), bytes);
}

/// The scenarios that ship, as JSON.
#[wasm_bindgen]
pub fn scenarios() -> String {
    let all = shipped().iter().map(|shipped| {
        json!({
            "name": shipped.name,
            "title": shipped.title,
            "about": shipped.about,
            "case": shipped.case,
            "path": shipped.path(),
            "text": shipped.text,
            "controller": shipped.controller,
        })
    });
    json!(all.collect::<Vec<_>>()).to_string()
}

/// The JSON Schemas of the two files, as JSON: `controller` and `scenario`.
#[wasm_bindgen]
pub fn schemas() -> String {
    json!({
        "controller": json_schema::controller(),
        "scenario": wbqp_sim::scenario::json_schema(),
    })
    .to_string()
}

/// A [`Session`].
#[wasm_bindgen]
pub struct Run {
    session: Session,
    rows: Vec<f64>,
}

#[wasm_bindgen]
impl Run {
    /// A case of a scenario at time 0; throws what is wrong, a line per mistake.
    #[wasm_bindgen(constructor)]
    pub fn new(path: &str, case: &str, seed: u32, variation: &str) -> Result<Run, JsError> {
        let session = Session::new(path, case, u64::from(seed), variation)?;
        Ok(Self::over(session))
    }

    fn over(session: Session) -> Self {
        Self {
            session,
            rows: Vec::new(),
        }
    }

    /// The same from its beginning.
    pub fn again(&self, seed: u32) -> Result<Run, JsError> {
        Ok(Self::over(self.session.again(u64::from(seed))?))
    }

    /// Everything that does not change, as JSON.
    pub fn about(&self) -> String {
        self.session.about().to_string()
    }

    /// At most so many periods; says how many there were.
    pub fn advance(&mut self, ticks: u32) -> u32 {
        let mut done = 0;
        while done < ticks && self.session.stopped().is_none() {
            self.session.tick(&mut now);
            done += 1;
        }
        done
    }

    /// Periods until the time is up, in ms; at most so many. Says how many there were.
    pub fn advance_within(&mut self, ticks: u32, milliseconds: f64) -> u32 {
        let end = now() + milliseconds;
        let mut done = 0;
        while done < ticks && self.session.stopped().is_none() && now() < end {
            self.session.tick(&mut now);
            done += 1;
        }
        done
    }

    /// Where what is on the boards is, as JSON.
    pub fn fields(&self) -> String {
        let list = |board: &Board| {
            let fields = board.fields().iter();
            let fields = fields.map(|f| json!({ "name": f.name, "at": f.at, "count": f.count }));
            fields.collect::<Vec<_>>()
        };
        let history = list(self.session.columns());
        json!({ "frame": list(self.session.last_frame()), "history": history }).to_string()
    }

    /// Writes the numbers of the present state; where they are in the module's memory, in bytes.
    pub fn frame(&mut self) -> *const f64 {
        self.session.frame().values().as_ptr()
    }

    /// How many numbers a frame has.
    pub fn frame_length(&self) -> usize {
        self.session.last_frame().values().len()
    }

    /// Takes the rows of the history since the last call; where they are in the module's memory, in bytes.
    pub fn rows(&mut self) -> *const f64 {
        self.rows = self.session.take_rows();
        self.rows.as_ptr()
    }

    /// How many numbers these rows have.
    pub fn rows_length(&self) -> usize {
        self.rows.len()
    }

    /// Level, explanation, end, as JSON.
    pub fn words(&self) -> String {
        self.session.words().to_string()
    }

    /// What matters in the last tick, as JSON.
    pub fn matters(&mut self) -> String {
        self.session.matters().to_string()
    }

    /// From now on nobody wants to know it.
    pub fn forget_matters(&mut self) {
        self.session.forget_matters();
    }

    /// A change, as JSON; throws why it is refused.
    pub fn change(&mut self, change: &str) -> Result<(), JsError> {
        let change = change::from_json(change)?;
        Ok(self.session.change(&change)?)
    }

    /// Pulls at a link until the next call.
    #[allow(
        clippy::too_many_arguments,
        reason = "JavaScript has no arrays of three"
    )]
    pub fn pull(&mut self, frame: &str, x: f64, y: f64, z: f64, fx: f64, fy: f64, fz: f64) -> bool {
        self.session.pull(frame, [x, y, z], [fx, fy, fz])
    }

    /// Moves a wall.
    pub fn move_wall(&mut self, wall: &str, x: f64, y: f64, z: f64) -> bool {
        self.session.move_wall(wall, [x, y, z])
    }

    /// A tick on a measurement of another run, see `Session::replay`.
    pub fn replay(&mut self, measured: &[f64]) -> Result<Vec<f64>, JsError> {
        self.session
            .replay(measured)
            .map_err(|what| JsError::new(&what))
    }

    /// Simulated time, s.
    pub fn time(&self) -> f64 {
        self.session.time()
    }

    /// The controller's period, s.
    pub fn period(&self) -> f64 {
        self.session.period()
    }

    /// Whether the scenario's duration is over.
    pub fn is_over(&self) -> bool {
        self.session.is_over()
    }

    /// Whether it cannot go on.
    pub fn is_stopped(&self) -> bool {
        self.session.stopped().is_some()
    }
}

/// The rows of the paper's experiment that these runs are the cases of, as JSON; throws what is missing. The runs are
/// used up.
#[wasm_bindgen]
pub fn measured(runs: Vec<Run>) -> Result<String, JsError> {
    let sessions: Vec<&Session> = runs.iter().map(|run| &run.session).collect();
    let rows = Session::rows(&sessions).map_err(|what| JsError::new(&what))?;
    Ok(rows.to_string())
}
