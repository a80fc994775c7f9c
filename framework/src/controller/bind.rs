//! Makes a controller from its configuration: resolves names, declares rows, fixes sizes.

use super::{
    Command, Controller,
    bounds::Plausible,
    command::Gate,
    entry_id::Stamp,
    fallback::Fallback,
    first::FirstTick,
    fit::{Sizes, make_entry, unlimited_moments},
    home,
    hover::{hover, missing_wrench, must_hover},
    memory::{Memory, Need, Stored},
    misfits::{Misfit, Misfits},
    names::Names,
    observer::Observer,
    record::MadeFrom,
    report::Report,
    running::RunningPlugin,
    tick::NoStopwatch,
    world::World,
};
use crate::{
    contact::{ContactBinding, ContactSpec},
    error::BindError,
    plugin::{
        AnyConstraint, AnyFallbackLaw, AnyPlugin, AnyTask, BoundFallbackLaw, BoundPlugin, Entry,
        EntryState, Setup, storage::RowStore,
    },
    problem::{BoundEntry, Partition, Problem, ProblemRows, Relaxation, Table, VariableNames},
    qp::{ActiveSet, Capacity, Qp, QpSolver as _, Solution, Solver},
    settings::{MeasurementLimits, Settings},
};
use wbqp_dynamics::{
    Actuation,
    model::{FrameId, Model},
};
use wbqp_robot_model::RobotModel;

/// What a controller is made of beside its robot.
#[derive(Debug)]
pub(crate) struct Parts {
    pub(crate) settings: Settings,
    /// The robot's.
    pub(crate) tag: &'static str,
    pub(crate) solver: Box<dyn Solver>,
    pub(crate) fallback: Box<dyn AnyFallbackLaw>,
    pub(crate) measurement: MeasurementLimits,
    pub(crate) contacts: Vec<ContactSpec>,
    pub(crate) tasks: Vec<Entry<dyn AnyTask>>,
    pub(crate) constraints: Vec<Entry<dyn AnyConstraint>>,
    pub(crate) made_from: MadeFrom,
}

/// A controller that fits its robot and is not made yet: all sizes are known, and nothing of its problem is allocated.
#[derive(Debug)]
pub(crate) struct Bound {
    settings: Settings,
    robot: RobotModel,
    /// The robot's.
    tag: &'static str,
    solver: Box<dyn Solver>,
    law: BoundFallbackLaw,
    measurement: MeasurementLimits,
    contacts: Vec<ContactSpec>,
    task_count: usize,
    made_from: MadeFrom,
    misfits: Misfits,
    bindings: Vec<ContactBinding>,
    plugins: Vec<RunningPlugin>,
    sizes: Sizes,
    frame_ids: Vec<FrameId>,
    actuation: Actuation,
    table: Table,
    problem_rows: ProblemRows,
    /// Their rows have no storage yet.
    entries: Vec<BoundEntry>,
    partition: Partition,
    need: Need,
}

/// Binds entries one after another.
struct Binder<'a> {
    robot: &'a RobotModel,
    contacts: &'a [ContactSpec],
    period: f64,
    sizes: Sizes,
    frame_ids: Vec<FrameId>,
    /// The robot at home, where references begin; none if a contact is wrong.
    home: Option<World>,
    table: &'a mut Table,
    misfits: &'a mut Misfits,
    stored: Stored,
    max_memory: f64,
    entries: Vec<BoundEntry>,
    plugins: Vec<RunningPlugin>,
}

impl Binder<'_> {
    /// Binds a task or constraint; what is wrong with it is a misfit.
    ///
    /// # Errors
    /// All misfits, if the rows take too much memory.
    fn bind<P: AnyPlugin + ?Sized>(
        &mut self,
        index: usize,
        entry: &Entry<P>,
    ) -> Result<(), Vec<Misfit>> {
        match self.make(entry) {
            Ok((bound, plugin)) => {
                let checked = self.stored.add(&bound, &self.sizes, self.max_memory);
                self.misfits.memory(checked);
                self.misfits.stop_if_too_large()?;
                self.entries.push(bound);
                self.plugins.push(plugin);
            }
            Err(error) => self.misfits.entry(index, entry, error),
        }
        Ok(())
    }

    fn make<P: AnyPlugin + ?Sized>(
        &mut self,
        entry: &Entry<P>,
    ) -> Result<(BoundEntry, RunningPlugin), BindError> {
        let frames = &mut self.frame_ids;
        let mut setup = Setup::new(self.robot, self.contacts, self.period, frames);
        let BoundPlugin { layout, running } = entry.plugin.bind(&mut setup)?;
        let mut references = setup.into_references();
        if let Some(home) = &mut self.home {
            home.look_at(&self.frame_ids);
            let tick = home.tick(EntryState::ON);
            for reference in &mut references {
                reference.start_at_home(&tick);
            }
        }
        let frames = self.frame_ids.len();
        let bound = make_entry(entry, layout, &self.sizes, frames, self.table)?;
        let plugin = RunningPlugin {
            plugin: running,
            references,
            tag: entry.plugin.tag(),
        };
        Ok((bound, plugin))
    }
}

