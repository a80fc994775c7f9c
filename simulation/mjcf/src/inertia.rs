//! Inertias as MuJoCo takes them: along principal axes, and such that a rigid body could have them.
#![allow(non_snake_case)]

use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};
use wbqp::model::Inertia;

/// MuJoCo refuses a moving body whose mass or smallest moment is not above 1e-15; ten times that is nothing beside what
/// moves with it.
const LEAST: f64 = 1e-14;
/// A breach of the triangle inequality up to this fraction of the largest moment is a rounding.
const ROUNDING: f64 = 1e-9;

/// Mass, centre of mass and principal axes of a body.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Principal {
    /// kg.
    pub(crate) mass: f64,
    /// m, body axes.
    pub(crate) com: Vector3<f64>,
    /// From the principal axes to the body's.
    pub(crate) rotation: UnitQuaternion<f64>,
    /// kg·m².
    pub(crate) moments: Vector3<f64>,
    /// What had to be changed, in words.
    pub(crate) changed: Option<String>,
}

impl Principal {
    pub(crate) fn of(inertia: &Inertia) -> Self {
        let I = inertia.I_BBcm();
        let eigen = ((I + I.transpose()) * 0.5).symmetric_eigen();
        let mut axes: Matrix3<f64> = eigen.eigenvectors;
        if axes.determinant() < 0.0 {
            axes.column_mut(2).neg_mut();
        }
        let rotation =
            UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes));
        let mut moments = eigen.eigenvalues;
        let changed = physical(&mut moments).map(|moved| {
            format!(
                "moments of inertia that no rigid body has were moved by up to {moved:.1e} kg·m²"
            )
        });
        let (mass, changed) = if inertia.mass > LEAST {
            (inertia.mass, changed)
        } else {
            let what = "it moves and has no mass: MuJoCo needs some, it got 1e-14 kg";
            (LEAST, Some(what.to_owned()))
        };
        Self {
            mass,
            com: inertia.com(),
            rotation,
            moments,
            changed,
        }
    }
}

/// Moves moments as little as it takes for a rigid body to have them; says by how much if that is more than rounding.
fn physical(moments: &mut Vector3<f64>) -> Option<f64> {
    let given = *moments;
    for moment in moments.iter_mut() {
        *moment = moment.max(LEAST);
    }
    let largest = moments.imax();
    let (a, b) = ((largest + 1) % 3, (largest + 2) % 3);
    let missing = moments[largest] - moments[a] - moments[b];
    if missing >= 0.0 {
        // A little more, so that the sum still holds after the rounding of the file's reader.
        let half = 0.5 * missing + 1e-14 * moments[largest];
        moments[a] += half;
        moments[b] += half;
    }
    let moved = (*moments - given).abs().max();
    (moved > ROUNDING * moments[largest] && moved > LEAST).then_some(moved)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn principal_axes_give_the_inertia_back() {
        let I = Matrix3::new(3.0, 0.2, -0.1, 0.2, 2.0, 0.3, -0.1, 0.3, 2.5);
        let body = Inertia::from_com(2.0, Vector3::new(0.1, -0.2, 0.3), I);
        let found = Principal::of(&body);
        let R = found.rotation.to_rotation_matrix();
        let back = R.matrix() * Matrix3::from_diagonal(&found.moments) * R.matrix().transpose();
        assert!((back - I).abs().max() < 1e-14, "{back}");
        assert!(R.matrix().determinant() > 0.0);
        assert_eq!(found.changed, None);
    }

    #[test]
    fn a_lamina_stays_within_rounding_and_what_is_no_body_is_told() {
        let lamina = Inertia::from_com(
            1.0,
            Vector3::zeros(),
            Matrix3::from_diagonal(&Vector3::new(1.0, 2.0, 3.0)),
        );
        let found = Principal::of(&lamina);
        let m = found.moments;
        assert!(m.sum() - m.max() > m.max() && found.changed.is_none());
        let none = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, 3.0));
        let found = Principal::of(&Inertia::from_com(1.0, Vector3::zeros(), none));
        assert!(found.changed.is_some_and(|what| what.contains("5.0e-1")));
    }
}
