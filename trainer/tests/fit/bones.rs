//! Helpers as bones of translation, rotation and scale (METHOD §1.13).

use models::shared;
use sinew_runtime::envelope::{HelperKind, Predictor, Trs};
use sinew_runtime::{Envelope, Matrix3x4, Model, Skin};
use sinew_trainer::ErrorKind;
use sinew_trainer::envelope::s3::ProxyCount;
use sinew_trainer::envelope::{Options, Predict, Trained, train};
use sinew_trainer::evaluate::{Frames, evaluate};
use sinew_trainer::examples::demo::{DemoOptions, demo};
use sinew_trainer::examples::{Examples, Split, npz};
use sinew_trainer::progress::Silent;
use std::sync::OnceLock;

fn fitted(examples: &Examples, helper_kind: HelperKind) -> Trained {
    let options =
        Options { helper_kind, proxies: Some(ProxyCount::Fixed(40)), ..Options::default() };
    train(examples, &options, &Silent).unwrap()
}

/// The demo, and a model of each kind trained on it.
fn arm() -> &'static (Examples, [Trained; 3]) {
    static ARM: OnceLock<(Examples, [Trained; 3])> = OnceLock::new();
    ARM.get_or_init(|| {
        let examples = demo(&DemoOptions::default());
        let models = HelperKind::ALL.map(|kind| fitted(&examples, kind));
        (examples, models)
    })
}

/// Bends the elbow of the demo's arm by an angle in degrees.
fn elbow(examples: &Examples, degrees: f64) -> Vec<Matrix3x4> {
    let elbow = examples.skeleton.names.iter().position(|name| name == "forearm").unwrap();
    let origin = nalgebra::Vector3::from(examples.skeleton.rest[elbow].map(|row| row[3]));
    let along = nalgebra::Vector3::from(examples.skeleton.rest[elbow + 1].map(|row| row[3]));
    // The arm lies in the plane of x and y, and bends in the plane of the arm and z.
    let axis = (along - origin).cross(&nalgebra::Vector3::z()).normalize();
    let turn = nalgebra::Rotation3::from_scaled_axis(axis * degrees.to_radians());
    let shift = origin - turn * origin;
    let bent = [0, 1, 2].map(|r| {
        let row = turn.matrix().row(r);
        [row[0] as f32, row[1] as f32, row[2] as f32, shift[r] as f32]
    });
    let rest = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
    (0..examples.joint_len()).map(|joint| if joint < elbow { rest } else { bent }).collect()
}

/// Returns the RMS distance between the skin of the bones and the skin of the palette.
fn loss(envelope: &Envelope<'_>, skin: &Skin<'_>, pose: &[Matrix3x4]) -> f64 {
    let mut palette = vec![[[0.0; 4]; 3]; envelope.palette_len()];
    let mut bones = vec![Trs::IDENTITY; envelope.proxy_len()];
    let mut scratch = vec![0.0; envelope.scratch_len()];
    envelope.palette_trs(pose, &[], &mut scratch, &mut palette, &mut bones).unwrap();
    let skinned = |palette: &[Matrix3x4]| {
        let mut out = vec![[0.0; 3]; skin.vertex_len()];
        skin.skin_positions(palette, &mut out).unwrap();
        out
    };
    let expected = skinned(&palette);
    let helpers = &mut palette[envelope.joint_len()..];
    for (l, (out, bone)) in helpers.iter_mut().zip(bones).enumerate() {
        *out = bone.palette_entry(envelope.helper_centre(l).unwrap());
    }
    let found = skinned(&palette);
    let squares = found.as_flattened().iter().zip(expected.as_flattened());
    let sum: f64 = squares.map(|(a, b)| f64::from(a - b).powi(2)).sum();
    (sum / found.len() as f64).sqrt()
}

/// Loss of the elbow at 20 and at 100 degrees, as shares of the diagonal.
fn losses(examples: &Examples, Trained { model, .. }: &Trained) -> [f64; 2] {
    let model = Model::from_bytes(model.as_slice()).unwrap();
    let (envelope, skin) = (model.first::<Envelope>().unwrap(), model.first::<Skin>().unwrap());
    let diagonal = f64::from(envelope.certificate().diagonal);
    [20.0, 100.0].map(|angle| loss(&envelope, &skin, &elbow(examples, angle)) / diagonal)
}

#[test]
fn bones_lose_little_of_affine_helpers_and_nothing_of_others() {
    let (examples, models) = arm();
    let [affine, trs, rigid] = models.each_ref().map(|trained| losses(examples, trained));
    println!("{affine:?} {trs:?} {rigid:?}");
    assert!(affine[1] < 2e-3 && affine[0] < 4.5e-4, "{affine:?}");
    // Helpers that bend are affine: the control of the comparison.
    assert!(affine[1] > 5e-4, "{affine:?}");
    for own in [trs, rigid].concat() {
        assert!(own < 1e-5, "{trs:?} {rigid:?}");
    }
}

#[test]
fn training_states_the_loss() {
    for (kind, trained) in HelperKind::ALL.into_iter().zip(&arm().1) {
        let model = Model::from_bytes(trained.model.as_slice()).unwrap();
        let envelope = model.first::<Envelope>().unwrap();
        assert_eq!(envelope.helper_kind(), kind);
        let bones = trained.report.bones;
        let certificate = envelope.certificate();
        let stated = f64::from(certificate.trs_error / certificate.diagonal);
        assert!((stated - bones.largest).abs() <= 1e-6 * stated.max(1e-9), "{stated} {bones:?}");
        if kind == HelperKind::Affine {
            assert!(bones.rms > 5e-4 && bones.rms < 2e-3 && bones.largest < 0.02, "{bones:?}");
        } else {
            assert!(bones.largest < 1e-9, "{bones:?}");
        }
    }
}

/// Returns the held-out error of a model.
fn held_out(examples: &Examples, Trained { model, .. }: &Trained) -> f64 {
    evaluate(model, None, examples, Frames::Of(Split::HeldOut)).unwrap().errors.rms
}

#[test]
fn helpers_that_bones_hold_are_almost_as_good() {
    let (examples, models) = arm();
    let [affine, trs, rigid] = models.each_ref().map(|trained| held_out(examples, trained));
    println!("{affine} {trs} {rigid}");
    assert!(trs < 1.5 * affine && rigid < 2.0 * affine, "{affine} {trs} {rigid}");
    let Some(path) = shared("mpfb-arm/mpfb_arm.npz") else { return };
    let examples = npz::load(&path).unwrap().examples;
    let [affine, trs] = [HelperKind::Affine, HelperKind::Trs]
        .map(|kind| held_out(&examples, &fitted(&examples, kind)));
    assert!(trs < 1.5 * affine, "{affine} {trs}");
}

#[test]
fn the_predictor_rotational_refuses_other_kinds() {
    let examples = demo(&DemoOptions { vertices: 300, poses: 12, held_out: 0, seed: 1 });
    let options = Options {
        predictor: Predict::Only(Predictor::Rotational),
        helper_kind: HelperKind::Trs,
        ..Options::default()
    };
    let Err(error) = train(&examples, &options, &Silent) else { panic!("it is trained") };
    assert_eq!(error.kind(), ErrorKind::Unsupported);
    assert!(error.to_string().contains("kind trs"), "{error}");
}
