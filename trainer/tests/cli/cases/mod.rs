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
