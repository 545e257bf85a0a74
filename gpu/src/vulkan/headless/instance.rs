//! An instance of Vulkan 1.1, with or without validation, and the devices that it sees.

use super::error::while_doing;
use super::messages::{Messages, Messenger};
use crate::headless::{DeviceInfo, HeadlessError};
use ash::{Entry, Instance, ext, khr, vk};
use std::ffi::CStr;

const LAYER: &CStr = c"VK_LAYER_KHRONOS_validation";

/// An instance with what keeps its messages.
pub(super) struct Vulkan {
    pub(super) instance: Instance,
    validation: Option<(Messages, Messenger)>,
    /// Holds the loader's library.
    _entry: Entry,
}

impl Vulkan {
    pub(super) fn new(validation: bool) -> Result<Self, HeadlessError> {
        // SAFETY: the system's loader is what it says it is.
        let entry = unsafe { Entry::load() }.map_err(|error| HeadlessError::Missing {
            what: "the Vulkan loader",
            detail: format!("{error}; on Debian install libvulkan1 and mesa-vulkan-drivers"),
        })?;
        let messages = match validation {
            true => Some(validating(&entry)?),
            false => None,
        };
        let instance = create(&entry, messages.as_ref())?;
        let validation = match messages {
            None => None,
            // SAFETY: the instance has just been made, with the extension.
            Some(messages) => match unsafe { Messenger::new(&entry, &instance, &messages) } {
                Ok(messenger) => Some((messages, messenger)),
                Err(error) => {
                    // SAFETY: nothing has been made of it.
                    unsafe { instance.destroy_instance(None) };
                    return Err(error);
                }
            },
        };
        Ok(Self { instance, validation, _entry: entry })
    }

    /// Lists the messages; `None` without validation.
    pub(super) fn messages(&self) -> Option<Vec<String>> {
        self.validation.as_ref().map(|(messages, _)| messages.list())
    }

    /// Lists the devices that have compute, as the loader orders them.
    pub(super) fn devices(&self) -> Result<Vec<(vk::PhysicalDevice, DeviceInfo)>, HeadlessError> {
        // SAFETY: the instance is valid as long as self.
        let all = unsafe { self.instance.enumerate_physical_devices() }
            .map_err(while_doing("listing devices"))?;
        all.into_iter().map(|physical| Ok((physical, self.info(physical)?))).collect()
    }

    fn info(&self, physical: vk::PhysicalDevice) -> Result<DeviceInfo, HeadlessError> {
        // SAFETY: the device is this instance's.
        let own = unsafe { self.instance.get_physical_device_properties(physical) };
        // SAFETY: likewise.
        let extensions = unsafe { self.instance.enumerate_device_extension_properties(physical) }
            .map_err(while_doing("listing extensions"))?;
        let mut driver = vk::PhysicalDeviceDriverProperties::default();
        let told = own.api_version >= vk::API_VERSION_1_2
            || own.api_version >= vk::API_VERSION_1_1
                && has(&extensions, khr::driver_properties::NAME);
        if told {
            let mut all = vk::PhysicalDeviceProperties2::default().push_next(&mut driver);
            // SAFETY: instance and device are of 1.1 or later, and the device knows the structure.
            unsafe { self.instance.get_physical_device_properties2(physical, &mut all) };
        }
        let text = |text: Result<&CStr, _>| {
            text.map_or_else(|_| String::new(), |text| text.to_string_lossy().into_owned())
        };
        let (driver, driver_info) = match told {
            true => (text(driver.driver_name_as_c_str()), text(driver.driver_info_as_c_str())),
            false => {
                (format!("vendor {:#06x}", own.vendor_id), format!("{:#x}", own.driver_version))
            }
        };
        Ok(DeviceInfo {
            api: "vulkan",
            name: text(own.device_name_as_c_str()),
            driver,
            driver_info,
            software: own.device_type == vk::PhysicalDeviceType::CPU,
        })
    }
}

impl Drop for Vulkan {
    fn drop(&mut self) {
        // SAFETY: what is made of the instance is gone: only `Device` makes any, and ends before.
        unsafe {
            if let Some((_, messenger)) = &self.validation {
                messenger.destroy();
            }
            self.instance.destroy_instance(None);
        }
    }
}

/// Finds the validation layer and its extensions.
fn validating(entry: &Entry) -> Result<Messages, HeadlessError> {
    let missing = |detail: String| HeadlessError::Missing {
        what: "VK_LAYER_KHRONOS_validation",
        detail: format!("{detail}; on Debian install vulkan-validationlayers"),
    };
    // SAFETY: the entry is valid.
    let layers = unsafe { entry.enumerate_instance_layer_properties() }
        .map_err(while_doing("listing layers"))?;
    if !layers.iter().any(|layer| layer.layer_name_as_c_str() == Ok(LAYER)) {
        return Err(missing("there is no such layer".to_owned()));
    }
    // SAFETY: likewise, and the layer is there.
    let extensions = unsafe { entry.enumerate_instance_extension_properties(Some(LAYER)) }
        .map_err(while_doing("listing extensions"))?;
    for name in [ext::debug_utils::NAME, ext::validation_features::NAME] {
        if !has(&extensions, name) {
            return Err(missing(format!("the layer is without {}", name.to_string_lossy())));
        }
    }
    Ok(Messages::new())
}

fn create(entry: &Entry, messages: Option<&Messages>) -> Result<Instance, HeadlessError> {
    let application =
        vk::ApplicationInfo::default().application_name(c"sinew").api_version(vk::API_VERSION_1_1);
    let enabled = [vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION];
    let mut features = vk::ValidationFeaturesEXT::default().enabled_validation_features(&enabled);
    let layers = [LAYER.as_ptr()];
    let extensions = [ext::debug_utils::NAME.as_ptr(), ext::validation_features::NAME.as_ptr()];
    let mut messenger = messages.map(Messages::info);
    let mut info = vk::InstanceCreateInfo::default().application_info(&application);
    if let Some(messenger) = &mut messenger {
        info = info
            .enabled_layer_names(&layers)
            .enabled_extension_names(&extensions)
            .push_next(&mut features)
            .push_next(messenger);
    }
    // SAFETY: all that the description points to lives through the call.
    unsafe { entry.create_instance(&info, None) }.map_err(|result| match result {
        vk::Result::ERROR_INCOMPATIBLE_DRIVER => HeadlessError::Missing {
            what: "a Vulkan driver",
            detail: format!("{result}; on Debian install mesa-vulkan-drivers"),
        },
        _ => while_doing("making an instance")(result),
    })
}

fn has(extensions: &[vk::ExtensionProperties], name: &CStr) -> bool {
    extensions.iter().any(|extension| extension.extension_name_as_c_str() == Ok(name))
}
