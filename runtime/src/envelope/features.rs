//! The pose features: how each joint has turned and moved against its parent (METHOD §1.9).

use super::key::joint_index;
use super::view::Envelope;
use crate::linear::{Columns, IDENTITY, Matrix3x4, columns, dot, floats, quaternion};
use crate::numeric::sqrt;

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

/// Returns `[half R | (R - I) o + t]`; the difference is taken first, so that rest is exactly 0.
fn relative(parent: &Matrix3x4, map: &Matrix3x4, origin: [f32; 3]) -> Matrix3x4 {
    let mut apart = *map;
    for (row, parent) in apart.iter_mut().zip(parent) {
        row[3] -= parent[3];
    }
    let [a, b, c] = apart;
    let mut out = [[0.0; 4]; 3];
    for (row, [x, y, z]) in out.iter_mut().zip(columns(parent)) {
        for (value, ((a, b), c)) in row.iter_mut().zip(a.iter().zip(&b).zip(&c)) {
            *value = x * a + y * b + z * c;
        }
    }
    let [x, y, z, _] = columns(&out);
    for ((row, half), [x, y, z]) in out.iter_mut().zip(half(&[x, y, z])).zip(IDENTITY) {
        let [rx, ry, rz, t] = *row;
        let [hx, hy, hz] = half;
        *row = [hx, hy, hz, dot([rx - x, ry - y, rz - z], origin) + t];
    }
    out
}

/// Returns the rows of S - I, S turning half as far as a rotation does, its odd part fading toward half a turn.
///
/// With the rotation's unit quaternion w >= 0, v it is `(1 - (1 - w)^8) [v] + [v][v] / (1 + w)`, `[v]` the cross
/// product with v.
fn half(m: &Columns) -> [[f32; 3]; 3] {
    let ([x, y, z], w) = quaternion(m);
    let length = sqrt(dot([x, y, z], [x, y, z]) + w * w);
    let low = 1.0 - w / length;
    let low = low * low;
    let low = low * low;
    let odd = (1.0 - low * low) / length;
    let even = 1.0 / (length * (length + w));
    let [a, b, c] = [x * odd, y * odd, z * odd];
    let [xx, yy, zz] = [x * x, y * y, z * z];
    let [xy, xz, yz] = [even * (x * y), even * (x * z), even * (y * z)];
    [
        [-even * (yy + zz), xy - c, xz + b],
        [xy + c, -even * (xx + zz), yz - a],
        [xz - b, yz + a, -even * (xx + yy)],
    ]
}
