//! Bounds on the method's errors on the sets of `../shared/data` (METHOD §1).
//!
//! A bound on a held-out error is a promise with 10 to 20 % of room, or an older, wider bar. No
//! bound is today's figure, so that no commit is chosen by held-out frames. A bound stays if a
//! figure gets much better.

use models::shared;
use sinew_runtime::envelope::Predictor;
use sinew_runtime::{Envelope, Model};
use sinew_trainer::envelope::choose::report::{CandidateReport, TrainingReport};
use sinew_trainer::envelope::lbs::poses::{Poses, trajectories};
use sinew_trainer::envelope::lbs::targets::Targets;
use sinew_trainer::envelope::lbs::training::Training;
use sinew_trainer::envelope::lbs::weights;
use sinew_trainer::envelope::s3::surface::Surface;
use sinew_trainer::envelope::s3::{self, merge};
use sinew_trainer::envelope::s3::{ProxyCount, proxies};
use sinew_trainer::envelope::{Options, Predict, train};
use sinew_trainer::evaluate::{Evaluation, Frames, evaluate};
use sinew_trainer::examples::demo::{DemoOptions, demo};
use sinew_trainer::examples::{Examples, Importance, Split, npz};
use sinew_trainer::numeric::basis;
use sinew_trainer::progress::Silent;
use std::sync::OnceLock;

fn set(file: &str) -> Option<Examples> {
    shared(file).map(|path| npz::load(&path).unwrap().examples)
}

/// The arm, and a kernel model of 40 proxies trained on it, shared by several tests.
pub(super) fn arm() -> Option<&'static (Examples, Vec<u8>)> {
    static ARM: OnceLock<Option<(Examples, Vec<u8>)>> = OnceLock::new();
    let arm = ARM.get_or_init(|| {
        let examples = set("mpfb-arm/mpfb_arm.npz")?;
        let model = train(&examples, &only(Predictor::Kernel), &Silent).unwrap().model;
        Some((examples, model))
    });
    arm.as_ref()
}

fn measured(examples: &Examples, options: &Options, split: Split) -> Evaluation {
    let model = train(examples, options, &Silent).unwrap().model;
    evaluate(&model, None, examples, Frames::Of(split)).unwrap()
}

pub(super) fn only(predictor: Predictor) -> Options {
    let proxies = Some(ProxyCount::Fixed(40));
    Options { predictor: Predict::Only(predictor), proxies, ..Options::default() }
}

/// Returns the error of LBS on held-out frames, in % of the diagonal, with weights fitted to the
/// training poses without a prior.
fn plain_lbs(examples: &Examples) -> f64 {
    let training = Training::of(examples, &examples.frames_of(Split::Train), &Silent).unwrap();
    let (poses, trajectories) = training.view(examples, &examples.frames_of(Split::HeldOut));
    let targets =
        Targets { trajectories: &trajectories, ..training.targets(&training.lbs.weights) };
    100.0 * targets.rms(&poses.stacked())
}

/// Checks errors on the held-out frames of a set. `lbs` is the published error of LBS in % of the
/// diagonal, which LBS may exceed by 2 %, the cost of its pull to prior weights. The other bounds
/// are errors of the unrefined and refined rotational predictor and of kernel, in % of the
/// diagonal, and errors of the normals of the last two, in degrees RMS over the area.
fn check(
    file: &str,
    lbs: f64,
    [unrefined, refined, kernel]: [f64; 3],
    [refined_normals, kernel_normals]: [f64; 2],
) {
    let Some(examples) = set(file) else { return };
    let plain = plain_lbs(&examples);
    assert!((plain / lbs - 1.0).abs() < 0.01, "{plain}");
    let rotational = only(Predictor::Rotational);
    for (options, most, most_degrees) in [
        (Options { refine: false, ..rotational.clone() }, unrefined, f64::INFINITY),
        (rotational, refined, refined_normals),
        (only(Predictor::Kernel), kernel, kernel_normals),
    ] {
        let found = measured(&examples, &options, Split::HeldOut);
        assert!((0.99..1.02).contains(&(found.lbs.rms_percent / lbs)), "{}", found.lbs.rms_percent);
        assert!(found.errors.rms_percent <= most, "{options:?}: {}", found.errors.rms_percent);
        let degrees = found.errors.normal_rms_degrees;
        assert!(degrees <= most_degrees, "{options:?}: {degrees} degrees");
        assert_eq!(found.proxies, 40);
    }
}

#[test]
fn mpfb_arm_by_every_predictor() {
    // Promised: unrefined 0.430, rotational 0.079 (FIGURES), kernel 0.068 (METHOD §1.9). Promised
    // normals: kernel 2.6 and rotational 3.2 degrees; cofactors leave 7 to 11.
    check("mpfb-arm/mpfb_arm.npz", 0.696, [0.49, 0.09, 0.07], [3.2, 2.6]);
}

