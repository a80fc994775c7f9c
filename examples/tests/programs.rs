//! The programs run to their end and print what they are for.

use std::process::Command;

fn printed(program: &str) -> String {
    let output = Command::new(program).output().expect("runs");
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{program}: {errors}");
    assert_eq!(errors, "", "{program}");
    String::from_utf8(output.stdout).expect("is text")
}

/// The numbers of a line that begins with another one.
fn numbers(line: &str) -> Vec<f64> {
    line.split_whitespace()
        .filter_map(|word| word.parse().ok())
        .collect()
}

#[test]
fn the_quadruped_stands() {
    let text = printed(env!("CARGO_BIN_EXE_stand"));
    let last = numbers(text.lines().last().expect("has lines"));
    let [_, height, forces @ ..] = last.as_slice() else {
        panic!("{text}");
    };
    assert!(*height > 0.1, "{text}");
    assert_eq!(forces.len(), 4);
    // It weighs 24.5 N.
    assert!((forces.iter().sum::<f64>() - 24.5).abs() < 1.0, "{text}");
}

#[test]
fn a_loop_of_ones_own_has_optimal_ticks() {
    let text = printed(env!("CARGO_BIN_EXE_own_loop"));
    assert!(text.starts_with("after 1 s, optimal"), "{text}");
    assert_eq!(text.lines().count(), 1 + 12, "{text}");
}

#[test]
fn a_controller_in_code_is_a_file_and_can_be_changed() {
    let text = printed(env!("CARGO_BIN_EXE_in_code"));
    assert!(
        text.contains("[[task]]\nname = \"arm\"\ntype = \"posture\""),
        "{text}"
    );
    assert_eq!(text.matches("s, optimal: joints").count(), 4, "{text}");
}

#[test]
fn contradicting_limits_are_named() {
    let text = printed(env!("CARGO_BIN_EXE_limits"));
    assert!(text.contains("contradict"), "{text}");
    for limit in ["above the floor", "below the ceiling"] {
        assert!(text.contains(limit), "{text}");
    }
}

#[test]
fn an_experiment_has_its_rows() {
    let text = printed(env!("CARGO_BIN_EXE_experiment"));
    assert!(text.contains("D: pushing away (IV-D)"), "{text}");
    assert_eq!(text.matches(" met ").count(), 22, "{text}");
    assert!(!text.contains("missed"), "{text}");
}
