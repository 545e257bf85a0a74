//! The inputs of `../shared/cases`: each gives the value that the folder's README states.

mod also;
mod face;
mod frames;
mod glb;
mod gltf;
mod kernel;
mod normals;
mod signal;
mod views;
mod words;

use crate::common::Folder;
use crate::shared::shared;

/// Makes a folder that holds copies of the cases `files`; `None` without shared data.
fn with_cases(test: &str, files: &[&str]) -> Option<Folder> {
    let folder = Folder::new(test);
    for file in files {
        let from = shared(&format!("../cases/{file}"))?;
        std::fs::copy(&from, folder.path(file.rsplit('/').next()?)).unwrap();
    }
    Some(folder)
}

/// Cases of later issues, and the picture of one of them.
const LATER: [&str; 4] = ["squash_leaf", "views-hidden-hole", "sq.png", "rigs"];

/// Cases that a test of the same kind covers with problems of its own.
const COVERED: [(&str, &str); 1] =
    [("kernel-fade-rate", "at_every_sample_the_confidence_is_one_and_the_output_the_samples")];

#[test]
fn every_case_has_a_test() {
    let Some(cases) = shared("../cases") else { return };
    let tests = [
        include_str!("also.rs"),
        include_str!("face.rs"),
        include_str!("frames.rs"),
        include_str!("gltf.rs"),
        include_str!("kernel.rs"),
        include_str!("normals.rs"),
        include_str!("signal.rs"),
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
            let is_later = LATER.iter().any(|later| path.to_string_lossy().contains(later));
            assert!(is_tested || is_later, "{} has no test", path.display());
        }
    }
}
