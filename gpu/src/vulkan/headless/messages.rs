//! What validation layers say, kept.

use super::error::while_doing;
use crate::headless::HeadlessError;
use ash::{Entry, Instance, ext::debug_utils, vk};
use std::ffi::{CStr, c_void};
use std::sync::{Mutex, PoisonError};

/// The messages so far. It stays where it is: layers hold its address.
pub(super) struct Messages(Box<Mutex<Vec<String>>>);

/// What hands messages over, until it is destroyed.
pub(super) struct Messenger {
    api: debug_utils::Instance,
    handle: vk::DebugUtilsMessengerEXT,
}

impl Messages {
    pub(super) fn new() -> Self {
        Self(Box::new(Mutex::new(Vec::new())))
    }

    /// Describes a messenger of warnings and errors, which must not outlive this.
    pub(super) fn info(&self) -> vk::DebugUtilsMessengerCreateInfoEXT<'static> {
        let own: *const Mutex<_> = &*self.0;
        vk::DebugUtilsMessengerCreateInfoEXT::default()
            .message_severity(
                vk::DebugUtilsMessageSeverityFlagsEXT::WARNING
                    | vk::DebugUtilsMessageSeverityFlagsEXT::ERROR,
            )
            // What is general comes from the loader, about drivers that are not asked for.
            .message_type(
                vk::DebugUtilsMessageTypeFlagsEXT::VALIDATION
                    | vk::DebugUtilsMessageTypeFlagsEXT::PERFORMANCE,
            )
            .pfn_user_callback(Some(receive))
            .user_data(own.cast_mut().cast())
    }

    pub(super) fn list(&self) -> Vec<String> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

impl Messenger {
    /// # Safety
    /// The instance must be valid and have the extension; the messages must outlive the messenger.
    pub(super) unsafe fn new(
        entry: &Entry,
        instance: &Instance,
        messages: &Messages,
    ) -> Result<Self, HeadlessError> {
        let api = debug_utils::Instance::new(entry, instance);
        // SAFETY: as our own caller promises.
        let handle = unsafe { api.create_debug_utils_messenger(&messages.info(), None) }
            .map_err(while_doing("making a messenger"))?;
        Ok(Self { api, handle })
    }

    /// # Safety
    /// The instance must be valid.
    pub(super) unsafe fn destroy(&self) {
        // SAFETY: as our own caller promises.
        unsafe { self.api.destroy_debug_utils_messenger(self.handle, None) };
    }
}

/// Keeps a message; as Vulkan asks, lets the call go on.
unsafe extern "system" fn receive(
    _: vk::DebugUtilsMessageSeverityFlagsEXT,
    _: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    messages: *mut c_void,
) -> vk::Bool32 {
    // SAFETY: the layer hands over its data, and the address that `info` gave it.
    let (data, messages) = unsafe { (&*data, &*messages.cast::<Mutex<Vec<String>>>()) };
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
