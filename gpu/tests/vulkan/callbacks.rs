//! The host's allocation callbacks reach every call, and nothing is left behind.

use crate::vulkan::fake;
use crate::vulkan::{opened, swiftshader};
use ash::vk;
use sinew_gpu::layout::Stage;
use sinew_gpu::vulkan::headless::Device;
use sinew_gpu::vulkan::{Error, Pipelines};
use std::alloc::{Layout, alloc, dealloc};
use std::collections::HashMap;
use std::ffi::c_void;
use std::ptr::null_mut;
use std::sync::Mutex;

const CACHE: vk::PipelineCache = vk::PipelineCache::null();

/// The host's live allocations by address, and the number of allocations.
#[derive(Default)]
struct Host {
    live: Mutex<HashMap<usize, Layout>>,
    given: Mutex<usize>,
}

impl Host {
    fn callbacks(&self) -> vk::AllocationCallbacks<'_> {
        let own: *const Self = self;
        vk::AllocationCallbacks {
            p_user_data: own.cast_mut().cast(),
            pfn_allocation: Some(allocate),
            pfn_reallocation: Some(reallocate),
            pfn_free: Some(free),
            ..Default::default()
        }
    }
}

#[test]
fn the_drivers_memory_for_pipelines_comes_from_the_host_and_returns() {
    // lavapipe uses the host's memory for modules only, SwiftShader for all objects.
    let lavapipe = opened(Device::of_driver("llvmpipe", false));
    let found = balance(&lavapipe);
    assert!(found.given >= Stage::ALL.len(), "{found:?}");
    if let Some(swiftshader) = swiftshader() {
        let found = balance(&swiftshader);
        assert!(found.live >= 3 * Stage::ALL.len(), "{found:?}");
    }
}

#[derive(Debug)]
struct Balance {
    given: usize,
    live: usize,
}

/// Makes every pipeline and destroys it; returns the number of allocations, and of those live in
/// between.
fn balance(headless: &Device) -> Balance {
    let host = Host::default();
    let (callbacks, device) = (host.callbacks(), headless.device());
    // SAFETY: the device is valid, and the callbacks outlive the pipelines, which nothing uses.
    let pipelines =
        unsafe { Pipelines::new(device, &Stage::ALL, CACHE, Some(&callbacks)) }.unwrap();
    let live = host.live.lock().unwrap().len();
    // SAFETY: as above.
    unsafe { pipelines.destroy(device, Some(&callbacks)) };
    assert_eq!(host.live.lock().unwrap().len(), 0);
    Balance { given: *host.given.lock().unwrap(), live }
}

#[test]
fn every_call_is_given_the_callbacks() {
    let host = Host::default();
    let callbacks = host.callbacks();
    let device = fake::device(None);
    // SAFETY: the fake device only counts.
    unsafe {
        let pipelines = Pipelines::new(&device, &Stage::ALL, CACHE, Some(&callbacks)).unwrap();
        assert_eq!(fake::seen().live.len(), 3 * Stage::ALL.len());
        pipelines.destroy(&device, Some(&callbacks));
    }
    let seen = fake::seen();
    assert_eq!(seen.callbacks.len(), 8 * Stage::ALL.len());
    let own = (&raw const callbacks).cast();
    assert!(seen.callbacks.iter().all(|callbacks| *callbacks == own));
    assert!(seen.live.is_empty());
}

#[test]
fn whatever_fails_nothing_is_left_behind() {
    let stages = [Stage::Joints, Stage::Skin];
    let calls = 4 * stages.len();
    for fails_at in 0..calls {
        let device = fake::device(Some(fails_at));
        // SAFETY: as above.
        let error = unsafe { Pipelines::new(&device, &stages, CACHE, None) }.unwrap_err();
        let Error::Vulkan { result, .. } = error else { panic!("{error:?}") };
        assert_eq!(result, vk::Result::ERROR_OUT_OF_HOST_MEMORY);
        let seen = fake::seen();
        assert_eq!((seen.made, seen.live.len()), (fails_at + 1, 0));
    }
    let device = fake::device(Some(calls));
    // SAFETY: as above.
    assert!(unsafe { Pipelines::new(&device, &stages, CACHE, None) }.is_ok());
    assert_eq!(fake::seen().live.len(), 3 * stages.len());
}

unsafe extern "system" fn allocate(
    host: *mut c_void,
    size: usize,
    alignment: usize,
    _: vk::SystemAllocationScope,
) -> *mut c_void {
    // SAFETY: `callbacks` gave the address of a host that outlives its use.
    let host = unsafe { &*host.cast::<Host>() };
    let Ok(layout) = Layout::from_size_align(size.max(1), alignment) else { return null_mut() };
    // SAFETY: the layout is not empty.
    let pointer = unsafe { alloc(layout) };
    *host.given.lock().unwrap() += 1;
    host.live.lock().unwrap().insert(pointer as usize, layout);
    pointer.cast()
}

unsafe extern "system" fn reallocate(
    host: *mut c_void,
    original: *mut c_void,
    size: usize,
    alignment: usize,
    scope: vk::SystemAllocationScope,
) -> *mut c_void {
    // SAFETY: Vulkan passes a pointer that these callbacks returned.
    unsafe {
        let new = allocate(host, size, alignment, scope);
        if !original.is_null() && !new.is_null() {
            let old = (&*host.cast::<Host>()).live.lock().unwrap()[&(original as usize)].size();
            new.copy_from_nonoverlapping(original, old.min(size));
        }
        free(host, original);
        new
    }
}

unsafe extern "system" fn free(host: *mut c_void, pointer: *mut c_void) {
    if pointer.is_null() {
        return;
    }
    // SAFETY: as above.
    let host = unsafe { &*host.cast::<Host>() };
    let layout = host.live.lock().unwrap().remove(&(pointer as usize)).unwrap();
    // SAFETY: the memory was allocated with that layout, and is freed once.
    unsafe { dealloc(pointer.cast(), layout) };
}
