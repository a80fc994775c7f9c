//! Prints random problems of a family, one JSON object per line, as `solve_json` reads them, with the status that is
//! known by construction.
//!
//! ```text
//! generate_json Unbounded 1000 [largest number of variables, 16] [exponent of the units, 0] [first seed, 0]
//! ```

#[path = "../tests/solver/families.rs"]
mod families;

use families::{FAMILIES, Family, Truth, draw};
use serde_json::{Value, json};

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let number = |at: usize, default: f64| {
        arguments
            .get(at)
            .map_or(default, |text| text.parse().expect("a number"))
    };
    let name = arguments.first().map_or("Regular", String::as_str);
    let family = FAMILIES
        .into_iter()
        .chain([Family::Faint])
        .find(|family| format!("{family:?}") == name);
    let family = family.unwrap_or_else(|| panic!("no family `{name}`: {FAMILIES:?}"));
    let first = number(4, 0.0) as u64;
    for seed in first..first + number(1, 10.0) as u64 {
        let known = draw(family, seed, number(2, 16.0) as usize, number(3, 0.0));
        let qp = &known.qp;
        let (status, objective) = match &known.truth {
            Truth::Optimal(x) => ("optimal", json!(qp.objective(x))),
            Truth::Infeasible => ("infeasible", Value::Null),
            Truth::Unbounded => ("unbounded", Value::Null),
        };
        let list = |numbers: &[f64]| -> Value {
            let number = |&x: &f64| {
                if x.is_finite() {
                    json!(x)
                } else {
                    json!(if x > 0.0 { "inf" } else { "-inf" })
                }
            };
            numbers.iter().map(number).collect()
        };
        let line = json!({
            "note": format!("{name} {seed}"), "n": qp.n(), "m": qp.m(),
            "H": list(qp.h()), "g": list(qp.g()), "A": list(qp.a()),
            "row_lower": list(qp.row_lower()), "row_upper": list(qp.row_upper()),
            "lower": list(qp.lower()), "upper": list(qp.upper()),
            "expected": {"status": status, "objective": objective, "x": null, "relative_tolerance": 1e-6},
        });
        println!("{line}");
    }
}