impl Bound {
    /// Binds tasks and constraints to a robot.
    ///
    /// # Errors
    /// Everything that does not fit the robot, and what takes more than [`Settings::max_memory`].
    pub(crate) fn new(parts: Parts, mut robot: RobotModel) -> Result<Self, Vec<Misfit>> {
        let Parts {
            settings,
            tag,
            mut solver,
            fallback,
            measurement,
            contacts,
            tasks,
            constraints,
            made_from,
        } = parts;
        let mut misfits = Misfits::default();
        misfits.settings(&settings, &robot.model);
        misfits.measurement(&measurement, settings.rate);
        misfits.robot(tag, robot.problems());
        // Plug-ins rely on a sound robot and a sound rate.
        misfits.stop_if_any()?;
        misfits.names(&contacts, &tasks, &constraints);
        let period = 1.0 / settings.rate;
        home::stand_on_contacts(&mut robot, &contacts);
        let model = robot.model.clone();

        let bindings = bind_contacts(&contacts, &model, period, &mut misfits);
        let actuation = Actuation::new(&model, &robot.actuators);
        let formulation = settings.formulation.resolve(&robot);
        let names = VariableNames::new(&robot, &contacts);
        let mut table = Table::default();
        let problem_rows = ProblemRows::new(formulation, &names, &mut table);
        let mut binder = Binder {
            robot: &robot,
            contacts: &contacts,
            period,
            sizes: Sizes::new(&robot, &contacts),
            // Frame 0 is always the base's, so that a handle never dangles.
            frame_ids: vec![model.base_frame()],
            // Contacts are found by their position: none may be missing.
            home: (bindings.len() == contacts.len())
                .then(|| World::at_home(&robot, period, &bindings)),
            table: &mut table,
            misfits: &mut misfits,
            stored: Stored::default(),
            max_memory: settings.max_memory,
            entries: Vec::new(),
            plugins: Vec::new(),
        };
        for (index, task) in tasks.iter().enumerate() {
            binder.bind(index, task)?;
        }
        for (index, constraint) in constraints.iter().enumerate() {
            binder.bind(index, constraint)?;
        }
        let Binder {
            mut frame_ids,
            stored,
            entries,
            plugins,
            sizes,
            ..
        } = binder;
        let law = bind_law(
            &*fallback,
            Setup::new(&robot, &contacts, period, &mut frame_ids),
        );
        let law = law.map_err(|error| misfits.fallback(fallback.typetag_name(), error));
        if misfits.is_empty() {
            for (index, error) in unlimited_moments(&contacts, &entries[tasks.len()..]) {
                misfits.contact(index, &contacts[index].name, error);
            }
        }
        if !misfits.is_empty() {
            // The problem has no size, but the solver's settings can be looked at.
            let capacity = Capacity {
                vars: robot.nu(),
                rows: 0,
            };
            let bound = solver.bind(capacity).map_err(BindError::from);
            misfits.solver(solver.typetag_name(), bound);
            misfits.stop_if_any()?;
        }
        let Ok(law) = law else {
            // A misfit, with which it has stopped above.
            return Err(Vec::new());
        };

        let partition = Partition::new(formulation, &robot, &contacts, &frame_ids);
        let need = Need::of(
            &partition,
            &entries,
            stored,
            [
                problem_rows.dynamics_rows(),
                contacts.len(),
                robot.nu(),
                frame_ids.len(),
            ],
            &*solver,
            &ActiveSet::default(),
        );
        misfits.memory(need.check(settings.max_memory));
        misfits.stop_if_too_large()?;
        Ok(Self {
            settings,
            robot,
            tag,
            solver,
            law,
            measurement,
            contacts,
            task_count: tasks.len(),
            made_from,
            misfits,
            bindings,
            plugins,
            sizes,
            frame_ids,
            actuation,
            table,
            problem_rows,
            entries,
            partition,
            need,
        })
    }

    /// What [`Bound::make`] is going to allocate, about.
    pub(crate) fn memory(&self) -> Memory {
        self.need.memory()
    }

