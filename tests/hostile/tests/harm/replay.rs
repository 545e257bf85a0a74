//! Replays findings of the fuzzers and their corpus, and bakes random descriptions, on stable Rust.

use hostile::round_trip::round_trip;
use hostile::targets::{self, Body};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::path::PathBuf;

fn folder(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("..").join(name)
}

/// Lists a folder of `tests`, sorted.
fn entries(name: &str) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder(name)).unwrap();
    let mut paths: Vec<_> = entries.map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    paths
}

fn stems(folder: &str) -> Vec<String> {
    let stem = |path: PathBuf| path.file_stem().unwrap().to_str().unwrap().to_owned();
    entries(folder).into_iter().map(stem).collect()
}

/// Runs a target's body over files; returns the numbers of files and of accepted files.
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
        let corpus = format!("fuzz/corpus/{target}");
        // A target that reads model files begins with the golden ones.
        let corpus = if folder(&corpus).is_dir() { corpus.as_str() } else { "golden" };
        let [found, accepted] = replay(corpus, body);
        assert!(found >= 3 && accepted > 0, "{target}: {accepted} of {found} accepted");
    }
}

#[test]
fn past_findings_are_harmless() {
    for target in stems("fuzz/regressions") {
        let (_, body) = targets::ALL.into_iter().find(|(name, _)| *name == target).unwrap();
        let [found, _] = replay(&format!("fuzz/regressions/{target}"), body);
        assert!(found > 0, "{target}");
    }
}

#[test]
fn every_target_of_the_fuzzer_is_replayed() {
    let mut replayed = targets::ALL.map(|(target, _)| target);
    replayed.sort_unstable();
    assert_eq!(stems("fuzz/fuzz_targets"), replayed);
}

#[test]
fn descriptions_survive_the_round_trip() {
    let mut random = ChaCha8Rng::seed_from_u64(6);
    let baked = |random: &mut ChaCha8Rng| {
        let mut data = vec![0; random.random_range(0..8192)];
        random.fill_bytes(&mut data);
        round_trip(&data)
    };
    let refused: Vec<_> = (0..500).filter_map(|_| baked(&mut random).err()).collect();
    assert!(refused.is_empty(), "{} of 500 refused, first {}", refused.len(), refused[0]);
}
