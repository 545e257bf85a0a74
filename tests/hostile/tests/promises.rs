//! Small files that promise much, and numbers as large as a file may hold.
#![allow(clippy::unwrap_used, reason = "a test's helpers fail as the test does")]

use hostile::GOLDEN;
use hostile::evaluate::evaluate_pose;
use hostile::pieces::Pieces;
use sinew_runtime::format::{
    CORRECTION_MAX, GroupRow, KEY_WORDS, MAGNITUDE_MAX, Predictor, SectionKind, TRAVEL_MAX,
};
use sinew_runtime::{FormatError, Limits, Matrix3x4, Model, Quantity};

const UNLIMITED: Limits = Limits {
    file_bytes: u32::MAX,
    vertices: u32::MAX,
    joints: u32::MAX,
    proxies: u32::MAX,
    influences: u32::MAX,
};

#[test]
fn what_counts_promise_must_be_there_before_anything_is_read() {
    for (golden, predictor) in GOLDEN.iter().zip(Predictor::ALL) {
        // Counts: V, J, P, K, root, G, scratch.
        let promised = |at: usize, count: u32| {
            let mut pieces = Pieces::of(golden).unwrap();
            pieces.parts[0].counts[at] = count;
            // A content that no check could pass: it would be the error if it were read first.
            pieces.section(SectionKind::RestNormals).unwrap().fill(0xff);
            Model::from_bytes_with(&pieces.file(|_| {}), &UNLIMITED).unwrap_err()
        };
        let length = |section: SectionKind, expected: u64| {
            move |error: FormatError| match error {
                FormatError::SectionLength { section: found, expected: e, .. } => {
                    let expected = u32::try_from(expected).unwrap_or(u32::MAX);
                    assert_eq!((found, e), (section, expected));
                }
                error => panic!("{section:?}: {error}"),
            }
        };
        let limit = |quantity, most| {
            move |error| {
                assert_eq!(error, FormatError::Limit { quantity, most, found: u32::MAX });
            }
        };
        length(SectionKind::RestPositions, 12 * 0xffff_ffff)(promised(0, u32::MAX));
        limit(Quantity::Joints, 65_535)(promised(1, u32::MAX));
        length(SectionKind::Names, 4 * 65_536)(promised(1, 65_535));
        limit(Quantity::Proxies, 65_535)(promised(2, u32::MAX));
        let per_proxy = if predictor.reconstructs() {
            length(SectionKind::Keys, 220 * 65_535)
        } else {
            length(SectionKind::RestBoxes, 24 * (65_535 + 5))
        };
        per_proxy(promised(2, 65_535));
        limit(Quantity::Influences, 65_535)(promised(3, u32::MAX));
        length(SectionKind::InfluenceIndices, 2 * 24 * 65_535)(promised(3, 65_535));
        let groups = if predictor.corrects() { 5 } else { 0 };
        limit(Quantity::Groups, groups)(promised(5, u32::MAX));
        if predictor.corrects() {
            length(SectionKind::Groups, 24 * 5)(promised(5, 5));
        }
        // What promises nothing is left for its own check.
        for at in [4, 6] {
            let error = promised(at, u32::MAX);
            assert!(matches!(error, FormatError::Hierarchy { .. } | FormatError::Float { .. }));
        }
    }
}

/// A golden whose every number is the largest that it may be, all of one sign.
fn largest(golden: &[u8]) -> Vec<u8> {
    let mut pieces = Pieces::of(golden).unwrap();
    let fill = |content: &mut [u8], value: f32| {
        content.as_chunks_mut().0.fill(value.to_le_bytes());
    };
    for kind in [
        SectionKind::RestPositions,
        SectionKind::RestNormals,
        SectionKind::RestTangents,
        SectionKind::RestBoxes,
        SectionKind::C1,
        SectionKind::C2,
        SectionKind::Origins,
    ] {
        if let Some(content) = pieces.section(kind) {
            fill(content, MAGNITUDE_MAX);
        }
    }
    if let Some(keys) = pieces.section(SectionKind::Keys) {
        keys.chunks_mut(4 * KEY_WORDS).for_each(|key| fill(&mut key[4 * 19..], MAGNITUDE_MAX));
    }
    let mut groups = Vec::new();
    if let Some(rows) = pieces.section(SectionKind::Groups) {
        for bytes in rows.as_chunks_mut().0 {
            let mut row = GroupRow::from_bytes(bytes);
            (row.fade_start, row.fade_end) = (0.5 * CORRECTION_MAX, CORRECTION_MAX);
            *bytes = row.to_bytes();
            groups.push(row);
        }
    }
    if let Some(words) = pieces.section(SectionKind::Corrections) {
        let words = words.as_chunks_mut::<4>().0;
        for row in groups {
            let group = &mut words[row.offset as usize..][..row.words() as usize];
            let inputs = usize::from(row.input_len).next_multiple_of(8);
            let (features_and_weights, centres_and_all) = group.split_at_mut(2 * inputs);
            // With weights of nothing and centres at rest, the map is confident however far a pose is.
            fill(features_and_weights[inputs..].as_flattened_mut(), 0.0);
            let centres =
                usize::from(row.centre_len).next_multiple_of(8) * usize::from(row.input_len);
            let (centres, all) = centres_and_all.split_at_mut(centres);
            fill(centres.as_flattened_mut(), 0.0);
            fill(all.as_flattened_mut(), CORRECTION_MAX);
        }
    }
    pieces.file(|_| {})
}

/// Half turns about z, each joint as far away as a pose may go.
fn far(joint_len: usize, travel: f32) -> Vec<Matrix3x4> {
    let map = |joint: usize| {
        let sign = if joint.is_multiple_of(2) { 1.0 } else { -1.0 };
        [[sign, 0.0, 0.0, sign * travel], [0.0, sign, 0.0, travel], [0.0, 0.0, 1.0, -sign * travel]]
    };
    (0..joint_len).map(map).collect()
}

#[test]
fn the_largest_numbers_evaluate_to_finite_values() {
    for golden in GOLDEN {
        let file = largest(golden);
        let envelope = Model::from_bytes(&file).unwrap().envelope().unwrap();
        evaluate_pose(&envelope, 0, &far(envelope.joint_len(), TRAVEL_MAX));
        if envelope.predictor().corrects() {
            let pose = far(envelope.joint_len(), TRAVEL_MAX);
            let mut workspace = vec![0.0; envelope.workspace_len()];
            let mut palette = vec![[[0.0; 4]; 3]; envelope.palette_len()];
            let confidence = envelope.palette(&pose, &mut workspace, &mut palette);
            assert!(confidence.unwrap() > 0.0, "the kernel maps have taken part");
            let most =
                palette.as_flattened().as_flattened().iter().fold(0.0f32, |a, x| a.max(x.abs()));
            assert!(most > 1e19, "{most}");
        }
    }
}

#[test]
fn the_check_sees_what_is_not_finite() {
    let file = largest(GOLDEN[0]);
    let envelope = Model::from_bytes(&file).unwrap().envelope().unwrap();
    let pose = far(envelope.joint_len(), 1e25);
    let seen = std::panic::catch_unwind(|| evaluate_pose(&envelope, 0, &pose));
    let message = seen.unwrap_err();
    assert!(message.downcast_ref::<String>().unwrap().contains("is not finite"));
}
