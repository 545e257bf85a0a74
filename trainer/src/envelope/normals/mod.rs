//! Accurate normals: tangent coefficients, fitted to the surface in the training frames (METHOD §1.8).

mod fan;
mod fit;
mod truth;
mod vertex;

pub use fan::Fan;
pub use fit::PosedSurface;
pub use truth::TrueNormals;

use crate::Error;
use crate::envelope::lbs::training::Training;
use crate::envelope::model::FileModel;
use crate::evaluate::{Baseline, Character, Measured};
use faer::Mat;
use sinew_runtime::skin::NormalErrors;

/// Number of frames measured at a time, to limit memory.
const CHUNK: usize = 16;

/// Fits the tangent coefficients of a model's skins. Then measures the normals on the training frames, as `evaluate`
/// does.
///
/// - `palettes`: of the training poses, 3n x 4 per transform, in training units; `None` for a skin without
///   coefficients.
/// - `influences_max`: maximum number of influences of a vertex, influences for its normal included.
///
/// # Errors
/// The model cannot be baked, opened or evaluated.
pub fn fit_normals(
    model: &mut FileModel,
    palettes: Option<&Mat<f64>>,
    influences_max: usize,
    training: &Training,
) -> Result<(), Error> {
    let examples = training.examples;
    let frames = training.poses.frames();
    let measure = |model: &FileModel| {
        let bytes = model.bake()?;
        let character = Character::open(&bytes, None, examples)?;
        rms(&frames, |chunk| Measured::model(&character, examples, chunk))
    };
    let cofactors = measure(model)?;
    let mut measured = cofactors;
    if let Some(palettes) = palettes {
        let surface = PosedSurface {
            rest: &training.rest,
            trajectories: &training.trajectories,
            palettes,
            fans: &Fan::of(&examples.surface()),
            authored: examples.surface().authored_normals().is_some(),
        };
        model.skins.iter_mut().for_each(|skin| surface.fit(skin, training.unit, influences_max));
        measured = measure(model)?;
    }
    let lbs = Baseline::new(training.lbs.weights.clone(), examples);
    let lbs = rms(&frames, |chunk| Ok(Measured::lbs(&lbs, examples, chunk)))?;
    let [model_rms, cofactors, lbs] = [measured, cofactors, lbs].map(|angle| angle as f32);
    let errors = NormalErrors { model: model_rms, cofactors, lbs };
    model.skins.iter_mut().for_each(|skin| skin.normal_errors = Some(errors));
    Ok(())
}

/// Returns the RMS angle between normals and true normals over all frames, in radians.
///
/// - `measure`: measures a few frames.
fn rms(
    frames: &[usize],
    measure: impl Fn(&[usize]) -> Result<Measured, Error>,
) -> Result<f64, Error> {
    let (mut sum, mut all) = (0.0, 0.0);
    for chunk in frames.chunks(CHUNK) {
        let part = measure(chunk)?.squared_angles();
        (sum, all) = (sum + part.0, all + part.1);
    }
    Ok((sum / all.max(f64::MIN_POSITIVE)).sqrt())
}
