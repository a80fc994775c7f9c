//! Derivatives of a tick's optimum against the same tick computed again with other numbers.

use std::collections::BTreeMap;

use wbqp::{
    Controller, ControllerConfig, Measurement,
    controller::{FallbackLevel, Parameter, ParameterKind, Report, RequestError, Sensitivity},
    nalgebra::{DVector, Quaternion, Vector6},
    plugin::{Entry, PerRow, RotationSample, VectorSample},
    prelude::*,
    settings::Formulation,
    toml,
};
use wbqp_tests::{
    files::workspace,
    scenes::{KINDS, Kind, Scene, observer},
};

/// Is always where it is said to be, with rate and acceleration; of rotations the first four numbers are a quaternion.
#[wbqp::reference("test.sample")]
struct Fixed {
    value: Vec<f64>,
    rate: Vec<f64>,
    acceleration: Vec<f64>,
}

impl Fixed {
    fn at(sample: &Sample) -> Self {
        match sample {
            Sample::Vector(s) => Self {
                value: s.value.clone(),
                rate: s.rate.clone(),
                acceleration: s.acceleration.clone(),
            },
            Sample::Rotation(s) => Self {
                value: vec![s.rotation.w, s.rotation.i, s.rotation.j, s.rotation.k],
                rate: s.rate.as_slice().to_vec(),
                acceleration: s.acceleration.as_slice().to_vec(),
            },
        }
    }
}

impl Reference for Fixed {
    type Running = ();

    fn bind(&self, _: Space) -> Result<(), BindError> {
        Ok(())
    }

    fn start(&self, (): &mut (), _: f64, _: &Sample) {}

    fn sample(&self, (): &mut (), _: &Tick<'_>, out: &mut Sample) {
        match out {
            Sample::Vector(out) => {
                *out = VectorSample {
                    value: self.value.clone(),
                    rate: self.rate.clone(),
                    acceleration: self.acceleration.clone(),
                };
            }
            Sample::Rotation(out) => {
                let [w, x, y, z] = [0, 1, 2, 3].map(|i| self.value[i]);
                *out = RotationSample {
                    rotation: UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z)),
                    rate: Vector3::from_column_slice(&self.rate),
                    acceleration: Vector3::from_column_slice(&self.acceleration),
                };
            }
        }
    }
}

const FORMULATIONS: [Formulation; 3] = [
    Formulation::Condensed,
    Formulation::TorqueEliminated,
    Formulation::Explicit,
];

/// What is run: a controller, and what it measures from tick to tick.
struct Case {
    name: String,
    make: Box<dyn Fn() -> Controller>,
    /// The same in the explicit formulation, whose rounding is smallest: for central differences.
    explicit: Box<dyn Fn() -> Controller>,
    measurements: Vec<Measurement>,
}

impl Case {
    fn new(
        name: impl Into<String>,
        make: impl Fn(Formulation) -> Controller + Clone + 'static,
        formulation: Formulation,
        ticks: usize,
        prepare: impl Fn(&mut Measurement, f64),
    ) -> Self {
        let controller = make(formulation);
        let period = 1.0 / controller.settings().rate;
        let measurement = |tick: usize| {
            let mut m = controller.measurement();
            m.time = tick as f64 * period;
            let time = m.time;
            prepare(&mut m, time);
            shake(&mut m);
            m
        };
        Self {
            name: name.into(),
            measurements: (0..ticks).map(measurement).collect(),
            explicit: Box::new({
                let make = make.clone();
                move || make(Formulation::Explicit)
            }),
            make: Box::new(move || make(formulation)),
        }
    }

    /// The last tick's controller, with something done before that tick, and its measurement.
    fn run(&self, change: impl FnOnce(&mut Controller, &mut Measurement)) -> Controller {
        let mut controller = (self.explicit)();
        self.before_last(&mut controller);
        let mut last = self.measurements[self.measurements.len() - 1].clone();
        change(&mut controller, &mut last);
        controller.tick(&last);
        controller
    }

    fn before_last(&self, controller: &mut Controller) {
        let last = self.measurements.len() - 1;
        for measurement in &self.measurements[..last] {
            controller.tick(measurement);
        }
    }

