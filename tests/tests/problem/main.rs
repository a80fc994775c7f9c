//! The quadratic program of a tick: its properties in all formulations, and contacts that determine accelerations.

mod hard_contacts;
mod properties;
