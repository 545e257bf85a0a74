//! Links an allocator, which the search for one must find.
#![cfg_attr(any(target_os = "none", target_family = "wasm"), no_std, no_main)]

extern crate alloc;

use alloc::vec::Vec;
use core::alloc::{GlobalAlloc, Layout};
use core::hint::black_box;

firmware::image!(run);
firmware::may_panic!();

fn run() -> bool {
    let mut list = Vec::new();
    list.try_reserve(black_box(3)).is_err()
}

struct Nothing;

// SAFETY: null says that there is no memory, which is true.
unsafe impl GlobalAlloc for Nothing {
    unsafe fn alloc(&self, _: Layout) -> *mut u8 {
        core::ptr::null_mut()
    }

    unsafe fn dealloc(&self, _: *mut u8, _: Layout) {}
}

#[global_allocator]
static NOTHING: Nothing = Nothing;
