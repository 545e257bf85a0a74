//! Stages of the rotational predictor: gradients (METHOD §1.1, §1.4, §1.5) and palette (METHOD §1.7.3).

use super::counts::STRAIN_LEN;
use super::polar::is_hidden;
use super::view::{Envelope, KeyRow, joint_index};
use crate::linear::{
    Columns, IDENTITY, Le, Matrix3x4, add_block_product, columns, compose, cross, dot, floats,
    product, quaternion, rows, turn_back,
};
use crate::numeric::{quadrant_angle, sin_versine, sqrt};
use crate::unit::level;

/// Evaluates stage gradients: [`crate::stages::gradients`] with checked arguments.
///
/// - `turns`, `strains`: J rotations and strains from stage polar; empty if no joint stretches.
pub(crate) fn gradients(
    envelope: &Envelope<'_>,
    pose: &[Matrix3x4],
    (turns, strains): (&[Columns], &[[f32; STRAIN_LEN]]),
    out_relative: &mut [[f32; 3]],
    out_rotations: &mut [[f32; 3]],
    out_gradients: &mut [[f32; 3]],
) {
    let (relative, _) = out_relative.as_chunks_mut::<4>();
    remove_root_motion(pose, envelope, relative);
    let turn = |joint: usize| turns.get(joint).unwrap_or_else(|| rotation(relative, joint));
    let parents = envelope.parents();
    for (joint, (out, parent)) in out_rotations.iter_mut().zip(parents).enumerate() {
        *out = match joint_index(parent) {
            None => [0.0; 3],
            Some(parent) => {
                let mut own = *turn(joint);
                turn_back(turn(parent), &mut own);
                log(&own)
            }
        };
    }
    let root = turns.get(envelope.root());
    for (out, key) in out_gradients.as_chunks_mut().0.iter_mut().zip(envelope.keys()) {
        let parent = parents.get(key.joint).and_then(joint_index);
        let strain = strains.get(key.joint);
        let map = gradient(&key, parent, strain, out_rotations);
        *out = match (parent.map(turn), root) {
            (None, _) => map,
            (Some(parent), None) => product(parent, &map),
            (Some(parent), Some(root)) => {
                let mut parent = *parent;
                turn_back(root, &mut parent);
                product(&parent, &map)
            }
        };
    }
}

/// Evaluates stage palette, `t = c1 d + c2 q`: [`crate::stages::palette`] with checked arguments.
pub(crate) fn palette(
    envelope: &Envelope<'_>,
    root: &Matrix3x4,
    relative: &[[f32; 3]],
    gradients: &[[f32; 3]],
    out_palette: &mut [Matrix3x4],
) {
    let level = level();
    // Neither stack is empty; chunks of zero would panic.
    let blocks = envelope
        .c1_blocks()
        .chunks_exact(gradients.len().max(1))
        .zip(envelope.c2_blocks().chunks_exact(relative.len().max(1)));
    for ((c1, c2), out) in blocks.zip(out_palette.chunks_mut(2)) {
        let mut sums = [[0.0; 8]; 3];
        add_block_product(level, &mut sums, c1, gradients);
        add_block_product(level, &mut sums, c2, relative);
        // A block is two transforms: rows 0 to 3, then 4 to 7.
        let [x, y, z] = &sums;
        let rows = x.as_chunks().0.iter().zip(y.as_chunks().0);
        for (out, ((x, y), z)) in out.iter_mut().zip(rows.zip(z.as_chunks().0)) {
            *out = compose(root, &[*x, *y, *z]);
        }
    }
}

/// Computes the joints' transforms relative to the root: 4 columns for each joint.
///
/// The root is taken as rigid if no joint stretches.
fn remove_root_motion(
    pose: &[Matrix3x4],
    envelope: &Envelope<'_>,
    out_relative: &mut [[[f32; 3]; 4]],
) {
    let root = envelope.root();
    let Some([x, y, z, origin]) = pose.get(root).map(columns) else { return };
    let mut rotation = [x, y, z];
    if envelope.stretches() {
        // Columns of the inverse's transpose.
        let cofactors = [cross(y, z), cross(z, x), cross(x, y)];
        let scale =
            pose.get(root).filter(|map| !is_hidden(map)).map(|_| 1.0 / dot(x, cofactors[0]));
        rotation = cofactors.map(|column| column.map(|value| value * scale.unwrap_or_default()));
    }
    for (out, map) in out_relative.iter_mut().zip(pose) {
        let [x, y, z, t] = columns(map);
        let t = [t[0] - origin[0], t[1] - origin[1], t[2] - origin[2]];
        *out = [x, y, z, t];
        turn_back(&rotation, out);
    }
    if let Some(out) = out_relative.get_mut(root) {
        let [x, y, z] = IDENTITY;
        *out = [x, y, z, [0.0; 3]];
    }
}

/// Evaluates the gradient of a key in the frame of the joint's parent, `exp(A theta_b) [exp(A' theta_c)] S`.
fn gradient(
    key: &KeyRow<'_>,
    parent: Option<usize>,
    strain: Option<&[f32; STRAIN_LEN]>,
    rotations: &[[f32; 3]],
) -> Columns {
    let theta = |joint: usize| rotations.get(joint).unwrap_or(&[0.0; 3]);
    let theta_p = parent.map_or(&[0.0; 3], theta);
    let mut out = scale_shear(key, theta(key.joint), theta_p, strain);
    if let Some((joint, twist)) = key.residual {
        out = turned(twist, theta(joint), &out);
    }
    turned(key.twist, theta(key.joint), &out)
}

