//! Makes a controller from its configuration: resolves names, declares rows, fixes sizes.

use super::{
    Controller,
    command::Command,
    error::ControllerError,
    report::{ContactReport, Report, Rung, TaskReport},
    stopwatch::{NoStopwatch, StageTimes},
    switch::Switch,
    world::{ContactBinding, World},
};
use crate::{
    actuator::ActuatorKind,
    assembly::{
        Actuation, Assembly, DynamicsTerms, Group, GroupSpec, ProblemRows, Table, VariableNames,
    },
    config::ControllerConfig,
    dynamics::{Data, FrameKinematics},
    entry::{Entry, Hardness},
    layout::{BoundTarget, Layout, Relation, VdotBlock},
    model::{Base, FrameId, JointKind, Model},
    qp::{Capacity, Qp, Solution, VarId},
    robot::RobotModel,
    rows::RowStore,
    setup::{BindError, Setup},
    tick::{FrameHandle, Prediction},
};

impl Controller {
    /// Makes a controller. This is where everything is allocated.
    ///
    /// # Errors
    /// [`ControllerError`] naming the entry and what does not fit.
    pub fn new(config: ControllerConfig) -> Result<Self, ControllerError> {
        let robot = config.robot.load(&config.directory)?;
        Self::with_robot(config, robot)
    }

    /// Makes a controller for a robot that is there already; the configuration's own is not loaded.
    ///
    /// # Errors
    /// [`ControllerError`] naming the entry and what does not fit.
    pub fn with_robot(
        config: ControllerConfig,
        robot: RobotModel,
    ) -> Result<Self, ControllerError> {
        let ControllerConfig {
            settings,
            mut solver,
            contacts,
            mut tasks,
            mut constraints,
            ..
        } = config;
        settings.validate().map_err(ControllerError::Settings)?;
        check_names(&tasks, &constraints, &contacts)?;
        let period = 1.0 / settings.rate;
        let model = robot.model.clone();

        let mut bindings = Vec::new();
        let mut contact_states = Vec::new();
        for spec in &contacts {
            let named = |source| bind_error("contact", &spec.name, "contact", source);
            let binding = ContactBinding::new(spec, &model, period).map_err(named)?;
            contact_states.push(binding.initial_state(&model));
            bindings.push(binding);
        }
        let nf: Vec<usize> = contacts
            .iter()
            .map(|c| c.kind.constrained().len())
            .collect();
        let sizes = Sizes {
            nv: model.nv(),
            nu: robot.nu(),
            nf: &nf,
        };

        // Frame 0 is always the base's, so that a handle never dangles.
        let mut frame_ids = vec![model.base_frame()];
        let actuation = Actuation::new(&model, &robot.actuators, |id| request(&mut frame_ids, id));
        let names = VariableNames {
            accelerations: acceleration_names(&model),
            efforts: robot
                .actuators
                .iter()
                .map(|a| (a.name.as_str(), effort_unit(&model, &a.kind)))
                .collect(),
            contacts: contacts
                .iter()
                .map(|c| (c.name.as_str(), c.kind.constrained()))
                .collect(),
        };
        let mut table = Table::default();
        let problem_rows = ProblemRows::new(settings.formulation, &names, &mut table);
        let mut groups = Vec::new();
        for entry in &mut tasks {
            let mut setup = Setup::new(&robot, &contacts, period, &mut frame_ids);
            let layout = entry.plugin.bind(&mut setup);
            let tag = entry.plugin.typetag_name();
            groups.push(make_group(
                "task",
                entry,
                tag,
                layout,
                &sizes,
                frame_ids.len(),
                &mut table,
            )?);
        }
        for entry in &mut constraints {
            let mut setup = Setup::new(&robot, &contacts, period, &mut frame_ids);
            let layout = entry.plugin.bind(&mut setup);
            let tag = entry.plugin.typetag_name();
            groups.push(make_group(
                "constraint",
                entry,
                tag,
                layout,
                &sizes,
                frame_ids.len(),
                &mut table,
            )?);
        }

        check_moment_limits(&contacts, &groups[tasks.len()..])?;

        let assembly = Assembly::new(
            settings.formulation,
            settings.regularisation,
            &names,
            problem_rows,
            &mut groups,
            &mut table,
        );
        let capacity = assembly.capacity(&groups, &table);
        // The hover problem below has only the efforts.
        let capacity = Capacity {
            vars: capacity.vars.max(robot.nu()),
            ..capacity
        };
        solver.bind(capacity).map_err(ControllerError::Solver)?;

        let frames = frame_ids
            .iter()
            .map(|_| FrameKinematics::new(&model))
            .collect();
        let world = World {
            period,
            time: 0.0,
            origin: None,
            state: robot.home.clone(),
            data: Data::new(&model),
            frame_ids,
            frames,
            contacts: contact_states,
            last: Prediction {
                virtual_input: nalgebra::DVector::zeros(sizes.nv),
                vdot: nalgebra::DVector::zeros(sizes.nv),
                effort: nalgebra::DVector::zeros(sizes.nu),
            },
            bindings,
            model,
        };
        let report = empty_report(&groups[..tasks.len()], &world, capacity);
        let mut controller = Self {
            settings,
            tasks: tasks.into_iter().map(|e| e.plugin).collect(),
            constraints: constraints.into_iter().map(|e| e.plugin).collect(),
            command: Command::new(&robot),
            groups,
            table,
            assembly,
            actuation,
            qp: Qp::new(capacity),
            solution: Solution::new(capacity),
            solver,
            world,
            report,
            engaged: false,
            hover_residual: nalgebra::DVector::zeros(sizes.nv),
            stopwatch: Box::new(NoStopwatch),
            robot,
        };
        controller.hover();
        Ok(controller)
    }

