//! Stage palette: from gradients and joints to the palette, `t = c1 d + c2 q` (METHOD §1.7.3).

use super::view::Envelope;
use crate::lanes::{Eight, Lanes};
use crate::linear::{Matrix3x4, add_block_product, compose};

/// Evaluates the stage: [`crate::stages::palette`] of arguments that have been checked.
pub(crate) fn evaluate(
    envelope: &Envelope<'_>,
    root: &Matrix3x4,
    relative: &[[f32; 3]],
    gradients: &[[f32; 3]],
    out_palette: &mut [Matrix3x4],
) {
    // Neither is empty; chunks of zero would panic.
    let blocks = envelope
        .c1_blocks()
        .chunks_exact(gradients.len().max(1))
        .zip(envelope.c2_blocks().chunks_exact(relative.len().max(1)));
    for ((c1, c2), out) in blocks.zip(out_palette.chunks_mut(2)) {
        let mut sums = [Lanes::default(); 3];
        add_block_product(&mut sums, c1, gradients);
        add_block_product(&mut sums, c2, relative);
        // A block is two transforms: rows 0 to 3, then 4 to 7.
        let [x, y, z] = &sums;
        let rows = x.floats().as_chunks().0.iter().zip(y.floats().as_chunks().0);
        for (out, ((x, y), z)) in out.iter_mut().zip(rows.zip(z.floats().as_chunks().0)) {
            *out = compose(root, &[*x, *y, *z]);
        }
    }
}
