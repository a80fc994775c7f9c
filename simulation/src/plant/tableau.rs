//! The method of Dormand and Prince, orders 5 and 4 (J. R. Dormand, P. J. Prince, "A family of embedded Runge–Kutta
//! formulae", 1980), and its value in the middle of a step, of order 4 (L. F. Shampine, "Some practical Runge–Kutta
//! formulas", 1986).
//!
//! # Mathematics
//! ```text
//! k₁ = f(x),  k_s = f(x + h Σ_j<s A_sj k_j),  k₇ = f(x⁺),  x⁺ = x + h Σ B_j k_j
//! error ≈ h Σ ERROR_j k_j,  x(t + h/2) ≈ x + h Σ MIDDLE_j k_j
//! ```

/// Stages, the derivative at the end included.
pub(super) const STAGES: usize = 7;

/// Weights of the earlier derivatives for the second stage up to the seventh, which is the step's end.
pub(super) const A: [[f64; STAGES - 1]; STAGES - 1] = [
    [1.0 / 5.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    [3.0 / 40.0, 9.0 / 40.0, 0.0, 0.0, 0.0, 0.0],
    [44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0, 0.0, 0.0, 0.0],
    [
        19372.0 / 6561.0,
        -25360.0 / 2187.0,
        64448.0 / 6561.0,
        -212.0 / 729.0,
        0.0,
        0.0,
    ],
    [
        9017.0 / 3168.0,
        -355.0 / 33.0,
        46732.0 / 5247.0,
        49.0 / 176.0,
        -5103.0 / 18656.0,
        0.0,
    ],
    [
        35.0 / 384.0,
        0.0,
        500.0 / 1113.0,
        125.0 / 192.0,
        -2187.0 / 6784.0,
        11.0 / 84.0,
    ],
];

/// Difference of the two orders.
pub(super) const ERROR: [f64; STAGES] = [
    71.0 / 57600.0,
    0.0,
    -71.0 / 16695.0,
    71.0 / 1920.0,
    -17253.0 / 339200.0,
    22.0 / 525.0,
    -1.0 / 40.0,
];

/// The middle of the step.
pub(super) const MIDDLE: [f64; STAGES] = [
    6025192743.0 / 60171106304.0,
    0.0,
    51252292925.0 / 130801643196.0,
    -2691868925.0 / 90256659968.0,
    187940372067.0 / 3189068634112.0,
    -1776094331.0 / 39487288512.0,
    11237099.0 / 470086768.0,
];

/// `out = x + h Σ weights_j k_j`, with the derivatives one after the other in `k`. Weights of zero are passed over.
pub(super) fn combine(out: &mut [f64], x: &[f64], h: f64, weights: &[f64], k: &[f64]) {
    out.copy_from_slice(x);
    for (weight, k) in weights.iter().zip(k.chunks_exact(x.len())) {
        if *weight != 0.0 {
            let weight = h * weight;
            for (out, k) in out.iter_mut().zip(k) {
                *out += weight * k;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One step of ẋ = x from 1: the end, its estimated error, the middle.
    fn exponential(h: f64) -> [f64; 3] {
        let mut k = vec![1.0];
        let mut x = [0.0];
        for weights in &A {
            combine(&mut x, &[1.0], h, &weights[..k.len()], &k);
            k.push(x[0]);
        }
        let [mut error, mut middle] = [[0.0]; 2];
        combine(&mut error, &[0.0], h, &ERROR, &k);
        combine(&mut middle, &[1.0], h, &MIDDLE, &k);
        [x[0], error[0], middle[0]]
    }

    #[test]
    fn a_step_its_error_and_its_middle_have_their_orders() {
        let errors = |h: f64| {
            let [end, error, middle] = exponential(h);
            [end - h.exp(), error, middle - (0.5 * h).exp()].map(f64::abs)
        };
        let (coarse, fine) = (errors(0.2), errors(0.1));
        let order: Vec<f64> = coarse
            .iter()
            .zip(fine)
            .map(|(c, f)| (c / f).log2())
            .collect();
        for (order, expected) in order.iter().zip([6.0, 5.0, 5.0]) {
            assert!((order - expected).abs() < 0.3, "{order} {expected}");
        }
    }
}
