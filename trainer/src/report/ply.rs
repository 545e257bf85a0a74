//! Errors by vertex, as a mesh for other tools.

use super::comparison::Comparison;
use crate::page::colour::Scale;

/// Writes the rest mesh as binary little-endian PLY: each vertex has its position, the colour of its
/// error, and `error`, its RMS over the measured frames in % of the rest diagonal, as floats.
pub fn rest_mesh(comparison: &Comparison<'_>) -> Vec<u8> {
    let examples = comparison.source.examples;
    let errors = comparison.model.measured.vertex_rms_percent();
    let scale = Scale::of(&errors);
    let mut out = format!(
        "ply\nformat binary_little_endian 1.0\n\
         comment error: RMS over {} frames ({}), % of the rest diagonal; colours up to {}\n\
         element vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
         property uchar red\nproperty uchar green\nproperty uchar blue\nproperty float error\n\
         element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        comparison.model.measured.frames.len(),
        comparison.frames.name(),
        scale.most,
        examples.vertex_len(),
        examples.triangles.len()
    )
    .into_bytes();
    for (position, &error) in examples.rest.iter().zip(&errors) {
        position.iter().for_each(|x| out.extend((*x as f32).to_le_bytes()));
        out.extend(scale.colour(error));
        out.extend((error as f32).to_le_bytes());
    }
    for corners in &examples.triangles {
        out.push(3);
        corners.iter().for_each(|corner| out.extend((*corner as i32).to_le_bytes()));
    }
    out
}
