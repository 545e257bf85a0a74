//! FORMAT.md against the code.
#![allow(clippy::unwrap_used, reason = "a test's helpers fail as the test does")]

mod common;

use common::{Builder, SMALL};
use sinew_runtime::format::{
    CHECKSUM_OFFSET, EnvelopeCounts, GroupRow, MAGIC, PartKind, PartRow, Predictor, Presence,
    SectionKind, SectionRow, VERSION,
};
use sinew_runtime::kernel::Kernel;

/// Cells of the rows of the table under a heading.
fn table<'a>(document: &'a str, heading: &str) -> Vec<Vec<&'a str>> {
    let section = document.split("\n## ").find(|section| section.starts_with(heading)).unwrap();
    let rows = section.lines().filter(|line| line.starts_with('|')).skip(2);
    rows.map(|row| row.trim_matches('|').split('|').map(str::trim).collect()).collect()
}

/// Value of a product such as "96 B P", or of a bound such as "≥ 4 J + 4".
fn evaluate(formula: &str, predictor: Predictor, counts: &EnvelopeCounts) -> u64 {
    let factor = |word: &str| match word {
        "V" => u64::from(counts.vertex_len),
        "J" => u64::from(counts.joint_len),
        "P" => u64::from(counts.proxy_len),
        "K" => u64::from(counts.influence_len),
        "G" => u64::from(counts.group_len),
        "B" => u64::from(counts.proxy_len.div_ceil(2)),
        "L" => counts.palette_len(predictor) as u64,
        number => number.parse().unwrap(),
    };
    let terms = formula.trim_start_matches('≥').split('+');
    terms.map(|term| term.split_whitespace().map(factor).product::<u64>()).sum()
}

const FORMAT: &str = include_str!("../FORMAT.md");

#[test]
fn the_document_lists_the_sections_of_the_code() {
    let rows = table(FORMAT, "Sections of an envelope");
    assert_eq!(rows.len(), SectionKind::ALL.len());
    for (row, kind) in rows.iter().zip(SectionKind::ALL) {
        assert_eq!(row[0], kind.number().to_string());
        assert_eq!(row[1], kind.name());
        for predictor in Predictor::ALL {
            let listed = |list: &str| list.split(", ").any(|word| word == predictor.name());
            let presence = match row[3] {
                "yes" => Presence::Required,
                "no" => Presence::Optional,
                list if listed(list) => Presence::Required,
                _ => Presence::Absent,
            };
            assert_eq!(presence, kind.presence(predictor), "{}", row[1]);
            for [v, j, p, k, g] in [[7, 4, 3, 2, 2], [1, 1, 1, 1, 1], [900, 33, 40, 4, 11]] {
                let counts = EnvelopeCounts {
                    vertex_len: v,
                    joint_len: j,
                    proxy_len: p,
                    influence_len: k,
                    root: 0,
                    group_len: g,
                    scratch_len: 0,
                };
                let bytes = evaluate(row[2], predictor, &counts);
                assert_eq!(Some(bytes), kind.bytes(predictor, &counts), "{}", row[1]);
            }
        }
    }
}

