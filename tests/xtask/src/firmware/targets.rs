//! The targets, and how each runs an image.

use crate::prepare::untested_unless_ci;
use std::path::Path;
use std::process::Command;

/// A target.
#[derive(Clone, Copy)]
pub(super) struct Target {
    /// What it is called in reports.
    pub(super) name: &'static str,
    /// Its triple; empty for that of this machine.
    pub(super) triple: &'static str,
    /// What the compiler may use beyond the triple.
    pub(super) flags: &'static str,
    /// Whether it has no operating system.
    pub(super) bare: bool,
    /// What runs an image; the image follows. Empty where it runs by itself.
    runner: &'static str,
}

/// The Cortex-M4F, which is measured.
pub(super) const M4F: Target = Target {
    name: "Cortex-M4F",
    triple: "thumbv7em-none-eabihf",
    flags: "",
    bare: true,
    runner: "qemu-system-arm -machine mps2-an386 -cpu cortex-m4 -icount shift=0 -nographic \
             -semihosting-config enable=on,target=native -kernel",
};

const HOST: Target =
    Target { name: "this machine", triple: "", flags: "", bare: false, runner: "" };

/// Every target; the first is what the others are compared with.
pub(super) const TARGETS: [Target; 6] = [
    HOST,
    // A Cortex-M3 runs the code of a Cortex-M0, and QEMU's has the memory for the models.
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

impl Target {
    /// Tells whether this machine can run it; says so where it cannot.
    ///
    /// # Errors
    /// If it cannot, and `CI` is set.
    pub(super) fn runs_here(&self) -> Result<bool, String> {
        let runs = self.flags.is_empty() || has_x86_64_v3();
        if !runs {
            untested_unless_ci(format!("{}: not run, this CPU has it not", self.name))?;
        }
        Ok(runs)
    }

    /// Runs an image and returns what it prints.
    ///
    /// # Errors
    /// If it cannot be run, or ends as failed.
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
        // QEMU prints for the image where there is a console, and elsewhere as an error.
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
