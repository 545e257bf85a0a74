//! Independence of the training from held-out frames and from the number of threads.

use sinew_runtime::envelope::Predictor;
use sinew_trainer::envelope::s3::ProxyCount;
use sinew_trainer::envelope::{Options, Predict, train};
use sinew_trainer::examples::demo::{DemoOptions, demo};
use sinew_trainer::examples::{Examples, Split, npz};
use sinew_trainer::progress::Silent;

fn arm() -> Examples {
    demo(&DemoOptions { vertices: 300, poses: 40, held_out: 20, seed: 11 })
}

fn model(examples: &Examples) -> Vec<u8> {
    let options = Options { proxies: Some(ProxyCount::Fixed(12)), ..Options::default() };
    train(examples, &options, &Silent).unwrap().model
}

/// Replaces the vertices of some frames with noise, and their poses with other rigid poses.
fn noise(examples: &mut Examples, split: Split) {
    let (vertices, joints) = (examples.vertex_len(), examples.joint_len());
    for frame in examples.frames_of(split) {
        for (k, pose) in examples.transforms[frame * joints..][..joints].iter_mut().enumerate() {
            let (sin, cos) = ((frame * 104_729 + k) as f64).sin_cos();
            *pose = [[cos, -sin, 0.0, 9.0 * sin], [sin, cos, 0.0, cos], [0.0, 0.0, 1.0, sin]];
        }
        for (k, position) in
            examples.vertices[frame * vertices..][..vertices].iter_mut().enumerate()
        {
            let wild = ((frame * 7919 + k) as f64).sin() * 100.0;
            *position = [wild, -wild, wild * wild];
        }
    }
}

#[test]
fn a_file_with_noise_for_held_out_frames_trains_to_the_same_bytes() {
    let folder = std::env::temp_dir().join(format!("sinew-held-out-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let (clean_file, noisy_file) = (folder.join("clean.npz"), folder.join("noisy.npz"));
    let clean = arm();
    let mut noisy = clean.clone();
    noise(&mut noisy, Split::HeldOut);
    npz::save_npz(&clean_file, &clean, &[]).unwrap();
    npz::save_npz(&noisy_file, &noisy, &[]).unwrap();
    let from = |path| model(&npz::load(path).unwrap().examples);
    assert_eq!(from(&clean_file), from(&noisy_file));
    std::fs::remove_dir_all(&folder).unwrap();

    // The places of joints at rest are estimated from the motion too, and only from training
    // frames.
    let mut found = clean.clone();
    found.split.fill(Split::Train);
    found.skeleton.unplaced = (0..found.joint_len()).collect();
    found.hold_out(0.25).unwrap();
    let mut noisy = found.clone();
    noise(&mut noisy, Split::HeldOut);
    let mut read = noisy.clone();
    read.split.fill(Split::Train);
    read.place_joints();
    assert_ne!(read.skeleton.rest, found.skeleton.rest);
    noisy.place_joints();
    assert_eq!(model(&found), model(&noisy));

    // Control: the same noise in one training frame gives another model.
    let mut other = clean.clone();
    let mut split = vec![Split::HeldOut; other.frame_len()];
    split[0] = Split::Train;
    let original = std::mem::replace(&mut other.split, split);
    noise(&mut other, Split::Train);
    other.split = original;
    assert_ne!(model(&clean), model(&other));
}

/// A clip that plays three times carries no more information than once, for every choice by
/// left-out poses. Rounding decides between tied choices, so the test takes the mean over several
/// sets.
#[test]
fn a_loop_is_fitted_as_one_pass_of_it() {
    for predictor in Predictor::ALL {
        let options = Options {
            proxies: Some(ProxyCount::Fixed(12)),
            predictor: Predict::Only(predictor),
            ..Options::default()
        };
        let error = |examples: &Examples| {
            train(examples, &options, &Silent).unwrap().report.chosen().validated_rms.unwrap()
        };
        let ratio = |seed: u64| {
            let once = demo(&DemoOptions { vertices: 300, poses: 40, held_out: 0, seed });
            let mut looped = once.clone();
            looped.split = once.split.repeat(3);
            looped.vertices = once.vertices.repeat(3);
            looped.transforms = once.transforms.repeat(3);
            error(&looped) / error(&once)
        };
        let ratios: Vec<f64> = (11..15).map(ratio).collect();
        let mean = ratios.iter().map(|ratio| ratio.ln()).sum::<f64>() / ratios.len() as f64;
        println!("{}: {ratios:.3?}", predictor.name());
        assert!(mean.abs() < 0.05, "{}: {ratios:?}", predictor.name());
    }
}

#[test]
fn one_thread_and_two_give_the_same_bytes() {
    let examples = arm();
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| model(&examples))
    };
    let one = on(1);
    assert_eq!(one, on(2));
    assert_eq!(one, on(3));
}
