//! Robots: those that ship, 69 as their makers describe them, and ten of these in closed loop.

mod collection;
mod gallery;
mod othex;
mod standing;
