//! Tests small files that state large counts, and files with the largest numbers.

use hostile::evaluate::evaluate_pose;
use models::{GOLDEN, GOLDEN_KIND, GOLDEN_STRETCH, Pieces, group_row};
use sinew_runtime::envelope::{GroupConfidence, GroupRow, KEY_WORDS};
use sinew_runtime::format::{CORRECTION_MAX, MAGNITUDE_MAX, SectionKind, TRAVEL_MAX};
use sinew_runtime::{Envelope, FileError, FileErrorKind as Kind, Limits, Matrix3x4, Model};

const UNLIMITED: Limits = Limits {
    file_bytes: u32::MAX,
    parts: u16::MAX,
    sections: u16::MAX,
    vertices: u32::MAX,
    joints: u32::MAX,
    proxies: u32::MAX,
    influences: u32::MAX,
    shapes: u32::MAX,
    curves: u32::MAX,
};

/// Loads a golden in which one count is changed, and returns the refusal.
fn promised(golden: &[u8], counts: SectionKind, at: usize, count: u32) -> FileError {
    let mut pieces = Pieces::of(golden).unwrap();
    pieces.set_word(counts, at, count);
    // Content that fails every check: if it were read first, the error would name it.
    for kind in [SectionKind::RestNormals, SectionKind::InverseBinds] {
        pieces.section(kind).fill(0xff);
    }
    Model::from_bytes_with(pieces.bytes(), &UNLIMITED).unwrap_err()
}

#[test]
fn counted_content_must_exist_before_anything_is_read() {
    use SectionKind::{EnvelopeCounts, SkinCounts};
    let length = |section: SectionKind, expected: u64, error: FileError| {
        let expected = u32::try_from(expected).unwrap_or(u32::MAX);
        let found = (error.kind, error.section, error.expected);
        assert_eq!(found, (Kind::Length, Some(section), expected), "{error}");
    };
    let limit = |section: SectionKind, index: u32, most: u32, error: FileError| {
        let found = (error.kind, error.section, error.index, error.expected, error.found);
        assert_eq!(found, (Kind::Limit, Some(section), index, most, u32::MAX), "{error}");
    };
    for golden in GOLDEN.into_iter().chain(GOLDEN_STRETCH) {
        let model = Model::from_bytes(golden).unwrap();
        let counts = model.first::<Envelope>().unwrap().counts();
        let (predictor, curves) = (counts.predictor, u64::from(counts.curve_len));
        // Counts: predictor, J, P, root, G, floats of the correction, whether joints stretch, C.
        let envelope = |at, count| promised(golden, EnvelopeCounts, at, count);
        limit(EnvelopeCounts, 1, 65_535, envelope(1, u32::MAX));
        length(SectionKind::Names, 4 * (65_536 + curves), envelope(1, 65_535));
        limit(EnvelopeCounts, 2, 65_535, envelope(2, u32::MAX));
        if predictor.reconstructs() {
            length(SectionKind::Keys, 220 * 65_535, envelope(2, 65_535));
        }
        let groups = if predictor.corrects() { 5 } else { 0 };
        limit(EnvelopeCounts, 4, groups, envelope(4, u32::MAX));
        if predictor.corrects() {
            length(SectionKind::Groups, 32 * 5, envelope(4, 5));
        }
        limit(EnvelopeCounts, 6, 1, envelope(6, u32::MAX));
        let most = if predictor.corrects() { 65_535 } else { 0 };
        limit(EnvelopeCounts, 7, most, envelope(7, u32::MAX));
        if predictor.corrects() {
            // The name of the part, 5 joints, and the curves.
            length(SectionKind::Names, 4 * (6 + 65_535), envelope(7, 65_535));
        }
        // Fields that are not counts have their own checks.
        for at in [3, 5] {
            let error = envelope(at, u32::MAX);
            let section = error.section.unwrap();
            let expected =
                [(Kind::Invalid, SectionKind::Hierarchy), (Kind::Float, SectionKind::InverseBinds)];
            assert!(expected.contains(&(error.kind, section)), "{error}");
        }
    }
    // V, K, the envelope, R. The sections of the envelope are valid here.
    for golden in GOLDEN.into_iter().chain(GOLDEN_STRETCH) {
        let skin = |at, count| {
            let mut pieces = Pieces::of(golden).unwrap();
            pieces.set_word(SkinCounts, at, count);
            pieces.section(SectionKind::RestNormals).fill(0xff);
            Model::from_bytes_with(pieces.bytes(), &UNLIMITED).unwrap_err()
        };
        length(SectionKind::RestPositions, 12 * 0xffff_fff8, skin(0, u32::MAX));
        limit(SkinCounts, 1, 65_535, skin(1, u32::MAX));
        length(SectionKind::InfluenceIndices, 2 * 24 * 65_535, skin(1, 65_535));
        length(SectionKind::Names, 4 * 0xffff_ffff, skin(3, 0xffff_fffe));
        length(SectionKind::Names, u64::MAX, skin(3, u32::MAX));
        limit(SkinCounts, 4, 65_535, skin(4, u32::MAX));
        length(SectionKind::Names, 4 * (1 + 2 + 65_535), skin(4, 65_535));
        // A skin without shapes.
        limit(SkinCounts, 5, 0, skin(5, u32::MAX));
        limit(SkinCounts, 6, 0, skin(6, u32::MAX));
    }
}

