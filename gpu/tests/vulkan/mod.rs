//! The stages on raw Vulkan: compared with the CPU's bits, under validation, and with a host's
//! mistakes.

mod allocations;
mod barriers;
mod bits;
mod callbacks;
mod fake;
mod refusals;

use sinew_gpu::headless::{Device as _, HeadlessError};
use sinew_gpu::vulkan::headless::Device;

/// Opens lavapipe under the validation layer.
fn lavapipe() -> Device {
    opened(Device::of_driver("llvmpipe", true))
}

fn opened(device: Result<Device, HeadlessError>) -> Device {
    match device {
        Ok(device) => device,
        Err(error) => panic!(
            "{error}\nthis test needs lavapipe and the validation layer; on Debian: \
             apt-get install mesa-vulkan-drivers vulkan-validationlayers"
        ),
    }
}

/// Opens SwiftShader where `SINEW_DEVICES` asks for it, as `cargo xtask test --full` does.
fn swiftshader() -> Option<Device> {
    if std::env::var_os("SINEW_DEVICES").is_none() {
        eprintln!("not run on SwiftShader: SINEW_DEVICES is not set");
        return None;
    }
    let found = Device::of_driver("SwiftShader driver", true);
    if let Err(HeadlessError::NoDevice { found, .. }) = &found {
        let missing = format!(
            "not run on SwiftShader: the loader finds only {found:?}; VK_ADD_DRIVER_FILES adds it, \
             as vk_swiftshader_icd.json of chromium's folder"
        );
        assert!(std::env::var_os("CI").is_none(), "{missing}");
        eprintln!("{missing}");
        return None;
    }
    Some(opened(found))
}

/// Asserts that the validation layer has reported nothing.
fn assert_silent(device: &Device) {
    let messages = device.messages().unwrap();
    assert!(messages.is_empty(), "{:?} {messages:#?}", device.info());
}
