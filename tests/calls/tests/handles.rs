//! Handles to a model and its parts, and the C calls with Rust's types.
#![allow(missing_docs, unreachable_pub, reason = "a module of a test")]

use sinew_capi::*;
use sinew_runtime::{FileErrorKind, LocalTransform, Matrix3x4};
use std::ffi::c_char;
use std::mem::MaybeUninit;
use std::ops::Range;
use std::ptr::{null, null_mut};

/// Null: the test does not need the error.
pub const NONE: *mut sinew_error = null_mut();

/// Memory of an object. A vector keeps its memory in place when the vector moves.
pub type Memory = Vec<MaybeUninit<usize>>;

pub fn memory(words: usize) -> Memory {
    vec![MaybeUninit::uninit(); words]
}

/// A loaded model and its memory. Tests keep the file.
pub struct Loaded {
    memory: Memory,
    pub handle: *const sinew_model,
}

/// An open part of a model and its memory.
pub struct Part<T> {
    memory: Memory,
    pub handle: *const T,
}

pub type Envelope = Part<sinew_envelope>;
pub type Skin = Part<sinew_skin>;
pub type Kernel = Part<sinew_kernel>;

// SAFETY: the library promises that threads may share loaded objects, and tests keep the file.
unsafe impl Sync for Skin {}

impl Loaded {
    /// Loads a file, which must outlive the model and its parts.
    pub fn new(file: &[u8]) -> Self {
        let mut loaded = Self { memory: memory(SINEW_MODEL_WORDS), handle: null() };
        done(loaded.load(file));
        assert_eq!(loaded.handle.addr(), loaded.memory.as_ptr().addr());
        loaded
    }

    /// Loads a file into the same memory.
    pub fn load(&mut self, file: &[u8]) -> sinew_status {
        let (at, bytes) = (self.memory.as_mut_ptr().cast(), size_of_val(&*self.memory));
        let out = &raw mut self.handle;
        // SAFETY: memory and file with their lengths; the tests keep the file.
        unsafe { sinew_model_load(at, bytes, file.as_ptr(), file.len(), null(), out, NONE) }
    }

    /// Fills the memory with zeros.
    pub fn empty(&mut self) {
        self.memory.fill(MaybeUninit::zeroed());
    }

    pub fn envelope(&self, name: Option<&str>, index: usize) -> Result<Envelope, sinew_status> {
        self.open(sinew_part_kind::Envelope, name, index)
    }

    pub fn skin(&self, name: Option<&str>, index: usize) -> Result<Skin, sinew_status> {
        self.open(sinew_part_kind::Skin, name, index)
    }

    pub fn kernel(&self, name: Option<&str>, index: usize) -> Result<Kernel, sinew_status> {
        self.open(sinew_part_kind::Kernel, name, index)
    }

    /// Opens the `index`-th part of a kind with this name, or the `index`-th of all.
    pub fn open<T>(
        &self,
        kind: sinew_part_kind,
        name: Option<&str>,
        index: usize,
    ) -> Result<Part<T>, sinew_status> {
        let mut memory = memory(SINEW_PART_WORDS);
        let (at, len) = name.map_or((null(), 0), |name| (name.as_ptr().cast(), name.len()));
        let (place, bytes) = (memory.as_mut_ptr().cast(), size_of_val(&*memory));
        let kind = kind as u32;
        // SAFETY: a loaded model, a name and memory with their lengths.
        match unsafe { sinew_part_open(self.handle, kind, at, len, index, place, bytes, NONE) } {
            sinew_status::Ok => Ok(Part { handle: memory.as_ptr().cast(), memory }),
            status => Err(status),
        }
    }
}

impl<T> Part<T> {
    /// Copies the object to other memory.
    pub fn moved(&self) -> Self {
        let memory = self.memory.clone();
        Self { handle: memory.as_ptr().cast(), memory }
    }
}

impl Kernel {
    pub fn info(&self) -> sinew_kernel_info {
        // SAFETY: an open kernel and one structure to be written.
        get(|out| unsafe { sinew_kernel_describe(self.handle, out, NONE) })
    }
}

impl Envelope {
    pub fn info(&self) -> sinew_envelope_info {
        // SAFETY: an open envelope and one structure to be written.
        get(|out| unsafe { sinew_envelope_describe(self.handle, out, NONE) })
    }

    pub fn pose(&self, local: &[LocalTransform]) -> Vec<Matrix3x4> {
        let mut pose = vec![[[f32::NAN; 4]; 3]; local.len()];
        let (at, out) = (local.as_ptr().cast(), pose.as_mut_ptr().cast());
        // SAFETY: an open envelope and two arrays with their lengths.
        done(unsafe { sinew_envelope_pose(self.handle, at, local.len(), out, pose.len(), NONE) });
        pose
    }