    fn differentiated(&self) -> (Controller, Sensitivity) {
        let mut controller = (self.make)();
        let mut sensitivity = Sensitivity::new(&mut controller);
        self.before_last(&mut controller);
        controller.tick(&self.measurements[self.measurements.len() - 1]);
        let level = controller.report().level;
        assert_eq!(level, FallbackLevel::Optimal, "{}", self.name);
        controller
            .sensitivity(&mut sensitivity)
            .unwrap_or_else(|e| panic!("{}: {e}", self.name));
        (controller, sensitivity)
    }
}

/// Away from rest, the same in each tick of the same time.
fn shake(m: &mut Measurement) {
    let wave = |i: usize, size: f64| size * (3.0 * m.time + 1.7 * i as f64 + 0.3).sin();
    let (turn, q, v): (Vector3<f64>, Vec<f64>, Vec<f64>) = (
        Vector3::from_fn(|i, _| wave(i, 0.02)),
        (0..m.state.q.len()).map(|i| wave(i + 3, 0.01)).collect(),
        (0..m.state.v.len()).map(|i| wave(i + 5, 0.03)).collect(),
    );
    let position = Vector3::from_fn(|i, _| wave(i + 9, 0.005));
    let wrench = |c: usize| Vector6::from_fn(|i, _| wave(i + 2 * c, 0.3));
    let wrenches: Vec<_> = (0..m.wrenches.len()).map(wrench).collect();
    m.state.p_WR += position;
    m.state.R_WR = UnitQuaternion::from_scaled_axis(turn) * m.state.R_WR;
    m.state.q += DVector::from_vec(q);
    m.state.v += DVector::from_vec(v);
    for (wrench, more) in m.wrenches.iter_mut().zip(wrenches) {
        *wrench += more;
    }
}

/// Accelerations, efforts and forces of a tick, and which limits are active.
fn outcome(controller: &Controller) -> (Vec<f64>, Vec<String>) {
    let report: &Report = controller.report();
    assert_eq!(report.level, FallbackLevel::Optimal);
    let mut all: Vec<f64> = report.vdot.iter().copied().collect();
    all.extend(&controller.command().effort);
    for name in controller.contact_names() {
        let contact = controller.contact_state(controller.contact(name).expect("exists"));
        let components = contact.kind.constrained();
        all.extend(components.iter().map(|&i| contact.solution[i]));
    }
    all.extend(report.tasks.iter().flat_map(|task| &task.error));
    let pushes = report.active.iter().filter(|row| row.multiplier != 0.0);
    let mut active: Vec<_> = pushes
        .map(|row| format!("{:?} {:?}", row.row, row.side))
        .collect();
    active.sort();
    (all, active)
}

/// Moves a parameter before the last tick; false if that cannot be asked for.
fn perturb(
    parameter: &Parameter,
    index: usize,
    by: f64,
    c: &mut Controller,
    m: &mut Measurement,
) -> bool {
    let label = parameter.label.as_str();
    let inside = |label: &str| {
        let (name, rest) = label.split_once('[')?;
        Some((name.to_owned(), rest.trim_end_matches(']').to_owned()))
    };
    match parameter.kind {
        ParameterKind::Weight => {
            let mut weights = c.weight(&parameter.owner).expect("exists").to_vec();
            weights[index] += by;
            c.reweight(&parameter.owner, PerRow::Each(weights)).is_ok()
        }
        ParameterKind::Gain => {
            let mut table = c.parameters(&parameter.owner).expect("can be written");
            table.retain(|key, value| key != "type" && value.get("type").is_none());
            let (key, element) = match inside(label) {
                Some((key, element)) => (key, Some(element)),
                None => (label.to_owned(), None),
            };
            let Some(value) = table.get_mut(&key) else {
                return false;
            };
            let value = match element {
                Some(element) => &mut value[element.parse::<usize>().expect("an index")],
                None => value,
            };
            *value = toml::Value::Float(value.as_float().expect("a number") + by);
            c.set(&parameter.owner, table).is_ok()
        }
        ParameterKind::Reference => {
            let mut sample = c.followed(&parameter.owner).expect("follows").clone();
            let (part, _) = inside(label).expect("has a component");
            match (&mut sample, part.as_str()) {
                (Sample::Vector(s), "value") => s.value[index] += by,
                (Sample::Vector(s), "rate") => s.rate[index] += by,
                (Sample::Vector(s), "acceleration") => s.acceleration[index] += by,
                (Sample::Rotation(s), "value") => {
                    let turn = UnitQuaternion::from_scaled_axis(Vector3::ith(index, by));
                    s.rotation = turn * s.rotation;
                }
                (Sample::Rotation(s), "rate") => s.rate[index] += by,
                (Sample::Rotation(s), "acceleration") => s.acceleration[index] += by,
                _ => return false,
            }
            c.follow(&parameter.owner, Fixed::at(&sample)).is_ok()
        }
        ParameterKind::State => {
            let base = m.state.v.len() - m.state.q.len();
            let (nq, rotation) = (m.state.q.len(), base / 2);
            match index {
                i if i < rotation => m.state.p_WR[i] += by,
                i if i < base => {
                    let turn = UnitQuaternion::from_scaled_axis(Vector3::ith(i - rotation, by));
                    m.state.R_WR = turn * m.state.R_WR;
                }
                i if i < base + nq => m.state.q[i - base] += by,
                i => m.state.v[i - base - nq] += by,
            }
            true
        }
        ParameterKind::Wrench => {
            let contact = c.contact(&parameter.owner).expect("exists");
            m.wrenches[contact.index()][index] += by;
            true
        }
        _ => false,
    }
}

