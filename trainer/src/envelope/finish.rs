//! What is done to the model that was chosen: its normals, and what it tells of its training.

use super::error::TrainError;
use super::evaluate::{Baseline, Character, Measured};
use super::model::{FileModel, RecordModel};
use super::normals::{Fan, PosedSurface};
use crate::envelope::skin::training::Training;
use crate::examples::Examples;
use faer::Mat;
use sinew_runtime::skin::NormalErrors;

/// Fits the tangent coefficients of a model's own skin, and measures its normals on the training frames as
/// `evaluate` does.
///
/// - `palettes`: of the training poses, 3n x 4 a transform, in training units; `None` for a skin without coefficients.
pub(super) fn fit_normals(
    model: &mut FileModel,
    palettes: Option<&Mat<f64>>,
    training: &Training,
    examples: &Examples,
) -> Result<(), TrainError> {
    if let Some(palettes) = palettes {
        let surface = PosedSurface {
            rest: &training.rest,
            trajectories: &training.trajectories,
            palettes,
            fans: &Fan::of(&examples.surface()),
            authored: examples.surface().authored_normals().is_some(),
        };
        model.skins.iter_mut().for_each(|skin| surface.fit(skin, training.unit));
    }
    let bytes = model.bake()?;
    let character = Character::open(&bytes, None, examples)?;
    let frames: Vec<usize> = training.poses.times().iter().map(|time| time.frame).collect();
    let measured = Measured::model(&character, examples, &frames)?.angle_rms();
    let lbs = Baseline::new(training.lbs.weights.clone(), examples);
    let lbs = Measured::lbs(&lbs, examples, &frames).angle_rms();
    let errors = NormalErrors { model: measured as f32, lbs: lbs as f32 };
    model.skins.iter_mut().for_each(|skin| skin.normal_errors = Some(errors));
    Ok(())
}

/// Bakes a model with the record of its training, as much of it as a budget has room for.
pub(super) fn recorded(
    mut model: FileModel,
    record: RecordModel,
    budget: Option<usize>,
) -> Result<Vec<u8>, TrainError> {
    let marks = RecordModel { lbs: None, ..record.clone() };
    for record in [record, marks] {
        model.records = vec![record];
        let bytes = model.bake()?;
        if budget.is_none_or(|budget| bytes.len() <= budget) {
            return Ok(bytes);
        }
    }
    model.records.clear();
    Ok(model.bake()?)
}