#[test]
fn dem_bones_by_every_predictor() {
    // Promised: unrefined no worse than LBS, rotational 0.297 (FIGURES), kernel 0.042 (METHOD
    // §1.9). Promised normals: kernel 0.9 degrees. Rotational stays below the error of cofactors,
    // 2.2; inward normals in a few frames alone would give tens of degrees.
    check("dem-bones/bone.npz", 0.534, [0.53, 0.34, 0.05], [2.2, 0.9]);
}

#[test]
fn extreme_poses_and_a_small_file_of_mpfb_arm() {
    let Some((examples, model)) = arm() else { return };
    let extreme = evaluate(model, None, examples, Frames::Of(Split::Extreme)).unwrap();
    // Promised: 0.083 (FIGURES).
    assert!(extreme.errors.rms_percent <= 0.1, "{}", extreme.errors.rms_percent);
    let small = Options { budget: Some(160_000), ..only(Predictor::Kernel) };
    let small = measured(examples, &small, Split::HeldOut);
    assert!(small.model_bytes <= 160_000);
    // Promised: 0.047 (FIGURES). The bar is wider: a sixth of the error of LBS.
    assert!(small.errors.rms_percent <= 0.11, "{}", small.errors.rms_percent);
    // Tangent coefficients are dropped before helpers. Promised: 0.151 (FIGURES).
    let smallest = Options { budget: Some(60_000), proxies: None, ..only(Predictor::Kernel) };
    let smallest = measured(examples, &smallest, Split::HeldOut);
    assert!(smallest.errors.rms_percent <= 0.25, "{}", smallest.errors.rms_percent);
}

#[test]
fn an_elbow_bent_further_than_in_training_stays_better_than_lbs_and_is_less_confident() {
    let Some((examples, model)) = arm() else { return };
    let usual = evaluate(model, None, examples, Frames::Of(Split::HeldOut)).unwrap();
    let mut examples = examples.clone();
    let elbow = examples.skeleton.names.iter().position(|name| name == "lowerarm_r").unwrap();
    let frames: Vec<usize> = (0..examples.frame_len()).collect();
    let poses = Poses::new(&examples, &frames);
    let angles: Vec<f64> = frames.iter().map(|&i| poses.angle(i, elbow).norm()).collect();
    let mut sorted = angles.clone();
    sorted.sort_by(f64::total_cmp);
    let bent = sorted[3 * sorted.len() / 4];
    let split = |angle: &f64| if *angle > bent { Split::HeldOut } else { Split::Train };
    examples.split = angles.iter().map(split).collect();
    let far = measured(&examples, &only(Predictor::Kernel), Split::HeldOut);
    // Promised: better than LBS, whose error is 0.90 there, and less confident; the figures are in
    // FIGURES.
    assert!(far.errors.rms <= far.lbs.rms, "{far:?}");
    assert!(far.confidence.mean < usual.confidence.mean, "{far:?} {usual:?}");
    assert!(far.confidence.least < usual.confidence.least, "{far:?} {usual:?}");
    assert!(usual.confidence.mean > 0.9 && usual.confidence.least > 0.5, "{far:?} {usual:?}");
}

#[test]
fn joints_that_never_moved_lose_confidence_as_they_turn() {
    let Some((examples, _)) = arm() else { return };
    let mut examples = examples.clone();
    // The first frames rotate only the collarbone.
    examples.split.iter_mut().enumerate().for_each(|(frame, split)| {
        *split = if frame < 12 { Split::Train } else { Split::HeldOut };
    });
    let model = train(&examples, &only(Predictor::Kernel), &Silent).unwrap().model;
    let seen = evaluate(&model, None, &examples, Frames::Of(Split::Train)).unwrap();
    let unseen = evaluate(&model, None, &examples, Frames::Of(Split::HeldOut)).unwrap();
    // The data do not determine which vertices follow the other joints. Arbitrary weights give LBS
    // an error of 8.6 %, weights by the nearest joint 3.0 %.
    assert!(unseen.lbs.rms_percent < 3.5 && unseen.errors.rms_percent < 3.5, "{unseen:?}");
    assert!(unseen.errors.rms_percent > 1.0, "{unseen:?}");
    assert!(seen.confidence.least > 0.5, "{seen:?}");
    assert!(unseen.confidence.mean < 0.3, "{unseen:?}");
}

#[test]
fn dense_lbs_weights_reach_the_error_that_dem_bones_prints() {
    let Some(examples) = set("dem-bones/bone.npz") else { return };
    let frames: Vec<usize> = (0..examples.frame_len()).collect();
    let poses = Poses::new(&examples, &frames);
    let moved = trajectories(&examples, &frames, &poses);
    let (dense, _) = weights::fit(&examples.rest, &moved, &poses, examples.joint_len(), None);
    let targets = Targets {
        rest: &examples.rest,
        weights: &dense,
        trajectories: &moved,
        importance: Importance::UNIFORM,
    };
    let rmse = targets.rms(&poses.stacked());
    // Published: the error that Dem Bones prints for this set. All frames are training frames.
    assert!((rmse - 0.026_552_3).abs() < 1e-6, "{rmse}");
}

