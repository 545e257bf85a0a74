//! The least that a frame needs, of which sizes are measured.

use core::hint::black_box;
use sinew_runtime::{Envelope, EvalError, Matrix3x4, Model};

/// Loads, computes the palette of a pose and skins positions, all of them unknown to the compiler.
#[inline(always)]
pub fn skinned_by(
    palette: impl Fn(
        &Envelope<'static>,
        &[Matrix3x4],
        &mut [f32],
        &mut [Matrix3x4],
    ) -> Result<f32, EvalError>,
) -> bool {
    let envelope = Model::from_bytes(black_box(&[])).ok().and_then(|model| model.envelope());
    let frame = |envelope: Envelope<'static>| {
        let (pose, maps) = black_box::<(&[Matrix3x4], &mut [Matrix3x4])>((&[], &mut []));
        let (workspace, out) = black_box::<(&mut [f32], &mut [[f32; 3]])>((&mut [], &mut []));
        let confidence = palette(&envelope, pose, workspace, maps)?;
        envelope.skin_positions(maps, out)?;
        Ok::<_, EvalError>(confidence)
    };
    envelope.is_some_and(|envelope| black_box(frame(envelope)).is_ok())
}
