//! The memory of one call.

use super::arguments::RESULTS_APART;
use super::frame::Frame;
use sinew_capi::*;
use sinew_runtime::Model;
use std::mem::MaybeUninit;
use std::ops::Range;
use std::ptr::{null, null_mut};

/// What memory holds that nothing was written to.
const BLANK: u8 = 0xa5;

/// Places start on multiples of this, which suffices for every type.
const ALIGNMENT: usize = align_of::<u128>();

/// All memory that a call is given, in one allocation: whatever it writes where it must not is seen,
/// and arguments drawn anywhere in it overlap in every way. Places are bytes from its start.
pub(super) struct Arena {
    memory: Vec<u128>,
    /// The loaded model; blank where the file was refused.
    pub(super) model: Range<usize>,
    /// Its first envelope; blank where it has none.
    pub(super) envelope: Range<usize>,
    pub(super) file: Range<usize>,
    /// The frame's inputs.
    pub(super) local: Range<usize>,
    pub(super) pose: Range<usize>,
    pub(super) palette: Range<usize>,
    /// Room for a name, limits or a job.
    pub(super) argument: Range<usize>,
    /// Room for results.
    pub(super) results: Range<usize>,
    /// A frame of the envelope, an empty one where there is none.
    pub(super) frame: Frame,
}

impl Arena {
    /// Lays out a file, what is loaded of it, and a frame.
    ///
    /// # Panics
    /// Where the C ABI refuses what the runtime accepts, or the other way round.
    pub(super) fn new(file: &[u8], pose_number: usize) -> Self {
        let loaded = Model::from_bytes(file).ok();
        let envelope = loaded.and_then(|model| model.envelope());
        let frame = envelope.map(|envelope| Frame::new(&envelope, pose_number)).unwrap_or_default();
        let mut end = 0;
        let mut place = |bytes: usize| {
            let start = end;
            end = (start + bytes).next_multiple_of(ALIGNMENT);
            start..start + bytes
        };
        // More than the results of any one call.
        let results = sinew_envelope_bytes()
            + 4 * (2 * frame.skin.len() + frame.workspace_len)
            + size_of_val(&*frame.palette)
            + 6 * frame.vertex_len * frame.influence_len;
        let mut arena = Self {
            memory: Vec::new(),
            model: place(sinew_model_bytes()),
            envelope: place(sinew_envelope_bytes()),
            file: place(file.len()),
            local: place(size_of_val(&*frame.local)),
            pose: place(size_of_val(&*frame.pose)),
            palette: place(size_of_val(&*frame.palette)),
            argument: place(frame.name.len().max(size_of::<sinew_skin_job>())),
            results: place(results + 4 * (RESULTS_APART + ALIGNMENT)),
            frame,
        };
        arena.memory = vec![u128::from_ne_bytes([BLANK; ALIGNMENT]); end / ALIGNMENT];
        arena.write(arena.file.start, file);
        let local = arena.frame.local.iter();
        let local = local.flat_map(|l| l.rotation.into_iter().chain(l.translation));
        arena.write(arena.local.start, &bytes(local));
        arena.write(arena.pose.start, &bytes(floats(&arena.frame.pose)));
        arena.write(arena.palette.start, &bytes(floats(&arena.frame.palette)));
        assert_eq!(arena.load(), loaded.is_some(), "C and Rust do not agree on a file");
        assert_eq!(arena.open(), envelope.is_some(), "C and Rust do not agree on an envelope");
        arena
    }

    /// Loads the model; whether that was possible.
    fn load(&mut self) -> bool {
        let (memory, file) = (self.at(self.model.start), self.at::<u8>(self.file.start));
        let (memory_bytes, file_bytes) = (self.model.len(), self.file.len());
        let (mut out, error) = (null(), null_mut());
        // SAFETY: places of the arena with their lengths; the file stays as it is.
        let status = unsafe {
            let out = &raw mut out;
            sinew_model_load(memory, memory_bytes, file, file_bytes, null(), out, error)
        };
        status == sinew_status::Ok
    }

    /// Opens the first envelope; whether that was possible.
    fn open(&mut self) -> bool {
        let (model, memory) = (self.at(self.model.start), self.at(self.envelope.start));
        let (memory_bytes, mut out, error) = (self.envelope.len(), null(), null_mut());
        // SAFETY: places of the arena with their lengths; that of the model is blank or holds one.
        let status = unsafe {
            sinew_envelope_open(model, null(), 0, memory, memory_bytes, &raw mut out, error)
        };
        status == sinew_status::Ok
    }

    /// Points to a place.
    pub(super) fn at<T>(&mut self, place: usize) -> *mut T {
        self.memory.as_mut_ptr().wrapping_byte_add(place).cast()
    }

    /// Returns the place of some values, whose pointer is null or into the arena.
    pub(super) fn place<T>(&self, at: *const T, len: usize) -> Option<Range<usize>> {
        let start = at.addr().checked_sub(self.memory.as_ptr().addr())?;
        Some(start..start.saturating_add(len.saturating_mul(size_of::<T>())))
    }

    /// Returns how many bytes it has.
    pub(super) fn len(&self) -> usize {
        size_of_val(&*self.memory)
    }

    /// Returns what lies behind the objects, and where that starts. Objects have padding, which nobody
    /// may read; [`Arena::blob`] and [`Arena::info`] tell whether they are as they were.
    pub(super) fn content(&self) -> (usize, &[u8]) {
        let (start, len) = (self.file.start, self.len() - self.file.start);
        let at = self.memory.as_ptr().wrapping_byte_add(start).cast();
        // SAFETY: the rest of the allocation.
        (start, unsafe { std::slice::from_raw_parts(at, len) })
    }

    /// Returns the model's blob, if the model is loaded.
    pub(super) fn blob(&mut self) -> Option<(*const u8, usize)> {
        let (mut blob, mut bytes) = (null(), 0);
        let model = self.at(self.model.start);
        // SAFETY: a place that is blank or holds a model, and two values to be written.
        let status = unsafe { sinew_model_blob(model, &raw mut blob, &raw mut bytes, null_mut()) };
        (status == sinew_status::Ok).then_some((blob, bytes))
    }

    /// Describes the envelope, if it is open.
    pub(super) fn info(&mut self) -> Option<sinew_envelope_info> {
        let mut info = MaybeUninit::uninit();
        let envelope = self.at(self.envelope.start);
        // SAFETY: a place that is blank or holds an envelope, and a structure to be written.
        let status = unsafe { sinew_envelope_describe(envelope, info.as_mut_ptr(), null_mut()) };
        // SAFETY: the call has succeeded and written it.
        (status == sinew_status::Ok).then(|| unsafe { info.assume_init() })
    }

    /// Writes bytes to a place.
    pub(super) fn write(&mut self, place: usize, bytes: &[u8]) {
        assert!(bytes.len() <= self.len().saturating_sub(place));
        let at = self.at(place);
        // SAFETY: the bytes fit, and come from elsewhere.
        unsafe { std::ptr::copy_nonoverlapping(bytes.as_ptr(), at, bytes.len()) };
    }
}

/// Lists the floats of maps.
pub(super) fn floats(maps: &[sinew_runtime::Matrix3x4]) -> impl Iterator<Item = f32> {
    maps.as_flattened().as_flattened().iter().copied()
}

/// Lists the bytes of floats.
pub(super) fn bytes(floats: impl IntoIterator<Item = f32>) -> Vec<u8> {
    floats.into_iter().flat_map(f32::to_ne_bytes).collect()
}
