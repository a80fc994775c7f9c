//! Whether contacts that must not move say nothing twice.
//!
//! # Mathematics
//! Hard rows are `J_c v̇ = b`. If `J_c` has fewer independent rows than rows, a `b` of noise, or of a ground that gives
//! way, has no solution: every tick would have to give up some of them. Legs whose joints all turn about one axis, four
//! of which stand, are such a case.
#![allow(non_snake_case)]

use wbqp::{
    dynamics::{Data, FrameKinematics},
    model::{FrameId, Model},
    nalgebra::DMatrix,
    state::State,
};

use super::draft::Draft;

/// Singular values below this share of the largest are none.
const RANK: f64 = 1e-6;

/// How contacts are held, by how many of their rows follow from the others.
pub(super) struct Motion {
    rows: usize,
    dependent: usize,
}

impl Motion {
    /// Of frames that touch, each with its first `rows_each` rows: three of a point, six of a sole.
    pub(super) fn of(model: &Model, state: &State, frames: &[FrameId], rows_each: usize) -> Self {
        let rows = frames.len() * rows_each;
        let mut data = Data::new(model);
        data.update_kinematics(model, state);
        let mut frame = FrameKinematics::new(model);
        let mut J = DMatrix::zeros(rows, model.nv());
        for (k, id) in frames.iter().enumerate() {
            frame.update(model, &data, *id);
            J.rows_mut(k * rows_each, rows_each)
                .copy_from(&frame.J.rows(0, rows_each));
        }
        let singular = J.singular_values();
        let largest = singular.max();
        let rank = singular.iter().filter(|s| **s > RANK * largest).count();
        Self {
            rows,
            dependent: rows - rank,
        }
    }

    /// The value of the key `motion`.
    pub(super) fn key(&self) -> &'static str {
        if self.dependent == 0 { "hard" } else { "soft" }
    }

    /// What the key asks of the contacts.
    pub(super) fn in_words(&self) -> &'static str {
        if self.dependent == 0 {
            "they must not move"
        } else {
            "they should not move"
        }
    }

    /// Why it is soft, for the file.
    pub(super) fn explain(&self, draft: &mut Draft) {
        if self.dependent > 0 {
            draft.comment(&format!(
                "`motion` is soft because the legs have too few joints: of the {} directions in which contacts with \
                 hard motion must not move, {} follow from the others at home. What the ground and noise ask of them \
                 would contradict itself in nearly every tick. Their friction limits are hard all the same.",
                self.rows, self.dependent
            ));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows of the feet of the quadruped that ships, at home, that follow from the others; of two feet alone, too.
    fn dependent(options: &str) -> [usize; 2] {
        let text = format!(
            "[controller]\nrate = 500.0\nhover = \"unchecked\"\n[robot]\ntype = \"urdf\"\n\
             file = \"quadruped.urdf\"\n{options}"
        );
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../robots/files/quadruped");
        let config = wbqp::ControllerConfig::from_str(&text, "test", folder).unwrap();
        let robot = config.load_robot().unwrap();
        let feet = ["fl_foot", "fr_foot", "hl_foot", "hr_foot"];
        let feet = feet.map(|name| robot.model.frame(name).unwrap());
        let of = |count: usize| {
            let feet = feet.get(..count).unwrap();
            Motion::of(&robot.model, &robot.home, feet, 3).dependent
        };
        [of(4), of(2)]
    }

    #[test]
    fn feet_on_legs_of_three_joints_are_independent_and_on_planar_ones_are_not() {
        assert_eq!(dependent(""), [0, 0]);
        let legs = ["fl", "fr", "hl", "hr"];
        let bent = legs.map(|leg| format!("{leg}_hip_pitch = 0.7, {leg}_knee = -1.2"));
        let home = format!("home = {{ {} }}\n", bent.join(", "));
        // The two in front are beside one another: they cannot come nearer, nor go apart.
        let lock = "lock = [\".*_hip_roll\"]\n";
        assert_eq!(dependent(&format!("{home}{lock}")), [2, 1]);
    }
}