#[test]
fn the_document_lays_rows_out_as_the_code() {
    // Every byte of a row is its own offset, so that a field's value tells where it was read.
    fn number(field: &[u8]) -> u64 {
        field.iter().rev().fold(0, |sum, &byte| sum << 8 | u64::from(byte))
    }
    let field = |heading: &str, name: &str| {
        let rows = table(FORMAT, heading);
        let row = rows.iter().find(|row| row[2] == name).unwrap().clone();
        (row[0].parse::<usize>().unwrap(), row[1].parse::<usize>().unwrap())
    };
    let bytes: [u8; PartRow::BYTES] = std::array::from_fn(|i| i as u8);
    let row = PartRow::from_bytes(&bytes);
    assert_eq!(row.to_bytes(), bytes);
    let at = |heading, name| {
        let (offset, len) = field(heading, name);
        number(&bytes[offset..offset + len.min(4)])
    };
    assert_eq!(at("Part row", "kind"), u64::from(row.kind));
    assert_eq!(at("Part row", "predictor"), u64::from(row.predictor));
    assert_eq!(at("Part row", "flags"), u64::from(row.flags));
    assert_eq!(at("Part row", "counts"), u64::from(row.counts[0]));
    assert_eq!(at("Part row", "figures"), u64::from(row.figures[0].to_bits()));
    let row = SectionRow::from_bytes(bytes.first_chunk().unwrap());
    assert_eq!(row.to_bytes(), bytes[..SectionRow::BYTES]);
    assert_eq!(at("Section row", "kind"), u64::from(row.kind));
    assert_eq!(at("Section row", "part"), u64::from(row.part));
    assert_eq!(at("Section row", "flags"), u64::from(row.flags));
    assert_eq!(at("Section row", "offset"), u64::from(row.offset));
    assert_eq!(at("Section row", "bytes"), u64::from(row.bytes));
    // A group's numbers one by one: its bytes are read by sizes of their own.
    let row = GroupRow::from_bytes(bytes.first_chunk().unwrap());
    assert_eq!(row.to_bytes(), bytes[..GroupRow::BYTES]);
    for (name, value) in [
        ("joint", row.joint.into()),
        ("kernel", row.kernel.into()),
        ("reserved", row.reserved.into()),
        ("input_len", row.input_len.into()),
        ("centre_len", row.centre_len.into()),
        ("rank", row.rank.into()),
        ("proxy_len", row.proxy_len.into()),
        ("offset", row.offset),
        ("fade_start", row.fade_start.to_bits()),
        ("fade_end", row.fade_end.to_bits()),
    ] {
        assert_eq!(at("Group row", name), u64::from(value), "{name}");
    }
    for (heading, len) in [
        ("Part row", PartRow::BYTES),
        ("Section row", SectionRow::BYTES),
        ("Group row", GroupRow::BYTES),
    ] {
        let rows = table(FORMAT, heading);
        let sum = rows.iter().map(|row| row[1].parse::<usize>().unwrap()).sum::<usize>();
        assert_eq!(sum, len);
    }
    assert_eq!(field("Message", "magic"), (0, MAGIC.len()));
    assert_eq!(field("Message", "checksum"), (CHECKSUM_OFFSET, 4));
    let file = Builder { features: 0x0403_0201, ..Builder::sample(SMALL) }.bytes();
    let (features, len) = field("Message", "features");
    assert_eq!(file[features..features + len], [1, 2, 3, 4]);
    assert_eq!(file[field("Message", "version").0], VERSION);
    assert_eq!(file[field("Message", "alignment_log2").0], 4);
    let kinds = table(FORMAT, "Part row")[0][3];
    for kind in PartKind::ALL {
        assert!(kinds.contains(&format!("{} {}", kind.number(), kind.name())));
        assert_eq!(PartKind::from_number(kind.number()), Some(kind));
    }
    let predictors = table(FORMAT, "Part row")[1][3];
    for predictor in Predictor::ALL {
        assert!(predictors.contains(&format!("{} {}", predictor.number(), predictor.name())));
        assert_eq!(Predictor::from_number(predictor.number()), Some(predictor));
    }
    let kernels = table(FORMAT, "Kernels");
    assert_eq!(kernels.len(), Kernel::ALL.len());
    for (row, kernel) in kernels.iter().zip(Kernel::ALL) {
        assert_eq!(row[..2], [kernel.number().to_string().as_str(), kernel.name()]);
    }
}

#[test]
#[should_panic(expected = "assertion")]
fn the_document_check_can_fail() {
    let counts = Builder::sample(SMALL).parts[0].envelope_counts();
    let predictor = Predictor::Rotational;
    let bytes = evaluate("220 V", predictor, &counts);
    assert_eq!(Some(bytes), SectionKind::Keys.bytes(predictor, &counts));
}
