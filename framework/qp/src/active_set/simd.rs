//! Code that is compiled twice: portable, and with the vector instructions that most machines have.

/// The vector instructions that a solver found when it was made: on x86-64 those of AVX2, with four numbers to a
/// vector, or none beyond the portable ones. As sums are added up in an order that the code fixes (`kernels`) and
/// nothing is fused, both give the same bits.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Simd(#[cfg(all(target_arch = "x86_64", feature = "simd"))] Option<Wide>);

/// Vector instructions that code is compiled for, where it is not compiled for all.
pub(super) trait Vectors: Copy {
    /// Calls a closure with these instructions: the part of `with_simd!` that is not syntax.
    fn run<T>(self, f: impl FnOnce() -> T) -> T;
}

/// Those that every machine of its architecture has.
#[derive(Clone, Copy, Debug)]
pub(super) struct Portable;

impl Vectors for Portable {
    #[inline(always)]
    fn run<T>(self, f: impl FnOnce() -> T) -> T {
        f()
    }
}

/// The value of an expression, computed with the instructions of a [`Simd`] or of [`Vectors`]. They reach what is
/// inlined into it and nothing else: functions that it calls have to be `#[inline(always)]`, as far as that matters.
macro_rules! with_simd {
    ($simd:expr, $value:expr) => {
        $simd.run(
            #[inline(always)]
            || $value,
        )
    };
}
pub(super) use with_simd;

/// Those that most machines have.
#[cfg(all(target_arch = "x86_64", feature = "simd"))]
#[derive(Clone, Copy, Debug)]
pub(super) struct Wide(pulp::x86::V3);

/// Those that most machines have: the portable ones, which have the width of their vectors, or nothing else was asked
/// for.
#[cfg(not(all(target_arch = "x86_64", feature = "simd")))]
pub(super) type Wide = Portable;

#[cfg(all(target_arch = "x86_64", feature = "simd"))]
impl Vectors for Wide {
    #[inline(always)]
    fn run<T>(self, f: impl FnOnce() -> T) -> T {
        struct Op<F>(F);
        impl<T, F: FnOnce() -> T> pulp::NullaryFnOnce for Op<F> {
            type Output = T;

            #[inline(always)]
            fn call(self) -> T {
                (self.0)()
            }
        }
        self.0.vectorize(Op(f))
    }
}

#[cfg(all(target_arch = "x86_64", feature = "simd"))]
impl Simd {
    /// Of this machine.
    pub(super) fn detect() -> Self {
        Self(pulp::x86::V3::try_new().map(Wide))
    }

    /// What most machines have, if this one has it.
    #[inline(always)]
    pub(super) fn wide(self) -> Option<Wide> {
        self.0
    }
}

#[cfg(not(all(target_arch = "x86_64", feature = "simd")))]
impl Simd {
    /// Of this machine.
    pub(super) fn detect() -> Self {
        Self()
    }

    /// What most machines have.
    #[inline(always)]
    pub(super) fn wide(self) -> Option<Wide> {
        let Self() = self;
        Some(Portable)
    }
}

impl Simd {
    /// Calls a closure with these instructions: the part of `with_simd!` that is not syntax.
    #[inline(always)]
    pub(super) fn run<T>(self, f: impl FnOnce() -> T) -> T {
        match self.wide() {
            Some(wide) => wide.run(f),
            None => f(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Simd;
    use crate::{
        Qp, Solution, Status,
        active_set::{limits::Limits, working_set::Factorisation, workspace::Workspace},
    };

    /// As good as random, between −1 and 1.
    fn wave(i: usize) -> f64 {
        ((i as f64 + 1.0) * 53.711).sin() * 4e3 % 1.0
    }

    /// A definite problem of n variables, with an equality if `seed` is odd.
    fn problem(n: usize, seed: usize) -> Qp {
        let at = |i: usize| wave(4001 * seed + 37 * n + i);
        let entry = |i: usize, j: usize| (0..n).map(|k| at(i * n + k) * at(j * n + k)).sum();
        let mut h: Vec<f64> = (0..n * n).map(|ij| entry(ij / n, ij % n)).collect();
        (0..n).for_each(|j| h[j * n + j] += 0.3);
        let g: Vec<f64> = (0..n).map(|j| 3.0 * at(7 * j + 2)).collect();
        let m = n + 3;
        let a: Vec<f64> = (0..m * n).map(|i| at(5 * i + 1)).collect();
        let (mut low, mut high) = (vec![f64::NEG_INFINITY; m], vec![0.2; m]);
        if seed % 2 == 1 {
            (low[0], high[0]) = (0.1, 0.1);
        }
        let bounds = (vec![-0.4; n], vec![f64::INFINITY; n]);
        Qp::dense(&h, &g, &a, (&low, &high), (&bounds.0, &bounds.1)).expect("the shapes fit")
    }

    /// From a cold start, and again from what was held with other numbers.
    #[test]
    fn the_width_of_vectors_changes_no_bit() {
        let mut changes = 0;
        for n in 1..=40 {
            for seed in 0..6 {
                let problems = [problem(n, seed), problem(n, seed + 2)];
                let capacity = problems[0].capacity();
                let mut found = Vec::new();
                for simd in [Simd::default(), Simd::detect()] {
                    let mut workspace = Workspace::new(capacity, simd);
                    let mut solution = Solution::new(capacity);
                    for qp in &problems {
                        let limits = Limits::new(1e-12, 10_000);
                        workspace.solve(qp, limits, Factorisation::Products, &mut solution);
                        found.push(solution.clone());
                    }
                }
                let bits =
                    |numbers: &[f64]| numbers.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
                let (portable, wide) = found.split_at(2);
                for (a, b) in portable.iter().zip(wide) {
                    assert!(
                        matches!(a.status, Status::Optimal | Status::Infeasible),
                        "{n} {seed}"
                    );
                    assert_eq!(
                        (a.status, a.iterations),
                        (b.status, b.iterations),
                        "{n} {seed}"
                    );
                    assert_eq!(bits(&a.x), bits(&b.x), "{n} {seed}");
                    assert_eq!(bits(&a.y), bits(&b.y), "{n} {seed}");
                    assert_eq!(bits(&a.z), bits(&b.z), "{n} {seed}");
                    changes += a.iterations;
                }
            }
        }
        assert!(
            changes > 2000,
            "{changes} iterations: hardly anything happens"
        );
    }
}
