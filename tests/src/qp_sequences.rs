//! Sequences of quadratic programs as consecutive ticks of a robot pose them: they change slowly, and so do the
//! constraints that are active.
//!
//! Accelerations, forces and inputs at which everything is feasible are drawn first, as smooth functions of time; bias
//! forces follow from them. What the tasks ask for deviates from them by more than the limits allow, now and then.

use std::{f64::consts::TAU, ops::Range};

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use wbqp::{
    nalgebra::{DMatrix, DVector, Matrix3, Vector3},
    qp::{Capacity, Qp, RowId, VarId},
};

/// Time between two problems, s.
const PERIOD: f64 = 1e-3;
const INF: f64 = f64::INFINITY;

/// A smooth signal: a sum of sines.
#[derive(Clone, Debug, PartialEq)]
struct Wave([(f64, f64, f64); 3]);

impl Wave {
    fn new(rng: &mut ChaCha8Rng, amplitude: f64) -> Self {
        Self([(); 3].map(|()| {
            let share = amplitude * rng.random_range(0.3..1.0) / 1.7;
            (
                share,
                TAU * rng.random_range(0.2..1.5),
                rng.random_range(0.0..TAU),
            )
        }))
    }

    fn at(&self, time: f64) -> f64 {
        let sine = |(a, rate, phase): &(f64, f64, f64)| a * (rate * time + phase).sin();
        self.0.iter().map(sine).sum()
    }
}

/// A matrix of smooth signals about constants.
struct Waves {
    mean: DMatrix<f64>,
    waves: DMatrix<Wave>,
}

impl Waves {
    fn new(rng: &mut ChaCha8Rng, rows: usize, columns: usize, mean: f64, amplitude: f64) -> Self {
        Self {
            mean: DMatrix::from_fn(rows, columns, |_, _| mean * rng.random_range(-1.7..1.7)),
            waves: DMatrix::from_fn(rows, columns, |_, _| Wave::new(rng, amplitude)),
        }
    }

    fn at(&self, time: f64) -> DMatrix<f64> {
        let (rows, columns) = self.mean.shape();
        DMatrix::from_fn(rows, columns, |i, j| {
            self.mean[(i, j)] + self.waves[(i, j)].at(time)
        })
    }

    fn vector(&self, time: f64) -> DVector<f64> {
        self.at(time).column(0).into_owned()
    }
}

/// A mass matrix: definite, with couplings between the coordinates that `coupled` names.
struct Mass {
    diagonal: DVector<f64>,
    coupling: Waves,
    coupled: fn(usize, usize) -> bool,
}

impl Mass {
    fn at(&self, time: f64) -> DMatrix<f64> {
        let (n, waves) = (self.diagonal.len(), self.coupling.at(time));
        DMatrix::from_fn(n, n, |i, j| {
            let size = (self.diagonal[i] * self.diagonal[j]).sqrt();
            let (low, high) = (i.min(j), i.max(j));
            if i == j {
                size * (1.3 + waves[(i, i)])
            } else if (self.coupled)(low, high) {
                size * waves[(high, low)]
            } else {
                0.0
            }
        })
    }
}

/// How much of the deviation from what is feasible the tasks ask for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Demand {
    /// From hardly any to all of it, now and then.
    Swelling,
    /// So much all the time: some limits are active in every problem.
    Steady(f64),
}

impl Demand {
    fn at(self, wave: &Wave, time: f64) -> f64 {
        match self {
            Self::Swelling => 0.5 + 0.5 * wave.at(time).clamp(-0.9, 1.0),
            Self::Steady(share) => share,
        }
    }
}

fn problem(vars: usize, rows: usize) -> Qp {
    let mut qp = Qp::new(Capacity { vars, rows });
    qp.reset((0..vars as u32).map(VarId::new)).expect("ascends");
    qp
}

fn push(qp: &mut Qp, a: impl Iterator<Item = f64>, lower: f64, upper: f64) {
    let id = RowId::new(qp.m() as u32);
    let row = qp.push_row(id, lower, upper).expect("has the capacity");
    for (row, a) in row.iter_mut().zip(a) {
        *row = a;
    }
}

fn set_cost(qp: &mut Qp, h: &DMatrix<f64>, g: &DVector<f64>) {
    let (to_h, to_g) = qp.cost_mut();
    // Symmetric: columns are rows.
    to_h.copy_from_slice(h.as_slice());
    to_g.copy_from_slice(g.as_slice());
}

