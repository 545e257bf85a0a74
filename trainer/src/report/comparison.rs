//! What a report is about: models, examples, and what was measured of the ones on the other.

use crate::evaluate::{
    Baseline, Baselines, Character, EvaluateError, Evaluation, Frames, LBS, Measured,
    MeasuredBaseline, OWN_WEIGHTS, Told,
};
use crate::examples::{Clip, Examples, Split};
use crate::space::beside;

/// Examples as a report names them.
#[derive(Clone, Copy)]
pub struct NamedExamples<'a> {
    /// The examples.
    pub examples: &'a Examples,
    /// The clips that their frames come from, in order; they cover all frames.
    pub clips: &'a [Clip],
    /// What they are called.
    pub name: &'a str,
}

/// A model's file as a report names it.
#[derive(Clone, Copy)]
pub struct NamedModel<'a> {
    /// What it is called.
    pub name: &'a str,
    /// Its content.
    pub bytes: &'a [u8],
    /// The name of the skin to measure; the first where none is given.
    pub skin: Option<&'a str>,
}

/// One or two models, baselines beside them, and their errors on frames of the examples.
pub struct Comparison<'a> {
    /// The examples.
    pub source: NamedExamples<'a>,
    /// Which of their frames are measured.
    pub frames: Frames,
    /// The baselines.
    pub baselines: Baselines,
    /// The model.
    pub model: MeasuredModel<'a>,
    /// The one that it is compared with.
    pub other: Option<MeasuredModel<'a>>,
}

/// A model and its errors.
pub struct MeasuredModel<'a> {
    /// Its file.
    pub file: NamedModel<'a>,
    /// Its envelope and the skin that is measured.
    pub character: Character<'a>,
    /// Its errors.
    pub measured: Measured,
    /// How many of the measured frames its training has read; none where its file does not tell.
    pub read: Option<usize>,
    /// The record of its training.
    pub told: Told,
}

/// One of the skins that stand side by side.
#[derive(Clone, Copy)]
pub struct Series<'a> {
    /// What it is called.
    pub name: &'a str,
    /// Its class in the page's style.
    pub class: &'static str,
    /// Its errors.
    pub measured: &'a Measured,
    /// Its model or baseline.
    pub skin: SeriesSkin<'a>,
}

/// Whose skin a series shows.
#[derive(Clone, Copy)]
pub enum SeriesSkin<'a> {
    /// A baseline's.
    Baseline(&'a Baseline),
    /// A model's.
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
    /// Measures a model and the baselines, on the frames of [`Frames::usual`] where none are chosen.
    ///
    /// # Errors
    /// Those of [`crate::evaluate::evaluate`].
    pub fn new(
        source: NamedExamples<'a>,
        frames: Option<Frames>,
        file: NamedModel<'a>,
    ) -> Result<Self, EvaluateError> {
        let NamedExamples { examples, .. } = source;
        let character = Character::open(file.bytes, file.skin, examples)?;
        let told = Told::of(file.bytes, &character, examples);
        let frames = frames.unwrap_or_else(|| Frames::usual(examples, &told));
        let chosen = frames.measurable(examples, &told)?;
        let measured = Measured::model(&character, examples, &chosen)?;
        let baselines = Baselines::new(&told, examples, &chosen);
        let model = MeasuredModel { file, character, measured, read: told.read_len(&chosen), told };
        Ok(Self { source, frames, baselines, model, other: None })
    }

    /// Measures a second model, to stand beside the first.
    ///
    /// # Errors
    /// Those of [`crate::evaluate::evaluate`].
    pub fn compare(&mut self, file: NamedModel<'a>) -> Result<(), EvaluateError> {
        let character = Character::open(file.bytes, file.skin, self.source.examples)?;
        let chosen = self.measured_frames();
        let measured = Measured::model(&character, self.source.examples, &chosen)?;
        let told = Told::of(file.bytes, &character, self.source.examples);
        let read = told.read_len(&chosen);
        self.other = Some(MeasuredModel { file, character, measured, read, told });
        Ok(())
    }

    /// Lists the numbers of the measured frames.
    pub fn measured_frames(&self) -> Vec<usize> {
        self.model.measured.frames.iter().map(|frame| frame.frame).collect()
    }

    /// Returns the millimetres of a length in % of the diagonal; `None` where the unit is not known.
    pub fn mm(&self, percent: f64) -> Option<f64> {
        self.model.measured.diagonal_mm.map(|diagonal| percent / 100.0 * diagonal)
    }

    /// Writes a length in % of the diagonal: `0.1234 %`, and ` (1.234 mm)` behind it where the unit is known.
    pub fn length(&self, percent: f64) -> String {
        format!("{percent:.4} %{}", beside(percent, self.model.measured.diagonal_mm))
    }

    /// Returns the use of a frame in the training of the model; in the examples where its file does not tell.
    pub fn use_of(&self, frame: usize) -> Split {
        match (self.model.told.has_read(frame), self.source.examples.split[frame]) {
            (Some(true), _) => Split::Train,
            (Some(false), Split::Train) => Split::HeldOut,
            (_, split) => split,
        }
    }

    /// Lists the models, one or two.
    pub fn models(&self) -> impl Iterator<Item = &MeasuredModel<'a>> {
        std::iter::once(&self.model).chain(&self.other)
    }

    /// Lists the baselines, the model at [`Comparison::model_place`], and the one that it is compared with.
    pub fn series(&self) -> Vec<Series<'_>> {
        let models = self.models().zip(["model", "other"]).map(|(model, class)| Series {
            name: model.file.name,
            class,
            measured: &model.measured,
            skin: SeriesSkin::Model(model),
        });
        self.baseline_series().into_iter().chain(models).collect()
    }

    /// Lists the baselines: LBS, fitted, and own weights where the mesh comes with any.
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

    /// Returns the index of the model among [`Comparison::series`].
    pub fn model_place(&self) -> usize {
        self.baseline_series().len()
    }

    /// Summarises what was measured, a model each, as [`crate::evaluate::evaluate`] does.
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
    /// Returns the number of the clip that a frame belongs to.
    pub fn clip_of(&self, frame: usize) -> Option<usize> {
        self.clips.iter().rposition(|clip| clip.first <= frame)
    }

    /// Returns what the source calls a frame, or its place where the source calls it nothing.
    pub fn number(&self, frame: usize) -> i64 {
        self.own_number(frame).unwrap_or(frame as i64)
    }

    fn own_number(&self, frame: usize) -> Option<i64> {
        let clip = &self.clips[self.clip_of(frame)?];
        clip.number(frame - clip.first)
    }

    /// Names a frame: its number and, where there are several clips, its place in one, or that clip where the
    /// number is the source's own.
    pub fn label(&self, frame: usize) -> String {
        let several = self.clip_of(frame).filter(|_| self.clips.len() > 1);
        match (self.own_number(frame), several.map(|clip| &self.clips[clip])) {
            (Some(number), Some(clip)) => format!("frame {number} ({})", clip.name),
            (Some(number), None) => format!("frame {number}"),
            (None, Some(clip)) => format!("frame {frame} ({}, {})", clip.name, frame - clip.first),
            (None, None) => format!("frame {frame}"),
        }
    }
}
