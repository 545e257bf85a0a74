//! Every function that can fail, with its arguments.

use super::arena::{BATCH, BLANK, bytes, floats};
use super::call::Call;
use super::filters;
use super::frame::SkinArguments;
use super::kernels;
use super::posed;
use super::priors;
use super::shapes;
use super::shared::{FLOATS, optional, outputs, spoilt_curves, spoilt_pose, unknown, wanted};
use super::views;
use crate::recipe;
use arbitrary::Result;
use sinew_capi::*;
use sinew_runtime::envelope::Predictor;
use std::ptr::{null, null_mut};

use sinew_argument as Argument;
use sinew_status as Status;

/// Draws the arguments of a function and calls the function.
pub(super) type Function = fn(&mut Call<'_, '_>) -> Result<sinew_status>;

/// The functions and their names.
pub(super) const FUNCTIONS: [(&str, Function); 50] = [
    ("sinew_limits_default", limits_default),
    ("sinew_model_load", load),
    ("sinew_model_describe", model_describe),
    ("sinew_model_blob", blob),
    ("sinew_model_section", section),
    ("sinew_part_open", part_open),
    ("sinew_envelope_describe", envelope_describe),
    ("sinew_envelope_joint", joint),
    ("sinew_envelope_curve", curve),
    ("sinew_envelope_pose", pose),
    ("sinew_envelope_palette", palette),
    ("sinew_envelope_palettes", palettes),
    ("sinew_envelope_rotational_palette", rotational_palette),
    ("sinew_envelope_base_palette", posed::base_palette),
    ("sinew_envelope_bones", posed::bones),
    ("sinew_envelope_joint_confidences", posed::joint_confidences),
    ("sinew_envelope_rest_locals", posed::rest_locals),
    ("sinew_envelope_bind", posed::bind),
    ("sinew_envelope_bind_curves", posed::bind_curves),
    ("sinew_envelope_gather", posed::gather),
    ("sinew_envelope_check_pose", posed::check_pose),
    ("sinew_pose_take_scale", posed::take_scale),
    ("sinew_palette_scale", posed::palette_scale),
    ("sinew_skeleton_hash", posed::skeleton_hash),
    ("sinew_skin_mesh_hash", posed::skin_mesh_hash),
    ("sinew_mesh_hash", posed::mesh_hash),
    ("sinew_skin_describe", skin_describe),
    ("sinew_skin_range", range),
    ("sinew_skin_attribute", attribute),
    ("sinew_skin_influences", influences),
    ("sinew_skin_run", run),
    ("sinew_skin_bounds", bounds),
    ("sinew_skin_shape", shapes::shape),
    ("sinew_shapes_run", shapes::run),
    ("sinew_shapes_bounds", shapes::bounds),
    ("sinew_kernel_describe", kernels::describe),
    ("sinew_kernel_input", kernels::input),
    ("sinew_kernel_output", kernels::output),
    ("sinew_kernel_evaluate", kernels::evaluate),
    ("sinew_kernel_jacobian", kernels::jacobian),
    ("sinew_kernel_variance", kernels::variance),
    ("sinew_prior_describe", priors::describe),
    ("sinew_skin_place", priors::place),
    ("sinew_pins_solve", priors::solve),
    ("sinew_views_describe", views::describe),
    ("sinew_views_map", views::map),
    ("sinew_views_frame", views::frame),
    ("sinew_views_render", views::render),
    ("sinew_filter_describe", filters::describe),
    ("sinew_filter_apply", filters::apply),
];

fn limits_default(call: &mut Call<'_, '_>) -> Result<sinew_status> {
    let out = call.output_one(Argument::Result)?;
    let error = call.ready(unknown);
    // SAFETY: as for each call of this module. Pointers are null, misaligned, or into the arena;
    // their lengths stay within the arena or reach beyond the address space. Handles are null,
    // misaligned, or point to enough of the arena, where an object is loaded or the memory is blank
    // or empty.
    Ok(unsafe { sinew_limits_default(out, error) })
}

