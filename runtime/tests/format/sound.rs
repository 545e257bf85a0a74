//! Valid files, and their content after loading.

use crate::common::{apart, envelope_error, exercise, skinned};
use models::{Content, JOINTLESS, Pieces, SMALL, STRETCHING, floats};
use sinew_runtime::envelope::{NO_JOINT, Predictor};
use sinew_runtime::format::{SectionKind, Space};
use sinew_runtime::skin::NormalErrors;
use sinew_runtime::{Envelope, FileError, FileErrorKind as Kind, Model, Skin};

#[test]
fn a_sound_file_loads_at_any_address() {
    // Additional rows shift the blob's start through many residues.
    for further in (0..=19).step_by(apart(19)) {
        let mut pieces = Pieces::small(Predictor::Rotational);
        pieces.sections.extend((900..900 + further).map(|kind| Content::unknown(kind, 0, 0)));
        let bytes = pieces.bytes();
        exercise(&bytes).unwrap();
        for shift in 1..4 {
            let shifted = [&[0; 3][..shift], bytes.as_slice()].concat();
            exercise(&shifted[shift..]).unwrap();
        }
    }
}

#[test]
fn accessors_give_what_was_written() {
    fn shared<T: Send + Sync + Copy>(value: T) -> T {
        value
    }
    let mut pieces = Pieces::small(Predictor::Rotational);
    pieces.set_float(SectionKind::C1, 8 * 4 + 5, 0.625);
    // Block 1, column 2, its row 3.
    pieces.set_float(SectionKind::C2, 8 * (16 + 2) + 3, 0.375);
    let bytes = pieces.bytes();
    let model = shared(Model::from_bytes(bytes.as_slice()).unwrap());
    let envelope = shared(model.first::<Envelope>().unwrap());
    assert_eq!((envelope.name(), envelope.root()), ("arm", 1));
    assert_eq!(envelope.joint_name(3), Some("joint 3"));
    assert_eq!(envelope.joint_name(4), None);
    assert_eq!([0, 1, 2, 3].map(|j| envelope.parent(j)), [Some(2), None, Some(1), Some(0)]);
    assert_eq!(envelope.evaluation_order().collect::<Vec<_>>(), [1, 2, 0, 3]);
    assert_eq!(envelope.inverse_bind(0).unwrap()[0][3], -2.0);
    assert_eq!((envelope.pose_range(0), envelope.pose_gap(0)), (Some(1.5), Some(0.125)));
    let beyond = envelope.joint_len();
    assert_eq!((envelope.pose_range(beyond), envelope.pose_gap(beyond)), (None, None));
    assert_eq!(envelope.c1(5, 4), Some(0.625));
    assert_eq!(envelope.c2(11, 2), Some(0.375));
    assert_eq!((envelope.c1(12, 0), envelope.c1(0, 9), envelope.c2(0, 16)), (None, None, None));
    let (first, second) = (envelope.key(0).unwrap(), envelope.key(1).unwrap());
    assert_eq!((first.joint, first.residual), (2, None));
    assert_eq!((second.joint, second.residual.unwrap().0), (3, 1));
    assert_eq!((first.twist[0][0], first.shear[0][0], first.shear[3][0]), (0.5, 0.5, 0.5));
    assert_eq!(envelope.certificate().lbs_training_rms, 0.04);
    assert_eq!(envelope.certificate().base_training_rms, 0.03);
    let skin = shared(model.first::<Skin>().unwrap());
    assert_eq!((skin.name(), skin.vertex_len(), skin.influence_len()), ("sleeve", 7, 2));
    assert_eq!((skin.palette_len(), skin.envelope_part()), (3, Some(0)));
    assert_eq!(skin.influences(1).collect::<Vec<_>>(), [(1, 0.75), (2, 0.25)]);
    assert_eq!(skin.influences(usize::MAX).len(), 0);
    pieces.edit_vertices(SectionKind::RestNormals, |written| {
        assert_eq!(floats(&skin.rest_normal(6).unwrap()), written[72..]);
    });
    assert_eq!(
        (skin.rest_position(7), skin.rest_normal(7), skin.rest_tangent(7)),
        Default::default()
    );
    assert_eq!((skin.rest_box(3), skin.rest_box(usize::MAX)), (None, None));
    assert!(skin.rest_box(1).unwrap().contains(skin.rest_position(0).unwrap()));
    assert!(skin.has_coefficients());
    // Half precision: 1, -2.5, the smallest and the largest normal number.
    for (at, (half, exact)) in
        [(0x3c00, 1.0), (0xc100, -2.5), (0x0400, 6.103_515_6e-5), (0x7bff, 65_504.0)]
            .into_iter()
            .enumerate()
    {
        let mut pieces = pieces.clone();
        pieces.set_half(SectionKind::TangentCoefficients, 2 + at, half);
        let model = Model::from_bytes(pieces.bytes()).unwrap();
        let found = model.first::<Skin>().unwrap().tangent_coefficients(1 + at / 2).next().unwrap();
        assert_eq!(found[at % 2], exact);
    }
    assert_eq!(skin.tangent_coefficients(0).len(), 1);
    assert_eq!(skin.tangent_coefficients(7).len() + skin.tangent_coefficients(usize::MAX).len(), 0);
    assert_eq!(
        skin.normal_errors(),
        Some(NormalErrors { model: 0.03125, cofactors: 0.0625, lbs: 0.125 })
    );
    let ranges = skin.ranges().collect::<Vec<_>>();
    assert_eq!(ranges, [("upper", 0..3), ("lower", 4..7)]);
    assert!(
        model.named::<Envelope>("arm").is_some() && model.named::<Envelope>("sleeve").is_none()
    );
    assert!(model.named::<Skin>("sleeve").is_some() && model.named::<Skin>("arm").is_none());
    assert_eq!((model.parts().len(), model.sections().len()), (2, 21));
    assert_eq!((model.as_bytes(), model.space()), (bytes.as_slice(), Space::default()));
    let first = model.sections().next().unwrap();
    assert_eq!(model.blob()[..32], *first.bytes);
    assert_eq!(model.into_bytes(), bytes);
}

