//! One task or constraint by itself: what it writes for any inputs. For tests of plug-ins, and for looking at rows.

use nalgebra::{DMatrix, DVector, Vector6};

use super::{
    Measurement,
    fit::{Sizes, check_layout},
    report::FallbackLevel,
    running::RunningPlugin,
    world::World,
};
use crate::{
    contact::{ContactBinding, ContactId, ContactSpec},
    error::BindError,
    plugin::{
        AnyPlugin, BoundPlugin, EntryState, Layout, Setup,
        storage::{RowStore, Variable},
    },
};
use wbqp_dynamics::state::State;
use wbqp_robot_model::RobotModel;

/// What is in a row's place before the plug-in writes it: a NaN that no computation gives.
const UNWRITTEN: u64 = 0x7ff8_0bad_0bad_0bad;

/// Of the plug-in's entry.
const ON: EntryState = EntryState {
    alpha: 1.0,
    since: 0.0,
};

/// A task or constraint that is bound to a robot and belongs to no controller. All contacts are on, and so is its
/// entry.
#[doc(hidden)] // named by the crate `wbqp-testing` alone
#[derive(Debug)]
pub struct Probe {
    running: RunningPlugin,
    layout: Layout,
    store: RowStore,
    world: World,
}

/// Everything that can change from tick to tick.
#[doc(hidden)] // named by the crate `wbqp-testing` alone
#[derive(Clone, Debug)]
pub struct ProbeInputs {
    /// Time since the first tick, s.
    pub time: f64,
    /// Measured state.
    pub state: State,
    /// As sent after the last solution, N or N·m, size nu.
    pub effort: DVector<f64>,
    /// Of the last solution, size nv.
    pub vdot: DVector<f64>,
    /// Measured, in the axes of the frame that touches, one per contact.
    pub wrenches: Vec<Vector6<f64>>,
    /// Of the last solution, C axes, one per contact; zero in the free directions.
    pub forces: Vec<Vector6<f64>>,
}

/// What a plug-in wrote, with borrowed and unit blocks written out.
#[doc(hidden)] // named by the crate `wbqp-testing` alone
#[derive(Clone, Debug)]
pub struct WrittenRows {
    /// Coefficients on `v̇`, rows × nv.
    pub vdot: Option<DMatrix<f64>>,
    /// Coefficients on `u`, rows × nu.
    pub effort: Option<DMatrix<f64>>,
    /// Coefficients on the constrained components of contacts' forces, rows × nf each.
    pub forces: Vec<(ContactId, DMatrix<f64>)>,
    /// `b`, or the lower limits, size rows.
    pub lower: DVector<f64>,
    /// The upper limits, size rows.
    pub upper: DVector<f64>,
    /// The error, size rows.
    pub error: DVector<f64>,
    /// Lower limits of the bounds.
    pub bound_lower: Vec<f64>,
    /// Upper limits of the bounds.
    pub bound_upper: Vec<f64>,
    /// Whether a block was written that is not declared.
    pub undeclared: bool,
}

impl WrittenRows {
    /// Whether a number is what stands in a row before the plug-in writes it.
    pub fn is_unwritten(x: f64) -> bool {
        x.to_bits() == UNWRITTEN
    }
}

impl Probe {
    /// Binds the plug-in, a `dyn AnyTask` or `dyn AnyConstraint`, to a robot with contacts, all of them on, at a
    /// control period in s.
    ///
    /// # Errors
    /// [`BindError`]: what the plug-in refuses, or what does not fit in its layout.
    pub fn new<P: AnyPlugin + ?Sized>(
        plugin: &P,
        robot: &RobotModel,
        contacts: &[ContactSpec],
        period: f64,
    ) -> Result<Self, BindError> {
        let model = robot.model.clone();
        let mut frame_ids = vec![model.base_frame()];
        let mut setup = Setup::new(robot, contacts, period, &mut frame_ids);
        let BoundPlugin { layout, running } = plugin.bind(&mut setup)?;
        let mut references = setup.into_references();
        let sizes = Sizes::new(robot, contacts);
        check_layout(&layout, &sizes, frame_ids.len())?;

        let mut bindings = Vec::new();
        for spec in contacts {
            let spec = ContactSpec {
                active: true,
                ..spec.clone()
            };
            bindings.push(ContactBinding::new(&spec, &model, period)?);
        }
        let mut store = RowStore::new(&layout, sizes.nv, sizes.nu, &sizes.nf);
        let unwritten = f64::from_bits(UNWRITTEN);
        for place in [
            &mut store.lower,
            &mut store.error,
            &mut store.bound_lower,
            &mut store.bound_upper,
        ] {
            place.fill(unwritten);
        }
        let mut home = World::at_home(robot, period, &bindings);
        home.look_at(&frame_ids);
        for reference in &mut references {
            reference.start_at_home(&home.tick(ON));
        }
        let mut world = World::new(robot, period, bindings, frame_ids);
        world.origin = Some(0.0);
        Ok(Self {
            running: RunningPlugin {
                plugin: running,
                references,
                tag: plugin.tag(),
            },
            layout,
            store,
            world,
        })
    }

    /// What it declares.
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    /// Takes the inputs of a tick: kinematics, dynamics and contacts are computed. Panics if they are of another robot.
    pub fn measure(&mut self, inputs: &ProbeInputs) {
        let measurement = Measurement {
            time: inputs.time,
            state: inputs.state.clone(),
            wrenches: inputs.wrenches.clone(),
        };
        self.world.measure(&measurement, FallbackLevel::Safe);
        for (contact, force) in self.world.contacts.iter_mut().zip(&inputs.forces) {
            contact.solution = *force;
        }
        self.world.last.effort.copy_from(&inputs.effort);
        self.world.last.vdot.copy_from(&inputs.vdot);
    }

    /// Lets the plug-in write its rows; allocates only if the plug-in does.
    pub fn update(&mut self) {
        let Self {
            running,
            layout,
            store,
            world,
            ..
        } = self;
        running.update(world, ON, layout, store);
    }

    /// What it wrote in the last update.
    pub fn written(&self) -> WrittenRows {
        let (layout, store) = (&self.layout, &self.store);
        let m = layout.len();
        let zeros = |n: usize| DMatrix::zeros(m, n);
        let mut vdot = zeros(self.world.model.nv());
        let mut effort = zeros(self.world.last.effort.len());
        let on_contact = |contact: ContactId| {
            let kind = self.world.contacts[contact.index()].kind;
            (contact, zeros(kind.constrained().len()))
        };
        let mut forces: Vec<_> = layout.forces.iter().map(|(c, _)| on_contact(*c)).collect();
        let World {
            frames, contacts, ..
        } = &self.world;
        for k in 0..m {
            store.for_each_coefficient(layout, k, frames, contacts, |variable, a| match variable {
                Variable::Acceleration(i) => vdot[(k, i)] += a,
                Variable::Effort(i) => effort[(k, i)] += a,
                Variable::Force(contact, i) => {
                    if let Some((_, block)) = forces.iter_mut().find(|(c, _)| *c == contact) {
                        block[(k, i)] += a;
                    }
                }
            });
        }
        WrittenRows {
            vdot: layout.acts_on_accelerations().then_some(vdot),
            effort: layout.effort.is_some().then_some(effort),
            forces,
            lower: DVector::from_column_slice(&store.lower),
            upper: DVector::from_column_slice(&store.upper),
            error: DVector::from_column_slice(&store.error),
            bound_lower: store.bound_lower.clone(),
            bound_upper: store.bound_upper.clone(),
            undeclared: store.undeclared,
        }
    }
}
