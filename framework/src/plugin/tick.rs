//! What a plug-in sees during one tick: borrowed, short-lived, already computed; and the references that a task
//! follows, begun at what is measured and sampled before each update.
//!
//! # Notation
//! W world (z up), R base, F a named frame, C a contact frame (z along the surface's outward normal). Frame
//! Jacobians are world-aligned, contact Jacobians in C axes; both linear first.

use nalgebra::{DVector, UnitQuaternion, Vector3, Vector6};

use crate::{
    contact::{ContactId, ContactState},
    plugin::{
        FrameHandle, Reference, RotationReference, RotationSample, Sample, VectorReference,
        VectorSample,
        followed::{Bound, Followed, Measured, RunningReference},
    },
};
use wbqp_dynamics::{Data, FrameKinematics, model::Model, state::State};

/// The inputs of one tick.
#[derive(Clone, Copy, Debug)]
pub struct Tick<'a> {
    /// Time since the controller's first tick, s.
    pub time: f64,
    /// Control period, s: what looks ahead looks so far.
    pub period: f64,
    /// Time that this tick stands for, s: what integrals and filters grow by. The time since the last usable state
    /// (whatever the wrenches were), four periods at the most; exactly the period in a loop that keeps its rate, and in
    /// the first tick.
    pub elapsed: f64,
    /// Time for which an actuator's `slew` counts in this tick, s: since the tick before, a period at the most.
    pub slew_time: f64,
    /// The robot.
    pub model: &'a Model,
    /// Measured state; velocities world-aligned.
    pub state: &'a State,
    /// `M`, `h`, gravity, centre of mass for that state.
    pub dynamics: &'a Data,
    /// Generalised acceleration of the last tick with a solution, size nv.
    pub last_vdot: &'a DVector<f64>,
    /// What tasks asked of `v̇` in that tick, size nv: for each component the virtual input `a*` of the live tasks
    /// whose rows are that component alone, their mean by weight if there are several, the hard one's if one is
    /// hard. Zero where no task asks, and before the first tick.
    pub last_virtual_input: &'a DVector<f64>,
    /// Efforts that the last tick sent, within limits, N or N·m, size nu. Before the first tick, the hover.
    pub last_effort: &'a DVector<f64>,
    /// Estimate of the wrench on a floating base that the model does not have, `[force; moment]` about the base's
    /// origin, world axes, N and N·m; zero without an [observer](crate::settings::Observer).
    pub disturbance: Vector6<f64>,
    /// Ramp of the plug-in's own entry, from 0 (off) to 1 (on); the framework has applied it to the weight already.
    pub alpha: f64,
    /// Time of the tick in which its entry was switched last, s; −∞ before.
    pub since: f64,
    pub(crate) frames: &'a [FrameKinematics],
    pub(crate) contacts: &'a [ContactState],
    /// The plug-in's own.
    pub(crate) references: &'a [Followed],
}

/// What a tick keeps for plug-ins in the next one, as they see it there.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct PreviousSolution {
    pub(crate) virtual_input: DVector<f64>,
    pub(crate) vdot: DVector<f64>,
    pub(crate) effort: DVector<f64>,
}

impl<'a> Tick<'a> {
    /// Pose, velocity, Jacobian and bias acceleration of a frame requested in `bind`.
    #[inline]
    pub fn frame(&self, frame: FrameHandle) -> &'a FrameKinematics {
        // A handle is made by the controller that owns this tick; the base frame is always computed.
        self.frames.get(frame.0).unwrap_or(&self.frames[0])
    }

    /// A contact's state; also while it is off.
    #[inline]
    pub fn contact(&self, contact: ContactId) -> &'a ContactState {
        self.contacts
            .get(contact.index())
            .unwrap_or_else(|| &self.contacts[0])
    }

    /// Where the plug-in's reference is in this tick.
    #[inline]
    pub fn vector(&self, reference: VectorReference) -> &'a VectorSample {
        // A handle is made by the setup of this plug-in.
        match self.references.get(reference.0).map(|r| &r.sample) {
            Some(Sample::Vector(sample)) => sample,
            _ => &NO_VECTOR,
        }
    }

    /// Where the plug-in's reference is in this tick.
    #[inline]
    pub fn rotation(&self, reference: RotationReference) -> RotationSample {
        match self.references.get(reference.0).map(|r| &r.sample) {
            Some(Sample::Rotation(sample)) => *sample,
            _ => RotationSample::at_rest(UnitQuaternion::identity()),
        }
    }

    /// All contacts, in the order of the configuration; also those that are off.
    pub fn contacts(&self) -> &'a [ContactState] {
        self.contacts
    }
}

