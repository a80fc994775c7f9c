//! Model and dynamics for those who want no controller.
#![allow(non_snake_case, reason = "the mathematics' names")]

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use pyo3::{exceptions::PyKeyError, prelude::*, types::PyDict};
use wbqp::{
    dynamics::{
        Actuation, Data, FrameKinematics, JointDrive, Wrenches, energy, forward_dynamics,
        inverse_dynamics,
    },
    nalgebra::{DVector, Quaternion, UnitQuaternion, Vector3},
    robot::RobotModel,
    state::State,
    suggestion::suggestion,
};

use crate::{
    arrays::{Length, of_matrix, of_rows, of_vector, vector},
    robot::Robot,
};

/// Kinematics and dynamics of a robot in one state: ``M v̇ + h = S u + Σ Jᵀ f``.
///
/// World axes throughout; ``v = [v_WR; w_WR; q̇]`` of a floating base, linear first, ``q̇`` of a fixed one.
/// Accelerations are classical ones. Every method returns new arrays.
///
/// Parameters
/// ----------
/// robot : Robot
///     Such as ``controller.robot`` or ``wbqp.Robot({"file": "ur5.urdf", "base": "fixed"})``.
///
/// Examples
/// --------
/// >>> dynamics = wbqp.Dynamics(robot)
/// >>> dynamics.update(q=q, v=v)
/// >>> M, h = dynamics.mass_matrix(), dynamics.bias()
#[pyclass(frozen, module = "wbqp")]
pub(crate) struct Dynamics {
    robot: Arc<RobotModel>,
    inner: Mutex<Inner>,
}

struct Inner {
    state: State,
    data: Data,
}

/// Pose, velocity and Jacobian of a frame in the world.
#[pyclass(frozen, get_all, module = "wbqp")]
pub(crate) struct FrameState {
    /// Origin, m, world, shape (3,).
    position: Py<PyAny>,
    /// Rotation matrix from the frame's axes to the world's, shape (3, 3).
    rotation: Py<PyAny>,
    /// ``[linear; angular]`` velocity of the origin, m/s and rad/s, world axes, shape (6,).
    velocity: Py<PyAny>,
    /// Jacobian of the origin, ``velocity = J v``, shape (6, nv).
    J: Py<PyAny>,
    /// ``J̇ v``, acceleration of the origin with ``v̇ = 0``, m/s² and rad/s², shape (6,).
    Jdot_v: Py<PyAny>,
}

impl Dynamics {
    /// The guard must be gone before anything of Python is made or called: that may run other Python code, also a
    /// collection of garbage, which may want it too.
    fn inner(&self) -> MutexGuard<'_, Inner> {
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A copy of something that was computed.
    fn read<T>(&self, of: impl FnOnce(&Data) -> T) -> T {
        of(&self.inner().data)
    }

    fn frame_of(&self, name: &str) -> PyResult<wbqp::model::FrameId> {
        self.robot.model.frame(name).ok_or_else(|| {
            let frames = self.robot.model.frames().iter();
            let known: Vec<&str> = frames.map(|frame| frame.name.as_str()).collect();
            let hint = suggestion(name, &known);
            PyKeyError::new_err(format!("the robot has no frame `{name}`{hint}"))
        })
    }

    /// Forces of the environment, `{frame: [force, moment]}` in world axes at the frame's origin.
    fn forces(&self, forces: Option<&Bound<'_, PyDict>>) -> PyResult<Vec<Force>> {
        let mut list = Vec::new();
        for (name, wrench) in forces.into_iter().flatten() {
            let name: String = name.extract()?;
            let frame = self.frame_of(&name)?;
            let numbers = vector(&wrench, &format!("forces[{name:?}]"), Length::Exactly(6))?;
            let three = |at: usize| Vector3::from_fn(|i, _| numbers[at + i]);
            list.push((frame, three(0), three(3)));
        }
        Ok(list)
    }

