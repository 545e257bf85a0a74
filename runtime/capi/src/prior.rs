//! A prior, what the file says of it, and pins on its skin.

use crate::argument::sinew_argument;
use crate::border::{self, Array, Loaded, Span};
use crate::envelope::sinew_matrix;
use crate::error::{sinew_error, sinew_status};
use crate::model::sinew_model;
use crate::part::{self, Opened, Opening};
use crate::skin::sinew_skin;
use core::ffi::{c_char, c_void};
use core::mem::{align_of, size_of};
use sinew_runtime::prior::{Anchor, PriorLayout, Temporal};
use sinew_runtime::{Matrix3x4, Pin, PinJob, Pins, Prior};

/// Elements of a `uintptr_t` array that holds a prior on every target:
/// `uintptr_t memory[SINEW_PRIOR_WORDS]`.
pub const SINEW_PRIOR_WORDS: usize = 48;

/// The most pins of a job.
pub const SINEW_PINS_MAX: usize = 64;

/// How the weights of a skin's shapes belong together. It points to its model: where that has been loaded again
/// with another file, or is loaded no more, every call refuses the prior.
pub struct sinew_prior(Loaded<Opened<PriorLayout>>);

part::part! {
    sinew_prior: PriorLayout to Prior, of Model::priors,
    tag b"SnwP", argument Prior, within SINEW_PRIOR_WORDS
}

/// What a prior is made of, and what it was measured to reach; lengths are in the file's unit.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct sinew_prior_info {
    /// Its name: UTF-8 in the file's bytes, not ended by a zero.
    pub name: *const c_char,
    /// Bytes of the name.
    pub name_len: usize,
    /// Its number among the file's parts.
    pub part: u32,
    /// That of its skin.
    pub skin_part: u32,
    /// S, shapes of its skin.
    pub shape_len: usize,
    /// Pairs of shapes that mirror each other.
    pub symmetry_len: usize,
    /// Pairs of shapes of which one alone is at work.
    pub cancel_len: usize,
    /// Doubles of scratch that a job without pins needs.
    pub scratch_len: usize,
    /// Doubles of scratch that each scalar of its pins needs: at most three a pin.
    pub scratch_len_each: usize,
    /// The square of the length by which a pin of stiffness 1 may miss.
    pub beta: f32,
    /// Frames that it was learned from; 0 of one that was not.
    pub frames: f32,
    /// RMS over vertices of the distance to held-out frames; 0 if it was not measured.
    pub error: f32,
    /// The same of the prior without covariance.
    pub slider_error: f32,
}

/// Where a vertex is to be, as far as up to three rows look at it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct sinew_pin {
    /// The vertex of the skin.
    pub vertex: u32,
    /// What is looked at of its posed position x: `row . (x, 1)`, three rows of four. A row whose first three
    /// numbers are 0 looks at nothing.
    pub rows: [[f32; 4]; 3],
    /// What each row is to give.
    pub target: [f32; 3],
    /// How much it counts against others and the prior; 1 is the prior's tolerance.
    pub stiffness: f32,
}

/// Solves weights of all shapes for pins.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct sinew_pin_job {
    /// The prior.
    pub prior: *const sinew_prior,
    /// Its skin, or another with the same shapes.
    pub skin: *const sinew_skin,
    /// `sinew_skin_info.palette_len` transforms of the pose in which pins are where they are.
    pub palette: *const sinew_matrix,
    /// Their number.
    pub palette_len: usize,
    /// The pins, in any order.
    pub pins: *const sinew_pin,
    /// Their number, at most `SINEW_PINS_MAX`.
    pub pins_len: usize,
    /// 0 to change the weights that are there as little as pins allow, else the mean ones.
    pub is_from_mean: u32,
    /// 1 to keep weights between the prior's bounds, else 0.
    pub is_bounded: u32,
    /// 1 to hold the smaller weight of each pair that cancels at 0, else 0.
    pub cancels: u32,
    /// The square of the length by which a pin of stiffness 1 may miss: `sinew_prior_info.beta`, or another.
    pub beta: f32,
    /// How much the prior's symmetry counts; 0 leaves it out, 1 is as stiff as the prior has it.
    pub symmetry: f32,
    /// How much the frame before counts: the reciprocal of the mean square by which a weight changes.
    pub temporal: f32,
    /// Null, or the S weights of the frame before.
    pub last_weights: *const f32,
    /// Their number.
    pub last_len: usize,
    /// At least `scratch_len + scalars * scratch_len_each` doubles of `sinew_prior_info`. What it holds of a run
    /// with the same prior, terms and pins but for their targets is used again: keep it for a drag.
    pub scratch: *mut f64,
    /// Their number.
    pub scratch_len: usize,
    /// The S weights that are there; receives those that are solved.
    pub weights: *mut f32,
    /// Their number.
    pub weights_len: usize,
}

