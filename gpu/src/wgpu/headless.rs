//! A device without a window or an engine: opens it, allocates, submits and waits.

use super::bound::{Bound, Buffers};
use super::error::{Error, scoped};
use super::pipelines::{Pipelines, limits, usage};
use crate::headless::{self, DeviceInfo, HeadlessError, refused};
use crate::layout::{DeviceLimits, LayoutError, Plan, Resource, Stage};
use ::wgpu::{
    Adapter, Backends, Buffer, BufferDescriptor, BufferUsages, CommandEncoder,
    CommandEncoderDescriptor, DeviceDescriptor, DeviceType, Instance, InstanceDescriptor,
    InstanceFlags, Limits, MapMode, PollType, Queue,
};
use std::sync::{Arc, Mutex, OnceLock, PoisonError, mpsc};
use std::time::{Duration, Instant};

/// Vulkan if the build has it, so that both APIs can be compared on one driver.
const BACKENDS: Backends = if Instance::enabled_backend_features().contains(Backends::VULKAN) {
    Backends::VULKAN
} else {
    Backends::PRIMARY
};

/// Flags that send the layer's messages to `log`. wgpu subscribes to the layer only with DEBUG.
/// DEBUG also marks shaders as compiled from WGSL, and layers of 1.3.239 and older reject that
/// mark. Labels are discarded, because some versions reject labels as well.
const VALIDATING: InstanceFlags =
    InstanceFlags::VALIDATION.union(InstanceFlags::DEBUG).union(InstanceFlags::DISCARD_HAL_LABELS);

/// An open device, at exactly [`Limits::downlevel_defaults`].
#[derive(Debug)]
pub struct Device {
    info: DeviceInfo,
    device: ::wgpu::Device,
    queue: Queue,
    lost: Arc<Mutex<Option<String>>>,
    pipelines: OnceLock<Pipelines>,
}

/// Lists the devices of the machine.
pub fn devices() -> Vec<DeviceInfo> {
    adapters(InstanceFlags::empty()).into_iter().map(|(_, info)| info).collect()
}

impl Device {
    /// Opens the first device that `wanted` accepts; `name` describes the request in words.
    /// `validation` turns on the API's validation layer if it is installed; the layer's messages go
    /// to `log`.
    ///
    /// # Errors
    /// - [`HeadlessError::NoDevice`]
    /// - [`HeadlessError::Refused`]: the device cannot be opened.
    pub fn open(
        wanted: impl Fn(&DeviceInfo) -> bool,
        name: &str,
        validation: bool,
    ) -> Result<Self, HeadlessError> {
        let flags = if validation { VALIDATING } else { InstanceFlags::empty() };
        let adapters = adapters(flags);
        let found = adapters.iter().map(|(_, info)| info.driver.clone()).collect();
        let own = adapters.into_iter().find(|(_, info)| wanted(info));
        let Some((adapter, info)) = own else {
            return Err(HeadlessError::NoDevice { api: "wgpu", wanted: name.to_owned(), found });
        };
        let opened = pollster::block_on(adapter.request_device(&DeviceDescriptor {
            label: Some("sinew headless"),
            required_limits: Limits::downlevel_defaults(),
            ..Default::default()
        }));
        let (device, queue) = opened.map_err(refused("opening the device"))?;
        let lost = Arc::new(Mutex::new(None));
        let reported = Arc::clone(&lost);
        device.set_device_lost_callback(move |reason, message| {
            *reported.lock().unwrap_or_else(PoisonError::into_inner) =
                Some(format!("{reason:?} {message}").trim_end().to_owned());
        });
        Ok(Self { info, device, queue, lost, pipelines: OnceLock::new() })
    }

    /// Opens the first device of a driver: `llvmpipe` (lavapipe), `SwiftShader driver`, `NVIDIA`,
    /// ...
    ///
    /// # Errors
    /// As [`Device::open`].
    pub fn of_driver(driver: &str, validation: bool) -> Result<Self, HeadlessError> {
        Self::open(|info| info.driver == driver, driver, validation)
    }

    /// Returns wgpu's device.
    pub fn device(&self) -> &::wgpu::Device {
        &self.device
    }

    /// Returns wgpu's queue.
    pub fn queue(&self) -> &Queue {
        &self.queue
    }

