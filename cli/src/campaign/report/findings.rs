//! What the lines of a variant say: shares, quantiles, reasons, effects, and the worst runs.
//!
//! A column is read when it is wanted and forgotten again; what stays is a few bytes per line and factor.

use std::cmp::Ordering;

use anyhow::Result;
use wbqp_campaign::{Column, Gaps};

use super::{
    lines::Part,
    reasons::Reasons,
    statistics::{Groups, Share, quantiles},
};

/// How runs end.
pub(super) const ENDS: [&str; 4] = ["completed", "diverged", "refused", "failed"];
/// The end of a run that was never simulated: it is in no share and no effect.
pub(super) const REFUSED: usize = 2;
/// Runs that are listed as the worst.
const WORST: usize = 10;
/// Groups of a factor's values.
const GROUPS: u8 = 5;
/// Groups of each of the two factors of a map.
const CELLS: u8 = 6;

/// What a variant's lines say.
#[derive(Debug)]
pub(super) struct Findings {
    pub(super) variant: String,
    /// Of those that were simulated.
    pub(super) holds: Share,
    /// How many ended how, in the order of [`ENDS`].
    pub(super) ended: [usize; 4],
    /// By measure.
    pub(super) measures: Vec<Measured>,
    pub(super) reasons: Reasons,
    /// The strongest first; empty if all runs hold.
    pub(super) effects: Vec<Effect>,
    /// How far apart the best and the worst group of each effect are in the share with which a measure holds, measure
    /// by measure.
    pub(super) by_measure: Vec<(String, Vec<f64>)>,
    pub(super) map: Option<Map>,
    pub(super) worst: Vec<WorstRun>,
    /// Number of the worst run that reached its end.
    pub(super) worst_completed: Option<i64>,
}

/// A measure's values.
#[derive(Debug)]
pub(super) struct Measured {
    /// Nothing if it is not judged.
    pub(super) holds: Option<Share>,
    /// 5 %, median, 95 %.
    pub(super) quantiles: [Option<f64>; 3],
    /// How many simulated runs have none.
    pub(super) without: usize,
    /// The smallest share of its window that a value is of, if it may be of less than all.
    pub(super) least_covered: Option<f64>,
}

/// The share that holds over groups of a factor's values.
#[derive(Debug)]
pub(super) struct Effect {
    /// Which factor.
    pub(super) factor: usize,
    /// Lowest and highest value, and the share.
    pub(super) groups: Vec<(f64, f64, Share)>,
}

impl Effect {
    /// Difference between the best and the worst group.
    pub(super) fn size(&self) -> f64 {
        let shares: Vec<Share> = self.groups.iter().map(|(_, _, share)| *share).collect();
        spread(&shares)
    }
}

/// The share that holds over two factors.
#[derive(Debug)]
pub(super) struct Map {
    /// Groups of the factor across.
    pub(super) columns: Vec<(f64, f64)>,
    /// Groups of the factor upwards.
    pub(super) rows: Vec<(f64, f64)>,
    /// Row by row.
    pub(super) cells: Vec<Vec<Share>>,
}

/// One of the runs that miss most.
#[derive(Debug)]
pub(super) struct WorstRun {
    pub(super) run: i64,
    pub(super) completed: bool,
    pub(super) reason: Option<String>,
    /// Measures that count and do not hold, with their values; not a number where there is none.
    pub(super) missed: Vec<(String, f64)>,
    /// By factor; what is not a number was the scenario's own.
    pub(super) factors: Vec<f64>,
    /// Among the variant's lines.
    pub(super) position: usize,
}

