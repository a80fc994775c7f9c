//! What each weight and gain does, in numbers that can be compared with one another.

use super::{Parameter, ParameterKind, Sensitivity};

/// What is smaller than this share of what moves most is rounding: a force that a limit holds, for example.
const ROUNDING: f64 = 1e-10;

/// What a weight or a gain does to the optimum of a tick, all rows or elements of it changing by the same factor.
#[derive(Clone, Debug, PartialEq)]
pub struct Effect {
    /// [`ParameterKind::Weight`] or [`ParameterKind::Gain`].
    pub kind: ParameterKind,
    /// The task or constraint that has it.
    pub owner: String,
    /// `weight`, or the key: `kp`.
    pub key: String,
    /// `‖∂u/∂ ln p‖`: a parameter that is 1 % larger moves the efforts by a hundredth of that, N and N·m.
    pub effort: f64,
    /// The output that moves most among accelerations, efforts and forces: its position among
    /// [`Sensitivity::outputs`], and its derivative by ln p in its own unit. Nothing where none of them moves by more
    /// than rounding.
    pub strongest: [Option<(usize, f64)>; 3],
}

impl Sensitivity {
    /// What each weight and each gain does, those that move the efforts most first; those that move nothing come last.
    /// Empty before the first tick. Allocates.
    pub fn effects(&self) -> Vec<Effect> {
        if self.time().is_none() {
            return Vec::new();
        }
        let mut effects: Vec<Effect> = Vec::new();
        let mut sums: Vec<Vec<f64>> = Vec::new();
        for (j, parameter) in self.parameters().iter().enumerate() {
            if !matches!(parameter.kind, ParameterKind::Weight | ParameterKind::Gain) {
                continue;
            }
            let key = key(parameter);
            let is_it =
                |e: &Effect| e.kind == parameter.kind && e.owner == parameter.owner && e.key == key;
            let index = effects.iter().position(is_it).unwrap_or_else(|| {
                effects.push(Effect {
                    kind: parameter.kind,
                    owner: parameter.owner.clone(),
                    key: key.to_owned(),
                    effort: 0.0,
                    strongest: [None; 3],
                });
                sums.push(vec![0.0; self.outputs().len()]);
                effects.len() - 1
            });
            for (sum, slope) in sums[index].iter_mut().zip(&self.derivatives().column(j)) {
                *sum += parameter.value * slope;
            }
        }
        let (nv, nu) = (self.vdot().nrows(), self.effort().nrows());
        for (effect, sum) in effects.iter_mut().zip(&sums) {
            let squares = sum[nv..nv + nu].iter().map(|x| x * x);
            effect.effort = squares.sum::<f64>().sqrt();
            let blocks = [0..nv, nv..nv + nu, nv + nu..sum.len()];
            let largest = sum.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
            effect.strongest = blocks.map(|block| {
                let numbers = block
                    .map(|i| (i, sum[i]))
                    .filter(|(_, x)| x.abs() > ROUNDING * largest);
                numbers.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))
            });
        }
        effects.sort_by(|a, b| b.effort.total_cmp(&a.effort));
        effects
    }

    /// The first of [`Sensitivity::effects`], `most` of them, without those that move the efforts by rounding beside
    /// the first: where limits hold everything, that is all that the others do. Allocates.
    pub fn strongest_effects(&self, most: usize) -> Vec<Effect> {
        let mut effects = self.effects();
        let least = effects.first().map_or(0.0, |first| ROUNDING * first.effort);
        effects.retain(|effect| effect.effort > least);
        effects.truncate(most);
        effects
    }
}

/// The label without the row or the index.
pub(super) fn key(parameter: &Parameter) -> &str {
    let label = parameter.label.as_str();
    let list = label.strip_suffix(']').and_then(|l| l.rsplit_once('['));
    list.map_or(label, |(key, _)| key)
}
