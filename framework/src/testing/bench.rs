//! Makes plug-ins and lets them write their rows for chosen inputs.

use std::{
    any::Any,
    panic::{AssertUnwindSafe, catch_unwind, resume_unwind},
};

use nalgebra::{DMatrix, DVector, Vector3, Vector6};
use toml::Table;

use super::{
    Check,
    report::Report,
    scatter::Scatter,
    subject::{Subject, load},
};
use crate::{
    contact::{ContactId, ContactSpec},
    controller::{
        Measurement,
        fit::{Sizes, check_layout},
        world::{ContactBinding, World},
    },
    dynamics::{Data, FrameKinematics, frame_motion},
    error::BindError,
    plugin::{
        EntryState, Layout, Prediction, Setup,
        layout::{Block, VdotBlock},
        rows::RowStore,
    },
    robot::RobotModel,
    state::State,
};

/// Control period of the tests, s.
const PERIOD: f64 = 0.004;

/// Time of all updates, s. Always the same, so that trajectories drop out of differences.
const TIME: f64 = 0.3;

/// What is in a row's place before the plug-in writes it: a NaN that no computation gives.
const UNWRITTEN: u64 = 0x7ff8_0bad_0bad_0bad;

/// Whether the plug-in has left the place alone.
pub(super) fn is_unwritten(x: f64) -> bool {
    x.to_bits() == UNWRITTEN
}

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
pub(super) fn report_panics(
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
pub(super) struct Bench<'a> {
    pub(super) form: &'a Table,
    pub(super) robot: &'a RobotModel,
    pub(super) contacts: &'a [ContactSpec],
    pub(super) allocations: Option<&'a dyn Fn() -> usize>,
}

/// Everything that can change from tick to tick.
#[derive(Clone, Debug)]
pub(super) struct Inputs {
    pub(super) state: State,
    /// As sent after the last solution, within the actuators' limits, N or N·m, size nu.
    pub(super) effort: DVector<f64>,
    /// Of the last solution, size nv.
    pub(super) vdot: DVector<f64>,
    /// Measured, in the axes of the frame that touches, one per contact.
    pub(super) wrenches: Vec<Vector6<f64>>,
    /// Of the last solution, C axes, one per contact; zero in the free directions.
    pub(super) forces: Vec<Vector6<f64>>,
}

impl Inputs {
    pub(super) fn random(bench: &Bench<'_>, scatter: &mut Scatter) -> Self {
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
        Self {
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
        }
    }

    /// The same with another velocity.
    pub(super) fn moving(&self, v: &DVector<f64>) -> Self {
        let mut moved = self.clone();
        moved.state.v.copy_from(v);
        moved
    }

    /// The same with the configuration moved on along a velocity for a time; the inputs' own velocity stays.
    pub(super) fn displaced(&self, bench: &Bench<'_>, v: &DVector<f64>, time: f64) -> Self {
        let mut moved = self.clone();
        moved.state.advance(&bench.robot.model, v, time);
        moved
    }

    /// The same at rest.
    pub(super) fn at_rest(&self) -> Self {
        self.moving(&DVector::zeros(self.state.v.len()))
    }
}

/// What a plug-in wrote, with borrowed and unit blocks written out.
#[derive(Clone, Debug)]
pub(super) struct Written {
    /// Coefficients on `v̇`, rows × nv.
    pub(super) vdot: Option<DMatrix<f64>>,
    /// Coefficients on `u`, rows × nu.
    pub(super) effort: Option<DMatrix<f64>>,
    /// Coefficients on the constrained components of contacts' forces.
    pub(super) forces: Vec<(ContactId, DMatrix<f64>)>,
    /// `b`, or the lower limits.
    pub(super) lower: DVector<f64>,
    pub(super) upper: DVector<f64>,
    pub(super) error: DVector<f64>,
    pub(super) bound_lower: Vec<f64>,
    pub(super) bound_upper: Vec<f64>,
    /// A block was written that is not declared.
    pub(super) undeclared: bool,
    /// Allocations in all updates so far.
    pub(super) allocated: usize,
}

impl Written {
    /// `J v`: the coefficients on `v̇` applied to a velocity; zero without such a block.
    pub(super) fn rates(&self, v: &DVector<f64>) -> DVector<f64> {
        match &self.vdot {
            Some(J) => J * v,
            None => DVector::zeros(self.lower.len()),
        }
    }
}

/// A plug-in that has been bound to the robot.
pub(super) struct Bound<'a, P: ?Sized> {
    pub(super) plugin: Box<P>,
    pub(super) layout: Layout,
    store: RowStore,
    world: World,
    allocations: Option<&'a dyn Fn() -> usize>,
    allocated: usize,
}

impl<'a> Bench<'a> {
    pub(super) fn name(&self) -> &str {
        self.robot.model.name()
    }

