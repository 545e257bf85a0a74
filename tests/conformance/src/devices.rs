//! The devices of this machine, through both APIs.

use log::{Level, LevelFilter, Log, Metadata, Record};
use sinew_gpu::headless::{Device, DeviceInfo, HeadlessError};
use sinew_gpu::vulkan::headless as vulkan;
use sinew_gpu::wgpu::headless as wgpu;
use std::sync::atomic::{AtomicUsize, Ordering};

/// The driver of lavapipe, which is required on every machine that runs tests.
pub const LAVAPIPE: &str = "llvmpipe";

/// Lists the devices of both APIs, one for each driver and name.
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

/// Opens a device; `validation` turns on the validation layers and counts their messages.
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

/// A logger that counts warnings and errors, except for one message. wgpu's validation reports to
/// `log`.
pub struct Counter;

/// Message of older layers about every shader that is marked as compiled from WGSL; SPIR-V
/// registered that mark later.
const TOO_OLD: &str = "SPIR-V module not valid: Invalid source language operand: 10";

static MESSAGES: AtomicUsize = AtomicUsize::new(0);

impl Counter {
    /// Installs this logger for the process; later calls have no effect.
    pub fn install() {
        if log::set_logger(&Self).is_ok() {
            log::set_max_level(LevelFilter::Warn);
        }
    }

    /// Returns the number of messages so far.
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
        // Lines that start with a tab continue the message before.
        let counts = !text.starts_with('\t') && !text.contains(TOO_OLD);
        if counts && self.enabled(record.metadata()) {
            MESSAGES.fetch_add(1, Ordering::SeqCst);
            eprintln!("{}: {text}", record.target());
        }
    }

    fn flush(&self) {}
}
