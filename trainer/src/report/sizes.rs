//! Trains the model's predictor again with more and fewer proxies, to show the effect on error, size and time.

use super::comparison::Comparison;
use crate::Error;
use crate::envelope::choose::choose;
use crate::envelope::clean::Inliers;
use crate::envelope::lbs::poses::MIN_POSES;
use crate::envelope::lbs::training::Training;
use crate::envelope::s3::ProxyCount;
use crate::envelope::s3::validation::near_rigid;
use crate::envelope::{Options, Predict, Trained};
use crate::evaluate::{Character, Errors, Measured};
use crate::examples::Split;
use crate::progress::Progress;
use sinew_runtime::Limits;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// Largest product of vertices, training frames and proxies for a training with twice the proxies: about 20 s of work
/// for kernel maps.
const TWICE_MOST: usize = 300_000_000;

/// Trainings with several numbers of proxies.
pub(super) struct Sizes {
    /// Seconds for the common steps: reading the frames and fitting LBS.
    pub(super) shared_seconds: f64,
    /// Whether the trainings read the measured frames, because the model read no others.
    pub(super) seen: bool,
    /// The trainings, by ascending number of proxies: the requested number, and the result.
    pub(super) trials: Vec<(usize, Result<Outcome, Error>)>,
    /// Near-rigid vertices of the training with the model's number of proxies, V; `None` without a reconstruction.
    pub(super) near_rigid: Option<Vec<bool>>,
}

/// Result of a training.
pub(super) struct Outcome {
    /// Number of proxies, P.
    pub(super) proxies: usize,
    /// Length of the file.
    pub(super) bytes: usize,
    /// Forecast of the RMS error on more frames of the same clips, in % of the rest diagonal.
    pub(super) forecast_percent: f64,
    /// Errors on the measured frames of the report.
    pub(super) errors: Errors,
    /// Seconds of the training without the common steps.
    pub(super) seconds: f64,
    /// Seconds of each step.
    pub(super) steps: Vec<(&'static str, f64)>,
}

impl Sizes {
    /// Trains the model's predictor with a quarter, a half and all of its proxies, and with twice as many if that takes
    /// only seconds. Measures each on the report's frames. A failed training reports its error.
    ///
    /// The trainings read the frames that the model read, without the measured frames. If too few remain, they read the
    /// measured frames too.
    ///
    /// # Errors
    /// No training on the examples is possible, as in [`Training::new`].
    pub(super) fn train(
        comparison: &Comparison<'_>,
        progress: &dyn Progress,
    ) -> Result<Self, Error> {
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
            sizes.trials.push((proxies, outcome));
        }
        Ok(sizes)
    }

    fn attempt(
        &mut self,
        comparison: &Comparison<'_>,
        training: &Training,
        proxies: usize,
        progress: &dyn Progress,
    ) -> Result<Outcome, Error> {
        let Character { envelope, skin, .. } = &comparison.model.character;
        let options = Options {
            predictor: Predict::Only(envelope.predictor()),
            proxies: Some(ProxyCount::Fixed(proxies)),
            influences: skin.influence_len(),
            ..Options::default()
        };
        let stopwatch = Stopwatch { others: progress, begun: Mutex::default() };
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

/// Lists the frames to train on, and returns whether the report measures these frames too.
fn frames(comparison: &Comparison<'_>) -> (Vec<usize>, bool) {
    let all = 0..comparison.source.examples.frame_len();
    let read: Vec<usize> = all.filter(|&f| comparison.use_of(f) == Split::Train).collect();
    let measured = comparison.measured_frames();
    let others: Vec<usize> = read.iter().copied().filter(|f| !measured.contains(f)).collect();
    if others.len() < MIN_POSES { (read, true) } else { (others, false) }
}

/// Lists the numbers of proxies to try, ascending; empty for a model without proxies.
fn counts(own: usize, training: &Training) -> Vec<usize> {
    let most = training.triangles.len().min(Limits::DEFAULT.proxies as usize);
    let cost = training.rest.len() * training.poses.len() * 2 * own;
    let twice = (cost <= TWICE_MOST).then_some(2 * own);
    let mut counts: Vec<usize> = [own / 4, own / 2, own].into_iter().chain(twice).collect();
    counts.retain(|count| (1..=most).contains(count));
    counts.dedup();
    counts
}

/// Measures the time of each step of a fit, and forwards the progress.
struct Stopwatch<'a> {
    others: &'a dyn Progress,
    begun: Mutex<Vec<(&'static str, Instant)>>,
}

impl Stopwatch<'_> {
    /// Stops, and returns the seconds of each step in the order of their first start. Time before the first step is not
    /// counted.
    fn finish(self) -> Vec<(&'static str, f64)> {
        let mut begun = self.begun.into_inner().unwrap_or_else(PoisonError::into_inner);
        begun.push(("", Instant::now()));
        let mut steps: Vec<(&'static str, f64)> = Vec::new();
        for pair in begun.windows(2) {
            let (name, seconds) = (pair[0].0, (pair[1].1 - pair[0].1).as_secs_f64());
            match steps.iter_mut().find(|step| step.0 == name) {
                Some(step) => step.1 += seconds,
                None => steps.push((name, seconds)),
            }
        }
        steps
    }
}

impl Progress for Stopwatch<'_> {
    fn part(&self, _: usize, _: usize) {}

    fn step(&self, name: &'static str, items: usize) {
        let mut begun = self.begun.lock().unwrap_or_else(PoisonError::into_inner);
        begun.push((name, Instant::now()));
        self.others.step(name, items);
    }

    fn advance(&self, items: usize) {
        self.others.advance(items);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Silent;
    use std::thread::sleep;
    use std::time::Duration;

    #[test]
    fn seconds_of_a_repeated_step_are_summed() {
        let stopwatch = Stopwatch { others: &Silent, begun: Mutex::default() };
        for (name, milliseconds) in [("a", 30), ("b", 10), ("a", 30)] {
            stopwatch.step(name, 1);
            sleep(Duration::from_millis(milliseconds));
        }
        let steps = stopwatch.finish();
        assert_eq!(steps.iter().map(|step| step.0).collect::<Vec<_>>(), ["a", "b"]);
        assert!(steps[0].1 >= 0.06 && steps[1].1 >= 0.01, "{steps:?}");
    }
}
