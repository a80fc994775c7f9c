//! Quantities of a robot as another library says, against ours: what files made with `oracles/tree.py` have in common.
#![allow(non_snake_case)]

use std::collections::BTreeMap;

use serde_json::Value;
use wbqp::{
    dynamics::{Data, FrameKinematics},
    model::Model,
    nalgebra::{DMatrix, DVector, Quaternion, UnitQuaternion, Vector3},
    state::State,
};

/// Of the largest entry of a quantity (a matrix, a vector): what its entries may differ by.
pub const TOLERANCE: f64 = 1e-9;

/// What is as good as zero in a quantity that is zero, SI units: a hundred times what is left of sums that cancel.
const ZERO: f64 = 1e-13;

/// A model's quantities compared with a file's, and the largest difference of each.
#[derive(Debug)]
pub struct Comparison<'a> {
    name: String,
    model: &'a Model,
    /// `order[i]` is the place in the file of velocity `i` of the model.
    order: Vec<usize>,
    data: Data,
    worst: &'a mut Worst,
}

/// The largest relative difference of each quantity, and whose it is.
#[derive(Debug, Default)]
pub struct Worst(BTreeMap<&'static str, (f64, String)>);

impl Worst {
    /// A line per quantity.
    pub fn lines(&self) -> String {
        let lines = self.0.iter();
        let lines: Vec<String> = lines
            .map(|(what, (error, name))| format!("{what:10} {error:.1e} ({name})"))
            .collect();
        lines.join("\n")
    }

    fn note(&mut self, what: &'static str, error: f64, name: &str) {
        let worst = self.0.entry(what).or_insert((0.0, String::new()));
        if error >= worst.0 {
            *worst = (error, name.to_owned());
        }
    }
}

impl<'a> Comparison<'a> {
    /// Of a robot whose `joints` are named in the file's order.
    ///
    /// # Errors
    /// If the degrees of freedom are not the same.
    pub fn new(
        name: &str,
        model: &'a Model,
        joints: &Value,
        worst: &'a mut Worst,
    ) -> Result<Self, String> {
        let theirs: Vec<&str> = list(joints).iter().filter_map(Value::as_str).collect();
        let ours: Vec<&str> = model.joints().iter().map(|j| j.name.as_str()).collect();
        let offset = model.joint_offset();
        let places = ours
            .iter()
            .map(|name| Some(offset + theirs.iter().position(|other| other == name)?));
        let places: Option<Vec<usize>> = places.collect();
        match places {
            Some(places) if ours.len() == theirs.len() => Ok(Self {
                name: name.to_owned(),
                model,
                order: (0..offset).chain(places).collect(),
                data: Data::new(model),
                worst,
            }),
            _ => Err(format!(
                "{name}: degrees of freedom are {ours:?}, not {theirs:?}"
            )),
        }
    }

    /// Compares everything that the file says of one state, which [`Self::data`] is then of.
    ///
    /// # Errors
    /// All quantities that are off, a line each.
    pub fn state(&mut self, entry: &Value) -> Result<(), String> {
        let state = self.read_state(entry);
        self.data.update(self.model, &state);
        let M = matrix(&entry["mass_matrix"])
            .select_rows(&self.order)
            .select_columns(&self.order);
        let h = self.ours(&entry["h"]);
        let [linear, angular] = ["linear", "angular"].map(|key| numbers(&entry["momentum"][key]));
        let (our_M, our_h) = (self.data.mass_matrix().clone(), self.data.bias().clone());
        let (com, momentum) = (self.data.center_of_mass(), self.data.centroidal_momentum());
        let mut errors = vec![
            self.same("M", our_M.as_slice(), M.as_slice()),
            self.same("h", our_h.as_slice(), h.as_slice()),
            self.same("com", com.as_slice(), &numbers(&entry["com"])),
            self.same("momentum", momentum.as_slice(), &[linear, angular].concat()),
        ];
        for frame in list(&entry["frames"]) {
            errors.push(self.frame(frame));
        }
        let errors: Vec<String> = errors.into_iter().filter_map(Result::err).collect();
        if errors.is_empty() {
            return Ok(());
        }
        Err(errors.join("\n"))
    }

    /// What the model computes in the last state that was compared.
    pub fn data(&mut self) -> &mut Data {
        &mut self.data
    }

    /// A vector over velocities, in our order.
    pub fn ours(&self, theirs: &Value) -> DVector<f64> {
        vector(theirs).select_rows(&self.order)
    }

    fn frame(&mut self, entry: &Value) -> Result<(), String> {
        let name = entry["name"].as_str().unwrap_or_default();
        let Some(frame) = self.model.frame(name) else {
            return Err(format!("{}: no frame {name}", self.name));
        };
        let mut k = FrameKinematics::new(self.model);
        k.update(self.model, &self.data, frame);
        let J = self.columns(&entry["jacobian"]);
        let R = matrix(&entry["R"]);
        [
            self.same("p", k.p_WF.as_slice(), &numbers(&entry["p"])),
            self.same("R", k.R_WF.matrix().as_slice(), R.as_slice()),
            self.same("J", k.J.as_slice(), J.as_slice()),
            self.same("Jdot_v", k.Jdot_v.as_slice(), &numbers(&entry["bias"])),
        ]
        .into_iter()
        .collect::<Result<(), String>>()
        .map_err(|error| format!("{error}, frame {name}"))
    }

    fn read_state(&self, entry: &Value) -> State {
        let mut state = State::neutral(self.model);
        if self.model.joint_offset() == 6 {
            let q = numbers(&entry["base"]["quaternion_wxyz"]);
            state.p_WR = Vector3::from_column_slice(&numbers(&entry["base"]["p"]));
            state.R_WR = UnitQuaternion::from_quaternion(Quaternion::new(q[0], q[1], q[2], q[3]));
        }
        for (joint, q) in self.model.joints().iter().zip(state.q.iter_mut()) {
            *q = entry["q"][&joint.name].as_f64().unwrap_or(f64::NAN);
        }
        state.v = self.ours(&entry["v"]);
        state
    }

    /// A matrix with a column per velocity, in our order.
    pub fn columns(&self, theirs: &Value) -> DMatrix<f64> {
        matrix(theirs).select_columns(&self.order)
    }

    /// Total mass, kg.
    ///
    /// # Errors
    /// If it is another one.
    pub fn mass(&mut self, theirs: &Value) -> Result<(), String> {
        self.same("mass", &[self.model.mass()], &[number(theirs)])
    }

    /// Compares one quantity.
    ///
    /// # Errors
    /// If it is off by more than [`TOLERANCE`] of its largest entry, or is not finite.
    pub fn same(&mut self, what: &'static str, ours: &[f64], theirs: &[f64]) -> Result<(), String> {
        if ours.len() != theirs.len() {
            let sizes = [ours.len(), theirs.len()];
            return Err(format!("{}: sizes of {what} are {sizes:?}", self.name));
        }
        let largest = |x: &mut dyn Iterator<Item = f64>| x.fold(0.0, |m: f64, y| m.max(y.abs()));
        let error = largest(&mut ours.iter().zip(theirs).map(|(a, b)| a - b));
        let size = largest(&mut theirs.iter().copied());
        let allowed = (TOLERANCE * size).max(ZERO);
        if size > ZERO {
            self.worst.note(what, error / size, &self.name);
        }
        if ours.iter().chain(theirs).all(|x| x.is_finite()) && error <= allowed {
            return Ok(());
        }
        let name = &self.name;
        Err(format!(
            "{name}: {what} is off by {error:e}, its largest entry is {size:e}"
        ))
    }
}

/// The entries of a list; none of what is no list.
pub fn list(value: &Value) -> &[Value] {
    value.as_array().map_or(&[], Vec::as_slice)
}

/// A number; not a number if it is something else.
fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or(f64::NAN)
}

/// A list of numbers.
pub fn numbers(value: &Value) -> Vec<f64> {
    list(value).iter().map(number).collect()
}

fn vector(value: &Value) -> DVector<f64> {
    DVector::from_vec(numbers(value))
}

/// A list of rows.
fn matrix(value: &Value) -> DMatrix<f64> {
    let rows: Vec<Vec<f64>> = list(value).iter().map(numbers).collect();
    DMatrix::from_row_slice(rows.len(), rows.first().map_or(0, Vec::len), &rows.concat())
}
