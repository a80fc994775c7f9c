//! Tasks, constraints and references for [wbqp]: those of G. Nava et al., *Direct Force Feedback Control and
//! Online Multi-task Optimization for Aerial Manipulators*, RA-L 2020, free of its misprints, and a catalogue beyond
//! it.
//!
//! Every plug-in here depends on the crate `wbqp` alone and uses nothing that a plug-in of yours could not use.
//! A binary that names none of these types writes `use wbqp_tasks as _;`, or the linker leaves them out.
//!
//! | `type` | kind | paper |
//! |---|---|---|
//! | `base_position` | task | p_R, first row of (11) |
//! | `base_orientation` | task | R_R, second row of (11) |
//! | `posture` | task | q_A, third row of (11) |
//! | `free_motion` | task | p_f, fourth row of (11) |
//! | `contact_force` | task | f_c, fifth row of (11) |
//! | `propeller_regularisation` | task | r_a, sixth row of (11) |
//! | `actuator_limits` | constraint | (10b) |
//! | `friction_pyramid` | constraint | (10c) |
//! | `contact_motion` | constraint | (10e) |
//! | `hold`, `min_jerk`, `waypoints`, `ellipse` | reference | y^d(t) |
//! | `thrust_attitude` | reference | attitude of an under-actuated base, not in the paper |
//!
//! Not in the paper:
//!
//! | `type` | kind | what it does |
//! |---|---|---|
//! | `frame_position`, `frame_orientation`, `frame_pose` | task | move a frame in the world |
//! | `relative_pose` | task | moves a frame relative to another one |
//! | `com` | task | moves the centre of mass |
//! | `centroidal_angular_momentum` | task | angular momentum about the centre of mass |
//! | `joint_torque_regularisation` | task | joint torques near a value |
//! | `thrust_regularisation` | task | thrusts near a value |
//! | `constant_force` | task | contact force at a fixed set point |
//! | `joint_limits` | constraint | range and speed of joints, viable |
//! | `thrust_rate_limits` | constraint | rates of thrusts |
//! | `plane_distance` | constraint | a point stays on one side of a plane |
//! | `tilt_limit` | constraint | the base does not tilt too far |
//! | `contact_wrench` | constraint | friction, centre of pressure and torsion of a sole |
//!
//! The dynamics (10d) belong to the framework.
//!
//! # Tasks on accelerations
//! All of them but `centroidal_angular_momentum`, whose rows are the first derivative of its error, ask for
//! `a* = a_d − K_D (v − v_d) − K_P (p − p_d)`, so a task that gets what it asks for makes its error decay as
//! `ë + K_D ė + K_P e = 0`. `K_P` has the unit 1/s² and `K_D` 1/s, whatever moves; critical damping is
//! `K_D = 2 √K_P`.
//!
//! ```
//! use wbqp::serde_json;
//! use wbqp_tasks::{MinJerk, Posture};
//! let arm = Posture::new(25.0, 10.0).following(MinJerk::new([0.0, 0.3, 0.9], 2.0));
//! let text = serde_json::to_string(&arm)?;
//! assert_eq!(
//!     text,
//!     r#"{"kp":25.0,"kd":10.0,"reference":{"type":"min_jerk","to":[0.0,0.3,0.9],"duration":2.0,"start":0.0}}"#,
//! );
//! # Ok::<(), serde_json::Error>(())
//! ```

mod axis;
mod check;
mod constraints;
mod effort;
mod follow;
mod integral;
mod references;
mod tasks;

pub use axis::Axis;
pub use constraints::{
    ActuatorLimits, Approximation, ContactMotion, ContactWrench, FrictionPyramid, JointLimits,
    PlaneDistance, ThrustRateLimits, TiltLimit,
};
pub use references::{Ellipse, Hold, MinJerk, ThrustAttitude, Waypoint, Waypoints};
pub use tasks::{
    BaseOrientation, BasePosition, CentroidalAngularMomentum, Com, ConstantForce, ContactForce,
    Feedback, FrameOrientation, FramePose, FramePosition, FreeMotion, GainAxes,
    JointTorqueRegularisation, Origin, Posture, PropellerRegularisation, RelativePose,
    RotationError, SurfaceAxis, Tangential, ThrustRegularisation,
};
