//! How each target starts, prints and ends.

#[cfg(target_os = "none")]
mod semihosting;
#[cfg_attr(all(target_os = "none", target_arch = "arm"), path = "arm.rs")]
#[cfg_attr(all(target_os = "none", target_arch = "riscv32"), path = "riscv.rs")]
#[cfg_attr(target_family = "wasm", path = "wasm.rs")]
#[cfg_attr(not(any(target_os = "none", target_family = "wasm")), path = "host.rs")]
mod target;

#[cfg(target_os = "none")]
pub use semihosting::{end, print};
// A RISC-V has nothing to add to semihosting.
#[cfg(any(not(target_os = "none"), target_arch = "arm"))]
pub use target::*;

use core::fmt;

/// Formats to where [`print`] prints.
#[derive(Debug)]
pub struct Console;

impl fmt::Write for Console {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        print(text);
        Ok(())
    }
}

/// Prints a line.
#[macro_export]
macro_rules! say {
    ($($argument:tt)*) => {{
        use core::fmt::Write;
        // Printing cannot fail.
        let _ = writeln!($crate::platform::Console, $($argument)*);
    }};
}