    /// The command before the first tick: the efforts within limits that come nearest to holding the home
    /// posture, `min ‖S u − g(q_home)‖²`.
    fn hover(&mut self) {
        let at_home = super::Measurement::home(&self.robot, self.world.contacts.len());
        self.world.measure(&at_home);
        let (nv, nu) = (self.robot.model.nv(), self.robot.nu());
        let mut s = vec![0.0; nv * nu];
        self.actuation.write(&self.world.frames, &mut s, nu);
        let gravity = self.world.data.gravity();
        self.qp.reset((0..nu).map(|i| VarId(i as u32)));
        let (h, g) = self.qp.cost_mut();
        for i in 0..nu {
            for j in 0..nu {
                h[i * nu + j] = (0..nv).map(|k| 2.0 * s[k * nu + i] * s[k * nu + j]).sum();
            }
            g[i] = (0..nv).map(|k| -2.0 * s[k * nu + i] * gravity[k]).sum();
            h[i * nu + i] += 1e-9;
        }
        let (lower, upper) = self.qp.bounds_mut();
        for (i, actuator) in self.robot.actuators.iter().enumerate() {
            lower[i] = actuator.lower;
            upper[i] = actuator.upper;
        }
        self.solver.solve(&self.qp, &mut self.solution);
        if !self.solution.status.is_usable() {
            // As near to no effort as the limits allow.
            self.solution.x[..nu].fill(0.0);
        }
        self.command.take_efforts(&self.robot, &self.solution.x);
        for k in 0..nv {
            let su: f64 = (0..nu)
                .map(|j| s[k * nu + j] * self.command.effort[j])
                .sum();
            self.hover_residual[k] = gravity[k] - su;
        }
        self.world.last.effort.copy_from_slice(&self.command.effort);
        self.solver.reset();
        self.qp.reset([]);
        self.world.origin = None;
    }

    /// The terms of the dynamics, borrowed for the assembly.
    pub(super) fn terms<'a>(world: &'a World, actuation: &'a Actuation) -> DynamicsTerms<'a> {
        DynamicsTerms {
            data: &world.data,
            frames: &world.frames,
            contacts: &world.contacts,
            actuation,
        }
    }
}

/// Sizes of the decision variables.
pub(crate) struct Sizes<'a> {
    pub(crate) nv: usize,
    pub(crate) nu: usize,
    /// Constrained components of each contact.
    pub(crate) nf: &'a [usize],
}

fn request(frames: &mut Vec<FrameId>, id: FrameId) -> FrameHandle {
    let slot = frames.iter().position(|&f| f == id).unwrap_or_else(|| {
        frames.push(id);
        frames.len() - 1
    });
    FrameHandle(slot)
}

fn check_names(
    tasks: &[Entry<dyn crate::task::Task>],
    constraints: &[Entry<dyn crate::constraint::Constraint>],
    contacts: &[crate::contact::ContactSpec],
) -> Result<(), ControllerError> {
    let entries = tasks
        .iter()
        .map(|e| e.name.as_str())
        .chain(constraints.iter().map(|e| e.name.as_str()));
    check_unique("entry", entries.collect())?;
    check_unique(
        "contact",
        contacts.iter().map(|c| c.name.as_str()).collect(),
    )
}