    /// Computes a palette with all curves at rest.
    pub fn palette(&self, pose: &[Matrix3x4]) -> (Vec<Matrix3x4>, f32) {
        self.curved_palette(pose, &vec![0.0; self.info().curve_len])
    }

    pub fn curved_palette(&self, pose: &[Matrix3x4], curves: &[f32]) -> (Vec<Matrix3x4>, f32) {
        let (e, at, len) = (self.handle, matrices(pose), pose.len());
        let (c, c_len) = (curves.as_ptr(), curves.len());
        // SAFETY: an open envelope, four arrays with their lengths, one value to be written.
        self.written(|s, s_len, out, out_len, confidence| unsafe {
            sinew_envelope_palette(e, at, len, c, c_len, s, s_len, out, out_len, confidence, NONE)
        })
    }

    pub fn rotational_palette(&self, pose: &[Matrix3x4]) -> (Vec<Matrix3x4>, f32) {
        let (e, at, len) = (self.handle, matrices(pose), pose.len());
        // SAFETY: an open envelope, three arrays with their lengths, one value to be written.
        self.written(|s, s_len, out, out_len, confidence| unsafe {
            sinew_envelope_rotational_palette(e, at, len, s, s_len, out, out_len, confidence, NONE)
        })
    }

    /// Returns the palette and the confidence that a call writes. The call takes scratch, the palette and the
    /// confidence.
    fn written(
        &self,
        call: impl FnOnce(*mut f32, usize, *mut sinew_matrix, usize, *mut f32) -> sinew_status,
    ) -> (Vec<Matrix3x4>, f32) {
        let info = self.info();
        let mut scratch = vec![f32::NAN; info.scratch_len];
        let mut palette = vec![[[f32::NAN; 4]; 3]; info.palette_len];
        let mut confidence = f32::NAN;
        let (s, s_len, out) = (scratch.as_mut_ptr(), scratch.len(), palette.as_mut_ptr().cast());
        done(call(s, s_len, out, palette.len(), &raw mut confidence));
        (palette, confidence)
    }

    /// Computes the palettes of several poses in one call.
    pub fn palettes(
        &self,
        poses: &[Matrix3x4],
        curves: &[f32],
        pose_len: usize,
    ) -> (Vec<Matrix3x4>, Vec<f32>) {
        let info = self.info();
        let mut scratch = vec![f32::NAN; info.scratch_len];
        let mut palettes = vec![[[f32::NAN; 4]; 3]; info.palette_len * pose_len];
        let mut confidences = vec![f32::NAN; pose_len];
        let (at, at_len, out) = (matrices(poses), poses.len(), palettes.as_mut_ptr().cast());
        let (c, c_len) = (curves.as_ptr(), curves.len());
        let (s, s_len, to) = (scratch.as_mut_ptr(), scratch.len(), confidences.as_mut_ptr());
        let (e, len) = (self.handle, palettes.len());
        // SAFETY: an open envelope and five arrays with their lengths.
        done(unsafe {
            sinew_envelope_palettes(e, at, at_len, c, c_len, s, s_len, out, len, to, pose_len, NONE)
        });
        (palettes, confidences)
    }
}

impl Skin {
    pub fn info(&self) -> sinew_skin_info {
        // SAFETY: an open skin and one structure to be written.
        get(|out| unsafe { sinew_skin_describe(self.handle, out, NONE) })
    }

    /// Copies an attribute into an array that has one float too many, which stays as it was.
    pub fn attribute(
        &self,
        attribute: sinew_attribute,
        vertices: Range<usize>,
    ) -> Result<Vec<f32>, sinew_error> {
        let float_len = match attribute {
            sinew_attribute::Position | sinew_attribute::Normal => 3,
            sinew_attribute::Tangent => 4,
            sinew_attribute::TangentCoefficients => 2 * (self.info().influence_len - 1),
        };
        let mut out = vec![7.0; float_len * vertices.len() + 1];
        let (number, at, len) = (attribute as u32, out.as_mut_ptr(), out.len());
        let (start, end, mut error) = (vertices.start, vertices.end, unwritten());
        let (skin, out_error) = (self.handle, &raw mut error);
        // SAFETY: an open skin, an array with its length, and a structure to be written.
        let status = unsafe { sinew_skin_attribute(skin, number, start, end, at, len, out_error) };
        if status != sinew_status::Ok {
            return Err(error);
        }
        assert_eq!(out.pop(), Some(7.0));
        Ok(out)
    }

