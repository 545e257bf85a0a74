//! Calls the C ABI as no careful caller does: with pointers that are null, misaligned or into other
//! memory of the call, with wrong lengths, and on untrusted files.
//!
//! Preconditions that no library can check hold, as `sinew.h` demands: a pointer and its length
//! describe memory of the caller, and a handle points to enough memory.

mod arena;
mod arguments;
mod call;
mod expected;
mod filters;
mod frame;
mod functions;
mod kernels;
mod posed;
mod priors;
mod shapes;
mod shared;
mod views;

pub use call::promises;
use functions::FUNCTIONS;

use crate::recipe;
use arbitrary::{Result, Unstructured};
use arena::{Arena, Since};
use call::Call;

use sinew_capi::sinew_status;
use sinew_runtime::{FileError, Model};

/// Largest number of a frame's pose.
const POSES: usize = 7;

/// Calls per input.
const CALLS: usize = 8;

/// Reads the first half of the bytes as calls and the second half as the [`recipe`] of the file
/// that they work on.
///
/// # Errors
/// The reason why the file was refused; the functions are called on a refused file too.
///
/// # Panics
/// - If a status is not in the function's comment in the header, is not the status of a fault among
///   the arguments, or is reported for another argument than the faulty argument.
/// - If a failed call has written, or a successful call has written outside its results.
/// - If a call with a fault succeeds.
/// - If a call without a fault fails or gives other bits than the runtime.
pub fn calls(data: &[u8]) -> std::result::Result<(), FileError> {
    let (script, recipe) = data.split_at(data.len() / 2);
    let file = recipe::file(recipe);
    let mut u = Unstructured::new(script);
    for _ in 0..CALLS {
        // A script that ends early has made all its calls.
        if u.is_empty() || one_call(&mut u, &file).is_err() {
            break;
        }
    }
    Model::from_bytes(&file).map(|_| ())
}

/// Lists the functions that [`one_call`] can call.
pub fn function_names() -> impl Iterator<Item = &'static str> {
    FUNCTIONS.into_iter().map(|(name, _)| name)
}

/// Makes one call in separate memory; returns the name of the function and its status.
///
/// # Errors
/// The script of the call is too short.
pub fn one_call(u: &mut Unstructured<'_>, file: &[u8]) -> Result<(&'static str, sinew_status)> {
    let pose_number = u.int_in_range(0..=POSES)?;
    let since = match u.int_in_range(0..=15)? {
        0 => Since::Reloaded,
        1 => Since::Emptied,
        _ => Since::Nothing,
    };
    let mut arena = Arena::new(file, pose_number, since);
    let (name, function) = FUNCTIONS[u.choose_index(FUNCTIONS.len())?];
    let mut call = Call::new(u, &mut arena)?;
    let status = function(&mut call)?;
    call.check(name, status);
    Ok((name, status))
}
