//! A fake device: counts the objects made and destroyed and the commands recorded, and fails at a
//! chosen call.

use ash::vk::{self, Handle};
use std::cell::RefCell;
use std::collections::BTreeSet;
use std::ffi::{CStr, c_void};

thread_local! {
    static SEEN: RefCell<Seen> = const { RefCell::new(Seen::NONE) };
}

/// Calls that a thread's device has received.
#[derive(Clone, Debug)]
pub(crate) struct Seen {
    /// Objects that have been made and not destroyed.
    pub(crate) live: BTreeSet<u64>,
    /// Number of calls that make an object.
    pub(crate) made: usize,
    /// Index of the making call that fails.
    pub(crate) fails_at: Option<usize>,
    /// The callbacks of each call that makes or destroys.
    pub(crate) callbacks: Vec<*const vk::AllocationCallbacks<'static>>,
    /// Names of calls that write sets or record commands, in order.
    pub(crate) recorded: Vec<&'static str>,
}

impl Seen {
    const NONE: Self = Self {
        live: BTreeSet::new(),
        made: 0,
        fails_at: None,
        callbacks: Vec::new(),
        recorded: Vec::new(),
    };

    fn make(&mut self, callbacks: *const vk::AllocationCallbacks<'static>) -> Option<u64> {
        self.callbacks.push(callbacks);
        self.made += 1;
        if self.fails_at == Some(self.made - 1) {
            return None;
        }
        self.live.insert(self.made as u64);
        Some(self.made as u64)
    }
}

/// Makes a new device for this thread.
pub(crate) fn device(fails_at: Option<usize>) -> ash::Device {
    SEEN.set(Seen { fails_at, ..Seen::NONE });
    // SAFETY: each function has the type of its name; ash panics for all others.
    unsafe { ash::Device::load_with(function, vk::Device::from_raw(1)) }
}

/// Returns the calls that the thread's device has received.
pub(crate) fn seen() -> Seen {
    SEEN.with_borrow(Clone::clone)
}

fn function(name: &CStr) -> *const c_void {
    let own: [(&CStr, *const c_void); 13] = [
        (c"vkCreateDescriptorSetLayout", make as *const c_void),
        (c"vkCreatePipelineLayout", make as *const c_void),
        (c"vkCreateShaderModule", make as *const c_void),
        (c"vkCreateComputePipelines", make_pipeline as *const c_void),
        (c"vkDestroyDescriptorSetLayout", destroy as *const c_void),
        (c"vkDestroyPipelineLayout", destroy as *const c_void),
        (c"vkDestroyShaderModule", destroy as *const c_void),
        (c"vkDestroyPipeline", destroy as *const c_void),
        (c"vkUpdateDescriptorSets", update as *const c_void),
        (c"vkCmdBindPipeline", bind_pipeline as *const c_void),
        (c"vkCmdBindDescriptorSets", bind_sets as *const c_void),
        (c"vkCmdDispatch", dispatch as *const c_void),
        (c"vkCmdPipelineBarrier", barrier as *const c_void),
    ];
    let found = own.iter().find(|(own, _)| *own == name);
    found.map_or(std::ptr::null(), |(_, function)| *function)
}

type Callbacks = *const vk::AllocationCallbacks<'static>;

/// Makes a set layout, a pipeline layout or a module; all are 64-bit handles.
unsafe extern "system" fn make(
    _: vk::Device,
    _: *const c_void,
    callbacks: Callbacks,
    out: *mut u64,
) -> vk::Result {
    match SEEN.with_borrow_mut(|seen| seen.make(callbacks)) {
        Some(handle) => {
            // SAFETY: ash passes a valid pointer for the handle.
            unsafe { out.write(handle) };
            vk::Result::SUCCESS
        }
        None => vk::Result::ERROR_OUT_OF_HOST_MEMORY,
    }
}

unsafe extern "system" fn make_pipeline(
    device: vk::Device,
    _: vk::PipelineCache,
    count: u32,
    infos: *const c_void,
    callbacks: Callbacks,
    out: *mut u64,
) -> vk::Result {
    assert_eq!(count, 1);
    // SAFETY: as in `make`; Vulkan returns null for a pipeline that fails.
    unsafe {
        out.write(0);
        make(device, infos, callbacks, out)
    }
}

unsafe extern "system" fn destroy(_: vk::Device, handle: u64, callbacks: Callbacks) {
    SEEN.with_borrow_mut(|seen| {
        seen.callbacks.push(callbacks);
        assert!(handle == 0 || seen.live.remove(&handle), "destroyed twice");
    });
}

unsafe extern "system" fn update(
    _: vk::Device,
    _: u32,
    _: *const c_void,
    _: u32,
    _: *const c_void,
) {
    record("update");
}

unsafe extern "system" fn bind_pipeline(
    _: vk::CommandBuffer,
    _: vk::PipelineBindPoint,
    _: vk::Pipeline,
) {
    record("bind pipeline");
}

unsafe extern "system" fn bind_sets(
    _: vk::CommandBuffer,
    _: vk::PipelineBindPoint,
    _: vk::PipelineLayout,
    _: u32,
    _: u32,
    _: *const c_void,
    _: u32,
    _: *const u32,
) {
    record("bind set");
}

unsafe extern "system" fn dispatch(_: vk::CommandBuffer, _: u32, _: u32, _: u32) {
    record("dispatch");
}

unsafe extern "system" fn barrier(
    _: vk::CommandBuffer,
    _: vk::PipelineStageFlags,
    _: vk::PipelineStageFlags,
    _: vk::DependencyFlags,
    _: u32,
    _: *const c_void,
    _: u32,
    _: *const c_void,
    _: u32,
    _: *const c_void,
) {
    record("barrier");
}

fn record(name: &'static str) {
    SEEN.with_borrow_mut(|seen| seen.recorded.push(name));
}
