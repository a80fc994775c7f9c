//! Whether a plan's factors fit its scenario, before anything is run.

use std::fmt;

use wbqp_sim::{ScenarioError, Variation};

use crate::{
    CampaignError,
    plan::{Factor, Misfit, Nominal, Plan, Variant},
};

/// An end of a factor's range with which the scenario is refused.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct RefusedEnd {
    /// `file:line:column` of the factor.
    pub place: String,
    /// Its name.
    pub factor: String,
    /// What its number is: `value`, `scale` or `shift` of the scenario's own.
    pub relation: &'static str,
    /// Its number there.
    pub number: f64,
    /// Why the scenario is refused.
    pub why: String,
}

impl fmt::Display for RefusedEnd {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{}: factor `{}`: with the {} {}, at an end of its range, the scenario is refused, and runs next to it \
             will not be simulated: {}",
            self.place, self.factor, self.relation, self.number, self.why
        )
    }
}

/// The points of every variant can be written into its cases, and each factor alone is taken at one of them at
/// least: a key that there is not is refused at all. What a push asks of a plant is another matter.
///
/// # Errors
/// [`CampaignError::Factor`]
pub(crate) fn check(plan: &Plan, nominals: &[Vec<Nominal>]) -> Result<(), CampaignError> {
    let last = plan.len().saturating_sub(1);
    let probes = [0, last / 2, last].map(|run| plan.runs(run..run + 1));
    let refuse = |Misfit { start, what }: Misfit| {
        let plan = plan.place(start);
        Err(CampaignError::Factor { plan, what })
    };
    for (variant, case, nominal) in cases(plan, nominals) {
        for run in probes.iter().flatten() {
            let changes = nominal.changes(plan.factors(), &run.factors);
            changes.map(|_| ()).or_else(refuse)?;
        }
        for (index, factor) in plan.factors().iter().enumerate() {
            let runs = probes.iter().flatten();
            let mut numbers: Vec<f64> = runs.filter_map(|run| run.factors[index]).collect();
            if numbers.is_empty() && plan.has_points() {
                // A design that varies one at a time may have nothing of it there.
                numbers.extend(factor.distribution().ends());
                numbers.push(factor.distribution().quantile(0.5));
            }
            let mut why = None;
            let is_taken = numbers.iter().any(|number| {
                why = match with(variant, case, nominal, factor, *number) {
                    Ok(()) | Err(Refusal::Scenario(ScenarioError::Push { .. })) => None,
                    Err(other) => Some(other.words()),
                };
                why.is_none()
            });
            if let (false, Some(why)) = (is_taken, why) {
                return refuse(Misfit {
                    start: factor.start(),
                    what: format!("factor `{}`: {why}", factor.name()),
                });
            }
        }
    }
    for (index, factor) in plan.factors().iter().enumerate() {
        let others = plan.factors().iter().enumerate();
        let others = others.filter(|(other, _)| *other != index);
        let others: Vec<&Factor> = others.map(|(_, other)| other).collect();
        let mut all = nominals.iter().flatten();
        let scales_nothing = all.all(|nominal| factor.scales_zeros_of(nominal, &others));
        if scales_nothing {
            return refuse(Misfit {
                start: factor.start(),
                what: factor.scales_nothing(),
            });
        }
    }
    Ok(())
}

/// The ends of factors' ranges with which a case of a variant is refused, each factor alone.
pub(crate) fn refused_ends(plan: &Plan, nominals: &[Vec<Nominal>]) -> Vec<RefusedEnd> {
    if !plan.has_points() {
        return Vec::new();
    }
    let mut refused = Vec::new();
    for factor in plan.factors() {
        for number in factor.distribution().ends() {
            let mut all = cases(plan, nominals);
            let why = all.find_map(|(variant, case, nominal)| {
                let refusal = with(variant, case, nominal, factor, number).err()?;
                Some(refusal.words())
            });
            if let Some(why) = why {
                refused.push(RefusedEnd {
                    place: plan.place(factor.start()),
                    factor: factor.name().to_owned(),
                    relation: factor.relation(),
                    number,
                    why,
                });
            }
        }
    }
    refused
}

/// All cases of all variants.
fn cases<'a>(
    plan: &'a Plan,
    nominals: &'a [Vec<Nominal>],
) -> impl Iterator<Item = (&'a Variant, &'a str, &'a Nominal)> {
    let variants = plan.variants().iter().zip(nominals);
    variants.flat_map(|(variant, nominals)| {
        let cases = variant.cases().iter().zip(nominals);
        cases.map(move |(case, nominal)| (variant, case.as_str(), nominal))
    })
}

/// Why a number is not taken.
enum Refusal {
    /// It cannot be written.
    Misfit(String),
    /// The scenario refuses it.
    Scenario(ScenarioError),
}

impl Refusal {
    fn words(self) -> String {
        match self {
            Self::Misfit(what) => what,
            Self::Scenario(error) => error.to_string(),
        }
    }
}

/// A case with a number of one factor alone.
fn with(
    variant: &Variant,
    case: &str,
    nominal: &Nominal,
    factor: &Factor,
    number: f64,
) -> Result<(), Refusal> {
    let changes = nominal.changes(std::slice::from_ref(factor), &[Some(number)]);
    let changes = changes.map_err(|misfit| Refusal::Misfit(misfit.what))?;
    let variation = Variation::from_toml(&changes);
    let variation = variation.map_err(|error| Refusal::Misfit(error.to_string()))?;
    let varied = variant.scenario().varied_case(case, &variation);
    varied.map(|_| ()).map_err(Refusal::Scenario)
}
