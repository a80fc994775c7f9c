//! Makes plug-ins and lets them write their rows for chosen inputs.

use std::{
    any::Any,
    ops::{Deref, DerefMut},
    panic::{AssertUnwindSafe, catch_unwind, resume_unwind},
};

use nalgebra::{DVector, Vector3, Vector6};
use toml::Table;

use crate::{
    Check,
    report::Report,
    scatter::Scatter,
    subject::{Subject, load},
};
use wbqp::{
    contact::ContactSpec,
    controller::{Probe, ProbeInputs, WrittenRows},
    dynamics::{Data, frame_motion},
    error::BindError,
    plugin::Layout,
    robot::RobotModel,
    state::State,
};

/// Control period of the tests, s.
const PERIOD: f64 = 0.004;

/// Time of all updates, s.
const TIME: f64 = 0.3;

/// A panic of the plug-in, as opposed to one of the kit.
struct PluginPanic(String);

/// Calls a method of the plug-in; a panic in it goes on as a [`PluginPanic`].
fn guarded<T>(method: &str, call: impl FnOnce() -> T) -> T {
    // What a plug-in leaves behind is not used again: the panic ends the tests on this robot.
    catch_unwind(AssertUnwindSafe(call)).unwrap_or_else(|payload| {
        let said = words(&*payload);
        resume_unwind(Box::new(PluginPanic(format!("`{method}` panics: {said}"))))
    })
}

/// Runs the tests on a robot, and reports a panic of the plug-in.
pub(crate) fn report_panics(
    robot: &RobotModel,
    report: &mut Report,
    tests: impl FnOnce(&mut Report),
) {
    let Err(payload) = catch_unwind(AssertUnwindSafe(|| tests(report))) else {
        return;
    };
    match payload.downcast::<PluginPanic>() {
        Ok(panic) => report.fail(Check::Panic, robot.model.name(), panic.0),
        Err(other) => resume_unwind(other),
    }
}

/// What a panic says.
fn words(payload: &(dyn Any + Send)) -> &str {
    payload
        .downcast_ref::<String>()
        .map(String::as_str)
        .or_else(|| payload.downcast_ref::<&str>().copied())
        .unwrap_or("without a message")
}

/// A plug-in in its TOML form on one robot.
pub(crate) struct Bench<'a> {
    pub(crate) form: &'a Table,
    pub(crate) robot: &'a RobotModel,
    pub(crate) contacts: &'a [ContactSpec],
    pub(crate) allocations: Option<&'a dyn Fn() -> usize>,
}

/// Everything that can change from tick to tick: always at the same time, so that trajectories drop out of differences.
#[derive(Clone, Debug)]
pub(crate) struct Inputs(pub(crate) ProbeInputs);

impl Deref for Inputs {
    type Target = ProbeInputs;

    fn deref(&self) -> &ProbeInputs {
        &self.0
    }
}

impl DerefMut for Inputs {
    fn deref_mut(&mut self) -> &mut ProbeInputs {
        &mut self.0
    }
}

impl Inputs {
    pub(crate) fn random(bench: &Bench<'_>, scatter: &mut Scatter) -> Self {
        let model = &bench.robot.model;
        let six = |scatter: &mut Scatter| {
            let x = scatter.vector(6, 5.0);
            Vector6::from_fn(|i, _| x[i])
        };
        let forces = bench.contacts.iter().map(|contact| {
            let mut force = six(scatter);
            for &free in contact.kind.free() {
                force[free] = 0.0;
            }
            force
        });
        let forces = forces.collect();
        Self(ProbeInputs {
            time: TIME,
            state: scatter.state(model),
            effort: DVector::from_iterator(
                bench.robot.nu(),
                bench.robot.actuators.iter().map(|actuator| {
                    scatter.number(actuator.lower.max(-20.0), actuator.upper.min(20.0))
                }),
            ),
            vdot: scatter.vector(model.nv(), 5.0),
            wrenches: bench.contacts.iter().map(|_| six(scatter)).collect(),
            forces,
        })
    }

    /// The same with another velocity.
    pub(crate) fn moving(&self, v: &DVector<f64>) -> Self {
        let mut moved = self.clone();
        moved.state.v.copy_from(v);
        moved
    }