#[test]
fn helpers_that_take_few_bytes_are_held_by_the_limits() {
    // A kernel envelope without a skin, with one group of as many helpers as possible and no
    // centres: a few bytes state a palette of many transforms, within the limits of the caller.
    let promise = |proxies: u32| {
        let mut pieces = Pieces::of(GOLDEN[1]).unwrap();
        pieces.parts.truncate(1);
        pieces.sections.retain(|content| content.part == 0);
        let row = GroupRow {
            joint: 0,
            kernel: 8,
            certainty_len: 0,
            input_len: 0,
            centre_len: 0,
            rank: 0,
            proxy_len: proxies as u16,
            offset: 0,
            confidence: GroupConfidence::default(),
        };
        *pieces.section(SectionKind::Groups) = group_row(&row).to_vec();
        pieces.section(SectionKind::Corrections).clear();
        let places = pieces.section(SectionKind::HelperPlaces);
        *places = places[..36].repeat(proxies as usize);
        pieces.set_word(SectionKind::EnvelopeCounts, 2, proxies);
        pieces.set_word(SectionKind::EnvelopeCounts, 4, 1);
        pieces.set_word(SectionKind::EnvelopeCounts, 5, row.scratch_len() as u32);
        pieces.bytes()
    };
    let most = Limits::DEFAULT.proxies;
    assert_eq!(hostile::targets::run(&promise(most)), Ok(()));
    let refused = hostile::targets::run(&promise(most + 1)).unwrap_err();
    assert_eq!((refused.kind, refused.index, refused.expected), (Kind::Limit, 2, most));
}

