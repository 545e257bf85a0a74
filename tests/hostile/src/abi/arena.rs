//! The memory of one call.

use super::expected::{FilterCase, PINS, PriorCase, ViewsCase};
use super::frame::Frame;
use models::GOLDEN;
use sinew_capi::*;
use std::mem::MaybeUninit;
use std::ops::Range;
use std::ptr::{null, null_mut};

/// Bytes between results: more than any element has.
const RESULTS_APART: usize = 64;

/// Byte value of memory that was never written.
pub(super) const BLANK: u8 = 0xa5;

/// Alignment of every place, enough for every type.
pub(super) const ALIGNMENT: usize = align_of::<u128>();

/// Number of objects that a file may hold.
pub(super) const OBJECTS: usize = 7;

/// Poses of a batch.
pub(super) const BATCH: usize = 2;

/// Fate of the model after its parts were opened.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Since {
    Nothing,
    /// Another file was loaded into the memory of the model.
    Reloaded,
    /// The memory of the model was cleared.
    Emptied,
}

/// All memory that a call is given, in one allocation. A write to a wrong place is therefore
/// detected, and arguments drawn anywhere in the arena overlap in every way. Places are byte
/// offsets from the start.
pub(super) struct Arena {
    memory: Vec<u128>,
    /// The loaded model; blank where the file was refused.
    pub(super) model: Range<usize>,
    /// First envelope, skin, kernel, prior, views and filter of the model; blank if the model has
    /// none.
    pub(super) envelope: Range<usize>,
    pub(super) skin: Range<usize>,
    pub(super) kernel: Range<usize>,
    pub(super) prior: Range<usize>,
    pub(super) views: Range<usize>,
    pub(super) filter: Range<usize>,
    pub(super) file: Range<usize>,
    /// The file that replaces the first file, if one does.
    other: Range<usize>,
    /// Inputs of the frame; as many poses as a batch has, each with its curves.
    pub(super) local: Range<usize>,
    pub(super) poses: Range<usize>,
    pub(super) curves: Range<usize>,
    /// Room for a name of each joint or of each curve.
    pub(super) names: Range<usize>,
    pub(super) skin_palette: Range<usize>,
    pub(super) remap: Range<usize>,
    pub(super) rest: [Range<usize>; 3],
    pub(super) weights: Range<usize>,
    pub(super) query: Range<usize>,
    /// Room for pins.
    pub(super) pins: Range<usize>,
    /// A frame of views.
    pub(super) points: Range<usize>,
    pub(super) visibility: Range<usize>,
    pub(super) scores: Range<usize>,
    pub(super) layers: Range<usize>,
    /// Room for parameters of a map.
    pub(super) parameters: Range<usize>,
    /// Room for samples.
    pub(super) samples: Range<usize>,
    /// Room for a name, limits, a shape or a job.
    pub(super) argument: Range<usize>,
    /// Room for results.
    pub(super) results: Range<usize>,
    /// Expected results; an empty frame if the file is refused.
    pub(super) frame: Frame,
    pub(super) since: Since,
}