    /// Makes the controller. This is where everything is allocated.
    ///
    /// # Errors
    /// A solver that refuses, a robot that does not hover.
    pub(crate) fn make(self) -> Result<Controller, Vec<Misfit>> {
        let Self {
            settings,
            robot,
            tag,
            mut solver,
            law,
            measurement,
            contacts,
            task_count,
            made_from,
            mut misfits,
            bindings,
            plugins,
            sizes,
            frame_ids,
            actuation,
            mut table,
            problem_rows,
            mut entries,
            partition,
            need,
        } = self;
        let model = robot.model.clone();
        let period = 1.0 / settings.rate;
        let solver_tag = solver.typetag_name();
        allocate(&mut entries, &sizes);
        let names = VariableNames::new(&robot, &contacts);
        let mut native = ActiveSet::by_reflections();
        let kept = partition.kept.iter().map(|&i| &robot.actuators[i]);
        let kept = Actuation::new(&model, kept);
        let problem = Problem::new(
            partition,
            kept,
            settings.regularisation,
            &names,
            problem_rows,
            &mut entries,
            &mut table,
        );
        debug_assert!(problem.capacity(&entries).vars <= need.problem.vars);
        let capacity = need.problem;
        misfits.solver(solver_tag, solver.bind(capacity).map_err(BindError::from));
        misfits.stop_if_any()?;

        let mut world = World::new(&robot, period, bindings, frame_ids);
        let observer = settings.observer.clone();
        world.observer = observer.map(|settings| Observer::new(settings, &robot, &world.bindings));
        let relaxation = Relaxation::new(&problem, &entries, &table, &robot.actuators, capacity);
        let relaxed = relaxation.qp.capacity();
        misfits.solver("active_set", native.bind(relaxed).map_err(BindError::from));
        let tags: Vec<&'static str> = plugins.iter().map(|plugin| plugin.tag).collect();
        let fallback = Fallback::new(law, relaxation, native, &*solver, sizes.nu);
        let first = FirstTick::new(
            settings.max_first_error,
            &entries[..task_count],
            &world.model,
        );
        let report = Report::new(
            &entries[..task_count],
            &world,
            capacity,
            fallback.relaxation.limits(),
            Names::new(
                &robot,
                &world.bindings,
                &entries,
                &table,
                &tags,
                first.clone(),
            ),
        );
        let mut controller = Controller {
            settings,
            first,
            plugins,
            task_count,
            command: Command::new(&robot),
            gate: Gate::new(&robot),
            plausible: Plausible::new(&measurement, &robot, &contacts, period),
            entries,
            table,
            problem,
            actuation,
            qp: Qp::new(capacity),
            solution: Solution::new(capacity),
            solver,
            world,
            report,
            fallback,
            made_from,
            recorder: None,
            hover_residual: nalgebra::DVector::zeros(sizes.nv),
            stopwatch: Box::new(NoStopwatch),
            stamp: Stamp::next(),
            before: None,
            revision: 0,
            robot,
        };
        let is_solved = hover(&mut controller);
        controller
            .problem
            .choose_determined(&controller.world.contacts);
        let hover = &controller.command.effort;
        controller.fallback.hover.copy_from_slice(hover);
        if is_solved
            && must_hover(&controller)
            && let Some(missing) = missing_wrench(&controller)
        {
            misfits.hover(tag, missing);
        }
        misfits.stop_if_any()?;
        Ok(controller)
    }
}

fn bind_contacts(
    contacts: &[ContactSpec],
    model: &Model,
    period: f64,
    misfits: &mut Misfits,
) -> Vec<ContactBinding> {
    let mut bindings = Vec::new();
    for (index, spec) in contacts.iter().enumerate() {
        match ContactBinding::new(spec, model, period) {
            Ok(binding) => bindings.push(binding),
            Err(error) => misfits.contact(index, &spec.name, error),
        }
    }
    bindings
}

fn bind_law(law: &dyn AnyFallbackLaw, mut setup: Setup<'_>) -> Result<BoundFallbackLaw, BindError> {
    let law = law.bind_any(&mut setup)?;
    if setup.into_references().is_empty() {
        Ok(law)
    } else {
        Err(BindError::Other("a law follows no reference".to_owned()))
    }
}

/// Makes the storage of their rows.
fn allocate(entries: &mut [BoundEntry], sizes: &Sizes) {
    for entry in entries {
        let store = RowStore::new(&entry.layout, sizes.nv, sizes.nu, &sizes.nf);
        entry.store = if entry.is_equality() {
            store
        } else {
            store.without_limits()
        };
    }
}
