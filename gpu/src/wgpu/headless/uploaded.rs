//! A batch on a device.

use super::super::bound::{Bound, Buffers};
use super::super::pipelines::limits;
use super::device::Device;
use crate::headless::{self, DeviceInfo, HeadlessError};
use crate::layout::{DeviceLimits, LayoutError, Plan, Resource, Stage};
use ::wgpu::{Buffer, BufferUsages};
use std::time::{Duration, Instant};

/// The buffers of a batch.
struct Uploaded<'a> {
    device: &'a Device,
    bound: Bound,
    buffers: [Option<Buffer>; Resource::ALL.len()],
}

impl Uploaded<'_> {
    fn buffer(&self, resource: Resource) -> Result<&Buffer, HeadlessError> {
        let own = self.buffers[resource as usize].as_ref();
        own.ok_or(LayoutError::Missing { resource }.into())
    }

    fn write_bytes(
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

impl headless::Device for Device {
    fn info(&self) -> &DeviceInfo {
        &self.info
    }

    fn limits(&self) -> DeviceLimits {
        limits(&self.device().limits())
    }

    fn upload(
        &self,
        blob: &[u8],
        plan: &Plan,
    ) -> Result<Box<dyn headless::Uploaded + '_>, HeadlessError> {
        let mut own: [Option<Buffer>; Resource::ALL.len()] = Default::default();
        for resource in Resource::ALL {
            let usage = match resource {
                Resource::Params => BufferUsages::UNIFORM,
                _ => BufferUsages::STORAGE,
            };
            let usage = usage | BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
            if plan.bytes(resource) > 0 {
                own[resource as usize] = Some(self.buffer(plan.bytes(resource), usage)?);
            }
        }
        let mut buffers = Buffers::new();
        for (resource, buffer) in Resource::ALL.into_iter().zip(&own) {
            if let Some(buffer) = buffer {
                buffers = buffers.with(resource, buffer, 0);
            }
        }
        let bound = Bound::new(self.pipelines()?, plan, &buffers)?;
        let uploaded = Uploaded { device: self, bound, buffers: own };
        uploaded.write_bytes(Resource::Params, 0, &plan.params())?;
        let mut blob = blob.to_vec();
        // Copies are of whole words.
        blob.resize(plan.bytes(Resource::Blob) as usize, 0);
        uploaded.write_bytes(Resource::Blob, 0, &blob)?;
        Ok(Box::new(uploaded))
    }

    fn message_len(&self) -> Option<usize> {
        // They go to `log`, whose one logger is the program's.
        None
    }
}
