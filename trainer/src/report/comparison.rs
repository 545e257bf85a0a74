//! The subject of a report: models, examples, and the errors of the models on the examples.

use crate::Error;
use crate::evaluate::{
    Baseline, Baselines, Character, Evaluation, Frames, LBS, Measured, MeasuredBaseline,
    OWN_WEIGHTS, TrainingRecord,
};
use crate::examples::{Clip, Examples, FrameName, Split};
use crate::space::beside;

/// Examples and their names in a report.
#[derive(Clone, Copy)]
pub struct NamedExamples<'a> {
    /// The examples.
    pub examples: &'a Examples,
    /// The clips of the frames, in order; they cover all frames.
    pub clips: &'a [Clip],
    /// Name of the examples.
    pub name: &'a str,
}

/// A model's file and its name in a report.
#[derive(Clone, Copy)]
pub struct NamedModel<'a> {
    /// Name of the file.
    pub name: &'a str,
    /// Content of the file.
    pub bytes: &'a [u8],
    /// Name of the measured skin; the first skin if `None`.
    pub skin: Option<&'a str>,
}

/// One or two models and the baselines, with their errors on frames of the examples.
pub struct Comparison<'a> {
    /// The examples.
    pub source: NamedExamples<'a>,
    /// The measured frames.
    pub frames: Frames,
    /// The baselines.
    pub baselines: Baselines,
    /// The model.
    pub model: MeasuredModel<'a>,
    /// The second model, for comparison.
    pub other: Option<MeasuredModel<'a>>,
}

/// A model and its errors.
pub struct MeasuredModel<'a> {
    /// The model's file.
    pub file: NamedModel<'a>,
    /// The measured envelope and skin.
    pub character: Character<'a>,
    /// Its errors.
    pub measured: Measured,
    /// Number of measured frames that the training read; `None` if the file has no record.
    pub read: Option<usize>,
    /// The record of its training.
    pub record: TrainingRecord,
}

/// A model or baseline of the comparison.
#[derive(Clone, Copy)]
pub struct Series<'a> {
    /// Name of the series.
    pub name: &'a str,
    /// CSS class of the series.
    pub class: &'static str,
    /// Its errors.
    pub measured: &'a Measured,
    /// The model or baseline.
    pub skin: SeriesSkin<'a>,
}

/// The skin of a series.
#[derive(Clone, Copy)]
pub enum SeriesSkin<'a> {
    /// A baseline.
    Baseline(&'a Baseline),
    /// A model.
    Model(&'a MeasuredModel<'a>),
}

impl<'a> Series<'a> {
    /// Returns the model; `None` for a baseline.
    pub fn model(&self) -> Option<&'a MeasuredModel<'a>> {
        match self.skin {
            SeriesSkin::Baseline(_) => None,
            SeriesSkin::Model(model) => Some(model),
        }
    }
}

impl<'a> Comparison<'a> {
    /// Measures a model and the baselines on the given frames, or on [`Frames::default_for`].
    ///
    /// # Errors
    /// The errors of [`crate::evaluate::evaluate`].
    pub fn new(
        source: NamedExamples<'a>,
        frames: Option<Frames>,
        file: NamedModel<'a>,
    ) -> Result<Self, Error> {
        let NamedExamples { examples, .. } = source;
        let character = Character::open(file.bytes, file.skin, examples)?;
        let record = TrainingRecord::of(file.bytes, &character, examples);
        let frames = frames.unwrap_or_else(|| Frames::default_for(examples, &record));
        let chosen = frames.measurable(examples, &record)?;
        let measured = Measured::model(&character, examples, &chosen)?;
        let baselines = Baselines::new(&record, examples, &chosen);
        let model =
            MeasuredModel { file, character, measured, read: record.read_len(&chosen), record };
        Ok(Self { source, frames, baselines, model, other: None })
    }

    /// Measures a second model on the same frames.
    ///
    /// # Errors
    /// The errors of [`crate::evaluate::evaluate`].
    pub fn compare(&mut self, file: NamedModel<'a>) -> Result<(), Error> {
        let character = Character::open(file.bytes, file.skin, self.source.examples)?;
        let chosen = self.measured_frames();
        let measured = Measured::model(&character, self.source.examples, &chosen)?;
        let record = TrainingRecord::of(file.bytes, &character, self.source.examples);
        let read = record.read_len(&chosen);
        self.other = Some(MeasuredModel { file, character, measured, read, record });
        Ok(())
    }