fn load(call: &mut Call<'_, '_>) -> Result<sinew_status> {
    let (memory, memory_bytes) = call.memory(sinew_model_bytes())?;
    let (file, file_bytes) = call.input_any(call.arena.held(), Argument::File)?;
    let limits = if call.one_in(4)? { limits(call)? } else { null() };
    match call.arena.frame.refusal {
        // With other limits the model may be accepted, or refused for another reason.
        Some(_) if !limits.is_null() => call.maybe_faulty = true,
        Some(refusal) => call.fault(refusal.status, refusal.argument),
        None => {}
    }
    let out = call.output_one(Argument::Result)?;
    let error = call.ready(unknown);
    // SAFETY: as above.
    Ok(unsafe { sinew_model_load(memory, memory_bytes, file, file_bytes, limits, out, error) })
}

/// Draws limits, some of which the file may exceed.
fn limits(call: &mut Call<'_, '_>) -> Result<*const sinew_limits> {
    let place = call.arena.argument.start;
    let mut limits = [u32::MAX; 6];
    for limit in &mut limits {
        if call.one_in(4)? {
            *limit = call.any()?;
        }
    }
    let [file_bytes, tables, vertices, joints, proxies, curves] = limits;
    let tables = [tables as u16, (tables >> 16) as u16];
    let mut content = file_bytes.to_ne_bytes().to_vec();
    content.extend(tables.into_iter().flat_map(u16::to_ne_bytes));
    let counts = [vertices, joints, proxies, u32::MAX, u32::MAX, curves];
    content.extend(counts.into_iter().flat_map(u32::to_ne_bytes));
    call.arena.write(place, &content);
    // Other bytes are other limits; a null pointer means default limits.
    let drawn = call.faults.len();
    let limits = call.input_one::<sinew_limits>(place, Argument::Limits)?;
    call.maybe_faulty |= limits.is_null();
    call.faults.truncate(if limits.is_null() { drawn } else { call.faults.len() });
    Ok(limits)
}

fn model_describe(call: &mut Call<'_, '_>) -> Result<sinew_status> {
    let (model, out) = (call.model()?, call.output_one(Argument::Result)?);
    let error = call.ready(unknown);
    // SAFETY: as above.
    Ok(unsafe { sinew_model_describe(model, out, error) })
}

fn blob(call: &mut Call<'_, '_>) -> Result<sinew_status> {
    let model = call.model()?;
    let out = call.output_one(Argument::Result)?;
    let out_bytes = call.output_one(Argument::SecondResult)?;
    let error = call.ready(unknown);
    // SAFETY: as above.
    Ok(unsafe { sinew_model_blob(model, out, out_bytes, error) })
}

fn section(call: &mut Call<'_, '_>) -> Result<sinew_status> {
    let (model, part, kind) = (call.model()?, call.any()?, call.any()?);
    let out = call.output_one(Argument::Result)?;
    let error = call.ready(unknown);
    // SAFETY: as above.
    Ok(unsafe { sinew_model_section(model, part, kind, out, error) })
}

fn part_open(call: &mut Call<'_, '_>) -> Result<sinew_status> {
    use sinew_part_kind as Kind;
    let frame = &call.arena.frame;
    let named = |has: bool, name: &str| has.then(|| name.to_owned());
    let parts = [
        (Kind::Envelope, named(frame.has_envelope, &frame.envelope_name), Argument::Envelope),
        (Kind::Skin, named(frame.has_skin, &frame.skin_name), Argument::Skin),
        (Kind::Kernel, named(frame.has_kernel, &frame.kernel_name), Argument::Kernel),
        (Kind::Prior, frame.prior.as_ref().map(|own| own.name.clone()), Argument::Prior),
        (Kind::Views, frame.views.as_ref().map(|own| own.name.clone()), Argument::Views),
        (Kind::Filter, frame.filter.as_ref().map(|own| own.name.clone()), Argument::Filter),
    ];
    let (known, own, argument) = &parts[call.u.choose_index(parts.len())?];
    let unknown_kind = call.one_in(8)?;
    let kind = if unknown_kind { *call.u.choose(&[0, 7, u32::MAX])? } else { *known as u32 };
    call.fault_if(unknown_kind, Status::OutOfRange, Argument::Kind);
    let model = call.model()?;
    let (is_there, own) = (own.is_some(), own.clone().unwrap_or_default());
    let (name, name_len, index) = wanted(call, is_there, own, *argument)?;
    let (memory, bytes) = call.memory(sinew_part_bytes())?;
    let error = call.ready(unknown);
    // SAFETY: as above.
    Ok(unsafe { sinew_part_open(model, kind, name, name_len, index, memory, bytes, error) })
}

