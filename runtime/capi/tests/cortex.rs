//! The C example on a Cortex-M4F: cross-compiled, linked with the M4F library, run in QEMU.
#![allow(clippy::unwrap_used, reason = "a test's helpers fail as the test does")]

mod common;

use common::{GOLDEN, STRICT, bare_library, golden, output, package, printed, scratch};
use std::process::Command;

const TARGET: &str = "thumbv7em-none-eabihf";
const FLAGS: [&str; 6] =
    ["-std=c11", "-O2", "-mcpu=cortex-m4", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16"];
const GCC: &str = "the ARM compiler (Debian: gcc-arm-none-eabi, libnewlib-arm-none-eabi)";
const QEMU: &str = "QEMU for ARM (Debian: qemu-system-arm)";
const POSES: usize = 1024;

/// Names that stand in an image if anything in it can panic.
const PANICS: [&str; 3] = ["rust_begin_unwind", "core::panicking", "core::fmt"];

#[test]
fn the_m4f_has_the_bits_of_rust_and_no_panic() {
    let image = scratch().join("skin-m4f.elf");
    let sources = package().join("tests/cortex");
    let mut gcc = Command::new("arm-none-eabi-gcc");
    gcc.args(FLAGS).args(STRICT).arg("-I").arg(package().join("include"));
    gcc.arg(package().join("examples/skin.c")).arg(sources.join("start.c"));
    // newlib's semihosting: the example's files and standard streams are this machine's.
    gcc.arg(bare_library(TARGET)).args(["--specs=rdimon.specs", "-Wl,--gc-sections"]);
    output(gcc.arg("-T").arg(sources.join("link.ld")).arg("-o").arg(&image), GCC);

    let names = output(Command::new("arm-none-eabi-nm").arg("-C").arg(&image), GCC);
    assert!(names.contains("sinew_envelope_palette"), "no names to search");
    assert!(PANICS.iter().all(|panic| !names.contains(panic)), "a panic is reachable");

    for name in GOLDEN {
        let mut qemu = Command::new("qemu-system-arm");
        qemu.args(["-machine", "mps2-an386", "-cpu", "cortex-m4", "-nographic"]);
        qemu.args(["-monitor", "none", "-serial", "none", "-semihosting-config"]);
        // A path could hold a comma, which separates options: the model is named from its folder.
        qemu.arg(format!("enable=on,target=native,arg=skin,arg={name},arg={POSES}"));
        qemu.arg("-kernel").arg(&image).current_dir(golden(""));
        let expected = printed(&std::fs::read(golden(name)).unwrap(), POSES);
        assert_eq!(output(&mut qemu, QEMU), expected, "{name}");
    }
}