#[test]
fn stretches_and_curves_are_read_back() {
    for predictor in Predictor::ALL {
        let mut pieces = Pieces::sample(predictor, STRETCHING);
        let model = Model::from_bytes(pieces.bytes()).unwrap();
        let envelope = model.first::<Envelope>().unwrap();
        assert!(envelope.stretches());
        let ranges = [0, 1, 2, 3, 4].map(|joint| envelope.stretch_range(joint));
        assert_eq!(ranges, [Some(0.0), Some(0.25), Some(0.5), Some(0.0), None]);
        let curves = if predictor.corrects() { 3 } else { 0 };
        assert_eq!((envelope.curve_len(), envelope.counts().curve_len), (curves, curves as u32));
        let expected = [Some([0.0, 1.0]), Some([-0.5, 0.5]), Some([0.25, 2.0])];
        let found = (0..curves).map(|curve| envelope.curve_range(curve)).collect::<Vec<_>>();
        assert_eq!(found, expected[..curves]);
        assert_eq!((envelope.curve_range(curves), envelope.curve_name(curves)), (None, None));
        // Joints keep their names before the curves'.
        assert_eq!((envelope.joint_name(3), envelope.joint_name(4)), (Some("joint 3"), None));
        let features = if predictor.corrects() { 12 * 4 + 6 * 4 + 3 } else { 12 * 4 + 6 * 4 };
        assert_eq!(envelope.counts().feature_len(), features);
        let keys = (0..3).filter_map(|proxy| envelope.key(proxy)?.stretch);
        let stretches = keys.flatten().flatten().collect::<Vec<_>>();
        let written = pieces.find(SectionKind::KeyStretches).cloned().unwrap_or_default();
        assert_eq!(floats(&stretches), written);
        assert_eq!(stretches.len(), if predictor.reconstructs() { 3 * 36 } else { 0 });
    }
    // A rigid model has none of them.
    let model = Model::from_bytes(Pieces::small(Predictor::Rotational).bytes()).unwrap();
    let envelope = model.first::<Envelope>().unwrap();
    assert!(!envelope.stretches() && envelope.key(0).unwrap().stretch.is_none());
    assert_eq!((envelope.stretch_range(3), envelope.stretch_range(4)), (Some(0.0), None));
    assert_eq!((envelope.curve_len(), envelope.curve_range(0)), (0, None));
}