fn envelope_describe(call: &mut Call<'_, '_>) -> Result<sinew_status> {
    let (envelope, out) = (call.envelope()?, call.output_one(Argument::Result)?);
    let error = call.ready(unknown);
    // SAFETY: as above.
    Ok(unsafe { sinew_envelope_describe(envelope, out, error) })
}

fn joint(call: &mut Call<'_, '_>) -> Result<sinew_status> {
    let envelope = call.envelope()?;
    let joint = call.number(call.arena.frame.pose.len(), Argument::Joint)?;
    let out = call.output_one(Argument::Result)?;
    let error = call.ready(unknown);
    // SAFETY: as above.
    Ok(unsafe { sinew_envelope_joint(envelope, joint, out, error) })
}

fn curve(call: &mut Call<'_, '_>) -> Result<sinew_status> {
    let envelope = call.envelope()?;
    let curve = call.number(call.arena.frame.curves.len(), Argument::Curve)?;
    let out = call.output_one(Argument::Result)?;
    let error = call.ready(unknown);
    // SAFETY: as above.
    Ok(unsafe { sinew_envelope_curve(envelope, curve, out, error) })
}

fn pose(call: &mut Call<'_, '_>) -> Result<sinew_status> {
    call.spoil(call.arena.local.clone())?;
    let (envelope, j) = (call.envelope()?, call.arena.frame.pose.len());
    let (local, local_len) = call.input(call.arena.local.clone(), j, Argument::Local)?;
    let (out, out_len) = call.output_exact(j, j, Argument::Pose)?;
    let error = call.ready(|arena| bytes(floats(&arena.frame.pose)));
    // SAFETY: as above.
    Ok(unsafe { sinew_envelope_pose(envelope, local, local_len, out, out_len, error) })
}

fn palette(call: &mut Call<'_, '_>) -> Result<sinew_status> {
    let (curves, curves_len) = spoilt_curves(call)?;
    let Palette { envelope, pose, scratch, out, confidence, error } = Palette::draw(call)?;
    let ((pose, pose_len), (scratch, scratch_len), (out, out_len)) = (pose, scratch, out);
    // SAFETY: as above.
    Ok(unsafe {
        sinew_envelope_palette(
            envelope,
            pose,
            pose_len,
            curves,
            curves_len,
            scratch,
            scratch_len,
            out,
            out_len,
            confidence,
            error,
        )
    })
}

fn rotational_palette(call: &mut Call<'_, '_>) -> Result<sinew_status> {
    let is_rotational = call.arena.frame.predictor == Some(Predictor::Rotational);
    call.fault_if(!is_rotational, Status::NoStage, Argument::Call);
    let Palette { envelope, pose, scratch, out, confidence, error } = Palette::draw(call)?;
    let ((pose, pose_len), (scratch, scratch_len), (out, out_len)) = (pose, scratch, out);
    // SAFETY: as above.
    Ok(unsafe {
        sinew_envelope_rotational_palette(
            envelope,
            pose,
            pose_len,
            scratch,
            scratch_len,
            out,
            out_len,
            confidence,
            error,
        )
    })
}

/// Arguments of the functions that compute one palette; arrays with their lengths.
struct Palette {
    envelope: *const sinew_envelope,
    pose: (*const sinew_matrix, usize),
    scratch: (*mut f32, usize),
    out: (*mut sinew_matrix, usize),
    confidence: *mut f32,
    error: *mut sinew_error,
}

impl Palette {
    fn draw(call: &mut Call<'_, '_>) -> Result<Self> {
        let one = spoilt_pose(call)?;
        let (envelope, j) = (call.envelope()?, call.arena.frame.pose.len());
        let pose = call.input(one, j, Argument::Pose)?;
        let p = call.arena.frame.palette.len();
        let out = call.output_exact(p, p, Argument::Palette)?;
        let scratch = call.output(call.arena.frame.scratch_len, Argument::Scratch)?;
        let confidence =
            if call.one_in(4)? { null_mut() } else { optional(call, Argument::Confidences)? };
        let error = call.ready(|arena| bytes(floats(&arena.frame.palette)));
        Ok(Self { envelope, pose, scratch, out, confidence, error })
    }
}

