//! A batch whose buffers the helper owns.

use super::super::bound::{Bound, barrier};
use super::device::Device;
use super::held::{Held, uploaded};
use super::memory::Memory;
use crate::headless::{self, DeviceInfo, HeadlessError, Uploaded};
use crate::layout::{DeviceLimits, Plan, Resource, Stage};
use std::time::{Duration, Instant};

/// A batch on a device, with its buffers in the device's own memory.
pub struct VulkanBatch<'d> {
    held: Held<'d>,
    bound: Bound,
}

impl<'d> VulkanBatch<'d> {
    fn new(device: &'d Device, blob: &[u8], plan: &Plan) -> Result<Self, HeadlessError> {
        let mut held = Held::new(device, plan)?;
        held.write(Resource::Params, 0, &plan.params())?;
        // Words are bound.
        let mut blob = blob.to_vec();
        blob.resize(blob.len().next_multiple_of(4), 0);
        held.write(Resource::Blob, 0, &blob)?;
        let pipelines = device.pipelines();
        let (sets, buffers) = (held.sets(plan)?, held.buffers());
        // SAFETY: buffers and sets have just been made for this plan, and live as long as the batch.
        let bound = unsafe { Bound::new(device.device(), pipelines, plan, &buffers, &sets) }?;
        Ok(Self { held, bound })
    }

    /// Returns what is recorded.
    pub fn bound(&self) -> &Bound {
        &self.bound
    }

    /// Returns a resource's buffer.
    ///
    /// # Errors
    /// [`crate::layout::LayoutError::Missing`]: the plan does not need it.
    pub fn memory(&self, resource: Resource) -> Result<&Memory<'d>, HeadlessError> {
        self.held.memory(resource)
    }
}

impl Uploaded for VulkanBatch<'_> {
    fn write(
        &mut self,
        resource: Resource,
        first: usize,
        floats: &[f32],
    ) -> Result<(), HeadlessError> {
        let bytes: Vec<u8> = floats.iter().flat_map(|float| float.to_le_bytes()).collect();
        self.held.write(resource, (first as u64).saturating_mul(4), &bytes)
    }

    fn run(&mut self, instance_len: usize) -> Result<(), HeadlessError> {
        self.held.submit(|device, commands| {
            uploaded(device, commands);
            // SAFETY: the command buffer is being recorded; the barrier above is what is asked for.
            Ok(unsafe { self.bound.record(device, commands, instance_len) }?)
        })
    }

    fn run_stage(&mut self, stage: Stage, instance_len: usize) -> Result<(), HeadlessError> {
        self.held.submit(|device, commands| {
            uploaded(device, commands);
            // SAFETY: likewise; the second barrier is for what other stages have written.
            unsafe {
                barrier(device, commands);
                Ok(self.bound.record_stage(device, commands, stage, instance_len)?)
            }
        })
    }

    fn time_stage(
        &mut self,
        stage: Stage,
        instance_len: usize,
        repeat_len: usize,
    ) -> Result<Duration, HeadlessError> {
        let start = Instant::now();
        self.held.submit(|device, commands| {
            uploaded(device, commands);
            for _ in 0..repeat_len {
                // SAFETY: as in `run_stage`.
                unsafe {
                    barrier(device, commands);
                    self.bound.record_stage(device, commands, stage, instance_len)?;
                }
            }
            Ok(())
        })?;
        Ok(start.elapsed())
    }

    fn read(&mut self, resource: Resource) -> Result<Vec<f32>, HeadlessError> {
        let bytes = self.held.read(resource)?;
        let words = bytes.as_chunks::<4>().0;
        Ok(words.iter().map(|word| f32::from_le_bytes(*word)).collect())
    }
}

impl Device {
    /// Allocates the buffers of a batch: [`headless::Device::upload`] with a type that shows more.
    ///
    /// # Errors
    /// [`HeadlessError`]
    pub fn batch(&self, blob: &[u8], plan: &Plan) -> Result<VulkanBatch<'_>, HeadlessError> {
        VulkanBatch::new(self, blob, plan)
    }
}

impl headless::Device for Device {
    fn info(&self) -> &DeviceInfo {
        &self.info
    }

    fn limits(&self) -> DeviceLimits {
        self.limits
    }

    fn upload(&self, blob: &[u8], plan: &Plan) -> Result<Box<dyn Uploaded + '_>, HeadlessError> {
        Ok(Box::new(self.batch(blob, plan)?))
    }

    fn message_len(&self) -> Option<usize> {
        self.messages().map(|messages| messages.len())
    }
}
