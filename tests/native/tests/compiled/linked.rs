//! The README's section on linking: a CMake project, the shared library's name, the C++ example.

use crate::compiled::host::{CXX, GCC, SANITIZERS, compile, static_library};
use crate::compiled::{libraries, output, package, readme, scratch};
use models::{GOLDEN_NAMES, golden_path};
use sinew_runtime::{LocalTransform, Matrix3x4, Model, model_space_pose};
use std::fmt::Write;
use std::process::Command;

const CMAKE: &str = "CMake (Debian: cmake)";

#[test]
fn the_cpp_of_the_readme_has_the_runtimes_numbers() {
    let source = scratch().join("readme.cpp");
    std::fs::write(&source, readme("cpp", 0)).unwrap();
    let library = static_library();
    let flags = [&SANITIZERS[..], &["-fno-exceptions", &library]].concat();
    let program = compile("g++", CXX, source.to_str().unwrap(), "readme++", &flags);
    let found = output(Command::new(program).arg(golden_path(GOLDEN_NAMES[1])), GCC);
    let file = std::fs::read(golden_path(GOLDEN_NAMES[1])).unwrap();
    let model = Model::from_bytes(&*file).unwrap();
    let (envelope, skin) = (model.envelope().unwrap(), model.skin().unwrap());
    let mut pose = vec![Matrix3x4::default(); envelope.joint_len()];
    let mut scratch = vec![0.0; envelope.scratch_len()];
    let mut palette = vec![Matrix3x4::default(); envelope.palette_len()];
    let mut positions = vec![[0.0; 3]; skin.vertex_len()];
    let mut expected = String::new();
    for angle in [0.0_f32, 0.5] {
        let mut local: Vec<LocalTransform> = envelope.rest_locals().collect();
        let (sin, cos) = (0.5 * angle).sin_cos();
        // The rest joints of a golden file are in a row along x, without rotation.
        local.last_mut().unwrap().rotation = [0.0, 0.0, sin, cos];
        model_space_pose(&envelope, &local, &mut pose).unwrap();
        let confidence = envelope.palette(&pose, &[], &mut scratch, &mut palette).unwrap();
        skin.skin_positions(&palette, &mut positions).unwrap();
        let [x, y, z] = *positions.last().unwrap();
        writeln!(
            expected,
            "turned by {angle:.2}: confidence {confidence:.2}, last vertex {x:.3} {y:.3} {z:.3}"
        )
        .unwrap();
    }
    assert_eq!(found, expected);
    assert!(expected.starts_with("turned by 0.00: confidence 1.00"), "{expected}");
}

#[test]
fn a_cmake_project_builds_and_runs_the_example() {
    let folder = scratch().join("cmake");
    // The folder may hold cargo's earlier build.
    std::fs::create_dir_all(&folder).unwrap();
    let project = readme("cmake", 0).replace("sinew/runtime/capi", "${SINEW}/runtime/capi sinew");
    assert!(project.contains("${SINEW}"), "{project}");
    std::fs::write(folder.join("CMakeLists.txt"), project).unwrap();
    std::fs::copy(package().join("examples/skin.c"), folder.join("game.c")).unwrap();
    let build = folder.join("build");
    let root = package().join("../..");
    let mut configure = Command::new("cmake");
    configure.args(["-DCMAKE_BUILD_TYPE=Release", "-S"]).arg(&folder).arg("-B").arg(&build);
    // Uses the cargo of this build; the path may name another one first.
    configure.arg(format!("-DSINEW_CARGO={}", env!("CARGO")));
    output(configure.arg(format!("-DSINEW={}", root.display())), CMAKE);
    output(Command::new("cmake").arg("--build").arg(&build), CMAKE);
    let found = output(Command::new(build.join("game")).arg(golden_path(GOLDEN_NAMES[0])), CMAKE);
    assert!(found.contains("\nhash        "), "{found}");
}

#[test]
#[cfg(target_os = "linux")]
fn a_program_finds_the_shared_library_by_its_name() {
    let library = libraries().join("libsinew_capi.so").display().to_string();
    // Links the library by its path, and runs the program with a copy in another folder.
    let program = compile("gcc", "-std=c11", "examples/skin.c", "skin-named", &[&library]);
    let elsewhere = scratch().join("elsewhere");
    std::fs::create_dir_all(&elsewhere).unwrap();
    std::fs::copy(&library, elsewhere.join("libsinew_capi.so")).unwrap();
    let listed = output(Command::new("readelf").arg("-d").arg(&program), "binutils");
    assert!(listed.contains("[libsinew_capi.so]"), "{listed}");
    let mut run = Command::new(program);
    run.arg(golden_path(GOLDEN_NAMES[0])).env("LD_LIBRARY_PATH", &elsewhere);
    assert!(output(&mut run, GCC).contains("\nhash        "));
}