/// Which number of its owner's a parameter is: of weights the row, of references the component, of state and wrenches
/// the position.
fn positions(parameters: &[Parameter]) -> Vec<usize> {
    let mut seen: BTreeMap<String, usize> = BTreeMap::new();
    let position = |p: &Parameter| {
        let part = match p.kind {
            ParameterKind::Reference => p.label.split('[').next().unwrap_or_default(),
            _ => "",
        };
        let next = seen
            .entry(format!("{:?} {} {part}", p.kind, p.owner))
            .or_default();
        *next += 1;
        *next - 1
    };
    parameters.iter().map(position).collect()
}

fn is_weight(parameter: &Parameter) -> bool {
    parameter.kind == ParameterKind::Weight
}

/// The largest difference to central differences, kind by kind and output by output, as a share of the largest
/// derivative of that block; how many parameters were compared, and how many could not be.
fn compare(case: &Case) -> (BTreeMap<String, f64>, [usize; 2]) {
    let (controller, sensitivity) = case.differentiated();
    let (_, active) = outcome(&case.run(|_, _| ()));
    assert!(
        sensitivity.mismatch() < 1e-6,
        "{}: {}",
        case.name,
        sensitivity.mismatch()
    );
    let [nv, nu] = [
        controller.report().vdot.len(),
        controller.command().effort.len(),
    ];
    let mut blocks: BTreeMap<String, [f64; 2]> = BTreeMap::new();
    let parameters = sensitivity.parameters();
    let positions = positions(parameters);
    let mut groups: Vec<Vec<usize>> = Vec::new();
    let tied: Vec<&str> = controller
        .entry_names()
        .filter(|name| {
            let tie = format!("the regularisation follows the weight of `{name}` and of others");
            sensitivity.notes().contains(&tie)
        })
        .collect();
    let largest = |owner: &str| {
        let own = parameters
            .iter()
            .filter(|p| is_weight(p) && p.owner == owner);
        own.map(|p| p.value).fold(0.0, f64::max)
    };
    let mut weighed: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
    for (j, p) in parameters.iter().enumerate() {
        if is_weight(p) && p.value == largest(&p.owner) {
            // The regularisation, or a slack, follows the largest.
            let name = if tied.contains(&p.owner.as_str()) {
                ""
            } else {
                p.owner.as_str()
            };
            weighed.entry(name).or_default().push(j);
        } else {
            groups.push(vec![j]);
        }
    }
    groups.extend(weighed.into_values());
    let (mut compared, mut left) = (0, 0);
    for group in &groups {
        let first = &parameters[group[0]];
        // Of weights by their logarithm, so that large and small ones are comparable.
        let unit = |p: &Parameter| if is_weight(p) { p.value } else { 1.0 };
        let step = match first.kind {
            ParameterKind::Weight => 1e-2,
            // The optimum is almost linear in these.
            ParameterKind::Gain => 2e-2 * first.value.abs().max(0.5),
            ParameterKind::Reference => 5e-3 * first.value.abs().max(1.0),
            _ => 1e-3 * first.value.abs().max(1.0),
        };
        let at = |factor: f64| {
            let mut done = true;
            let controller = case.run(|c, m| {
                for &j in group {
                    let by = factor * step * unit(&parameters[j]);
                    done &= perturb(&parameters[j], positions[j], by, c, m);
                }
            });
            done.then(|| outcome(&controller))
                .filter(|(_, other)| *other == active)
                .map(|(x, _)| x)
        };
        let points = [-2.0, -1.0, 1.0, 2.0].map(at);
        let [Some(a), Some(b), Some(c), Some(d)] = points else {
            left += group.len();
            println!("    {first}: other limits, or refused");
            continue;
        };
        compared += group.len();
        for i in 0..a.len() {
            let slope = (a[i] - d[i] + 8.0 * (c[i] - b[i])) / (12.0 * step);
            let outputs = sensitivity.outputs().len();
            let derivative = |j: usize| match i.checked_sub(outputs) {
                Some(error) => sensitivity.errors()[(error, j)],
                None => sensitivity.derivatives()[(i, j)],
            };
            let each = group.iter().map(|&j| unit(&parameters[j]) * derivative(j));
            let found: f64 = each.sum();
            let output = match i {
                i if i < nv => "v̇",
                i if i < nv + nu => "u",
                i if i < outputs => "f",
                _ => "e",
            };
            let block = blocks
                .entry(format!("{} {output}", first.kind.as_str()))
                .or_default();
            block[0] = block[0].max((slope - found).abs());
            block[1] = block[1].max(slope.abs());
        }
    }
    // What does not move is compared as it is.
    let share = |[error, size]: [f64; 2]| error / size.max(1e-3);
    let shares: BTreeMap<String, f64> = blocks.into_iter().map(|(k, b)| (k, share(b))).collect();
    println!(
        "{}: {compared} parameters, {left} left out, {} limits push, mismatch {:.1e}, {} notes",
        case.name,
        active.len(),
        sensitivity.mismatch(),
        sensitivity.notes().len()
    );
    for (block, share) in &shares {
        println!("    {block}: {share:.1e}");
    }
    (shares, [compared, left])
}

