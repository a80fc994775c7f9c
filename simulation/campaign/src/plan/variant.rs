//! One of the things that a plan compares.

use std::ops::Range;

use wbqp_sim::{Scenario, ScenarioError, Variation};

use super::{
    PlanError, Refuse, check_name,
    file::{Keys, variation},
};

/// Cases of the scenario, and what is changed in them.
#[derive(Clone, Debug)]
pub struct Variant {
    name: String,
    cases: Vec<String>,
    scenario: Scenario,
}

impl Variant {
    /// Those of a plan; each case of the scenario, if the plan names none.
    pub(super) fn all(
        keys: &Keys,
        base: &Scenario,
        place: &dyn Fn(Range<usize>) -> String,
        refuse: &Refuse<'_>,
    ) -> Result<Vec<Self>, PlanError> {
        if keys.variants.is_empty() {
            let alone = |case: &str| Self {
                name: case.to_owned(),
                cases: vec![case.to_owned()],
                scenario: base.clone(),
            };
            return Ok(base.cases().map(alone).collect());
        }
        let mut variants: Vec<Self> = Vec::new();
        for entry in &keys.variants {
            let keys = entry.get_ref();
            check_name("variant", &keys.name).map_err(|what| refuse(entry.span(), what))?;
            let at = |span: Range<usize>, what: String| {
                refuse(span, format!("variant `{}`: {what}", keys.name))
            };
            let refuse = |what: String| at(entry.span(), what);
            if variants.iter().any(|other| other.name == keys.name) {
                return Err(refuse("the name is used twice".to_owned()));
            }
            if keys.cases.is_empty() {
                return Err(refuse("has no case".to_owned()));
            }
            let of = |source| PlanError::Scenario {
                of: format!("variant `{}` of {}", keys.name, place(entry.span())),
                source: Box::new(source),
            };
            for case in &keys.cases {
                base.case(case).map_err(|error| refuse(error.to_string()))?;
            }
            let variation =
                variation(&keys.change, &keys.set).map_err(|(span, what)| at(span, what))?;
            let scenario = if variation.is_empty() {
                base.clone()
            } else {
                base.varied(&variation).map_err(of)?
            };
            variants.push(Self {
                name: keys.name.clone(),
                cases: keys.cases.clone(),
                scenario,
            });
        }
        Ok(variants)
    }

    pub(super) fn vary(&mut self, variation: &Variation) -> Result<(), ScenarioError> {
        self.scenario = self.scenario.varied(variation)?;
        Ok(())
    }

    /// Its name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Its cases, in the order in which they are run.
    pub fn cases(&self) -> &[String] {
        &self.cases
    }

    /// The scenario with what it changes.
    pub fn scenario(&self) -> &Scenario {
        &self.scenario
    }
}
