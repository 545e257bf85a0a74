//! Installs what firmware needs, or says what to run.

use super::targets::TARGETS;
use std::process::Command;

/// Programs, and the Debian packages that they come in.
const PROGRAMS: [(&str, &str); 3] = [
    ("qemu-system-arm", "qemu-system-arm"),
    ("qemu-system-riscv32", "qemu-system-misc"),
    ("node", "nodejs"),
];

/// Prepares compilers and emulators.
pub(super) fn components() -> Result<(), String> {
    let listed = Command::new("rustup").args(["target", "list", "--installed"]).output();
    let listed = listed.map_err(|error| format!("rustup: {error}; see rustup.rs"))?;
    let installed = String::from_utf8_lossy(&listed.stdout).into_owned();
    for triple in TARGETS.iter().map(|target| target.triple).filter(|triple| !triple.is_empty()) {
        if !installed.lines().any(|line| line.trim() == triple) {
            crate::run(Command::new("rustup").args(["target", "add", triple]))
                .map_err(|error| format!("{error}; run `rustup target add {triple}`"))?;
        }
    }
    for (program, package) in PROGRAMS {
        if !starts(program) {
            let advice =
                format!("{program} was not found: run `apt-get install {package}` as root");
            // Without the right to install this fails at once, and says what to run.
            let install = ["install", "--yes", "--no-install-recommends", package];
            crate::run(
                Command::new("apt-get").env("DEBIAN_FRONTEND", "noninteractive").args(install),
            )
            .map_err(|error| format!("{error}; {advice}"))?;
            if !starts(program) {
                return Err(advice);
            }
        }
    }
    Ok(())
}

fn starts(program: &str) -> bool {
    Command::new(program).arg("--version").output().is_ok_and(|output| output.status.success())
}
