//! Presence and length of sections.

use super::{FORMAT, evaluate, table};
use sinew_runtime::envelope::{ENVELOPE_SECTIONS, EnvelopeCounts, HelperKind, Predictor};
use sinew_runtime::filter::{FILTER_SECTIONS, FilterCounts};
use sinew_runtime::format::{Element, SectionKind};
use sinew_runtime::kernel::{KERNEL_SECTIONS, KernelCounts};
use sinew_runtime::prior::{PRIOR_SECTIONS, PriorCounts};
use sinew_runtime::record::{RECORD_SECTIONS, RecordCounts};
use sinew_runtime::skin::{BLOCK, NO_ENVELOPE, SKIN_SECTIONS, SkinCounts};
use sinew_runtime::views::{VIEWS_SECTIONS, ViewsCounts};

fn of_envelope(formula: &str, counts: &EnvelopeCounts) -> u64 {
    evaluate(formula, |word| match word {
        "J" => Some(counts.joint_len.into()),
        "P" => Some(counts.proxy_len.into()),
        "G" => Some(counts.group_len.into()),
        "C" => Some(counts.curve_len.into()),
        "B" => Some(counts.proxy_len.div_ceil(2).into()),
        _ => None,
    })
}

fn of_skin(formula: &str, counts: &SkinCounts, palette_len: usize, element: Element) -> u64 {
    evaluate(&formula.replace("(K - 1)", "K-1"), |word| match word {
        "K-1" => Some(counts.influence_len.saturating_sub(1).into()),
        "V" => Some(counts.vertex_len.into()),
        "W" => Some(counts.vertex_len.next_multiple_of(8).into()),
        "K" => Some(counts.influence_len.into()),
        "R" => Some(counts.range_len.into()),
        "L" => Some(palette_len as u64),
        "S" => Some(counts.shape_len.into()),
        "E" => Some(counts.entry_len.into()),
        "D" => Some(counts.delta_len.into()),
        "B" => Some(counts.vertex_len.div_ceil(BLOCK as u32).into()),
        "w" => Some(element.bytes() as u64),
        _ => None,
    })
}

fn of_kernel(formula: &str, counts: &KernelCounts) -> u64 {
    let count = |word: &str| match word {
        "I" => Some(counts.input_len),
        "O" => Some(counts.output_len),
        "d" => Some(counts.feature_len),
        "e" => Some(counts.metric_len),
        "c" => Some(if counts.metric_len > 0 { counts.metric_len } else { counts.feature_len }),
        "n" => Some(counts.centre_len),
        "T" => Some(counts.term_len),
        "m" => Some(counts.value_len),
        "r" => Some(counts.variance_len),
        _ => None,
    };
    evaluate(formula, |word| {
        let in_blocks = word.strip_prefix("b(").and_then(|word| word.strip_suffix(')'));
        match in_blocks {
            Some(word) => count(word).map(|len| u64::from(len.div_ceil(8))),
            None => count(word).map(u64::from),
        }
    })
}

fn of_prior(formula: &str, counts: &PriorCounts) -> u64 {
    let s = u64::from(counts.shape_len);
    evaluate(formula, |word| match word {
        "S" => Some(s),
        "T" => Some(s * (s + 1) / 2),
        "Y" => Some(counts.symmetry_len.into()),
        "C" => Some(counts.cancel_len.into()),
        _ => None,
    })
}

fn of_views(formula: &str, counts: &ViewsCounts) -> u64 {
    evaluate(formula, |word| match word {
        "K" => Some(counts.point_len.into()),
        "V" => Some(counts.vertex_len.into()),
        "W" => Some(counts.weight_len.into()),
        "E" => Some(counts.element_len.into()),
        "L" => Some(counts.layer_len.into()),
        "N" => Some(counts.view_len.into()),
        "M" => Some(counts.map_len.into()),
        "T" => Some(counts.texture_len.into()),
        "X" => Some(counts.texel_len.into()),
        "B" => Some(counts.point_len.div_ceil(32).into()),
        "D" => Some(u64::from(2 * counts.point_len + 1)),
        _ => None,
    })
}

fn of_filter(formula: &str, counts: &FilterCounts) -> u64 {
    evaluate(formula, |word| match word {
        "F" => Some(counts.factor.into()),
        "N" => Some(counts.tap_len.into()),
        _ => None,
    })
}

