//! What the rows of the paper's experiments need of a run, kept in memory as it goes.

use wbqp::{
    controller::Controller,
    serde_json::{Value, json},
};
use wbqp_measures::{
    Cases, Recording, RotorLimits, Series, Signals, escaped, experiments, promises,
};
use wbqp_sim::{Plant, Scenario, World as _, scenario::Case};

/// A series that is being recorded.
#[derive(Clone, Debug)]
struct Column {
    topic: String,
    field: String,
    values: Vec<f64>,
}

/// The series of a run.
#[derive(Clone, Debug)]
pub(crate) struct Track {
    time: Vec<f64>,
    columns: Vec<Column>,
    /// Everything that is known before the first tick.
    base: Signals,
    /// So many ticks are kept: the scenario's.
    most: usize,
    numbers: Vec<f64>,
}

impl Track {
    pub(crate) fn new(scenario: &Scenario, case: &Case, controller: &Controller) -> Self {
        let mut base = Signals::new();
        for event in case.events() {
            if let Some(mark) = &event.mark {
                base = base.with_mark(mark, event.at);
            }
        }
        for disturbance in case.plant().disturbances.iter().rev() {
            base = base
                .with_mark(&format!("{}_start", disturbance.name), disturbance.from)
                .with_mark(&format!("{}_end", disturbance.name), disturbance.until);
        }
        for (_, actuator, rotor) in controller.robot().rotors() {
            let thrust = [actuator.lower, actuator.upper];
            base = base.with_rotor(RotorLimits {
                name: actuator.name.clone(),
                thrust,
                speed: thrust.map(|f| rotor.speed(f)),
                lag: [rotor.rise, rotor.fall],
            });
        }
        // The scenario's file first, then the controller's, as in a log.
        let config = case.controller_config().ok().and_then(|c| c.source);
        let sources = [Some(scenario.source().clone()), config];
        for source in sources.into_iter().flatten() {
            if let Ok(table) = source.contents.parse::<toml::Table>() {
                base = base.with_configuration(table);
            }
        }
        Self {
            time: Vec::new(),
            columns: Vec::new(),
            base,
            most: case.ticks(controller.settings().rate),
            numbers: Vec::new(),
        }
    }

    /// After a tick, before the plant moves on.
    pub(crate) fn record(&mut self, controller: &Controller, plant: &Plant) {
        if self.time.len() >= self.most {
            return;
        }
        if self.columns.is_empty() {
            self.columns = names(controller)
                .into_iter()
                .map(|(topic, field)| Column {
                    topic,
                    field,
                    values: Vec::with_capacity(self.most),
                })
                .collect();
        }
        self.time.push(plant.time());
        self.numbers.clear();
        numbers(controller, plant, &mut self.numbers);
        for (column, value) in self.columns.iter_mut().zip(&self.numbers) {
            column.values.push(*value);
        }
    }

    fn signals(&self) -> Signals {
        let columns = self.columns.iter();
        columns.fold(self.base.clone(), |signals, column| {
            let series = Series {
                t: self.time.clone(),
                y: column.values.clone(),
            };
            signals.with_series(&column.topic, &column.field, series)
        })
    }

    /// The rows of a scenario's experiment, each with whether it is promised, from the tracks of its cases.
    ///
    /// # Errors
    /// In words, what is not there.
    pub(crate) fn rows(scenario: &str, tracks: &[(&str, &Self)]) -> Result<Value, String> {
        let experiment = experiments::of(scenario)
            .ok_or_else(|| format!("`{scenario}` is not one of the paper's experiments"))?;
        let runs: Vec<(&str, Signals)> = tracks
            .iter()
            .map(|(case, track)| (*case, track.signals()))
            .collect();
        let cases: Cases<'_> = runs
            .iter()
            .map(|(case, signals)| (*case, signals as &dyn Recording))
            .collect();
        let rows = experiment.rows(&cases).map_err(|error| error.to_string())?;
        let promised = promises::of(scenario).map_err(|error| error.to_string())?;
        let rows = rows.iter().map(|row| {
            let key = promises::Key::of(row);
            json!({
                "id": row.id,
                "quantity": row.quantity,
                "unit": row.unit,
                "paper": row.paper,
                "measured": row.measured,
                "tolerance": row.tolerance,
                "pass": row.pass,
                "promised": promised.promised.contains(&key),
            })
        });
        Ok(json!({ "title": experiment.title, "rows": rows.collect::<Vec<_>>() }))
    }
}

/// Topics and fields in the order of [`numbers`], named as in a log.
fn names(controller: &Controller) -> Vec<(String, String)> {
    let mut names = Vec::new();
    let mut add = |topic: &str, field: &str| names.push((topic.to_owned(), field.to_owned()));
    for field in [
        "/base/position/x",
        "/base/position/y",
        "/base/position/z",
        "/base/orientation/w",
        "/base/orientation/x",
        "/base/orientation/y",
        "/base/orientation/z",
    ] {
        add("/plant", field);
    }
    for (_, actuator, _) in controller.robot().rotors() {
        let name = escaped(&actuator.name);
        add("/command", &format!("/rotors/{name}/thrust"));
    }
    for name in controller.contact_names() {
        let topic = format!("/contact/{name}");
        for field in ["active", "alpha", "clamped"] {
            add(&topic, &format!("/{field}"));
        }
        for force in [
            "reference",
            "virtual_input",
            "solution",
            "measured",
            "position",
            "truth",
            "true_position",
        ] {
            for axis in ["x", "y", "z"] {
                add(&topic, &format!("/{force}/{axis}"));
            }
        }
    }
    add("/qp", "/times/total");
    names
}

fn numbers(controller: &Controller, plant: &Plant, out: &mut Vec<f64>) {
    let state = plant.state();
    out.extend(&state.p_WR);
    let quaternion = state.R_WR.quaternion();
    out.extend([quaternion.w, quaternion.i, quaternion.j, quaternion.k]);
    let efforts = &controller.command().effort;
    out.extend(
        controller
            .robot()
            .rotors()
            .map(|(id, _, _)| efforts[id.index()]),
    );
    let contacts = controller.contact_names();
    for (name, contact) in contacts.zip(&controller.report().contacts) {
        let task = contact.task.as_ref();
        out.extend([f64::from(u8::from(contact.on)), contact.alpha]);
        out.push(task.map_or(f64::NAN, |task| f64::from(u8::from(task.clamped))));
        let absent = [f64::NAN; 3];
        out.extend(task.map_or(absent, |task| task.reference.into()));
        out.extend(task.map_or(absent, |task| task.virtual_input.into()));
        out.extend(contact.solution.iter().take(3));
        out.extend(contact.measured.iter().take(3));
        out.extend(&contact.position);
        let known = controller.contact(name).ok().and_then(|id| {
            let state = controller.contact_state(id);
            let spec = controller.contact_spec(id);
            let (force, point) = plant.contact_at(&spec.frame)?;
            let to_surface = state.R_WC.inverse();
            let at = to_surface * (point - state.p_WS);
            Some(((to_surface * force).into(), at.into()))
        });
        let (force, point): ([f64; 3], [f64; 3]) = known.unwrap_or((absent, absent));
        out.extend(force);
        out.extend(point);
    }
    out.push(controller.report().times.total());
}
