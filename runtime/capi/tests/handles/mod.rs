//! Handles to a file's first envelope, and calls in Rust's types.
#![allow(missing_docs, unreachable_pub, reason = "a module of a test")]

use sinew_capi::*;
use sinew_runtime::{LocalTransform, Matrix3x4};
use std::ffi::c_char;
use std::mem::MaybeUninit;
use std::ptr::{null, null_mut};

/// No interest in the error.
pub const NONE: *mut sinew_error = null_mut();

/// What computes a palette.
pub type PaletteCall = unsafe extern "C" fn(
    *const sinew_envelope,
    *const sinew_matrix,
    usize,
    *mut f32,
    usize,
    *mut sinew_matrix,
    usize,
    *mut f32,
    *mut sinew_error,
) -> sinew_status;

/// Memory of a model and of its first envelope, both loaded, and the file they borrow.
#[derive(Clone)]
pub struct Handles {
    file: *const [u8],
    model: Box<[MaybeUninit<usize>; SINEW_MODEL_WORDS]>,
    envelope: Box<[MaybeUninit<usize>; SINEW_ENVELOPE_WORDS]>,
}

// SAFETY: the library promises that loaded objects may be shared, and the tests that the file stays.
unsafe impl Sync for Handles {}

impl Handles {
    /// Loads a file, which must outlive the handles.
    pub fn load(file: &[u8]) -> Self {
        let mut model = Box::new([MaybeUninit::uninit(); SINEW_MODEL_WORDS]);
        let mut envelope = Box::new([MaybeUninit::uninit(); SINEW_ENVELOPE_WORDS]);
        let (mut out_model, mut out_envelope) = (null(), null());
        let (memory, bytes) = (model.as_mut_ptr().cast(), size_of_val(&*model));
        // SAFETY: memory and file with their lengths; the tests keep the file.
        done(unsafe {
            let (at, len) = (file.as_ptr(), file.len());
            sinew_model_load(memory, bytes, at, len, null(), &raw mut out_model, NONE)
        });
        assert_eq!(out_model.addr(), memory.addr());
        let (memory, bytes) = (envelope.as_mut_ptr().cast(), size_of_val(&*envelope));
        // SAFETY: a loaded model, and memory with its length.
        done(unsafe {
            sinew_envelope_open(out_model, null(), 0, memory, bytes, &raw mut out_envelope, NONE)
        });
        assert_eq!(out_envelope.addr(), memory.addr());
        Self { file, model, envelope }
    }

    /// Copies the objects' memory elsewhere.
    pub fn moved(&self) -> Self {
        self.clone()
    }

    pub fn file(&self) -> &[u8] {
        // SAFETY: the tests keep the file for as long as its handles.
        unsafe { &*self.file }
    }

    pub fn model(&self) -> *const sinew_model {
        self.model.as_ptr().cast()
    }

    pub fn envelope(&self) -> *const sinew_envelope {
        self.envelope.as_ptr().cast()
    }

    pub fn info(&self) -> sinew_envelope_info {
        let mut info = MaybeUninit::uninit();
        // SAFETY: a loaded envelope and one structure to be written.
        done(unsafe { sinew_envelope_describe(self.envelope(), info.as_mut_ptr(), NONE) });
        // SAFETY: the call succeeded and has written it.
        unsafe { info.assume_init() }
    }

    pub fn pose(&self, local: &[LocalTransform]) -> Vec<Matrix3x4> {
        let mut pose = vec![[[f32::NAN; 4]; 3]; local.len()];
        let (at, out) = (local.as_ptr().cast(), pose.as_mut_ptr().cast());
        // SAFETY: a loaded envelope and two arrays with their lengths.
        done(unsafe {
            sinew_envelope_pose(self.envelope(), at, local.len(), out, pose.len(), NONE)
        });
        pose
    }

    pub fn palette(&self, pose: &[Matrix3x4]) -> (Vec<Matrix3x4>, f32) {
        self.palette_by(sinew_envelope_palette, pose)
    }

    pub fn palette_by(&self, call: PaletteCall, pose: &[Matrix3x4]) -> (Vec<Matrix3x4>, f32) {
        let info = self.info();
        let mut workspace = vec![f32::NAN; info.workspace_len];
        let mut palette = vec![[[f32::NAN; 4]; 3]; info.palette_len];
        let mut confidence = f32::NAN;
        // SAFETY: a loaded envelope, three arrays with their lengths, one value to be written.
        done(unsafe {
            call(
                self.envelope(),
                matrices(pose),
                pose.len(),
                workspace.as_mut_ptr(),
                workspace.len(),
                palette.as_mut_ptr().cast(),
                palette.len(),
                &raw mut confidence,
                NONE,
            )
        });
        (palette, confidence)
    }
}

pub fn matrices(maps: &[Matrix3x4]) -> *const sinew_matrix {
    maps.as_ptr().cast()
}

pub fn done(status: sinew_status) {
    assert_eq!(status, sinew_status::Ok);
}

/// Reads a name that a call has returned.
pub fn name<'a>(at: *const c_char, len: usize) -> &'a str {
    // SAFETY: a name lies in the file, which the test keeps.
    str::from_utf8(unsafe { std::slice::from_raw_parts(at.cast(), len) }).unwrap()
}