/// A controller of the examples.
fn example(name: &str, formulation: Formulation, replace: Replace) -> Controller {
    let path = workspace("examples/scenarios").join(name);
    let mut text = std::fs::read_to_string(&path).expect("an example");
    for (old, new) in replace {
        assert!(text.contains(old), "{name} has no `{old}`");
        text = text.replace(old, new);
    }
    text = text.replace("formulation = \"condensed\"\n", "");
    let directory = path.parent().expect("a file");
    let mut config = ControllerConfig::from_str(&text, name, directory).expect("is valid");
    config.settings.formulation = formulation;
    Controller::new(config).expect("fits")
}

type Replace = &'static [(&'static str, &'static str)];

const HIGHER: (&str, &str) = ("[-0.5, 0.0, 1.258]", "[-0.5, 0.0, 2.4]");
const FROM_ANYWHERE: (&str, &str) = (
    "rate = 250.0",
    "rate = 250.0\nmax_first_error = { position = 10.0, rotation = 3.0 }",
);
const AT_ONCE: (&str, &str) = ("transition = 1.0", "transition = 0.0");

fn push(formulation: Formulation, replace: Replace) -> Case {
    let make = move |formulation| {
        let name = "push_with_disturbance.controller.toml";
        let mut controller = example(name, formulation, replace);
        controller.activate_contact("tip").expect("exists");
        controller
    };
    let name = format!("OTHex, {formulation:?}");
    Case::new(name, make, formulation, 6, move |m, _| {
        m.state.p_WR = Vector3::new(-0.5, 0.0, 1.258);
        m.state.q.copy_from_slice(&[0.0, 0.26, 0.96]);
        m.wrenches[0][0] = -4.0;
    })
}

fn stand(name: &'static str, formulation: Formulation) -> Case {
    let make = move |formulation| example(name, formulation, &[]);
    Case::new(
        format!("{name}, {formulation:?}"),
        make,
        formulation,
        5,
        |_, _| (),
    )
}

fn check(case: &Case, least: usize) {
    let (shares, [compared, _]) = compare(case);
    assert!(compared >= least, "{}: {compared} compared", case.name);
    for (block, share) in shares {
        assert!(share < 1e-6, "{}: {block}: {share:e}", case.name);
    }
}

#[test]
fn an_aerial_manipulator_that_pushes() {
    for formulation in FORMULATIONS {
        check(&push(formulation, &[AT_ONCE]), 70);
    }
}

