//! An allocator that counts what each thread allocates.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

thread_local! {
    static ALLOCATED: Cell<[usize; 2]> = const { Cell::new([0; 2]) };
}

/// Returns the number of allocations of this thread so far, and their bytes.
pub(crate) fn allocated() -> [usize; 2] {
    ALLOCATED.with(Cell::get)
}

struct Counting;

// SAFETY: every call goes to the system's allocator unchanged; counting touches a plain cell.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATED.with(|allocated| {
            let [count, bytes] = allocated.get();
            allocated.set([count + 1, bytes + layout.size()]);
        });
        // SAFETY: the caller's promise is passed on.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, at: *mut u8, layout: Layout) {
        // SAFETY: the caller's promise is passed on.
        unsafe { System.dealloc(at, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

#[test]
fn allocations_are_counted() {
    let [count, bytes] = allocated();
    drop(std::hint::black_box(vec![1_u8; 3]));
    assert_eq!(allocated(), [count + 1, bytes + 3]);
}
