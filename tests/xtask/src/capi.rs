//! Compilers and the emulator that the tests of the C ABI run, and its header.

use super::{cargo, run};
use std::path::Path;
use std::process::Command;

/// What is needed, the Debian package that brings it, and how to see that it is there.
struct Component {
    what: &'static str,
    package: &'static str,
    found: fn() -> bool,
}

const COMPONENTS: [Component; 5] = [
    Component { what: "gcc", package: "gcc", found: || starts("gcc") },
    Component { what: "g++", package: "g++", found: || starts("g++") },
    Component {
        what: "arm-none-eabi-gcc",
        package: "gcc-arm-none-eabi",
        found: || starts("arm-none-eabi-gcc"),
    },
    Component {
        what: "newlib for ARM",
        package: "libnewlib-arm-none-eabi",
        found: || {
            // The compiler answers with a path where it finds the file, else with the bare name.
            let mut gcc = Command::new("arm-none-eabi-gcc");
            let answer = gcc.arg("-print-file-name=rdimon.specs").output();
            answer.is_ok_and(|out| Path::new(&*String::from_utf8_lossy(&out.stdout)).is_absolute())
        },
    },
    Component {
        what: "qemu-system-arm",
        package: "qemu-system-arm",
        found: || starts("qemu-system-arm"),
    },
];

/// Installs what is missing with apt-get, or says what to run.
pub(super) fn prepare() -> Result<(), String> {
    let missing = || COMPONENTS.iter().filter(|component| !(component.found)());
    let packages: Vec<_> = missing().map(|component| component.package).collect();
    if packages.is_empty() {
        return Ok(());
    }
    let packages = packages.join(" ");
    let advice = format!("run `apt-get install {packages}` as root, or your system's equivalent");
    let apt_get = |arguments: &str| {
        let mut command = Command::new("apt-get");
        run(command.env("DEBIAN_FRONTEND", "noninteractive").args(arguments.split_whitespace()))
    };
    let install = format!("install -y --no-install-recommends {packages}");
    // The list of packages may be there already, and then there may be no network.
    apt_get(&install)
        .or_else(|_| apt_get("update").and_then(|()| apt_get(&install)))
        .map_err(|error| format!("{error}; {advice}"))?;
    missing()
        .next()
        .map_or(Ok(()), |component| Err(format!("{} is still not found; {advice}", component.what)))
}

/// Writes the C header that the sources give.
pub(super) fn header() -> Result<(), String> {
    cargo("test --locked -p sinew-capi --test header", &[("SINEW_WRITE_HEADER", "1")])
}

fn starts(program: &str) -> bool {
    Command::new(program).arg("--version").output().is_ok_and(|output| output.status.success())
}