    pub fn range(&self, index: usize) -> sinew_range {
        // SAFETY: an open skin and one structure to be written.
        get(|out| unsafe { sinew_skin_range(self.handle, index, out, NONE) })
    }

    pub fn bounds(&self, palette: &[Matrix3x4], rest_offset: f32) -> sinew_bounds {
        let (at, len) = (matrices(palette), palette.len());
        // SAFETY: an open skin, an array with its length, a structure to be written.
        get(|out| unsafe { sinew_skin_bounds(self.handle, at, len, rest_offset, out, NONE) })
    }

    pub fn shape(&self, index: usize) -> sinew_shape {
        // SAFETY: an open skin and one structure to be written.
        get(|out| unsafe { sinew_skin_shape(self.handle, index, out, NONE) })
    }

    pub fn shaped_bounds(&self, palette: &[Matrix3x4], weights: &[f32]) -> sinew_bounds {
        let (at, len, w) = (matrices(palette), palette.len(), weights.as_ptr());
        // SAFETY: an open skin, two arrays with their lengths, a structure to be written.
        get(|out| unsafe { sinew_shapes_bounds(self.handle, at, len, w, weights.len(), out, NONE) })
    }

    /// Makes a shapes job without outputs.
    pub fn shapes_job(&self, weights: &[f32], vertices: Range<usize>) -> sinew_shapes_job {
        let nothing = sinew_output { floats: null_mut(), len: 0, stride: 0 };
        sinew_shapes_job {
            skin: self.handle,
            weights: weights.as_ptr(),
            weights_len: weights.len(),
            start: vertices.start,
            end: vertices.end,
            positions: nothing,
            normals: nothing,
            tangents: nothing,
        }
    }

    /// Makes a skin job without outputs.
    pub fn job(&self, palette: &[Matrix3x4], vertices: Range<usize>) -> sinew_skin_job {
        let nothing = sinew_output { floats: null_mut(), len: 0, stride: 0 };
        sinew_skin_job {
            skin: self.handle,
            palette: matrices(palette),
            palette_len: palette.len(),
            start: vertices.start,
            end: vertices.end,
            remap: null(),
            remap_len: 0,
            rest_positions: null(),
            rest_normals: null(),
            rest_tangents: null(),
            rest_len: 0,
            positions: nothing,
            normals: nothing,
            tangents: nothing,
            scratch: null_mut(),
            scratch_len: 0,
        }
    }

    /// Runs a job with packed outputs and returns them in this order: positions (3 floats), normals (3) and tangents (4),
    /// which are missing if the skin has none.
    pub fn run(&self, job: sinew_skin_job) -> Vec<f32> {
        let n = job.end - job.start;
        let mut out = [vec![f32::NAN; 3 * n], vec![f32::NAN; 3 * n], vec![f32::NAN; 4 * n]];
        let [positions, normals, tangents] = &mut out;
        let mut job =
            sinew_skin_job { positions: output(positions, 3), normals: output(normals, 3), ..job };
        if self.info().has_tangents == 1 {
            job.tangents = output(tangents, 4);
        } else {
            tangents.clear();
        }
        // SAFETY: every pointer of the job comes with its length.
        done(unsafe { sinew_skin_run(&raw const job, NONE) });
        out.concat()
    }
}

/// Makes an output that fills all of `floats`.
pub fn output(floats: &mut [f32], stride: usize) -> sinew_output {
    sinew_output { floats: floats.as_mut_ptr(), len: floats.len(), stride }
}

pub fn matrices(transforms: &[Matrix3x4]) -> *const sinew_matrix {
    transforms.as_ptr().cast()
}

/// Returns an error that no refused call writes: an error about a file.
pub fn unwritten() -> sinew_error {
    crate::common::file_error(FileErrorKind::Index).into()
}

pub fn done(status: sinew_status) {
    assert_eq!(status, sinew_status::Ok);
}

/// Returns the value that a successful call writes.
pub fn get<T>(call: impl FnOnce(*mut T) -> sinew_status) -> T {
    let mut out = MaybeUninit::uninit();
    done(call(out.as_mut_ptr()));
    // SAFETY: the call succeeded and has written its result.
    unsafe { out.assume_init() }
}

/// Reads a name that a call has returned.
pub fn name<'a>(at: *const c_char, len: usize) -> &'a str {
    // SAFETY: the name is in the file, which the test keeps.
    str::from_utf8(unsafe { std::slice::from_raw_parts(at.cast(), len) }).unwrap()
}