/// Returns `exp(twist theta) m`.
fn turned(twist: &[Le; 9], theta: &[f32; 3], m: &Columns) -> Columns {
    let [x, y, z] = rows(&floats(twist));
    product(&exp([dot(x, *theta), dot(y, *theta), dot(z, *theta)]), m)
}

/// Returns the linear part of a joint's relative transform.
fn rotation(relative: &[[[f32; 3]; 4]], joint: usize) -> &Columns {
    relative.get(joint).and_then(|map| map.first_chunk()).unwrap_or(&IDENTITY)
}

/// Returns S = I + sym(H [theta_b; theta_p] + G E_b).
fn scale_shear(
    key: &KeyRow<'_>,
    b: &[f32; 3],
    p: &[f32; 3],
    strain: Option<&[f32; STRAIN_LEN]>,
) -> Columns {
    let mut sums = [0.0; STRAIN_LEN];
    for (sum, row) in sums.iter_mut().zip(key.shear.as_chunks::<6>().0) {
        let [h0, h1, h2, h3, h4, h5] = floats(row);
        *sum = dot([h0, h1, h2], *b) + dot([h3, h4, h5], *p);
    }
    if let (Some(stretch), Some([xx, xy, xz, yy, yz, zz])) = (key.stretch, strain) {
        for (sum, row) in sums.iter_mut().zip(stretch.as_chunks::<6>().0) {
            let [g0, g1, g2, g3, g4, g5] = floats(row);
            *sum += dot([g0, g1, g2], [*xx, *xy, *xz]) + dot([g3, g4, g5], [*yy, *yz, *zz]);
        }
    }
    let [xx, xy, xz, yy, yz, zz] = sums;
    [[1.0 + xx, xy, xz], [xy, 1.0 + yy, yz], [xz, yz, 1.0 + zz]]
}

/// Returns the rotation vector of a rotation matrix, with an angle in [0, pi].
///
/// The quaternion is not normalised, because the angle depends only on a ratio.
fn log(m: &Columns) -> [f32; 3] {
    let (v, w) = quaternion(m);
    let length = sqrt(dot(v, v));
    // A length that underflows belongs to the identity.
    if length < 1.0e-18 {
        return [0.0; 3];
    }
    let scale = 2.0 * quadrant_angle(length, w) / length;
    let [x, y, z] = v;
    [x * scale, y * scale, z * scale]
}

/// Returns the rotation matrix of a rotation vector, by Rodrigues' formula with the versine.
fn exp(v: [f32; 3]) -> Columns {
    let [x, y, z] = v;
    let square = dot(v, v);
    // Below this square sin(a)/a and versin(a)/a^2 equal their limits, but for rounding.
    let (a, b) = if square < 1.0e-8 {
        (1.0, 0.5)
    } else {
        let angle = sqrt(square);
        let (sine, versine) = sin_versine(angle);
        (sine / angle, versine / square)
    };
    [
        [1.0 - b * (y * y + z * z), b * (x * y) + a * z, b * (x * z) - a * y],
        [b * (x * y) - a * z, 1.0 - b * (x * x + z * z), b * (y * z) + a * x],
        [b * (x * z) + a * y, b * (y * z) - a * x, 1.0 - b * (x * x + y * y)],
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lists rotation vectors that reach every branch of the logarithm.
    fn vectors() -> impl Iterator<Item = [f32; 3]> {
        let axis = |i: u32| [i % 7, i / 7 % 7, i / 49].map(|x| x as f32 - 3.0);
        // Miri is slow.
        let axes = (0..343)
            .step_by(if cfg!(miri) { 31 } else { 1 })
            .map(axis)
            .filter(|a| dot(*a, *a) > 0.0);
        let angles = [1e-12, 1e-6, 1e-3, 0.1, 1.0, 2.0, 3.0, 3.125];
        axes.flat_map(move |a| angles.map(|angle| a.map(|x| x * angle / sqrt(dot(a, a)))))
    }

    fn error(a: [f32; 3], b: [f32; 3]) -> f32 {
        let d = [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
        sqrt(dot(d, d))
    }

    #[test]
    fn log_undoes_exp() {
        for v in vectors() {
            let length = sqrt(dot(v, v));
            // The entries of the matrix are about 1, with a few roundings; near 0 the direction is exact.
            assert!(error(log(&exp(v)), v) <= 2e-6 * length.min(1.0), "{v:?}");
        }
        assert!(error(log(&exp([0.1, 0.0, 0.0])), [0.1, 0.0, 1e-5]) > 1e-6, "the control fails");
    }

    #[test]
    fn exp_is_a_rotation() {
        for v in vectors() {
            let m = exp(v);
            let mut gram = m;
            turn_back(&m, &mut gram);
            for (column, unit) in gram.iter().zip(&IDENTITY) {
                assert!(error(*column, *unit) < 1e-6, "{v:?}");
            }
        }
    }

    #[test]
    fn half_turn_and_identity() {
        assert_eq!(log(&IDENTITY), [0.0; 3]);
        assert_eq!(exp([0.0; 3]), IDENTITY);
        let half = [[-1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0]];
        assert_eq!(log(&half).map(f32::abs), [0.0, 0.0, core::f32::consts::PI]);
    }

    #[test]
    fn log_of_a_scaled_rotation_keeps_its_axis() {
        let scaled = exp([0.0, 0.5, 0.0]).map(|c| c.map(|x| x * 1.0001));
        assert!(error(log(&scaled), [0.0, 0.5, 0.0]) < 1e-4);
    }
}
