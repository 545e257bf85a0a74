//! Stage 2: from gradients and joints to the palette, `t = c1 d + c2 q` (METHOD §1.7.3).

use super::view::Envelope;
use crate::error::{Argument, CallError};
use crate::linear::{Matrix3x4, add_block_product, compose};

/// Computes the palette from what [`crate::stages::gradients`] gives.
///
/// - `root`: the root's skinning matrix B_r, which moves the result back: `T_l <- B_r T_l`.
/// - `relative`: the stack q, 4 J columns.
/// - `gradients`: the stack d, 3 P columns.
/// - `out_palette`: P transforms, rest to posed, in model space; `T_l[r][c]` is row 4 l + c of t.
///
/// # Errors
/// - [`crate::CallErrorKind::NoStage`]: the model is of the kernel predictor and has no c1 and c2.
/// - [`crate::CallErrorKind::Length`]: an argument has another length.
pub fn evaluate(
    envelope: &Envelope<'_>,
    root: &Matrix3x4,
    relative: &[[f32; 3]],
    gradients: &[[f32; 3]],
    out_palette: &mut [Matrix3x4],
) -> Result<(), CallError> {
    envelope.check_stage(envelope.predictor().reconstructs())?;
    let (d_len, q_len) = (3 * envelope.proxy_len(), 4 * envelope.joint_len());
    Argument::Relative.check_len(q_len, relative.len())?;
    Argument::Gradients.check_len(d_len, gradients.len())?;
    Argument::Palette.check_len(envelope.palette_len(), out_palette.len())?;
    // Counts of a loaded model are at least one; chunks of zero would panic.
    let blocks = envelope
        .c1_blocks()
        .chunks_exact(d_len.max(1))
        .zip(envelope.c2_blocks().chunks_exact(q_len.max(1)));
    for ((c1, c2), out) in blocks.zip(out_palette.chunks_mut(2)) {
        let mut sums = [[0.0; 8]; 3];
        add_block_product(&mut sums, c1, gradients);
        add_block_product(&mut sums, c2, relative);
        // A block is two transforms: rows 0 to 3, then 4 to 7.
        let [x, y, z] = sums.each_ref().map(|row| row.as_chunks::<4>().0);
        for (out, ((x, y), z)) in out.iter_mut().zip(x.iter().zip(y).zip(z)) {
            *out = compose(root, &[*x, *y, *z]);
        }
    }
    Ok(())
}