/// Friction rows of a point force whose components begin with variable `at`: four faces and the least normal force.
fn push_friction(qp: &mut Qp, at: usize, friction: f64, least: f64) {
    let n = qp.n();
    for (axis, sign) in [(0, 1.0), (0, -1.0), (1, 1.0), (1, -1.0)] {
        let mut a = vec![0.0; n];
        a[at + axis] = sign;
        a[at + 2] = -friction;
        push(qp, a.into_iter(), -INF, 0.0);
    }
    let mut normal = vec![0.0; n];
    normal[at + 2] = 1.0;
    push(qp, normal.into_iter(), least, INF);
}

/// An aerial manipulator with a point contact in condensed form: 12 variables (six thrusts, three torques, a force)
/// with bounds on the inputs, five friction rows.
///
/// # Panics
/// Never: mass matrices are definite.
pub fn aerial(ticks: usize, demand: Demand) -> Vec<Qp> {
    let rng = &mut ChaCha8Rng::seed_from_u64(1);
    let (nv, nu) = (9, 9);
    let mass = Mass {
        diagonal: DVector::from_row_slice(&[2.8, 2.8, 2.8, 0.045, 0.05, 0.08, 0.02, 0.015, 0.006]),
        coupling: Waves::new(rng, nv, nv, 0.0, 0.06),
        coupled: |_, _| true,
    };
    let allocation = DMatrix::from_fn(nv, nu, |i, j| match (i, j) {
        (6.., _) => f64::from(u8::from(i == j)),
        (_, 6..) => 0.0,
        _ => {
            let (sin, cos) = (j as f64 * TAU / 6.0).sin_cos();
            let sign = if j % 2 == 0 { 1.0 } else { -1.0 };
            let (tilt_sin, tilt_cos) = (sign * 0.45_f64).sin_cos();
            let axis = Vector3::new(-sin * tilt_sin, cos * tilt_sin, tilt_cos);
            let moment = Vector3::new(0.38 * cos, 0.38 * sin, 0.0).cross(&axis);
            let moment = moment + 0.018 * sign * axis;
            if i < 3 { axis[i] } else { moment[i - 3] }
        }
    });
    let contact = Waves::new(rng, 3, nv, 0.3, 0.12);
    let tip = Waves::new(rng, 3, nv, 0.3, 0.1);
    let acceleration = Waves::new(rng, nv, 1, 0.0, 1.0);
    let inputs = Waves::new(rng, nu, 1, 0.0, 1.0);
    let deviation = Waves::new(rng, nv, 1, 0.0, 1.0);
    let (normal, asked) = (Wave::new(rng, 4.0), Wave::new(rng, 1.0));
    let scale = [4.0, 4.0, 4.0, 18.0, 18.0, 18.0, 40.0, 40.0, 40.0];
    let weights = [
        10.0, 10.0, 10.0, 1.0, 1.0, 1.0, 5.0, 5.0, 5.0, 1e-2, 1e-2, 1e-2,
    ];

    let tick = |k: usize| {
        let time = k as f64 * PERIOD;
        let mass = mass.at(time);
        let mut generalised = DMatrix::zeros(nv, nu + 3);
        generalised.columns_mut(0, nu).copy_from(&allocation);
        let translation = DMatrix::identity(3, nv);
        let contact = contact.at(time) + &translation;
        generalised
            .columns_mut(nu, 3)
            .copy_from(&contact.transpose());
        let mut nominal = DVector::zeros(nu + 3);
        for (i, u) in inputs.vector(time).iter().enumerate() {
            nominal[i] = if i < 6 { 5.2 + 1.6 * u } else { 0.25 * u };
        }
        nominal[nu + 2] = 6.0 + normal.at(time);
        let acceleration = acceleration.vector(time);
        let inverse = mass.clone().try_inverse().expect("is definite");
        // v̇ = G x + v̇₀, with v̇ = `acceleration` at the nominal x.
        let g_matrix = &inverse * &generalised;
        let offset = &acceleration - &g_matrix * &nominal;
        let mut tasks = DMatrix::zeros(12, nv);
        tasks.rows_mut(0, 6).fill_with_identity();
        tasks
            .rows_mut(6, 3)
            .copy_from(&(tip.at(time) + &translation));
        tasks.view_mut((9, 6), (3, 3)).fill_with_identity();
        let deviation = deviation.vector(time) * demand.at(&asked, time);
        let wanted = DVector::from_fn(12, |i, _| {
            let more = if i < nv { scale[i] * deviation[i] } else { 0.0 };
            tasks.row(i).transpose().dot(&acceleration) + more
        });
        let weights = DMatrix::from_diagonal(&DVector::from_row_slice(&weights));
        let columns = &tasks * &g_matrix;
        let mut h = columns.transpose() * &weights * &columns;
        let mut g = columns.transpose() * &weights * (&tasks * &offset - wanted);
        for i in 0..nu + 3 {
            let (weight, target) = match i {
                0..6 => (1e-5, 5.0),
                6..9 => (1e-5, 0.0),
                _ => (1e-3, 1.3 * nominal[i]),
            };
            h[(i, i)] += weight;
            g[i] -= weight * target;
        }
        let mut qp = problem(nu + 3, 5);
        set_cost(&mut qp, &h, &g);
        push_friction(&mut qp, nu, 0.35, 0.5);
        let (lower, upper) = qp.bounds_mut();
        lower[..6].fill(0.25);
        upper[..6].fill(9.9);
        lower[6..9].fill(-1.2);
        upper[6..9].fill(1.2);
        qp
    };
    (0..ticks).map(tick).collect()
}

