//! C ABI of `sinew-runtime`. cbindgen generates `include/sinew.h` from these sources and their doc comments.
//!
//! Objects are in the caller's memory. Nothing is allocated and nothing has to be freed. Each function checks its
//! arguments where possible and returns a [`sinew_status`].
#![cfg_attr(target_os = "none", no_std)]
#![allow(non_camel_case_types, reason = "types have their C names")]
#![allow(
    clippy::missing_safety_doc,
    reason = "the head of the header states the requirements of all pointers once"
)]

mod border;
mod part;

// The header lists the functions in the order of these modules.
mod argument;
mod error;

mod model;

mod open;

mod envelope;
mod palette;
mod pose;

mod kernel;

mod skin;

mod filter;
mod job;

mod prior;

mod views;

pub use argument::*;
pub use envelope::*;
pub use error::*;
pub use filter::*;
pub use job::*;
pub use kernel::*;
pub use model::*;
pub use open::*;
pub use palette::*;
pub use part::SINEW_PART_WORDS;
pub use pose::*;
pub use prior::*;
pub use skin::*;
pub use views::*;

use core::ffi::c_char;

/// Version of the ABI that this header describes. `sinew_abi_version` returns the library's version.
///
/// The version grows when a function, a structure or the meaning of a number changes.
pub const SINEW_ABI_VERSION: u32 = 11;

/// Returns the version of the library's ABI. A program that loads the library at run time compares the
/// version with `SINEW_ABI_VERSION`.
#[unsafe(no_mangle)]
pub extern "C" fn sinew_abi_version() -> u32 {
    SINEW_ABI_VERSION
}

/// Returns the version of the library as zero-terminated text.
#[unsafe(no_mangle)]
pub extern "C" fn sinew_version() -> *const c_char {
    const VERSION: &str = concat!(env!("CARGO_PKG_VERSION"), "\0");
    VERSION.as_ptr().cast()
}

/// Returns the version of the file format that the library reads.
#[unsafe(no_mangle)]
pub extern "C" fn sinew_format_version() -> u32 {
    u32::from(sinew_runtime::format::VERSION)
}

/// Stops. No code of this crate panics, but the linker of a bare target requires a handler.
#[cfg(target_os = "none")]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {}
}
