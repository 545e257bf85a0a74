//! The limits of a device, and the check that the shaders can run within them.

use super::error::LayoutError;
use super::resource::ALIGNMENT;
use super::stage::WORKGROUP;

/// The limits of a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DeviceLimits {
    /// Largest storage binding, in bytes.
    pub storage_binding_bytes: u64,
    /// Storage buffers of a stage.
    pub storage_buffers: u32,
    /// Required alignment of offsets of storage and uniform bindings, in bytes.
    pub offset_alignment: u32,
    /// Threads of a workgroup.
    pub workgroup_threads: u32,
    /// Workgroups of a dispatch along each of the first two axes.
    pub workgroups: u32,
}

impl DeviceLimits {
    /// The limits of wgpu's `downlevel_defaults`; the shaders stay within them.
    pub const DOWNLEVEL: Self = Self {
        storage_binding_bytes: 128 << 20,
        storage_buffers: 4,
        offset_alignment: 256,
        workgroup_threads: 256,
        workgroups: 65_535,
    };

    /// Checks that the shaders can run within these limits.
    ///
    /// # Errors
    /// - [`LayoutError::Device`]
    /// - [`LayoutError::OffsetAlignment`]
    pub fn check(&self) -> Result<(), LayoutError> {
        let least = |name, least: u64, found: u64| {
            if found < least { Err(LayoutError::Device { name, least, found }) } else { Ok(()) }
        };
        least("number of storage buffers a stage", 4, self.storage_buffers.into())?;
        least("number of threads a workgroup", WORKGROUP.into(), self.workgroup_threads.into())?;
        least("number of workgroups a dispatch", 65_535, self.workgroups.into())?;
        if u64::from(self.offset_alignment) > ALIGNMENT {
            let (limit, found) = (ALIGNMENT, self.offset_alignment.into());
            return Err(LayoutError::OffsetAlignment { limit, found });
        }
        Ok(())
    }
}