#[test]
fn proxies_alone_on_dem_bones() {
    let Some(examples) = set("dem-bones/bone.npz") else { return };
    let Training { unit, rest, triangles, trajectories, .. } =
        Training::new(&examples, &Silent).unwrap();
    let basis = basis::basis(&trajectories);
    let surface = Surface::new(&rest, triangles, &trajectories, &basis, Importance::UNIFORM);
    let tree = merge::MergeTree::build(&surface, || ());
    // Promised on training frames: 0.0019, 0.0010 and 0.0006 (METHOD §1.7.1); nothing is held out
    // here.
    for (count, most) in [(10, 0.0020), (20, 0.0013), (30, 0.0009)] {
        let proxies = ProxyCount::Fixed(count);
        let options = s3::RotationalOptions { proxies, ..s3::RotationalOptions::default() };
        let none = faer::Mat::zeros(0, 0);
        let fitted = proxies::fit(&surface, &tree, &none, &options, &Silent).unwrap();
        assert!(unit * fitted.rms <= most, "P = {count}: {}", unit * fitted.rms);
    }
}

/// Checks that the smallest candidate that ties with the best in cross-validation is chosen: a
/// candidate with kernel maps before one without.
fn check_choice(report: &TrainingReport) {
    let (chosen, all) = (report.chosen(), &report.candidates);
    let best = all.iter().filter_map(|c| c.validated_rms).fold(f64::INFINITY, f64::min).max(1e-4);
    let alike = all.iter().filter(|c| c.validated_rms.is_some_and(|rms| rms <= 1.02 * best));
    let order = |c: &CandidateReport| (c.predictor == "rotational", c.bytes);
    assert_eq!(alike.map(order).min(), Some(order(chosen)));
}

#[test]
fn the_demo_arm_by_every_predictor_and_by_the_best() {
    let examples = demo(&DemoOptions::default());
    let unrefined = Options { refine: false, ..only(Predictor::Rotational) };
    let plain = measured(&examples, &unrefined, Split::HeldOut);
    // The demo's promise: LBS leaves about 1 %, the unrefined method half of it, each predictor a
    // tenth (FIGURES: 0.663, 0.205, at most 0.019). The choice equals the best except for ties:
    // within 2 % in cross-validation, the smaller file is chosen.
    assert!((0.6..1.5).contains(&plain.lbs.rms_percent), "{}", plain.lbs.rms_percent);
    assert!(plain.errors.rms < 0.5 * plain.lbs.rms);
    let mut least = f64::INFINITY;
    for predictor in Predictor::ALL {
        let found = measured(&examples, &only(predictor), Split::HeldOut);
        assert!(found.errors.rms < 0.1 * found.lbs.rms, "{predictor:?}");
        least = least.min(found.errors.rms);
    }
    let trained = train(&examples, &only(Predictor::Kernel), &Silent).unwrap();
    check_choice(&trained.report);
    let found = evaluate(&trained.model, None, &examples, Frames::Of(Split::HeldOut)).unwrap();
    assert!(found.errors.rms <= 1.15 * least, "{} {least}", found.errors.rms);
}

/// Trains without a clip. Returns the errors on this clip and the forecast for another clip, in %
/// of the diagonal.
fn held_out(clip: &str) -> Option<(Evaluation, f64)> {
    let mut loaded = npz::load(&shared("../cases/rigs/biped.npz")?).unwrap();
    loaded.examples.hold_out_clips(&loaded.clips, &[clip.to_owned()]).unwrap();
    let model = train(&loaded.examples, &Options::default(), &Silent).unwrap().model;
    let file = Model::from_bytes(&model).unwrap();
    let certificate = file.first::<Envelope>().unwrap().certificate();
    let forecast = f64::from(certificate.other_clip_rms.unwrap() / certificate.diagonal);
    let found = evaluate(&model, None, &loaded.examples, Frames::Of(Split::HeldOut)).unwrap();
    Some((found, 100.0 * forecast))
}

#[test]
fn an_unseen_clip_is_no_worse_than_by_own_or_fitted_weights_and_is_forecast() {
    // The smaller of two RMS errors, by an independent measurement: of the artist's weights, and of
    // fitted weights before the pull to the artist's.
    for (clip, least) in [("Walk 歩き", 0.171), ("Wave & look", 0.163), ("Squat + squash", 0.226)]
    {
        let Some((found, forecast)) = held_out(clip) else { return };
        let (model, lbs) = (found.errors.rms_percent, found.lbs.rms_percent);
        assert!(model <= 1.02 * least && lbs <= 1.02 * least, "{clip}: {model} {lbs} {least}");
        let ratio = forecast / model;
        assert!((0.7..4.0).contains(&ratio), "{clip}: the forecast is {ratio} times the error");
    }
}

#[test]
fn no_forecast_is_below_the_error_on_the_frames_that_were_read() {
    // Forecasts use 250 vertices, which leave less data for 60 helpers than the 2,500 vertices do.
    let examples = demo(&DemoOptions { vertices: 2500, poses: 120, held_out: 0, seed: 1 });
    let options = Options { proxies: Some(ProxyCount::Fixed(60)), ..Options::default() };
    let report = train(&examples, &options, &Silent).unwrap().report;
    assert!(report.same_clips_rms >= report.training_rms, "{report:?}");
}
