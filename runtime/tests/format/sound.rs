//! Valid files, and their content after loading.

use crate::common::{apart, exercise, skinned};
use models::{Content, Pieces, SMALL, floats};
use sinew_runtime::Model;
use sinew_runtime::envelope::Predictor;
use sinew_runtime::format::{SectionKind, Space};
use sinew_runtime::skin::NormalErrors;

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
    let envelope = shared(model.envelope().unwrap());
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
    let skin = shared(model.skin().unwrap());
    assert_eq!((skin.name(), skin.vertex_len(), skin.influence_len()), ("sleeve", 7, 2));
    assert_eq!((skin.palette_len(), skin.envelope_part()), (3, Some(0)));
    assert_eq!(skin.influences(1).collect::<Vec<_>>(), [(1, 0.75), (2, 0.25)]);
    assert_eq!(skin.influences(usize::MAX).len(), 0);
    let written = pieces.section(SectionKind::RestNormals);
    assert_eq!(floats(&skin.rest_normal(6).unwrap()), written[72..]);
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
        let found = model.skin().unwrap().tangent_coefficients(1 + at / 2).next().unwrap();
        assert_eq!(found[at % 2], exact);
    }
    assert_eq!(skin.tangent_coefficients(0).len(), 1);
    assert_eq!(skin.tangent_coefficients(7).len() + skin.tangent_coefficients(usize::MAX).len(), 0);
    assert_eq!(skin.normal_errors(), Some(NormalErrors { model: 0.03125, lbs: 0.125 }));
    let ranges = skin.ranges().collect::<Vec<_>>();
    assert_eq!(ranges, [("upper", 0..3), ("lower", 4..7)]);
    assert!(model.envelope_named("arm").is_some() && model.envelope_named("sleeve").is_none());
    assert!(model.skin_named("sleeve").is_some() && model.skin_named("arm").is_none());
    assert_eq!((model.parts().len(), model.sections().len()), (2, 20));
    assert_eq!((model.as_bytes(), model.space()), (bytes.as_slice(), Space::default()));
    let first = model.sections().next().unwrap();
    assert_eq!(model.blob()[..24], *first.bytes);
    assert_eq!(model.into_bytes(), bytes);
}

#[test]
fn several_envelopes_and_skins_stand_in_one_file() {
    let bytes = Pieces::several().bytes();
    exercise(&bytes).unwrap();
    let model = Model::from_bytes(bytes).unwrap();
    let kinds = model.parts().map(|row| row.kind).collect::<Vec<_>>();
    assert_eq!(kinds, [1, 2, 1, 2, 2]);
    let predictors = model.envelopes().map(|envelope| (envelope.part(), envelope.predictor()));
    let expected = [(0, Predictor::Rotational), (2, Predictor::Kernel)];
    assert_eq!(predictors.collect::<Vec<_>>(), expected);
    let skins = model.skins().map(|skin| (skin.part(), skin.envelope_part(), skin.palette_len()));
    let expected = [(1, Some(0), 3), (3, Some(2), 7), (4, None, 0)];
    assert_eq!(skins.collect::<Vec<_>>(), expected);
    let followed = model.skins().map(|skin| model.envelope_of(&skin).map(|found| found.part()));
    assert_eq!(followed.collect::<Vec<_>>(), [Some(0), Some(2), None]);
    assert_eq!((model.envelope().unwrap().part(), model.skin().unwrap().part()), (0, 1));
    let eye = model.skin_named("eye").unwrap();
    assert_eq!((eye.part(), eye.influence_len(), eye.influences(0).len()), (4, 0, 0));
    // A mesh without an envelope, and an envelope without a mesh.
    let loose = Model::from_bytes(Pieces::loose(SMALL).bytes()).unwrap();
    assert!(loose.envelope().is_none() && loose.skin().is_some());
    let mut alone = Pieces::small(Predictor::Kernel);
    alone.parts.truncate(1);
    alone.sections.retain(|content| content.part == 0);
    let alone = Model::from_bytes(alone.bytes()).unwrap();
    assert!(alone.envelope().is_some() && alone.skin().is_none());
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
            model.envelopes().map(|envelope| envelope.counts()).collect::<Vec<_>>()
        };
        assert_eq!(envelopes(&model), envelopes(&expected));
        for (found, expected) in model.skins().zip(expected.skins()) {
            let palette = vec![crate::common::IDENTITY; found.palette_len()];
            assert_eq!(skinned(found, &palette), skinned(expected, &palette));
        }
    }
}