#[test]
fn with_saturated_rotors() {
    let case = push(Formulation::Condensed, &[AT_ONCE, FROM_ANYWHERE, HIGHER]);
    let (controller, _) = case.differentiated();
    let pushing = controller.report().active.iter();
    let rotors = pushing.filter(|row| row.multiplier != 0.0).filter(|row| {
        let name = controller.row(row.row).expect("has a name");
        name.owner == "limits"
    });
    assert!(rotors.count() >= 1, "no rotor is at its limit");
    check(&case, 60);
}

#[test]
fn a_quadruped_that_stands() {
    for formulation in FORMULATIONS {
        check(&stand("quadruped_stand.controller.toml", formulation), 100);
    }
}

#[test]
fn a_humanoid_that_stands() {
    let case = stand(
        "humanoid_stand.controller.toml",
        Formulation::TorqueEliminated,
    );
    check(&case, 150);
}

#[test]
fn random_scenes_in_all_formulations() {
    for kind in KINDS {
        for formulation in FORMULATIONS {
            let mut scene = Scene::new(kind, 11, u32::MAX, 0b11);
            scene.hard_contacts = formulation != Formulation::Condensed;
            scene.soft_cones = true;
            let start = scene.measurement();
            let observed = formulation == Formulation::Condensed && kind != Kind::Quadruped;
            let make = move |formulation| {
                let mut config = scene.config();
                config.settings.formulation = formulation;
                if observed {
                    config.settings.observer = Some(observer(kind));
                }
                Controller::new(config).expect("the scene is valid")
            };
            let case = Case::new(
                format!("{kind:?}, {formulation:?}"),
                make,
                formulation,
                4,
                move |m, _| {
                    m.state.copy_from(&start.state);
                    m.wrenches.copy_from_slice(&start.wrenches);
                },
            );
            check(&case, 30);
        }
    }
}

/// Integrals, the feedback of a force, an observer, ramps: everything that a tick remembers.
fn remembering(formulation: Formulation) -> Controller {
    let mut controller = example(
        "push_with_disturbance.controller.toml",
        formulation,
        &[
            ("kp = 9.0\nkd = 10.4", "kp = 9.0\nkd = 10.4\nki = 3.0"),
            (
                "rate = 250.0",
                "rate = 250.0\nobserver = { velocity = 10.0, wrench = 1.0, max_force = 5.0, max_moment = 1.0 }",
            ),
        ],
    );
    controller.activate_contact("tip").expect("exists");
    controller
}

#[test]
fn the_next_ticks_are_the_same_to_the_bit() {
    let case = Case::new(
        "remembering",
        remembering,
        Formulation::Condensed,
        300,
        |m, _| {
            m.state.p_WR = Vector3::new(-0.5, 0.0, 1.258);
            m.state.q.copy_from_slice(&[0.0, 0.26, 0.96]);
            m.wrenches[0][0] = -4.0;
        },
    );
    let (mut asked, mut left_alone) = (
        remembering(Formulation::Condensed),
        remembering(Formulation::Condensed),
    );
    let mut sensitivity = Sensitivity::new(&mut asked);
    let bits = |c: &Controller| -> Vec<u64> {
        let (command, report) = (c.command(), c.report());
        let numbers = command.effort.iter().chain(&command.joint_velocity);
        let numbers = numbers.chain(&report.vdot).chain(&report.disturbance);
        let errors = report.tasks.iter().flat_map(|task| &task.residual);
        numbers.chain(errors).map(|x| x.to_bits()).collect()
    };
    for (tick, measurement) in case.measurements.iter().enumerate() {
        if tick == 150 {
            let hover = toml::toml! { kp = 8.0 };
            for c in [&mut asked, &mut left_alone] {
                c.set("base_position", hover.clone()).expect("fits");
            }
        }
        asked.tick(measurement);
        left_alone.tick(measurement);
        assert_eq!(bits(&asked), bits(&left_alone), "tick {tick}");
        if tick % 7 < 2 {
            asked.sensitivity(&mut sensitivity).expect("an optimum");
            let again = sensitivity.derivatives().clone();
            asked.sensitivity(&mut sensitivity).expect("an optimum");
            assert_eq!(&again, sensitivity.derivatives(), "twice is once");
        }
    }
}

