//! The C example on a Cortex-M4F: cross-compiled, linked with the M4F library, run in QEMU.

use crate::compiled::{BITS_C, STRICT, bare_library, output, package, printed, readme, scratch};
use models::{GOLDEN_NAMES, golden_path};
use sinew_runtime::{Envelope, Model, Skin};
use std::path::{Path, PathBuf};
use std::process::Command;

const TARGET: &str = "thumbv7em-none-eabihf";
const FLAGS: [&str; 6] =
    ["-std=c11", "-O2", "-mcpu=cortex-m4", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16"];
const GCC: &str = "the ARM compiler (Debian: gcc-arm-none-eabi, libnewlib-arm-none-eabi)";
const QEMU: &str = "QEMU for ARM (Debian: qemu-system-arm)";
const POSES: usize = 1024;

/// Symbols that an image contains if its code can panic.
const PANICS: [&str; 3] = ["rust_begin_unwind", "core::panicking", "core::fmt"];

#[test]
fn the_m4f_has_the_bits_of_rust_and_no_panic() {
    let image = link(Path::new(BITS_C), "skin-m4f");
    let names = output(Command::new("arm-none-eabi-nm").arg("-C").arg(&image), GCC);
    assert!(names.contains("sinew_envelope_palette"), "no names to search");
    assert!(PANICS.iter().all(|panic| !names.contains(panic)), "a panic is reachable");
    for name in GOLDEN_NAMES {
        let expected = printed(&std::fs::read(golden_path(name)).unwrap(), POSES);
        let found = run(&image, &format!("arg=skin,arg={name},arg={POSES}"));
        assert_eq!(found, expected, "{name}");
    }
}

#[test]
fn the_readme_runs_on_the_m4f() {
    let file = std::fs::read(golden_path(GOLDEN_NAMES[0])).unwrap();
    let model = Model::from_bytes(&*file).unwrap();
    let (envelope, skin) = (model.first::<Envelope>().unwrap(), model.first::<Skin>().unwrap());
    let (j, p, v) = (envelope.joint_len(), envelope.palette_len(), skin.vertex_len());
    let shown = readme("c", 1);
    let code = shown.replacen("JOINTS = 20", &format!("JOINTS = {j}"), 1);
    let code = code.replacen("TRANSFORMS = 20", &format!("TRANSFORMS = {p}"), 1);
    let code = code.replacen("VERTICES = 1000", &format!("VERTICES = {v}"), 1);
    let source = scratch().join("readme-m4f.c");
    let bytes = file.iter().map(u8::to_string).collect::<Vec<_>>().join(",");
    let program = format!(
        "{code}
#include <stdio.h>
const uint8_t model_file[] = {{{bytes}}};
const size_t model_bytes = sizeof model_file;
int main(void)
{{
    for (int joint = 0; joint < JOINTS; joint++) {{
        pose[joint] = (sinew_matrix){{{{{{1, 0, 0, 0}}, {{0, 1, 0, 0}}, {{0, 0, 1, 0}}}}}};
    }}
    printf(\"%d %d\", (int)character_init(), (int)character_frame());
    printf(\" [%.6f, %.6f, %.6f]\", positions[0], positions[1], positions[2]);
}}
"
    );
    std::fs::write(&source, program).unwrap();
    let found = run(&link(&source, "readme-m4f"), "arg=readme");
    let first = skin.rest_position(0).unwrap();
    assert_eq!(found, format!("0 0 {first:.6?}"));
    assert_ne!(code, shown);
}

/// Links a program for the M4F.
fn link(source: &Path, name: &str) -> PathBuf {
    let image = scratch().join(name).with_extension("elf");
    let sources = package().join("examples/cortex");
    let mut gcc = Command::new("arm-none-eabi-gcc");
    gcc.args(FLAGS).args(STRICT).arg("-I").arg(package().join("include"));
    gcc.arg(source).arg(sources.join("start.c"));
    // newlib's semihosting gives the program this machine's files and standard streams.
    gcc.arg(bare_library(TARGET)).args(["--specs=rdimon.specs", "-Wl,--gc-sections"]);
    output(gcc.arg("-T").arg(sources.join("link.ld")).arg("-o").arg(&image), GCC);
    image
}

/// Runs an image in the folder of the golden files: a path with a comma would be split into options.
fn run(image: &Path, arguments: &str) -> String {
    let mut qemu = Command::new("qemu-system-arm");
    qemu.args(["-machine", "mps2-an386", "-cpu", "cortex-m4", "-nographic"]);
    qemu.args(["-monitor", "none", "-serial", "none", "-semihosting-config"]);
    qemu.arg(format!("enable=on,target=native,{arguments}"));
    output(qemu.arg("-kernel").arg(image).current_dir(golden_path("")), QEMU)
}
