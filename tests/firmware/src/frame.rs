//! Frames whose sizes are measured: the smallest frame, and a frame with every output.

use core::hint::black_box;
#[cfg(feature = "shapes")]
use sinew_runtime::ShapesJob;
use sinew_runtime::skin::Output;
use sinew_runtime::{
    CallError, Envelope, LocalTransform, Matrix3x4, Model, Skin, SkinJob, model_space_pose,
};

/// Loads, computes the palette of a pose and skins positions, with arguments unknown to the
/// compiler.
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
    let Some(envelope) = model.first::<Envelope>() else { return false };
    let Some(skin) = model.first::<Skin>() else { return false };
    let (pose, out_palette) = black_box::<(&[Matrix3x4], &mut [Matrix3x4])>((&[], &mut []));
    let (scratch, out) = black_box::<(&mut [f32], &mut [[f32; 3]])>((&mut [], &mut []));
    let done = palette(&envelope, pose, scratch, out_palette);
    black_box(done).is_ok() && black_box(skin.skin_positions(out_palette, out)).is_ok()
}

/// Loads, poses, skins positions, with the feature `normals` also normals and tangents, and computes
/// bounds; `None` if nothing is loaded.
#[inline(always)]
pub fn whole(bytes: &[u8]) -> Option<Result<(), CallError>> {
    let model = Model::from_bytes(bytes).ok()?;
    let (envelope, skin) = (model.first::<Envelope>()?, model.first::<Skin>()?);
    let local = black_box::<&[LocalTransform]>(&[]);
    let (pose, palette) = black_box::<(&mut [Matrix3x4], &mut [Matrix3x4])>((&mut [], &mut []));
    let (scratch, out) = black_box::<(&mut [f32], &mut [f32])>((&mut [], &mut []));
    let mut frame = || {
        model_space_pose(&envelope, local, pose)?;
        black_box(envelope.palette(pose, black_box::<&[f32]>(&[]), scratch, palette)?);
        black_box(skin.bounds(palette, 0.0)?);
        let [positions, normals, tangents] = Output::interleaved(out, 10, [0, 3, 6]);
        let job = SkinJob::new(skin, palette).positions(black_box(Some(positions)));
        #[cfg(feature = "normals")]
        let job = job.normals(black_box(Some(normals))).tangents(black_box(Some(tangents)));
        #[cfg(not(feature = "normals"))]
        let _ = (normals, tangents);
        job.run()
    };
    Some(frame())
}

/// Loads, shapes positions at rest, and computes bounds; `None` if nothing is loaded.
#[cfg(feature = "shapes")]
#[inline(always)]
pub fn shaped(bytes: &[u8]) -> Option<Result<(), CallError>> {
    let model = Model::from_bytes(bytes).ok()?;
    let skin = model.first::<Skin>()?;
    let (weights, out) = black_box::<(&[f32], &mut [f32])>((&[], &mut []));
    let mut frame = || {
        black_box(skin.shaped_bounds(black_box(&[]), weights)?);
        let positions = black_box(Some(Output::new(out, 3)));
        ShapesJob::new(skin, weights).positions(positions).run()
    };
    Some(frame())
}
