//! FORMAT.md against the code.

use models::{Pieces, head};
use sinew_runtime::envelope::{
    Certificate, ENVELOPE_SECTIONS, EnvelopeCounts, GroupKernel, GroupRow, NO_JOINT, Predictor,
};
use sinew_runtime::format::{
    ALIGNMENT, Axis, CHECKSUM_OFFSET, Element, Handedness, MAGIC, PartKind, PartRow, SectionKind,
    SectionRow, Space, VERSION,
};
use sinew_runtime::kernel::{
    EulerOrder, InputKind, InputRow, KERNEL_SECTIONS, Kernel, KernelCounts, KernelFit, KernelRule,
    NO_TERM, Normalise, OutputKind, OutputRow, QueryRule,
};
use sinew_runtime::prior::{PRIOR_SECTIONS, PriorCounts, PriorFit};
use sinew_runtime::skin::{BLOCK, NO_ENVELOPE, SKIN_SECTIONS, SkinCounts};

/// Cells of the rows of the table under a heading.
fn table<'a>(document: &'a str, heading: &str) -> Vec<Vec<&'a str>> {
    let title = format!("{heading}\n");
    let mut sections = document.split("\n## ");
    let section = sections.find(|section| section.starts_with(&title)).unwrap();
    let rows = section.lines().filter(|line| line.starts_with('|')).skip(2);
    rows.map(|row| row.trim_matches('|').split('|').map(str::trim).collect()).collect()
}

/// Value of a product such as "96 B P", or of a bound such as "≥ 4 J + 4".
fn evaluate(formula: &str, factor: impl Fn(&str) -> Option<u64>) -> u64 {
    let factor = |word: &str| factor(word).unwrap_or_else(|| word.parse().unwrap());
    let terms = formula.trim_start_matches('≥').split('+');
    terms.map(|term| term.split_whitespace().map(factor).product::<u64>()).sum()
}

fn of_envelope(formula: &str, counts: &EnvelopeCounts) -> u64 {
    evaluate(formula, |word| match word {
        "J" => Some(counts.joint_len.into()),
        "P" => Some(counts.proxy_len.into()),
        "G" => Some(counts.group_len.into()),
        "B" => Some(counts.proxy_len.div_ceil(2).into()),
        _ => None,
    })
}

