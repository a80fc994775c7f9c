//! Factors that do not fit their scenario, or do so only in a part of their range.

use wbqp_campaign::Campaign;

use crate::common::{Folder, HEAD};

fn factor(lines: &str) -> String {
    format!("[[factor]]\nname = \"x\"\n{lines}\n")
}

fn campaign(design: &str, factors: &str) -> Result<Campaign, String> {
    let folder = Folder::new();
    let text = format!(
        r#"{HEAD}
design = {design}
{factors}
[[measure]]
name = "height"
signals = {{ z = "/plant.base.position.z" }}
reduce = "mean"
"#
    );
    let plan = folder.try_plan(&text).map_err(|error| error.to_string())?;
    Campaign::new(plan).map_err(|error| error.to_string())
}

const RANDOM: &str = "{ type = \"random\", points = 4 }";

#[test]
fn a_scale_of_zero_is_refused_with_what_to_write() {
    for path in ["push.force[0]", "push.force"] {
        let lines = format!(
            "path = \"change.plant.disturbance.{path}\"\nscale = {{ uniform = [0.5, 2.0] }}"
        );
        let refused = campaign(RANDOM, &factor(&lines)).unwrap_err();
        for words in [
            "plan.toml:7:1: factor `x`: `scale` of `change.plant.disturbance.push.force",
            "which is 0 in the scenario, is always 0, and has no effect",
            "as `value = { uniform = [lowest, highest] }` in place of `scale`",
        ] {
            assert!(refused.contains(words), "{words}: {refused}");
        }
    }
    // With another path that is not zero, or a factor that writes the list, it does something.
    for factors in [
        "path = [\"change.plant.disturbance.push.force\", \"change.plant.mismatch.mass_scale\"]\n\
         scale = { uniform = [0.9, 1.1] }",
        "path = \"change.plant.disturbance.push.force\"\nscale = { uniform = [0.9, 1.1] }\n\
         [[factor]]\nname = \"y\"\npath = \"change.plant.disturbance.push.force[1]\"\nvalue = { uniform = [0.9, 1.1] }",
    ] {
        campaign(RANDOM, &factor(factors)).unwrap();
    }
}

#[test]
fn rotors_need_no_list_and_other_lists_are_told_to_be_written_out() {
    let lines = "path = \"change.plant.mismatch.rotor_scales[1]\"\nvalue = { values = [0.9] }";
    let made = campaign("{ type = \"grid\" }", &factor(lines)).unwrap();
    let runs = made.plan().runs(0..1);
    let (_, case) = made.cases(&runs[0]).next().unwrap();
    let case = case.unwrap();
    let scales = &case.plant().mismatch.rotor_scales;
    assert_eq!(scales[..], [1.0, 0.9, 1.0, 1.0, 1.0, 1.0]);
    let lines = "path = \"change.plant.mismatch.rotor_scales[6]\"\nvalue = { values = [0.9] }";
    let refused = campaign(RANDOM, &factor(lines)).unwrap_err();
    assert!(
        refused.contains("has 6 entries, none with number 6"),
        "{refused}"
    );
    for (path, words) in [
        (
            "change.plant.mismatch.mass_scale[1]",
            "`change.plant.mismatch.mass_scale` is the number 1.0, no list with entry 1; write it out first, with all \
             its entries: `change.plant.mismatch.mass_scale = [1.0, 1.0, …]`",
        ),
        (
            "change.plant.nothing[0]",
            "the scenario has no list at `change.plant.nothing` to take entry 0 of; write it out first, with all its \
             entries: `change.plant.nothing = [1.0, …]` at the beginning of the plan",
        ),
    ] {
        let lines = format!("path = \"{path}\"\nvalue = {{ values = [0.9] }}");
        let refused = campaign(RANDOM, &factor(&lines)).unwrap_err();
        assert!(refused.contains(words), "{refused}");
    }
}

#[test]
fn the_ends_of_ranges_are_tried_before_anything_is_run() {
    let delay = "path = \"change.plant.command_delay\"\nvalue = { integers = [-1, 8] }";
    let made = campaign(RANDOM, &factor(delay)).unwrap();
    let [end] = made.refused_ends() else {
        panic!("{:?}", made.refused_ends());
    };
    assert_eq!(
        (end.factor.as_str(), end.relation, end.number),
        ("x", "value", -1.0)
    );
    let words = end.to_string();
    for part in [
        "plan.toml:7:1: factor `x`: with the value -1, at an end of its range, the scenario is refused",
        "expected an integer, 0 or more",
    ] {
        assert!(words.contains(part), "{words}");
    }
    let thrust = "path = \"change.plant.mismatch.thrust_scale\"\n";
    for (numbers, refused) in [
        ("value = { uniform = [0.9, 1.1] }", 0),
        ("value = { uniform = [-0.1, 1.1] }", 1),
        ("value = { values = [1.0, -1.0, 1.1] }", 1),
        ("shift = { normal = { mean = 0.0, sd = 0.5 } }", 1),
        ("scale = { normal = { mean = 1.0, sd = 0.02 } }", 0),
    ] {
        let made = campaign(RANDOM, &factor(&format!("{thrust}{numbers}"))).unwrap();
        assert_eq!(made.refused_ends().len(), refused, "{numbers}");
    }
    // Without points no factor has any value.
    let made = campaign("{ type = \"plain\" }", &factor(delay)).unwrap();
    assert!(made.refused_ends().is_empty());
    // A key that there is not is found also where few points have it.
    let lines = "path = \"change.plant.mismatch.mas_scale\"\nvalue = { uniform = [0.9, 1.1] }";
    let refused = campaign("{ type = \"one_at_a_time\" }", &factor(lines)).unwrap_err();
    assert!(refused.contains("did you mean `mass_scale`"), "{refused}");
}