    /// Submits the commands that a closure records, and waits for completion.
    ///
    /// # Errors
    /// - [`HeadlessError::Lost`]
    /// - The closure's own error.
    pub fn submit(
        &self,
        record: impl FnOnce(&mut CommandEncoder) -> Result<(), HeadlessError>,
    ) -> Result<(), HeadlessError> {
        self.check_alive()?;
        let mut encoder = self.device.create_command_encoder(&CommandEncoderDescriptor::default());
        record(&mut encoder)?;
        self.queue.submit([encoder.finish()]);
        self.wait()
    }

    /// Reads a buffer's floats through a mapped copy; the buffer must have `COPY_SRC`.
    ///
    /// # Errors
    /// - [`HeadlessError::Lost`]
    /// - [`HeadlessError::Refused`]: the copy cannot be mapped.
    pub fn read(&self, buffer: &Buffer) -> Result<Vec<f32>, HeadlessError> {
        let bytes = self.read_bytes(buffer)?;
        Ok(bytes.as_chunks::<4>().0.iter().map(|le| f32::from_le_bytes(*le)).collect())
    }

    /// Reads a buffer's bytes through a mapped copy; the buffer must have `COPY_SRC`.
    ///
    /// # Errors
    /// As [`Device::read`].
    pub fn read_bytes(&self, buffer: &Buffer) -> Result<Vec<u8>, HeadlessError> {
        let copy = self.buffer(buffer.size(), BufferUsages::MAP_READ | BufferUsages::COPY_DST)?;
        self.submit(|encoder| {
            encoder.copy_buffer_to_buffer(buffer, 0, &copy, 0, buffer.size());
            Ok(())
        })?;
        const MAPPING: &str = "mapping a buffer";
        let (send, receive) = mpsc::channel();
        // Sending fails only if this function has returned.
        copy.map_async(MapMode::Read, .., move |mapped| drop(send.send(mapped)));
        self.wait()?;
        receive.recv().map_err(refused(MAPPING))?.map_err(refused(MAPPING))?;
        let view = copy.get_mapped_range(..).map_err(refused(MAPPING))?;
        Ok(view.to_vec())
    }

    fn wait(&self) -> Result<(), HeadlessError> {
        let polled = self.device.poll(PollType::wait_indefinitely());
        self.check_alive()?;
        polled.map(drop).map_err(refused("waiting for the device"))
    }

    fn check_alive(&self) -> Result<(), HeadlessError> {
        let lost = self.lost.lock().unwrap_or_else(PoisonError::into_inner);
        lost.clone().map_or(Ok(()), |why| Err(HeadlessError::Lost(why)))
    }

    fn buffer(&self, size: u64, usage: BufferUsages) -> Result<Buffer, HeadlessError> {
        self.check_alive()?;
        let descriptor = BufferDescriptor { label: None, size, usage, mapped_at_creation: false };
        Ok(scoped(&self.device, "a buffer", || self.device.create_buffer(&descriptor))?)
    }

    fn pipelines(&self) -> Result<&Pipelines, HeadlessError> {
        self.check_alive()?;
        if let Some(own) = self.pipelines.get() {
            return Ok(own);
        }
        let made = Pipelines::new(&self.device, Stage::ALL)?;
        Ok(self.pipelines.get_or_init(|| made))
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
        for (resource, own) in Resource::ALL.into_iter().zip(&mut own) {
            let usage = usage(resource) | BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
            if plan.bytes(resource) > 0 {
                *own = Some(self.buffer(plan.bytes(resource), usage)?);
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
        // Copies have whole words.
        blob.resize(plan.bytes(Resource::Blob) as usize, 0);
        uploaded.write_bytes(Resource::Blob, 0, &blob)?;
        Ok(Box::new(uploaded))
    }

    fn message_len(&self) -> Option<usize> {
        // The messages go to `log`, whose only logger belongs to the program.
        None
    }
}

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

fn adapters(flags: InstanceFlags) -> Vec<(Adapter, DeviceInfo)> {
    let instance = Instance::new(InstanceDescriptor {
        backends: BACKENDS,
        flags,
        ..InstanceDescriptor::new_without_display_handle()
    });
    let adapters = pollster::block_on(instance.enumerate_adapters(BACKENDS));
    let named = adapters.into_iter().map(|adapter| {
        let info = adapter.get_info();
        let info = DeviceInfo {
            api: "wgpu",
            name: info.name,
            driver: info.driver,
            driver_info: info.driver_info,
            software: info.device_type == DeviceType::Cpu,
        };
        (adapter, info)
    });
    named.collect()
}

impl From<Error> for HeadlessError {
    fn from(error: Error) -> Self {
        match error {
            Error::Layout(error) => error.into(),
            _ => refused("preparing a batch")(error),
        }
    }
}
