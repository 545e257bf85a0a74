//! The pose features: how each joint has turned and moved against its parent (METHOD §1.9).

use super::key::joint_index;
use super::view::Envelope;
use crate::linear::{IDENTITY, Matrix3x4, columns, dot, floats};

/// Evaluates the stage: [`crate::stages::features`] of arguments that have been checked.
pub(crate) fn evaluate(
    envelope: &Envelope<'_>,
    pose: &[Matrix3x4],
    out_features: &mut [Matrix3x4],
) {
    let joints = envelope.parents().iter().zip(envelope.origins());
    for ((map, out), (parent, origin)) in pose.iter().zip(out_features).zip(joints) {
        let parent = joint_index(parent).and_then(|parent| pose.get(parent));
        *out = parent.map_or([[0.0; 4]; 3], |parent| relative(parent, map, floats(origin)));
    }
}

/// Returns `[R - I | (R - I) o + t]`; the difference is taken first, so that rest is exactly 0.
fn relative(parent: &Matrix3x4, map: &Matrix3x4, origin: [f32; 3]) -> Matrix3x4 {
    let mut apart = *map;
    for (row, parent) in apart.iter_mut().zip(parent) {
        row[3] -= parent[3];
    }
    let [a, b, c] = apart;
    let mut out = [[0.0; 4]; 3];
    for ((row, [x, y, z]), unit) in out.iter_mut().zip(columns(parent)).zip(IDENTITY) {
        for (value, ((a, b), c)) in row.iter_mut().zip(a.iter().zip(&b).zip(&c)) {
            *value = x * a + y * b + z * c;
        }
        row.iter_mut().zip(unit).for_each(|(value, unit)| *value -= unit);
        let [x, y, z, t] = *row;
        row[3] = dot([x, y, z], origin) + t;
    }
    out
}
