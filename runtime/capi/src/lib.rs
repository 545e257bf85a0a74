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
mod version;

mod argument;
mod error;
mod status;

mod matrix;
mod model;

mod envelope;
mod palette;
mod pose;

mod kernel;

mod skin;

mod mesh;

mod filter;
mod job;

mod shapes;

mod prior;

mod views;

pub use argument::*;
pub use envelope::*;
pub use error::*;
pub use filter::*;
pub use job::*;
pub use kernel::*;
pub use matrix::*;
pub use mesh::*;
pub use model::*;
pub use palette::*;
pub use pose::*;
pub use prior::*;
pub use shapes::*;
pub use skin::*;
pub use status::*;
pub use version::*;
pub use views::*;

/// Stops: nothing here panics, but a bare target's linker asks for it.
#[cfg(target_os = "none")]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {}
}
