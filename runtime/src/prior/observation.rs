//! Observations: which number a row of a pin gives of a vertex, and how the weights change it.

use crate::error::{Argument, CallError, CallErrorKind};
use crate::linear::Matrix3x4;
use crate::skin::Skin;

/// A vertex as the weights move it: `x = offset + sum z_s (image of delta s)`.
pub(super) struct Vertex {
    /// Rows of its blended transform.
    transform: [[f64; 4]; 3],
    rest: [f64; 3],
}

impl Skin<'_> {
    /// Returns where a vertex is with weights of its shapes and a palette; `None` beyond the mesh.
    ///
    /// - `palette`: [`Skin::palette_len`] transforms.
    /// - `weights`: [`Skin::shape_len`] weights z; of fewer the others are 0.
    pub fn place(&self, vertex: u32, palette: &[Matrix3x4], weights: &[f32]) -> Option<[f32; 3]> {
        let moving = Vertex::new(self, palette, vertex)?;
        let mut x = moving.rest;
        for (shape, delta) in self.deltas_of(vertex as usize) {
            let weight = weights.get(shape).copied().unwrap_or_default();
            x.iter_mut().zip(delta).for_each(|(x, u)| *x += f64::from(weight) * f64::from(u));
        }
        let [a, b, c] = x;
        Some(moving.transform.map(|[x, y, z, w]| (x * a + y * b + z * c + w) as f32))
    }
}

impl Vertex {
    pub(super) fn new(skin: &Skin<'_>, palette: &[Matrix3x4], vertex: u32) -> Option<Self> {
        let rest = skin.rest_position(vertex as usize)?.map(f64::from);
        let transform = skin.blended(palette, vertex as usize)?.map(|row| row.map(f64::from));
        Some(Self { transform, rest })
    }

    /// Returns what a row looks at, before any shape: its number at rest, and how it turns a delta into a change.
    pub(super) fn seen(&self, row: [f32; 4]) -> (f64, [f64; 3]) {
        let [a, b, c, d] = row.map(f64::from);
        let [x, y, z] = self.transform;
        let along = |i: usize| a * at(x, i) + b * at(y, i) + c * at(z, i);
        let own = [along(0), along(1), along(2)];
        let [u, v, w] = own;
        let [r, s, t] = self.rest;
        (u * r + v * s + w * t + along(3) + d, own)
    }
}

fn at(row: [f64; 4], i: usize) -> f64 {
    row.get(i).copied().unwrap_or_default()
}

/// Refuses what a pin would make infinite.
pub(super) fn not_finite(pin: usize) -> CallError {
    CallError::new(CallErrorKind::NonFinite, Argument::Pins).at(pin)
}