impl Findings {
    pub(super) fn of(part: &Part<'_>, factors: &[String], columns: &[Column]) -> Result<Self> {
        let holds: Vec<bool> = truths(part, "holds")?.collect();
        let mut ended = [0; 4];
        let mut ends = Vec::with_capacity(part.count);
        part.texts("status", |_, status| {
            let end = ENDS.iter().position(|end| Some(*end) == status);
            if let Some(end) = end {
                ended[end] += 1;
            }
            ends.push(end.map_or(u8::MAX, |end| end as u8));
        })?;
        let is_simulated = |position: usize| usize::from(ends[position]) != REFUSED;
        let mut misses = Misses {
            missed: vec![0; part.count],
            excess: vec![0.0; part.count],
        };
        let measures = columns.iter().map(|column| {
            let simulated = part.count - ended[REFUSED];
            misses.measured(part, column, simulated, &is_simulated)
        });
        let measures: Vec<Measured> = measures.collect::<Result<_>>()?;
        let Misses { missed, excess } = misses;
        let worse = |position: usize| Badness {
            completed: ends[position] == 0,
            missed: missed[position],
            excess: excess[position],
            position,
        };
        let failed = |position: &usize| !holds[*position] && is_simulated(*position);
        let mut worst = worst((0..part.count).filter(failed), worse);
        let worst_completed = worst_completed(part, &holds, &ends, worse)?;
        drop((missed, excess));
        let reasons = Reasons::of(part, &ends, &mut worst)?;
        let share = Share::of_all(of_simulated(&holds, &is_simulated));
        let is_perfect = share.count == share.of;
        let mut effects: Vec<(Effect, Groups)> = Vec::new();
        for (factor, name) in factors.iter().enumerate() {
            let mut numbers = part.numbers(&format!("factor.{name}"))?;
            for run in &mut worst {
                run.factors.extend(numbers.get(run.position));
            }
            if is_perfect {
                continue;
            }
            leave_out_refused(&mut numbers, &is_simulated);
            let groups = Groups::new(&numbers, GROUPS);
            if groups.ranges.len() > 1 {
                let shares = groups.shares(holds.iter().copied());
                let both = groups.ranges.iter().zip(shares);
                let both = both.map(|((low, high), share)| (*low, *high, share));
                let effect = Effect {
                    factor,
                    groups: both.collect(),
                };
                effects.push((effect, groups));
            }
        }
        effects.sort_by(|(a, _), (b, _)| b.size().total_cmp(&a.size()));
        let mut by_measure = Vec::new();
        for (column, measured) in columns.iter().zip(&measures) {
            let is_missed = measured.holds.is_some_and(|share| share.count < share.of);
            if column.counts && is_missed {
                let spreads = spreads(part, column, &effects, &mut worst)?;
                by_measure.push((column.name.clone(), spreads));
            }
        }
        let effects: Vec<Effect> = effects.into_iter().map(|(effect, _)| effect).collect();
        let map = match effects.as_slice() {
            [across, up, ..] => {
                let groups = |effect: &Effect| {
                    let name = &factors[effect.factor];
                    let mut numbers = part.numbers(&format!("factor.{name}"))?;
                    leave_out_refused(&mut numbers, &is_simulated);
                    anyhow::Ok(Groups::new(&numbers, CELLS))
                };
                Some(Map::of(&groups(across)?, &groups(up)?, &holds))
            }
            _ => None,
        };
        Ok(Self {
            variant: part.name().to_owned(),
            holds: share,
            ended,
            measures,
            reasons,
            effects,
            by_measure,
            map,
            worst,
            worst_completed,
        })
    }
}

/// How badly each line misses, over all measures.
struct Misses {
    /// How many measures do not hold.
    missed: Vec<u16>,
    excess: Vec<f32>,
}

impl Misses {
    /// What a measure says of a variant's lines; counts what each misses.
    fn measured(
        &mut self,
        part: &Part<'_>,
        column: &Column,
        simulated: usize,
        is_simulated: &impl Fn(usize) -> bool,
    ) -> Result<Measured> {
        let numbers = part.numbers(&format!("measure.{}", column.name))?;
        let values = numbers.iter().filter(|number| !number.is_nan()).count();
        let quantiles = quantiles(numbers, [0.05, 0.5, 0.95]);
        let mut least_covered = None;
        if column.gaps != Gaps::NoValue {
            let covered = part.numbers(&format!("covered.{}", column.name))?;
            least_covered = covered.into_iter().reduce(f64::min);
        }
        let mut holds = None;
        if column.is_judged {
            let verdicts: Vec<bool> = verdicts(part, column)?.collect();
            holds = Some(Share::of_all(of_simulated(&verdicts, is_simulated)));
            if column.counts {
                for (missed, holds) in self.missed.iter_mut().zip(&verdicts) {
                    *missed = missed.saturating_add(u16::from(!holds));
                }
                if verdicts.contains(&false) {
                    let numbers = part.numbers(&format!("measure.{}", column.name))?;
                    add_excess(&mut self.excess, &numbers, &verdicts, quantiles);
                }
            }
        }
        Ok(Measured {
            holds,
            quantiles,
            without: simulated.saturating_sub(values),
            least_covered,
        })
    }
}