/// Sets every number of a golden to its largest value, all of one sign. Normals and tangents keep
/// their length.
fn largest(golden: &[u8]) -> Vec<u8> {
    let mut pieces = Pieces::of(golden).unwrap();
    let fill = |content: &mut [u8], value: f32| {
        content.as_chunks_mut().0.fill(value.to_le_bytes());
    };
    for kind in [
        SectionKind::RestPositions,
        SectionKind::RestBoxes,
        SectionKind::C1,
        SectionKind::C2,
        SectionKind::PoseRanges,
        SectionKind::Origins,
        SectionKind::StretchRanges,
        SectionKind::KeyStretches,
        SectionKind::CurveRanges,
    ] {
        if let Some(content) = pieces.find(kind) {
            fill(content, MAGNITUDE_MAX);
        }
    }
    if let Some(places) = pieces.find(SectionKind::HelperPlaces) {
        places.as_chunks_mut::<36>().0.iter_mut().for_each(|place| {
            fill(&mut place[..12], MAGNITUDE_MAX);
            fill(&mut place[12..], 2.0);
        });
    }
    if let Some(keys) = pieces.find(SectionKind::Keys) {
        keys.chunks_mut(4 * KEY_WORDS).for_each(|key| fill(&mut key[4 * 19..], MAGNITUDE_MAX));
    }
    let mut groups = Vec::new();
    if let Some(rows) = pieces.find(SectionKind::Groups) {
        for bytes in rows.as_chunks_mut().0 {
            let mut row = GroupRow::from_bytes(bytes);
            let [reach, linear, signal, noise] = [CORRECTION_MAX; 4];
            row.confidence = GroupConfidence { reach, linear, signal, noise };
            *bytes = group_row(&row);
            groups.push(row);
        }
    }
    if let Some(words) = pieces.find(SectionKind::Corrections) {
        let words = words.as_chunks_mut::<4>().0;
        for row in groups {
            let group = &mut words[row.offset as usize..][..row.words() as usize];
            let inputs = usize::from(row.input_len).next_multiple_of(8);
            let (features_and_weights, centres_and_all) = group.split_at_mut(2 * inputs);
            // With zero feature weights and centres at rest, the map is confident at any distance.
            fill(features_and_weights[inputs..].as_flattened_mut(), 0.0);
            let centres =
                usize::from(row.centre_len).next_multiple_of(8) * usize::from(row.input_len);
            let (centres, all) = centres_and_all.split_at_mut(centres);
            fill(centres.as_flattened_mut(), 0.0);
            fill(all.as_flattened_mut(), CORRECTION_MAX);
        }
    }
    pieces.bytes()
}

/// Makes half turns about z, with each joint as far away as a pose may go, and scaled.
fn far(joint_len: usize, travel: f32, scale: f32) -> Vec<Matrix3x4> {
    let transform = |joint: usize| {
        let sign = if joint.is_multiple_of(2) { 1.0 } else { -1.0 };
        let turn = sign * scale;
        [
            [turn, 0.0, 0.0, sign * travel],
            [0.0, turn, 0.0, travel],
            [0.0, 0.0, scale, -sign * travel],
        ]
    };
    (0..joint_len).map(transform).collect()
}

#[test]
fn the_largest_numbers_evaluate_to_finite_values() {
    for golden in GOLDEN.into_iter().chain(GOLDEN_STRETCH).chain(GOLDEN_KIND) {
        let file = largest(golden);
        let model = Model::from_bytes(file).unwrap();
        let envelope = model.first::<Envelope>().unwrap();
        let scales: &[f32] = if envelope.stretches() { &[4.0, 1.0, 0.25] } else { &[1.0] };
        for (number, scale) in scales.iter().enumerate() {
            let pose = far(envelope.joint_len(), TRAVEL_MAX, *scale);
            let curves = vec![TRAVEL_MAX; envelope.curve_len()];
            evaluate_pose(&model, &envelope, number, &pose, &curves);
        }
        if envelope.predictor().corrects() {
            let pose = far(envelope.joint_len(), TRAVEL_MAX, scales[0]);
            // The only value in the range of a curve.
            let curves = vec![MAGNITUDE_MAX; envelope.curve_len()];
            let mut scratch = vec![0.0; envelope.scratch_len()];
            let mut palette = vec![[[0.0; 4]; 3]; envelope.palette_len()];
            let confidence = envelope.palette(&pose, &curves, &mut scratch, &mut palette);
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
    let model = Model::from_bytes(file).unwrap();
    let envelope = model.first::<Envelope>().unwrap();
    let pose = far(envelope.joint_len(), 1e25, 1.0);
    let seen = std::panic::catch_unwind(|| evaluate_pose(&model, &envelope, 0, &pose, &[]));
    let message = seen.unwrap_err();
    assert!(message.downcast_ref::<String>().unwrap().contains("is not finite"));
}