fn palettes(call: &mut Call<'_, '_>) -> Result<sinew_status> {
    call.spoil(call.arena.poses.clone())?;
    call.spoil(call.arena.curves.clone())?;
    let envelope = call.envelope()?;
    let (j, p) = (call.arena.frame.pose.len(), call.arena.frame.palette.len());
    let c = call.arena.frame.curves.len();
    // The number of confidences is the number of poses.
    let (confidences, n) = call.output_any(BATCH, Argument::Confidences)?;
    let n_or_more = n.min(usize::MAX / 2);
    let (poses, poses_len) =
        call.input(call.arena.poses.clone(), n_or_more.saturating_mul(j), Argument::Pose)?;
    let (curves, curves_len) =
        call.input(call.arena.curves.clone(), n_or_more.saturating_mul(c), Argument::Curves)?;
    let right = n_or_more.saturating_mul(p);
    let (out, out_len) = call.output_exact(BATCH * p, right, Argument::Palette)?;
    let (scratch, scratch_len) = call.output(call.arena.frame.scratch_len, Argument::Scratch)?;
    let error = call.ready(|arena| bytes([arena.frame.confidence; BATCH]));
    // SAFETY: as above.
    Ok(unsafe {
        sinew_envelope_palettes(
            envelope,
            poses,
            poses_len,
            curves,
            curves_len,
            scratch,
            scratch_len,
            out,
            out_len,
            confidences,
            n,
            error,
        )
    })
}

fn skin_describe(call: &mut Call<'_, '_>) -> Result<sinew_status> {
    let (skin, out) = (call.skin()?, call.output_one(Argument::Result)?);
    let error = call.ready(unknown);
    // SAFETY: as above.
    Ok(unsafe { sinew_skin_describe(skin, out, error) })
}

fn range(call: &mut Call<'_, '_>) -> Result<sinew_status> {
    let skin = call.skin()?;
    let range = call.number(call.arena.frame.range_len, Argument::Range)?;
    let out = call.output_one(Argument::Result)?;
    let error = call.ready(unknown);
    // SAFETY: as above.
    Ok(unsafe { sinew_skin_range(skin, range, out, error) })
}

fn attribute(call: &mut Call<'_, '_>) -> Result<sinew_status> {
    use sinew_attribute as Attribute;
    let (frame, own) = (&call.arena.frame, Argument::Coefficients);
    let pair_len = frame.influence_len.saturating_sub(1);
    let attributes = [
        (Attribute::Position, true, 3, Argument::Positions),
        (Attribute::Normal, true, 3, Argument::Normals),
        (Attribute::Tangent, frame.has_tangents, 4, Argument::Tangents),
        (Attribute::TangentCoefficients, frame.has_coefficients, 2 * pair_len, own),
    ];
    let (known, is_there, floats, argument) = *call.u.choose(&attributes)?;
    let is_unknown = call.one_in(8)?;
    let number = if is_unknown { *call.u.choose(&[0, 5, u32::MAX])? } else { known as u32 };
    call.fault_if(is_unknown, Status::OutOfRange, Argument::Attribute);
    call.fault_if(!is_there, Status::NoAttribute, argument);
    let skin = call.skin()?;
    let (start, end, n) = call.vertices(call.arena.frame.vertex_len)?;
    let (out, out_len) = call.output(floats * n, argument)?;
    let error =
        call.ready(|arena| bytes(arena.frame.attribute(arena.file_bytes(), known, start..end)));
    // SAFETY: as above.
    Ok(unsafe { sinew_skin_attribute(skin, number, start, end, out, out_len, error) })
}

fn influences(call: &mut Call<'_, '_>) -> Result<sinew_status> {
    let skin = call.skin()?;
    let (start, end, n) = call.vertices(call.arena.frame.vertex_len)?;
    let len = n * call.arena.frame.influence_len;
    let (indices, indices_len) = call.output(len, Argument::Indices)?;
    let (weights, weights_len) = call.output(len, Argument::Weights)?;
    let error = call.ready(unknown);
    // SAFETY: as above.
    Ok(unsafe {
        sinew_skin_influences(skin, start, end, indices, indices_len, weights, weights_len, error)
    })
}

