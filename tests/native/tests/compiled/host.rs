//! The examples and the tests of sinew.hpp, with this machine's C and C++ compilers.

use crate::compiled::{STRICT, libraries, output, package, printed, readme, scratch};
use models::{GOLDEN_NAMES, golden_path};
use std::path::{Path, PathBuf};
use std::process::Command;

const POSES: usize = 1024;
const C: &str = "-std=c11";
pub(crate) const CXX: &str = "-std=c++17";
pub(crate) const GCC: &str = "gcc and g++ (Debian: gcc, g++)";
/// Flags for sanitizers that end the program at the first error.
pub(crate) const SANITIZERS: [&str; 3] =
    ["-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"];

/// Compiles a source of this package with strict warnings, and links it with the flags in `more`.
pub(crate) fn compile(
    compiler: &str,
    standard: &str,
    source: &str,
    name: &str,
    more: &[&str],
) -> PathBuf {
    let program = scratch().join(name);
    let mut command = Command::new(compiler);
    command.arg(standard).args(STRICT).arg("-I").arg(package().join("include"));
    command.arg(package().join(source)).args(more);
    output(command.arg("-o").arg(&program), GCC);
    program
}

pub(crate) fn static_library() -> String {
    libraries().join("libsinew_capi.a").display().to_string()
}

/// Runs an example on every golden file and compares its whole output.
fn agrees(program: &Path) {
    for name in GOLDEN_NAMES {
        let poses = POSES.to_string();
        let found = output(Command::new(program).arg(golden_path(name)).arg(&poses), GCC);
        let expected = printed(&std::fs::read(golden_path(name)).unwrap(), POSES);
        assert_eq!(found, expected, "{} on {name}", program.display());
    }
}

#[test]
fn c_has_the_bits_of_rust() {
    let library = static_library();
    agrees(&compile("gcc", C, "examples/skin.c", "skin-gcc", &["-O2", &library]));
}

#[test]
fn cpp_has_the_bits_of_rust() {
    let library = static_library();
    let flags = ["-O2", "-fno-exceptions", "-fno-rtti", &library];
    agrees(&compile("g++", CXX, "examples/skin.cpp", "skin-g++", &flags));
}

#[test]
fn clang_has_the_bits_of_rust_if_installed() {
    let starts = |program| Command::new(program).arg("--version").output().is_ok();
    if !starts("clang") || !starts("clang++") {
        assert!(std::env::var_os("CI").is_none(), "clang was not found (Debian: clang)");
        eprintln!("clang was not found: only gcc is tested");
        return;
    }
    let library = static_library();
    agrees(&compile("clang", C, "examples/skin.c", "skin-clang", &["-O2", &library]));
    agrees(&compile("clang++", CXX, "examples/skin.cpp", "skin-clang++", &["-O2", &library]));
}

#[test]
fn the_shared_library_has_the_bits_of_rust() {
    let folder = libraries().display().to_string();
    let found_at = format!("-Wl,-rpath,{folder}");
    let flags = ["-L", &folder, "-Wl,-Bdynamic", "-l:libsinew_capi.so", &found_at];
    agrees(&compile("gcc", C, "examples/skin.c", "skin-shared", &flags));
}

#[test]
fn sanitizers_are_silent() {
    let library = static_library();
    let flags = [&SANITIZERS[..], &[&library]].concat();
    agrees(&compile("gcc", C, "examples/skin.c", "skin-sanitized", &flags));
    agrees(&compile("g++", CXX, "examples/skin.cpp", "skin-sanitized++", &flags));
}

#[test]
fn cpp_objects_own_move_reload_and_fail() {
    let library = static_library();
    let flags = [&SANITIZERS[..], &["-fno-exceptions", &library]].concat();
    let program = compile(
        "g++",
        CXX,
        concat!(env!("CARGO_MANIFEST_DIR"), "/tests/compiled/raii.cpp"),
        "raii",
        &flags,
    );
    let found = output(
        Command::new(program).args([golden_path(GOLDEN_NAMES[1]), golden_path(GOLDEN_NAMES[0])]),
        GCC,
    );
    assert_eq!(found, "0 failures\n");
}

#[test]
fn the_readme_compiles_and_runs() {
    let source = scratch().join("readme.c");
    std::fs::write(&source, readme("c", 0)).unwrap();
    let library = static_library();
    let program = compile("gcc", C, source.to_str().unwrap(), "readme", &["-O2", &library]);
    let found = output(Command::new(program).arg(golden_path(GOLDEN_NAMES[1])), GCC);
    assert!(found.starts_with("confidence 1.00"), "{found}");
}

#[test]
fn a_file_that_is_no_model_is_refused_in_words() {
    let library = static_library();
    let program = compile("gcc", C, "examples/skin.c", "skin-refuses", &[&library]);
    let done = Command::new(program).arg(package().join("README.md")).output().unwrap();
    let said = String::from_utf8(done.stderr).unwrap();
    assert_eq!(done.status.code(), Some(1));
    assert!(said.starts_with("skin: not a model (status 100): "), "{said}");
}
