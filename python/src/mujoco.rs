//! What MuJoCo as a plant needs of Rust: the exported model, and a case's run period by period. The engine itself is
//! driven from Python (`wbqp.mujoco`).
#![allow(non_snake_case)]

use std::path::PathBuf;

use numpy::{PyReadonlyArray1, PyReadonlyArray2};
use pyo3::{
    exceptions::{PyRuntimeError, PyValueError},
    prelude::*,
    types::PyDict,
};
use wbqp::{
    model::{FrameId, Model},
    nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3, Vector6},
    robot::RobotModel,
    state::State,
};
use wbqp_log::{LogSink, McapLog};
use wbqp_mjcf::{Mjcf, Scene};
use wbqp_sim::{
    PlantCommand, RunOptions, Scenario, SceneWatcher, Variation, World, center_of_force,
    plant::has_diverged,
};

use crate::{config, plugin, robot::Robot, simulate};

/// Text, notes, and the geoms of walls and contact points.
fn exported<'py>(py: Python<'py>, mjcf: &Mjcf) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("text", &mjcf.text)?;
    dict.set_item("notes", &mjcf.notes)?;
    dict.set_item("walls", &mjcf.walls)?;
    dict.set_item("points", &mjcf.points)?;
    Ok(dict)
}

/// Anything that is wrong with files or values, a line each.
fn refused(py: Python<'_>, error: &dyn std::error::Error) -> PyErr {
    config::refused_text(py, &error.to_string())
}

/// A robot at home, alone in the world, as MJCF.
#[pyfunction]
pub(crate) fn export_robot<'py>(
    py: Python<'py>,
    robot: &Bound<'py, Robot>,
    step: f64,
) -> PyResult<Bound<'py, PyDict>> {
    let mut scene = Scene::of_robot(&robot.get().model);
    scene.step = step;
    exported(py, &scene.export().map_err(|e| refused(py, &e))?)
}

/// What the engine said last.
struct Truth {
    time: f64,
    robot: RobotModel,
    state: State,
    /// Per force-torque sensor: its frame and the wrench there.
    sensors: Vec<(FrameId, Vector6<f64>)>,
    /// Per contact point: its frame's name, force on the robot and place, world axes.
    points: Vec<(String, Vector3<f64>, Vector3<f64>)>,
    has_walls: bool,
    diverged: bool,
}

impl World for Truth {
    fn time(&self) -> f64 {
        self.time
    }

    fn model(&self) -> &Model {
        &self.robot.model
    }

    fn state(&self) -> &State {
        &self.state
    }

    fn wrench_at(&self, frame: FrameId) -> Vector6<f64> {
        let found = self.sensors.iter().find(|(of, _)| *of == frame);
        found.map_or_else(Vector6::zeros, |(_, wrench)| *wrench)
    }

    fn contact_at(&self, frame: &str) -> Option<(Vector3<f64>, Vector3<f64>)> {
        let at_frame = self.points.iter().filter(|(of, ..)| of == frame);
        let at_frame = at_frame.map(|(_, force, place)| (*force, *place));
        center_of_force(at_frame).filter(|_| self.has_walls)
    }

    fn is_diverged(&self) -> bool {
        self.diverged
    }
}

/// Frame, force, moment, start and end.
type Disturbance = (String, [f64; 3], [f64; 3], f64, f64);

/// One case of a scenario, period by period, whose world MuJoCo moves.
#[pyclass(module = "wbqp.mujoco", unsendable)]
pub(crate) struct CaseRun {
    run: Option<wbqp_sim::CaseRun>,
    truth: Truth,
    log: Option<McapLog>,
    scene: SceneWatcher,
    due: PlantCommand,
    mjcf: Mjcf,
    /// Which of the sensors' bodies each contact point is on.
    is_on: Vec<Vec<bool>>,
    case: wbqp_sim::scenario::Case,
    /// Of the first thing that a plug-in written in Python raised.
    traceback: Option<String>,
}

impl CaseRun {
    fn run(&mut self) -> PyResult<(&mut wbqp_sim::CaseRun, &Truth, &mut McapLog)> {
        match (&mut self.run, &mut self.log) {
            (Some(run), Some(log)) => Ok((run, &self.truth, log)),
            _ => Err(finished()),
        }
    }
}

fn finished() -> PyErr {
    PyRuntimeError::new_err("the run is finished")
}

fn watched_by(scene: &mut SceneWatcher) -> RunOptions<'_> {
    RunOptions {
        watchers: vec![scene],
        ..RunOptions::default()
    }
}

