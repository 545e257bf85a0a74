//! The validation layer confirms that the barriers are needed, and that they are enough.

use crate::common::{GOLDEN, GOLDEN_STRETCH, hosted_batch, load, parts};
use crate::vulkan::{assert_silent, lavapipe};
use sinew_gpu::headless::Device as _;
use sinew_gpu::layout::{Batch, Plan, Stage};
use sinew_gpu::vulkan::barrier;
use sinew_gpu::vulkan::headless::{Commands, Device};

const HAZARD: &str = "SYNC-HAZARD-READ-AFTER-WRITE";

#[test]
fn gradients_then_palette_without_a_barrier_are_reported() {
    let device = lavapipe();
    record(&device, GOLDEN[0], &[Stage::Gradients, Stage::Palette], None);
    let messages = device.messages().unwrap();
    assert!(messages.iter().any(|message| message.contains(HAZARD)), "{messages:#?}");
}

#[test]
fn gradients_then_palette_with_a_barrier_pass() {
    let device = lavapipe();
    record(&device, GOLDEN[0], &[Stage::Gradients, Stage::Palette], Some(1));
    assert_silent(&device);
}

#[test]
fn each_stage_that_reads_another_is_reported_without_its_barrier() {
    for (bytes, first, second) in [
        (GOLDEN[0], Stage::Gradients, Stage::Palette),
        (GOLDEN[0], Stage::Gradients, Stage::Confidence),
        (GOLDEN[0], Stage::Palette, Stage::Skin),
        (GOLDEN[1], Stage::Joints, Stage::Skin),
        (GOLDEN[1], Stage::Correction, Stage::Confidence),
        (GOLDEN[1], Stage::Correction, Stage::Skin),
        (GOLDEN_STRETCH[0], Stage::Polar, Stage::Confidence),
    ] {
        let device = lavapipe();
        record(&device, bytes, &[first, second], Some(1));
        assert_silent(&device);
        record(&device, bytes, &[first, second], None);
        let messages = device.messages().unwrap();
        assert!(
            messages.iter().any(|message| message.contains(HAZARD)),
            "{first:?}, {second:?}: {messages:#?}"
        );
    }
}

#[test]
fn consecutive_records_need_no_barrier_between_them() {
    let device = lavapipe();
    for bytes in GOLDEN {
        let model = load(bytes);
        let (envelope, skin) = parts(&model);
        for batch in [Batch::skinned(&envelope, &skin, 3), hosted_batch(&envelope, &skin, 3)] {
            let plan = Plan::new(&model, &envelope, &batch, &device.limits()).unwrap();
            let batch = device.batch(model.blob(), &plan).unwrap();
            assert!(plan.stages().len() > 3 && skin.vertex_len() > 0);
            let commands = Commands::new(&device).unwrap();
            // SAFETY: the command buffer is new; the batch is valid, and nothing else uses it.
            unsafe {
                commands.submit(|device, commands| {
                    batch.bound().record(device, commands, 3)?;
                    Ok(batch.bound().record(device, commands, 3)?)
                })
            }
            .unwrap();
        }
    }
    assert_silent(&device);
}

/// Skins and confidences need no barrier between them, in either order.
#[test]
fn skin_and_confidence_do_not_wait_for_each_other() {
    let device = lavapipe();
    for bytes in GOLDEN {
        for stages in [[Stage::Skin, Stage::Confidence], [Stage::Confidence, Stage::Skin]] {
            record(&device, bytes, &stages, None);
        }
    }
    assert_silent(&device);
}

/// Records stages in one command buffer, with a barrier before stage `guarded`.
fn record(headless: &Device, bytes: &[u8], stages: &[Stage], guarded: Option<usize>) {
    let model = load(bytes);
    let (envelope, skin) = parts(&model);
    let batch = Batch::skinned(&envelope, &skin, 3);
    let plan = Plan::new(&model, &envelope, &batch, &headless.limits()).unwrap();
    let batch = headless.batch(model.blob(), &plan).unwrap();
    let commands = Commands::new(headless).unwrap();
    let record = |device: &ash::Device, commands| {
        for (index, stage) in stages.iter().enumerate() {
            // SAFETY: as below, except for the barrier whose absence is tested.
            unsafe {
                if guarded == Some(index) {
                    barrier(device, commands);
                }
                batch.bound().record_stage(device, commands, *stage, 3)?;
            }
        }
        Ok(())
    };
    // SAFETY: the command buffer is new, and lavapipe runs dispatches one after another.
    unsafe { commands.submit(record) }.unwrap();
}