impl Arena {
    /// Lays out a file, its loaded objects and a frame; then applies `since`.
    ///
    /// # Panics
    /// If the C ABI refuses a file that the runtime accepts, or accepts one that the runtime
    /// refuses.
    pub(super) fn new(file: &[u8], pose_number: usize, since: Since) -> Self {
        let frame = Frame::new(file, pose_number);
        let other = GOLDEN.into_iter().find(|golden| *golden != file).unwrap_or_default();
        // A refused file holds no model that could be reloaded or cleared.
        let since = if frame.refusal.is_some() { Since::Nothing } else { since };
        let mut end = 0;
        let mut place = |bytes: usize| {
            let start = end;
            end = (start + bytes).next_multiple_of(ALIGNMENT);
            start..start + bytes
        };
        // More than any one call returns.
        let ways = frame.ways.iter().map(|way| way.scratch_len + way.found.len());
        let results = sinew_model_bytes()
            + 6 * sinew_part_bytes()
            + frame.filter.as_ref().map_or(0, FilterCase::result_bytes)
            + frame.prior.as_ref().map_or(0, PriorCase::result_bytes)
            + frame.views.as_ref().map_or(0, ViewsCase::result_bytes)
            + 4 * ways.max().unwrap_or_default()
            + size_of_val(&*frame.weights)
            + 4 * (frame.scratch_len + frame.skin_scratch_len + 32 * 2 * (frame.vertex_len + 1))
            + BATCH * size_of_val(&*frame.palette)
            + size_of_val(&*frame.pose)
            + size_of_val(&*frame.curves)
            + (6 + 8) * frame.vertex_len * frame.influence_len;
        let mut arena = Self {
            memory: Vec::new(),
            model: place(sinew_model_bytes()),
            envelope: place(sinew_part_bytes()),
            skin: place(sinew_part_bytes()),
            kernel: place(sinew_part_bytes()),
            prior: place(sinew_part_bytes()),
            views: place(sinew_part_bytes()),
            filter: place(sinew_part_bytes()),
            file: place(file.len()),
            other: place(if since == Since::Reloaded { other.len() } else { 0 }),
            local: place(size_of_val(&*frame.local)),
            poses: place(BATCH * size_of_val(&*frame.pose)),
            curves: place(BATCH * size_of_val(&*frame.curves)),
            names: place(size_of::<sinew_name>() * frame.pose.len().max(frame.curves.len())),
            skin_palette: place(size_of_val(&*frame.skin_palette)),
            remap: place(size_of_val(&*frame.remap)),
            rest: [12, 12, 16].map(|bytes| place(bytes * frame.vertex_len)),
            weights: place(size_of_val(&*frame.weights)),
            query: place(size_of_val(&*frame.query)),
            pins: place(frame.prior.as_ref().map_or(0, |_| PINS * size_of::<sinew_pin>())),
            points: place(frame.views.as_ref().map_or(0, |views| 12 * views.points.len())),
            visibility: place(frame.views.as_ref().map_or(0, |views| 4 * views.points.len())),
            scores: place(frame.views.as_ref().map_or(0, |views| 4 * views.scores.len())),
            layers: place(frame.views.as_ref().map_or(0, |views| 8 * views.layers.len())),
            parameters: place(frame.views.as_ref().map_or(0, |views| 4 * views.parameter_len())),
            samples: place(frame.filter.as_ref().map_or(0, FilterCase::sample_bytes)),
            argument: place(
                [size_of::<sinew_skin_job>(), size_of::<sinew_pin_job>()]
                    .into_iter()
                    .chain([size_of::<sinew_frame_job>(), size_of::<sinew_render_job>()])
                    .chain(frame.names().map(str::len))
                    .max()
                    .unwrap_or_default(),
            ),
            results: place(results + 6 * (RESULTS_APART + ALIGNMENT)),
            frame,
            since,
        };
        arena.memory = vec![u128::from_ne_bytes([BLANK; ALIGNMENT]); end / ALIGNMENT];
        arena.write(arena.file.start, file);
        arena.write_inputs();
        arena.open();
        match since {
            Since::Nothing => {}
            Since::Emptied => arena.write(arena.model.start, &vec![0; arena.model.len()]),
            Since::Reloaded => {
                arena.write(arena.other.start, other);
                assert_eq!(arena.load(arena.other.clone()), sinew_status::Ok);
                // The parts were opened in this file, which is now overwritten.
                arena.write(arena.file.start, &vec![BLANK; file.len()]);
            }
        }
        arena
    }

    fn write_inputs(&mut self) {
        let frame = std::mem::take(&mut self.frame);
        let local = frame.local.iter().flat_map(|l| l.rotation.into_iter().chain(l.translation));
        let poses = floats(&frame.pose).collect::<Vec<_>>().repeat(BATCH);
        let remap = frame.remap.iter().flat_map(|vertex| vertex.to_ne_bytes());
        let views = |floats: &dyn Fn(&ViewsCase) -> &[f32]| {
            frame.views.as_ref().map_or(Vec::new(), |views| floats(views).to_vec())
        };
        let [positions, normals, tangents] = self.rest.clone().map(|place| place.start);
        for (place, content) in [
            (self.local.start, bytes(local)),
            (self.poses.start, bytes(poses)),
            (self.curves.start, bytes(frame.curves.repeat(BATCH))),
            (self.skin_palette.start, bytes(floats(&frame.skin_palette))),
            (self.remap.start, remap.collect()),
            (self.weights.start, bytes(frame.weights.iter().copied())),
            (self.query.start, bytes(frame.query.iter().copied())),
            (self.points.start, bytes(views(&|views| views.points.as_flattened()))),
            (self.visibility.start, bytes(views(&|views| &views.visibility))),
            (self.scores.start, bytes(views(&|views| &views.scores))),
            (self.layers.start, bytes(views(&|views| views.layers.as_flattened()))),
            (positions, bytes(frame.rest_positions.as_flattened().iter().copied())),
            (normals, bytes(frame.rest_normals.as_flattened().iter().copied())),
            (tangents, bytes(frame.rest_tangents.as_flattened().iter().copied())),
        ] {
            self.write(place, &content);
        }
        self.frame = frame;
    }

