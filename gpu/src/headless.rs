//! What the two headless helpers have in common: they find a device, allocate, submit and wait, which
//! the rest of this crate leaves to the host. For tests, examples, and tools without an engine.

use crate::layout::{DeviceLimits, LayoutError, Plan, Resource, Stage};
use std::time::Duration;
use thiserror::Error;

/// A device as its driver names it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DeviceInfo {
    /// The API it is driven by: `wgpu` or `vulkan`.
    pub api: &'static str,
    /// The device's name.
    pub name: String,
    /// The driver's name: `llvmpipe` (lavapipe), `SwiftShader driver`, `NVIDIA`, ...
    pub driver: String,
    /// The driver's version or build, as it tells it.
    pub driver_info: String,
    /// Whether it is a program on the CPU.
    pub software: bool,
}

/// A device that has been opened, at the limits of [`DeviceLimits::DOWNLEVEL`].
pub trait Device {
    /// Returns which it is.
    fn info(&self) -> &DeviceInfo;

    /// Returns the limits to plan by.
    fn limits(&self) -> DeviceLimits;

    /// Allocates every buffer of a batch and uploads the params and the model's blob. Other buffers are
    /// zero at first.
    ///
    /// # Errors
    /// [`HeadlessError`]
    fn upload(&self, blob: &[u8], plan: &Plan) -> Result<Box<dyn Uploaded + '_>, HeadlessError>;

    /// Counts the messages of validation layers so far; `None` where they cannot be counted here.
    fn message_len(&self) -> Option<usize>;
}

/// The buffers of a batch on a device.
pub trait Uploaded {
    /// Writes floats into a resource's buffer, from the given float on.
    ///
    /// # Errors
    /// [`HeadlessError`]
    fn write(
        &mut self,
        resource: Resource,
        first: usize,
        floats: &[f32],
    ) -> Result<(), HeadlessError>;

    /// Evaluates the first `instance_len` instances: all stages of the plan in one submission; waits.
    ///
    /// # Errors
    /// [`HeadlessError`]
    fn run(&mut self, instance_len: usize) -> Result<(), HeadlessError>;

    /// Runs one stage alone, on what the buffers hold; waits.
    ///
    /// # Errors
    /// [`HeadlessError`]
    fn run_stage(&mut self, stage: Stage, instance_len: usize) -> Result<(), HeadlessError>;

    /// Measures how long a stage takes on what the buffers hold, `repeat_len` times in one submission.
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

/// Why a headless helper cannot go on.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum HeadlessError {
    /// There is no device of the kind asked for.
    #[error("no {api} device {wanted}; there are: {}", if .found.is_empty() { "none".to_owned() } else { .found.join(", ") })]
    NoDevice {
        /// `wgpu` or `vulkan`.
        api: &'static str,
        /// What was asked for.
        wanted: String,
        /// Drivers of the devices that there are.
        found: Vec<String>,
    },
    /// The Vulkan loader or a layer is not installed.
    #[error("{what} is not installed: {detail}")]
    Missing {
        /// Loader or layer.
        what: &'static str,
        /// What the system says.
        detail: String,
    },
    /// The device was lost.
    #[error("the device was lost: {0}")]
    Lost(String),
    /// The device refuses.
    #[error("{doing}: {detail}")]
    Refused {
        /// What was being done.
        doing: &'static str,
        /// What the API says.
        detail: String,
    },
    /// The batch cannot be evaluated.
    #[error(transparent)]
    Layout(#[from] LayoutError),
}