    /// The same with the configuration moved on along a velocity for a time; the inputs' own velocity stays.
    pub(crate) fn displaced(&self, bench: &Bench<'_>, v: &DVector<f64>, time: f64) -> Self {
        let mut moved = self.clone();
        moved.state.advance(&bench.robot.model, v, time);
        moved
    }

    /// The same at rest.
    pub(crate) fn at_rest(&self) -> Self {
        self.moving(&DVector::zeros(self.state.v.len()))
    }
}

/// What a plug-in wrote.
#[derive(Clone, Debug)]
pub(crate) struct Written {
    pub(crate) rows: WrittenRows,
    /// Allocations in all updates so far.
    pub(crate) allocated: usize,
}

impl Deref for Written {
    type Target = WrittenRows;

    fn deref(&self) -> &WrittenRows {
        &self.rows
    }
}

impl Written {
    /// `J v`: the coefficients on `v̇` applied to a velocity; zero without such a block.
    pub(crate) fn rates(&self, v: &DVector<f64>) -> DVector<f64> {
        match &self.vdot {
            Some(J) => J * v,
            None => DVector::zeros(self.lower.len()),
        }
    }
}

/// A plug-in that has been bound to the robot.
pub(crate) struct Bound<'a> {
    pub(crate) probe: Probe,
    allocations: Option<&'a dyn Fn() -> usize>,
    allocated: usize,
}

impl<'a> Bench<'a> {
    pub(crate) fn name(&self) -> &str {
        self.robot.model.name()
    }

    /// What the sensor of contact `index` measures of a wrench in C axes about the contact point.
    pub(crate) fn in_sensor_axes(
        &self,
        state: &State,
        index: usize,
        wrench: &Vector6<f64>,
    ) -> Vector6<f64> {
        let spec = &self.contacts[index];
        let model = &self.robot.model;
        let mut data = Data::new(model);
        data.update_kinematics(model, state);
        // Both were accepted when the plug-in was bound.
        let (Some(frame), Ok(R_WC)) = (model.frame(&spec.frame), spec.surface.rotation()) else {
            return *wrench;
        };
        let R_EC = frame_motion(model, &data, frame).R_WF.inverse() * R_WC;
        let force = R_EC * Vector3::new(wrench[0], wrench[1], wrench[2]);
        let moment = R_EC * Vector3::new(wrench[3], wrench[4], wrench[5])
            + Vector3::from(spec.offset).cross(&force);
        Vector6::new(force.x, force.y, force.z, moment.x, moment.y, moment.z)
    }

    /// What a new plug-in declares.
    pub(crate) fn layout<P: Subject + ?Sized>(&self) -> Result<Layout, BindError> {
        Ok(self.bind::<P>(&self.robot.home)?.probe.layout().clone())
    }

    /// A new plug-in on the robot with another home posture.
    pub(crate) fn bind<P: Subject + ?Sized>(&self, home: &State) -> Result<Bound<'a>, BindError> {
        let mut robot = self.robot.clone();
        robot.home.copy_from(home);
        robot.home.v.fill(0.0);
        let plugin = load::<P>(self.form).map_err(BindError::Other)?;
        let probe = guarded("bind", || {
            Probe::new(&*plugin, &robot, self.contacts, PERIOD)
        })?;
        Ok(Bound {
            probe,
            allocations: self.allocations,
            allocated: 0,
        })
    }

    /// What a new plug-in writes for `at`, after one update for `before`: where there is a state to be made, such
    /// as the place of a touch, it is the same in all comparisons. `None` if it cannot be made.
    pub(crate) fn write<P: Subject + ?Sized>(
        &self,
        home: &State,
        before: &Inputs,
        at: &Inputs,
    ) -> Option<Written> {
        // The layout was accepted before; a plug-in that refuses now and then is none to compare.
        let mut bound = self.bind::<P>(home).ok()?;
        bound.update(before);
        Some(bound.update(at))
    }
}

impl Bound<'_> {
    /// One tick.
    pub(crate) fn update(&mut self, inputs: &Inputs) -> Written {
        self.probe.measure(inputs);
        let before = self.allocations.map(|count| count());
        guarded("update", || self.probe.update());
        if let (Some(count), Some(before)) = (self.allocations, before) {
            self.allocated += count() - before;
        }
        Written {
            rows: self.probe.written(),
            allocated: self.allocated,
        }
    }
}
