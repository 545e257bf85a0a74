//! The normals of the model that was chosen.

use super::{Fan, PosedSurface};
use crate::envelope::error::TrainError;
use crate::envelope::lbs::training::Training;
use crate::envelope::model::FileModel;
use crate::evaluate::{Baseline, Character, EvaluateError, Measured};
use faer::Mat;
use sinew_runtime::skin::NormalErrors;

/// Frames whose normals are in memory at the same time.
const FEW_FRAMES: usize = 16;

/// Fits the tangent coefficients of a model's own skin, and measures its normals on the training frames as
/// `evaluate` does.
///
/// - `palettes`: of the training poses, 3n x 4 a transform, in training units; `None` for a skin without coefficients.
/// - `most`: influences that a vertex may have for the sake of its normal.
pub fn fit_normals(
    model: &mut FileModel,
    palettes: Option<&Mat<f64>>,
    most: usize,
    training: &Training,
) -> Result<(), TrainError> {
    let examples = training.examples;
    if let Some(palettes) = palettes {
        let surface = PosedSurface {
            rest: &training.rest,
            trajectories: &training.trajectories,
            palettes,
            fans: &Fan::of(&examples.surface()),
            authored: examples.surface().authored_normals().is_some(),
        };
        model.skins.iter_mut().for_each(|skin| surface.fit(skin, training.unit, most));
    }
    let bytes = model.bake()?;
    let character = Character::open(&bytes, None, examples)?;
    let frames = training.poses.frames();
    let measured = rms(&frames, |few| Measured::model(&character, examples, few))?;
    let lbs = Baseline::new(training.lbs.weights.clone(), examples);
    let lbs = rms(&frames, |few| Ok(Measured::lbs(&lbs, examples, few)))?;
    let errors = NormalErrors { model: measured as f32, lbs: lbs as f32 };
    model.skins.iter_mut().for_each(|skin| skin.normal_errors = Some(errors));
    Ok(())
}

/// Measures a few frames at a time. Returns the RMS angle between normals and true normals over all frames, in radians.
fn rms(
    frames: &[usize],
    measure: impl Fn(&[usize]) -> Result<Measured, EvaluateError>,
) -> Result<f64, EvaluateError> {
    let (mut sum, mut all) = (0.0, 0.0);
    for few in frames.chunks(FEW_FRAMES) {
        let own = measure(few)?.squared_angles();
        (sum, all) = (sum + own.0, all + own.1);
    }
    Ok((sum / all.max(f64::MIN_POSITIVE)).sqrt())
}
