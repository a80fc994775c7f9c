//! A choice of the world's axes.

use wbqp::prelude::*;

/// An axis of the world.
#[wbqp::parameters]
#[derive(Copy, PartialEq, Eq)]
pub enum Axis {
    /// World x.
    X,
    /// World y.
    Y,
    /// World z, up.
    Z,
}

impl Axis {
    /// All three.
    pub(crate) const ALL: [Self; 3] = [Self::X, Self::Y, Self::Z];

    pub(crate) fn index(self) -> usize {
        match self {
            Self::X => 0,
            Self::Y => 1,
            Self::Z => 2,
        }
    }

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::X => "x",
            Self::Y => "y",
            Self::Z => "z",
        }
    }

    /// The axes chosen by the key `axes`: all if it is absent, each at most once.
    pub(crate) fn chosen(axes: Option<&[Self]>) -> Result<Vec<Self>, BindError> {
        let Some(axes) = axes else {
            return Ok(Self::ALL.to_vec());
        };
        if axes.is_empty() {
            return Err(BindError::length("axes", 0, "at least one"));
        }
        let twice = (1..axes.len()).find(|&i| axes[..i].contains(&axes[i]));
        match twice {
            Some(i) => {
                let problem = format!("names `{}` twice", axes[i].name());
                Err(BindError::value("axes", problem))
            }
            None => Ok(axes.to_vec()),
        }
    }
}
