//! The targets, how each runs an image, and the programs that they need.

use crate::components::{Component, install, starts};
use crate::prepare::{targets, untested_unless_ci};
use std::path::Path;
use std::process::Command;

/// A target.
#[derive(Clone, Copy)]
pub(super) struct Target {
    /// Name in reports.
    pub(super) name: &'static str,
    /// Target triple; empty for the host.
    pub(super) triple: &'static str,
    /// Compiler flags.
    pub(super) flags: &'static str,
    /// Whether it has no operating system.
    pub(super) bare: bool,
    /// Command that runs an image, which is its last argument; empty if the image runs directly.
    runner: &'static str,
}

/// The Cortex-M4F, the target of all measurements.
pub(super) const M4F: Target = Target {
    name: "Cortex-M4F",
    triple: "thumbv7em-none-eabihf",
    flags: "",
    bare: true,
    runner: "qemu-system-arm -machine mps2-an386 -cpu cortex-m4 -icount shift=0 -nographic \
             -semihosting-config enable=on,target=native -kernel",
};

/// The board of the example: an STM32F405.
pub(super) const STM32F4: Target = Target {
    name: "STM32F405",
    runner: "qemu-system-arm -machine netduinoplus2 -nographic \
             -semihosting-config enable=on,target=native -kernel",
    ..M4F
};

const HOST: Target =
    Target { name: "this machine", triple: "", flags: "", bare: false, runner: "" };

/// Every target; the others are compared with the first.
pub(super) const TARGETS: [Target; 6] = [
    HOST,
    // A Cortex-M3 runs the code of a Cortex-M0, and its QEMU board has enough memory for the
    // models.
    Target {
        name: "thumbv6m, soft float",
        triple: "thumbv6m-none-eabi",
        flags: "",
        bare: true,
        runner: "qemu-system-arm -machine mps2-an385 -cpu cortex-m3 -nographic \
                 -semihosting-config enable=on,target=native -kernel",
    },
    Target {
        name: "riscv32imac, soft float",
        triple: "riscv32imac-unknown-none-elf",
        flags: "",
        bare: true,
        runner: "qemu-system-riscv32 -machine virt -bios none -nographic \
                 -semihosting-config enable=on,target=native -kernel",
    },
    M4F,
    Target {
        name: "wasm32 in Node",
        triple: "wasm32-unknown-unknown",
        flags: "",
        bare: false,
        runner: "node tests/firmware/run.mjs",
    },
    Target { name: "x86-64-v3", flags: "-C target-cpu=x86-64-v3", ..HOST },
];

const COMPONENTS: [Component; 3] = [
    Component {
        what: "QEMU for Arm",
        package: "qemu-system-arm",
        found: || starts("qemu-system-arm"),
    },
    Component {
        what: "QEMU for RISC-V",
        package: "qemu-system-misc",
        found: || starts("qemu-system-riscv32"),
    },
    Component { what: "Node.js", package: "nodejs", found: || starts("node") },
];

/// Installs compilers and emulators, or says how to install them.
pub(super) fn prepare() -> Result<(), String> {
    let triples = TARGETS.iter().map(|target| target.triple).filter(|triple| !triple.is_empty());
    targets(&triples.collect::<Vec<_>>())?;
    install(&COMPONENTS)
}

impl Target {
    /// Returns whether this machine can run the target; prints a notice if not.
    ///
    /// # Errors
    /// If this machine cannot run the target, and `CI` is set.
    pub(super) fn runs_here(&self) -> Result<bool, String> {
        let runs = self.flags.is_empty() || has_x86_64_v3();
        if !runs {
            untested_unless_ci(format!("{}: not run, this CPU has it not", self.name))?;
        }
        Ok(runs)
    }

    /// Runs an image and returns its output.
    ///
    /// # Errors
    /// If the image cannot be run, or ends with a failure.
    pub(super) fn run(&self, image: &Path) -> Result<String, String> {
        let mut words = self.runner.split_whitespace();
        let mut command = words.next().map_or_else(
            || Command::new(image),
            |runner| {
                let mut command = Command::new(runner);
                command.args(words).arg(image);
                command
            },
        );
        let output = command.output().map_err(|error| format!("{}: {error}", self.name))?;
        // QEMU prints the image's output to stdout if there is a console, else to stderr.
        let printed = [output.stdout, output.stderr].concat();
        let printed = String::from_utf8_lossy(&printed).into_owned();
        if output.status.success() {
            Ok(printed)
        } else {
            Err(format!("{}: {} failed: {}\n{printed}", self.name, image.display(), output.status))
        }
    }
}

#[cfg(target_arch = "x86_64")]
fn has_x86_64_v3() -> bool {
    std::is_x86_feature_detected!("avx2")
        && std::is_x86_feature_detected!("fma")
        && std::is_x86_feature_detected!("bmi1")
        && std::is_x86_feature_detected!("bmi2")
        && std::is_x86_feature_detected!("f16c")
        && std::is_x86_feature_detected!("lzcnt")
        && std::is_x86_feature_detected!("movbe")
}

#[cfg(not(target_arch = "x86_64"))]
fn has_x86_64_v3() -> bool {
    false
}
