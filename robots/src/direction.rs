//! The direction of a vector of any length.

use wbqp::nalgebra::{Unit, Vector3};

/// Nothing if it has none: it is zero, or a number is not finite.
pub(crate) fn direction(vector: Vector3<f64>) -> Option<Unit<Vector3<f64>>> {
    let largest = vector.amax();
    let has_one = largest > 0.0 && vector.iter().all(|x| x.is_finite());
    // Scaled first: the squares of a tiny vector vanish, those of a long one overflow.
    has_one.then(|| Unit::new_normalize(vector / largest))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_finite_length_has_a_direction() {
        for length in [1e-300, 1e-10, 1.0, 1e200] {
            let found = direction(Vector3::new(0.0, -length, 0.0));
            assert_eq!(found, Some(-Vector3::y_axis()), "{length}");
        }
        for none in [0.0, f64::NAN, f64::INFINITY] {
            assert_eq!(direction(Vector3::new(none, 0.0, 0.0)), None);
        }
    }
}