fn check_unique(kind: &'static str, mut names: Vec<&str>) -> Result<(), ControllerError> {
    names.sort_unstable();
    match names.windows(2).find(|w| w[0] == w[1]) {
        Some(w) => Err(ControllerError::Duplicate {
            kind,
            name: w[0].to_owned(),
        }),
        None => Ok(()),
    }
}

fn bind_error(kind: &'static str, name: &str, tag: &str, source: BindError) -> ControllerError {
    ControllerError::Bind {
        kind,
        name: name.to_owned(),
        tag: tag.to_owned(),
        source: Box::new(source),
    }
}

/// A contact with moments needs a constraint that limits them: without, the solver would pull with moments.
fn check_moment_limits(
    contacts: &[crate::contact::ContactSpec],
    constraints: &[Group],
) -> Result<(), ControllerError> {
    for (i, spec) in contacts.iter().enumerate() {
        let limits = |g: &Group| g.layout.moment_limits.iter().any(|c| c.index() == i);
        if spec.kind.has_moments() && !constraints.iter().any(limits) {
            let problem = format!(
                "constrains rotations, and no constraint limits this contact's moments: add one of type \
                 `contact_wrench` with `contact = \"{}\"` (crate wbqp-tasks), or one of your own whose layout says \
                 `limits_moments`",
                spec.name
            );
            let source = BindError::value("kind", problem);
            return Err(bind_error("contact", &spec.name, "contact", source));
        }
    }
    Ok(())
}

/// Checks the entry and its layout and registers its rows.
fn make_group<P: ?Sized>(
    kind: &'static str,
    entry: &Entry<P>,
    tag: &str,
    layout: Result<Layout, BindError>,
    sizes: &Sizes<'_>,
    frames: usize,
    table: &mut Table,
) -> Result<Group, ControllerError> {
    let refuse = |source| bind_error(kind, &entry.name, tag, source);
    let layout = layout.map_err(refuse)?;
    check_layout(&layout, sizes, frames, kind == "task").map_err(refuse)?;
    check_entry(entry, &layout, kind == "task").map_err(refuse)?;
    let spec = GroupSpec {
        name: &entry.name,
        weight: &entry.weight,
        hardness: entry.hardness,
        switch: Switch::new(entry.active, entry.transition),
        is_task: kind == "task",
    };
    let store = RowStore::new(&layout, sizes.nv, sizes.nu, sizes.nf);
    Ok(Group::new(&spec, layout, store, table))
}

fn check_entry<P: ?Sized>(
    entry: &Entry<P>,
    layout: &Layout,
    is_task: bool,
) -> Result<(), BindError> {
    let rows = layout.len();
    if let crate::entry::Weight::PerRow(weights) = &entry.weight
        && weights.len() != rows
    {
        let expected = format!("one number, or {rows}: one per row");
        return Err(BindError::length("weight", weights.len(), expected));
    }
    if let Some(w) = entry
        .weight
        .values()
        .iter()
        .find(|w| !w.is_finite() || **w < 0.0)
    {
        let problem = format!("is {w}, must be finite and not negative");
        return Err(BindError::value("weight", problem));
    }
    if !entry.transition.is_finite() || entry.transition < 0.0 {
        let problem = format!("is {} s, must be finite and not negative", entry.transition);
        return Err(BindError::value("transition", problem));
    }
    let equality = is_task || layout.relation == Relation::Equality;
    let soft = entry.hardness != Hardness::Hard;
    if matches!(entry.hardness, Hardness::Exact(_)) && equality {
        return Err(BindError::value(
            "hardness",
            "an exact penalty is for inequality rows; use `soft` with a weight",
        ));
    }
    if soft && !is_task && rows == 0 {
        return Err(BindError::value(
            "hardness",
            "bounds are always hard, and the entry has no rows that could be softened",
        ));
    }
    if soft && !equality && entry.weight.values().iter().all(|w| *w == 0.0) {
        return Err(BindError::value(
            "weight",
            "is zero: a soft inequality without price limits nothing",
        ));
    }
    if entry.transition > 0.0 && !equality && !soft {
        return Err(BindError::value(
            "transition",
            "hard inequalities and bounds cannot ramp; use `soft`, or no transition",
        ));
    }
    if let Hardness::Exact(linear) = entry.hardness
        && !(linear.is_finite() && linear > 0.0)
    {
        return Err(BindError::value(
            "hardness",
            format!("exact penalty is {linear}, must be positive"),
        ));
    }
    Ok(())
}

