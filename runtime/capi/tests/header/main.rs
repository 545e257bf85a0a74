//! The committed header is what cbindgen makes of the sources; it and the README list every status.
#![allow(clippy::unwrap_used, reason = "a test's helpers fail as the test does")]

mod statuses;

use std::{env, fs, path::Path};

/// Set to write the header instead of comparing it; `cargo xtask header` does.
const WRITE: &str = "SINEW_WRITE_HEADER";

#[test]
fn the_header_is_that_of_the_sources() {
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
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
