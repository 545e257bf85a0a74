//! Compilers and the emulator for the tests of the C ABI, and its header.

use super::call::{cargo_with, run, target_folder};
use super::components::{self, Component, starts};
use std::path::Path;
use std::process::Command;

const COMPONENTS: [Component; 8] = [
    Component { what: "gcc", package: "gcc", found: || starts("gcc") },
    Component { what: "g++", package: "g++", found: || starts("g++") },
    Component { what: "clang", package: "clang", found: || starts("clang") },
    Component { what: "clang-format", package: "clang-format", found: || starts("clang-format") },
    Component { what: "CMake", package: "cmake", found: || starts("cmake") },
    Component {
        what: "arm-none-eabi-gcc",
        package: "gcc-arm-none-eabi",
        found: || starts("arm-none-eabi-gcc"),
    },
    Component {
        what: "newlib for ARM",
        package: "libnewlib-arm-none-eabi",
        found: || {
            // The compiler prints a path if it finds the file, else only the name.
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

/// Installs missing programs, or says how to install them.
pub(super) fn prepare() -> Result<(), String> {
    components::install(&COMPONENTS)
}

/// Writes the C header generated from the sources.
pub(super) fn header() -> Result<(), String> {
    run(native_cargo("test --locked")?.arg("the_header_is").env("SINEW_WRITE_HEADER", "1"))
}

/// Formats, lints and runs the C ABI's tests from outside Rust.
pub(super) fn native() -> Result<(), String> {
    run(&mut native_cargo("fmt --check")?)?;
    run(native_cargo("clippy --locked --all-targets")?.args(["--", "-D", "warnings"]))?;
    run(&mut native_cargo("test --locked")?)
}

/// Makes a call of cargo on `tests/native`, in its own target folder.
fn native_cargo(arguments: &str) -> Result<Command, String> {
    let mut command = cargo_with(arguments, &[]);
    command.args(["--manifest-path", "tests/native/Cargo.toml"]);
    if !arguments.starts_with("fmt") {
        command.env("CARGO_TARGET_DIR", target_folder()?.join("nested/native"));
    }
    Ok(command)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn installed_programs_are_found() {
        assert!(starts("rustc"));
        assert!(!starts("no-such-program"));
    }
}