/// A robot on its feet without its torques: what of it changes with time, and what limits it.
struct Standing {
    mass: Mass,
    /// An acceleration, forces and torques that are feasible.
    acceleration: Waves,
    forces: Waves,
    torques: Waves,
    /// What the tasks ask for beyond that.
    deviation: Waves,
    /// What a point that is to be moved has of the accelerations of joints.
    point: Waves,
    asked: Wave,
    limits: Limits,
}

/// Sizes of a robot on its feet, and its limits.
struct Limits {
    mean_normal: f64,
    largest_torque: f64,
    friction: f64,
    /// Forces along the ground, of the normal ones.
    sideways: f64,
    /// Weight of the forces in the cost.
    force_weight: f64,
    /// Accelerations that move the point besides the base's.
    moving: Range<usize>,
}

/// Jacobians of a robot on its feet.
struct Feet {
    /// Of the points that bear forces.
    contact: DMatrix<f64>,
    /// Of what is at rest.
    motion: DMatrix<f64>,
}

impl Standing {
    /// `drift` is the amplitude of what changes in the point's row.
    fn new(rng: &mut ChaCha8Rng, mass: Mass, nf: usize, drift: f64, limits: Limits) -> Self {
        let nv = mass.diagonal.len();
        Self {
            mass,
            acceleration: Waves::new(rng, nv, 1, 0.0, 1.0),
            forces: Waves::new(rng, nf, 1, 0.0, 0.35),
            torques: Waves::new(rng, nv, 1, 0.0, 0.35),
            deviation: Waves::new(rng, nv, 1, 0.0, 1.0),
            point: Waves::new(rng, 3, nv, 0.25, drift),
            asked: Wave::new(rng, 1.0),
            limits,
        }
    }

    /// The problem at a time, s.
    fn problem(&self, time: f64, feet: &Feet, demand: Demand) -> Qp {
        let (nv, nf) = (self.mass.diagonal.len(), feet.contact.nrows());
        let mass = self.mass.at(time);
        let acceleration = self.acceleration.vector(time);
        let force = self.force(time, nf);
        let mut torque = self.torques.vector(time) * self.limits.largest_torque;
        torque.rows_mut(0, 6).fill(0.0);
        let bias = &torque + feet.contact.transpose() * &force - &mass * &acceleration;

        let mut h = DMatrix::zeros(nv + nf, nv + nf);
        let mut g = DVector::zeros(nv + nf);
        let deviation = self.deviation.vector(time) * demand.at(&self.asked, time);
        for i in 0..nv {
            let (weight, scale) = match i {
                0..3 => (10.0, 5.0),
                3..6 => (5.0, 5.0),
                _ => (0.1, 40.0),
            };
            h[(i, i)] = weight + 1e-5;
            g[i] = -weight * (acceleration[i] + scale * deviation[i]);
        }
        let weight = self.limits.force_weight;
        for i in 0..nf {
            h[(nv + i, nv + i)] = weight;
            g[nv + i] = -weight * force[i];
        }
        // Couples all accelerations that move the point.
        for (axis, row) in self.point.at(time).row_iter().enumerate() {
            let row = DVector::from_fn(nv + nf, |j, _| match j {
                0..3 => f64::from(u8::from(j == axis)),
                j if self.limits.moving.contains(&j) => row[j],
                _ => 0.0,
            });
            let wanted = row.rows(0, nv).dot(&acceleration) + 5.0 * deviation[axis];
            h += 4.0 * &row * row.transpose();
            g -= 4.0 * wanted * row;
        }

        let rows = 6 + feet.motion.nrows() + 5 * (nf / 3) + nv - 6;
        let mut qp = problem(nv + nf, rows);
        set_cost(&mut qp, &h, &g);
        self.constrain(&mut qp, feet, &mass, [&bias, &acceleration]);
        qp
    }

