//! Priors: opens and describes a prior, and solves pins.

use crate::argument::sinew_argument;
use crate::border::{self, Array, Loaded, Span};
use crate::envelope::sinew_matrix;
use crate::error::{sinew_error, sinew_status};
use crate::part::{self, Opened};
use crate::skin::sinew_skin;
use core::ffi::c_char;
use sinew_runtime::prior::{Anchor, Temporal};
use sinew_runtime::{Matrix3x4, Pin, PinJob, Pins, Prior, Skin};

/// Maximum number of pins of a job.
pub const SINEW_PINS_MAX: usize = 64;

/// Covariance of the weights of a skin's shapes.
///
/// The prior points to its model. Every call refuses the prior once the model was cleared or has loaded
/// another file.
pub struct sinew_prior(Loaded<Opened>);

part::part! { sinew_prior: Prior, tag b"SnwP", argument Prior }

/// Counts and measured errors of a prior. Lengths are in the file's unit.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct sinew_prior_info {
    /// Name in UTF-8, in the file's bytes, without a terminating zero.
    pub name: *const c_char,
    /// Length of the name in bytes.
    pub name_len: usize,
    /// Index among the file's parts.
    pub part: u32,
    /// Index of the skin among the file's parts.
    pub skin_part: u32,
    /// S, the number of shapes of the skin.
    pub shape_len: usize,
    /// Number of pairs of shapes that mirror each other.
    pub symmetry_len: usize,
    /// Number of pairs of mutually exclusive shapes.
    pub cancel_len: usize,
    /// Doubles of scratch that a job without pins needs.
    pub scratch_len: usize,
    /// Doubles of scratch for each scalar of the pins; a pin has at most three scalars.
    pub scratch_len_each: usize,
    /// Square of the allowed distance between a pin of stiffness 1 and its target.
    pub beta: f32,
    /// Number of frames that the prior was learned from; 0 if it was not learned.
    pub frames: f32,
    /// RMS distance over vertices to held-out frames; 0 if not measured.
    pub error: f32,
    /// RMS distance of the prior without covariance.
    pub slider_error: f32,
}

/// Target of a vertex, constrained in up to three directions.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct sinew_pin {
    /// Index of the skin's vertex.
    pub vertex: u32,
    /// Three rows of four. Each row measures the posed position x as `row . (x, 1)`. A row whose first
    /// three numbers are 0 is not used.
    pub rows: [[f32; 4]; 3],
    /// Target value of each row.
    pub target: [f32; 3],
    /// Weight against other pins and the prior; 1 is the prior's tolerance.
    pub stiffness: f32,
}

/// Solves the weights of all shapes for pins.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct sinew_pin_job {
    /// The prior.
    pub prior: *const sinew_prior,
    /// The prior's skin, or another skin with the same shapes.
    pub skin: *const sinew_skin,
    /// `sinew_skin_info.palette_len` transforms of the pose in which the pins are given.
    pub palette: *const sinew_matrix,
    /// Length of `palette`.
    pub palette_len: usize,
    /// The pins, in any order.
    pub pins: *const sinew_pin,
    /// Number of pins, at most `SINEW_PINS_MAX`.
    pub pins_len: usize,
    /// 0 to change the current weights as little as the pins allow, otherwise to change the mean weights as
    /// little.
    pub is_from_mean: u32,
    /// 1 to keep weights between the prior's bounds, otherwise 0.
    pub is_bounded: u32,
    /// 1 to hold the smaller weight of each mutually exclusive pair at 0, otherwise 0.
    pub cancels: u32,
    /// Square of the allowed distance between a pin of stiffness 1 and its target: `sinew_prior_info.beta`
    /// or another value.
    pub beta: f32,
    /// Weight of the symmetry term: 0 leaves the term out, 1 uses the prior's stiffness.
    pub symmetry: f32,
    /// Weight of the previous frame: the reciprocal mean square change of a weight.
    pub temporal: f32,
    /// Null, or the S weights of the previous frame.
    pub last_weights: *const f32,
    /// Length of `last_weights`.
    pub last_len: usize,
    /// At least `scratch_len + scalars * scratch_len_each` doubles, both lengths from `sinew_prior_info`.
    /// Keep the scratch during a drag: a run reuses its content if prior, terms and pins are the same and
    /// only targets differ.
    pub scratch: *mut f64,
    /// Length of `scratch`.
    pub scratch_len: usize,
    /// The S current weights; receives the solved weights.
    pub weights: *mut f32,
    /// Length of `weights`.
    pub weights_len: usize,
}

/// Result of a pin job.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct sinew_edit {
    /// Norm of the change under the prior; a larger norm is less likely.
    pub norm: f32,
    /// Number of pins that no shape moves; they are ignored.
    pub unreachable_len: u32,
    /// Number of factorisations and solves; 0 if there was nothing to solve.
    pub round_len: u32,
    /// 1 if the weights are the minimum within the bounds, 0 if they were clamped to the bounds.
    pub is_least: u32,
}

/// Describes a prior.
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

/// Computes the position of a vertex for given weights and a palette. A pin with this position as its
/// target holds the vertex in place.
///
/// - `palette`, `palette_len`: `sinew_skin_info.palette_len` transforms.
/// - `weights`, `weights_len`: a weight per shape; missing weights are 0.
/// - `out_place`: receives 3 floats in model space.
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
    let palette = Array::new(palette.cast(), palette_len, sinew_argument::Palette);
    let weights = Array::new(weights, weights_len, sinew_argument::ShapeWeights);
    let answer = |skin: &Skin<'_>, palette: &[Matrix3x4], weights: &[f32]| {
        if palette_len != skin.palette_len() {
            let error = sinew_error::new(sinew_status::Length, sinew_argument::Palette);
            return Err(error.values(skin.palette_len(), palette_len));
        }
        let (at, len) = (vertex as usize, skin.vertex_len());
        let outside = sinew_error::out_of_range(sinew_argument::Vertices, at, len);
        skin.place(vertex, palette, weights).ok_or(outside)
    };
    // SAFETY: the caller's promise is passed on.
    unsafe { part::compute(skin, (palette, weights), out_place, out_error, answer) }
}

/// Runs a pin job. If no shape moves any pin, the weights stay unchanged.
///
/// - `out_edit`: null, or receives the result.
///
/// Returns `NULL`, `MISALIGNED`, `NOT_LOADED`, `STALE`, `LENGTH`, `TOO_SHORT`, `OUT_OF_RANGE`,
/// `NON_FINITE`, `TOO_LONG`, `OVERLAP`.
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
        let last_span = last.as_ref().map_or(Span::EMPTY, Array::span);
        let [all, inputs] =
            [[own, model, file, job_span], [palette.span(), given.span(), last_span, Span::EMPTY]];
        let reads = [all, inputs, [skin_own, skin_model, skin_file, Span::EMPTY]];
        border::check_disjoint(
            &[scratch.span(), weights.span(), edit.span()],
            reads.as_flattened(),
        )?;
        let mut pins = Pins::<SINEW_PINS_MAX>::new();
        // SAFETY: lent by the caller; written memory does not overlap it.
        for pin in unsafe { given.read() } {
            let sinew_pin { vertex, rows, target, stiffness } = *pin;
            pins.add(Pin { vertex, rows, target, stiffness })?;
        }
        // SAFETY: lent by the caller; written memory overlaps nothing else.
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
        // SAFETY: lent by the caller; written memory overlaps nothing else.
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
