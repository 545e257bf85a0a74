//! Programs that the tests need.

use super::call::{run, target_folder};
use std::process::Command;

/// Blender as a Python module.
const BPY: &str = "bpy==5.0.1";
/// USD as a Python module.
const USD: &str = "usd-core==26.11";

/// Finds the programs that the tests need, or says how to install them.
pub(super) fn programs() -> Result<(), String> {
    for program in ["node", "npm"] {
        // The tests of exported files fetch the glTF validator with npm and run it with Node.js.
        Command::new(program).arg("--version").output().map_err(|_| {
            format!("{program} was not found: install Node.js 18 or newer with npm, see nodejs.org")
        })?;
    }
    Ok(())
}

/// Reports a test that this machine cannot run; an error if `CI` is set.
pub(super) fn untested_unless_ci(what: String) -> Result<(), String> {
    if std::env::var_os("CI").is_some() {
        return Err(format!("CI is set, but {what}"));
    }
    eprintln!("xtask: {what}");
    Ok(())
}

/// Installs compiler targets.
pub(super) fn targets(targets: &[&str]) -> Result<(), String> {
    let missing = "rustup, with which the bare targets are installed, was not found: see rustup.rs";
    let listed = Command::new("rustup")
        .args(["target", "list", "--installed"])
        .output()
        .map_err(|_| missing.to_owned())?;
    let installed = String::from_utf8_lossy(&listed.stdout).into_owned();
    for target in targets {
        if !installed.lines().any(|line| line.trim() == *target) {
            let advice = format!("run `rustup target add {target}`");
            run(Command::new("rustup").args(["target", "add", target]))
                .map_err(|error| format!("{error}; {advice}"))?;
        }
    }
    Ok(())
}

/// Returns the Python for the test of the Blender script, with Blender as a module; see [`python`].
pub(super) fn blender() -> Result<String, String> {
    python("bpy", BPY, "the Blender script")
}

/// Returns the Python for the test of exported USD, with Pixar's library as a module; see [`python`].
pub(super) fn usd() -> Result<String, String> {
    python("pxr", USD, "the export to USD")
}

/// Returns a Python with a module of a package. If this machine has no such package, prints a notice
/// and returns an empty string, or an error if `CI` is set.
fn python(module: &str, package: &str, tested: &str) -> Result<String, String> {
    let folder = target_folder()?.join(module);
    let python = folder.join("bin/python").display().to_string();
    let has_module = || {
        let found = Command::new(&python).args(["-c", &format!("import {module}")]).output();
        found.is_ok_and(|found| found.status.success())
    };
    if !has_module() {
        let advice = "install Python 3 with its venv module (Debian: python3-venv)";
        run(Command::new("python3").args(["-m", "venv", "--clear"]).arg(&folder))
            .map_err(|error| format!("{error}; {advice}"))?;
        let installed = run(Command::new(&python).args(["-m", "pip", "install", "-q", package]));
        if installed.is_err() || !has_module() {
            let untested = format!("{package} does not install here: {tested} is not tested");
            return untested_unless_ci(untested).map(|()| String::new());
        }
    }
    Ok(python)
}