    fn force(&self, time: f64, nf: usize) -> DVector<f64> {
        let shape = self.forces.vector(time);
        DVector::from_fn(nf, |i, _| {
            let normal = self.limits.mean_normal * (1.0 + 0.5 * shape[i - i % 3 + 2]);
            if i % 3 == 2 {
                normal
            } else {
                self.limits.sideways * normal * shape[i]
            }
        })
    }

    /// Dynamics of the base and feet at rest as equalities; friction and torque limits.
    fn constrain(
        &self,
        qp: &mut Qp,
        feet: &Feet,
        mass: &DMatrix<f64>,
        [bias, acceleration]: [&DVector<f64>; 2],
    ) {
        let (nv, nf) = (mass.nrows(), feet.contact.nrows());
        let dynamics = |i: usize| {
            let forces = feet.contact.column(i).into_owned();
            let row = mass.row(i).transpose();
            (0..nv + nf).map(move |j| if j < nv { row[j] } else { -forces[j - nv] })
        };
        for i in 0..6 {
            push(qp, dynamics(i), -bias[i], -bias[i]);
        }
        let at_rest = &feet.motion * acceleration;
        for (row, at_rest) in feet.motion.row_iter().zip(&at_rest) {
            let row = row.iter().copied().chain(std::iter::repeat_n(0.0, nf));
            push(qp, row, *at_rest, *at_rest);
        }
        let Limits {
            friction,
            mean_normal,
            largest_torque,
            ..
        } = self.limits;
        for point in 0..nf / 3 {
            push_friction(qp, nv + 3 * point, friction, 0.05 * mean_normal);
        }
        for i in 6..nv {
            let (lower, upper) = (-largest_torque - bias[i], largest_torque - bias[i]);
            push(qp, dynamics(i), lower, upper);
        }
    }
}

/// A quadruped on four point feet without its torques: 30 variables (18 accelerations, 12 components of four forces),
/// 18 equalities (the base's dynamics, the feet at rest), 32 rows (friction, torque limits).
pub fn quadruped(ticks: usize, demand: Demand) -> Vec<Qp> {
    let rng = &mut ChaCha8Rng::seed_from_u64(1);
    let (nv, nf) = (18, 12);
    let mass = Mass {
        diagonal: DVector::from_fn(nv, |i, _| match i {
            0..3 => 12.0,
            3..6 => 0.3,
            _ => 0.03 * rng.random_range(0.3..1.5),
        }),
        coupling: Waves::new(rng, nv, nv, 0.0, 0.04),
        coupled: |low, high| high >= 3 && (low < 6 || (low - 6) / 3 == (high - 6) / 3),
    };
    let legs = Waves::new(rng, nf, 3, 0.2, 0.05);
    let limits = Limits {
        mean_normal: 30.0,
        largest_torque: 6.0,
        friction: 0.5,
        sideways: 0.35,
        force_weight: 1e-4,
        // The centre of mass.
        moving: 3..nv,
    };
    let standing = Standing::new(rng, mass, nf, 0.05, limits);

    let tick = |k: usize| {
        let time = k as f64 * PERIOD;
        let legs = legs.at(time);
        let mut contact = DMatrix::zeros(nf, nv);
        for foot in 0..4 {
            let x = if foot < 2 { 0.19 } else { -0.19 };
            let y = if foot % 2 == 0 { 0.15 } else { -0.15 };
            let arm: Matrix3<f64> = -Vector3::new(x, y, -0.24).cross_matrix();
            let at = 3 * foot;
            contact.view_mut((at, 0), (3, 3)).fill_with_identity();
            contact.view_mut((at, 3), (3, 3)).copy_from(&arm);
            let own = legs.rows(at, 3) + Matrix3::from_diagonal_element(0.2);
            contact.view_mut((at, 6 + at), (3, 3)).copy_from(&own);
        }
        let motion = contact.clone();
        standing.problem(time, &Feet { contact, motion }, demand)
    };
    (0..ticks).map(tick).collect()
}

/// The humanoid's base, left leg, right leg or upper body.
fn part(i: usize) -> usize {
    match i {
        0..6 => 0,
        6..12 => 1,
        12..18 => 2,
        _ => 3,
    }
}

