//! What matters in a tick: which weights and gains move the command, which limits hold it.

use wbqp::{
    controller::{Controller, Effect, LimitRow, RequestError, Sensitivity},
    serde_json::{Value, json},
};

/// Weights and gains that are told.
const MOST: usize = 6;
/// A limit with a multiplier below this share of the largest does not hold anything.
const NEGLIGIBLE: f64 = 1e-6;

/// The derivatives of the last tick as JSON:
///
/// * `time`: s; null before there is a tick of which beginnings were kept
/// * `refused`: why there are no derivatives, or null
/// * `effects`: the weights and gains that move the efforts most, each with `kind`, `owner`, `key`, `effort` (the norm
///   of the efforts' derivative by the logarithm) and `most`, a list of the outputs that move most, each with `name`,
///   `slope` (by the logarithm) and `unit`
/// * `limits`: what holds the optimum back, the most expensive first, each with `name` and `side`
/// * `notes`: where the optimum is not differentiable, in words
pub(crate) fn tell(controller: &mut Controller, sensitivity: &mut Sensitivity) -> Value {
    let refused = match controller.sensitivity(sensitivity) {
        Ok(()) | Err(RequestError::NotKept) => None,
        Err(error) => Some(error.to_string()),
    };
    let mut effects = sensitivity.effects();
    // Where limits hold everything, the others move it by rounding.
    let least = effects.first().map_or(0.0, |most| 1e-10 * most.effort);
    effects.retain(|effect| effect.effort > least);
    effects.truncate(MOST);
    let notes = sensitivity.notes_on(&effects);
    let effects = effects.iter().map(|effect| of_effect(effect, sensitivity));
    let effects: Vec<Value> = effects.collect();
    json!({
        "time": sensitivity.time(),
        "refused": refused,
        "effects": effects,
        "limits": if sensitivity.time().is_some() { limits(controller) } else { Vec::new() },
        "notes": notes,
    })
}

fn of_effect(effect: &Effect, sensitivity: &Sensitivity) -> Value {
    // Efforts are what is commanded; then what they are for.
    let [acceleration, effort, force] = effect.strongest;
    let most = [effort, force, acceleration].into_iter().flatten();
    let most = most.filter_map(|(output, slope)| {
        let about = sensitivity.outputs().get(output)?;
        let name = format!("{} {}", about.owner, about.label);
        Some(json!({ "name": name, "slope": slope, "unit": about.unit }))
    });
    json!({
        "kind": effect.kind.as_str(),
        "owner": effect.owner,
        "key": effect.key,
        "effort": effect.effort,
        "most": most.collect::<Vec<_>>(),
    })
}

fn limits(controller: &Controller) -> Vec<Value> {
    let mut active: Vec<&LimitRow> = controller.report().active.iter().collect();
    active.sort_by(|a, b| b.multiplier.abs().total_cmp(&a.multiplier.abs()));
    let largest = active.first().map_or(0.0, |row| row.multiplier.abs());
    let holding = active
        .into_iter()
        .filter(|row| row.multiplier.abs() > NEGLIGIBLE * largest);
    holding
        .take(MOST)
        .filter_map(|row| {
            let name = controller.row(row.row)?.to_string();
            Some(json!({ "name": name, "side": row.side.as_str() }))
        })
        .collect()
}
