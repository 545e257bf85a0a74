//! The choice of predictor and number of proxies by cross-validation inside the training split
//! (METHOD §1.9).

use super::budget::Budget;
use super::candidate::{Candidate, Kind, chosen, near};
use super::counts::{proxies_max, proxy_counts, usual_count};
use super::error::{FitError, TrainError};
use super::fitted::{Fitted, corrected};
use super::helpers::fit::{HelperFit, Helpers, STEP};
use super::levels::AddError;
use super::levels::{self, LevelReport};
use super::normals::fit_normals;
use super::options::{FileSkins, Options, Predict};
use super::rotational::lessons::Lessons;
use super::rotational::{self, Rotational, RotationalOptions, Variant};
use super::rotational::{Method, ProxyCount};
use super::training_report::{CandidateReport, TrainingReport};
use crate::envelope::correction::candidates::GroupReport;
use crate::envelope::correction::lists::{self, Known};
use crate::envelope::correction::search::Search;
use crate::envelope::correction::target::CorrectionTarget;
use crate::envelope::skin::folds::folds;
use crate::envelope::skin::training::Training;
use crate::examples::Examples;
use crate::progress::Progress;
use faer::Mat;
use sinew_runtime::envelope::{Certificate, Predictor};

/// Most values of a map's certainty under a budget: they tell less of a pose, and leave bytes for what moves the skin.
const FEW_VALUES: usize = 4;

/// A trained model.
pub struct Trained {
    /// The file's bytes.
    pub model: Vec<u8>,
    /// How it was fitted.
    pub report: TrainingReport,
    /// How the further meshes follow, in their order.
    pub levels: Vec<LevelReport>,
}

/// Fits every candidate that the options allow and takes the best.
///
/// # Errors
/// Every [`TrainError`].
pub fn choose(
    training: &Training,
    examples: &Examples,
    options: &Options,
    progress: &dyn Progress,
) -> Result<Trained, TrainError> {
    if let FileSkins::Skins(further) = &options.meshes {
        levels::check_names(further).map_err(AddError::from)?;
        levels::check_places(further, examples).map_err(AddError::from)?;
    }
    let lbs = training.targets(&training.lbs.weights);
    let mut choice = PredictorSearch {
        training,
        examples,
        options,
        progress,
        lbs_rms: lbs.rms(&training.poses.stacked()),
        budget: Budget::new(training, examples, options)?,
        reports: Vec::new(),
        candidates: Vec::new(),
        kept: Vec::new(),
        helper_fit: None,
        known: Known::new(),
        known_of_reconstruction: None,
        usual: None,
        teacher: None,
        lessons: None,
        parts: 0,
        begun: 0,
    };
    if options.predictor == Predict::Auto && options.proxies.is_none() {
        choice.joints_alone()?;
    }
    if choice.wants(Predictor::Kernel) {
        choice.listen();
    }
    let counts = proxy_counts(training, options);
    choice.parts = counts.len() * choice.fits();
    match &counts[..] {
        [usual, others @ ..] if options.budget.is_none() => {
            choice.attempt(*usual)?;
            choice.attempt_best_kinds(*usual, others)?;
        }
        _ => counts.iter().try_for_each(|count| choice.attempt(*count))?,
    }
    choice.take()
}

struct PredictorSearch<'a> {
    training: &'a Training,
    examples: &'a Examples,
    options: &'a Options,
    progress: &'a dyn Progress,
    lbs_rms: f64,
    budget: Budget<'a>,
    reports: Vec<CandidateReport>,
    candidates: Vec<Candidate>,
    /// The kinds of predictors to try; every one that is asked for where there is none.
    kept: Vec<Kind>,
    /// What fits of helpers read; none where LBS errs nowhere.
    helper_fit: Option<HelperFit<'a>>,
    /// The usual number of helpers, and what the maps of each joint listen to, which is chosen by them for any number.
    usual: Option<Helpers>,
    known: Known,
    /// Kernel maps on the usual number of helpers, and the lessons that they give.
    teacher: Option<Fitted>,
    lessons: Option<Lessons>,
    /// What maps listen to that correct a reconstruction, chosen by the first one.
    known_of_reconstruction: Option<Known>,
    /// How many fits there are to be, and how many were begun.
    parts: usize,
    begun: usize,
}

