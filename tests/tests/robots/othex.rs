//! The OTHex's numbers: mass, hover thrusts, and the singular values of its rotors' wrench map.
#![allow(non_snake_case)]

use nalgebra::{Matrix6, Vector6};
use wbqp::{
    dynamics::{Data, FrameKinematics},
    nalgebra,
};

#[test]
fn mass_and_singular_values() {
    let robot = wbqp_robots::othex().expect("it ships with the crate");
    assert!((robot.model.mass() - 2.91933).abs() <= 5e-6);
    let mut data = Data::new(&robot.model);
    data.update(&robot.model, &robot.home);
    let mut kinematics = FrameKinematics::new(&robot.model);
    let mut S = Matrix6::zeros();
    for (id, _, rotor) in robot.rotors() {
        kinematics.update(&robot.model, &data, rotor.frame);
        let z = kinematics.R_WF.matrix().column(2).into_owned();
        let twist = z * (rotor.reaction.sign() * rotor.moment_coefficient);
        let w = Vector6::new(z.x, z.y, z.z, twist.x, twist.y, twist.z);
        let column = kinematics.J.transpose() * w;
        S.set_column(id.index(), &column.fixed_rows::<6>(0));
    }
    let mut singular: Vec<f64> = S.singular_values().iter().copied().collect();
    singular.sort_by(|a, b| b.total_cmp(a));
    for (value, expected) in singular
        .iter()
        .zip([1.980, 1.064, 1.018, 0.659, 0.562, 0.460])
    {
        assert!((value - expected).abs() <= 5e-4, "{value} {expected}");
    }
}