/// What a pin job did.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct sinew_edit {
    /// How unlikely the prior finds the change.
    pub norm: f32,
    /// Pins that no shape moves, which count as none.
    pub unreachable_len: u32,
    /// Factors and solves that it took; 0 where there was nothing to solve.
    pub round_len: u32,
    /// 1 where bounds were found to hold at the least, 0 where weights were cut to them.
    pub is_least: u32,
}

/// Returns the bytes of memory that a prior needs: at most those of `SINEW_PRIOR_WORDS` words.
#[unsafe(no_mangle)]
pub extern "C" fn sinew_prior_bytes() -> usize {
    size_of::<sinew_prior>()
}

/// Opens a prior of a model.
///
/// - `name`, `name_len`: its name, without a zero at its end; null and 0 for any.
/// - `index`: which of those; 0 for the first.
/// - `memory`, `memory_bytes`: for the prior; at least `sinew_prior_bytes()`, aligned as a `uintptr_t`.
/// - `out_prior`: receives the handle, which is `memory`.
///
/// Returns `NULL`, `MISALIGNED`, `TOO_SHORT`, `TOO_LONG`, `OVERLAP`, `NOT_LOADED`, `NOT_FOUND`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_prior_open(
    model: *const sinew_model,
    name: *const c_char,
    name_len: usize,
    index: usize,
    memory: *mut c_void,
    memory_bytes: usize,
    out_prior: *mut *const sinew_prior,
    out_error: *mut sinew_error,
) -> sinew_status {
    let opening = Opening { model, name, name_len, index, memory, memory_bytes };
    // SAFETY: the caller's promise is passed on.
    unsafe { opening.open(out_prior, out_error) }
}

/// Says what a prior is made of.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `OVERLAP`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_prior_describe(
    prior: *const sinew_prior,
    out_info: *mut sinew_prior_info,
    out_error: *mut sinew_error,
) -> sinew_status {
    let answer = |prior: &Prior<'_>| {
        let (counts, fit) = (prior.counts(), prior.fit());
        Ok(sinew_prior_info {
            name: prior.name().as_ptr().cast(),
            name_len: prior.name().len(),
            part: prior.part() as u32,
            skin_part: counts.skin,
            shape_len: prior.shape_len(),
            symmetry_len: counts.symmetry_len as usize,
            cancel_len: counts.cancel_len as usize,
            scratch_len: counts.pin_scratch_len(0),
            scratch_len_each: prior.shape_len() + 1,
            beta: fit.beta,
            frames: fit.frames,
            error: fit.error,
            slider_error: fit.slider_error,
        })
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { part::describe(prior, out_info, out_error, answer) }
}

