//! The inputs of `../shared/cases`: each must give the value in the folder's README.

mod also;
mod curves;
mod face;
mod fits;
mod glb;
mod gltf;
mod kernel;
mod playing;
mod takes;
mod views;
mod words;

use crate::cli::common::{Folder, Run};
use glb::Glb;
use models::shared;
use nalgebra::Vector3;
use serde_json::Value;

/// Makes a folder with copies of the cases `files`; `None` without shared data.
pub(crate) fn with_cases(test: &str, files: &[&str]) -> Option<Folder> {
    let folder = Folder::new(test);
    for file in files {
        let from = shared(&format!("../cases/{file}"))?;
        std::fs::copy(&from, folder.path(file.rsplit('/').next()?)).unwrap();
    }
    Some(folder)
}

/// Runs a command that must succeed; warnings are allowed.
#[track_caller]
fn run(folder: &Folder, command: &str) -> Run {
    let run = folder.sinew(command);
    assert_eq!(run.code, Some(0), "{command}: {}", run.err);
    run
}

/// Runs a command that must fail; returns its last line.
#[track_caller]
fn refused(folder: &Folder, command: &str) -> String {
    let run = folder.sinew(command);
    assert_eq!(run.code, Some(1), "{command}: {}", run.err);
    run.err.lines().last().unwrap().to_owned()
}

/// Trains a file and returns the error of linear blend skinning on it, in % of the diagonal.
#[track_caller]
fn lbs(folder: &Folder, file: &str) -> f64 {
    run(folder, &format!("-q train --predictor kernel {file} -o m.sinew"));
    let found = run(folder, &format!("-q eval m.sinew {file} --json")).out;
    let found: Value = serde_json::from_str(&found).unwrap();
    found["lbs"]["rms_percent"].as_f64().unwrap()
}

/// Returns the largest distance between two meshes, in % of the first mesh's diagonal.
fn apart(a: &[Vector3<f64>], b: &[Vector3<f64>]) -> f64 {
    assert_eq!(a.len(), b.len());
    let (low, high) = a.iter().fold((a[0], a[0]), |(low, high), x| (low.inf(x), high.sup(x)));
    let most = a.iter().zip(b).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
    100.0 * most / (high - low).norm()
}

/// Lists the keys of an animation, and 8 times between neighbouring keys.
fn moments(glb: &Glb, animation: usize) -> Vec<f64> {
    let mut keys = glb.times(animation, 0);
    let between = keys.windows(2).flat_map(|pair| {
        (1..9).map(|part| pair[0] + f64::from(part) / 9.0 * (pair[1] - pair[0])).collect::<Vec<_>>()
    });
    let mut all: Vec<f64> = between.collect();
    all.append(&mut keys);
    all
}

/// Returns the largest distance between two files that play together, in % of the diagonal.
fn off(source: (&Glb, &str, usize), played: (&Glb, &str, usize)) -> f64 {
    let at = |(glb, mesh, clip): (&Glb, &str, usize), time| glb.posed(mesh, Some((clip, time)));
    let times = moments(source.0, source.2);
    times.iter().map(|&t| apart(&at(source, t), &at(played, t))).fold(0.0, f64::max)
}

/// Trains a file and exports it with its clip, both plainly and into the file; returns the errors
/// of both exports.
#[track_caller]
fn off_as_exported(folder: &Folder, file: &str) -> [f64; 2] {
    run(folder, &format!("-q train --predictor kernel {file} -o m.sinew"));
    let source = Glb::read(folder, file);
    ["", &format!("--into {file}")].map(|into| {
        run(folder, &format!("-q export m.sinew --clip {file} {into} -o out.glb"));
        let played = Glb::read(folder, "out.glb");
        let clip = played.json["animations"].as_array().unwrap().len() - 1;
        off((&source, "tube", 0), (&played, "tube", clip))
    })
}

/// Folders whose cases are tested elsewhere: `rigs` in `tests/fit`.
const ELSEWHERE: [&str; 1] = ["rigs"];

/// Cases covered by another test of the same behaviour, with other inputs.
const COVERED: [(&str, &str); 1] =
    [("kernel-fade-rate", "at_every_sample_the_confidence_is_one_and_the_output_the_samples")];

#[test]
fn every_case_has_a_test() {
    let Some(cases) = shared("../cases") else { return };
    let tests = [
        include_str!("also.rs"),
        include_str!("face.rs"),
        include_str!("fits.rs"),
        include_str!("gltf.rs"),
        include_str!("kernel.rs"),
        include_str!("playing.rs"),
        include_str!("views.rs"),
        include_str!("words.rs"),
        include_str!("../kernel.rs"),
    ]
    .concat();
    let folders = std::fs::read_dir(cases).unwrap().map(|folder| folder.unwrap().path());
    for folder in folders.filter(|folder| folder.is_dir()) {
        for file in std::fs::read_dir(&folder).unwrap() {
            let path = file.unwrap().path();
            let case = path.file_stem().unwrap().to_string_lossy().into_owned();
            let test = COVERED.iter().find(|covered| covered.0 == case);
            let is_tested = tests.contains(test.map_or(case.as_str(), |covered| covered.1));
            let is_elsewhere =
                ELSEWHERE.iter().any(|folder| path.to_string_lossy().contains(folder));
            assert!(is_tested || is_elsewhere, "{} has no test", path.display());
        }
    }
}
