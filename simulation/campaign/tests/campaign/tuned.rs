//! The tuned cases of the examples: what is said of them on the plant as the controller believes it to be.

use std::path::Path;

use wbqp_campaign::{Campaign, Plan, Status};

/// All measures of a variant of an example's plan without any factor.
fn measured(plan: &str, variant: &str) -> Vec<(String, f64)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/campaigns");
    let plan = Plan::from_file(&root.join(format!("{plan}.toml"))).unwrap();
    let campaign = Campaign::new(plan).unwrap();
    let variants = campaign.plan().variants().iter();
    let index = variants
        .into_iter()
        .position(|v| v.name() == variant)
        .unwrap();
    let outcome = campaign.outcome(&campaign.plan().plain(index));
    assert_eq!(outcome.status, Status::Completed, "{:?}", outcome.reason);
    assert!(outcome.holds, "{variant} does not hold");
    let names = campaign.columns().iter().map(|column| column.name.clone());
    let values = outcome
        .measured
        .iter()
        .map(|value| value.unwrap_or(f64::NAN));
    names.zip(values).collect()
}

fn value(rows: &[(String, f64)], name: &str) -> f64 {
    rows.iter().find(|(n, _)| n.contains(name)).unwrap().1
}

#[test]
fn the_force_of_experiment_b_is_nearer_than_a_twentieth_of_a_newton() {
    let tuned = measured("push_with_disturbance", "tuned");
    assert!(
        value(&tuned, "RMSE of the measured force") < 0.05,
        "{tuned:?}"
    );
    assert!(value(&tuned, "force_rmse") < 0.05, "{tuned:?}");
    assert!(
        value(
            &measured("push_with_disturbance", "papers"),
            "RMSE of the measured force"
        ) > 0.05
    );
}

#[test]
fn the_path_of_experiment_c_is_nearer_than_three_millimetres() {
    let tuned = measured("push_and_slide", "tuned");
    for axis in ["x", "y"] {
        let error = value(&tuned, &format!("largest tracking error along {axis}"));
        assert!(error < 0.3, "{axis}: {error} cm");
    }
}

#[test]
fn experiment_d_holds() {
    measured("push_away", "tuned");
}
