//! The least that a frame needs, of which sizes are measured.

use core::hint::black_box;
use sinew_runtime::{CallError, Envelope, Matrix3x4, Model, Skin};

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
    let frame = |envelope: Envelope<'_>, skin: Skin<'_>| {
        let (pose, out_palette) = black_box::<(&[Matrix3x4], &mut [Matrix3x4])>((&[], &mut []));
        let (scratch, out) = black_box::<(&mut [f32], &mut [[f32; 3]])>((&mut [], &mut []));
        let confidence = palette(&envelope, pose, scratch, out_palette)?;
        skin.skin_positions(out_palette, out)?;
        Ok::<_, CallError>(confidence)
    };
    let views = model.envelope().zip(model.skin());
    views.is_some_and(|(envelope, skin)| black_box(frame(envelope, skin)).is_ok())
}
