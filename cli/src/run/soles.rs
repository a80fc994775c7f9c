//! Sizes of soles: of flat contacts, from the constraints that know them.
//!
//! # Notation
//! `C` is a contact's surface frame, `E` the robot's frame that touches.
#![allow(non_snake_case)]

use anyhow::Result;
use wbqp::{
    ControllerConfig,
    contact::ContactSpec,
    nalgebra::{Rotation3, Vector3},
};

/// Half lengths of the soles, by contact.
pub(super) struct Soles(Vec<(String, [f64; 2])>);

impl Soles {
    pub(super) fn of(config: &ControllerConfig) -> Result<Self> {
        let file: toml::Table = config.to_toml()?.parse()?;
        let constraints = file.get("constraint").and_then(toml::Value::as_array);
        let sole = |entry: &toml::Value| {
            let number = |key| entry.get(key)?.as_float();
            let contact = entry.get("contact")?.as_str()?.to_owned();
            let lengths = [number("half_length_x")?, number("half_length_y")?];
            Some((contact, lengths))
        };
        let soles = constraints.into_iter().flatten().filter_map(sole);
        Ok(Self(soles.collect()))
    }

    /// Where a contact touches, in E: its point, or the four corners of its sole, one after the other around it.
    pub(super) fn points(&self, contact: &ContactSpec, R_EC: &Rotation3<f64>) -> Vec<Vector3<f64>> {
        let offset = Vector3::from(contact.offset);
        let sole = self.0.iter().find(|(name, _)| *name == contact.name);
        match sole {
            Some((_, [x, y])) if contact.kind.has_moments() => {
                let corners = [(1., 1.), (1., -1.), (-1., -1.), (-1., 1.)];
                let corner = |(a, b)| offset + R_EC * Vector3::new(a * x, b * y, 0.0);
                corners.into_iter().map(corner).collect()
            }
            _ => vec![offset],
        }
    }
}