    fn wrenches(&self, data: &Data, forces: &[Force]) -> Wrenches {
        let mut wrenches = Wrenches::new(&self.robot.model);
        for (frame, force, moment) in forces {
            let motion = wbqp::dynamics::frame_motion(&self.robot.model, data, *frame);
            let body = self.robot.model.frames()[frame.index()].body;
            wrenches.add_wrench(data, body, &motion.p_WF, force, moment);
        }
        wrenches
    }
}

/// Force and moment at a frame's origin, N and N·m, world axes.
type Force = (wbqp::model::FrameId, Vector3<f64>, Vector3<f64>);

#[pymethods]
impl Dynamics {
    #[new]
    fn new(robot: &Robot) -> Self {
        let robot = Arc::clone(&robot.model);
        let state = robot.home.clone();
        let mut data = Data::new(&robot.model);
        data.update(&robot.model, &state);
        Self {
            inner: Mutex::new(Inner { state, data }),
            robot,
        }
    }

    /// Goes to a state; what is left out stays, at first the home posture at rest.
    ///
    /// Parameters
    /// ----------
    /// q : array (joints,), optional
    ///     Joint positions, rad or m.
    /// v : array (nv,), optional
    ///     Generalised velocity.
    /// position : array (3,), optional
    ///     Origin of the base, m, world.
    /// quaternion : array (4,), optional
    ///     Orientation of the base, w-x-y-z; normalised.
    #[pyo3(signature = (q = None, v = None, *, position = None, quaternion = None))]
    fn update(
        &self,
        q: Option<&Bound<'_, PyAny>>,
        v: Option<&Bound<'_, PyAny>>,
        position: Option<&Bound<'_, PyAny>>,
        quaternion: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        let mut state = self.inner().state.clone();
        if let Some(q) = q {
            let joints = Length::Exactly(state.q.len());
            state.q = DVector::from_vec(vector(q, "q", joints)?);
        }
        if let Some(v) = v {
            let velocities = Length::Exactly(state.v.len());
            state.v = DVector::from_vec(vector(v, "v", velocities)?);
        }
        if let Some(position) = position {
            state.p_WR = Vector3::from_vec(vector(position, "position", Length::Exactly(3))?);
        }
        if let Some(quaternion) = quaternion {
            let wxyz = vector(quaternion, "quaternion", Length::Exactly(4))?;
            let [w, x, y, z] = [wxyz[0], wxyz[1], wxyz[2], wxyz[3]];
            let unit = UnitQuaternion::try_new(Quaternion::new(w, x, y, z), 1e-6);
            state.R_WR = unit.ok_or_else(|| {
                pyo3::exceptions::PyValueError::new_err(
                    "quaternion: is zero, must have a direction",
                )
            })?;
        }
        if !state.is_finite() {
            return Err(pyo3::exceptions::PyValueError::new_err(
                "the state has a number that is not finite",
            ));
        }
        let mut inner = self.inner();
        let Inner { state: is, data } = &mut *inner;
        is.copy_from(&state);
        data.update(&self.robot.model, is);
        Ok(())
    }

