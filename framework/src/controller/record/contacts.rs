//! Copies what a contact remembers from one tick to the next into a record, and back.
#![allow(non_snake_case)]

use nalgebra::{Matrix3, Rotation3, Vector3};

use super::ContactMemory;
use crate::contact::{ContactBinding, ContactState, SensorZero, SurfaceMotion};
use wbqp_dynamics::{Data, model::Model};

impl ContactBinding {
    /// Writes what is remembered from one tick to the next.
    pub(crate) fn remember(&self, c: &ContactState, out: &mut ContactMemory) {
        out.switch = self.switch;
        out.exit_force = self.exit_force;
        out.exit_alpha = self.exit_alpha;
        out.filtered = self.filtered.into();
        out.mean_reading = self.zero.mean.map(Into::into);
        out.sensor_zero = self.zero.offset.into();
        let m = &self.motion;
        out.rotation = columns(&m.R_WC);
        out.last_placed = Some((columns(&c.R_WC), c.p_WS.into()));
        out.motion = [m.p_WS, m.v_WS, m.w_WC, m.a_WS, m.alpha_WC].map(Into::into);
    }

    /// Takes it over again.
    pub(crate) fn recall(&mut self, memory: &ContactMemory) {
        self.switch = memory.switch;
        self.exit_force = memory.exit_force;
        self.exit_alpha = memory.exit_alpha;
        self.filtered = memory.filtered.into();
        self.zero = SensorZero {
            mean: memory.mean_reading.map(Into::into),
            offset: memory.sensor_zero.into(),
        };
        let [p_WS, v_WS, w_WC, a_WS, alpha_WC] = memory.motion.map(Vector3::from);
        self.motion = SurfaceMotion {
            R_WC: rotation(&memory.rotation),
            p_WS,
            v_WS,
            w_WC,
            a_WS,
            alpha_WC,
        };
    }

    /// What is known of the contact without its wrench, where the surface was in the tick that is remembered; it may
    /// have moved since.
    pub(crate) fn place_as_then(
        &mut self,
        time: f64,
        model: &Model,
        data: &Data,
        memory: &ContactMemory,
        c: &mut ContactState,
    ) {
        let now = self.motion;
        if let Some((R_WC, p_WS)) = &memory.last_placed {
            (self.motion.R_WC, self.motion.p_WS) = (rotation(R_WC), (*p_WS).into());
        }
        self.place(model, data, c);
        self.stand(time, c);
        self.motion = now;
    }
}

/// A rotation's columns, one after the other.
fn columns(rotation: &Rotation3<f64>) -> [f64; 9] {
    let mut out = [0.0; 9];
    out.copy_from_slice(rotation.matrix().as_slice());
    out
}

fn rotation(columns: &[f64; 9]) -> Rotation3<f64> {
    Rotation3::from_matrix_unchecked(Matrix3::from_column_slice(columns))
}
