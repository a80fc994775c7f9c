//! What matters in a tick: which weights and gains move the command, which limits hold it.

use wbqp::{
    controller::{Controller, Effect, RequestError, Sensitivity},
    serde_json::{Value, json},
};

/// Weights and gains, and limits, that are told.
const MOST: usize = 6;

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
    let effects = sensitivity.strongest_effects(MOST);
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
    let holding = controller.report().holding().into_iter();
    holding
        .take(MOST)
        .filter_map(|row| {
            let name = controller.row(row.row)?.to_string();
            Some(json!({ "name": name, "side": row.side.as_str() }))
        })
        .collect()
}