#[test]
fn what_is_remembered_counts() {
    let case = Case::new(
        "remembering",
        remembering,
        Formulation::Condensed,
        20,
        |m, _| {
            m.state.p_WR = Vector3::new(-0.5, 0.0, 1.258);
            m.state.q.copy_from_slice(&[0.0, 0.26, 0.96]);
            m.wrenches[0][0] = -4.0;
        },
    );
    check(&case, 70);
}

/// A row on the first joint that is curved in the state.
#[wbqp::task("test.curved")]
struct Curved {}

impl Task for Curved {
    type Running = VelocityId;

    fn bind(&self, setup: &mut Setup<'_>) -> Result<(Layout, VelocityId), BindError> {
        let joint = setup.joint(&setup.model().joints()[0].name.clone())?;
        let rows = Layout::rows([("curved", "rad/s²")]).error_unit("rad");
        Ok((rows.vdot_dense(), setup.velocity(joint)))
    }

    fn update(&self, first: &mut VelocityId, tick: &Tick<'_>, rows: &mut Rows<'_>) {
        let (q, v) = (tick.state.q[0], tick.state.v[*first]);
        rows.vdot()[(0, first.index())] = 1.0 + 0.5 * q.sin();
        rows.bias(0, 0.5 * q.cos() * v * v);
        rows.acceleration(0, -3.0 * v * v - 20.0 * q.sin());
        rows.error()[0] = q.sin();
    }

    fn remembered(&self, _: &mut VelocityId, _: &mut Remembered<'_>) {}
}

#[test]
fn rows_that_are_curved_in_the_state_have_derivatives() {
    let start = Scene::new(Kind::Othex, 11, u32::MAX, 0).measurement();
    let make = |formulation| {
        let scene = Scene::new(Kind::Othex, 11, u32::MAX, 0);
        let mut config = scene.config();
        config.settings.formulation = formulation;
        let entry = Entry::task("curved", 0.7, Curved {});
        Controller::new(config.with_task(entry)).expect("is valid")
    };
    let prepare = |m: &mut Measurement, _| {
        m.state.copy_from(&start.state);
        m.wrenches.copy_from_slice(&start.wrenches);
    };
    let case = Case::new("curved", make, Formulation::Explicit, 4, prepare);
    check(&case, 30);
}

/// A limit on the first actuator, N or N·m.
#[wbqp::constraint("test.ceiling")]
struct Ceiling {
    most: f64,
}

impl Constraint for Ceiling {
    type Running = ();

    fn bind(&self, setup: &mut Setup<'_>) -> Result<(ConstraintLayout, ()), BindError> {
        let first = setup.actuators().map(|(id, _)| id).take(1);
        let layout = Layout::rows([("ceiling", "N")]).effort_unit(first);
        Ok((layout.limits(), ()))
    }

    fn update(&self, (): &mut (), _: &Tick<'_>, rows: &mut ConstraintRows<'_>) {
        rows.limit(0, f64::NEG_INFINITY, self.most);
    }
}

/// Remembers how often it was asked, and does not say so.
#[wbqp::task("test.counting")]
struct Counting {
    share: f64,
}

impl Task for Counting {
    type Running = u32;

    fn bind(&self, setup: &mut Setup<'_>) -> Result<(Layout, u32), BindError> {
        let first = setup.actuators().map(|(id, _)| id).take(1);
        Ok((Layout::rows([("count", "N")]).effort_unit(first), 0))
    }