#[pymethods]
impl CaseRun {
    /// Loads a case and begins its log. `variation` is TOML with keys `change.…` and `set.…`, as in a `[[case]]`.
    #[new]
    #[pyo3(signature = (scenario, case, log, *, seed, step, variation = ""))]
    fn new(
        py: Python<'_>,
        scenario: PathBuf,
        case: &str,
        log: PathBuf,
        seed: u64,
        step: f64,
        variation: &str,
    ) -> PyResult<Self> {
        let variation = Variation::from_toml(variation).map_err(|e| refused(py, &e))?;
        let scenario =
            Scenario::from_file_with(&scenario, &variation).map_err(|e| refused(py, &e))?;
        let case = scenario.case(case).map_err(|e| refused(py, &e))?;
        let (controller, source) =
            wbqp_sim::CaseRun::controller(case).map_err(|e| refused(py, &e))?;
        let robot = controller.robot().clone();
        let command = PlantCommand::of(&robot, controller.command());
        let mut scene =
            Scene::of_case(case, &robot, command.clone()).map_err(|e| refused(py, &e))?;
        scene.step = step;
        let mjcf = scene.export().map_err(|e| refused(py, &e))?;
        let body_of = |frame: &str| {
            let id = robot.model.frame(frame)?;
            Some((id, robot.model.frames().get(id.index())?.body))
        };
        let sensors = &case.sensors().force_torque;
        let sensors: Vec<_> = sensors.iter().filter_map(|s| body_of(&s.frame)).collect();
        let points = &case.plant().contact_points;
        let is_on = sensors.iter().map(|(_, body)| {
            let on = points
                .iter()
                .map(|p| body_of(&p.frame).is_some_and(|(_, b)| b == *body));
            on.collect()
        });
        let is_on = is_on.collect();
        let truth = Truth {
            time: 0.0,
            state: scene.initial.clone(),
            sensors: sensors
                .iter()
                .map(|(id, _)| (*id, Vector6::zeros()))
                .collect(),
            points: points
                .iter()
                .map(|p| (p.frame.clone(), Vector3::zeros(), Vector3::zeros()))
                .collect(),
            has_walls: !case.plant().walls.is_empty(),
            diverged: false,
            robot,
        };
        let text = |e: &dyn std::fmt::Display| PyRuntimeError::new_err(e.to_string());
        let mut log = McapLog::create(&log).map_err(|e| text(&e))?;
        let run = wbqp_sim::CaseRun::new(
            &scenario,
            case,
            (controller, source),
            seed,
            &truth,
            &mut log,
        )
        .map_err(|e| text(&e))?;
        let mut scene = SceneWatcher::default();
        run.begin(&mut log, &mut watched_by(&mut scene))
            .map_err(|e| text(&e))?;
        Ok(Self {
            run: Some(run),
            truth,
            log: Some(log),
            scene,
            due: command,
            mjcf,
            is_on,
            case: case.clone(),
            traceback: None,
        })
    }