fn of_record(formula: &str, counts: &RecordCounts) -> u64 {
    evaluate(formula, |word| match word {
        "F" => Some(counts.frame_len.into()),
        "V" => Some(counts.vertex_len.into()),
        "K" => Some(counts.influence_len.into()),
        _ => None,
    })
}

fn envelope_counts(
    predictor: Predictor,
    [j, p, g, c]: [u32; 4],
    stretches: bool,
) -> EnvelopeCounts {
    EnvelopeCounts {
        predictor,
        joint_len: j,
        proxy_len: p,
        root: 0,
        group_len: g,
        correction_len: 0,
        stretches,
        curve_len: c,
        helper_kind: HelperKind::Affine,
    }
}

/// Whether an envelope has a section, by a cell of the table.
fn must_be_there(cell: &str, counts: &EnvelopeCounts) -> bool {
    let predictor = counts.predictor.name();
    match cell.split_once("with ").map_or((cell, ""), |(who, what)| (who.trim(), what)) {
        ("yes", "") => true,
        ("", "curves") => counts.curve_len > 0,
        (who, "stretches") => counts.stretches && (who.is_empty() || who == predictor),
        (who, "") => who == predictor,
        other => panic!("{other:?}"),
    }
}

#[test]
fn the_document_lists_the_sections_of_the_code() {
    let envelope = table(FORMAT, "Sections of an envelope");
    let skin = table(FORMAT, "Sections of a skin");
    let kernel = table(FORMAT, "Sections of a kernel");
    assert_eq!((envelope.len(), skin.len()), (ENVELOPE_SECTIONS.len(), SKIN_SECTIONS.len()));
    let prior = table(FORMAT, "Sections of a prior");
    assert_eq!((kernel.len(), prior.len()), (KERNEL_SECTIONS.len(), PRIOR_SECTIONS.len()));
    let views = table(FORMAT, "Sections of views");
    let filter = table(FORMAT, "Sections of a filter");
    assert_eq!((views.len(), filter.len()), (VIEWS_SECTIONS.len(), FILTER_SECTIONS.len()));
    let two = envelope.iter().zip(ENVELOPE_SECTIONS).chain(skin.iter().zip(SKIN_SECTIONS));
    let others = kernel.iter().zip(KERNEL_SECTIONS).chain(prior.iter().zip(PRIOR_SECTIONS));
    let others = others.chain(views.iter().zip(VIEWS_SECTIONS));
    let record = table(FORMAT, "Sections of a record");
    assert_eq!(record.len(), RECORD_SECTIONS.len());
    let others = others.chain(filter.iter().zip(FILTER_SECTIONS));
    let others = others.chain(record.iter().zip(RECORD_SECTIONS));
    for (row, kind) in two.chain(others) {
        assert_eq!(row[0], kind.number().to_string());
        let elements = kind.elements().iter().map(|element| element.name());
        assert_eq!((row[1], row[4]), (kind.name(), &*elements.collect::<Vec<_>>().join(", ")));
        assert_eq!(SectionKind::from_number(kind.number()), Some(kind));
    }
    let listed = |kind: SectionKind| {
        let all = envelope.iter().chain(&skin).chain(&kernel).chain(&prior).chain(&views);
        all.chain(&filter).chain(&record).any(|row| row[0] == kind.number().to_string())
    };
    assert!(SectionKind::ALL.into_iter().all(listed));
    for (row, kind) in envelope.iter().zip(ENVELOPE_SECTIONS) {
        for (predictor, stretches) in
            Predictor::ALL.map(|each| [(each, false), (each, true)]).concat()
        {
            for sizes in [[4, 3, 2, 0], [1, 1, 1, 0], [33, 40, 11, 7], [0, 1, 1, 1]] {
                let counts = envelope_counts(predictor, sizes, stretches);
                assert_eq!(counts.has(kind), must_be_there(row[3], &counts), "{}", row[1]);
                let bytes = of_envelope(row[2], &counts);
                assert_eq!(counts.section_bytes(kind), Some(bytes), "{}", row[1]);
            }
        }
    }
    for (row, kind) in skin.iter().zip(SKIN_SECTIONS) {
        for envelope in [0, 7, NO_ENVELOPE] {
            for ([vertex_len, influence_len, range_len, palette_len], [s, e, d], element) in [
                ([7, 2, 2, 3], [0, 0, 0], Element::F32),
                ([1, 1, 0, 1], [5, 4, 4], Element::I8),
                ([900, 4, 11, 73], [53, 400, 9000], Element::F16),
                ([64, 4, 1, 7], [1, 1, 64], Element::F32),
            ] {
                let follows = envelope != NO_ENVELOPE;
                let has = match row[3] {
                    "yes" => Some(true),
                    "no" => None,
                    "with an envelope" => Some(follows),
                    "no, and only if K > 1" if follows && influence_len > 1 => None,
                    "no, and only if K > 1" => Some(false),
                    "with shapes" => Some(s > 0),
                    "no, and only with shapes" if s > 0 => None,
                    "no, and only with shapes" => Some(false),
                    other => panic!("{other}"),
                };
                let words = [vertex_len, influence_len, envelope, range_len, s, e, d];
                let counts = SkinCounts::from_words(words);
                assert_eq!(counts.has(kind), has, "{}", row[1]);
                let palette_len = palette_len as usize;
                let bytes = of_skin(row[2], &counts, palette_len, element);
                let found = counts.section_bytes(kind, palette_len, element);
                assert_eq!(found, Some(bytes), "{}", row[1]);
            }
        }
    }
    for (row, kind) in kernel.iter().zip(KERNEL_SECTIONS) {
        for words in
            [[3, 2, 9, 0, 17, 10, 4, 0], [1, 1, 1, 5, 0, 0, 1, 9], [8, 64, 65, 8, 64, 1, 81, 73]]
        {
            let counts = KernelCounts::from_words(words);
            let has = match row[3] {
                "yes" => true,
                "with a metric" => counts.metric_len > 0,
                "with a variance" => counts.variance_len > 0,
                other => panic!("{other}"),
            };
            assert_eq!(counts.has(kind), has, "{}", row[1]);
            assert_eq!(counts.section_bytes(kind), Some(of_kernel(row[2], &counts)), "{}", row[1]);
        }
    }
    for (row, kind) in prior.iter().zip(PRIOR_SECTIONS) {
        assert_eq!(row[3], "yes");
        for words in [[0, 1, 0, 0], [3, 53, 22, 2], [9, 65_535, 1, 0]] {
            let counts = PriorCounts::from_words(words);
            let bytes = of_prior(row[2], &counts);
            assert_eq!(counts.section_bytes(kind), Some(bytes), "{}", row[1]);
        }
    }
    for (row, kind) in views.iter().zip(VIEWS_SECTIONS) {
        assert_eq!(row[3], if kind == SectionKind::Deformations { "no" } else { "yes" });
        for words in [
            [1, 0, 0, 0, 1, 1, 1, 1, 1, 1, 1],
            [33, 40, 71, 51, 4, 27, 2, 5, 900, 48, 40],
            [32, 9, 17, 8, 3, 2, 1, 6, 65_536, 7, 65_535],
        ] {
            let counts = ViewsCounts::from_words(words);
            let bytes = of_views(row[2], &counts);
            assert_eq!(counts.section_bytes(kind), Some(bytes), "{}", row[1]);
        }
    }
    for (row, kind) in filter.iter().zip(FILTER_SECTIONS) {
        assert_eq!(row[3], if kind == SectionKind::FilterVariances { "no" } else { "yes" });
        for words in [[1, 1], [2, 9], [4, 65_535]] {
            let counts = FilterCounts::from_words(words);
            let bytes = of_filter(row[2], &counts);
            assert_eq!(counts.section_bytes(kind), Some(bytes), "{}", row[1]);
        }
    }
    for (row, kind) in record.iter().zip(RECORD_SECTIONS) {
        let is_lbs = [SectionKind::LbsJoints, SectionKind::LbsWeights].contains(&kind);
        assert_eq!(row[3], if is_lbs { "if K > 0" } else { "yes" });
        for words in [[1, 1, 1, 1], [160, 13_380, 4, 53], [0, 3, 0, 7]] {
            let counts = RecordCounts::from_words(words);
            let bytes = of_record(row[2], &counts);
            assert_eq!(counts.section_bytes(kind), Some(bytes), "{}", row[1]);
        }
    }
}

#[test]
#[should_panic(expected = "assertion")]
fn the_document_check_can_fail() {
    let counts = envelope_counts(Predictor::Rotational, [4, 3, 0, 0], false);
    assert_eq!(counts.section_bytes(SectionKind::Keys), Some(of_envelope("216 P", &counts)));
}
