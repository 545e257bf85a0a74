//! What more or fewer proxies would give: the model's predictor, trained again.

use super::comparison::Comparison;
use super::stopwatch::Stopwatch;
use crate::envelope::choose::choose;
use crate::envelope::clean::Inliers;
use crate::envelope::lbs::poses::MIN_POSES;
use crate::envelope::lbs::training::Training;
use crate::envelope::s3::ProxyCount;
use crate::envelope::s3::settings::near_rigid;
use crate::envelope::{FitError, Options, Predict, TrainError, Trained};
use crate::evaluate::{Character, Errors, EvaluateError, Measured};
use crate::examples::Split;
use crate::progress::Progress;
use sinew_runtime::Limits;
use std::time::Instant;

/// Most vertices x training frames x proxies of a training with twice the proxies: some 20 s of work
/// for kernel maps.
const TWICE_MOST: usize = 300_000_000;

/// Trainings with several numbers of proxies.
pub(super) struct Sizes {
    /// Seconds that they share: reading the frames, LBS.
    pub(super) shared_seconds: f64,
    /// Whether they are measured on frames that they were trained on, for the model has read no others.
    pub(super) seen: bool,
    /// The trainings, by ascending number of proxies.
    pub(super) trials: Vec<SizeTrial>,
    /// The near-rigid vertices of the one with as many proxies as the model, V; none where it has no
    /// reconstruction.
    pub(super) near_rigid: Option<Vec<bool>>,
}

/// A training.
pub(super) struct SizeTrial {
    /// P, as asked for.
    pub(super) proxies: usize,
    /// What came of it.
    pub(super) outcome: Result<Outcome, SizeError>,
}

/// What came of a training.
pub(super) struct Outcome {
    /// P.
    pub(super) proxies: usize,
    /// Length of the file.
    pub(super) bytes: usize,
    /// Forecast of the RMS error on more of these clips, in % of the rest diagonal.
    pub(super) forecast_percent: f64,
    /// On the frames that the report measures.
    pub(super) errors: Errors,
    /// Of the whole training, without what is shared.
    pub(super) seconds: f64,
    /// Of each step.
    pub(super) steps: Vec<(&'static str, f64)>,
}

/// A training, or its measurement, that failed.
#[derive(Debug, thiserror::Error)]
pub(super) enum SizeError {
    /// It could not be trained.
    #[error(transparent)]
    Train(#[from] TrainError),
    /// It could not be measured.
    #[error(transparent)]
    Evaluate(#[from] EvaluateError),
}

impl Sizes {
    /// Trains the model's predictor with a quarter and a half of its proxies, with as many, and,
    /// where that takes no more than seconds, with twice as many; measures each on the report's
    /// frames. A training that fails says so in its place.
    ///
    /// The trainings read the frames that the model has read, without those that the report measures. Where too few
    /// are left, they read the measured ones too.
    ///
    /// # Errors
    /// [`FitError`], where the examples allow no training at all.
    pub(super) fn train(
        comparison: &Comparison<'_>,
        progress: &dyn Progress,
    ) -> Result<Self, FitError> {
        let (frames, seen) = frames(comparison);
        let examples = &comparison.source.examples.trained_on(&frames);
        let begun = Instant::now();
        let training = Inliers::new(examples, progress)?.weighted(progress)?;
        let shared_seconds = begun.elapsed().as_secs_f64();
        let counts = counts(comparison.model.character.envelope.proxy_len(), &training);
        let mut sizes = Self { shared_seconds, seen, trials: Vec::new(), near_rigid: None };
        for (number, &proxies) in counts.iter().enumerate() {
            progress.part(number + 1, counts.len());
            let outcome = sizes.attempt(comparison, &training, proxies, progress);
            sizes.trials.push(SizeTrial { proxies, outcome });
        }
        Ok(sizes)
    }

    fn attempt(
        &mut self,
        comparison: &Comparison<'_>,
        training: &Training,
        proxies: usize,
        progress: &dyn Progress,
    ) -> Result<Outcome, SizeError> {
        let Character { envelope, skin, .. } = &comparison.model.character;
        let options = Options {
            predictor: Predict::Only(envelope.predictor()),
            proxies: Some(ProxyCount::Fixed(proxies)),
            influences: skin.influence_len(),
            ..Options::default()
        };
        let stopwatch = Stopwatch::new(progress);
        let begun = Instant::now();
        let Trained { model, report, .. } = choose(training, &options, &stopwatch)?;
        let (seconds, steps) = (begun.elapsed().as_secs_f64(), stopwatch.finish());
        if let (true, Some(fit)) = (proxies == envelope.proxy_len(), &report.rotational) {
            let fraction = fit.choice.near_rigid_fraction;
            self.near_rigid = Some(near_rigid(&training.lbs.errors, fraction));
        }
        let examples = training.examples;
        let trained = Character::open(&model, None, examples)?;
        let errors = Measured::model(&trained, examples, &comparison.measured_frames())?.errors();
        Ok(Outcome {
            proxies: trained.envelope.proxy_len(),
            bytes: model.len(),
            forecast_percent: 100.0 * report.same_clips_rms,
            errors,
            seconds,
            steps,
        })
    }
}

/// Lists the frames to train on, and returns whether the report measures them too.
fn frames(comparison: &Comparison<'_>) -> (Vec<usize>, bool) {
    let all = 0..comparison.source.examples.frame_len();
    let read: Vec<usize> = all.filter(|&f| comparison.use_of(f) == Split::Train).collect();
    let measured = comparison.measured_frames();
    let others: Vec<usize> = read.iter().copied().filter(|f| !measured.contains(f)).collect();
    if others.len() < MIN_POSES { (read, true) } else { (others, false) }
}

/// The numbers of proxies to try, ascending; none for a model without any.
fn counts(own: usize, training: &Training) -> Vec<usize> {
    let most = training.triangles.len().min(Limits::DEFAULT.proxies as usize);
    let cost = training.rest.len() * training.poses.len() * 2 * own;
    let twice = (cost <= TWICE_MOST).then_some(2 * own);
    let mut counts: Vec<usize> = [own / 4, own / 2, own].into_iter().chain(twice).collect();
    counts.retain(|count| (1..=most).contains(count));
    counts.dedup();
    counts
}
