//! A batch on a device.

use super::Device;
use crate::headless::{self, HeadlessError};
use crate::layout::{LayoutError, Resource, Stage};
use crate::wgpu::Bound;
use ::wgpu::Buffer;
use std::time::{Duration, Instant};

/// The buffers of a batch.
pub(super) struct Uploaded<'a> {
    pub(super) device: &'a Device,
    pub(super) bound: Bound,
    pub(super) buffers: [Option<Buffer>; Resource::ALL.len()],
}

impl Uploaded<'_> {
    fn buffer(&self, resource: Resource) -> Result<&Buffer, HeadlessError> {
        let own = self.buffers[resource as usize].as_ref();
        own.ok_or(LayoutError::Missing { resource }.into())
    }

    pub(super) fn write_bytes(
        &self,
        resource: Resource,
        offset: u64,
        bytes: &[u8],
    ) -> Result<(), HeadlessError> {
        self.device.check_alive()?;
        let buffer = self.buffer(resource)?;
        let (least, found) = (offset.saturating_add(bytes.len() as u64), buffer.size());
        if least > found {
            return Err(LayoutError::TooShort { resource, least, found }.into());
        }
        self.device.queue.write_buffer(buffer, offset, bytes);
        Ok(())
    }
}

impl headless::Uploaded for Uploaded<'_> {
    fn write(
        &mut self,
        resource: Resource,
        first: usize,
        floats: &[f32],
    ) -> Result<(), HeadlessError> {
        let bytes: Vec<u8> = floats.iter().flat_map(|x| x.to_le_bytes()).collect();
        self.write_bytes(resource, 4 * first as u64, &bytes)
    }

    fn run(&mut self, instance_len: usize) -> Result<(), HeadlessError> {
        self.device.submit(|encoder| Ok(self.bound.encode(encoder, instance_len)?))
    }

    fn run_stage(&mut self, stage: Stage, instance_len: usize) -> Result<(), HeadlessError> {
        self.device.submit(|encoder| Ok(self.bound.encode_stage(encoder, stage, instance_len)?))
    }

    fn time_stage(
        &mut self,
        stage: Stage,
        instance_len: usize,
        repeat_len: usize,
    ) -> Result<Duration, HeadlessError> {
        let start = Instant::now();
        self.device.submit(|encoder| {
            for _ in 0..repeat_len {
                self.bound.encode_stage(encoder, stage, instance_len)?;
            }
            Ok(())
        })?;
        Ok(start.elapsed())
    }

    fn read(&mut self, resource: Resource) -> Result<Vec<f32>, HeadlessError> {
        self.device.read(self.buffer(resource)?)
    }
}
