//! Functions of an engine, such as the matrix product, and measures of the tests.

use sinew_runtime::{Envelope, Matrix3x4, Model, Skin};

/// Returns the matrix product a b: `b` applies first.
pub(crate) fn product(a: &Matrix3x4, b: &Matrix3x4) -> Matrix3x4 {
    a.map(|[x, y, z, shift]| {
        let mut row = [0, 1, 2, 3].map(|c| x * b[0][c] + y * b[1][c] + z * b[2][c]);
        row[3] += shift;
        row
    })
}

/// Transforms a point.
pub(crate) fn moved(m: &Matrix3x4, [x, y, z]: [f32; 3]) -> [f32; 3] {
    m.map(|[a, b, c, shift]| a * x + b * y + c * z + shift)
}

/// Returns the largest distance between corresponding points, divided by `length`.
pub(crate) fn farthest(a: &[[f32; 3]], b: &[[f32; 3]], length: f32) -> f32 {
    assert_eq!(a.len(), b.len());
    let squared = |(a, b): (&[f32; 3], &[f32; 3])| (0..3).map(|c| (a[c] - b[c]).powi(2)).sum();
    let most = a.iter().zip(b).map(squared).fold(0.0, f32::max);
    most.sqrt() / length
}

/// Returns the diagonal of the points' bounding box.
pub(crate) fn diagonal(points: &[[f32; 3]]) -> f32 {
    let extent = |c: usize| {
        let all = points.iter().map(|point| point[c]);
        all.clone().fold(f32::MIN, f32::max) - all.fold(f32::MAX, f32::min)
    };
    (0..3).map(|c| extent(c).powi(2)).sum::<f32>().sqrt()
}

/// Returns the rest positions.
pub(crate) fn rest(skin: &Skin<'_>) -> Vec<[f32; 3]> {
    (0..skin.vertex_len()).map(|v| skin.rest_position(v).unwrap()).collect()
}

/// Predicts a palette of a model without curves.
pub(crate) fn palette(envelope: &Envelope<'_>, pose: &[Matrix3x4]) -> (Vec<Matrix3x4>, f32) {
    curved_palette(envelope, pose, &[])
}

/// Predicts a palette.
pub(crate) fn curved_palette(
    envelope: &Envelope<'_>,
    pose: &[Matrix3x4],
    curves: &[f32],
) -> (Vec<Matrix3x4>, f32) {
    let mut scratch = vec![0.0; envelope.scratch_len()];
    let mut palette = vec![Matrix3x4::default(); envelope.palette_len()];
    let confidence = envelope.palette(pose, curves, &mut scratch, &mut palette).unwrap();
    (palette, confidence)
}

/// Skins all positions.
pub(crate) fn skinned<B: AsRef<[u8]>>(model: &Model<B>, palette: &[Matrix3x4]) -> Vec<[f32; 3]> {
    let skin = model.first::<Skin>().unwrap();
    let mut positions = vec![[0.0; 3]; skin.vertex_len()];
    skin.skin_positions(palette, &mut positions).unwrap();
    positions
}
