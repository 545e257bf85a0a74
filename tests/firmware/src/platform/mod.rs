//! Start, output and end of the image on each target.

#[cfg(target_os = "none")]
mod semihosting;
#[cfg(any(target_os = "none", target_family = "wasm"))]
#[cfg_attr(all(target_os = "none", target_arch = "arm"), path = "arm.rs")]
#[cfg_attr(all(target_os = "none", target_arch = "riscv32"), path = "riscv.rs")]
#[cfg_attr(target_family = "wasm", path = "wasm.rs")]
mod target;

/// The host, which builds the images.
#[cfg(not(any(target_os = "none", target_family = "wasm")))]
mod target {
    /// Prints a text.
    pub fn print(text: &str) {
        std::print!("{text}");
    }
}

#[cfg(target_os = "none")]
pub use semihosting::{end, print};
// RISC-V needs only semihosting.
#[cfg(any(not(target_os = "none"), target_arch = "arm"))]
pub use target::*;

use core::fmt;

/// Formats text for [`print`].
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