impl PredictorSearch<'_> {
    fn wants(&self, predictor: Predictor) -> bool {
        let asked = match self.options.predictor {
            Predict::Auto => None,
            Predict::Only(only) => Some(only),
            Predict::Published => Some(Predictor::Rotational),
        };
        let is_kept = self.kept.is_empty() || self.kept.iter().any(|kept| kept.0 == predictor);
        is_kept && asked.is_none_or(|only| only == predictor)
    }

    /// Tries other numbers of proxies than the usual one: where bytes do not decide, what predicts best with so many
    /// predicts best with fewer, and what predicts nearly as well may do so with more.
    fn attempt_best_kinds(
        &mut self,
        usual: ProxyCount,
        others: &[ProxyCount],
    ) -> Result<(), TrainError> {
        let Some(best) = chosen(&self.candidates, &self.reports) else { return Ok(()) };
        let best = vec![best.kind(&self.reports)];
        let near = near(&self.candidates, &self.reports);
        let kinds = |&count| if count > usual { near.clone() } else { best.clone() };
        let plan: Vec<Vec<Kind>> = others.iter().map(kinds).collect();
        self.parts = self.begun;
        for kinds in &plan {
            self.kept.clone_from(kinds);
            self.parts += self.fits();
        }
        for (kinds, count) in plan.into_iter().zip(others) {
            self.kept = kinds;
            self.attempt(*count)?;
        }
        Ok(())
    }

    /// Chooses what helpers' maps listen to, by the usual number of them: for every number the same, so that it does not
    /// matter which were tried.
    fn listen(&mut self) {
        self.progress.step(STEP, 1);
        self.helper_fit = HelperFit::new(self.training);
        self.usual = self.helper_fit.as_ref().map(|fit| {
            let helpers = fit.run(usual_count(self.training), self.options.influences);
            let target = helpers.target(self.training);
            self.known = lists::choose(&target, usize::MAX, self.progress);
            helpers.listening(self.training, &self.known)
        });
    }

    /// Fits helpers; none where LBS errs nowhere.
    fn helpers(&self, count: usize) -> Option<Helpers> {
        let fit = self.helper_fit.as_ref()?;
        Some(fit.run(count, self.options.influences).listening(self.training, &self.known))
    }

    /// Counts the fits of one number of proxies: a reconstruction, what corrects it, and helpers.
    fn fits(&self) -> usize {
        let [rotational, hybrid, kernel] =
            [Predictor::Rotational, Predictor::Hybrid, Predictor::Kernel].map(|p| self.wants(p));
        usize::from(rotational || hybrid) + usize::from(hybrid) + usize::from(kernel)
    }

    fn begin(&mut self) {
        self.begun += 1;
        self.progress.part(self.begun.min(self.parts), self.parts);
    }

    fn attempt(&mut self, count: ProxyCount) -> Result<(), TrainError> {
        let mut proxies = count;
        // Kernel maps go first, for reconstructions learn from them, but where the error decides how many proxies there are.
        let first = matches!(count, ProxyCount::Fixed(_));
        if first && self.wants(Predictor::Kernel) {
            self.begin();
            self.kernel(count)?;
        }
        if self.wants(Predictor::Rotational) || self.wants(Predictor::Hybrid) {
            self.begin();
            let options = RotationalOptions {
                proxies: count,
                influences: self.options.influences,
                method: self.options.method(),
            };
            if options.method == Method::Refined {
                self.teach();
            }
            let lessons = self.lessons.as_ref();
            match rotational::fit(self.training, &options, lessons, self.progress) {
                Ok(fitted) => {
                    proxies = ProxyCount::Fixed(fitted.dominant.len());
                    if self.wants(Predictor::Rotational) {
                        self.rotational(&fitted)?;
                    }
                    if self.wants(Predictor::Hybrid) {
                        self.begin();
                        self.hybrid(&fitted)?;
                    }
                }
                // Helpers need no reconstruction.
                Err(FitError::Singular) if self.wants(Predictor::Kernel) => {}
                Err(error) => return Err(error.into()),
            }
        }
        if !first && self.wants(Predictor::Kernel) {
            self.begin();
            self.kernel(proxies)?;
        }
        Ok(())
    }

    /// Has lessons made for reconstructions, once: by kernel maps on the usual number of helpers, so that it does not
    /// matter what else was tried. There are none where LBS errs nowhere.
    fn teach(&mut self) {
        if self.lessons.is_some() {
            return;
        }
        if self.teacher.is_none() {
            if self.helper_fit.is_none() {
                self.listen();
            }
            let helpers = self.usual.take().or_else(|| self.helpers(usual_count(self.training)));
            self.teacher = helpers.as_ref().and_then(|helpers| {
                let target = helpers.target(self.training);
                let correction = Search::new(target, &self.known, self.progress).fit(usize::MAX)?;
                Some(helpers.fitted(self.training, correction.groups))
            });
            self.usual = helpers;
        }
        self.lessons = self.teacher.as_ref().map(|teacher| Lessons::new(self.training, teacher));
    }

    fn rotational(&mut self, rotational: &Rotational) -> Result<(), TrainError> {
        let best = rotational.best();
        let fitted = rotational.fitted(best, self.training);
        for coefficients in self.budget.with_coefficients() {
            let bytes = self.budget.bytes(&fitted, coefficients)?;
            let fits =
                (bytes <= self.budget.most()).then_some((bytes, &best.validated, Vec::new()));
            self.add((fitted.clone(), coefficients), fits, Some((rotational, best)));
        }
        Ok(())
    }

    /// Corrects the refined variant of a reconstruction, and the other too where that is nearly the best, or all that is
    /// asked for. What corrects them listens to what the first one's first variant, which is not refined, leaves over.
    fn hybrid(&mut self, rotational: &Rotational) -> Result<(), TrainError> {
        let known = self.known_of_reconstruction.take().unwrap_or_else(|| {
            let first = rotational.variants.first().map(|v| rotational.target(v, self.training));
            let known = first.map(|target| lists::choose(&target, 1, self.progress));
            known.unwrap_or_default()
        });
        let all = &rotational.variants;
        let is_kept =
            |variant: &Variant| self.kept.contains(&(Predictor::Hybrid, Some(variant.method)));
        let any_is = all.iter().any(is_kept);
        let tried: Vec<&Variant> = all.iter().rev().filter(|v| is_kept(v) || !any_is).collect();
        for variant in tried {
            let fitted = rotational.fitted(variant, self.training);
            let target = rotational.target(variant, self.training);
            let of = Some((rotational, variant));
            self.corrected(fitted, (&target, &known), &variant.validated, of)?;
            let near = near(&self.candidates, &self.reports);
            if near.iter().all(|kind| kind.0 != Predictor::Hybrid) {
                break;
            }
        }
        self.known_of_reconstruction = Some(known);
        Ok(())
    }

    fn kernel(&mut self, count: ProxyCount) -> Result<(), TrainError> {
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
        let known = self.known.clone();
        self.corrected(fitted, (&helpers.target(self.training), &known), &base, None)?;
        if is_usual && self.options.budget.is_none() {
            self.teacher = self.candidates.last().map(|candidate| candidate.fitted.clone());
        }
        Ok(())
    }

    /// Plain LBS: a palette of joints without helpers.
    fn joints_alone(&mut self) -> Result<(), TrainError> {
        let fitted = Fitted::new(self.training, self.training.lbs.weights.clone(), None);
        let palette = self.training.poses.stacked();
        for coefficients in self.budget.with_coefficients() {
            let bytes = self.budget.bytes(&fitted, coefficients)?;
            let fits = (bytes <= self.budget.most()).then_some((bytes, &palette, Vec::new()));
            self.add((fitted.clone(), coefficients), fits, None);
        }
        Ok(())
    }

    /// Doubles the helpers until their true maps come as near as asked; none where LBS does.
    fn fewest_helpers(&self, limit: f64) -> Result<Option<Helpers>, FitError> {
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
                return Err(FitError::MaxError { limit, reached, proxies: count });
            }
            count = (2 * count).min(most);
        }
    }

    /// Corrects a base whose palette of poses that it has not seen is `validated`, in what the budget
    /// leaves.
    fn corrected(
        &mut self,
        fitted: Fitted,
        (target, known): (&CorrectionTarget<'_>, &Known),
        validated: &Mat<f64>,
        rotational: Option<(&Rotational, &Variant)>,
    ) -> Result<(), TrainError> {
        let certainty = if self.options.budget.is_some() { FEW_VALUES } else { target.certainty };
        let target = CorrectionTarget { certainty, ..*target };
        let search = Search::new(target, known, self.progress);
        let fitted = fitted.with(search.nothing());
        for coefficients in self.budget.with_coefficients() {
            let without = self.budget.bytes(&fitted, coefficients)?;
            let room = self.budget.most().checked_sub(without);
            let Some(correction) = room.and_then(|room| search.fit(room)) else {
                self.add((fitted.clone(), coefficients), None, rotational);
                continue;
            };
            let palette = corrected(validated.clone(), &correction.validated);
            let fits = (without + correction.bytes, &palette, correction.reports);
            let fitted = fitted.clone().with(correction.groups);
            self.add((fitted, coefficients), Some(fits), rotational);
        }
        Ok(())
    }

    fn add(
        &mut self,
        (fitted, tangent_coefficients): (Fitted, bool),
        fits: Option<(usize, &Mat<f64>, Vec<GroupReport>)>,
        rotational: Option<(&Rotational, &Variant)>,
    ) {
        let mut report = CandidateReport {
            predictor: fitted.envelope.predictor().name(),
            method: rotational.map(|(_, variant)| variant.method),
            proxies: fitted.envelope.proxy_len(),
            tangent_coefficients,
            bytes: None,
            validated_rms: None,
            groups: Vec::new(),
        };
        if let Some((bytes, palette, groups)) = fits {
            let validated_rms = self.training.targets(&fitted.weights).rms(palette);
            (report.bytes, report.validated_rms) = (Some(bytes), Some(validated_rms));
            report.groups = groups;
            let rotational = rotational.map(|(rotational, _)| rotational.report.clone());
            let report = self.reports.len();
            self.candidates.push(Candidate {
                fitted,
                tangent_coefficients,
                report,
                validated_rms,
                rotational,
            });
        }
        self.reports.push(report);
    }

    /// Takes the candidate that scores best, or a smaller one where that costs little.
    fn take(self) -> Result<Trained, TrainError> {
        let Self { training, examples, progress, lbs_rms, budget, mut reports, candidates, .. } =
            self;
        let Some(chosen) = chosen(&candidates, &reports) else {
            return Err(budget.exceeded());
        };
        let palette = chosen.fitted.envelope.palettes(&training.poses);
        let training_rms = training.targets(&chosen.fitted.weights).rms(&palette);
        let base = chosen.fitted.envelope.bases(&training.poses);
        let base_rms = training.targets(&chosen.fitted.weights).rms(&base);
        let certificate = Certificate {
            training_rms: training_rms as f32,
            cross_validated_rms: chosen.validated_rms as f32,
            lbs_training_rms: lbs_rms as f32,
            base_training_rms: base_rms as f32,
            ..Certificate::default()
        };
        let (fitted, palette) = chosen.fitted.led_by_upright(palette);
        let mut model = fitted.file_model(training, examples, certificate);
        let levels = match &self.options.meshes {
            FileSkins::Skins(further) => {
                progress.step("normals", 1);
                let coefficients = chosen.tangent_coefficients;
                // A budget was measured with the lists as they are.
                let most = self.options.budget.map_or(self.options.influences, |_| 0);
                let palettes = coefficients.then_some(&palette);
                fit_normals(&mut model, palettes, most, training, examples)?;
                levels::add(&mut model, further, coefficients, examples)?
            }
            FileSkins::PaletteAlone => {
                model.skins.clear();
                Vec::new()
            }
        };
        let model = budget.recorded(model)?;
        reports[chosen.report].bytes = Some(model.len());
        let report = TrainingReport {
            left_out: Vec::new(),
            lbs_rms,
            folds: folds(&training.poses).into_iter().map(|fold| fold.own).collect(),
            chosen: chosen.report,
            training_rms,
            rotational: chosen.rotational.clone(),
            angle_ranges: training.poses.angle_ranges(),
            candidates: reports,
        };
        Ok(Trained { model, report, levels })
    }
}