impl Sample {
    /// Stands still at another one's value, if both are of the same space. Does not allocate.
    pub fn stand_at(&mut self, other: &Self) {
        match (self, other) {
            (Self::Vector(sample), Self::Vector(other)) => sample.stand_at(other),
            (Self::Rotation(sample), Self::Rotation(other)) => {
                *sample = RotationSample::at_rest(other.rotation);
            }
            _ => {}
        }
    }
}

impl VectorSample {
    /// Value, rate and acceleration of a component; zeros for one that is missing.
    #[inline]
    pub fn component(&self, index: usize) -> [f64; 3] {
        [&self.value, &self.rate, &self.acceleration]
            .map(|numbers| numbers.get(index).copied().unwrap_or(0.0))
    }

    /// Stands still at another one's value, as far as there is room. Does not allocate.
    pub fn stand_at(&mut self, other: &Self) {
        for (value, other) in self.value.iter_mut().zip(&other.value) {
            *value = *other;
        }
        self.rate.fill(0.0);
        self.acceleration.fill(0.0);
    }

    /// Value as a 3-vector; missing components are zero.
    pub fn value3(&self) -> Vector3<f64> {
        three(&self.value)
    }

    /// Rate as a 3-vector; missing components are zero.
    pub fn rate3(&self) -> Vector3<f64> {
        three(&self.rate)
    }

    /// Acceleration as a 3-vector; missing components are zero.
    pub fn acceleration3(&self) -> Vector3<f64> {
        three(&self.acceleration)
    }
}

impl RotationSample {
    /// This orientation, standing still.
    pub fn at_rest(rotation: UnitQuaternion<f64>) -> Self {
        Self {
            rotation,
            rate: Vector3::zeros(),
            acceleration: Vector3::zeros(),
        }
    }
}

fn three(x: &[f64]) -> Vector3<f64> {
    Vector3::from_fn(|i, _| x.get(i).copied().unwrap_or(0.0))
}

static NO_VECTOR: VectorSample = VectorSample {
    value: Vec::new(),
    rate: Vec::new(),
    acceleration: Vec::new(),
};

impl Measured {
    /// Writes it into a sample of its space.
    pub(super) fn write(&self, tick: &Tick<'_>, out: &mut Sample) {
        match (self, out) {
            (Self::Vector(measured), Sample::Vector(out)) => measured(tick, &mut out.value),
            (Self::Rotation(measured), Sample::Rotation(out)) => out.rotation = measured(tick),
            _ => {}
        }
    }
}

impl<R: Reference> RunningReference for Bound<R> {
    fn start(&mut self, time: f64, from: &Sample) {
        self.parameters.start(&mut self.running, time, from);
    }

    fn sample(&mut self, tick: &Tick<'_>, out: &mut Sample) {
        self.parameters.sample(&mut self.running, tick, out);
    }
}

/// The largest distance, m or rad, at which a robot that is measured near its home counts as at home: more than a good
/// sensor's noise, less than what can be seen.
pub const AT_HOME: f64 = 5e-3;

impl Followed {
    /// Starts at what is measured in the first tick. What is within [`AT_HOME`] of where it starts already (the length
    /// of the difference, or the angle) counts as noise, and nothing changes. Values that the reference's parameters
    /// give stay.
    pub(crate) fn start_here(&mut self, tick: &Tick<'_>) {
        let Some(measured) = &self.measured else {
            return;
        };
        measured.write(tick, &mut self.here);
        if distance(&self.here, &self.sample) > AT_HOME {
            self.sample.stand_at(&self.here);
            self.start(0.0);
        }
    }

    /// The sample for this tick.
    pub(crate) fn update(&mut self, tick: &Tick<'_>) {
        self.reference.0.sample(tick, &mut self.sample);
    }
}

fn distance(a: &Sample, b: &Sample) -> f64 {
    match (a, b) {
        (Sample::Vector(a), Sample::Vector(b)) => {
            let squares = a.value.iter().zip(&b.value).map(|(a, b)| (a - b) * (a - b));
            squares.sum::<f64>().sqrt()
        }
        (Sample::Rotation(a), Sample::Rotation(b)) => a.rotation.angle_to(&b.rotation),
        _ => 0.0,
    }
}