    /// Loads the model and opens its first part of each kind, if it has one.
    fn open(&mut self) {
        let refusal = self.frame.refusal.map_or(sinew_status::Ok, |error| error.status);
        assert_eq!(self.load(self.file.clone()), refusal, "C and Rust do not agree on a file");
        let model = self.at(self.model.start);
        use sinew_part_kind as Kind;
        for (kind, place, is_there) in [
            (Kind::Envelope, self.envelope.clone(), self.frame.has_envelope),
            (Kind::Skin, self.skin.clone(), self.frame.has_skin),
            (Kind::Kernel, self.kernel.clone(), self.frame.has_kernel),
            (Kind::Prior, self.prior.clone(), self.frame.prior.is_some()),
            (Kind::Views, self.views.clone(), self.frame.views.is_some()),
            (Kind::Filter, self.filter.clone(), self.frame.filter.is_some()),
        ] {
            let (place, bytes) = (self.at(place.start), place.len());
            // SAFETY: places of the arena with their lengths; the place of the model is blank or holds
            // one.
            let opened = unsafe {
                sinew_part_open(model, kind as u32, null(), 0, 0, place, bytes, null_mut())
            };
            assert_eq!(opened == sinew_status::Ok, is_there, "{kind:?}: {opened:?}");
        }
    }

    /// Loads the model.
    fn load(&mut self, file: Range<usize>) -> sinew_status {
        let (memory, at) = (self.at(self.model.start), self.at::<u8>(file.start));
        let (bytes, mut out) = (self.model.len(), null());
        // SAFETY: places of the arena with their lengths; the file stays as it is.
        unsafe {
            let out = &raw mut out;
            sinew_model_load(memory, bytes, at, file.len(), null(), out, null_mut())
        }
    }

    /// Returns the place of the file that the model holds.
    pub(super) fn held(&self) -> Range<usize> {
        if self.since == Since::Reloaded { self.other.clone() } else { self.file.clone() }
    }

    /// Returns the bytes of the file that the parts were opened in.
    pub(super) fn file_bytes(&self) -> &[u8] {
        &self.content().1[..self.file.len()]
    }

    /// Lists the places of objects: first the model, then its parts.
    pub(super) fn objects(&self) -> [&Range<usize>; OBJECTS] {
        let Self { model, envelope, skin, kernel, prior, views, filter, .. } = self;
        [model, envelope, skin, kernel, prior, views, filter]
    }

    /// Returns a pointer to a place.
    pub(super) fn at<T>(&mut self, place: usize) -> *mut T {
        self.memory.as_mut_ptr().wrapping_byte_add(place).cast()
    }

    /// Returns the place of `len` values; the pointer is null or points into the arena.
    pub(super) fn place<T>(&self, at: *const T, len: usize) -> Option<Range<usize>> {
        let start = at.addr().checked_sub(self.memory.as_ptr().addr())?;
        Some(start..start.saturating_add(len.saturating_mul(size_of::<T>())))
    }

    /// Returns the length in bytes.
    pub(super) fn len(&self) -> usize {
        size_of_val(&*self.memory)
    }

    /// Returns the bytes behind the objects, and the place where those bytes start. Objects have
    /// padding, which must not be read; [`Arena::descriptions`] detects changes of objects.
    pub(super) fn content(&self) -> (usize, &[u8]) {
        let (start, len) = (self.file.start, self.len() - self.file.start);
        let at = self.memory.as_ptr().wrapping_byte_add(start).cast();
        // SAFETY: the rest of the allocation.
        (start, unsafe { std::slice::from_raw_parts(at, len) })
    }

