//! Recording allocates nothing on the host's heap.

use crate::allocator::allocated;
use crate::common::{GOLDEN, GOLDEN_STRETCH, load, odd_batch, parts};
use crate::vulkan::opened;
use sinew_gpu::headless::Device as _;
use sinew_gpu::layout::{DeviceLimits, Plan};
use sinew_gpu::vulkan::headless::{Commands, Device};

#[test]
fn recording_allocates_nothing() {
    // Without the validation layer, which allocates.
    let device = opened(Device::of_driver("llvmpipe", false));
    for bytes in GOLDEN.into_iter().chain(GOLDEN_STRETCH) {
        let model = load(bytes);
        let (envelope, skin) = parts(&model);
        let batch = odd_batch(&envelope, &skin, 40);
        let limits = DeviceLimits { storage_binding_bytes: 12 << 10, ..device.limits() };
        let plan = Plan::new(&model, &envelope, &batch, &limits).unwrap();
        let uploaded = device.batch(model.blob(), &plan).unwrap();
        assert!(plan.chunks().len() > 1);
        let commands = Commands::new(&device).unwrap();
        let frame = |instance_len| {
            let [before, _] = allocated();
            // SAFETY: the command buffer is ours and waited for; the batch is valid.
            unsafe {
                commands.submit(|device, commands| {
                    Ok(uploaded.bound().record(device, commands, instance_len)?)
                })
            }
            .unwrap();
            allocated()[0] - before
        };
        frame(40);
        let counts: usize = (0..100).map(|n| frame(1 + n % 40)).sum();
        assert_eq!(counts, 0);
    }
}
