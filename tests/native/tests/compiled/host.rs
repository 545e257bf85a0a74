//! The examples and the tests of sinew.hpp, with this machine's C and C++ compilers.

use crate::compiled::{
    BITS_C, BITS_CPP, STRICT, example, libraries, output, package, printed, readme, scratch,
};
use models::{GOLDEN_NAMES, TURNED_NAMES, golden_path};
use std::path::{Path, PathBuf};
use std::process::Command;

const POSES: usize = 1024;
const C: &str = "-std=c11";
pub(crate) const CXX: &str = "-std=c++17";
pub(crate) const GCC: &str = "gcc and g++ (Debian: gcc, g++)";
/// Flags for sanitizers that end the program at the first error.
pub(crate) const SANITIZERS: [&str; 3] =
    ["-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"];

/// Compiles a source with strict warnings, and links it with the flags in `more`.
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
    command.arg(source).args(more);
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
    agrees(&compile("gcc", C, BITS_C, "skin-gcc", &["-O2", &library]));
}

#[test]
fn cpp_has_the_bits_of_rust() {
    let library = static_library();
    let flags = ["-O2", "-fno-exceptions", "-fno-rtti", &library];
    agrees(&compile("g++", CXX, BITS_CPP, "skin-g++", &flags));
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
    agrees(&compile("clang", C, BITS_C, "skin-clang", &["-O2", &library]));
    agrees(&compile("clang++", CXX, BITS_CPP, "skin-clang++", &["-O2", &library]));
}

#[test]
fn the_header_is_clean_for_msvc_if_clang_is_installed() {
    if Command::new("clang").arg("--version").output().is_err() {
        assert!(std::env::var_os("CI").is_none(), "clang was not found (Debian: clang)");
        return;
    }
    let source = scratch().join("msvc.c");
    std::fs::write(&source, "#include <sinew.h>\nsinew_skin_job job(void);\n").unwrap();
    for language in [["/TC", "/std:c11"], ["/TP", "/std:c++17"]] {
        // Only the checks of the compiler: a machine without Windows has no headers of its system.
        let mut clang = Command::new("clang");
        clang.args(["--driver-mode=cl", "--target=x86_64-pc-windows-msvc", "/Zs", "/W4", "/WX"]);
        clang.args(language).args(["/clang:-ffreestanding", "/I"]).arg(package().join("include"));
        // After "--", or a path that starts with "/w" is an option.
        output(clang.arg("--").arg(&source), "clang");
    }
}

#[test]
fn the_shared_library_has_the_bits_of_rust() {
    let folder = libraries().display().to_string();
    let found_at = format!("-Wl,-rpath,{folder}");
    let flags = ["-L", &folder, "-Wl,-Bdynamic", "-l:libsinew_capi.so", &found_at];
    agrees(&compile("gcc", C, BITS_C, "skin-shared", &flags));
}

#[test]
fn sanitizers_are_silent() {
    let library = static_library();
    let flags = [&SANITIZERS[..], &[&library]].concat();
    agrees(&compile("gcc", C, BITS_C, "skin-sanitized", &flags));
    agrees(&compile("g++", CXX, BITS_CPP, "skin-sanitized++", &flags));
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
    let files = [GOLDEN_NAMES[1], GOLDEN_NAMES[0], TURNED_NAMES[0]].map(golden_path);
    let found = output(Command::new(program).args(files), GCC);
    assert_eq!(found, "0 failures\n");
}

/// Lines of a host program that a reader takes in at once.
const LINES: usize = 60;

#[test]
fn the_hosts_print_the_same_in_c_cpp_and_rust() {
    let library = static_library();
    let [c, cpp] = ["host.c", "host.cpp"].map(example);
    let flags = [&SANITIZERS[..], &[&library]].concat();
    let programs = [
        PathBuf::from(env!("CARGO_BIN_EXE_host")),
        compile("gcc", C, c.to_str().unwrap(), "host", &flags),
        compile("g++", CXX, cpp.to_str().unwrap(), "host++", &flags),
    ];
    for name in GOLDEN_NAMES {
        let [rust, c, cpp] =
            programs.each_ref().map(|own| output(Command::new(own).arg(golden_path(name)), GCC));
        assert_eq!((&c, &cpp), (&rust, &rust), "{name}");
        assert_eq!(rust.lines().count(), 4, "{rust}");
        assert!(rust.contains("\n0.0: up to ") && rust.contains(", confidence 1.00\n"), "{rust}");
    }
}

#[test]
fn the_hosts_are_short_formatted_and_in_the_readme() {
    for (name, language) in [("host.c", "c"), ("host.cpp", "cpp"), ("host.rs", "rust")] {
        let text = std::fs::read_to_string(example(name)).unwrap();
        assert!(text.lines().count() <= LINES, "{name}: {} lines", text.lines().count());
        if language != "rust" {
            assert_eq!(readme(language, 0), text, "the README shows another {name}");
            let mut format = Command::new("clang-format");
            let formatted =
                output(format.arg(example(name)), "clang-format (Debian: clang-format)");
            assert_eq!(formatted, text, "{name} is not formatted");
        }
    }
}

#[test]
fn a_file_that_is_no_model_is_refused_in_words() {
    let library = static_library();
    let program = compile("gcc", C, BITS_C, "skin-refuses", &[&library]);
    let done = Command::new(program).arg(package().join("README.md")).output().unwrap();
    let said = String::from_utf8(done.stderr).unwrap();
    assert_eq!(done.status.code(), Some(1));
    assert!(said.starts_with("skin: file: not a model, "), "{said}");
}
