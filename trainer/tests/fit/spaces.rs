//! Models in the axes and the unit of an engine have the same errors as models in the examples'
//! axes.

use nalgebra::Vector3;
use sinew_runtime::Model;
use sinew_runtime::envelope::Predictor;
use sinew_runtime::format::Space;
use sinew_trainer::envelope::s3::ProxyCount;
use sinew_trainer::envelope::{Options, Predict, train};
use sinew_trainer::evaluate::{Character, Evaluation, Frames, evaluate, skin};
use sinew_trainer::examples::demo::{DemoOptions, demo};
use sinew_trainer::examples::{Examples, Split};
use sinew_trainer::progress::Silent;
use sinew_trainer::space::Conversion;

const GLTF: Space = Space::GLTF;
const UNREAL: Space = Space::UNREAL;
const UNITY: Space = Space::UNITY;

/// With this seed, no vertex is midway between joints: there the last digit would decide, and a
/// factor of 100 would change it.
fn arm() -> Examples {
    let arm = demo(&DemoOptions { vertices: 400, poses: 40, held_out: 12, seed: 3 });
    Examples { space: GLTF, ..arm }
}

fn model(examples: &Examples, predictor: Predictor) -> Vec<u8> {
    let options = Options {
        predictor: Predict::Only(predictor),
        proxies: Some(ProxyCount::Fixed(6)),
        ..Options::default()
    };
    train(examples, &options, &Silent).unwrap().model
}

/// Evaluates a model on examples that are first converted to its space, as `sinew eval` does.
fn measured(model: &[u8], mut examples: Examples) -> Evaluation {
    examples.convert_to(&Model::from_bytes(model).unwrap().space());
    evaluate(model, None, &examples, Frames::Of(Split::HeldOut)).unwrap()
}

#[track_caller]
fn check(predictor: Predictor) {
    let plain = measured(&model(&arm(), predictor), arm());
    for space in [UNREAL, UNITY] {
        let mut examples = arm();
        let conversion = examples.convert_to(&space).unwrap();
        examples.validate().unwrap();
        let model = model(&examples, predictor);
        assert_eq!(Model::from_bytes(&model).unwrap().space(), space);
        let found = measured(&model, arm());
        for (found, expected) in [
            (found.errors.rms_percent, plain.errors.rms_percent),
            (found.errors.p99_percent, plain.errors.p99_percent),
            (found.errors.max_percent, plain.errors.max_percent),
            (found.errors.normal_rms_degrees, plain.errors.normal_rms_degrees),
            (found.lbs.rms_percent, plain.lbs.rms_percent),
            (found.diagonal, plain.diagonal * conversion.scale),
        ] {
            println!("{}: {found} {expected}", predictor.name());
            assert!((found / expected - 1.0).abs() < 1e-3, "{found} {expected}");
        }
        // Normals point outward in every space.
        let character = Character::open(&model, None, &examples).unwrap();
        let frame = examples.frames_of(Split::HeldOut)[3];
        let skin = skin(&character, &examples, frame).unwrap();
        let posed = examples.posed_normals(frame);
        let along = (0..posed.len()).map(|v| skin.vertex(v).1.dot(&Vector3::from(posed[v])));
        assert!(along.sum::<f64>() / posed.len() as f64 > 0.95);
    }
}

#[test]
fn kernel_models_for_engines_have_the_errors_of_the_examples_space() {
    check(Predictor::Kernel);
}

#[test]
fn rotational_models_for_engines_have_the_errors_of_the_examples_space() {
    check(Predictor::Rotational);
}

#[test]
fn examples_of_unknown_space_are_refused_in_other_axes() {
    let mut examples = arm();
    examples.convert_to(&UNREAL).unwrap();
    let model = model(&examples, Predictor::Kernel);
    let unknown = Examples { space: Space::default(), ..arm() };
    assert_eq!(Conversion::between(&unknown.space, &UNREAL), None);
    let refused = evaluate(&model, None, &unknown, Frames::All).unwrap_err().to_string();
    let begin = "the model's rest mesh is not that of the examples: off by ";
    assert!(refused.starts_with(begin) && refused.contains("--up"), "{refused}");
}