fn run(call: &mut Call<'_, '_>) -> Result<sinew_status> {
    call.spoil(call.arena.skin_palette.clone())?;
    let skin = call.skin()?;
    let p = call.arena.frame.skin_palette.len();
    let (palette, palette_len) =
        call.input(call.arena.skin_palette.clone(), p, Argument::Palette)?;
    let (remap, remap_len) = if call.one_in(2)? { remap(call)? } else { (null(), 0) };
    let vertex_len = call.arena.frame.vertex_len;
    let most = if remap.is_null() { vertex_len } else { remap_len };
    let (start, end, n) = call.vertices(most)?;
    // The arena has no room for a longer remap: a longer remap is not the frame's.
    let n = n.min(2 * vertex_len);
    let (rest, rest_len) = rest_mesh(call)?;
    let has_tangents = call.arena.frame.has_tangents || !rest[2].is_null();
    let (outputs, requested) = outputs(call, n, has_tangents)?;
    let [positions, normals, tangents] = outputs;
    let (scratch, scratch_len) = match call.one_in(2)? {
        true => call.output(call.arena.frame.skin_scratch_len, Argument::Scratch)?,
        false => (null_mut(), 0),
    };
    let place = call.arena.argument.start;
    let job = call.arena.at::<sinew_skin_job>(place);
    // SAFETY: the place is aligned and large enough, and the structure has no padding.
    unsafe {
        job.write(sinew_skin_job {
            skin,
            palette,
            palette_len,
            start,
            end,
            remap,
            remap_len,
            rest_positions: rest[0],
            rest_normals: rest[1],
            rest_tangents: rest[2],
            rest_len,
            positions,
            normals,
            tangents,
            scratch,
            scratch_len,
        });
    }
    // Other bytes would be pointers to memory that the caller does not own.
    let job = call.input_fixed(place, Argument::Job)?;
    call.shared = true;
    let arguments = SkinArguments {
        vertices: start..end,
        has_remap: !remap.is_null(),
        has_rest: rest.map(|array| !array.is_null()),
        outputs: requested,
    };
    let error = call.ready(|arena| {
        let mut skin = vec![f32::from_ne_bytes([BLANK; 4]); FLOATS * n];
        arena.frame.skin(arena.file_bytes(), &arguments, &mut skin);
        bytes(skin)
    });
    // SAFETY: as above.
    Ok(unsafe { sinew_skin_run(job, error) })
}

/// Draws a remap: the frame's remap, a shorter one, or one with a missing vertex.
fn remap(call: &mut Call<'_, '_>) -> Result<(*const u32, usize)> {
    let place = call.arena.remap.clone();
    if call.one_in(8)? && !place.is_empty() {
        call.arena.write(place.start, &u32::MAX.to_ne_bytes());
        call.maybe_faulty = true;
    }
    call.input_any(place, Argument::Remap)
}

/// Draws a rest mesh of the caller; each array may be missing.
fn rest_mesh(call: &mut Call<'_, '_>) -> Result<([*const f32; 3], usize)> {
    let v = call.arena.frame.vertex_len;
    let len = if call.one_in(16)? { call.u.int_in_range(0..=v)? } else { v };
    let mut rest = [null(); 3];
    let arrays =
        [(3, Argument::RestPositions), (3, Argument::RestNormals), (4, Argument::RestTangents)];
    for (i, (floats, argument)) in arrays.into_iter().enumerate() {
        if call.one_in(3)? {
            let place = call.arena.rest[i].start;
            rest[i] = call.rest_array(place, floats * len, argument)?;
            call.fault_if(!rest[i].is_null() && len != v, Status::Length, argument);
        }
    }
    Ok((rest, len))
}

fn bounds(call: &mut Call<'_, '_>) -> Result<sinew_status> {
    call.fault_if(call.arena.frame.vertex_len == 0, Status::NoVertices, Argument::Skin);
    let (skin, p) = (call.skin()?, call.arena.frame.skin_palette.len());
    let (palette, palette_len) =
        call.input(call.arena.skin_palette.clone(), p, Argument::Palette)?;
    let rest_offset = if call.one_in(4)? { recipe::float(call.u)? } else { 0.25 };
    let is_distance = (0.0..=f32::MAX).contains(&rest_offset);
    call.fault_if(!is_distance, Status::OutOfRange, Argument::RestPositions);
    let out = call.output_one(Argument::Result)?;
    let error = call.ready(|arena| {
        let bounds = arena.frame.bounds(arena.file_bytes(), rest_offset);
        bytes(bounds.into_iter().flat_map(|bounds| [bounds.min, bounds.max]).flatten())
    });
    // SAFETY: as above.
    Ok(unsafe { sinew_skin_bounds(skin, palette, palette_len, rest_offset, out, error) })
}
