//! Programs that the tests need.

use super::call::{TARGETS, run, target_folder};
use std::process::Command;

/// Blender as a Python module.
const BPY: &str = "bpy==5.0.1";

/// Installs the targets and finds the programs that the tests need, or says what to install.
pub(super) fn programs() -> Result<(), String> {
    for program in ["node", "npm"] {
        // The tests of exported files fetch the glTF validator with the one and run it with the other.
        Command::new(program).arg("--version").output().map_err(|_| {
            format!("{program} was not found: install Node.js 18 or newer with npm, see nodejs.org")
        })?;
    }
    targets(&TARGETS)
}

/// Says what is left untested on this machine; where `CI` is set that is an error.
pub(super) fn untested_unless_ci(what: String) -> Result<(), String> {
    if std::env::var_os("CI").is_some() {
        return Err(format!("CI is set, but {what}"));
    }
    eprintln!("xtask: {what}");
    Ok(())
}

/// Installs targets of the compiler.
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

/// Gives the Python that the test of the Blender script runs in, with Blender as a module; the empty
/// text, said aloud, where there is no such package for this machine, unless `CI` is set.
pub(super) fn blender() -> Result<String, String> {
    let folder = target_folder()?.join("bpy");
    let python = folder.join("bin/python").display().to_string();
    let has_bpy = || {
        let found = Command::new(&python).args(["-c", "import bpy"]).output();
        found.is_ok_and(|found| found.status.success())
    };
    if !has_bpy() {
        let advice = "install Python 3 with its venv module (Debian: python3-venv)";
        run(Command::new("python3").args(["-m", "venv", "--clear"]).arg(&folder))
            .map_err(|error| format!("{error}; {advice}"))?;
        let installed = run(Command::new(&python).args(["-m", "pip", "install", "-q", BPY]));
        if installed.is_err() || !has_bpy() {
            let untested = format!("{BPY} does not install here: the Blender script is not tested");
            return untested_unless_ci(untested).map(|()| String::new());
        }
    }
    Ok(python)
}
