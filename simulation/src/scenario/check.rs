//! What is wrong with a case: by making its controller, plant and sensors, and what none of them knows alone.

use std::{collections::HashSet, sync::Arc};

use wbqp::{config::plausible, contact::Detector};

use super::{
    Case, Event, ScenarioError,
    contradiction::contradiction,
    groups::{Common, Groups, Known},
    push::Asked,
    text::Text,
};

/// Control periods of a run, at most: at 250 Hz more than four days of simulated time.
const MOST_TICKS: f64 = 1e8;
/// Integration steps of a run, at most: at some microseconds each, a day.
const MOST_STEPS: f64 = 1e10;

impl Case {
    /// Makes everything once, as far as no other case of its group did.
    pub(super) fn check(
        &self,
        index: usize,
        text: &Text<'_>,
        groups: &Groups<'_>,
    ) -> Result<(), ScenarioError> {
        if !(self.contents.duration.is_finite() && self.contents.duration > 0.0) {
            return Err(self.refuse(&format!(
                "duration: is {} s, must be positive and finite",
                self.contents.duration
            )));
        }
        let common = groups.common(index, self)?;
        if common.is_checked(&self.contents) {
            return Ok(());
        }
        if self.ticks(common.rate) == 0 {
            return Err(self.refuse(&format!(
                "duration: is {} s, shorter than a control period, which is {} s",
                self.contents.duration,
                1.0 / common.rate
            )));
        }
        self.check_marks(text)?;
        let plant = self.make_plant(&common.robot)?;
        self.check_length(common.rate)?;
        self.make_sensors(&plant, 0)?;
        self.check_beginnings(text, common.rate)?;
        self.check_detectors(text, groups, &common)?;
        let known = if let Some(known) = common.known(&self.contents) {
            known
        } else {
            let asked = self.check_events(text, groups, &common)?;
            let known = Arc::new(Known {
                contents: self.contents.clone(),
                asked,
            });
            common.remember(&known);
            known
        };
        self.check_pushes(text, &common.robot, &common.contacts, &known.asked)?;
        common.checked(&self.contents);
        Ok(())
    }

    /// Refuses a run that would not end in a day or two.
    fn check_length(&self, rate: f64) -> Result<(), ScenarioError> {
        let ticks = self.contents.duration * rate;
        if ticks > MOST_TICKS {
            return Err(self.refuse(&format!(
                "duration: is {:e} s, which are {ticks:.1e} control periods at {rate} Hz; a run has at most \
                 {MOST_TICKS:e}: make it shorter",
                self.contents.duration
            )));
        }
        let steps = ticks * (1.0 / (rate * self.contents.plant.step)).ceil();
        if steps > MOST_STEPS {
            return Err(self.refuse(&format!(
                "plant.step: is {:e} s, which makes {steps:.1e} steps in {} s; a run has at most {MOST_STEPS:e}: make \
                 the step larger or the run shorter",
                self.contents.plant.step, self.contents.duration
            )));
        }
        Ok(())
    }

    /// The log keeps the times of each disturbance under marks of its own.
    fn check_marks(&self, text: &Text<'_>) -> Result<(), ScenarioError> {
        let mut disturbances: HashSet<&str> = HashSet::new();
        for (index, disturbance) in self.contents.plant.disturbances.iter().enumerate() {
            let name = disturbance.name.as_str();
            // Changes call it by its name as well.
            if !disturbances.insert(name) {
                let of_nameless = match name {
                    crate::plant::DISTURBANCE => ", which one without a name has,",
                    _ => "",
                };
                return Err(self.refuse(&format!(
                    "plant.disturbance[{index}].name: `{name}`{of_nameless} is used twice: give it another one"
                )));
            }
        }
        for (event, span) in self.contents.events.iter() {
            let Some(mark) = &event.mark else {
                continue;
            };
            plausible::check_name(mark).map_err(|what| ScenarioError::Value {
                place: text.place(span.start),
                what: format!("event at {} s: mark: {what}", event.at),
            })?;
            let mut names = ["_start", "_end"]
                .iter()
                .filter_map(|end| mark.strip_suffix(end));
            let taken = names.find(|name| disturbances.contains(name));
            if let Some(disturbance) = taken {
                return Err(ScenarioError::Value {
                    place: text.place(span.start),
                    what: format!(
                        "event `{mark}` at {} s: the log keeps a time of the disturbance `{}` under this mark; take \
                         another one",
                        event.at, disturbance
                    ),
                });
            }
        }
        Ok(())
    }

