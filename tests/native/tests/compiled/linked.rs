//! The README's section on linking: a CMake project, the shared library's name.

use crate::compiled::host::{GCC, compile};
use crate::compiled::{BITS_C, example, libraries, output, package, readme, scratch};
use models::{GOLDEN_NAMES, golden_path};
use std::path::Path;
use std::process::Command;

const CMAKE: &str = "CMake (Debian: cmake)";

#[test]
fn a_cmake_project_builds_and_runs_the_example() {
    let folder = scratch().join("cmake");
    // The folder may hold cargo's earlier build.
    std::fs::create_dir_all(&folder).unwrap();
    let project = readme("cmake", 0).replace("sinew/runtime/capi", "${SINEW}/runtime/capi sinew");
    assert!(project.contains("${SINEW}"), "{project}");
    std::fs::write(folder.join("CMakeLists.txt"), project).unwrap();
    std::fs::copy(example("host.c"), folder.join("game.c")).unwrap();
    let build = folder.join("build");
    let root = package().join("../..");
    let mut configure = Command::new("cmake");
    configure.args(["-DCMAKE_BUILD_TYPE=Release", "-S"]).arg(&folder).arg("-B").arg(&build);
    // Uses the cargo of this build; the path may name another one first.
    configure.arg(format!("-DSINEW_CARGO={}", env!("CARGO")));
    output(configure.arg(format!("-DSINEW={}", root.display())), CMAKE);
    output(Command::new("cmake").arg("--build").arg(&build), CMAKE);
    let found = output(Command::new(build.join("game")).arg(golden_path(GOLDEN_NAMES[0])), CMAKE);
    assert!(found.contains("\n0.0: up to "), "{found}");
}

#[test]
fn an_installed_package_is_found_and_builds_from_the_runtime_alone() {
    let folder = scratch().join("installed");
    let copied = folder.join("runtime");
    let _ = std::fs::remove_dir_all(&copied);
    let runtime = package().join("..");
    let own = ["Cargo.toml", "src", "examples", "benches", "capi/Cargo.toml"];
    for path in own.iter().chain(&["capi/CMakeLists.txt", "capi/build.rs"]) {
        copy(&runtime.join(path), &copied.join(path));
    }
    for path in ["capi/src", "capi/include"] {
        copy(&runtime.join(path), &copied.join(path));
    }
    // The versions of this build, so that nothing is downloaded.
    copy(&runtime.join("../Cargo.lock"), &copied.join("capi/Cargo.lock"));
    let (build, place) = (folder.join("build"), folder.join("place"));
    let cmake = |arguments: &[&std::ffi::OsStr]| {
        let mut cmake = Command::new("cmake");
        output(cmake.args(arguments).env("CARGO_NET_OFFLINE", "true"), CMAKE)
    };
    let cargo = format!("-DSINEW_CARGO={}", env!("CARGO"));
    cmake(&[
        "-S".as_ref(),
        copied.join("capi").as_ref(),
        "-B".as_ref(),
        build.as_ref(),
        cargo.as_ref(),
    ]);
    cmake(&["--build".as_ref(), build.as_ref()]);
    cmake(&["--install".as_ref(), build.as_ref(), "--prefix".as_ref(), place.as_ref()]);
    let game = folder.join("game");
    std::fs::create_dir_all(&game).unwrap();
    std::fs::write(game.join("CMakeLists.txt"), readme("cmake", 1)).unwrap();
    std::fs::copy(example("host.c"), game.join("game.c")).unwrap();
    let prefix = format!("-DCMAKE_PREFIX_PATH={}", place.display());
    let built = game.join("build");
    cmake(&["-S".as_ref(), game.as_ref(), "-B".as_ref(), built.as_ref(), prefix.as_ref()]);
    cmake(&["--build".as_ref(), built.as_ref()]);
    let found = output(Command::new(built.join("game")).arg(golden_path(GOLDEN_NAMES[0])), CMAKE);
    assert!(found.contains("\n0.0: up to "), "{found}");
}

/// Copies a file or a folder.
fn copy(from: &Path, to: &Path) {
    if from.is_dir() {
        for entry in std::fs::read_dir(from).unwrap().flatten() {
            copy(&entry.path(), &to.join(entry.file_name()));
        }
        return;
    }
    std::fs::create_dir_all(to.parent().unwrap()).unwrap();
    std::fs::copy(from, to).unwrap();
}

#[test]
#[cfg(target_os = "linux")]
fn a_program_finds_the_shared_library_by_its_name() {
    let library = libraries().join("libsinew_capi.so").display().to_string();
    // Links the library by its path, and runs the program with a copy in another folder.
    let program = compile("gcc", "-std=c11", BITS_C, "skin-named", &[&library]);
    let elsewhere = scratch().join("elsewhere");
    std::fs::create_dir_all(&elsewhere).unwrap();
    std::fs::copy(&library, elsewhere.join("libsinew_capi.so")).unwrap();
    let listed = output(Command::new("readelf").arg("-d").arg(&program), "binutils");
    assert!(listed.contains("[libsinew_capi.so]"), "{listed}");
    let mut run = Command::new(program);
    run.arg(golden_path(GOLDEN_NAMES[0])).env("LD_LIBRARY_PATH", &elsewhere);
    assert!(output(&mut run, GCC).contains("\nhash        "));
}
