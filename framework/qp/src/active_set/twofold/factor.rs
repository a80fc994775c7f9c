//! The factorisation of the constraints held, in the metric of H.
//!
//! # Mathematics
//! `Jᵀ H J = 1`, and `Jᵀ N = [R; 0]` with a triangle R for the normals N held. A constraint that comes turns the
//! columns of J by a reflection, one that goes by rotations (Goldfarb and Idnani 1983). With `d = Jᵀ a`, the step of x
//! towards a constraint with the normal a that leaves those held where they are is along `z = J₂ d₂`, and a combines
//! from their normals with `r = R⁻¹ d₁`.

use super::number::{Twofold, dot, dot_with};

#[derive(Clone, Debug)]
pub(super) struct Factor {
    n: usize,
    /// Constraints held.
    held: usize,
    /// J, one column of n numbers after the other.
    j: Vec<Twofold>,
    /// The columns of R, one after the other with a stride of n.
    r: Vec<Twofold>,
    /// `Jᵀ a`.
    d: Vec<Twofold>,
    /// `R⁻¹ d₁`.
    combination: Vec<Twofold>,
    /// `J₂ v` of a reflection.
    along: Vec<Twofold>,
}

impl Factor {
    pub(super) fn new(n: usize) -> Self {
        Self {
            n: 0,
            held: 0,
            j: vec![Twofold::ZERO; n * n],
            r: vec![Twofold::ZERO; n * n],
            d: vec![Twofold::ZERO; n],
            combination: vec![Twofold::ZERO; n],
            along: vec![Twofold::ZERO; n],
        }
    }

    /// Nothing held; `J = L⁻ᵀ` with `H + ρ = L Lᵀ`. False if a pivot is below a part of its diagonal entry.
    pub(super) fn reset(&mut self, n: usize, (h, rho): (&[f64], f64), weak: f64) -> bool {
        (self.n, self.held) = (n, 0);
        // L in the place of R.
        for i in 0..n {
            for k in 0..=i {
                let entry = Twofold::new(h[i * n + k]);
                let diagonal = if i == k { rho } else { 0.0 };
                let (above, below) = self.r.split_at_mut(i * n);
                let row_k = if k == i {
                    &below[..k]
                } else {
                    &above[k * n..k * n + k]
                };
                let rest = entry + Twofold::new(diagonal) - dot(row_k, &below[..k]);
                if k < i {
                    below[k] = rest / above[k * n + k];
                } else if rest.rounded() > weak * (h[i * n + i] + rho) {
                    below[k] = rest.sqrt();
                } else {
                    return false;
                }
            }
        }
        self.j[..n * n].fill(Twofold::ZERO);
        for i in 0..n {
            let column = &mut self.j[i * n..(i + 1) * n];
            column[i] = Twofold::new(1.0) / self.r[i * n + i];
            for k in (0..i).rev() {
                let mut sum = Twofold::ZERO;
                for (l, j) in column[..=i].iter().enumerate().skip(k + 1) {
                    sum += self.r[l * n + k] * *j;
                }
                column[k] = -sum / self.r[k * n + k];
            }
        }
        true
    }

    /// `x = −J Jᵀ g`, the minimiser without constraints.
    pub(super) fn minimise(&mut self, g: &[Twofold], x: &mut [Twofold]) {
        let n = self.n;
        x.fill(Twofold::ZERO);
        for column in self.j[..n * n].chunks_exact(n) {
            let along = dot(column, g);
            for (x, j) in x.iter_mut().zip(column) {
                *x -= along * *j;
            }
        }
    }

    /// Looks at a constraint: `d` and `r`. Returns `‖d₂‖²`.
    pub(super) fn look(&mut self, normal: &[f64]) -> Twofold {
        let (n, q) = (self.n, self.held);
        for (d, column) in self.d.iter_mut().zip(self.j[..n * n].chunks_exact(n)) {
            *d = dot_with(normal, column);
        }
        let r = &mut self.combination[..q];
        for i in (0..q).rev() {
            let mut sum = self.d[i];
            for (l, r) in r.iter().enumerate().skip(i + 1) {
                sum -= self.r[l * n + i] * *r;
            }
            r[i] = sum / self.r[i * n + i];
        }
        let free = &self.d[q..n];
        dot(free, free)
    }

