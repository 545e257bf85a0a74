//! The least that a frame needs, of which sizes are measured.

use core::hint::black_box;
use sinew_runtime::{CallError, Envelope, Matrix3x4, Model};

/// Loads, computes the palette of a pose and skins positions, all of them unknown to the compiler.
#[inline(always)]
pub fn skinned_by(
    palette: impl Fn(
        &Envelope<'_>,
        &[Matrix3x4],
        &mut [f32],
        &mut [Matrix3x4],
    ) -> Result<f32, CallError>,
) -> bool {
    let Ok(model) = Model::from_bytes(black_box::<&[u8]>(&[])) else { return false };
    let Some(envelope) = model.envelope() else { return false };
    let Some(skin) = model.skin() else { return false };
    let (pose, out_palette) = black_box::<(&[Matrix3x4], &mut [Matrix3x4])>((&[], &mut []));
    let (scratch, out) = black_box::<(&mut [f32], &mut [[f32; 3]])>((&mut [], &mut []));
    let done = palette(&envelope, pose, scratch, out_palette);
    black_box(done).is_ok() && black_box(skin.skin_positions(out_palette, out)).is_ok()
}
