//! Choice of the number of proxies by cross-validation inside the training split (METHOD §1.9).

mod budget;
mod candidates;
mod forecast;
pub mod report;

use super::correction::Search;
use super::correction::candidates::GroupReport;
use super::correction::joint_sets::{self, JointSets};
use super::correction::target::CorrectionTarget;
use super::fitted::{Fitted, corrected};
use super::helpers::Helpers;
use super::helpers::fit::{HelperFit, STEP};
use super::lbs::prior::own_weights;
use super::lbs::training::Training;
use super::levels::{self, LevelReport};
use super::normals::fit_normals;
use super::options::{FileSkins, Options, Predict};
use super::s3::proxies::out_of_reach;
use super::s3::{self, ProxyCount, Rotational, RotationalOptions};
use crate::Error;
use crate::examples::spread;
use crate::progress::{Progress, Silent};
use crate::settings::FEW_VERTICES;
use budget::Budget;
use candidates::{Candidate, chosen, proxies_max, proxy_counts, usual_count};
use faer::Mat;
use forecast::{errors, forecast, pooled};
use report::{CandidateReport, Refused, TrainingReport};
use sinew_runtime::envelope::{Certificate, Predictor};

/// Largest number of certainty values of a map under a budget. The confidence gets coarser, but more bytes are left for
/// the motion of the skin.
const FEW_VALUES: usize = 4;

/// A candidate, its forecasts on more frames of the training clips and on another clip, and the candidate that another
/// clip refused.
type Taken<'a> = (&'a Candidate, [Option<f64>; 2], Option<Refused>);

/// A trained model.
pub struct Trained {
    /// Bytes of the file.
    pub model: Vec<u8>,
    /// Report of the fit.
    pub report: TrainingReport,
    /// Reports of the further meshes, in order.
    pub levels: Vec<LevelReport>,
}

/// Fits every candidate that the options allow and bakes the best.
///
/// # Errors
/// Those of [`train`](super::train) about the budget, the accuracy, the further meshes and the runtime.
pub fn choose(
    training: &Training,
    options: &Options,
    progress: &dyn Progress,
) -> Result<Trained, Error> {
    if let FileSkins::Skins(further) = &options.meshes {
        levels::check_names(further)?;
        levels::check_places(further, training.examples)?;
    }
    let lbs = training.targets(&training.lbs.weights);
    let counts = proxy_counts(training, options);
    let mut choice = PredictorSearch {
        training,
        options,
        progress,
        lbs_rms: lbs.rms(&training.poses.stacked()),
        budget: Budget::new(training, options)?,
        reports: Vec::new(),
        candidates: Vec::new(),
        helper_fit: None,
        joint_sets: JointSets::new(),
        usual: None,
    };
    let is_kernel = options.predictor == Predict::Only(Predictor::Kernel);
    if is_kernel {
        if options.proxies.is_none() {
            choice.joints_alone()?;
        }
        choice.choose_joint_sets();
    }
    let parts = counts.len();
    for (count, part) in counts.into_iter().zip(1..) {
        if choice.needs(count) {
            progress.part(part, parts);
            if is_kernel { choice.kernel(count)? } else { choice.rotational(count)? }
        }
    }
    choice.take()
}

/// Search over the numbers of proxies: candidates so far, and input shared by their fits.
struct PredictorSearch<'a> {
    training: &'a Training<'a>,
    options: &'a Options,
    progress: &'a dyn Progress,
    lbs_rms: f64,
    budget: Budget<'a>,
    reports: Vec<CandidateReport>,
    candidates: Vec<Candidate>,
    /// Input shared by all helper fits; `None` if no vertex has an LBS error.
    helper_fit: Option<HelperFit<'a>>,
    /// Helpers of the usual number.
    usual: Option<Helpers>,
    /// Joint sets for any number of helpers, chosen with the usual number.
    joint_sets: JointSets,
}

