//! The interface of the two `headless` modules: open a device, allocate, submit and wait. The rest
//! of this crate leaves these steps to the host. For tests, examples, and tools without an engine.

use crate::layout::{DeviceLimits, LayoutError, Plan, Resource, Stage};
use std::time::Duration;
use thiserror::Error;

/// A device, as its driver describes it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DeviceInfo {
    /// The API that drives the device: `wgpu` or `vulkan`.
    pub api: &'static str,
    /// The device's name.
    pub name: String,
    /// The driver's name: `llvmpipe` (lavapipe), `SwiftShader driver`, `NVIDIA`, ...
    pub driver: String,
    /// The driver's version or build, as the driver reports it.
    pub driver_info: String,
    /// Whether the device is a program on the CPU.
    pub software: bool,
}

/// An open device, at the limits of [`DeviceLimits::DOWNLEVEL`].
pub trait Device {
    /// Returns the description of the device.
    fn info(&self) -> &DeviceInfo;

    /// Returns the limits to plan by.
    fn limits(&self) -> DeviceLimits;

    /// Allocates every buffer of a batch, and uploads the params and the model's blob. All other
    /// buffers start as zeros.
    ///
    /// # Errors
    /// [`HeadlessError`]
    fn upload(&self, blob: &[u8], plan: &Plan) -> Result<Box<dyn Uploaded + '_>, HeadlessError>;

    /// Counts the messages of validation layers so far; `None` if this device cannot count them.
    fn message_len(&self) -> Option<usize>;
}

/// The buffers of a batch on a device.
pub trait Uploaded {
    /// Writes floats into a resource's buffer, starting at float `first`.
    ///
    /// # Errors
    /// [`HeadlessError`]
    fn write(
        &mut self,
        resource: Resource,
        first: usize,
        floats: &[f32],
    ) -> Result<(), HeadlessError>;

    /// Evaluates the first `instance_len` instances: runs all stages of the plan in one submission,
    /// and waits.
    ///
    /// # Errors
    /// [`HeadlessError`]
    fn run(&mut self, instance_len: usize) -> Result<(), HeadlessError>;

    /// Runs one stage alone on the present content of the buffers, and waits.
    ///
    /// # Errors
    /// [`HeadlessError`]
    fn run_stage(&mut self, stage: Stage, instance_len: usize) -> Result<(), HeadlessError> {
        self.time_stage(stage, instance_len, 1).map(drop)
    }

    /// Measures the time of a stage on the present content of the buffers, run `repeat_len` times
    /// in one submission.
    ///
    /// # Errors
    /// [`HeadlessError`]
    fn time_stage(
        &mut self,
        stage: Stage,
        instance_len: usize,
        repeat_len: usize,
    ) -> Result<Duration, HeadlessError>;

    /// Reads the whole of a resource's buffer.
    ///
    /// # Errors
    /// [`HeadlessError`]
    fn read(&mut self, resource: Resource) -> Result<Vec<f32>, HeadlessError>;
}

/// Errors of the headless devices.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum HeadlessError {
    /// No device matches the request.
    #[error("no {api} device {wanted}; there are: {}", if .found.is_empty() { "none".to_owned() } else { .found.join(", ") })]
    NoDevice {
        /// `wgpu` or `vulkan`.
        api: &'static str,
        /// Device that was requested.
        wanted: String,
        /// Drivers of the devices that were found.
        found: Vec<String>,
    },
    /// The Vulkan loader or a layer is not installed.
    #[error("{what} is not installed: {detail}")]
    Missing {
        /// The loader or the layer.
        what: &'static str,
        /// The system's message.
        detail: String,
    },
    /// The device was lost.
    #[error("the device was lost: {0}")]
    Lost(String),
    /// The device reports an error.
    #[error("{doing}: {detail}")]
    Refused {
        /// The step that failed.
        doing: &'static str,
        /// The API's message.
        detail: String,
    },
    /// The batch cannot be evaluated.
    #[error(transparent)]
    Layout(#[from] LayoutError),
}

/// Returns a function that makes an error of the step `doing` from the API's message.
#[cfg(any(feature = "vulkan", feature = "wgpu"))]
pub(crate) fn refused<E: ToString>(doing: &'static str) -> impl Fn(E) -> HeadlessError {
    move |error| HeadlessError::Refused { doing, detail: error.to_string() }
}
