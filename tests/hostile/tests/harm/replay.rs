//! What the fuzzers once found, and the corpus that they start from, on stable Rust.

use hostile::targets::{self, Body};
use std::path::PathBuf;

/// Lists a folder of `tests/fuzz`, sorted.
fn entries(folder: &str) -> Vec<PathBuf> {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../fuzz").join(folder);
    let entries = std::fs::read_dir(folder).unwrap();
    let mut paths: Vec<_> = entries.map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    paths
}

fn stems(folder: &str) -> Vec<String> {
    let stem = |path: PathBuf| path.file_stem().unwrap().to_str().unwrap().to_owned();
    entries(folder).into_iter().map(stem).collect()
}

/// Runs a target's body over files; returns how many there are and how many were accepted.
fn replay(folder: &str, body: Body) -> [usize; 2] {
    let paths = entries(folder);
    let harmless = |path: &PathBuf| {
        println!("{}", path.display());
        body(&std::fs::read(path).unwrap())
    };
    [paths.len(), paths.iter().filter(|path| harmless(path)).count()]
}

#[test]
fn the_corpus_is_harmless() {
    for (target, body) in targets::ALL {
        let [found, accepted] = replay(&format!("corpus/{target}"), body);
        assert!(found >= 3 && accepted > 0, "{target}: {accepted} of {found} accepted");
    }
}

#[test]
fn what_was_once_found_is_harmless() {
    for target in stems("regressions") {
        let (_, body) = targets::ALL.into_iter().find(|(name, _)| *name == target).unwrap();
        let [found, _] = replay(&format!("regressions/{target}"), body);
        assert!(found > 0, "{target}");
    }
}

#[test]
fn every_target_of_the_fuzzer_is_replayed() {
    let mut replayed = targets::ALL.map(|(target, _)| target);
    replayed.sort_unstable();
    assert_eq!(stems("fuzz_targets"), replayed);
}