    /// What the sensor of contact `index` measures of a wrench in C axes about the contact point.
    pub(super) fn in_sensor_axes(
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
    pub(super) fn layout<P: Subject + ?Sized>(&self) -> Result<Layout, BindError> {
        Ok(self.bind::<P>(&self.robot.home)?.layout)
    }

    /// A new plug-in on the robot with another home posture.
    pub(super) fn bind<P: Subject + ?Sized>(
        &self,
        home: &State,
    ) -> Result<Bound<'a, P>, BindError> {
        let mut robot = self.robot.clone();
        robot.home.copy_from(home);
        robot.home.v.fill(0.0);
        let model = robot.model.clone();
        let mut plugin = load::<P>(self.form).map_err(BindError::Other)?;
        let mut frame_ids = vec![model.base_frame()];
        let mut setup = Setup::new(&robot, self.contacts, PERIOD, &mut frame_ids);
        let layout = guarded("bind", || plugin.bind(&mut setup))?;
        let nf: Vec<usize> = self
            .contacts
            .iter()
            .map(|c| c.kind.constrained().len())
            .collect();
        let sizes = Sizes {
            nv: model.nv(),
            nu: robot.nu(),
            nf: &nf,
        };
        check_layout(&layout, &sizes, frame_ids.len(), P::IS_TASK)?;

        let mut bindings = Vec::new();
        let mut contacts = Vec::new();
        for spec in self.contacts {
            let spec = ContactSpec {
                active: true,
                ..spec.clone()
            };
            let binding = ContactBinding::new(&spec, &model, PERIOD)?;
            contacts.push(binding.initial_state(&model));
            bindings.push(binding);
        }
        let mut store = RowStore::new(&layout, model.nv(), robot.nu(), &nf);
        let unwritten = f64::from_bits(UNWRITTEN);
        for place in [
            &mut store.lower,
            &mut store.error,
            &mut store.bound_lower,
            &mut store.bound_upper,
        ] {
            place.fill(unwritten);
        }
        let world = World {
            period: PERIOD,
            elapsed: PERIOD,
            slew_time: PERIOD,
            time: 0.0,
            origin: Some(0.0),
            state: robot.home.clone(),
            data: Data::new(&model),
            frames: frame_ids
                .iter()
                .map(|_| FrameKinematics::new(&model))
                .collect(),
            frame_ids,
            contacts,
            last: Prediction {
                virtual_input: DVector::zeros(model.nv()),
                vdot: DVector::zeros(model.nv()),
                effort: DVector::zeros(robot.nu()),
            },
            bindings,
            model,
        };
        Ok(Bound {
            plugin,
            layout,
            store,
            world,
            allocations: self.allocations,
            allocated: 0,
        })
    }

    /// What a new plug-in writes for `at`, after one update for `before`: where there is a state to be made, such
    /// as the place of a touch, it is the same in all comparisons. `None` if it cannot be made.
    pub(super) fn write<P: Subject + ?Sized>(
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

impl<P: Subject + ?Sized> Bound<'_, P> {
    /// One tick.
    pub(super) fn update(&mut self, inputs: &Inputs) -> Written {
        self.world.measure(&Measurement {
            time: TIME,
            state: inputs.state.clone(),
            wrenches: inputs.wrenches.clone(),
        });
        for (contact, force) in self.world.contacts.iter_mut().zip(&inputs.forces) {
            contact.solution = *force;
        }
        self.world.last.effort.copy_from(&inputs.effort);
        self.world.last.vdot.copy_from(&inputs.vdot);
        let tick = self.world.tick(EntryState {
            alpha: 1.0,
            since: 0.0,
        });
        let before = self.allocations.map(|count| count());
        let (plugin, layout, store) = (&mut self.plugin, &self.layout, &mut self.store);
        guarded("update", || plugin.update(&tick, layout, store));
        if let (Some(count), Some(before)) = (self.allocations, before) {
            self.allocated += count() - before;
        }
        self.written()
    }

    fn written(&self) -> Written {
        let (layout, store) = (&self.layout, &self.store);
        let m = layout.len();
        let dense = |n: usize, data: &[f64]| DMatrix::from_row_slice(m, n, data);
        let block = |n: usize, block: &Block, data: &[f64]| match block {
            Block::Dense => dense(n, data),
            Block::Unit(columns) => unit(m, n, columns),
        };
        let nv = self.world.model.nv();
        let picked = |jacobian: &nalgebra::Matrix6xX<f64>, rows: &[usize]| {
            DMatrix::from_fn(m, nv, |k, j| jacobian[(rows[k], j)])
        };
        Written {
            vdot: match &layout.vdot {
                VdotBlock::Absent => None,
                VdotBlock::Dense => Some(dense(nv, &store.vdot)),
                VdotBlock::Unit(columns) => Some(unit(m, nv, columns)),
                VdotBlock::Frame(frame, rows) => Some(picked(&self.world.frames[frame.0].J, rows)),
                VdotBlock::Contact(c, rows) => {
                    Some(picked(&self.world.contacts[c.index()].J, rows))
                }
            },
            effort: layout
                .effort
                .as_ref()
                .map(|b| block(self.world.last.effort.len(), b, &store.effort)),
            forces: layout
                .forces
                .iter()
                .zip(&store.forces)
                .map(|((c, b), data)| {
                    let n = self.world.contacts[c.index()].kind.constrained().len();
                    (*c, block(n, b, data))
                })
                .collect(),
            lower: DVector::from_column_slice(&store.lower),
            upper: DVector::from_column_slice(&store.upper),
            error: DVector::from_column_slice(&store.error),
            bound_lower: store.bound_lower.clone(),
            bound_upper: store.bound_upper.clone(),
            undeclared: store.undeclared,
            allocated: self.allocated,
        }
    }
}

fn unit(m: usize, n: usize, columns: &[usize]) -> DMatrix<f64> {
    DMatrix::from_fn(m, n, |k, j| if columns[k] == j { 1.0 } else { 0.0 })
}
