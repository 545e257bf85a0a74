//! Builds other programs, in separate folders.

use crate::repository;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Makes an empty folder `name` in `place`.
///
/// # Panics
/// If the disk refuses it.
pub fn emptied(place: &Path, name: &str) -> PathBuf {
    let folder = place.join(name);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).expect("a folder of the build can be made");
    folder
}

/// Writes a file and makes its parent folders.
///
/// # Panics
/// If the disk refuses it.
pub fn write(path: &Path, content: &str) {
    std::fs::create_dir_all(path.parent().unwrap_or(path)).expect("a folder can be made");
    std::fs::write(path, content).expect("a file can be written");
}

/// Copies files of the repository into a folder, under their names.
///
/// # Panics
/// If a file is missing.
pub fn copy(paths: &[&str], to: &Path) {
    for path in paths {
        let from = repository().join(path);
        if from.is_dir() {
            let entries = std::fs::read_dir(&from).expect("a folder can be listed");
            for entry in entries.flatten() {
                let inner = format!("{path}/{}", entry.file_name().to_string_lossy());
                copy(&[&inner], to);
            }
        } else {
            let to = to.join(path);
            std::fs::create_dir_all(to.parent().unwrap_or(&to)).expect("a folder can be made");
            std::fs::copy(&from, &to).unwrap_or_else(|error| panic!("{path}: {error}"));
        }
    }
}

/// Runs a command to its end and returns its output.
///
/// # Panics
/// If the command does not start, or fails.
pub fn output(command: &mut Command) -> String {
    let done = command.output().unwrap_or_else(|error| panic!("{command:?}: {error}"));
    let (out, err) = (String::from_utf8_lossy(&done.stdout), String::from_utf8_lossy(&done.stderr));
    assert!(done.status.success(), "{command:?}: {}\n{out}\n{err}", done.status);
    out.into_owned()
}

/// Calls cargo in a folder, with the crate versions of this build and without a network.
///
/// The target folder is kept between runs, so that dependencies are built once.
///
/// # Panics
/// As [`output`] does.
pub fn cargo(folder: &Path, target: &Path, arguments: &[&str]) -> String {
    copy(&["Cargo.lock"], folder);
    let mut cargo = Command::new(env!("CARGO"));
    cargo.current_dir(folder).arg("--offline").args(arguments);
    cargo.env("CARGO_TARGET_DIR", target);
    output(&mut cargo)
}