    /// The multipliers `λ = −R⁻¹ w` of the minimiser on those held, which is `x₀ + J₁ w` with `Rᵀ w = b − Nᵀ x₀`, from
    /// that without constraints and what their values lack there.
    pub(super) fn balance(&mut self, excess: &[Twofold], multipliers: &mut [Twofold]) {
        let n = self.n;
        for (i, excess) in excess.iter().enumerate() {
            let mut sum = *excess;
            for (r, w) in self.r[i * n..].iter().zip(&self.d[..i]) {
                sum -= *r * *w;
            }
            self.d[i] = sum / self.r[i * n + i];
        }
        for i in (0..excess.len()).rev() {
            let mut sum = -self.d[i];
            for (l, m) in multipliers.iter().enumerate().skip(i + 1) {
                sum -= self.r[l * n + i] * *m;
            }
            multipliers[i] = sum / self.r[i * n + i];
        }
    }

    /// `x += J₁ w`, of the balance before.
    pub(super) fn approach(&self, x: &mut [Twofold]) {
        let n = self.n;
        let columns = self.j[..n * n].chunks_exact(n).zip(&self.d);
        for (column, w) in columns.take(self.held) {
            for (x, j) in x.iter_mut().zip(column) {
                *x += *w * *j;
            }
        }
    }

    /// How the constraint looked at combines from those held.
    pub(super) fn combination(&self) -> &[Twofold] {
        &self.combination[..self.held]
    }

    /// `x += α z`.
    pub(super) fn step(&self, alpha: Twofold, x: &mut [Twofold]) {
        let (n, q) = (self.n, self.held);
        let columns = self.j[..n * n].chunks_exact(n).zip(&self.d);
        for (column, d) in columns.skip(q) {
            let along = alpha * *d;
            for (x, j) in x.iter_mut().zip(column) {
                *x += along * *j;
            }
        }
    }

    /// Holds the constraint looked at: a reflection turns `d₂` to its first axis.
    pub(super) fn push(&mut self) {
        let (n, q) = (self.n, self.held);
        let d = &mut self.d[q..n];
        if d[1..].iter().any(|d| d.rounded() != 0.0) {
            let size = dot(d, d).sqrt();
            let size = if d[0].rounded() > 0.0 { size } else { -size };
            // Along d₂ + size e₁, the normal v of the mirror: the sum does not cancel.
            d[0] += size;
            let part = Twofold::new(1.0) / (size * d[0]);
            let free = &mut self.j[q * n..n * n];
            let along = &mut self.along[..n];
            along.fill(Twofold::ZERO);
            for (column, v) in free.chunks_exact(n).zip(&*d) {
                for (along, j) in along.iter_mut().zip(column) {
                    *along += *v * *j;
                }
            }
            for (column, v) in free.chunks_exact_mut(n).zip(&*d) {
                let v = *v * part;
                for (j, along) in column.iter_mut().zip(&*along) {
                    *j -= v * *along;
                }
            }
            d.fill(Twofold::ZERO);
            d[0] = -size;
        }
        self.r[q * n..][..=q].copy_from_slice(&self.d[..=q]);
        self.held = q + 1;
    }

    /// Lets the l-th constraint held go.
    pub(super) fn remove(&mut self, l: usize) {
        let (n, q) = (self.n, self.held);
        self.r.copy_within((l + 1) * n..q * n, l * n);
        self.held = q - 1;
        for k in l..q - 1 {
            let column = &self.r[k * n..];
            let (c, s, size) = rotation(column[k], column[k + 1]);
            (self.r[k * n + k], self.r[k * n + k + 1]) = (size, Twofold::ZERO);
            for column in self.r.chunks_exact_mut(n).take(q - 1).skip(k + 1) {
                let (a, b) = (column[k], column[k + 1]);
                (column[k], column[k + 1]) = (c * a + s * b, c * b - s * a);
            }
            self.turn(k, c, s);
        }
    }

    /// Turns two columns of J that follow one another.
    fn turn(&mut self, k: usize, c: Twofold, s: Twofold) {
        let n = self.n;
        let (a, b) = self.j[k * n..(k + 2) * n].split_at_mut(n);
        for (a, b) in a.iter_mut().zip(b) {
            (*a, *b) = (c * *a + s * *b, c * *b - s * *a);
        }
    }
}

/// Cosine and sine that turn (a, b) to (size, 0), and the size.
fn rotation(a: Twofold, b: Twofold) -> (Twofold, Twofold, Twofold) {
    if b.rounded() == 0.0 {
        return (Twofold::new(1.0), Twofold::ZERO, a);
    }
    let size = (a * a + b * b).sqrt();
    (a / size, b / size, size)
}