    /// The plant as MJCF: `text`, `notes`, and the geoms of `walls` and contact `points`.
    #[getter]
    fn mjcf<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        exported(py, &self.mjcf)
    }

    /// The controller's robot.
    #[getter]
    fn robot(&self) -> Robot {
        Robot::new(std::sync::Arc::new(self.truth.robot.clone()))
    }

    /// The controller's period, s.
    #[getter]
    fn period(&mut self) -> PyResult<f64> {
        Ok(self.run()?.0.period())
    }

    /// Control periods of the whole run.
    #[getter]
    fn ticks(&mut self) -> PyResult<usize> {
        Ok(self.run()?.0.ticks())
    }

    /// Frames of the force-torque sensors.
    #[getter]
    fn sensor_frames(&self) -> Vec<String> {
        let sensors = self.case.sensors().force_torque.iter();
        sensors.map(|s| s.frame.clone()).collect()
    }

    /// Disturbances: frame, force (N), moment (N·m), start and end (s); world axes.
    #[getter]
    fn disturbances(&self) -> Vec<Disturbance> {
        let all = self.case.plant().disturbances.iter();
        all.map(|d| (d.frame.clone(), d.force, d.moment, d.from, d.until))
            .collect()
    }

    /// Viscous friction of every wall, N·s/m.
    #[getter]
    fn viscous(&self) -> Vec<f64> {
        self.case
            .plant()
            .walls
            .iter()
            .map(|wall| wall.viscous)
            .collect()
    }

    /// The command that is applied now, in the order of the actuators.
    #[getter]
    fn due(&self) -> Vec<f64> {
        self.due.values().to_vec()
    }

    /// Takes the truth at a time, as the engine has it: `state` is base position, quaternion w-x-y-z, joints and
    /// velocities; `points` has force on the robot and place of every contact point, `frames` position and rotation,
    /// row by row, of every sensor's frame; world axes.
    fn observe(
        &mut self,
        time: f64,
        state: PyReadonlyArray1<'_, f64>,
        points: PyReadonlyArray2<'_, f64>,
        frames: PyReadonlyArray2<'_, f64>,
    ) -> PyResult<()> {
        let sizes = || PyValueError::new_err("the truth is not of this robot's sizes");
        let truth = &mut self.truth;
        let (points, frames, state) = (points.as_slice()?, frames.as_slice()?, state.as_slice()?);
        if points.len() != 6 * truth.points.len() || frames.len() != 12 * truth.sensors.len() {
            return Err(sizes());
        }
        truth.time = time;
        read_state(state, &mut truth.state).ok_or_else(sizes)?;
        for (point, new) in truth.points.iter_mut().zip(points.chunks_exact(6)) {
            point.1 = Vector3::from_column_slice(&new[..3]);
            point.2 = Vector3::from_column_slice(&new[3..]);
        }
        for ((sensor, frame), is_on) in truth
            .sensors
            .iter_mut()
            .zip(frames.chunks_exact(12))
            .zip(&self.is_on)
        {
            let position = Vector3::from_column_slice(&frame[..3]);
            let R_WF = Matrix3::from_row_slice(&frame[3..]);
            let (mut force, mut moment) = (Vector3::zeros(), Vector3::zeros());
            for ((_, f, place), _) in truth.points.iter().zip(is_on).filter(|(_, is_on)| **is_on) {
                force += f;
                moment += (place - position).cross(f);
            }
            let (force, moment) = (R_WF.tr_mul(&force), R_WF.tr_mul(&moment));
            sensor.1.fixed_rows_mut::<3>(0).copy_from(&force);
            sensor.1.fixed_rows_mut::<3>(3).copy_from(&moment);
        }
        truth.diverged = has_diverged(&truth.state);
        let (run, truth, _) = self.run()?;
        run.observe(truth);
        run.note_divergence(truth);
        Ok(())
    }

    /// One control period at the truth that was observed last: sensors, events, tick, log. Hands out the command that
    /// is due now, by actuator; `None` after the last period.
    fn tick(&mut self) -> PyResult<Option<Vec<f64>>> {
        let (Some(run), Some(log)) = (&mut self.run, &mut self.log) else {
            return Err(finished());
        };
        if run.is_over() {
            return Ok(None);
        }
        run.tick(&self.truth, log, &mut watched_by(&mut self.scene))
            .map_err(|e| PyRuntimeError::new_err(e.to_string()))?;
        if let Some(traceback) = plugin::traceback() {
            self.traceback.get_or_insert(traceback);
        }
        if let Some(interrupt) = plugin::interrupt() {
            return Err(interrupt);
        }
        if let Some(run) = &mut self.run {
            run.exchange(&mut self.due);
        }
        Ok(Some(self.due.values().to_vec()))
    }

    /// Ends the log, and says how the run went, as `wbqp.simulate` does.
    fn finish<'py>(&mut self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let (Some(run), Some(mut log)) = (self.run.take(), self.log.take()) else {
            return Err(finished());
        };
        let text = |e: &dyn std::fmt::Display| PyRuntimeError::new_err(e.to_string());
        let summary = run.finish(&mut log).map_err(|e| text(&e))?;
        log.finish().map_err(|e| text(&e))?;
        simulate::described(py, &summary, self.traceback.take())
    }
}

fn read_state(from: &[f64], state: &mut State) -> Option<()> {
    let (joints, velocities) = (state.q.len(), state.v.len());
    let (position, rest) = from.split_at_checked(3)?;
    let (quaternion, rest) = rest.split_at_checked(4)?;
    let (q, v) = rest.split_at_checked(joints)?;
    if v.len() != velocities {
        return None;
    }
    state.p_WR.as_mut_slice().copy_from_slice(position);
    if let &[w, x, y, z] = quaternion {
        state.R_WR = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z));
    }
    state.q.as_mut_slice().copy_from_slice(q);
    state.v.as_mut_slice().copy_from_slice(v);
    Some(())
}
