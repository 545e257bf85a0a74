//! The C ABI, called as no careful caller calls it: with pointers that are null, misaligned or into
//! other memory of the call, with wrong lengths, on files from strangers.
//!
//! What no library can see stays true, as `sinew.h` asks: a pointer and its length describe memory of
//! the caller, and a handle points to enough of it.

mod arena;
mod arguments;
mod call;
mod filtered;
mod filters;
mod frame;
mod functions;
mod header;
mod kernels;
mod outputs;
mod pinned;
mod posed;
mod priors;
mod shapes;
mod shared;
mod viewed;
mod views;

use crate::recipe;
use arbitrary::{Result, Unstructured};
use arena::{Arena, Since};
use call::Call;
use functions::FUNCTIONS;

use sinew_capi::sinew_status;
use sinew_runtime::{FileError, Model};

/// The last number of a pose that the frame may have.
const POSES: usize = 7;

/// Calls of one input.
const CALLS: usize = 8;

/// Reads the first half of some bytes as calls and the second as the [`recipe`] of the file that they
/// work on.
///
/// # Errors
/// Why the file was refused; it is called all the same.
///
/// # Panics
/// Where a status is not one that the header names for the function, or not that of a fault among the
/// arguments, or is told of another argument than the fault's; where a call that failed has written,
/// where one that succeeded has written elsewhere than to its results, and where one with a fault
/// succeeds, or one without fails or gives other bits than the runtime.
pub fn calls(data: &[u8]) -> std::result::Result<(), FileError> {
    let (script, recipe) = data.split_at(data.len() / 2);
    let file = recipe::file(recipe);
    let mut u = Unstructured::new(script);
    for _ in 0..CALLS {
        // A script that ends early has called what it could.
        if u.is_empty() || one_call(&mut u, &file).is_err() {
            break;
        }
    }
    Model::from_bytes(&file).map(|_| ())
}

/// Makes one call in memory of its own; returns the function and what it said.
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
    use super::functions::FUNCTIONS;
    use super::header::promises;
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

    /// An object whose map goes by a rotation, and a layer of which has depth.
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
    fn whatever_the_header_promises_of_calls_happens() {
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
