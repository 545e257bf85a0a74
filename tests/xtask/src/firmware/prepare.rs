//! Installs what firmware needs, or says what to install.

use super::targets::TARGETS;
use crate::components::{Component, install, starts};
use crate::prepare::targets;

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

/// Prepares compilers and emulators.
pub(super) fn prepare() -> Result<(), String> {
    let triples = TARGETS.iter().map(|target| target.triple).filter(|triple| !triple.is_empty());
    targets(&triples.collect::<Vec<_>>())?;
    install(&COMPONENTS)
}
