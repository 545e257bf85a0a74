//! The committed header matches the output of cbindgen. Header and README list every status.

use sinew_capi::sinew_status_text;
use std::ffi::{CStr, c_char};
use std::{env, fs, path::Path};

/// Environment variable that makes the test write the header; `cargo xtask header` sets it.
const WRITE: &str = "SINEW_WRITE_HEADER";

#[test]
fn the_header_is_up_to_date() {
    let package = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../runtime/capi"));
    let config = cbindgen::Config::from_file(package.join("cbindgen.toml")).unwrap();
    let mut made = Vec::new();
    let builder = cbindgen::Builder::new().with_crate(package).with_config(config);
    builder.generate().unwrap().write(&mut made);
    let made = String::from_utf8(made).unwrap();
    let header = package.join("include/sinew.h");
    if env::var_os(WRITE).is_some() {
        fs::write(&header, &made).unwrap();
    }
    let committed = fs::read_to_string(&header).unwrap();
    let differs = committed.lines().zip(made.lines()).find(|(committed, made)| committed != made);
    assert!(committed == made, "include/sinew.h: {differs:?}; run `cargo xtask header`");
}

#[test]
fn every_status_has_a_text_and_no_other_number_has() {
    let statuses = listed("SINEW_STATUS_");
    // `calls/errors.rs` lists the runtime's kinds: 13 for calls and 21 for files.
    let within = |range: std::ops::Range<i64>| {
        statuses.iter().filter(|(_, number)| range.contains(number)).count()
    };
    assert_eq!([within(1..50), within(100..1000), statuses.len()], [13, 21, 43]);
    for number in -2..1000 {
        let is_status = statuses.iter().any(|(_, listed)| *listed == number);
        let found = text(sinew_status_text(number as i32));
        assert_eq!(found != "unknown status", is_status, "{number}: {found}");
    }
}

/// Functions that a reader of the header takes in.
const FUNCTIONS: usize = 60;

#[test]
fn the_header_stays_small() {
    let header = concat!(env!("CARGO_MANIFEST_DIR"), "/../../runtime/capi/include/sinew.h");
    let header = fs::read_to_string(header).unwrap();
    let code = header.lines().filter(|line| line.starts_with(|c: char| c.is_ascii_lowercase()));
    let functions = code.filter(|line| line.contains(" sinew_") || line.contains(" *sinew_"));
    let functions = functions.filter(|line| line.contains('(') && !line.starts_with("typedef"));
    let found = functions.count();
    assert!((40..=FUNCTIONS).contains(&found), "{found} functions");
}

#[test]
fn the_readme_has_every_status() {
    let readme =
        fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../../runtime/capi/README.md"))
            .unwrap();
    let rows = readme.lines().filter(|line| line.starts_with("| `SINEW_STATUS_"));
    let expected = listed("SINEW_STATUS_").into_iter().map(|(name, number)| {
        format!("| `{name}` | {number} | {} |", text(sinew_status_text(number as i32)))
    });
    assert_eq!(rows.collect::<Vec<_>>(), expected.collect::<Vec<_>>());
}

fn text(text: *const c_char) -> &'static str {
    // SAFETY: the library's texts end in a zero and stay valid.
    unsafe { CStr::from_ptr(text) }.to_str().unwrap()
}

/// Lists the names and numbers of an enumeration of the header.
fn listed(prefix: &str) -> Vec<(String, i64)> {
    let header = concat!(env!("CARGO_MANIFEST_DIR"), "/../../runtime/capi/include/sinew.h");
    let header = fs::read_to_string(header).unwrap();
    let entries =
        header.lines().filter_map(|line| line.trim().strip_suffix(',')?.split_once(" = "));
    let of_prefix = entries.filter(|(name, _)| name.starts_with(prefix));
    of_prefix.map(|(name, number)| (name.to_owned(), number.parse().unwrap())).collect()
}
