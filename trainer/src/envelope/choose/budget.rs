//! What the files of fits take, and whether a budget has room for them.

use crate::envelope::error::TrainError;
use crate::envelope::fitted::{Fitted, NAME};
use crate::envelope::lbs::blend::Weights;
use crate::envelope::lbs::training::Training;
use crate::envelope::levels;
use crate::envelope::model::{FileModel, RecordModel, SkinModel};
use crate::envelope::options::{FileSkins, Options};
use sinew_runtime::envelope::Certificate;
use sinew_runtime::skin::NormalErrors;

/// How many bytes a file may have, and what it holds beside the envelope that is chosen.
pub(super) struct Budget<'a> {
    training: &'a Training<'a>,
    options: &'a Options,
    record: RecordModel,
    /// Bytes of the smallest file that was tried.
    least: usize,
}

impl<'a> Budget<'a> {
    /// Refuses a budget that no model can meet, before anything is fitted: each holds the skeleton and, of every vertex, a
    /// weight at least.
    ///
    /// # Errors
    /// [`TrainError::BudgetOfMesh`].
    pub(super) fn new(
        training: &'a Training<'a>,
        options: &'a Options,
    ) -> Result<Self, TrainError> {
        let lbs = &training.lbs.weights;
        let mut frames = training.poses.frames();
        frames.dedup();
        let mut record = RecordModel::new(NAME, training.examples, &frames, lbs);
        if matches!(options.meshes, FileSkins::PaletteAlone) {
            // Of weights without a mesh nothing can be made.
            record.lbs = None;
        }
        let own = Self { training, options, record, least: usize::MAX };
        if let Some(budget) = options.budget {
            let strongest = |vertex| vec![(lbs.strongest(vertex).unwrap_or(0), 1.0)];
            let weights = Weights::from_lists(1, (0..lbs.len()).map(strongest));
            let least = own.size(&Fitted::new(training, weights, None), false)?;
            if least > budget {
                return Err(TrainError::BudgetOfMesh { budget, least });
            }
        }
        Ok(own)
    }

    /// Most bytes of a file.
    pub(super) fn most(&self) -> usize {
        self.options.budget.unwrap_or(usize::MAX)
    }

    /// Whether skins are to have tangent coefficients, as it is tried: under a budget positions may need their bytes.
    pub(super) fn with_coefficients(&self) -> impl Iterator<Item = bool> + use<> {
        [true].into_iter().chain(self.options.budget.map(|_| false))
    }

    /// Counts the bytes of the file of a candidate.
    pub(super) fn bytes(
        &mut self,
        fitted: &Fitted,
        coefficients: bool,
    ) -> Result<usize, TrainError> {
        let bytes = self.size(fitted, coefficients)?;
        self.least = self.least.min(bytes);
        Ok(bytes)
    }

    /// Says that nothing which was tried fits.
    pub(super) fn exceeded(&self) -> TrainError {
        TrainError::Budget { budget: self.most(), least: self.least }
    }

    /// Bakes a model with the record of its training, as much of it as there is room for.
    pub(super) fn recorded(&self, mut model: FileModel) -> Result<Vec<u8>, TrainError> {
        let most = self.most();
        let marks = RecordModel { lbs: None, ..self.record.clone() };
        for record in [self.record.clone(), marks] {
            model.records = vec![record];
            let bytes = model.bake()?;
            if bytes.len() <= most {
                return Ok(bytes);
            }
        }
        model.records.clear();
        Ok(model.bake()?)
    }

    fn size(&self, fitted: &Fitted, coefficients: bool) -> Result<usize, TrainError> {
        let mut model = fitted.file_model(self.training, Certificate::default());
        match &self.options.meshes {
            FileSkins::Skins(further) => {
                levels::reserve(&mut model, further);
                if coefficients {
                    model.skins.iter_mut().for_each(SkinModel::reserve_coefficients);
                }
                if let Some(own) = model.skins.first_mut() {
                    own.normal_errors = Some(NormalErrors { model: 0.0, lbs: 0.0 });
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
