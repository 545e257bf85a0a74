//! Opens an FBX file with ufbx, and converts the types of ufbx.

use crate::Error;
use crate::space::{SpaceRequest, direction};
use nalgebra::Matrix4;
use sinew_runtime::format::{Axis, Handedness, Space};
use ufbx::{
    AllocatorOpts, CoordinateAxis, FileFormat, IndexErrorHandling, LoadOpts, SceneRoot,
    SceneSettings,
};

/// Memory that reading a file may take, in bytes for each byte of the file, with a lower and an upper limit. The factor
/// is the highest compression ratio of the format.
const MEMORY_A_BYTE: usize = 1100;
const MEMORY_LEAST: usize = 64 << 20;
const MEMORY_MOST: usize = 4 << 30;

/// Deepest hierarchy of nodes.
const DEPTH_MOST: u32 = 4096;

/// Parses a file, within limits of memory and depth.
pub(super) fn open(bytes: &[u8]) -> Result<SceneRoot, Error> {
    let memory_limit = bytes.len().saturating_mul(MEMORY_A_BYTE).clamp(MEMORY_LEAST, MEMORY_MOST);
    let allocator = || AllocatorOpts { memory_limit, ..Default::default() };
    let options = LoadOpts {
        file_format: FileFormat::Fbx,
        temp_allocator: allocator(),
        result_allocator: allocator(),
        ignore_embedded: true,
        skip_mesh_parts: true,
        index_error_handling: IndexErrorHandling::AbortLoading,
        node_depth_limit: DEPTH_MOST,
        ..Default::default()
    };
    ufbx::load_memory(bytes, options).map_err(fault)
}

/// Returns the axes and the unit that a scene states.
pub(super) fn space(settings: &SceneSettings) -> Space {
    let axis = |axis: CoordinateAxis| match axis {
        CoordinateAxis::PositiveX => Some(Axis::X),
        CoordinateAxis::NegativeX => Some(Axis::MinusX),
        CoordinateAxis::PositiveY => Some(Axis::Y),
        CoordinateAxis::NegativeY => Some(Axis::MinusY),
        CoordinateAxis::PositiveZ => Some(Axis::Z),
        CoordinateAxis::NegativeZ => Some(Axis::MinusZ),
        CoordinateAxis::Unknown => None,
    };
    let [right, up, forward] =
        [settings.axes.right, settings.axes.up, settings.axes.front].map(axis);
    // FBX's right is the right of a viewer whom the character faces.
    let volume = |right, up, forward| {
        let [right, up, forward] = [right, up, forward].map(direction);
        right.cross(&up).dot(&forward)
    };
    let known = right.zip(up).zip(forward).map(|((r, u), f)| (u, f, volume(r, u, f)));
    let (up, forward, volume) = match known.filter(|(.., volume)| *volume != 0.0) {
        Some((up, forward, volume)) => (Some(up), Some(forward), volume),
        None => (up, None, 1.0),
    };
    let handedness = if volume < 0.0 { Handedness::Left } else { Handedness::Right };
    let unit = (settings.unit_meters as f32 > 0.0).then_some(settings.unit_meters as f32);
    SpaceRequest { unit, ..SpaceRequest::default() }
        .of(Space { up, forward, handedness, unit: None })
        .unwrap_or(Space { up, forward, handedness, unit: None })
}

/// Converts an error of ufbx.
pub(super) fn fault(error: ufbx::Error) -> Error {
    let reason = error.description.to_lowercase();
    Error::damaged(format!(
        "is no FBX file that can be read: {reason}; export it again as binary FBX"
    ))
}

/// Converts a matrix of ufbx.
pub(super) fn matrix(m: &ufbx::Matrix) -> Matrix4<f64> {
    Matrix4::new(
        m.m00, m.m01, m.m02, m.m03, m.m10, m.m11, m.m12, m.m13, m.m20, m.m21, m.m22, m.m23, 0.0,
        0.0, 0.0, 1.0,
    )
}
