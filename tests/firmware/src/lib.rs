//! What the runtime promises to firmware, run on every target that can run here.
//!
//! The images are in `src/bin`; `cargo xtask firmware` builds, runs and compares them. What differs
//! between targets is [`platform`]: how to start, print and end.
#![no_std]

#[cfg(not(any(target_os = "none", target_family = "wasm")))]
extern crate std;

#[path = "../../golden/bits.rs"]
#[allow(dead_code, reason = "no image nudges its poses")]
mod bits;
#[cfg(all(target_os = "none", target_arch = "arm"))]
pub mod cost;
pub mod frame;
mod memory;
pub mod platform;
pub mod report;

/// Makes a function the image's content: it returns whether all was well.
#[macro_export]
macro_rules! image {
    ($run:path) => {
        /// Called once, when the target has started.
        #[unsafe(no_mangle)]
        extern "C" fn image() -> bool {
            $run()
        }

        #[cfg(not(any(target_os = "none", target_family = "wasm")))]
        fn main() -> std::process::ExitCode {
            if image() { std::process::ExitCode::SUCCESS } else { std::process::ExitCode::FAILURE }
        }
    };
}

/// Lets an image panic. Without it an image that can panic does not link.
#[macro_export]
macro_rules! may_panic {
    () => {
        /// Ends the image as failed.
        #[cfg(any(target_os = "none", target_family = "wasm"))]
        #[unsafe(no_mangle)]
        extern "C" fn a_panic_is_reachable() -> ! {
            $crate::platform::print("panicked\n");
            $crate::platform::end(false)
        }
    };
}

#[cfg(any(target_os = "none", target_family = "wasm"))]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    unsafe extern "C" {
        /// Defined by [`may_panic`] and by nothing else: the linker is what proves.
        fn a_panic_is_reachable() -> !;
    }
    // SAFETY: it has no arguments and touches nothing of this program's.
    unsafe { a_panic_is_reachable() }
}
