//! M, h, gravity, centre of mass, momentum, frames and forward dynamics against Pinocchio, on the shipped robots
//! and four others, to 1e-9 of each quantity's size. `fixtures/generate_pinocchio.py` describes the numbers.
#![allow(non_snake_case)]

use serde_json::Value;
use wbqp::{
    dynamics::{Data, FrameKinematics, JointDrive, Wrenches, forward_dynamics, inverse_dynamics},
    model::Model,
    nalgebra::{DMatrix, DVector, Quaternion, UnitQuaternion, Vector3},
    state::State,
};
use wbqp_robots::{BaseKind, Options};

const TOLERANCE: f64 = 1e-9;

fn numbers(value: &Value) -> Vec<f64> {
    let list = value.as_array().expect("a list");
    list.iter().map(|x| x.as_f64().expect("a number")).collect()
}

fn vector(value: &Value) -> DVector<f64> {
    DVector::from_vec(numbers(value))
}

fn vector3(value: &Value) -> Vector3<f64> {
    Vector3::from_column_slice(&numbers(value))
}

fn matrix(value: &Value) -> DMatrix<f64> {
    let rows: Vec<Vec<f64>> = value
        .as_array()
        .expect("rows")
        .iter()
        .map(numbers)
        .collect();
    DMatrix::from_row_slice(rows.len(), rows[0].len(), &rows.concat())
}

/// One robot of the file: its model here, and where its velocities are in Pinocchio's order.
struct Robot<'a> {
    name: &'a str,
    model: Model,
    /// `order[i]` is the place in the file of velocity `i` of the model.
    order: Vec<usize>,
}

impl<'a> Robot<'a> {
    fn load(entry: &'a Value) -> Self {
        let file = entry["urdf"].as_str().expect("a path");
        let path = format!("{}/../{file}", env!("CARGO_MANIFEST_DIR"));
        let text = std::fs::read_to_string(path).expect("the robot's URDF");
        let floating = entry["floating"].as_bool().expect("a flag");
        let options = Options {
            base: if floating {
                BaseKind::Floating
            } else {
                BaseKind::Fixed
            },
            ..Options::default()
        };
        let model = wbqp_robots::urdf::model(file, &text, &options).expect("a valid robot");
        let joints = entry["joints"].as_array().expect("names");
        let offset = model.joint_offset();
        let place = |name: &str| {
            joints
                .iter()
                .position(|j| j == name)
                .expect("the same joints")
        };
        let of_joints = model.joints().iter().map(|j| offset + place(&j.name));
        let order = (0..offset).chain(of_joints).collect();
        let name = entry["name"].as_str().expect("a name");
        Self { name, model, order }
    }

    fn ours(&self, v: &DVector<f64>) -> DVector<f64> {
        v.select_rows(&self.order)
    }

    fn state(&self, entry: &Value) -> State {
        let mut state = State::neutral(&self.model);
        if self.model.joint_offset() == 6 {
            let q = numbers(&entry["base"]["quaternion_wxyz"]);
            state.p_WR = vector3(&entry["base"]["p"]);
            state.R_WR = UnitQuaternion::from_quaternion(Quaternion::new(q[0], q[1], q[2], q[3]));
        }
        for (i, joint) in self.model.joints().iter().enumerate() {
            state.q[i] = entry["q"][&joint.name].as_f64().expect("an angle");
        }
        state.v = self.ours(&vector(&entry["v"]));
        state
    }

    /// Compares relative to the size of the whole quantity, 1 at least.
    fn same(&self, what: &str, ours: &[f64], theirs: &[f64]) {
        assert_eq!(ours.len(), theirs.len(), "{}: size of {what}", self.name);
        let norm = |x: &mut dyn Iterator<Item = f64>| x.fold(0.0, |m: f64, y| m.max(y.abs()));
        let error = norm(&mut ours.iter().zip(theirs).map(|(a, b)| a - b));
        let size = norm(&mut theirs.iter().copied()).max(1.0);
        let finite = ours.iter().all(|x| x.is_finite());
        assert!(
            finite && error <= TOLERANCE * size,
            "{}: {what} is off by {error:e} of {size}",
            self.name
        );
    }