    /// Lists the indices of the measured frames.
    pub fn measured_frames(&self) -> Vec<usize> {
        self.model.measured.frames.iter().map(|frame| frame.frame).collect()
    }

    /// Converts a length in % of the diagonal to millimetres; `None` if the unit is unknown.
    pub fn mm(&self, percent: f64) -> Option<f64> {
        self.model.measured.diagonal_mm.map(|diagonal| percent / 100.0 * diagonal)
    }

    /// Formats a length in % of the diagonal: `0.1234 %`, followed by ` (1.234 mm)` if the unit is known.
    pub fn length(&self, percent: f64) -> String {
        format!("{percent:.4} %{}", beside(percent, self.model.measured.diagonal_mm))
    }

    /// Returns the use of a frame in the training of the model, or its use in the examples if the file has no record.
    pub fn use_of(&self, frame: usize) -> Split {
        match (self.model.record.has_read(frame), self.source.examples.split[frame]) {
            (Some(true), _) => Split::Train,
            (Some(false), Split::Train) => Split::HeldOut,
            (_, split) => split,
        }
    }

    /// Lists the one or two models.
    pub fn models(&self) -> impl Iterator<Item = &MeasuredModel<'a>> {
        std::iter::once(&self.model).chain(&self.other)
    }

    /// Lists the baselines, the model at [`Comparison::model_place`], and the second model.
    pub fn series(&self) -> Vec<Series<'_>> {
        let models = self.models().zip(["model", "other"]).map(|(model, class)| Series {
            name: model.file.name,
            class,
            measured: &model.measured,
            skin: SeriesSkin::Model(model),
        });
        self.baseline_series().into_iter().chain(models).collect()
    }

    /// Lists the baselines: fitted LBS, and own weights if the mesh has any.
    pub fn baseline_series(&self) -> Vec<Series<'_>> {
        let Baselines { lbs, own_weights } = &self.baselines;
        let own_weights = own_weights.as_ref().map(|own| (OWN_WEIGHTS, "own", own));
        let all = std::iter::once((LBS, "lbs", lbs)).chain(own_weights);
        let series = all.map(|(name, class, MeasuredBaseline { baseline, measured })| Series {
            name,
            class,
            measured,
            skin: SeriesSkin::Baseline(baseline),
        });
        series.collect()
    }

    /// Returns the index of the model in [`Comparison::series`].
    pub fn model_place(&self) -> usize {
        self.baseline_series().len()
    }

    /// Summarises the measurements of each model, as [`crate::evaluate::evaluate`] does.
    pub fn evaluations(&self) -> Vec<Evaluation> {
        let of = |model: &MeasuredModel<'_>| {
            let character = (&model.character, model.file.bytes.len(), &model.measured);
            let (frames, examples) = ((self.frames, model.read), self.source.examples);
            Evaluation::new(frames, character, examples, &self.baselines)
        };
        self.models().map(of).collect()
    }
}

impl NamedExamples<'_> {
    /// Returns the index of the clip that holds a frame.
    pub fn clip_of(&self, frame: usize) -> Option<usize> {
        self.clips.iter().rposition(|clip| clip.first <= frame)
    }

    /// Returns the source's number of a frame, or the frame index if the source has no number.
    pub fn number(&self, frame: usize) -> i64 {
        FrameName::new(self.clips, frame).number.unwrap_or(frame as i64)
    }

    /// Names a frame: the number and, with several clips, the clip. Without a source number the place in the clip is
    /// added.
    pub fn label(&self, frame: usize) -> String {
        let FrameName { number, clip, .. } = FrameName::new(self.clips, frame);
        match (number, clip) {
            (Some(number), Some((clip, _))) => format!("frame {number} ({clip})"),
            (Some(number), None) => format!("frame {number}"),
            (None, Some((clip, place))) => format!("frame {frame} ({clip}, {place})"),
            (None, None) => format!("frame {frame}"),
        }
    }
}