/// Computes where a vertex is with weights and a palette: as a target it makes a pin hold the vertex there.
///
/// - `palette`, `palette_len`: `sinew_skin_info.palette_len` transforms.
/// - `weights`, `weights_len`: a weight of each shape; of fewer the others are 0.
/// - `out_place`: receives 3 floats, model space.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `LENGTH`, `OUT_OF_RANGE`, `TOO_LONG`, `OVERLAP`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_skin_place(
    skin: *const sinew_skin,
    vertex: u32,
    palette: *const sinew_matrix,
    palette_len: usize,
    weights: *const f32,
    weights_len: usize,
    out_place: *mut [f32; 3],
    out_error: *mut sinew_error,
) -> sinew_status {
    let body = || {
        // SAFETY: the caller's promise is passed on.
        let (skin, [own, model, file]) = unsafe { part::view(skin) }?;
        let palette =
            Array::new(palette.cast::<Matrix3x4>(), palette_len, sinew_argument::Palette)?;
        let weights = Array::new(weights, weights_len, sinew_argument::ShapeWeights)?;
        let out = Array::one(out_place, sinew_argument::Result)?;
        let reads = [own, model, file, palette.span(), weights.span()];
        border::apart(&[out.span()], &reads)?;
        if palette_len != skin.palette_len() {
            let error = sinew_error::new(sinew_status::Length, sinew_argument::Palette);
            return Err(error.values(skin.palette_len(), palette_len));
        }
        let (at, len) = (vertex as usize, skin.vertex_len());
        let beyond = sinew_error::beyond(sinew_argument::Vertices, at, len);
        // SAFETY: lent by the caller.
        let place = unsafe { skin.place(vertex, palette.read(), weights.read()) }.ok_or(beyond)?;
        // SAFETY: one element, which the caller lets be written.
        unsafe { out.store(place) };
        Ok(())
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { border::call(out_error, body) }
}

/// Runs a pin job. Without a pin that any shape moves the weights stay as they are.
///
/// - `out_edit`: null, or receives what it did.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `LENGTH`, `TOO_SHORT`, `OUT_OF_RANGE`, `NON_FINITE`,
/// `TOO_LONG`, `OVERLAP`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_pins_solve(
    job: *const sinew_pin_job,
    out_edit: *mut sinew_edit,
    out_error: *mut sinew_error,
) -> sinew_status {
    let body = || {
        // SAFETY: lent by the caller.
        let (job, job_span) = unsafe { border::copied(job, sinew_argument::Job) }?;
        // SAFETY: the caller's promise is passed on.
        let (prior, [own, model, file]) = unsafe { part::view(job.prior) }?;
        // SAFETY: the caller's promise is passed on.
        let (skin, of_skin) = unsafe { part::view(job.skin) }?;
        let palette = job.palette.cast::<Matrix3x4>();
        let palette = Array::new(palette, job.palette_len, sinew_argument::Palette)?;
        let given = Array::new(job.pins, job.pins_len, sinew_argument::Pins)?;
        let last = Array::given(job.last_weights, job.last_len, sinew_argument::ShapeWeights)?;
        let scratch = Array::new(job.scratch, job.scratch_len, sinew_argument::Scratch)?;
        let weights = Array::new(job.weights, job.weights_len, sinew_argument::ShapeWeights)?;
        let edit = Array::optional(out_edit, sinew_argument::Result)?;
        let [skin_own, skin_model, skin_file] = of_skin;
        let last_span = last.as_ref().map_or(Span::NOWHERE, Array::span);
        let [all, inputs] = [
            [own, model, file, job_span],
            [palette.span(), given.span(), last_span, Span::NOWHERE],
        ];
        let reads = [all, inputs, [skin_own, skin_model, skin_file, Span::NOWHERE]];
        border::apart(&[scratch.span(), weights.span(), edit.span()], reads.as_flattened())?;
        let mut pins = Pins::<SINEW_PINS_MAX>::new();
        // SAFETY: lent by the caller, and apart from all that is written.
        for pin in unsafe { given.read() } {
            let sinew_pin { vertex, rows, target, stiffness } = *pin;
            pins.add(Pin { vertex, rows, target, stiffness })?;
        }
        // SAFETY: lent by the caller; what is written is apart from all else.
        let (palette, last) = unsafe { (palette.read(), last.map(|last| last.read())) };
        let run = PinJob {
            palette,
            anchor: if job.is_from_mean == 0 { Anchor::Current } else { Anchor::Mean },
            beta: job.beta,
            is_bounded: job.is_bounded != 0,
            temporal: last.map(|weights| Temporal { weights, stiffness: job.temporal }),
            symmetry: job.symmetry,
            cancels: job.cancels != 0,
            ..PinJob::new(prior, skin, pins.list())
        };
        // SAFETY: likewise.
        let (scratch, weights, edit) = unsafe { (scratch.write(), weights.write(), edit.write()) };
        let done = run.run(scratch, weights)?;
        edit.fill(sinew_edit {
            norm: done.norm,
            unreachable_len: done.unreachable_len as u32,
            round_len: done.round_len,
            is_least: u32::from(done.is_least),
        });
        Ok(())
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { border::call(out_error, body) }
}