    fn check_detectors(
        &self,
        text: &Text<'_>,
        groups: &Groups<'_>,
        common: &Common,
    ) -> Result<(), ScenarioError> {
        let mut detected = HashSet::new();
        for (detector, span) in self.contents.detectors.iter() {
            let refuse = |what: String| ScenarioError::Value {
                place: text.place(span.start),
                what: format!("detector: {what}"),
            };
            detector.validate().map_err(|e| refuse(e.to_string()))?;
            detector_numbers(detector).map_err(refuse)?;
            if !detected.insert(&detector.contact) {
                let what = format!("contact `{}` has a detector already", detector.contact);
                return Err(refuse(what));
            }
            let mut contacts = common.contacts.iter();
            let Some(contact) = contacts.find(|c| c.name == detector.contact) else {
                // It says which there are.
                let controller = groups.fresh(self, common)?;
                let unknown = controller.contact(&detector.contact).err();
                return Err(refuse(unknown.map_or_else(String::new, |e| e.to_string())));
            };
            if self.force_torque_at(&contact.frame).is_none() {
                return Err(refuse(no_force(&contact.name, &contact.frame)));
            }
        }
        Ok(())
    }

    /// Applies every event once, and looks at what is asked of the controller until the end.
    fn check_events(
        &self,
        text: &Text<'_>,
        groups: &Groups<'_>,
        common: &Common,
    ) -> Result<Vec<Asked>, ScenarioError> {
        let mut controller = groups.fresh(self, common)?;
        let rate = common.rate;
        let last_tick = self.ticks(rate).saturating_sub(1) as f64 / rate;
        let mut marks = HashSet::new();
        let refuse_event = |index, event: &Event, span, what: &str| ScenarioError::Value {
            place: text.place_in_event(self.name(), index, span, what),
            what: match &event.mark {
                Some(mark) => format!("event `{mark}` at {} s: {what}", event.at),
                None => format!("event at {} s: {what}", event.at),
            },
        };
        for (index, (event, span)) in self.contents.events.iter().enumerate() {
            let refuse = |what: String| refuse_event(index, event, span, &what);
            if event.is_idle() {
                return Err(refuse(
                    "does nothing: give it an action, such as `follow`, or a `mark`, or take it out".into(),
                ));
            }
            // The check applies every event to a controller that never runs.
            event.apply(&mut controller).map_err(&refuse)?;
            event.check_numbers(&controller).map_err(&refuse)?;
            for contact in common
                .contacts
                .iter()
                .filter(|c| event.tare.contains(&c.name))
            {
                if self.force_torque_at(&contact.frame).is_none() {
                    let what = no_force(&contact.name, &contact.frame);
                    return Err(refuse(format!("tare: {what}")));
                }
            }
            if event.at > last_tick + 1e-6 / rate {
                return Err(refuse(format!(
                    "would never happen: the last tick is at {last_tick:.3} s"
                )));
            }
            if let Some(mark) = &event.mark
                && !marks.insert(mark.as_str())
            {
                return Err(refuse("another event has the same mark".into()));
            }
        }
        if let Some((index, what)) = contradiction(self.events())
            && let Some((event, span)) = self.contents.events.iter().nth(index)
        {
            return Err(refuse_event(index, event, span, &what));
        }
        let mut events: Vec<&Event> = self.events().iter().collect();
        events.sort_by(|a, b| a.at.total_cmp(&b.at));
        if !events.is_empty() {
            // Without what happens later.
            controller = groups.fresh(self, common)?;
        }
        self.asked(&mut controller, &events)
    }
}

/// What can hardly be meant of the numbers of a detector.
///
/// # Errors
/// What cannot be.
pub(super) fn detector_numbers(detector: &Detector) -> Result<Vec<String>, String> {
    let mut warnings = Vec::new();
    for (key, value, unit) in [
        ("on", detector.on, "N"),
        ("off", detector.off, "N"),
        ("dwell", detector.dwell, "s"),
    ] {
        let named = |what| format!("`{key}` {what}");
        warnings.extend(
            plausible::check(key, value, unit)
                .map_err(named)?
                .map(named),
        );
    }
    Ok(warnings)
}

fn no_force(contact: &str, frame: &str) -> String {
    format!(
        "no force is measured at contact `{contact}`: there is no [[sensors.force_torque]] with frame = \"{frame}\""
    )
}