    /// Describes the unchanged objects: the blob of the model and the info of each part. Objects
    /// that are missing have no description.
    pub(super) fn descriptions(&mut self, kept: [bool; OBJECTS]) -> Descriptions {
        let [model, envelope, skin, kernel, prior, views, filter] = kept;
        let mut descriptions = Descriptions::default();
        let (mut blob, mut blob_bytes, error) = (null(), 0, null_mut());
        let (mut envelope_info, mut skin_info) = (MaybeUninit::uninit(), MaybeUninit::uninit());
        let (mut prior_info, mut views_info) = (MaybeUninit::uninit(), MaybeUninit::uninit());
        let (mut kernel_info, mut filter_info) = (MaybeUninit::uninit(), MaybeUninit::uninit());
        let [at_model, at_envelope, at_skin, at_kernel, at_prior, at_views, at_filter] =
            self.objects().map(|object| object.start);
        let done = |status| status == sinew_status::Ok;
        let at = self.at(at_model);
        // SAFETY: a place that is blank, empty or holds a model, and two values to be written.
        if model && done(unsafe { sinew_model_blob(at, &raw mut blob, &raw mut blob_bytes, error) })
        {
            descriptions.blob = Some((blob, blob_bytes));
        }
        let (at, out) = (self.at(at_envelope), envelope_info.as_mut_ptr());
        // SAFETY: a place that is blank or holds an envelope, whose model is as it was.
        if model && envelope && done(unsafe { sinew_envelope_describe(at, out, error) }) {
            // SAFETY: the call has succeeded and written it.
            descriptions.envelope = Some(unsafe { envelope_info.assume_init() });
        }
        let (at, out) = (self.at(at_skin), skin_info.as_mut_ptr());
        // SAFETY: a place that is blank or holds a skin, whose model is as it was.
        if model && skin && done(unsafe { sinew_skin_describe(at, out, error) }) {
            // SAFETY: the call has succeeded and written it.
            descriptions.skin = Some(unsafe { skin_info.assume_init() });
        }
        let (at, out) = (self.at(at_kernel), kernel_info.as_mut_ptr());
        // SAFETY: a place that is blank or holds a kernel, whose model is as it was.
        if model && kernel && done(unsafe { sinew_kernel_describe(at, out, error) }) {
            // SAFETY: the call has succeeded and written it.
            descriptions.kernel = Some(unsafe { kernel_info.assume_init() });
        }
        let (at, out) = (self.at(at_prior), prior_info.as_mut_ptr());
        // SAFETY: a place that is blank or holds a prior, whose model is as it was.
        if model && prior && done(unsafe { sinew_prior_describe(at, out, error) }) {
            // SAFETY: the call has succeeded and written it.
            descriptions.prior = Some(unsafe { prior_info.assume_init() });
        }
        let (at, out) = (self.at(at_views), views_info.as_mut_ptr());
        // SAFETY: a place that is blank or holds views, whose model is as it was.
        if model && views && done(unsafe { sinew_views_describe(at, out, error) }) {
            // SAFETY: the call has succeeded and written it.
            descriptions.views = Some(unsafe { views_info.assume_init() });
        }
        let (at, out) = (self.at(at_filter), filter_info.as_mut_ptr());
        // SAFETY: a place that is blank or holds a filter, whose model is as it was.
        if model && filter && done(unsafe { sinew_filter_describe(at, out, error) }) {
            // SAFETY: the call has succeeded and written it.
            descriptions.filter = Some(unsafe { filter_info.assume_init() });
        }
        descriptions
    }

    /// Writes bytes to a place.
    pub(super) fn write(&mut self, place: usize, bytes: &[u8]) {
        assert!(bytes.len() <= self.len().saturating_sub(place));
        let at = self.at(place);
        // SAFETY: the bytes fit, and come from another allocation.
        unsafe { std::ptr::copy_nonoverlapping(bytes.as_ptr(), at, bytes.len()) };
    }
}

/// Returns where the next result starts.
pub(super) const fn result_after(end: usize) -> usize {
    end.next_multiple_of(ALIGNMENT) + RESULTS_APART
}

/// Descriptions of objects, as the C ABI returns them.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Descriptions {
    blob: Option<(*const u8, usize)>,
    envelope: Option<sinew_envelope_info>,
    skin: Option<sinew_skin_info>,
    kernel: Option<sinew_kernel_info>,
    prior: Option<sinew_prior_info>,
    views: Option<sinew_views_info>,
    filter: Option<sinew_filter_info>,
}

/// Lists the floats of transforms.
pub(super) fn floats(transforms: &[sinew_runtime::Matrix3x4]) -> impl Iterator<Item = f32> {
    transforms.as_flattened().as_flattened().iter().copied()
}

/// Lists the bytes of floats.
pub(super) fn bytes(floats: impl IntoIterator<Item = f32>) -> Vec<u8> {
    floats.into_iter().flat_map(f32::to_ne_bytes).collect()
}