fn of_skin(formula: &str, counts: &SkinCounts, palette_len: usize, element: Element) -> u64 {
    evaluate(&formula.replace("(K - 1)", "K-1"), |word| match word {
        "K-1" => Some(counts.influence_len.saturating_sub(1).into()),
        "V" => Some(counts.vertex_len.into()),
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

fn envelope_counts(predictor: Predictor, [j, p, g]: [u32; 3]) -> EnvelopeCounts {
    let (joint_len, proxy_len, group_len) = (j, p, g);
    EnvelopeCounts { predictor, joint_len, proxy_len, root: 0, group_len, correction_len: 0 }
}

/// Little-endian.
fn number(field: &[u8]) -> u64 {
    field.iter().rev().fold(0, |sum, &byte| sum << 8 | u64::from(byte))
}

const FORMAT: &str = include_str!("../../FORMAT.md");

/// Checks that a table's rows follow each other without a gap; returns their length together.
fn length(heading: &str) -> usize {
    table(FORMAT, heading).iter().fold(0, |end, row| {
        assert_eq!(row[0].parse::<usize>().unwrap(), end, "{heading}: {}", row[2]);
        end + row[1].parse::<usize>().unwrap()
    })
}

/// Where a field stands, and its length.
fn field(heading: &str, name: &str) -> (usize, usize) {
    let rows = table(FORMAT, heading);
    let row = rows.iter().find(|row| row[2] == name).unwrap();
    (row[0].parse().unwrap(), row[1].parse().unwrap())
}

/// Checks that the fields of a table are these numbers of some bytes, all of them.
fn assert_fields(heading: &str, bytes: &[u8], fields: &[(&str, u64)]) {
    assert_eq!(table(FORMAT, heading).len(), fields.len(), "{heading}");
    for (name, value) in fields {
        let (offset, len) = field(heading, name);
        assert_eq!(number(&bytes[offset..offset + len]), *value, "{heading}: {name}");
    }
    assert_eq!(length(heading), bytes.len(), "{heading}");
}

#[test]
fn the_document_lists_the_sections_of_the_code() {
    let envelope = table(FORMAT, "Sections of an envelope");
    let skin = table(FORMAT, "Sections of a skin");
    let kernel = table(FORMAT, "Sections of a kernel");
    assert_eq!((envelope.len(), skin.len()), (ENVELOPE_SECTIONS.len(), SKIN_SECTIONS.len()));
    let prior = table(FORMAT, "Sections of a prior");
    assert_eq!((kernel.len(), prior.len()), (KERNEL_SECTIONS.len(), PRIOR_SECTIONS.len()));
    let two = envelope.iter().zip(ENVELOPE_SECTIONS).chain(skin.iter().zip(SKIN_SECTIONS));
    let others = kernel.iter().zip(KERNEL_SECTIONS).chain(prior.iter().zip(PRIOR_SECTIONS));
    for (row, kind) in two.chain(others) {
        assert_eq!(row[0], kind.number().to_string());
        let elements = kind.elements().iter().map(|element| element.name());
        assert_eq!((row[1], row[4]), (kind.name(), &*elements.collect::<Vec<_>>().join(", ")));
        assert_eq!(SectionKind::from_number(kind.number()), Some(kind));
    }
    let listed = |kind: SectionKind| {
        let all = envelope.iter().chain(&skin).chain(&kernel).chain(&prior);
        all.into_iter().any(|row| row[0] == kind.number().to_string())
    };
    assert!(SectionKind::ALL.into_iter().all(listed));
    for (row, kind) in envelope.iter().zip(ENVELOPE_SECTIONS) {
        for predictor in Predictor::ALL {
            let has = row[3] == "yes" || row[3].split(", ").any(|word| word == predictor.name());
            for sizes in [[4, 3, 2], [1, 1, 1], [33, 40, 11]] {
                let counts = envelope_counts(predictor, sizes);
                assert_eq!(counts.has(kind), has, "{}", row[1]);
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
}

#[test]
fn the_document_lays_rows_out_as_the_code() {
    // Every byte of a row is its own offset, so that a field's value tells where it was read.
    let bytes: [u8; 32] = std::array::from_fn(|i| i as u8);
    let row = PartRow::from_bytes(bytes.first_chunk().unwrap());
    assert_eq!(row.to_bytes(), bytes[..PartRow::BYTES]);
    let fields = [("kind", row.kind.into()), ("flags", row.flags.into())];
    assert_fields("Part row", &bytes[..PartRow::BYTES], &fields);
    let row = SectionRow::from_bytes(bytes.first_chunk().unwrap());
    assert_eq!(row.to_bytes(), bytes[..SectionRow::BYTES]);
    let fields = [
        ("kind", row.kind.into()),
        ("part", row.part.into()),
        ("element", row.element.into()),
        ("flags", row.flags.into()),
        ("reserved", row.reserved.into()),
        ("offset", row.offset.into()),
        ("bytes", row.bytes.into()),
    ];
    assert_fields("Section row", &bytes[..SectionRow::BYTES], &fields);
    let row = GroupRow::from_bytes(bytes.first_chunk().unwrap());
    assert_eq!(row.to_bytes(), bytes[..GroupRow::BYTES]);
    let fields = [
        ("joint", row.joint.into()),
        ("kernel", row.kernel.into()),
        ("reserved", row.reserved.into()),
        ("input_len", row.input_len.into()),
        ("centre_len", row.centre_len.into()),
        ("rank", row.rank.into()),
        ("proxy_len", row.proxy_len.into()),
        ("offset", row.offset.into()),
        ("fade_start", row.fade_start.to_bits().into()),
        ("fade_end", row.fade_end.to_bits().into()),
    ];
    assert_fields("Group row", &bytes[..GroupRow::BYTES], &fields);
}

#[test]
fn the_document_lays_the_rows_of_a_kernel_out_as_the_code() {
    let bits = |x: f32| u64::from(x.to_bits());
    let float = |x: f32| x.to_le_bytes();
    let mut bytes = vec![12, 5, 2, 1];
    bytes.extend([1.5, 2.5].map(float).as_flattened());
    let rule = KernelRule::from_bytes(bytes.as_slice().first_chunk().unwrap()).unwrap();
    assert_eq!(rule.to_bytes(), bytes[..]);
    let fields = [
        ("kernel", rule.kernel.number().into()),
        ("parameter", rule.kernel.parameter().into()),
        ("query", rule.query as u64),
        ("normalise", rule.normalise as u64),
        ("fade_start", bits(rule.fade.0)),
        ("fade_end", bits(rule.fade.1)),
    ];
    assert_fields("Rule of a kernel", &bytes, &fields);

    let mut bytes = vec![5, 4, 0, 0];
    bytes.extend([0.25, 0.5, 0.75].map(float).as_flattened());
    let row = InputRow::from_bytes(bytes.as_slice().first_chunk().unwrap()).unwrap();
    assert_eq!(row.to_bytes(), bytes[..]);
    assert_eq!(row.axis, [0.25, 0.5, 0.75]);
    let (at, len) = field("Input row", "axis");
    assert_eq!(bytes[at..at + len], *row.axis.map(float).as_flattened());
    let head = [
        ("kind", row.kind.number().into()),
        ("euler", row.euler.map_or(0, |order| order as u64)),
        ("reserved", 0),
    ];
    for (name, value) in head {
        let (at, len) = field("Input row", name);
        assert_eq!(number(&bytes[at..at + len]), value, "{name}");
    }
    assert_eq!(length("Input row"), InputRow::BYTES);

    let mut bytes = vec![1, 1, 0, 0];
    bytes.extend([-3.0, 4.0, 0.25, 0.5, 0.75, 1.0].map(float).as_flattened());
    let row = OutputRow::from_bytes(bytes.as_slice().first_chunk().unwrap()).unwrap();
    assert_eq!(row.to_bytes(), bytes[..]);
    let (at, len) = field("Output row", "neutral");
    assert_eq!(bytes[at..at + len], *row.neutral.map(float).as_flattened());
    let head = [
        ("kind", row.kind.number().into()),
        ("marked", u64::from(row.is_marked)),
        ("reserved", 0),
        ("low", bits(row.range.0)),
        ("high", bits(row.range.1)),
    ];
    for (name, value) in head {
        let (at, len) = field("Output row", name);
        assert_eq!(number(&bytes[at..at + len]), value, "{name}");
    }
    assert_eq!(length("Output row"), OutputRow::BYTES);
}

#[test]
fn the_document_lays_the_numbers_of_a_kernel_out_as_the_code() {
    let words: [u32; 8] = [11, 12, 13, 14, 15, 16, 17, 18];
    let counts = KernelCounts::from_words(words);
    assert_eq!(counts.words(), words);
    let fields = [
        ("input_len", counts.input_len.into()),
        ("output_len", counts.output_len.into()),
        ("feature_len", counts.feature_len.into()),
        ("metric_len", counts.metric_len.into()),
        ("centre_len", counts.centre_len.into()),
        ("term_len", counts.term_len.into()),
        ("value_len", counts.value_len.into()),
        ("variance_len", counts.variance_len.into()),
    ];
    let bytes = words.map(u32::to_le_bytes);
    assert_eq!(bytes.as_flattened().len(), KernelCounts::BYTES);
    assert_fields("Counts of a kernel", bytes.as_flattened(), &fields);

    let figures = [1.0, 2.0, 3.0, 4.0];
    let fit = KernelFit::from_figures(figures);
    assert_eq!(fit.figures(), figures);
    let bits = |x: f32| u64::from(x.to_bits());
    let fields = [
        ("rms_residual", bits(fit.rms_residual)),
        ("left_out_rms", bits(fit.left_out_rms)),
        ("rounding_error", bits(fit.rounding_error)),
        ("reciprocal_condition", bits(fit.reciprocal_condition)),
    ];
    let bytes = figures.map(f32::to_le_bytes);
    assert_fields("Fit of a kernel", bytes.as_flattened(), &fields);
}

#[test]
fn the_document_lays_the_numbers_of_a_prior_out_as_the_code() {
    let words: [u32; 4] = [11, 12, 13, 14];
    let counts = PriorCounts::from_words(words);
    assert_eq!(counts.words(), words);
    let fields = [
        ("skin", counts.skin.into()),
        ("shape_len", counts.shape_len.into()),
        ("symmetry_len", counts.symmetry_len.into()),
        ("cancel_len", counts.cancel_len.into()),
    ];
    let bytes = words.map(u32::to_le_bytes);
    assert_eq!(bytes.as_flattened().len(), PriorCounts::BYTES);
    assert_fields("Counts of a prior", bytes.as_flattened(), &fields);

    let figures = [1.0, 2.0, 3.0, 4.0];
    let fit = PriorFit::from_figures(figures);
    assert_eq!(fit.figures(), figures);
    let bits = |x: f32| u64::from(x.to_bits());
    let fields = [
        ("beta", bits(fit.beta)),
        ("frames", bits(fit.frames)),
        ("error", bits(fit.error)),
        ("slider_error", bits(fit.slider_error)),
    ];
    let bytes = figures.map(f32::to_le_bytes);
    assert_fields("Fit of a prior", bytes.as_flattened(), &fields);
}

#[test]
fn the_document_names_the_numbers_of_a_kernel() {
    let inputs = table(FORMAT, "Inputs");
    assert_eq!(inputs.len(), InputKind::ALL.len());
    for (row, kind) in inputs.iter().zip(InputKind::ALL) {
        let numbers = [kind.number_len(), kind.feature_len()].map(|len| len.to_string());
        assert_eq!(row[..2], [kind.number().to_string().as_str(), kind.name()]);
        assert_eq!(row[2..4], numbers.each_ref().map(String::as_str));
        assert_eq!(InputKind::from_number(kind.number()), Some(kind));
    }
    let outputs = table(FORMAT, "Outputs");
    assert_eq!(outputs.len(), OutputKind::ALL.len());
    for (row, kind) in outputs.iter().zip(OutputKind::ALL) {
        let numbers = [kind.value_len(), kind.number_len()].map(|len| len.to_string());
        assert_eq!(row[..2], [kind.number().to_string().as_str(), kind.name()]);
        assert_eq!(row[2..4], numbers.each_ref().map(String::as_str));
        assert_eq!(OutputKind::from_number(kind.number()), Some(kind));
    }
    let cell = |heading: &str, name: &str| {
        let rows = table(FORMAT, heading);
        rows.iter().find(|row| row[2] == name).unwrap()[3].to_owned()
    };
    let names = |names: &[&str], first: usize| {
        let numbered = names.iter().enumerate().map(|(i, name)| format!("{} {name}", first + i));
        numbered.collect::<Vec<_>>().join(", ")
    };
    let query = names(&QueryRule::ALL.map(QueryRule::name), 0);
    assert!(cell("Rule of a kernel", "query").ends_with(&query), "{query}");
    let normalise = names(&Normalise::ALL.map(Normalise::name), 0);
    assert!(cell("Rule of a kernel", "normalise").ends_with(&normalise), "{normalise}");
    let euler = names(&EulerOrder::ALL.map(EulerOrder::name), 1);
    assert!(cell("Input row", "euler").contains(&euler), "{euler}");
    assert!(FORMAT.contains(&format!("\"None\" is {NO_TERM}.")));
}

#[test]
fn the_document_lays_counts_out_as_the_code() {
    let words: [u32; 6] = [2, 11, 12, 13, 14, 15];
    let counts = EnvelopeCounts::from_words(words).unwrap();
    assert_eq!(counts.words(), words);
    let fields = [
        ("predictor", counts.predictor.number().into()),
        ("joint_len", counts.joint_len.into()),
        ("proxy_len", counts.proxy_len.into()),
        ("root", counts.root.into()),
        ("group_len", counts.group_len.into()),
        ("correction_len", counts.correction_len.into()),
    ];
    let bytes = words.map(u32::to_le_bytes);
    assert_eq!(bytes.as_flattened().len(), EnvelopeCounts::BYTES);
    assert_fields("Counts of an envelope", bytes.as_flattened(), &fields);

    let words: [u32; 7] = [11, 12, 13, 14, 15, 16, 17];
    let counts = SkinCounts::from_words(words);
    assert_eq!(counts.words(), words);
    let fields = [
        ("vertex_len", counts.vertex_len.into()),
        ("influence_len", counts.influence_len.into()),
        ("envelope", counts.envelope.into()),
        ("range_len", counts.range_len.into()),
        ("shape_len", counts.shape_len.into()),
        ("entry_len", counts.entry_len.into()),
        ("delta_len", counts.delta_len.into()),
    ];
    let bytes = words.map(u32::to_le_bytes);
    assert_eq!(bytes.as_flattened().len(), SkinCounts::BYTES);
    assert_fields("Counts of a skin", bytes.as_flattened(), &fields);

    let figures = [1.0, 2.0, 3.0, 4.0, 5.0];
    let certificate = Certificate::from_figures(figures);
    assert_eq!(certificate.figures(), figures);
    let bits = |x: f32| u64::from(x.to_bits());
    let fields = [
        ("diagonal", bits(certificate.diagonal)),
        ("training_rms", bits(certificate.training_rms)),
        ("cross_validated_rms", bits(certificate.cross_validated_rms)),
        ("lbs_training_rms", bits(certificate.lbs_training_rms)),
        ("correction_error", bits(certificate.correction_error)),
    ];
    let bytes = figures.map(f32::to_le_bytes);
    assert_eq!(bytes.as_flattened().len(), Certificate::BYTES);
    assert_fields("Certificate", bytes.as_flattened(), &fields);
}

#[test]
fn the_document_lays_the_message_out_as_the_code() {
    assert_eq!(field("Message", "magic"), (0, MAGIC.len()));
    assert_eq!(field("Message", "checksum"), (CHECKSUM_OFFSET, 4));
    let space = Space {
        up: Some(Axis::MinusY),
        forward: Some(Axis::X),
        handedness: Handedness::Left,
        unit: Some(0.5),
    };
    let mut pieces = Pieces::small(Predictor::Rotational);
    pieces.head[head::FEATURES].copy_from_slice(&[1, 2, 3, 4]);
    pieces.head[head::SPACE].copy_from_slice(&space.to_bytes());
    let file = pieces.bytes();
    let (features, len) = field("Message", "features");
    assert_eq!(file[features..features + len], [1, 2, 3, 4]);
    assert_eq!(file[field("Message", "version").0], VERSION);
    assert!(
        table(FORMAT, "Message").iter().any(|row| row[2..] == ["version", &VERSION.to_string()])
    );
    assert!(FORMAT.starts_with(&format!("# The baked model, version {VERSION}\n")));
    let (offset, len) = field("Message", "space");
    let fields = [
        ("up", Axis::MinusY.number().into()),
        ("forward", Axis::X.number().into()),
        ("handedness", Handedness::Left as u64),
        ("reserved", 0),
        ("unit", 0.5f32.to_bits().into()),
    ];
    assert_fields("Space", &file[offset..offset + len], &fields);
    // The first of the byte strings follows: its length, then the rows of the parts.
    let parts = length("Message");
    let rows = pieces.parts.iter().flat_map(PartRow::to_bytes).collect::<Vec<_>>();
    assert_eq!(usize::from(file[parts]), rows.len());
    assert_eq!(file[parts + 1..][..rows.len()], rows);
    assert!(FORMAT.contains(&format!("a multiple of {ALIGNMENT}, counted from the file's start")));
    let rows = table(FORMAT, "Section row");
    let offset = rows.iter().find(|row| row[2] == "offset").unwrap();
    assert!(offset[3].ends_with(&format!("a multiple of {ALIGNMENT}")));
}

#[test]
fn the_document_names_the_numbers_of_the_code() {
    let cell = |heading: &str, name: &str| {
        let rows = table(FORMAT, heading);
        rows.iter().find(|row| row[2] == name).unwrap()[3].to_owned()
    };
    let listed = |cell: &str, number: u64, name: &str| {
        let mut items = cell.split([',', ';', ':']).map(str::trim);
        assert!(items.any(|item| item == format!("{number} {name}")), "{cell}: {number} {name}");
    };
    let kinds = cell("Part row", "kind");
    for kind in PartKind::ALL {
        listed(&kinds, kind.number().into(), kind.name());
        assert_eq!(PartKind::from_number(kind.number()), Some(kind));
    }
    assert_eq!(kinds.split(',').count(), PartKind::ALL.len());
    let predictors = cell("Counts of an envelope", "predictor");
    for predictor in Predictor::ALL {
        listed(&predictors, predictor.number().into(), predictor.name());
        assert_eq!(Predictor::from_number(predictor.number().into()), Some(predictor));
    }
    assert_eq!(predictors.split(',').count(), Predictor::ALL.len());
    let axes = cell("Space", "up");
    for axis in Axis::ALL {
        listed(&axes, axis.number().into(), axis.name());
        assert_eq!(Axis::from_number(axis.number()), Some(axis));
    }
    let hands = cell("Space", "handedness");
    for (hand, name) in [(Handedness::Right, "right"), (Handedness::Left, "left")] {
        listed(&hands, hand as u64, name);
    }
    let elements = table(FORMAT, "Elements");
    assert_eq!(elements.len(), Element::ALL.len());
    for (row, element) in elements.iter().zip(Element::ALL) {
        assert_eq!(row[..2], [element.number().to_string().as_str(), element.name()]);
    }
    let kernels = table(FORMAT, "Kernels");
    for kernel in Kernel::ALL {
        let row = &kernels[usize::from(kernel.number()) - 1];
        assert_eq!(row[..2], [kernel.number().to_string().as_str(), kernel.name()]);
        assert_eq!(row[3] == "0", kernel.parameter() == 0);
    }
    assert_eq!(kernels.len(), usize::from(Kernel::Hat { power: 1 }.number()));
    let [first, .., last] = GroupKernel::ALL.map(GroupKernel::number);
    assert!(FORMAT.contains(&format!("envelope has one of {first} to {last}.")));
    let none = cell("Counts of a skin", "envelope");
    assert!(none.replace(',', "").ends_with(&format!("{NO_ENVELOPE} without")), "{none}");
    assert!(FORMAT.contains(&format!("\"None\" is {NO_JOINT}.")));
}

#[test]
#[should_panic(expected = "assertion")]
fn the_document_check_can_fail() {
    let counts = envelope_counts(Predictor::Rotational, [4, 3, 0]);
    assert_eq!(counts.section_bytes(SectionKind::Keys), Some(of_envelope("216 P", &counts)));
}

#[test]
#[should_panic(expected = "Part row: kind")]
fn the_check_of_a_row_can_fail() {
    assert_fields("Part row", &[1, 0, 0, 0], &[("kind", 2), ("flags", 0)]);
}