/// How far apart the groups of each effect are in the share with which a measure holds. The worst runs learn what they
/// miss of it.
fn spreads(
    part: &Part<'_>,
    column: &Column,
    effects: &[(Effect, Groups)],
    worst: &mut [WorstRun],
) -> Result<Vec<f64>> {
    let verdicts: Vec<bool> = verdicts(part, column)?.collect();
    let numbers = part.numbers(&format!("measure.{}", column.name))?;
    for run in worst {
        if verdicts.get(run.position) == Some(&false) {
            let value = numbers.get(run.position).copied().unwrap_or(f64::NAN);
            run.missed.push((column.name.clone(), value));
        }
    }
    drop(numbers);
    let spreads = effects
        .iter()
        .map(|(_, groups)| spread(&groups.shares(verdicts.iter().copied())));
    Ok(spreads.collect())
}

impl Map {
    fn of(across: &Groups, up: &Groups, holds: &[bool]) -> Self {
        let mut counts = vec![vec![(0, 0); across.ranges.len()]; up.ranges.len()];
        for ((i, j), holds) in across.of.iter().zip(&up.of).zip(holds) {
            let row = counts.get_mut(usize::from(*j));
            if let Some((count, of)) = row.and_then(|row| row.get_mut(usize::from(*i))) {
                *count += usize::from(*holds);
                *of += 1;
            }
        }
        let shares = |row: Vec<(usize, usize)>| {
            let shares = row.into_iter().map(|(count, of)| Share::new(count, of));
            shares.collect()
        };
        Self {
            columns: across.ranges.clone(),
            rows: up.ranges.clone(),
            cells: counts.into_iter().map(shares).collect(),
        }
    }
}

/// Those of the lines that were simulated.
fn of_simulated(
    holds: &[bool],
    is_simulated: &impl Fn(usize) -> bool,
) -> impl Iterator<Item = bool> {
    let holds = holds.iter().enumerate();
    holds.filter_map(|(position, holds)| is_simulated(position).then_some(*holds))
}

/// What is not a number is in no group.
fn leave_out_refused(numbers: &mut [f64], is_simulated: &impl Fn(usize) -> bool) {
    for (position, number) in numbers.iter_mut().enumerate() {
        if !is_simulated(position) {
            *number = f64::NAN;
        }
    }
}

/// Nothing is as good as false.
fn truths(part: &Part<'_>, name: &str) -> Result<impl Iterator<Item = bool> + use<>> {
    Ok(part
        .truths(name)?
        .into_iter()
        .map(|truth| truth == Some(true)))
}

fn verdicts(part: &Part<'_>, column: &Column) -> Result<impl Iterator<Item = bool> + use<>> {
    truths(part, &format!("holds.{}", column.name))
}

/// Difference between the best and the worst.
fn spread(shares: &[Share]) -> f64 {
    let values = || shares.iter().map(|share| share.value());
    values().fold(0.0, f64::max) - values().fold(1.0, f64::min)
}

/// How bad a run is that does not hold.
#[derive(Clone, Copy, Debug)]
struct Badness {
    completed: bool,
    /// Measures that do not hold.
    missed: u16,
    /// How far these are from those that hold, in spreads.
    excess: f32,
    position: usize,
}

impl Badness {
    /// The worst first: those that did not reach their end, those that miss most, by most; among equals the first.
    fn order(&self, other: &Self) -> Ordering {
        let ended = self.completed.cmp(&other.completed);
        let missed = ended.then(other.missed.cmp(&self.missed));
        let excess = missed.then(other.excess.total_cmp(&self.excess));
        excess.then(self.position.cmp(&other.position))
    }
}

