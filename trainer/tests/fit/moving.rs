//! Skins that follow joints which stretch, and animation curves (METHOD §1.10), on the sets of `../shared`.
//!
//! A bound is a promise with 5 to 10 % of room, as in `real_sets.rs`.

use models::shared;
use sinew_runtime::envelope::Predictor;
use sinew_runtime::{Envelope, Model, Skin};
use sinew_trainer::envelope::s3::ProxyCount;
use sinew_trainer::envelope::{Options, Predict, Trained, train};
use sinew_trainer::evaluate::{Errors, Frames, evaluate};
use sinew_trainer::examples::{Examples, Skeleton, Split, npz};
use sinew_trainer::progress::Silent;

fn set(file: &str) -> Option<Examples> {
    shared(file).map(|path| npz::load(&path).unwrap().examples)
}

/// Returns the bytes of a model, and its errors on held-out frames.
fn measured(examples: &Examples, options: &Options) -> (Vec<u8>, Errors) {
    let model = train(examples, options, &Silent).unwrap().model;
    let found = evaluate(&model, None, examples, Frames::Of(Split::HeldOut)).unwrap();
    (model, found.errors)
}

/// Returns the bytes of a model, and its RMS error on held-out frames in % of the diagonal.
fn held_out(examples: &Examples, options: &Options) -> (Vec<u8>, f64) {
    let (model, found) = measured(examples, options);
    (model, found.rms_percent)
}

fn helpers(count: usize, influences: usize) -> Options {
    let proxies = Some(ProxyCount::Fixed(count));
    Options { proxies, influences, ..Options::default() }
}

#[test]
fn a_rig_whose_joints_stretch_is_learned_by_every_predictor() {
    let Some(examples) = set("stretchy/set.npz") else { return };
    assert_eq!(examples.stretching_joints().iter().filter(|stretches| **stretches).count(), 18);
    let rotational =
        Options { predictor: Predict::Only(Predictor::Rotational), ..Options::default() };
    // Promised: 0.065, 0.058, 0.17; the painted weights have 0.1885.
    for (options, most) in
        [(Options::default(), 0.068), (helpers(40, 4), 0.061), (rotational, 0.17)]
    {
        let (model, found) = held_out(&examples, &options);
        assert!(found <= most, "{found}");
        let model = Model::from_bytes(model).unwrap();
        let envelope = model.first::<Envelope>().unwrap();
        let ranges = |joint| envelope.stretch_range(joint).unwrap();
        assert!(envelope.stretches() && ranges(0) == 0.0 && ranges(1) > 0.01);
    }
}

#[test]
fn rigs_of_an_artist_are_learned() {
    for file in ["../cases/rigs/rigify.npz", "../cases/rigs/rigify_nostretch.npz"] {
        let Some(mut examples) = set(file) else { return };
        examples.hold_out(0.25).unwrap();
        // Promised: 0.004.
        let (_, found) = held_out(&examples, &Options::default());
        assert!(found <= 0.004, "{file}: {found}");
    }
}

#[test]
fn curves_and_their_products_with_joints_are_learned() {
    let Some(examples) = set("curves/set.npz") else { return };
    // Promised: 0.040; linear in the curves 0.122.
    let (model, with) = held_out(&examples, &Options::default());
    assert!(with <= 0.042, "{with}");
    let model = Model::from_bytes(model).unwrap();
    let envelope = model.first::<Envelope>().unwrap();
    let names: Vec<_> = (0..envelope.curve_len()).filter_map(|c| envelope.curve_name(c)).collect();
    assert_eq!(names, examples.curve_names);
    // belly goes both ways, the others from 0 to 1.
    let signs = [0, 1, 2].map(|curve| envelope.curve_range(curve).unwrap().map(|x| x < -0.5));
    assert_eq!(signs, [[false, false], [true, false], [false, false]]);
}

#[test]
fn without_the_curves_that_move_it_a_skin_gets_lbs_and_an_honest_forecast() {
    let Some(mut examples) = set("curves/set.npz") else { return };
    examples.keep_curves(&[]).unwrap();
    let Trained { model, report, .. } = train(&examples, &Options::default(), &Silent).unwrap();
    let refused = report.refused.unwrap();
    assert!(report.candidates[refused.candidate].proxies > 0 && report.chosen().proxies == 0);
    let found = evaluate(&model, None, &examples, Frames::Of(Split::HeldOut)).unwrap();
    let forecast = report.other_clip_rms.unwrap() / found.errors.rms;
    // Promised: 0.7 to 1.5.
    assert!((0.7..1.5).contains(&forecast), "{forecast}");
}

#[test]
fn a_face_follows_curves_alone() {
    let Some(examples) = set("face-curves/set.npz") else { return };
    let small = Options { budget: Some(685_000), ..helpers(40, 8) };
    // Promised: the same, but 0.051 mm for 40 helpers. `small` leaves 94 kB for the maps.
    for (options, mean, max) in
        [(Options::default(), 0.046, 1.2), (helpers(40, 8), 0.054, 1.5), (small, 0.058, 1.4)]
    {
        let (model, found) = measured(&examples, &options);
        assert!(model.len() <= options.budget.unwrap_or(usize::MAX), "{}", model.len());
        let found = found.millimetres.unwrap();
        assert!(found.mean_mm <= mean && found.max_mm <= max, "{found:?}");
    }
}

#[test]
fn a_face_needs_no_joint() {
    let Some(examples) = set("face-curves/set.npz") else { return };
    let joint = held_out(&examples, &helpers(40, 8));
    let mut jointless = examples.clone();
    jointless.skeleton = Skeleton::still();
    let (model, found) = held_out(&jointless, &helpers(40, 8));
    assert!((found / joint.1 - 1.0).abs() < 1e-3, "{found} without joints, {} with one", joint.1);
    let model = Model::from_bytes(model).unwrap();
    let (envelope, skin) = (model.first::<Envelope>().unwrap(), model.first::<Skin>().unwrap());
    assert_eq!((envelope.joint_len(), envelope.curve_len()), (0, 52));
    assert_eq!(envelope.palette_len(), 41, "40 helpers, and one that is still");
    let mut palette = vec![Default::default(); envelope.palette_len()];
    let mut scratch = vec![0.0; envelope.scratch_len()];
    envelope.palette(&[], &[0.0; 52], &mut scratch, &mut palette).unwrap();
    let mut rest = vec![[0.0; 3]; skin.vertex_len()];
    skin.skin_positions(&palette, &mut rest).unwrap();
    let off = (0..rest.len()).map(|v| {
        let expected = skin.rest_position(v).unwrap();
        (0..3).map(|axis| (rest[v][axis] - expected[axis]).abs()).fold(0.0, f32::max)
    });
    assert!(off.fold(0.0, f32::max) < 1e-6);
}
