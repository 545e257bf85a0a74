//! Sizes of model files, and the budget of bytes.

use crate::Error;
use crate::envelope::fitted::{Fitted, NAME};
use crate::envelope::lbs::blend::Weights;
use crate::envelope::lbs::training::Training;
use crate::envelope::levels;
use crate::envelope::model::{FileModel, RecordModel, SkinModel};
use crate::envelope::options::{FileSkins, Options};
use sinew_runtime::envelope::Certificate;
use sinew_runtime::skin::NormalErrors;

/// Largest size of the file, and the parts of the file besides the envelope.
pub(super) struct Budget<'a> {
    training: &'a Training<'a>,
    options: &'a Options,
    record: RecordModel,
    /// Bytes of the smallest candidate.
    least: usize,
}

impl<'a> Budget<'a> {
    /// Creates the budget, and refuses a budget below the size of the skeleton and one weight a vertex.
    ///
    /// # Errors
    /// - No model can meet the budget.
    /// - The smallest model cannot be baked.
    pub(super) fn new(training: &'a Training<'a>, options: &'a Options) -> Result<Self, Error> {
        let lbs = &training.lbs.weights;
        let mut frames = training.poses.frames();
        frames.dedup();
        let mut record = RecordModel::new(NAME, training.examples, &frames, lbs);
        if matches!(options.meshes, FileSkins::PaletteAlone) {
            // Weights are useless without a mesh.
            record.lbs = None;
        }
        let budget = Self { training, options, record, least: usize::MAX };
        if let Some(most) = options.budget {
            let strongest = |vertex| vec![(lbs.strongest(vertex).unwrap_or(0), 1.0)];
            let weights = Weights::from_lists(1, (0..lbs.len()).map(strongest));
            let least = budget.size(&Fitted::new(training, weights, None), false)?;
            if least > most {
                return Err(Error::limit(format!(
                    "a budget of {most} bytes is too small: skeleton and mesh alone take {least}"
                )));
            }
        }
        Ok(budget)
    }

    /// Returns the largest size of the file, in bytes.
    pub(super) fn most(&self) -> usize {
        self.options.budget.unwrap_or(usize::MAX)
    }

    /// Lists the options for tangent coefficients. Under a budget a model without them is tried too: positions may need
    /// their bytes.
    pub(super) fn with_coefficients(&self) -> impl Iterator<Item = bool> + use<> {
        [true].into_iter().chain(self.options.budget.map(|_| false))
    }

    /// Computes the bytes of a candidate's file.
    pub(super) fn bytes(&mut self, fitted: &Fitted, coefficients: bool) -> Result<usize, Error> {
        let bytes = self.size(fitted, coefficients)?;
        self.least = self.least.min(bytes);
        Ok(bytes)
    }

    /// Returns the budget error.
    pub(super) fn exceeded(&self) -> Error {
        Error::limit(format!(
            "a budget of {} bytes is too small: the smallest model that was tried takes {}, \
             most of which is the mesh itself",
            self.most(),
            self.least
        ))
    }

    /// Bakes a model with the record of its training. The record is shortened or left out if the budget requires it.
    pub(super) fn recorded(&self, mut model: FileModel) -> Result<Vec<u8>, Error> {
        let most = self.most();
        let without_lbs = RecordModel { lbs: None, ..self.record.clone() };
        for record in [self.record.clone(), without_lbs] {
            model.records = vec![record];
            let bytes = model.bake()?;
            if bytes.len() <= most {
                return Ok(bytes);
            }
        }
        model.records.clear();
        model.bake()
    }

    fn size(&self, fitted: &Fitted, coefficients: bool) -> Result<usize, Error> {
        let mut model = fitted.file_model(self.training, Certificate::default());
        match &self.options.meshes {
            FileSkins::Skins(further) => {
                levels::reserve(&mut model, further);
                if coefficients {
                    model.skins.iter_mut().for_each(SkinModel::reserve_coefficients);
                }
                if let Some(own) = model.skins.first_mut() {
                    own.normal_errors = Some(NormalErrors { model: 0.0, cofactors: 0.0, lbs: 0.0 });
                }
            }
            FileSkins::PaletteAlone => model.skins.clear(),
        }
        if self.options.budget.is_none() {
            model.records.push(self.record.clone());
        }
        Ok(model.bake()?.len())
    }
}
