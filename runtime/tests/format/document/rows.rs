//! The message, its rows, and the numbers of names.

use super::{FORMAT, assert_fields, field, length, number, table};
use models::{Pieces, head};
use sinew_runtime::envelope::{EnvelopeCounts, GroupKernel, GroupRow, NO_JOINT, Predictor};
use sinew_runtime::format::{
    ALIGNMENT, Axis, CHECKSUM_OFFSET, Element, Handedness, MAGIC, PartKind, PartRow, SectionRow,
    Space, VERSION,
};
use sinew_runtime::kernel::{
    EulerOrder, InputKind, InputRow, Kernel, KernelRule, NO_TERM, Normalise, OutputKind, OutputRow,
    QueryRule,
};
use sinew_runtime::skin::NO_ENVELOPE;

#[test]
fn the_document_lays_rows_out_as_the_code() {
    // Every byte of a row equals its offset, so a field's value shows its place.
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
        ("certainty_len", row.certainty_len.into()),
        ("input_len", row.input_len.into()),
        ("centre_len", row.centre_len.into()),
        ("rank", row.rank.into()),
        ("proxy_len", row.proxy_len.into()),
        ("offset", row.offset.into()),
        ("reach", row.confidence.reach.to_bits().into()),
        ("linear", row.confidence.linear.to_bits().into()),
        ("signal", row.confidence.signal.to_bits().into()),
        ("noise", row.confidence.noise.to_bits().into()),
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
    // The byte strings follow: a length, then the rows of the parts.
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
    }
    for number in 0..9 {
        let mut items = predictors.split([',', ';']).map(str::trim);
        let is_listed = items.any(|item| item.starts_with(&format!("{number} ")));
        let counts = EnvelopeCounts::from_words([number, 1, 1, 0, 0, 0, 0, 0]);
        assert_eq!(counts.is_some(), is_listed, "{number}");
    }
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
#[should_panic(expected = "Part row: kind")]
fn the_check_of_a_row_can_fail() {
    assert_fields("Part row", &[1, 0, 0, 0], &[("kind", 2), ("flags", 0)]);
}
