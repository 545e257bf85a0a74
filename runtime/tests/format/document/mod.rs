//! Checks FORMAT.md against the code, from its tables.

mod bytes;
mod numbers;
mod rows;
mod sections;

const FORMAT: &str = include_str!("../../../FORMAT.md");

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

/// Decodes a little-endian number.
fn number(field: &[u8]) -> u64 {
    field.iter().rev().fold(0, |sum, &byte| sum << 8 | u64::from(byte))
}

/// Checks that a table's rows follow each other without a gap; returns their total length.
fn length(heading: &str) -> usize {
    table(FORMAT, heading).iter().fold(0, |end, row| {
        assert_eq!(row[0].parse::<usize>().unwrap(), end, "{heading}: {}", row[2]);
        end + row[1].parse::<usize>().unwrap()
    })
}

/// Offset and length of a field.
fn field(heading: &str, name: &str) -> (usize, usize) {
    let rows = table(FORMAT, heading);
    let row = rows.iter().find(|row| row[2] == name).unwrap();
    (row[0].parse().unwrap(), row[1].parse().unwrap())
}

/// Checks that the fields of a table, and no others, have these values in some bytes.
fn assert_fields(heading: &str, bytes: &[u8], fields: &[(&str, u64)]) {
    assert_eq!(table(FORMAT, heading).len(), fields.len(), "{heading}");
    for (name, value) in fields {
        let (offset, len) = field(heading, name);
        assert_eq!(number(&bytes[offset..offset + len]), *value, "{heading}: {name}");
    }
    assert_eq!(length(heading), bytes.len(), "{heading}");
}
