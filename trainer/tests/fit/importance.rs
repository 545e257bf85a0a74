//! Importance: important vertices are fitted better, and equal importance changes nothing.

use sinew_runtime::envelope::Predictor;
use sinew_trainer::envelope::s3::ProxyCount;
use sinew_trainer::envelope::{Options, Predict, train};
use sinew_trainer::evaluate::{Character, Frames, evaluate, skin};
use sinew_trainer::examples::demo::{DemoOptions, demo};
use sinew_trainer::examples::{Examples, Split};
use sinew_trainer::progress::Silent;

fn arm() -> Examples {
    demo(&DemoOptions { vertices: 600, poses: 40, held_out: 10, seed: 1 })
}

fn model(examples: &Examples, predictor: Predictor) -> Vec<u8> {
    let proxies = Some(ProxyCount::Fixed(8));
    let options = Options { predictor: Predict::Only(predictor), proxies, ..Options::default() };
    train(examples, &options, &Silent).unwrap().model
}

/// Returns the RMS error of some vertices over the held-out frames.
fn error(model: &[u8], examples: &Examples, of: impl Fn(usize) -> bool) -> f64 {
    let character = Character::open(model, None, examples).unwrap();
    let (mut sum, mut count) = (0.0, 0);
    for frame in examples.frames_of(Split::HeldOut) {
        let skin = skin(&character, examples, frame).unwrap();
        let found = skin.positions.chunks_exact(3).zip(examples.frame(frame)).enumerate();
        for (_, (found, truth)) in found.filter(|(vertex, _)| of(*vertex)) {
            sum += found.iter().zip(truth).map(|(&a, b)| (f64::from(a) - b).powi(2)).sum::<f64>();
            count += 1;
        }
    }
    (sum / f64::from(count)).sqrt()
}

#[test]
fn important_vertices_are_fitted_better_by_every_predictor() {
    let plain = arm();
    // The plain model can gain most in the region of its largest errors.
    let far = |vertex: usize| plain.rest[vertex][0] > plain.centroid()[0];
    let mut weighed = plain.clone();
    let numbers = (0..plain.vertex_len()).map(|v| if far(v) { 1.0 } else { 1e-3 });
    weighed.set_importance(numbers.collect()).unwrap();
    for predictor in Predictor::ALL {
        let (before, after) = (model(&plain, predictor), model(&weighed, predictor));
        let [here, there] = [&before, &after].map(|model| error(model, &plain, far));
        assert!(there < 0.9 * here, "{predictor:?}: {there} against {here}");
        let [here, there] = [&before, &after].map(|model| error(model, &plain, |v| !far(v)));
        assert!(there > here, "{predictor:?}: what counts less pays, {there} against {here}");
    }
}

#[test]
fn equal_importance_changes_nothing() {
    let plain = arm();
    let mut weighed = plain.clone();
    weighed.set_importance(vec![2.0; plain.vertex_len()]).unwrap();
    for predictor in [Predictor::Rotational, Predictor::Kernel] {
        assert_eq!(model(&weighed, predictor), model(&plain, predictor));
    }
}

/// Errors weigh a vertex of importance 3 like three vertices of importance 1, and ignore a vertex
/// of importance 0.
#[test]
fn errors_weigh_vertices_by_importance() {
    let plain = arm();
    let model = model(&plain, Predictor::Kernel);
    let mut weighed = plain.clone();
    let counts = |vertex: usize| [1, 0, 3][vertex % 3];
    weighed.set_importance((0..plain.vertex_len()).map(|v| counts(v) as f64).collect()).unwrap();
    let found = evaluate(&model, None, &weighed, Frames::Of(Split::HeldOut)).unwrap().errors;

    let character = Character::open(&model, None, &plain).unwrap();
    let mut distances = Vec::new();
    for frame in plain.frames_of(Split::HeldOut) {
        let skin = skin(&character, &plain, frame).unwrap();
        let positions = skin.positions.chunks_exact(3).zip(plain.frame(frame)).enumerate();
        for (vertex, (found, truth)) in positions {
            let squared = found.iter().zip(truth).map(|(&a, b)| (f64::from(a) - b).powi(2));
            distances.extend(vec![squared.sum::<f64>().sqrt(); counts(vertex)]);
        }
    }
    distances.sort_by(f64::total_cmp);
    let rms = (distances.iter().map(|d| d * d).sum::<f64>() / distances.len() as f64).sqrt();
    let percent = 100.0 / plain.diagonal();
    let p99 = distances[(distances.len() * 99).div_ceil(100) - 1];
    let max = distances[distances.len() - 1];
    for (found, expected) in
        [(found.rms, rms), (found.p99_percent, percent * p99), (found.max_percent, percent * max)]
    {
        assert!((found / expected - 1.0).abs() < 1e-9, "{found} against {expected}");
    }
}

#[test]
fn repeated_frames_are_fitted_better() {
    let plain = arm();
    let mut weighed = plain.clone();
    for predictor in Predictor::ALL {
        let of_frame = |model: &[u8], frame: usize| {
            let mut alone = plain.clone();
            alone.split.fill(Split::Train);
            alone.split[frame] = Split::HeldOut;
            error(model, &alone, |_| true)
        };
        // The frame with the largest error.
        let model_of = |examples: &Examples| model(examples, predictor);
        let before = model_of(&plain);
        let errors = plain.frames_of(Split::Train).into_iter();
        let errors = errors.map(|frame| (of_frame(&before, frame), frame));
        let (before, frame) = errors.max_by(|a, b| a.0.total_cmp(&b.0)).unwrap();
        let mut weights = vec![1.0; plain.frame_len()];
        weights[frame] = 30.0;
        weighed.repeat(&weights).unwrap();
        let after = of_frame(&model_of(&weighed), frame);
        assert!(after < 0.8 * before, "{}: {before} {after}", predictor.name());
    }
    // Repeating every frame once changes nothing.
    weighed.repeat(&vec![1.0; plain.frame_len()]).unwrap();
    assert_eq!(model(&weighed, Predictor::Kernel), model(&plain, Predictor::Kernel));
}
