//! How what a tick depends on is moved by a step: weights, keys, references, and what is measured.

use std::any::Any;

use nalgebra::{UnitQuaternion, Vector3};

use super::key_numbers::{self, Step};
use crate::{
    controller::Measurement,
    plugin::{AnyConstraint, AnyTask, RotationSample, Sample, VectorSample},
};

/// Steps of central differences, of the number itself where it is larger than one: rounding and curvature are about as
/// large there.
const STEP: f64 = 1e-5;
/// Of a gain that is zero or next to it.
const SMALL: f64 = 1e-2;

/// Which part of a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    Value,
    Rate,
    Acceleration,
}

/// How a parameter is moved.
#[derive(Debug)]
pub(super) enum Change {
    Weight {
        entry: usize,
        row: usize,
    },
    Gain {
        entry: usize,
        moved: Moved,
    },
    Reference {
        entry: usize,
        reference: usize,
        part: Part,
        component: usize,
    },
    Measured(Measured),
}

/// A component of the measured state, or of the wrench at a contact.
#[derive(Clone, Copy, Debug)]
pub(super) enum Measured {
    Position(usize),
    Rotation(usize),
    Joint(usize),
    Velocity(usize),
    Wrench(usize, usize),
}

/// All keys of an entry with one number below and above its value, and the step between.
#[derive(Debug)]
pub(super) struct Moved {
    below: Keys,
    above: Keys,
    step: f64,
}

#[derive(Debug)]
enum Keys {
    Task(Box<dyn AnyTask>),
    Constraint(Box<dyn AnyConstraint>),
}

impl Keys {
    fn read(table: toml::Table, is_task: bool) -> Option<Self> {
        let table = toml::Value::Table(table);
        if is_task {
            table.try_into().ok().map(Self::Task)
        } else {
            table.try_into().ok().map(Self::Constraint)
        }
    }

    fn as_any(&mut self) -> &mut dyn Any {
        match self {
            Self::Task(task) => &mut **task,
            Self::Constraint(constraint) => &mut **constraint,
        }
    }
}

impl Moved {
    /// Nothing if the keys of a task or constraint could not be read with the number moved.
    pub(super) fn new(
        table: &toml::Table,
        path: &[Step],
        value: f64,
        is_task: bool,
    ) -> Option<Self> {
        let step = STEP * value.abs().max(SMALL);
        let keys = |step: f64| {
            let mut table = table.clone();
            key_numbers::put(&mut table, path, value + step);
            Keys::read(table, is_task)
        };
        Some(Self {
            below: keys(-step)?,
            above: keys(step)?,
            step,
        })
    }

    pub(super) fn keys(&mut self, is_above: bool) -> &mut dyn Any {
        if is_above {
            self.above.as_any()
        } else {
            self.below.as_any()
        }
    }

    pub(super) fn step(&self) -> f64 {
        self.step
    }
}

/// The step of a number.
pub(super) fn step(value: f64) -> f64 {
    STEP * value.abs().max(1.0)
}

/// Moves what is measured by a step.
pub(super) fn measure(measurement: &mut Measurement, what: Measured, step: f64) {
    let state = &mut measurement.state;
    match what {
        Measured::Position(i) => state.p_WR[i] += step,
        Measured::Rotation(i) => {
            let turn = UnitQuaternion::from_scaled_axis(Vector3::ith(i, step));
            state.R_WR = turn * state.R_WR;
        }
        Measured::Joint(i) => state.q[i] += step,
        Measured::Velocity(i) => state.v[i] += step,
        Measured::Wrench(contact, i) => measurement.wrenches[contact][i] += step,
    }
}

/// What is measured; zero for small rotations.
pub(super) fn measured(measurement: &Measurement, what: Measured) -> f64 {
    let state = &measurement.state;
    match what {
        Measured::Position(i) => state.p_WR[i],
        Measured::Rotation(_) => 0.0,
        Measured::Joint(i) => state.q[i],
        Measured::Velocity(i) => state.v[i],
        Measured::Wrench(contact, i) => measurement.wrenches[contact][i],
    }
}

/// What a sample was before it was moved.
#[derive(Clone, Copy, Debug)]
pub(super) enum Kept {
    Number(f64),
    Rotation(RotationSample),
}

fn number(sample: &mut VectorSample, part: Part, component: usize) -> Option<&mut f64> {
    let numbers = match part {
        Part::Value => &mut sample.value,
        Part::Rate => &mut sample.rate,
        Part::Acceleration => &mut sample.acceleration,
    };
    numbers.get_mut(component)
}

/// Moves a component of a sample by a step; rotations multiply on the left.
pub(super) fn follow(sample: &mut Sample, part: Part, component: usize, step: f64) -> Kept {
    match sample {
        Sample::Vector(sample) => {
            let Some(number) = number(sample, part, component) else {
                return Kept::Number(0.0);
            };
            let kept = Kept::Number(*number);
            *number += step;
            kept
        }
        Sample::Rotation(sample) => {
            let kept = Kept::Rotation(*sample);
            match part {
                Part::Value => {
                    let turn = UnitQuaternion::from_scaled_axis(Vector3::ith(component, step));
                    sample.rotation = turn * sample.rotation;
                }
                Part::Rate => sample.rate[component] += step,
                Part::Acceleration => sample.acceleration[component] += step,
            }
            kept
        }
    }
}

/// Makes a sample what it was.
pub(super) fn put_back(sample: &mut Sample, part: Part, component: usize, kept: Kept) {
    match (sample, kept) {
        (Sample::Vector(sample), Kept::Number(kept)) => {
            if let Some(number) = number(sample, part, component) {
                *number = kept;
            }
        }
        (Sample::Rotation(sample), Kept::Rotation(kept)) => *sample = kept,
        _ => {}
    }
}

/// A component of a sample; zero for small rotations.
pub(super) fn followed(sample: &Sample, part: Part, component: usize) -> f64 {
    match (sample, part) {
        (Sample::Vector(sample), part) => {
            let all = sample.component(component);
            all[part as usize]
        }
        (Sample::Rotation(_), Part::Value) => 0.0,
        (Sample::Rotation(sample), Part::Rate) => sample.rate[component],
        (Sample::Rotation(sample), Part::Acceleration) => sample.acceleration[component],
    }
}
