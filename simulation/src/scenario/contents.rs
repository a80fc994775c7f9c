//! What the file says of one case, with its own changes and a variation's.

use std::{ops::Range, path::PathBuf, sync::Arc};

use toml::Spanned;
use wbqp::contact::Detector;

use super::{Event, Initial, file::Keys};
use crate::{PlantConfig, SensorsConfig};

/// What the scenario's file says of a case.
#[derive(Clone, Debug)]
pub(super) struct Contents {
    /// The scenario's name.
    pub(super) scenario: Spanned<String>,
    pub(super) controller: PathBuf,
    pub(super) duration: f64,
    pub(super) initial: Initial,
    pub(super) plant: PlantConfig,
    pub(super) sensors: SensorsConfig,
    pub(super) detectors: Listed<Detector>,
    /// The same as that of other cases that have the same, where no case changes them.
    pub(super) events: Arc<Listed<Event>>,
}

/// The entries of a list.
#[derive(Clone, Debug)]
pub(super) struct Listed<T> {
    pub(super) entries: Vec<T>,
    /// Where each is in the text.
    places: Vec<Range<usize>>,
}

impl<T> Listed<T> {
    /// Each with its place in the text.
    pub(super) fn iter(&self) -> impl Iterator<Item = (&T, &Range<usize>)> {
        self.entries.iter().zip(&self.places)
    }
}

impl<T> From<Vec<Spanned<T>>> for Listed<T> {
    fn from(entries: Vec<Spanned<T>>) -> Self {
        Self {
            places: entries.iter().map(Spanned::span).collect(),
            entries: entries.into_iter().map(Spanned::into_inner).collect(),
        }
    }
}

impl Contents {
    pub(super) fn new(keys: Keys, events: Arc<Listed<Event>>) -> Self {
        Self {
            scenario: keys.name,
            controller: keys.controller,
            duration: keys.duration,
            initial: keys.initial,
            plant: keys.plant,
            sensors: keys.sensors,
            detectors: keys.detectors.into(),
            events,
        }
    }

    /// How many entries its lists have, without the events.
    pub(super) fn entries(&self) -> usize {
        let plant = &self.plant;
        let in_plant = plant.walls.len() + plant.contact_points.len() + plant.disturbances.len();
        let in_sensors = self.sensors.force_torque.len() + self.sensors.outages.len();
        self.detectors.entries.len() + in_plant + in_sensors
    }
}
