//! The figures that the method is held to on the sets of `../shared/data` (METHOD §1).

#![allow(clippy::unwrap_used, reason = "a test stops where its set-up fails")]

use sinew_trainer::envelope::motion::{Poses, trajectories};
use sinew_trainer::envelope::rotational::proxies::{self, ProxyCount};
use sinew_trainer::envelope::rotational::surface::Surface;
use sinew_trainer::envelope::rotational::training::Training;
use sinew_trainer::envelope::rotational::validation::Targets;
use sinew_trainer::envelope::rotational::{Options, basis, merge};
use sinew_trainer::envelope::{train, weights};
use sinew_trainer::evaluate::{Evaluation, Frames, evaluate};
use sinew_trainer::examples::{Examples, Split, npz};
use sinew_trainer::progress::Silent;
use std::path::Path;

/// Loads a set; none where there is no shared data, which continuous integration must have.
fn set(file: &str) -> Option<Examples> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data").join(file);
    if path.exists() {
        return Some(npz::load(&path).unwrap().examples);
    }
    assert!(std::env::var_os("CI").is_none(), "{file} must be in ../shared/data");
    eprintln!("{file} is not in ../shared/data: not tested");
    None
}

fn measured(examples: &Examples, options: &Options, split: Split) -> Evaluation {
    let model = train(examples, options, &Silent).unwrap().model;
    evaluate(&model, examples, Frames::Of(split)).unwrap()
}

/// Checks a measurement on the held-out frames against LBS's published figure and a bound.
fn check(file: &str, lbs_percent: f64, published_percent: f64, refined_percent: f64) {
    let Some(examples) = set(file) else { return };
    let published = Options { refine: false, ..Options::default() };
    let plain = measured(&examples, &published, Split::HeldOut);
    assert!((plain.lbs.rms_percent / lbs_percent - 1.0).abs() < 0.01, "{}", plain.lbs.rms_percent);
    assert!(plain.errors.rms_percent <= published_percent, "{}", plain.errors.rms_percent);
    let refined = measured(&examples, &Options::default(), Split::HeldOut);
    assert_eq!(refined.proxies, 40);
    assert!(refined.errors.rms_percent <= refined_percent, "{}", refined.errors.rms_percent);
}

#[test]
fn mpfb_arm_as_published_and_refined() {
    check("mpfb-arm/mpfb_arm.npz", 0.696, 0.49, 0.09);
}

#[test]
fn dem_bones_as_published_and_refined() {
    check("dem-bones/bone.npz", 0.534, 0.53, 0.30);
}

#[test]
fn dense_lbs_weights_reach_the_error_that_dem_bones_prints() {
    let Some(examples) = set("dem-bones/bone.npz") else { return };
    let frames: Vec<usize> = (0..examples.frame_len()).collect();
    let poses = Poses::new(&examples, &frames);
    let moved = trajectories(&examples, &frames, &poses);
    let (dense, _) = weights::fit(&examples.rest, &moved, &poses, examples.joint_len());
    let targets = Targets { rest: &examples.rest, weights: &dense, trajectories: &moved };
    let rmse = targets.rms(&poses.stacked());
    assert!((rmse - 0.026_552_3).abs() < 1e-6, "{rmse}");
}

#[test]
fn proxies_alone_on_dem_bones() {
    let Some(examples) = set("dem-bones/bone.npz") else { return };
    let Training { unit, rest, triangles, trajectories, .. } = Training::new(&examples).unwrap();
    let basis = basis::basis(&trajectories);
    let (surface, _) = Surface::new(&rest, triangles, &trajectories, basis);
    let tree = merge::MergeTree::build(&surface, || ());
    for (count, most) in [(10, 0.0020), (20, 0.0013), (30, 0.0009)] {
        let options = Options { proxies: ProxyCount::Fixed(count), ..Options::default() };
        let none = faer::Mat::zeros(0, 0);
        let fitted = proxies::fit(&surface, &tree, &none, &options, &Silent).unwrap();
        assert!(unit * fitted.rms <= most, "P = {count}: {}", unit * fitted.rms);
    }
}

#[test]
fn the_demo_arm_leaves_at_most_half_of_the_error_of_lbs() {
    let examples = sinew_trainer::demo::demo(&sinew_trainer::demo::DemoOptions::default());
    let published = Options { refine: false, ..Options::default() };
    let plain = measured(&examples, &published, Split::HeldOut);
    assert!((0.6..1.5).contains(&plain.lbs.rms_percent), "{}", plain.lbs.rms_percent);
    assert!(plain.errors.rms < 0.5 * plain.lbs.rms);
    let refined = measured(&examples, &Options::default(), Split::HeldOut);
    assert!(refined.errors.rms < 0.1 * refined.lbs.rms);
}