impl PredictorSearch<'_> {
    /// Chooses joint sets with the usual number of helpers. All numbers of helpers share them, so the result does not
    /// depend on the numbers that are tried.
    fn choose_joint_sets(&mut self) {
        self.progress.step(STEP, 1);
        self.helper_fit = HelperFit::new(self.training, self.options.helper_kind);
        self.usual = self.helper_fit.as_ref().map(|fit| {
            let helpers = fit.run(usual_count(self.training), self.options.influences);
            let target = helpers.target(self.training);
            self.joint_sets = joint_sets::choose(&target, self.progress);
            helpers.with_joint_sets(self.training, &self.joint_sets)
        });
    }

    /// Returns whether to try a number of proxies. Without a budget, numbers below the usual number are skipped once a
    /// larger number is best.
    fn needs(&self, count: ProxyCount) -> bool {
        let usual = usual_count(self.training);
        let is_fewer = matches!(count, ProxyCount::Fixed(count) if count < usual);
        let best = chosen(&self.candidates, &self.reports);
        let larger_is_best = best.is_some_and(|best| best.fitted.envelope.proxy_len() > usual);
        self.options.budget.is_some() || !is_fewer || !larger_is_best
    }

    /// Fits helpers; `None` if no vertex has an LBS error.
    fn helpers(&self, count: usize) -> Option<Helpers> {
        let fit = self.helper_fit.as_ref()?;
        let helpers = fit.run(count, self.options.influences);
        Some(helpers.with_joint_sets(self.training, &self.joint_sets))
    }

    fn rotational_options(&self, proxies: ProxyCount) -> RotationalOptions {
        let Options { influences, .. } = *self.options;
        RotationalOptions { proxies, influences, method: self.options.method() }
    }

    fn rotational(&mut self, count: ProxyCount) -> Result<(), Error> {
        let options = self.rotational_options(count);
        let rotational = s3::fit(self.training, &options, self.progress)?;
        let fitted = rotational.fitted(self.training);
        self.uncorrected(fitted, &rotational.validated, Some(&rotational))
    }

    /// Adds candidates without a correction.
    ///
    /// - `palette`: palette of the training poses, 3n x 4 per transform.
    fn uncorrected(
        &mut self,
        fitted: Fitted,
        palette: &Mat<f64>,
        rotational: Option<&Rotational>,
    ) -> Result<(), Error> {
        for coefficients in self.budget.with_coefficients() {
            let bytes = self.budget.bytes(&fitted, coefficients)?;
            let fits = (bytes <= self.budget.most()).then_some((bytes, palette, Vec::new()));
            self.add((fitted.clone(), coefficients), fits, rotational);
        }
        Ok(())
    }

    fn kernel(&mut self, count: ProxyCount) -> Result<(), Error> {
        self.progress.step(STEP, 1);
        let is_usual = count == ProxyCount::Fixed(usual_count(self.training));
        let helpers = match count {
            ProxyCount::Fixed(count) => {
                let usual = self.usual.take_if(|_| is_usual);
                usual.or_else(|| self.helpers(count))
            }
            ProxyCount::MaxError(limit) => self.fewest_helpers(limit)?,
        };
        let Some(helpers) = helpers else { return self.joints_alone() };
        let fitted = helpers.fitted(self.training, Vec::new());
        let base = helpers.base(&self.training.poses);
        self.corrected(fitted, &helpers.target(self.training), &base)
    }

    /// Adds plain LBS as a candidate: a palette of joints without helpers.
    fn joints_alone(&mut self) -> Result<(), Error> {
        let fitted = Fitted::new(self.training, self.training.lbs.weights.clone(), None);
        self.uncorrected(fitted, &self.training.poses.stacked(), None)
    }

    /// Doubles the number of helpers until their true transforms reach an RMS error; `None` if LBS reaches it.
    fn fewest_helpers(&self, limit: f64) -> Result<Option<Helpers>, Error> {
        if self.lbs_rms <= limit {
            return Ok(None);
        }
        let most = proxies_max(self.training);
        let mut count = 4.min(most);
        loop {
            let Some(helpers) = self.helpers(count) else { return Ok(None) };
            let palette = helpers.true_palette(&self.training.poses);
            let reached = self.training.targets(&helpers.weights).rms(&palette);
            if reached <= limit {
                return Ok(Some(helpers));
            }
            if count == most {
                return Err(out_of_reach(limit, reached, count));
            }
            count = (2 * count).min(most);
        }
    }

    /// Adds candidates with a correction, within the bytes that the budget leaves.
    ///
    /// - `base`: palette of the training poses without a correction, 3n x 4(J + P).
    fn corrected(
        &mut self,
        fitted: Fitted,
        target: &CorrectionTarget<'_>,
        base: &Mat<f64>,
    ) -> Result<(), Error> {
        let certainty = if self.options.budget.is_some() { FEW_VALUES } else { target.certainty };
        let target = CorrectionTarget { certainty, ..*target };
        let search = Search::new(target, &self.joint_sets, self.progress);
        let fitted = fitted.with(search.nothing());
        for coefficients in self.budget.with_coefficients() {
            let without = self.budget.bytes(&fitted, coefficients)?;
            let room = self.budget.most().checked_sub(without);
            let Some(correction) = room.and_then(|room| search.fit(room)) else {
                self.add((fitted.clone(), coefficients), None, None);
                continue;
            };
            let palette = corrected(base.clone(), &correction.validated);
            let palette = fitted.projected(palette);
            let fits = (without + correction.bytes, &palette, correction.reports);
            let fitted = fitted.clone().with(correction.groups);
            self.add((fitted, coefficients), Some(fits), None);
        }
        Ok(())
    }

    /// Adds a candidate and its report.
    ///
    /// - `fits`: bytes, validated palette and reports of the groups; `None` if the candidate exceeds the budget.
    fn add(
        &mut self,
        (fitted, tangent_coefficients): (Fitted, bool),
        fits: Option<(usize, &Mat<f64>, Vec<GroupReport>)>,
        rotational: Option<&Rotational>,
    ) {
        let validated_rms =
            fits.as_ref().map(|fits| self.training.targets(&fitted.weights).rms(fits.1));
        let report = CandidateReport {
            predictor: fitted.envelope.predictor().name(),
            method: rotational.map(|rotational| rotational.method),
            proxies: fitted.envelope.proxy_len(),
            tangent_coefficients,
            bytes: fits.as_ref().map(|fits| fits.0),
            validated_rms,
            groups: fits.map_or_else(Vec::new, |fits| fits.2),
        };
        if let Some(validated_rms) = validated_rms {
            self.candidates.push(Candidate {
                fitted,
                tangent_coefficients,
                report: self.reports.len(),
                validated_rms,
                rotational: rotational.map(|rotational| rotational.report.clone()),
            });
        }
        self.reports.push(report);
    }

    /// Chooses a candidate. Returns it with its forecasts, and the candidate that another clip refused.
    ///
    /// Helpers whose forecast for another clip is worse than the forecast of plain LBS follow motion that the pose does
    /// not explain. LBS is taken in their place. How much of such motion another clip has is unknown, so the worst clip
    /// is the forecast.
    fn chosen(&self) -> Option<Taken<'_>> {
        let best = chosen(&self.candidates, &self.reports)?;
        let forecasts = self.forecasts(best);
        let refused = || {
            let helper_len = |candidate: &Candidate| candidate.fitted.envelope.proxy_len();
            let is_plain = |other: &&Candidate| {
                helper_len(other) == 0 && other.tangent_coefficients == best.tangent_coefficients
            };
            let plain = self.candidates.iter().find(is_plain).filter(|_| helper_len(best) > 0)?;
            let other_clip_rms = forecasts[1]?;
            let vertices = spread(self.training.rest.len(), FEW_VERTICES);
            let clips = self.training.folds().clips();
            let fit = |part: &Training| Some(self.refit(part, 0, usize::MAX));
            let errors = errors(self.training, &vertices, &clips, &fit)?;
            if pooled(&errors, &clips)? >= other_clip_rms {
                return None;
            }
            let [same_clips, _] = self.forecasts(plain);
            let worst = errors.into_iter().reduce(f64::max);
            let refused = Refused { candidate: best.report, other_clip_rms };
            Some((plain, [same_clips, worst], Some(refused)))
        };
        refused().or(Some((best, forecasts, None)))
    }

    /// Forecasts the RMS error of a candidate on more frames of the training clips, and on another clip.
    fn forecasts(&self, chosen: &Candidate) -> [Option<f64>; 2] {
        let training = self.training;
        let folds = training.folds();
        let [some, all] = [FEW_VERTICES, usize::MAX].map(|most| spread(training.rest.len(), most));
        let envelope = &chosen.fitted.envelope;
        let proxies = ProxyCount::Fixed(envelope.proxy_len());
        match chosen.rotational {
            Some(_) => {
                let options = self.rotational_options(proxies);
                let fit = |part: &Training| {
                    let rotational = s3::fit(part, &options, &Silent).ok()?;
                    Some(rotational.fitted(part))
                };
                [None, forecast(training, &all, &folds.clips(), &fit)]
            }
            None => {
                let bytes = &self.reports[chosen.report].groups;
                let bytes =
                    self.options.budget.map(|_| bytes.iter().map(|group| group.bytes).sum());
                let fit = |part: &Training| {
                    Some(self.refit(part, envelope.proxy_len(), bytes.unwrap_or(usize::MAX)))
                };
                [folds.spread(), folds.clips()]
                    .map(|blocks| forecast(training, &some, &blocks, &fit))
            }
        }
    }

    /// Repeats the fit of helpers on a part of the training.
    ///
    /// - `bytes`: largest size of the maps, in bytes.
    fn refit(&self, part: &Training, count: usize, bytes: usize) -> Fitted {
        let Some(fit) = HelperFit::new(part, self.options.helper_kind).filter(|_| count > 0) else {
            return Fitted::new(part, part.lbs.weights.clone(), None);
        };
        let helpers =
            fit.run(count, self.options.influences).with_joint_sets(part, &self.joint_sets);
        let search = Search::new(helpers.target(part), &self.joint_sets, &Silent);
        let correction = search.fit(bytes);
        let groups = correction.map_or_else(|| search.nothing(), |correction| correction.groups);
        helpers.fitted(part, groups)
    }

    /// Bakes the best candidate and reports all candidates.
    fn take(self) -> Result<Trained, Error> {
        let (training, progress, lbs_rms) = (self.training, self.progress, self.lbs_rms);
        let Some((chosen, forecasts, refused)) = self.chosen() else {
            return Err(self.budget.exceeded());
        };
        let palette = chosen.fitted.envelope.palettes(&training.poses);
        let training_rms = training.targets(&chosen.fitted.weights).rms(&palette);
        let base = chosen.fitted.envelope.bases(&training.poses);
        let base_rms = training.targets(&chosen.fitted.weights).rms(&base);
        // A forecast fits few vertices. With an equal number of helpers, few vertices have a smaller error than all
        // vertices.
        let [same_clips, other_clip] = forecasts.map(|rms| rms.map(|rms| rms.max(training_rms)));
        let same_clips = same_clips.unwrap_or(chosen.validated_rms);
        let bones = chosen.fitted.bone_errors(training, &palette);
        let certificate = Certificate {
            trs_error: bones.largest as f32,
            training_rms: training_rms as f32,
            same_clips_rms: same_clips as f32,
            other_clip_rms: other_clip.map(|rms| rms as f32),
            lbs_training_rms: lbs_rms as f32,
            base_training_rms: base_rms as f32,
            ..Certificate::default()
        };
        let (fitted, palette) = chosen.fitted.with_upright_first(palette);
        let mut model = fitted.file_model(training, certificate);
        let levels = match &self.options.meshes {
            FileSkins::Skins(further) => {
                progress.step("normals", 1);
                let coefficients = chosen.tangent_coefficients;
                // The bytes of a budgeted model were measured with the present influences.
                let most = self.options.budget.map_or(self.options.influences, |_| 0);
                let palettes = coefficients.then_some(&palette);
                fit_normals(&mut model, palettes, most, training)?;
                levels::add(&mut model, further, coefficients, training.examples)?
            }
            FileSkins::PaletteAlone => {
                model.skins.clear();
                Vec::new()
            }
        };
        let model = self.budget.recorded(model)?;
        let mut reports = self.reports.clone();
        reports[chosen.report].bytes = Some(model.len());
        let report = TrainingReport {
            left_out: Vec::new(),
            lbs_rms,
            own_weights_rms: own_weights(training.examples, &training.lbs.weights)
                .map(|own| training.targets(&own).rms(&training.poses.stacked())),
            folds: training.folds().runs().iter().map(|fold| fold.own.clone()).collect(),
            chosen: chosen.report,
            refused,
            training_rms,
            bones,
            same_clips_rms: same_clips,
            other_clip_rms: other_clip,
            rotational: chosen.rotational.clone(),
            angle_ranges: training.poses.angle_ranges(),
            candidates: reports,
        };
        Ok(Trained { model, report, levels })
    }
}
