//! The plug-ins of this crate as a user's program sees them.

mod binding;
mod registration;
mod robot;
mod ticking;
