//! Frames that plug-ins ask for.

/// A frame whose kinematics the plug-in asked for in `bind`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrameHandle(pub(crate) usize);
