//! An instance of Vulkan 1.1, with or without validation: its devices, messages and errors.

use super::super::error::Error;
use crate::headless::{DeviceInfo, HeadlessError, refused};
use ash::{Entry, Instance, ext, ext::debug_utils, khr, vk};
use std::ffi::{CStr, c_void};
use std::sync::{Mutex, PoisonError};

const LAYER: &CStr = c"VK_LAYER_KHRONOS_validation";

/// An instance, with the messages of the validation layer.
pub(super) struct Vulkan {
    pub(super) instance: Instance,
    /// With validation, the messages so far, boxed because the layer holds their address.
    messages: Option<Box<Messages>>,
    /// The Vulkan object that passes messages on, until it is destroyed.
    messenger: Option<(debug_utils::Instance, vk::DebugUtilsMessengerEXT)>,
    /// Keeps the loader's library loaded.
    _entry: Entry,
}

impl Vulkan {
    pub(super) fn new(validation: bool) -> Result<Self, HeadlessError> {
        // SAFETY: the system's library is the Vulkan loader.
        let entry = unsafe { Entry::load() }.map_err(|error| HeadlessError::Missing {
            what: "the Vulkan loader",
            detail: format!("{error}; on Debian install libvulkan1 and mesa-vulkan-drivers"),
        })?;
        if validation {
            check_layer(&entry)?;
        }
        let messages = validation.then(Box::default);
        let instance = create(&entry, messages.as_deref())?;
        // From here on, a drop frees everything.
        let mut own = Self { instance, messages, messenger: None, _entry: entry };
        if let Some(messages) = &own.messages {
            let api = debug_utils::Instance::new(&own._entry, &own.instance);
            // SAFETY: the instance has just been made with the extension.
            let handle = unsafe { api.create_debug_utils_messenger(&messenger(messages), None) }
                .map_err(while_doing("making a messenger"))?;
            own.messenger = Some((api, handle));
        }
        Ok(own)
    }

    /// Lists the messages so far; `None` without validation.
    pub(super) fn messages(&self) -> Option<Vec<String>> {
        let messages = self.messages.as_ref()?;
        Some(messages.lock().unwrap_or_else(PoisonError::into_inner).clone())
    }

    /// Lists the devices, in the loader's order.
    pub(super) fn devices(&self) -> Result<Vec<(vk::PhysicalDevice, DeviceInfo)>, HeadlessError> {
        // SAFETY: the instance is valid as long as `self`.
        let all = unsafe { self.instance.enumerate_physical_devices() }
            .map_err(while_doing("listing devices"))?;
        all.into_iter().map(|physical| Ok((physical, self.info(physical)?))).collect()
    }

