//! What this library is.

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
