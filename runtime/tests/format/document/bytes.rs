use super::FORMAT;
use models::golden_path;

/// Offset and bytes of a line of the dump: two digits a byte, then two spaces and the meaning.
fn parse(line: &str) -> (usize, Vec<u8>) {
    let (offset, rest) = line.split_once("  ").unwrap();
    let bytes = rest.split("  ").next().unwrap();
    let byte = |digits| u8::from_str_radix(digits, 16).unwrap();
    (usize::from_str_radix(offset, 16).unwrap(), bytes.split(' ').map(byte).collect())
}

#[test]
fn the_dump_shows_the_whole_file() {
    let (_, section) = FORMAT.split_once("\n## A file byte by byte\n").unwrap();
    let (introduction, dump) = section.split_once("```text\n").unwrap();
    let name = introduction.split("tests/golden/").nth(1).unwrap().split('`').next().unwrap();
    let file = std::fs::read(golden_path(name)).unwrap();
    let mut end = 0;
    for line in dump.split("```").next().unwrap().lines() {
        // Only weights are left out.
        if let Some(left_out) = line.strip_prefix("...  ") {
            end += left_out.strip_suffix(" bytes of weights").unwrap().parse::<usize>().unwrap();
            continue;
        }
        let (offset, bytes) = parse(line);
        assert_eq!(offset, end, "{line}");
        end += bytes.len();
        assert_eq!(file[offset..end], bytes, "{line}");
    }
    assert_eq!(end, file.len());
}