    /// Mass matrix ``M``, shape (nv, nv), armature on the diagonal.
    fn mass_matrix<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        of_matrix(py, &self.read(|data| data.mass_matrix().clone()))
    }

    /// ``h``: Coriolis, centrifugal and gravity terms, N and N·m, shape (nv,).
    fn bias<'py>(&self, py: Python<'py>) -> Bound<'py, PyAny> {
        of_vector(py, self.read(|data| data.bias().clone()).as_slice())
    }

    /// ``g = h(q, 0)``: what holds the robot still, N and N·m, shape (nv,).
    fn gravity<'py>(&self, py: Python<'py>) -> Bound<'py, PyAny> {
        of_vector(py, self.read(|data| data.gravity().clone()).as_slice())
    }

    /// ``S``: generalised force of a unit of each effort, shape (nv, nu).
    fn actuation<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let (nv, nu) = (self.robot.model.nv(), self.robot.nu());
        let mut rows = vec![0.0; nv * nu];
        let actuation = Actuation::new(&self.robot.model, &self.robot.actuators);
        actuation.write(&self.inner().data, &mut rows, nu);
        of_rows(py, &rows, nv, nu)
    }

    /// Centre of mass, m, world, shape (3,).
    fn center_of_mass<'py>(&self, py: Python<'py>) -> Bound<'py, PyAny> {
        of_vector(py, self.read(Data::center_of_mass).as_slice())
    }

    /// Velocity of the centre of mass, m/s, world axes, shape (3,).
    fn center_of_mass_velocity<'py>(&self, py: Python<'py>) -> Bound<'py, PyAny> {
        of_vector(py, self.read(Data::center_of_mass_velocity).as_slice())
    }

    /// Jacobian of the centre of mass, shape (3, nv).
    fn center_of_mass_jacobian<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        of_matrix(
            py,
            &self.read(|data| data.center_of_mass_jacobian().clone()),
        )
    }

    /// ``J̇_com v``, m/s², world axes, shape (3,).
    fn center_of_mass_bias<'py>(&self, py: Python<'py>) -> Bound<'py, PyAny> {
        of_vector(py, self.read(Data::center_of_mass_bias).as_slice())
    }

    /// ``[linear; angular]`` momentum, kg·m/s and kg·m²/s, world axes, about the centre of mass, shape (6,).
    fn momentum<'py>(&self, py: Python<'py>) -> Bound<'py, PyAny> {
        of_vector(py, self.read(Data::centroidal_momentum).as_slice())
    }

    /// ``(kinetic, potential)`` energy, J.
    fn energy(&self) -> (f64, f64) {
        let energy = energy(&self.robot.model, &self.inner().data);
        (energy.kinetic, energy.potential)
    }

    /// Pose, velocity and Jacobian of a named frame.
    fn frame(&self, py: Python<'_>, name: &str) -> PyResult<FrameState> {
        let frame = self.frame_of(name)?;
        let mut kinematics = FrameKinematics::new(&self.robot.model);
        kinematics.update(&self.robot.model, &self.inner().data, frame);
        let FrameKinematics {
            p_WF,
            R_WF,
            v_WF,
            w_WF,
            J,
            Jdot_v,
        } = &kinematics;
        let velocity = [v_WF.x, v_WF.y, v_WF.z, w_WF.x, w_WF.y, w_WF.z];
        Ok(FrameState {
            position: of_vector(py, p_WF.as_slice()).unbind(),
            rotation: of_matrix(py, R_WF.matrix())?.unbind(),
            velocity: of_vector(py, &velocity).unbind(),
            J: of_matrix(py, J)?.unbind(),
            Jdot_v: of_vector(py, Jdot_v.as_slice()).unbind(),
        })
    }

    /// Generalised force that gives an acceleration: ``M v̇ + h − Σ Jᵀ f``, shape (nv,).
    ///
    /// Parameters
    /// ----------
    /// vdot : array (nv,)
    ///     Generalised acceleration.
    /// forces : dict, optional
    ///     What the environment does to the robot: ``{frame: [force, moment]}``, N and N·m, world axes, at the frame's
    ///     origin, six numbers each.
    #[pyo3(signature = (vdot, forces = None))]
    fn inverse<'py>(
        &self,
        vdot: &Bound<'py, PyAny>,
        forces: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let nv = self.robot.model.nv();
        let vdot_numbers = DVector::from_vec(vector(vdot, "vdot", Length::Exactly(nv))?);
        let forces = self.forces(forces)?;
        let mut inner = self.inner();
        let wrenches = self.wrenches(&inner.data, &forces);
        let mut out = DVector::zeros(nv);
        let model = &self.robot.model;
        inverse_dynamics(model, &mut inner.data, &vdot_numbers, &wrenches, &mut out);
        drop(inner);
        Ok(of_vector(vdot.py(), out.as_slice()))
    }

    /// Acceleration that efforts and forces give: ``M⁻¹ (S u + Σ Jᵀ f − h)``, shape (nv,), without friction.
    ///
    /// Parameters
    /// ----------
    /// effort : array (nu,)
    ///     Efforts of the actuators, N or N·m.
    /// forces : dict, optional
    ///     As of `inverse`.
    #[pyo3(signature = (effort, forces = None))]
    fn forward<'py>(
        &self,
        effort: &Bound<'py, PyAny>,
        forces: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let robot = &self.robot;
        let effort_numbers = vector(effort, "effort", Length::Exactly(robot.nu()))?;
        let forces = self.forces(forces)?;
        let mut inner = self.inner();
        let mut wrenches = self.wrenches(&inner.data, &forces);
        let mut drives = vec![JointDrive::Effort(0.0); robot.model.joints().len()];
        for (actuator, effort) in robot.actuators.iter().zip(&effort_numbers) {
            match &actuator.kind {
                wbqp::actuator::ActuatorKind::Joint(motor) => {
                    drives[motor.joint.index()] = JointDrive::Effort(*effort);
                }
                wbqp::actuator::ActuatorKind::Rotor(rotor) => {
                    let motion =
                        wbqp::dynamics::frame_motion(&robot.model, &inner.data, rotor.frame);
                    let axis = motion.R_WF * Vector3::z();
                    let twist = rotor.reaction.sign() * rotor.moment_coefficient * *effort;
                    let body = robot.model.frames()[rotor.frame.index()].body;
                    let (force, moment) = (axis * *effort, axis * twist);
                    wrenches.add_wrench(&inner.data, body, &motion.p_WF, &force, &moment);
                }
            }
        }
        let mut vdot = DVector::zeros(robot.model.nv());
        let mut efforts = DVector::zeros(drives.len());
        let data = &mut inner.data;
        forward_dynamics(
            &robot.model,
            data,
            &drives,
            &wrenches,
            &mut vdot,
            &mut efforts,
        );
        drop(inner);
        Ok(of_vector(effort.py(), vdot.as_slice()))
    }

    /// Efforts that come nearest to holding the robot still, within the actuators' limits.
    ///
    /// Parameters
    /// ----------
    /// forces : dict, optional
    ///     As of `inverse`.
    ///
    /// Returns
    /// -------
    /// effort : array (nu,)
    ///     N or N·m.
    /// residual : array (nv,)
    ///     What they leave unbalanced, ``g − S u − Σ Jᵀ f``, N and N·m; zero where the robot can hold still.
    #[pyo3(signature = (forces = None))]
    fn statics<'py>(
        &self,
        py: Python<'py>,
        forces: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let robot = &self.robot;
        let (nv, nu) = (robot.model.nv(), robot.nu());
        let forces = self.forces(forces)?;
        let mut inner = self.inner();
        let wrenches = self.wrenches(&inner.data, &forces);
        let mut at_rest = inner.state.clone();
        at_rest.v.fill(0.0);
        inner.data.update(&robot.model, &at_rest);
        let mut load = DVector::zeros(nv);
        let zero = DVector::zeros(nv);
        inverse_dynamics(&robot.model, &mut inner.data, &zero, &wrenches, &mut load);
        let mut S = vec![0.0; nv * nu];
        Actuation::new(&robot.model, &robot.actuators).write(&inner.data, &mut S, nu);
        let Inner { state, data } = &mut *inner;
        data.update(&robot.model, state);
        drop(inner);
        let limits: Vec<(f64, f64)> = robot.actuators.iter().map(|a| (a.lower, a.upper)).collect();
        let effort = crate::qp::least_squares(&S, load.as_slice(), &limits)?;
        let residual: Vec<f64> = (0..nv)
            .map(|i| load[i] - (0..nu).map(|j| S[i * nu + j] * effort[j]).sum::<f64>())
            .collect();
        Ok((of_vector(py, &effort), of_vector(py, &residual)))
    }

    /// ``v̇`` from ``M v̇ = rhs``: for those who have the right-hand side, shape (nv,).
    fn solve_mass<'py>(&self, rhs: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        let nv = self.robot.model.nv();
        let rhs_numbers = DVector::from_vec(vector(rhs, "rhs", Length::Exactly(nv))?);
        let factor = self.inner().data.mass_matrix().clone().cholesky();
        let factor = factor.ok_or_else(|| {
            pyo3::exceptions::PyValueError::new_err("the mass matrix is not positive definite")
        })?;
        Ok(of_vector(rhs.py(), factor.solve(&rhs_numbers).as_slice()))
    }
}