    fn update(&self, count: &mut u32, _: &Tick<'_>, rows: &mut Rows<'_>) {
        *count += 1;
        rows.b()[0] = self.share * f64::from(*count);
    }
}

fn scene_with(extra: impl FnOnce(ControllerConfig) -> ControllerConfig) -> (Controller, Scene) {
    let scene = Scene::new(Kind::Othex, 11, u32::MAX, 0);
    let config = extra(scene.config());
    (Controller::new(config).expect("is valid"), scene)
}

#[test]
fn a_limit_that_is_touched_is_noted() {
    let (mut free, scene) = scene_with(|config| config);
    let effort = free.tick(&scene.measurement()).0.effort[0];
    for (room, touches, pushes) in [(1.0, false, false), (0.0, true, false), (-0.1, false, true)] {
        let (mut c, scene) = scene_with(|config| {
            let most = effort + room;
            config.with_constraint(Entry::constraint("ceiling", Ceiling { most }))
        });
        let mut sensitivity = Sensitivity::new(&mut c);
        c.tick(&scene.measurement());
        c.sensitivity(&mut sensitivity).expect("an optimum");
        let said = sensitivity.notes();
        let touching = said.iter().filter(|s| s.contains("ceiling.ceiling"));
        assert_eq!(touching.count() == 1, touches, "{room}: {said:?}");
        let column = sensitivity.column("ceiling", "most").expect("is a number");
        let slope = sensitivity.effort()[(0, column)];
        let expected = f64::from(u8::from(pushes));
        assert!((slope - expected).abs() < 1e-9, "{room}: {slope}");
        assert_eq!(sensitivity.to_string().contains("touches"), touches);
    }
}

#[test]
fn who_does_not_say_what_it_remembers_is_not_asked() {
    let (mut c, scene) = scene_with(|config| {
        config.with_task(Entry::task("counting", 1.0, Counting { share: 0.01 }))
    });
    let mut sensitivity = Sensitivity::new(&mut c);
    let mut measurement = scene.measurement();
    for tick in 1..5 {
        measurement.time = 0.004 * f64::from(tick);
        c.tick(&measurement);
        c.sensitivity(&mut sensitivity).expect("an optimum");
        let notes = sensitivity.notes();
        let is_said = notes
            .iter()
            .any(|note| note.starts_with("`counting` does not say"));
        assert!(is_said, "{notes:?}");
    }
    assert_eq!(sensitivity.column("counting", "share"), None);
    assert!(sensitivity.column("counting", "weight").is_some());
    // The fifth update asks for five hundredths.
    measurement.time = 0.004 * 5.0;
    let report = c.tick(&measurement).1.clone();
    let residual = report.task("counting").expect("exists").residual[0];
    let effort = c.command().effort[0];
    assert!((effort - 0.05 - residual).abs() < 1e-9);
}

#[test]
fn weights_are_ranked_by_what_they_do() {
    let (controller, sensitivity) = push(Formulation::Condensed, &[AT_ONCE]).differentiated();
    let mut ranking = sensitivity.effects();
    ranking.retain(|effect| effect.kind == ParameterKind::Weight);
    let weighted = controller.entry_names().filter(|name| {
        let mut weights = sensitivity.parameters().iter();
        weights.any(|p| p.kind == ParameterKind::Weight && p.owner == *name)
    });
    assert_eq!(ranking.len(), weighted.count());
    assert!(
        ranking
            .windows(2)
            .all(|pair| pair[0].effort >= pair[1].effort)
    );
    let nv = controller.report().vdot.len();
    for influence in &ranking {
        let mut sum = vec![0.0; controller.command().effort.len()];
        for (j, p) in sensitivity.parameters().iter().enumerate() {
            if p.kind == ParameterKind::Weight && p.owner == influence.owner {
                for (i, sum) in sum.iter_mut().enumerate() {
                    *sum += p.value * sensitivity.derivatives()[(nv + i, j)];
                }
            }
        }
        let norm = sum.iter().map(|x| x * x).sum::<f64>().sqrt();
        assert!((norm - influence.effort).abs() <= 1e-12 * norm);
    }
    let text = sensitivity.to_string();
    assert!(
        text.contains("base_position.kp") && text.contains("1/s²"),
        "{text}"
    );
}

#[test]
fn what_has_no_derivatives_says_why() {
    let (mut c, scene) = scene_with(|config| config);
    let (mut other, _) = scene_with(|config| config);
    let mut measurement = scene.measurement();
    c.tick(&measurement);
    let mut sensitivity = Sensitivity::new(&mut c);
    assert_eq!(c.sensitivity(&mut sensitivity), Err(RequestError::NotKept));
    assert_eq!(
        other.sensitivity(&mut sensitivity),
        Err(RequestError::OtherController)
    );
    measurement.time += 0.004;
    c.tick(&measurement);
    assert_eq!(c.sensitivity(&mut sensitivity), Ok(()));
    assert_eq!(sensitivity.time(), Some(measurement.time));
    measurement.time += 0.004;
    measurement.state.q[0] = f64::NAN;
    c.tick(&measurement);
    assert_eq!(
        c.sensitivity(&mut sensitivity),
        Err(RequestError::NoOptimum(FallbackLevel::Extrapolated))
    );
    assert_eq!(sensitivity.time(), None);
}
