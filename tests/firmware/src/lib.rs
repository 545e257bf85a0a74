//! Tests the runtime's promises to firmware, on every target that can run here.
//!
//! The images are in `src/bin`; `cargo xtask firmware` builds, runs and compares them. [`platform`]
//! holds the differences between targets: start, print and end.
#![no_std]

#[cfg(not(any(target_os = "none", target_family = "wasm")))]
extern crate std;

#[cfg(feature = "internals")]
#[path = "../../golden/bits.rs"]
#[allow(dead_code, reason = "no image nudges its poses")]
mod bits;
#[cfg(all(target_os = "none", target_arch = "arm", feature = "internals"))]
pub mod cost;
pub mod frame;
pub mod platform;
#[cfg(feature = "internals")]
pub mod report;

/// Makes a function the content of an image; the function returns whether the image succeeded.
#[macro_export]
macro_rules! image {
    ($run:path) => {
        /// Called once, after the target has started.
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

/// Allows an image to panic. Without this macro, an image that can panic does not link.
#[macro_export]
macro_rules! may_panic {
    () => {
        /// Ends the image with a failure.
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
        /// Defined only by [`may_panic`]: an image that links without the macro proves that it
        /// cannot panic.
        fn a_panic_is_reachable() -> !;
    }
    // SAFETY: the function has no arguments and does not touch this program's memory.
    unsafe { a_panic_is_reachable() }
}

/// The static memory of an image.
#[cfg(feature = "internals")]
mod memory {
    use crate::bits::Memory;
    use core::cell::UnsafeCell;
    use core::sync::atomic::{AtomicBool, Ordering};

    struct Shared(UnsafeCell<Memory>);

    // SAFETY: `take` returns the content once.
    unsafe impl Sync for Shared {}

    static MEMORY: Shared = Shared(UnsafeCell::new(Memory::new()));
    static TAKEN: AtomicBool = AtomicBool::new(false);

    /// Takes the memory; `None` if it is already taken.
    ///
    /// A load and a store replace a swap, which a Cortex-M0 lacks: images have one thread and no
    /// interrupts.
    pub(crate) fn take() -> Option<&'static mut Memory> {
        if TAKEN.load(Ordering::Relaxed) {
            return None;
        }
        TAKEN.store(true, Ordering::Relaxed);
        // SAFETY: there is no other reference, because the flag was not set before.
        Some(unsafe { &mut *MEMORY.0.get() })
    }
}