/// A humanoid on two feet without its torques: 60 variables (36 accelerations, 24 components of eight point forces), 18
/// equalities (the base's dynamics, both feet at rest), 70 rows (friction, torque limits).
pub fn humanoid(ticks: usize, demand: Demand) -> Vec<Qp> {
    let rng = &mut ChaCha8Rng::seed_from_u64(1);
    let (nv, points) = (36, 8);
    let nf = 3 * points;
    let mass = Mass {
        diagonal: DVector::from_fn(nv, |i, _| match i {
            0..3 => 60.0,
            3..6 => 3.0,
            _ => 0.3 * rng.random_range(0.3..1.5),
        }),
        coupling: Waves::new(rng, nv, nv, 0.0, 0.04),
        coupled: |low, high| {
            let translations = high < 3;
            (low < 6 || part(low) == part(high)) && !translations
        },
    };
    let feet = [1, 2].map(|leg| (leg, Waves::new(rng, 6, nv, 0.4, 0.1)));
    let limits = Limits {
        mean_normal: 75.0,
        largest_torque: 60.0,
        friction: 0.42,
        sideways: 0.3,
        force_weight: 1e-5,
        // A hand.
        moving: 18..nv,
    };
    let standing = Standing::new(rng, mass, nf, 0.0, limits);

    let tick = |k: usize| {
        let time = k as f64 * PERIOD;
        let mut motion = DMatrix::zeros(12, nv);
        let mut contact = DMatrix::zeros(nf, nv);
        for (foot, (leg, waves)) in feet.iter().enumerate() {
            let mut jacobian = waves.at(time);
            for j in 0..nv {
                match (j, part(j)) {
                    (0..3, _) => jacobian.column_mut(j).fill(0.0),
                    (3..6, _) => jacobian.view_mut((3, j), (3, 1)).fill(0.0),
                    (_, p) if p != *leg => jacobian.column_mut(j).fill(0.0),
                    _ => {}
                }
                if j < 6 {
                    jacobian[(j, j)] = 1.0;
                }
            }
            for corner in 0..4 {
                let x = if corner % 2 == 0 { 0.09 } else { -0.07 };
                let y = if corner < 2 { 0.05 } else { -0.05 };
                let arm: Matrix3<f64> = -Vector3::new(x, y, 0.0).cross_matrix();
                let point = jacobian.rows(0, 3) + arm * jacobian.rows(3, 3);
                let at = 3 * (4 * foot + corner);
                contact.rows_mut(at, 3).copy_from(&point);
            }
            motion.rows_mut(6 * foot, 6).copy_from(&jacobian);
        }
        standing.problem(time, &Feet { contact, motion }, demand)
    };
    (0..ticks).map(tick).collect()
}

/// Dense problems without any structure, all of whose numbers drift: a definite cost, equalities, rows with two limits.
/// The more is asked for, the more limits are active; with `Demand::Steady` their number varies least.
pub fn drifting(
    ticks: usize,
    variables: usize,
    equalities: usize,
    rows: usize,
    demand: Demand,
) -> Vec<Qp> {
    let rng = &mut ChaCha8Rng::seed_from_u64(1);
    let root = Waves::new(rng, variables, variables, 1.0, 0.1);
    let coefficients = Waves::new(rng, equalities + rows, variables, 1.0, 0.1);
    let point = Waves::new(rng, variables, 1, 0.0, 1.0);
    let deviation = Waves::new(rng, variables, 1, 1.0, 0.3);
    let margins = Waves::new(rng, rows, 2, 0.0, 0.3);
    let asked = Wave::new(rng, 1.0);

    let tick = |k: usize| {
        let time = k as f64 * PERIOD;
        let (root, a) = (root.at(time), coefficients.at(time));
        let (point, margins) = (point.vector(time), margins.at(time));
        let mut h = &root * root.transpose() / variables as f64;
        for i in 0..variables {
            h[(i, i)] += 0.1;
        }
        let wanted = &point + deviation.vector(time) * demand.at(&asked, time);
        let g = -(&h * wanted);
        let mut qp = problem(variables, equalities + rows);
        set_cost(&mut qp, &h, &g);
        // Limits lie on both sides of what a point that is feasible has.
        for (i, row) in a.row_iter().enumerate() {
            let value = row.transpose().dot(&point);
            let below_and_above = match i.checked_sub(equalities) {
                None => [0.0, 0.0],
                Some(j) => [margins[(j, 0)], margins[(j, 1)]].map(|margin| 1.0 + margin),
            };
            let [below, above] = below_and_above;
            push(&mut qp, row.iter().copied(), value - below, value + above);
        }
        qp
    };
    (0..ticks).map(tick).collect()
}
