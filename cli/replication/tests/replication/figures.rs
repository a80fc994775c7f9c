//! Figures of runs whose numbers are known.

use std::fs;

use wbqp_replication::plots::{push, slide, under_actuated as tilted};

use crate::stories::{push_and_slide, push_with_disturbance, under_actuated};

#[test]
fn figures_of_pushing_are_drawn_with_axes_and_legends() {
    use push_with_disturbance::{log, no_ft, with_ft};
    let directory = std::env::temp_dir().join("wbqp_figures_test");
    fs::create_dir_all(&directory).unwrap();
    push::draw(&log(&with_ft()), &log(&no_ft()), &directory).unwrap();
    for (file, words) in [
        (
            "fig2_normal_force.svg",
            ["normal force [N]", "commanded f*", "disturbance"],
        ),
        (
            "fig3_propellers_rotation.svg",
            ["speed [rad/s]", "limits", "angle [deg]"],
        ),
        ("base_position.svg", ["x [m]", "time [s]", "contact"]),
    ] {
        let text = fs::read_to_string(directory.join(file)).unwrap();
        for word in words {
            assert!(text.contains(word), "{file} lacks {word}");
        }
    }
    fs::remove_dir_all(directory).unwrap();
}

#[test]
fn figures_of_sliding_are_drawn_with_axes_and_legends() {
    use push_and_slide::{GOOD, recorded};
    let directory = std::env::temp_dir().join(format!("wbqp_slide_{}", std::process::id()));
    fs::create_dir_all(&directory).unwrap();
    let pictures = slide::draw(&recorded(GOOD).logs(), &directory).unwrap();
    let words = |file: &str| match file {
        "fig4_path.svg" => ["y [cm]", "x [cm], up", "reference"],
        "fig4_tracking_force.svg" => ["x [cm]", "normal force [N]", "contact"],
        "fig5_joint_error.svg" => ["[deg]", "pitch", "slide"],
        "friction_compensation.svg" => ["force [N]", "with compensation", "error, y [cm]"],
        "heavier_plant.svg" => ["heavier plant", "error, z [cm]", "time [s]"],
        other => panic!("{other}"),
    };
    assert_eq!(pictures.len(), 5);
    for picture in pictures {
        let text = fs::read_to_string(directory.join(&picture.file)).unwrap();
        for word in words(&picture.file) {
            assert!(text.contains(word), "{} lacks {word}", picture.file);
        }
    }
    fs::remove_dir_all(directory).unwrap();
}

#[test]
fn figures_of_tilting_are_drawn_with_axes_and_legends() {
    use under_actuated::{bad, good, log};
    let directory = std::env::temp_dir().join("wbqp_under_actuated_figures_test");
    fs::create_dir_all(&directory).unwrap();
    tilted::draw(&log(&good()), &log(&bad()), &directory).unwrap();
    for (file, words) in [
        (
            "fig9_force_propellers.svg",
            ["normal force [N]", "speed [rad/s]", "limits"],
        ),
        ("fig10_rotation.svg", ["angle [deg]", "desired", "contact"]),
        (
            "attitude_reference.svg",
            ["pitch [deg]", "attitude reference", "time [s]"],
        ),
    ] {
        let text = fs::read_to_string(directory.join(file)).unwrap();
        for word in words {
            assert!(text.contains(word), "{file} lacks {word}");
        }
    }
    fs::remove_dir_all(directory).unwrap();
}
