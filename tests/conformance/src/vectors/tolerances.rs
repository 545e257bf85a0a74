//! Tolerances as they are written.

use crate::tolerance::{Inexact, Transform, UNDERFLOW};
use nalgebra::SMatrix;
use sinew_runtime::Matrix3x4;

/// How far from the value that is written, the CPU's, a backend's may be: as far from the oracle's
/// as its arithmetic explains, and as far as the CPU's is from that; rounded up.
pub(super) struct Tolerance(pub(super) Vec<f32>);

impl Tolerance {
    /// Begins with nothing.
    pub(super) const fn new() -> Self {
        Self(Vec::new())
    }

    /// Adds that of a value.
    pub(super) fn add(&mut self, cpu: f32, oracle: f64, error: f64) {
        let apart = (f64::from(cpu) - oracle).abs();
        let most = if error + apart > 0.0 { error + UNDERFLOW + apart } else { 0.0 };
        let rounded = most as f32;
        self.0.push(if f64::from(rounded) < most { rounded.next_up() } else { rounded });
    }

    /// Adds those of columns.
    pub(super) fn columns<const C: usize>(
        &mut self,
        found: &[[f32; 3]],
        bounds: &Inexact<SMatrix<f64, 3, C>>,
    ) {
        let right = bounds.value.iter().flatten().zip(bounds.error.iter().flatten());
        for (x, (value, error)) in found.as_flattened().iter().zip(right) {
            self.add(*x, *value, *error);
        }
    }

    /// Adds those of transforms.
    pub(super) fn transforms(&mut self, found: &[Matrix3x4], bounds: &Inexact<Transform>) {
        for (found, (value, error)) in found.iter().zip(bounds.value.iter().zip(&bounds.error)) {
            for (r, row) in found.iter().enumerate() {
                for (c, x) in row.iter().enumerate() {
                    self.add(*x, value[(r, c)], error[(r, c)]);
                }
            }
        }
    }
}

/// Lists the tolerances of every pose's transforms.
pub(super) fn transforms_tolerance(found: &[Matrix3x4], bounds: &[Inexact<Transform>]) -> Vec<f32> {
    let mut out = Tolerance::new();
    for (i, bounds) in bounds.iter().enumerate() {
        out.transforms(&found[i * bounds.value.len()..], bounds);
    }
    out.0
}

/// Lists the tolerances of every pose's number.
pub(super) fn numbers_tolerance(found: &[f32], bounds: &[Inexact<f64>]) -> Vec<f32> {
    let mut out = Tolerance::new();
    for (x, bound) in found.iter().zip(bounds) {
        out.add(*x, bound.value[0], bound.error[0]);
    }
    out.0
}
