//! Allocates: the control that the search for an allocator must detect.
#![cfg_attr(any(target_os = "none", target_family = "wasm"), no_std, no_main)]

extern crate alloc;

use alloc::vec::Vec;
use core::alloc::{GlobalAlloc, Layout};
use core::hint::black_box;
use core::sync::atomic::{AtomicPtr, Ordering};

firmware::image!(run);
firmware::may_panic!();

fn run() -> bool {
    let mut list = Vec::<u8>::new();
    list.try_reserve(black_box(3)).is_err() && black_box(list).is_empty()
}

/// Allocator that returns one address, and null after that.
struct Once(AtomicPtr<u8>);

// SAFETY: `alloc` returns null unless an address was stored, and no code stores one.
unsafe impl GlobalAlloc for Once {
    #[inline(never)]
    unsafe fn alloc(&self, _: Layout) -> *mut u8 {
        let at = self.0.load(Ordering::Relaxed);
        self.0.store(core::ptr::null_mut(), Ordering::Relaxed);
        black_box(at)
    }

    unsafe fn dealloc(&self, _: *mut u8, _: Layout) {}
}

#[global_allocator]
static ONCE: Once = Once(AtomicPtr::new(core::ptr::null_mut()));
