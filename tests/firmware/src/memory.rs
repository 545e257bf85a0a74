//! The one memory of an image, in static memory.

use crate::bits::Memory;
use core::cell::UnsafeCell;
use core::sync::atomic::{AtomicBool, Ordering};

struct Shared(UnsafeCell<Memory>);

// SAFETY: `take` gives the content out once.
unsafe impl Sync for Shared {}

static MEMORY: Shared = Shared(UnsafeCell::new(Memory::new()));
static TAKEN: AtomicBool = AtomicBool::new(false);

/// Takes the memory; `None` when it has been taken.
///
/// Load and store stand for a swap, which a Cortex-M0 has not: images have one thread and no
/// interrupts.
pub(crate) fn take() -> Option<&'static mut Memory> {
    if TAKEN.load(Ordering::Relaxed) {
        return None;
    }
    TAKEN.store(true, Ordering::Relaxed);
    // SAFETY: nothing else refers to it, for the flag was not set before.
    Some(unsafe { &mut *MEMORY.0.get() })
}
