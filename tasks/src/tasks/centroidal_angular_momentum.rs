//! Angular momentum about the centre of mass.
//!
//! # Notation
//! W world, R base, G the centre of mass, `r = p_WG − p_WR`. All vectors in world axes.
#![allow(non_snake_case)]

use wbqp::{plugin::VectorReference, prelude::*};

use crate::follow::stay;

/// Controls the angular momentum of the whole robot about its centre of mass: zero keeps limbs from winding it up.
///
/// Three rows in world axes, N·m, the rate of the momentum:
///
/// `A v̇ = L̇_d − K (L_G − L_d) − Ȧ v`.
///
/// `A` is the angular part of the centroidal momentum matrix (Orin, Goswami and Lee, *Centroidal dynamics of a humanoid
/// robot*, Autonomous Robots 35, 2013). With a floating base it is read off the mass matrix: its first three
/// rows are the linear momentum and the next three the angular one about R, so `A = M_w − S(r) M_v`; likewise
/// `Ȧ v = n − r × f` with the force `f` and the moment `n` about R that the velocities alone need at the base.
///
/// The reference is a momentum, its rate `L̇_d`. Rotors that spin have no part in `L_G`. Floating base only.
///
/// Error: `L_G − L_d`, kg·m²/s.
#[wbqp::task("centroidal_angular_momentum")]
pub struct CentroidalAngularMomentum {
    /// Gain `K`, 1/s: one number, or one per world axis.
    #[wbqp(unit = "1/s")]
    pub k: PerRow,
    /// The momentum wanted: three numbers, kg·m²/s, world axes. Default: none, as in the home posture at rest.
    #[wbqp(default = stay(), unit = "kg·m²/s")]
    pub reference: Box<dyn AnyReference>,
}

impl CentroidalAngularMomentum {
    /// Takes all momentum away with this gain (1/s).
    pub fn new(k: impl Into<PerRow>) -> Self {
        Self {
            k: k.into(),
            reference: stay(),
        }
    }

    /// Follows a trajectory: momentum, kg·m²/s, world axes.
    pub fn following(mut self, reference: impl AnyReference) -> Self {
        self.reference = Box::new(reference);
        self
    }
}

impl Task for CentroidalAngularMomentum {
    type Running = VectorReference;

    fn bind(&self, setup: &mut Setup<'_>) -> Result<(Layout, VectorReference), BindError> {
        setup.base_velocities()?;
        self.k.validate("k", 3)?;
        let reference = setup.follow_from_zero("reference", &*self.reference, 3)?;
        let layout = Layout::rows([("x", "N·m"), ("y", "N·m"), ("z", "N·m")])
            .error_unit("kg·m²/s")
            .vdot_dense();
        Ok((layout, reference))
    }

    fn update(&self, reference: &mut VectorReference, tick: &Tick<'_>, rows: &mut Rows<'_>) {
        let desired = tick.vector(*reference);
        let data = tick.dynamics;
        let r = data.center_of_mass() - tick.state.p_WR;
        let mut vdot = rows.vdot();
        for (j, column) in data.mass_matrix().column_iter().enumerate() {
            let linear = Vector3::new(column[0], column[1], column[2]);
            let angular = Vector3::new(column[3], column[4], column[5]) - r.cross(&linear);
            for i in 0..3 {
                vdot[(i, j)] = angular[i];
            }
        }
        let at_base = |i: usize| data.bias()[i] - data.gravity()[i];
        let f = Vector3::new(at_base(0), at_base(1), at_base(2));
        let n = Vector3::new(at_base(3), at_base(4), at_base(5));
        let momentum = data.centroidal_momentum();
        let error = Vector3::from_fn(|i, _| momentum[3 + i]) - desired.value3();
        let bias = n - r.cross(&f);
        let wanted = desired.rate3() - self.k.times(&error);
        for k in 0..3 {
            rows.bias(k, bias[k]);
            rows.acceleration(k, wanted[k]);
        }
        rows.error().copy_from(&error);
    }

    fn remembered(&self, _: &mut Self::Running, _: &mut Remembered<'_>) {}
}
