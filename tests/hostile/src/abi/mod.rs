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

use crate::recipe;
use arbitrary::{Result, Unstructured};
use arena::{Arena, Since};
use call::Call;
use functions::FUNCTIONS;

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

/// Makes one call in separate memory; returns the name of the function and its status.
fn one_call(u: &mut Unstructured<'_>, file: &[u8]) -> Result<(&'static str, sinew_status)> {
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

#[cfg(test)]
mod tests {
    use super::call::promises;
    use super::functions::FUNCTIONS;
    use super::one_call;
    use crate::recipe;
    use arbitrary::Unstructured;
    use models::{FilterContent, GOLDEN, KernelContent, Pieces, ViewsContent};
    use rand::{Rng, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use sinew_runtime::format::SectionKind;
    use sinew_runtime::kernel::Kernel;
    use sinew_runtime::views::Layer;
    use std::collections::BTreeSet;

    #[test]
    fn every_function_that_can_fail_is_called() {
        let called = FUNCTIONS.map(|(name, _)| name).into_iter().collect::<BTreeSet<_>>();
        assert_eq!(called, promises().keys().copied().collect());
    }

    /// Makes an object whose map has a rotation as input, and whose first layer has depth.
    fn turned() -> Pieces {
        let mut map = KernelContent::map("walk", 51);
        map.inputs = KernelContent::servo().inputs.split_off(2);
        let mut pieces = Pieces::kernels(&[map]);
        let mut content = ViewsContent::sample(vec![0], false);
        content.layers[0].flags = Layer::DEPTH;
        pieces.add_views(&content);
        pieces
    }

    #[test]
    fn every_status_in_the_header_occurs() {
        let golden = |index: usize| Pieces::of(GOLDEN[index]).unwrap();
        let (mut empty, mut bare, mut loose) = (golden(1), golden(0), golden(0));
        empty.keep_vertices(0);
        bare.sections.retain(|content| content.kind != SectionKind::RestTangents.number());
        loose.loosen();
        let mut files = GOLDEN.map(<[u8]>::to_vec).to_vec();
        files.extend([empty, bare, loose, Pieces::face()].map(|pieces| pieces.bytes()));
        let kernels = [KernelContent::every(Kernel::Quintic), KernelContent::servo()];
        files.extend(kernels.map(|content| Pieces::kernels(&[content]).bytes()));
        files.extend(Pieces::viewed().into_iter().chain([turned()]).map(|pieces| pieces.bytes()));
        files.push(Pieces::filter(&FilterContent::sample(2, 5)).bytes());
        let mut random = ChaCha8Rng::seed_from_u64(139);
        let mut seen = BTreeSet::new();
        for number in 0..600_000 {
            let mut bytes = [0; 160];
            random.fill_bytes(&mut bytes);
            let (script, recipe) = bytes.split_at(96);
            let file = files
                .get(number % (files.len() + 2))
                .cloned()
                .unwrap_or_else(|| recipe::file(recipe));
            if let Ok((name, status)) = one_call(&mut Unstructured::new(script), &file) {
                seen.insert((name, status as i32));
            }
        }
        for (name, statuses) in promises() {
            for status in statuses.iter().chain(&[0]).filter(|status| **status < 100) {
                assert!(seen.contains(&(name, *status)), "{name} never returned {status}");
            }
        }
    }
}
