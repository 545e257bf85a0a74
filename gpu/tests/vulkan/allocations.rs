//! Recording allocates nothing on the host's heap.

use crate::common::{GOLDEN, load, odd_batch, parts};
use crate::opened;
use sinew_gpu::headless::Device as _;
use sinew_gpu::layout::{DeviceLimits, Plan};
use sinew_gpu::vulkan::headless::{Commands, Device};
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

thread_local! {
    static COUNT: Cell<usize> = const { Cell::new(0) };
}

/// Counts the allocations of each thread.
struct Counting;

#[global_allocator]
static ALLOCATOR: Counting = Counting;

// SAFETY: the system's allocator does the work.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        COUNT.set(COUNT.get() + 1);
        // SAFETY: as our own caller promises.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: as our own caller promises.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[test]
fn recording_allocates_nothing() {
    // Without the validation layer, which allocates.
    let device = opened(Device::of_driver("llvmpipe", false));
    for bytes in GOLDEN {
        let model = load(bytes);
        let (envelope, skin) = parts(&model);
        let batch = odd_batch(&envelope, &skin, 40);
        let limits = DeviceLimits { storage_binding_bytes: 12 << 10, ..device.limits() };
        let plan = Plan::new(&model, &envelope, &batch, &limits).unwrap();
        let uploaded = device.batch(model.blob(), &plan).unwrap();
        assert!(plan.chunks().len() > 1);
        let commands = Commands::new(&device).unwrap();
        let frame = |instance_len| {
            let before = COUNT.get();
            // SAFETY: the command buffer is ours and waited for; the batch is valid.
            unsafe {
                commands.submit(|device, commands| {
                    Ok(uploaded.bound().record(device, commands, instance_len)?)
                })
            }
            .unwrap();
            COUNT.get() - before
        };
        frame(40);
        let counts: usize = (0..100).map(|n| frame(1 + n % 40)).sum();
        assert_eq!(counts, 0);
    }
}

#[test]
fn the_allocator_counts() {
    let before = COUNT.get();
    drop(std::hint::black_box(vec![1_u8]));
    assert_eq!(COUNT.get(), before + 1);
}
