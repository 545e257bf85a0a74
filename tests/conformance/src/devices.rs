//! The devices of this machine, by both APIs.

use log::{Level, LevelFilter, Log, Metadata, Record};
use sinew_gpu::headless::{Device, DeviceInfo, HeadlessError};
use sinew_gpu::vulkan::headless as vulkan;
use sinew_gpu::wgpu::headless as wgpu;
use std::sync::atomic::{AtomicUsize, Ordering};

/// The driver of lavapipe, which is required wherever tests run.
pub const LAVAPIPE: &str = "llvmpipe";

/// Lists the devices of both APIs: of every driver and name one.
///
/// # Errors
/// [`HeadlessError::Missing`]: there is no Vulkan loader, and no device for wgpu either.
pub fn list() -> Result<Vec<DeviceInfo>, HeadlessError> {
    let mut all = wgpu::devices();
    match vulkan::devices() {
        Ok(list) => all.extend(list),
        Err(error) if all.is_empty() => return Err(error),
        Err(_) => {}
    }
    let mut out: Vec<DeviceInfo> = Vec::new();
    for info in all {
        if !out.iter().any(|own| same(own, &info)) {
            out.push(info);
        }
    }
    Ok(out)
}

/// Opens a device; with validation, through the layers, whose messages are counted.
///
/// # Errors
/// [`HeadlessError`]
pub fn open(info: &DeviceInfo, validation: bool) -> Result<Box<dyn Device>, HeadlessError> {
    let wanted = |own: &DeviceInfo| same(own, info);
    Ok(match info.api {
        "wgpu" => Box::new(wgpu::Device::open(wanted, &info.driver, validation)?),
        _ => Box::new(vulkan::Device::open(wanted, &info.driver, validation)?),
    })
}

fn same(a: &DeviceInfo, b: &DeviceInfo) -> bool {
    a.api == b.api && a.driver == b.driver && a.name == b.name
}

/// What wgpu's validation says goes to `log`: a logger that counts warnings and errors, but for one.
pub struct Counter;

/// What older layers say of every shader that tells it was WGSL, which SPIR-V registered later.
const TOO_OLD: &str = "SPIR-V module not valid: Invalid source language operand: 10";

static MESSAGES: AtomicUsize = AtomicUsize::new(0);

impl Counter {
    /// Makes it the process's logger; once it is, nothing happens.
    pub fn install() {
        if log::set_logger(&Self).is_ok() {
            log::set_max_level(LevelFilter::Warn);
        }
    }

    /// Returns the messages so far.
    pub fn message_len() -> usize {
        MESSAGES.load(Ordering::SeqCst)
    }
}

impl Log for Counter {
    fn enabled(&self, metadata: &Metadata<'_>) -> bool {
        metadata.level() <= Level::Warn
    }

    fn log(&self, record: &Record<'_>) {
        let text = record.args().to_string();
        // Lines that begin so tell more of the message before.
        let counts = !text.starts_with('\t') && !text.contains(TOO_OLD);
        if counts && self.enabled(record.metadata()) {
            MESSAGES.fetch_add(1, Ordering::SeqCst);
            eprintln!("{}: {text}", record.target());
        }
    }

    fn flush(&self) {}
}
