//! Rigid-body dynamics: placeholder