    fn info(&self, physical: vk::PhysicalDevice) -> Result<DeviceInfo, HeadlessError> {
        // SAFETY: the device belongs to this instance.
        let own = unsafe { self.instance.get_physical_device_properties(physical) };
        // SAFETY: as above.
        let extensions = unsafe { self.instance.enumerate_device_extension_properties(physical) }
            .map_err(while_doing("listing extensions"))?;
        let mut driver = vk::PhysicalDeviceDriverProperties::default();
        let has_properties = own.api_version >= vk::API_VERSION_1_2
            || own.api_version >= vk::API_VERSION_1_1
                && has(&extensions, khr::driver_properties::NAME);
        if has_properties {
            let mut all = vk::PhysicalDeviceProperties2::default().push_next(&mut driver);
            // SAFETY: instance and device are of 1.1 or later, and the device knows the structure.
            unsafe { self.instance.get_physical_device_properties2(physical, &mut all) };
        }
        let text = |text: Result<&CStr, _>| {
            text.map_or_else(|_| String::new(), |text| text.to_string_lossy().into_owned())
        };
        let (driver, driver_info) = match has_properties {
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
        // SAFETY: the instance's objects are gone: only `Device` makes any, and it is dropped
        // before.
        unsafe {
            if let Some((api, handle)) = &self.messenger {
                api.destroy_debug_utils_messenger(*handle, None);
            }
            self.instance.destroy_instance(None);
        }
    }
}

/// Checks that the validation layer and its extensions are installed.
fn check_layer(entry: &Entry) -> Result<(), HeadlessError> {
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
    // SAFETY: the entry is valid, and the layer is installed.
    let extensions = unsafe { entry.enumerate_instance_extension_properties(Some(LAYER)) }
        .map_err(while_doing("listing extensions"))?;
    for name in [ext::debug_utils::NAME, ext::validation_features::NAME] {
        if !has(&extensions, name) {
            return Err(missing(format!("the layer is without {}", name.to_string_lossy())));
        }
    }
    Ok(())
}

fn create(entry: &Entry, messages: Option<&Messages>) -> Result<Instance, HeadlessError> {
    let application =
        vk::ApplicationInfo::default().application_name(c"sinew").api_version(vk::API_VERSION_1_1);
    let enabled = [vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION];
    let mut features = vk::ValidationFeaturesEXT::default().enabled_validation_features(&enabled);
    let layers = [LAYER.as_ptr()];
    let extensions = [ext::debug_utils::NAME.as_ptr(), ext::validation_features::NAME.as_ptr()];
    let mut messenger = messages.map(messenger);
    let mut info = vk::InstanceCreateInfo::default().application_info(&application);
    if let Some(messenger) = &mut messenger {
        info = info
            .enabled_layer_names(&layers)
            .enabled_extension_names(&extensions)
            .push_next(&mut features)
            .push_next(messenger);
    }
    // SAFETY: all pointers in the description live through the call.
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

/// The messages of the validation layer.
type Messages = Mutex<Vec<String>>;

/// Describes a messenger of warnings and errors. The messenger must not outlive the messages.
fn messenger(messages: &Messages) -> vk::DebugUtilsMessengerCreateInfoEXT<'static> {
    use vk::{
        DebugUtilsMessageSeverityFlagsEXT as Severity, DebugUtilsMessageTypeFlagsEXT as Type,
    };
    let own: *const Messages = messages;
    vk::DebugUtilsMessengerCreateInfoEXT::default()
        .message_severity(Severity::WARNING | Severity::ERROR)
        // No general messages: the loader sends them about drivers that are not in use.
        .message_type(Type::VALIDATION | Type::PERFORMANCE)
        .pfn_user_callback(Some(receive))
        .user_data(own.cast_mut().cast())
}

/// Stores a message. Returns `FALSE`, as Vulkan requires, so that the call goes on.
unsafe extern "system" fn receive(
    _: vk::DebugUtilsMessageSeverityFlagsEXT,
    _: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    messages: *mut c_void,
) -> vk::Bool32 {
    // SAFETY: the layer passes valid data, and the address that `messenger` gave.
    let (data, messages) = unsafe { (&*data, &*messages.cast::<Messages>()) };
    let text = [data.p_message_id_name, data.p_message].map(|text| {
        if text.is_null() {
            return String::new();
        }
        // SAFETY: texts end with nul.
        unsafe { CStr::from_ptr(text) }.to_string_lossy().into_owned()
    });
    messages.lock().unwrap_or_else(PoisonError::into_inner).push(text.join(": "));
    vk::FALSE
}

/// Returns a function that converts a result of the step `doing` into an error.
pub(super) fn while_doing(doing: &'static str) -> impl Fn(vk::Result) -> HeadlessError {
    move |result| match result {
        vk::Result::ERROR_DEVICE_LOST => HeadlessError::Lost(doing.to_owned()),
        _ => refused(doing)(result),
    }
}

impl From<Error> for HeadlessError {
    fn from(error: Error) -> Self {
        match error {
            Error::Layout(error) => Self::Layout(error),
            Error::Vulkan { doing, result } => while_doing(doing)(result),
            Error::NoPipeline { .. } | Error::NotPlanned { .. } | Error::Sets { .. } => {
                refused("preparing or recording a batch")(error)
            }
        }
    }
}