#[test]
fn a_model_may_follow_curves_alone() {
    let bytes = Pieces::sample(Predictor::Kernel, JOINTLESS).bytes();
    exercise(&bytes).unwrap();
    let model = Model::from_bytes(bytes).unwrap();
    let envelope = model.first::<Envelope>().unwrap();
    assert_eq!((envelope.joint_len(), envelope.root(), envelope.curve_len()), (0, 0, 5));
    assert_eq!((envelope.palette_len(), envelope.counts().feature_len()), (3, 5));
    assert_eq!(envelope.evaluation_order().len(), 0);
    assert_eq!(
        (envelope.parent(0), envelope.inverse_bind(0), envelope.origin(0)),
        (None, None, None)
    );
    assert!(envelope.groups().all(|group| group.joint == usize::from(NO_JOINT)));
    assert_eq!(model.first::<Skin>().unwrap().palette_len(), 3);
    // Without curves there must be joints, and without joints helpers.
    let refused = |edit: &dyn Fn(&mut Pieces)| {
        let mut pieces = Pieces::sample(Predictor::Kernel, JOINTLESS);
        edit(&mut pieces);
        Model::from_bytes(pieces.bytes()).unwrap_err()
    };
    let counts =
        |kind, index| FileError { index, ..envelope_error(kind, SectionKind::EnvelopeCounts) };
    let set = |index: usize, value| {
        refused(&|pieces| pieces.set_word(SectionKind::EnvelopeCounts, index, value))
    };
    assert_eq!(set(7, 0), FileError { expected: 1, ..counts(Kind::Empty, 1) });
    assert_eq!(set(2, 0), FileError { expected: 1, ..counts(Kind::Empty, 2) });
    assert_eq!(set(6, 1), FileError { found: 1, ..counts(Kind::Limit, 6) });
    assert_eq!(set(3, 1), counts(Kind::Invalid, 3));
    let joint = refused(&|pieces| pieces.edit_group(1, |row| row.joint = 0));
    let index = FileError { index: 1, ..envelope_error(Kind::Index, SectionKind::Groups) };
    assert_eq!(joint, index);
    // With joints a group must have one.
    let mut pieces = Pieces::small(Predictor::Kernel);
    pieces.edit_group(1, |row| row.joint = NO_JOINT);
    let found = Model::from_bytes(pieces.bytes()).unwrap_err();
    assert_eq!(found, FileError { expected: 4, found: NO_JOINT.into(), ..index });
}

#[test]
fn several_envelopes_and_skins_stand_in_one_file() {
    let bytes = Pieces::several().bytes();
    exercise(&bytes).unwrap();
    let model = Model::from_bytes(bytes).unwrap();
    let kinds = model.parts().map(|row| row.kind).collect::<Vec<_>>();
    assert_eq!(kinds, [1, 2, 1, 2, 2]);
    let predictors =
        model.all::<Envelope>().map(|envelope| (envelope.part(), envelope.predictor()));
    let expected = [(0, Predictor::Rotational), (2, Predictor::Kernel)];
    assert_eq!(predictors.collect::<Vec<_>>(), expected);
    let skins =
        model.all::<Skin>().map(|skin| (skin.part(), skin.envelope_part(), skin.palette_len()));
    let expected = [(1, Some(0), 3), (3, Some(2), 7), (4, None, 0)];
    assert_eq!(skins.collect::<Vec<_>>(), expected);
    let followed =
        model.all::<Skin>().map(|skin| model.envelope_of(&skin).map(|found| found.part()));
    assert_eq!(followed.collect::<Vec<_>>(), [Some(0), Some(2), None]);
    assert_eq!(
        (model.first::<Envelope>().unwrap().part(), model.first::<Skin>().unwrap().part()),
        (0, 1)
    );
    let eye = model.named::<Skin>("eye").unwrap();
    assert_eq!((eye.part(), eye.influence_len(), eye.influences(0).len()), (4, 0, 0));
    // A mesh without an envelope, and an envelope without a mesh.
    let loose = Model::from_bytes(Pieces::loose(SMALL).bytes()).unwrap();
    assert!(loose.first::<Envelope>().is_none() && loose.first::<Skin>().is_some());
    let mut alone = Pieces::small(Predictor::Kernel);
    alone.parts.truncate(1);
    alone.sections.retain(|content| content.part == 0);
    let alone = Model::from_bytes(alone.bytes()).unwrap();
    assert!(alone.first::<Envelope>().is_some() && alone.first::<Skin>().is_none());
}

#[test]
fn sections_stand_in_any_order() {
    let pieces = Pieces::several();
    let expected = Model::from_bytes(pieces.bytes()).unwrap();
    for first in [0, 7, 20] {
        let mut turned = pieces.clone();
        turned.sections.rotate_left(first);
        turned.sections.reverse();
        let bytes = turned.bytes();
        exercise(&bytes).unwrap();
        let model = Model::from_bytes(bytes).unwrap();
        let envelopes = |model: &Model<Vec<u8>>| {
            model.all::<Envelope>().map(|envelope| envelope.counts()).collect::<Vec<_>>()
        };
        assert_eq!(envelopes(&model), envelopes(&expected));
        for (found, expected) in model.all::<Skin>().zip(expected.all::<Skin>()) {
            let palette = vec![crate::common::IDENTITY; found.palette_len()];
            assert_eq!(skinned(found, &palette), skinned(expected, &palette));
        }
    }
}