/// Catches a plug-in that declares what does not exist, so that nothing can go out of range in a tick.
pub(crate) fn check_layout(
    layout: &Layout,
    sizes: &Sizes<'_>,
    frames: usize,
    is_task: bool,
) -> Result<(), BindError> {
    let rows = layout.len();
    let columns = |what: &str, list: &[usize], limit: usize| {
        if list.len() != rows {
            return Err(BindError::Other(format!(
                "its layout declares {rows} rows but {} {what}",
                list.len()
            )));
        }
        match list.iter().find(|&&c| c >= limit) {
            Some(c) => Err(BindError::Other(format!(
                "its layout declares {what} {c}, beyond the last, {}",
                limit.saturating_sub(1)
            ))),
            None => Ok(()),
        }
    };
    let no_contact = || BindError::Other("its layout declares a contact of another setup".into());
    let nf = |c: crate::contact::ContactId| sizes.nf.get(c.index()).copied().ok_or_else(no_contact);
    match &layout.vdot {
        VdotBlock::Absent | VdotBlock::Dense => {}
        VdotBlock::Unit(list) => columns("acceleration columns", list, sizes.nv)?,
        VdotBlock::Frame(frame, list) => {
            if frame.0 >= frames {
                return Err(BindError::Other(
                    "its layout declares a frame of another setup".into(),
                ));
            }
            columns("frame Jacobian rows", list, 6)?;
        }
        VdotBlock::Contact(contact, list) => {
            nf(*contact)?;
            columns("contact Jacobian rows", list, 6)?;
        }
    }
    if let Some(crate::layout::Block::Unit(list)) = &layout.effort {
        columns("effort columns", list, sizes.nu)?;
    }
    for (contact, block) in &layout.forces {
        let limit = nf(*contact)?;
        if let crate::layout::Block::Unit(list) = block {
            columns("force columns", list, limit)?;
        }
    }
    for (_, target) in &layout.bounds {
        let in_range = match *target {
            BoundTarget::Effort(i) => i < sizes.nu,
            BoundTarget::Force(contact, i) => i < nf(contact)?,
        };
        if !in_range {
            return Err(BindError::Other(
                "its layout bounds a variable that does not exist".into(),
            ));
        }
    }
    if is_task && !layout.bounds.is_empty() {
        return Err(BindError::Other(
            "a task cannot bound variables; make it a constraint".into(),
        ));
    }
    for contact in layout.contact.iter().chain(&layout.moment_limits) {
        nf(*contact)?;
    }
    Ok(())
}

fn acceleration_names(model: &Model) -> Vec<(String, &'static str)> {
    let base: &[(&str, &str)] = match model.base() {
        Base::Floating => &[
            ("base x", "m/s²"),
            ("base y", "m/s²"),
            ("base z", "m/s²"),
            ("base roll", "rad/s²"),
            ("base pitch", "rad/s²"),
            ("base yaw", "rad/s²"),
        ],
        Base::Fixed => &[],
    };
    let base = base.iter().map(|(name, unit)| ((*name).to_owned(), *unit));
    let joints = model.joints().iter().map(|j| {
        let unit = match j.kind {
            JointKind::Revolute => "rad/s²",
            JointKind::Prismatic => "m/s²",
        };
        (j.name.clone(), unit)
    });
    base.chain(joints).collect()
}

fn effort_unit(model: &Model, kind: &ActuatorKind) -> &'static str {
    match kind {
        ActuatorKind::Joint(motor) => match model.joints()[motor.joint.index()].kind {
            JointKind::Revolute => "N·m",
            JointKind::Prismatic => "N",
        },
        ActuatorKind::Rotor(_) => "N",
    }
}

fn empty_report(tasks: &[Group], world: &World, capacity: Capacity) -> Report {
    let zeros = |g: &Group| vec![0.0; g.layout.len()];
    Report {
        time: 0.0,
        rung: Rung::Held,
        fault: None,
        status: crate::qp::Status::Failed,
        iterations: 0,
        objective: 0.0,
        vdot: nalgebra::DVector::zeros(world.model.nv()),
        tasks: tasks
            .iter()
            .map(|g| TaskReport {
                alpha: 0.0,
                error: zeros(g),
                residual: zeros(g),
                cost: zeros(g),
            })
            .collect(),
        contacts: world
            .contacts
            .iter()
            .map(|_| ContactReport {
                on: false,
                alpha: 0.0,
                task: None,
                solution: nalgebra::Vector6::zeros(),
                measured: nalgebra::Vector6::zeros(),
                position: nalgebra::Vector3::zeros(),
            })
            .collect(),
        active: Vec::with_capacity(2 * capacity.vars + capacity.rows),
        undeclared: None,
        regularisation: 0.0,
        times: StageTimes::default(),
    }
}
