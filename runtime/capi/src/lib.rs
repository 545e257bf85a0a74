//! C ABI of `sinew-runtime`; `include/sinew.h` is made of these sources and says the same.
//!
//! Objects lie in memory of the caller, nothing is allocated, nothing has to be freed. Each
//! function checks what can be checked of its arguments and returns a [`sinew_status`].
#![cfg_attr(target_os = "none", no_std)]
#![allow(non_camel_case_types, reason = "types have the names that they have in C")]
#![allow(
    clippy::missing_safety_doc,
    reason = "what every pointer must be is stated once, at the head of the header"
)]

mod border;
mod part;

// The header's functions come in the order of these groups.
mod argument;
mod error;

mod model;

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
pub use palette::*;
pub use pose::*;
pub use prior::*;
pub use skin::*;
pub use views::*;

use core::ffi::c_char;

/// Version of the ABI that this header describes; `sinew_abi_version` returns the library's.
///
/// It grows when a function, a structure or the meaning of a number changes.
pub const SINEW_ABI_VERSION: u32 = 9;

/// Returns the version of the ABI, to be compared with `SINEW_ABI_VERSION` where the library is
/// loaded at run time.
#[unsafe(no_mangle)]
pub extern "C" fn sinew_abi_version() -> u32 {
    SINEW_ABI_VERSION
}

/// Returns the version of the library, as text that ends in a zero.
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

/// Stops: nothing here panics, but a bare target's linker asks for it.
#[cfg(target_os = "none")]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {}
}