    fn compare_dynamics(&self, data: &Data, entry: &Value) {
        let M = matrix(&entry["mass_matrix"])
            .select_rows(&self.order)
            .select_columns(&self.order);
        self.same("M", data.mass_matrix().as_slice(), M.as_slice());
        self.same(
            "h",
            data.bias().as_slice(),
            self.ours(&vector(&entry["h"])).as_slice(),
        );
        self.same(
            "g",
            data.gravity().as_slice(),
            self.ours(&vector(&entry["g"])).as_slice(),
        );
        self.same(
            "centre of mass",
            data.center_of_mass().as_slice(),
            &numbers(&entry["com"]),
        );
        let J = matrix(&entry["com_jacobian"]).select_columns(&self.order);
        self.same(
            "J_com",
            data.center_of_mass_jacobian().as_slice(),
            J.as_slice(),
        );
        let momentum = [
            numbers(&entry["momentum"]["linear"]),
            numbers(&entry["momentum"]["angular"]),
        ]
        .concat();
        self.same("momentum", data.centroidal_momentum().as_slice(), &momentum);
    }

    fn compare_frame(&self, data: &Data, entry: &Value) {
        let name = entry["name"].as_str().expect("a name");
        let frame = self.model.frame(name).expect("the same frames");
        let mut k = FrameKinematics::new(&self.model);
        k.update(&self.model, data, frame);
        self.same(name, k.p_WF.as_slice(), &numbers(&entry["p"]));
        self.same(
            name,
            k.R_WF.matrix().as_slice(),
            matrix(&entry["R"]).as_slice(),
        );
        let J = matrix(&entry["jacobian"]).select_columns(&self.order);
        self.same(name, k.J.as_slice(), J.as_slice());
        self.same(name, k.Jdot_v.as_slice(), &numbers(&entry["bias"]));
    }

    /// Forward dynamics with all joints driven by effort, then with every second joint servoed to the
    /// acceleration that the effort gave.
    fn compare_forward(&self, data: &mut Data, entry: &Value) {
        let model = &self.model;
        let joints = model.joints().len();
        let name = entry["frame"].as_str().expect("a name");
        let frame = &model.frames()[model.frame(name).expect("the same frames").index()];
        let p_WF = (data.body_pose(frame.body) * frame.X_BF).translation.vector;
        let w = numbers(&entry["wrench"]);
        let (force, moment) = (
            Vector3::from_column_slice(&w[..3]),
            Vector3::from_column_slice(&w[3..]),
        );
        let mut wrenches = Wrenches::new(model);
        wrenches.add_wrench(data, frame.body, &p_WF, &force, &moment);

        let given: Vec<f64> = model
            .joints()
            .iter()
            .map(|j| entry["effort"][&j.name].as_f64().expect("a number"))
            .collect();
        let expected = self.ours(&vector(&entry["acceleration"]));
        let (mut vdot, mut effort) = (DVector::zeros(model.nv()), DVector::zeros(joints));
        for servoed in [joints + 1, 2] {
            let drives: Vec<JointDrive> = (0..joints)
                .map(|i| match (i + 1) % servoed {
                    0 => JointDrive::Acceleration(expected[model.joint_offset() + i]),
                    _ => JointDrive::Effort(given[i]),
                })
                .collect();
            forward_dynamics(model, data, &drives, &wrenches, &mut vdot, &mut effort);
            self.same("forward dynamics", vdot.as_slice(), expected.as_slice());
            self.same("effort", effort.as_slice(), &given);
        }
        let mut tau = DVector::zeros(model.nv());
        inverse_dynamics(model, data, &expected, &wrenches, &mut tau);
        let of_joints = tau.rows(model.joint_offset(), joints).into_owned();
        self.same("inverse dynamics", of_joints.as_slice(), &given);
    }
}

#[test]
fn agrees_with_pinocchio() {
    let path = format!("{}/fixtures/pinocchio.json", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(path).expect("the fixture file");
    let file: Value = serde_json::from_str(&text).expect("valid JSON");
    let mut compared = 0;
    for entry in file["robots"].as_array().expect("robots") {
        let robot = Robot::load(entry);
        let mut data = Data::new(&robot.model);
        assert_eq!(robot.model.nv(), robot.order.len());
        for entry in entry["states"].as_array().expect("states") {
            data.update(&robot.model, &robot.state(entry));
            robot.compare_dynamics(&data, entry);
            for frame in entry["frames"].as_array().expect("frames") {
                robot.compare_frame(&data, frame);
            }
            robot.compare_forward(&mut data, &entry["forward"]);
            compared += 1;
        }
    }
    assert!(compared >= 30, "only {compared} states compared");
}
