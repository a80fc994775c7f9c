//! The dynamics allocate nothing once their workspaces exist.

use wbqp::{
    dynamics::{
        Data, FrameKinematics, JointDrive, Wrenches, energy, forward_dynamics, frame_motion,
        inverse_dynamics,
    },
    model::Base,
    nalgebra::{DVector, Vector3},
};
use wbqp_tests::random_model::{random_model, random_state};

use crate::allocations;

pub(crate) fn dynamics_do_not_allocate() {
    for base in [Base::Floating, Base::Fixed] {
        let model = random_model(11, base, 9);
        let states: Vec<_> = (0..20).map(|i| random_state(i, &model, 1.0)).collect();
        let frame = model.frame("tool9").expect("made by the generator");
        let body = model.frames()[frame.index()].body;
        let mut data = Data::new(&model);
        let mut kinematics = FrameKinematics::new(&model);
        let mut wrenches = Wrenches::new(&model);
        let (mut vdot, mut effort) = (DVector::zeros(model.nv()), DVector::zeros(9));
        let mut tau = DVector::zeros(model.nv());
        let mut drives = vec![JointDrive::Effort(0.1); 9];
        drives[4] = JointDrive::Acceleration(1.0);

        let before = allocations();
        let mut sum = 0.0;
        for state in &states {
            data.update(&model, state);
            kinematics.update(&model, &data, frame);
            let tool = frame_motion(&model, &data, frame);
            wrenches.clear();
            wrenches.add_force(&data, body, &tool.p_WF, &Vector3::z());
            forward_dynamics(
                &model,
                &mut data,
                &drives,
                &wrenches,
                &mut vdot,
                &mut effort,
            );
            inverse_dynamics(&model, &mut data, &vdot, &wrenches, &mut tau);
            sum += energy(&model, &data).total() + tau[0];
        }
        let allocated = allocations() - before;
        assert!(sum.is_finite());
        assert_eq!(allocated, 0);
    }
}
