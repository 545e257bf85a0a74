//! Counts every number that sets a fit, so that a new number must be worth its cost.

use sinew_trainer::settings::Settings;
use std::fs;
use std::path::{Path, PathBuf};

/// Sources of the fit.
const FIT: [&str; 3] = ["src/envelope", "src/regression", "src/settings.rs"];
/// Folders and files inside [`FIT`] that set no fit.
const OTHERS: [&str; 6] = [
    "envelope/bake",
    "envelope/choose/report.rs",
    "envelope/model",
    "envelope/oracle",
    "regression/arithmetic.rs",
    "regression/rotations.rs",
];
/// Limit besides the fields of [`Settings`]; raise it only for a gain of 3 % on two sets.
const MOST: usize = 110;

fn sources(path: PathBuf, found: &mut Vec<PathBuf>) {
    if OTHERS.iter().any(|other| path.ends_with(other)) {
        return;
    }
    if path.is_dir() {
        let mut entries: Vec<_> =
            fs::read_dir(path).unwrap().map(|entry| entry.unwrap().path()).collect();
        entries.sort();
        entries.into_iter().for_each(|entry| sources(entry, found));
    } else {
        found.push(path);
    }
}

/// Returns the numeric constants of a source above its tests: name and value.
fn constants(source: &str) -> Vec<(String, String)> {
    let source = source.split("#[cfg(test)]").next().unwrap();
    let after = |part: &str| -> Option<(String, String)> {
        let (name, rest) = part.split_once(": ")?;
        let is_name =
            name.chars().all(|c| c.is_ascii_uppercase() || c.is_ascii_digit() || c == '_');
        let (kind, value) = rest.split_once(" =")?;
        let is_number = ["f64", "usize", "i32", "u32", "Alternation", "Anchors"]
            .iter()
            .any(|number| kind == *number || kind.starts_with(&format!("[{number};")));
        let value = value.split_once(';')?.0.split_whitespace().collect::<Vec<_>>().join(" ");
        (is_name && is_number).then(|| (name.to_owned(), value))
    };
    source.split("const ").skip(1).filter_map(after).collect()
}

#[test]
fn no_number_is_added_without_notice() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut paths = Vec::new();
    FIT.iter().for_each(|path| sources(root.join(path), &mut paths));
    let mut count = 0;
    for path in paths {
        for (name, value) in constants(&fs::read_to_string(&path).unwrap()) {
            println!("{}: {name} = {value}", path.strip_prefix(root).unwrap().display());
            count += 1;
        }
    }
    for (name, value) in Settings::default().numbers() {
        println!("Settings: {name} = {value:e}");
    }
    println!("{count} constants, {} settings", Settings::default().numbers().len());
    assert!(
        count <= MOST,
        "{count} constants, at most {MOST}: does the new one earn 3 % on two sets?"
    );
    assert!(count + 3 > MOST, "{count} constants: lower MOST");
}

#[test]
fn constants_are_found_in_every_form() {
    let source = "pub(super) const A: f64 = 1e-3;\n    const B_2: [usize; 2] = [1,\n 2];\nconst C: &str = \"x\";\n\
                  const D: Alternation = Alternation { choices: 3 };\n#[cfg(test)]\nconst E: f64 = 1.0;\n";
    let found = constants(source);
    let expected = [("A", "1e-3"), ("B_2", "[1, 2]"), ("D", "Alternation { choices: 3 }")];
    assert_eq!(found, expected.map(|(name, value)| (name.to_owned(), value.to_owned())));
}