/// Adds how far values that do not hold are from the median of those that do, or from zero if none does, in distances
/// between the 5 % and the 95 % quantile of all. What has no value is farther than any.
///
/// The median of all may lie among those that do not hold, and then the one that misses least be far from it.
fn add_excess(excess: &mut [f32], numbers: &[f64], verdicts: &[bool], of_all: [Option<f64>; 3]) {
    let [Some(low), _, Some(high)] = of_all else {
        return;
    };
    let good = numbers.iter().zip(verdicts).filter(|(_, holds)| **holds);
    let [middle] = quantiles(good.map(|(number, _)| *number).collect(), [0.5]);
    let middle = middle.unwrap_or(0.0);
    let spread = (high - low).max(f64::MIN_POSITIVE);
    for ((excess, number), holds) in excess.iter_mut().zip(numbers).zip(verdicts) {
        if !holds {
            let far = ((number - middle) / spread).abs();
            *excess += if far.is_nan() {
                1e6
            } else {
                far.min(1e6) as f32
            };
        }
    }
}

/// Of those that do not hold, the worst first.
fn worst(failed: impl Iterator<Item = usize>, worse: impl Fn(usize) -> Badness) -> Vec<WorstRun> {
    let mut worst: Vec<usize> = Vec::new();
    for position in failed {
        let this = worse(position);
        let rank = worst.partition_point(|other| worse(*other).order(&this) == Ordering::Less);
        if rank < WORST {
            worst.insert(rank, position);
            worst.truncate(WORST);
        }
    }
    let run = |position: usize| WorstRun {
        run: 0,
        completed: worse(position).completed,
        reason: None,
        missed: Vec::new(),
        factors: Vec::new(),
        position,
    };
    worst.into_iter().map(run).collect()
}

/// Number of the worst of those that reached their end.
fn worst_completed(
    part: &Part<'_>,
    holds: &[bool],
    ends: &[u8],
    worse: impl Fn(usize) -> Badness,
) -> Result<Option<i64>> {
    let completed = (0..holds.len()).filter(|position| !holds[*position] && ends[*position] == 0);
    let Some(worst) = completed.min_by(|a, b| worse(*a).order(&worse(*b))) else {
        return Ok(None);
    };
    let mut number = None;
    part.wholes("run", |position, run| {
        if position == worst {
            number = Some(run);
        }
    })?;
    Ok(number)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_worst_come_first_and_among_equals_the_first() {
        let mut holds = [false; 40];
        holds[0] = true;
        let worse = |position: usize| Badness {
            completed: position != 30,
            missed: u16::from(position % 20 == 7),
            excess: if position == 5 { 2.0 } else { 0.5 },
            position,
        };
        let worst = worst((0..40).filter(|position| !holds[*position]), worse);
        let positions: Vec<usize> = worst.iter().map(|run| run.position).collect();
        assert_eq!(positions, [30, 7, 27, 5, 1, 2, 3, 4, 6, 8]);
    }

    #[test]
    fn what_is_far_from_what_holds_is_worse_and_what_has_no_value_most() {
        let mut excess = [0.0; 4];
        let quantiles = [Some(1.0), Some(2.0), Some(3.0)];
        add_excess(
            &mut excess,
            &[2.0, 6.0, -4.0, f64::NAN],
            &[true, false, false, false],
            quantiles,
        );
        assert_eq!(excess, [0.0, 2.0, 3.0, 1e6]);
        // Most of them do not hold, and the median is among these.
        let mut excess = [0.0; 5];
        let quantiles = [Some(0.5), Some(6.0), Some(8.5)];
        let numbers = [0.5, 2.5, 6.5, 7.5, 8.5];
        let holds = [true, false, false, false, false];
        add_excess(&mut excess, &numbers, &holds, quantiles);
        assert_eq!(excess, [0.0, 0.25, 0.75, 0.875, 1.0]);
        let mut excess = [0.0; 5];
        add_excess(&mut excess, &numbers, &[false; 5], quantiles);
        assert!(excess.is_sorted());
    }
}
