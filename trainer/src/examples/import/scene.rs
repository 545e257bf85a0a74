//! Converts a scene, with separate posed meshes or its own, to examples.

use super::align::{self, is_shuffled};
use super::clips::{best_order, check_even, frame_len, selected, selected_rows};
use super::curves::SampledCurves;
use super::joined::Loaded;
use super::matched::{arranged, matched};
use super::targets::TargetMeshes;
use crate::Error;
use crate::examples::distortion::REPAIRABLE;
use crate::examples::joints::{idle, join_roots};
use crate::examples::validate::{Origin, numbers, vertex};
use crate::examples::{Clip, Examples, Matrix3x4, RIGID, Skeleton, Split, Warning};
use crate::formats::FormatWarning;
use crate::formats::posed_meshes::PosedMeshes;
use crate::formats::scene::{SampledScene, Sampling, faults};
use nalgebra::{Matrix3, Matrix4};
use std::mem::take;

/// Joins poses with posed meshes from `targets`, or with the scene's own meshes. The examples are not checked.
///
/// If the targets have a rest mesh, it defines the space and unit, and the joints move there. Otherwise the targets
/// move to the joints. If the targets cover more clips than requested, the other clips are removed.
///
/// # Errors
/// - A bind matrix has no inverse, or a number of the rest mesh or of the poses is not finite.
/// - Without targets: the scene has no shapes.
/// - With targets: the keys are uneven. Errors about the targets name their file: a number is not finite or too large,
///   counts of vertices or frames differ, copies of a vertex separate, several orders of the clips fit, the vertices
///   have another order, or the meshes are not near the joints.
pub(super) fn join(
    mut scene: SampledScene,
    curves: SampledCurves,
    targets: Option<TargetMeshes>,
    sampling: &Sampling<'_>,
) -> Result<Loaded, Error> {
    let (shapes, morphs) = (scene.shapes.take(), scene.morphs);
    let mut loaded = poses(scene)?;
    curves.put(&mut loaded.examples);
    let Some(targets) = targets else {
        if !morphs {
            loaded.warnings.push(Warning::PlainSkin);
        }
        loaded.examples.vertices = shapes.ok_or_else(no_shapes)?;
        loaded.examples.own_skin = true;
        return Ok(unscaled(loaded));
    };
    // Checked first: otherwise positions that are not finite would be reported as far from the joints.
    targets.check_numbers(&loaded.clips)?;
    if sampling.fps.is_none() {
        check_even(&loaded.clips)?;
    }
    let path = targets.path.clone();
    let all = join_targets(loaded, targets).map_err(|error| error.in_file(path))?;
    Ok(cut(unscaled(all), sampling))
}

/// Removes scales that no fit needs.
fn unscaled(mut loaded: Loaded) -> Loaded {
    loaded.warnings.extend(loaded.examples.unscale());
    loaded
}

/// Joins poses with posed meshes of all clips. Every error is about the posed meshes.
fn join_targets(loaded: Loaded, targets: TargetMeshes) -> Result<Loaded, Error> {
    let Loaded { mut examples, clips, mut warnings } = loaded;
    let TargetMeshes { meshes, split, missing, .. } = targets;
    let meshes = arranged(&examples.ranges, examples.vertex_len(), meshes, &mut warnings);
    let meshes = matched(&examples.surface(), meshes)?;
    check_frames(&clips, &meshes, missing)?;
    let PosedMeshes { vertices, rest, triangles, .. } = meshes;
    examples.vertices = vertices;
    examples.split = split.unwrap_or(examples.split);
    match rest {
        Some(rest) => {
            let similarity = align::meshes(&examples.rest, &rest).map_err(align::targets_apart)?;
            similarity.move_joints(&mut examples.skeleton.rest, &mut examples.transforms);
            examples.space = similarity.space(&examples.space);
            warnings.extend(similarity.warning("joints"));
            examples.rest = rest;
            warnings.extend(sort(&mut examples, &clips, true)?);
            similarity.turn(examples.engine.as_mut());
            // Authored data belongs to the scene's own triangles.
            let others = triangles.filter(|_| examples.engine.is_none());
            examples.triangles = others.unwrap_or(examples.triangles);
        }
        None => {
            warnings.extend(sort(&mut examples, &clips, false)?);
            let similarity = align::poses(&examples)
                .map_err(|error| if is_shuffled(&examples) { vertex_order() } else { error })?;
            similarity.move_points(&mut examples.vertices);
            warnings.extend(similarity.warning("targets"));
        }
    }
    let weights = examples.joint_weights.as_deref().unwrap_or_default();
    let rows = weights.chunks_exact(examples.joint_len().max(1));
    let count = rows.filter(|row| row.iter().all(|weight| *weight == 0.0)).count();
    if count > 0 {
        let unweighted = FormatWarning::Unweighted { count, follow: "the targets" };
        warnings.push(unweighted.into());
    }
    Ok(Loaded { examples, clips, warnings })
}

fn no_shapes() -> Error {
    Error::missing(
        "holds poses but neither a skin nor shapes: give the posed meshes as --targets (.abc, .pc2, .mdd, .npz, or a \
         numbered sequence of .obj)",
    )
}

fn vertex_order() -> Error {
    Error::mismatch(
        "its vertices are those of the scene's mesh, but in another order: export both from one mesh, neither as glTF, \
         which sorts vertices anew; or give an .npz with the `rest` positions of its vertices",
    )
}

/// Removes the frames of clips that were not requested.
fn cut(Loaded { mut examples, clips, mut warnings }: Loaded, sampling: &Sampling<'_>) -> Loaded {
    let held = examples.frame_len();
    let (clips, frames) = selected(clips, sampling);
    if let Some(frames) = frames {
        let names = clips.iter().map(|clip| clip.name.clone()).collect();
        warnings.push(Warning::TargetsCut { clips: names, frames: frames.len(), held });
        take_meshes(&mut examples, &frames);
        let (joint_len, curve_len) = (examples.joint_len(), examples.curve_names.len());
        examples.transforms = selected_rows(examples.transforms, joint_len, Some(&frames));
        examples.curves = selected_rows(examples.curves, curve_len, Some(&frames));
    }
    Loaded { examples, clips, warnings }
}

/// Takes the posed meshes and uses of some frames.
fn take_meshes(examples: &mut Examples, frames: &[usize]) {
    let vertex_len = examples.vertex_len();
    examples.vertices = selected_rows(take(&mut examples.vertices), vertex_len, Some(frames));
    examples.split = selected_rows(take(&mut examples.split), 1, Some(frames));
}

/// Returns the poses with the rest mesh in every frame. The examples are not checked.
///
/// # Errors
/// A bind matrix has no inverse, a number is not finite, or a number of the rest mesh is too large.
pub(super) fn still(scene: SampledScene) -> Result<Loaded, Error> {
    let mut loaded = poses(scene)?;
    loaded.examples.vertices = loaded.examples.rest.repeat(loaded.examples.frame_len());
    Ok(unscaled(loaded))
}

/// Converts a scene to examples without posed meshes, on a skeleton with one root. The maps are rigid if the scene's
/// are.
///
/// Mesh and joints of a scene may have different units. The rest mesh is scaled to the joints' unit.
///
/// # Errors
/// A bind matrix has no inverse, a number is not finite, or a number of the rest mesh is too large.
fn poses(scene: SampledScene) -> Result<Loaded, Error> {
    let SampledScene { mut rest, names, parents, binds, at_rest, frames, clips, .. } = scene;
    let joint_weights = scene.joint_weights;
    numbers(Origin::SCENE.rest, &rest, None, vertex)?;
    let joint = |number: usize| format!("joint {}", names[number]);
    let all = frames.iter().map(Matrix4::as_slice);
    numbers(Origin::SCENE.pose, all, Some((binds.len(), &|_| false)), joint)?;
    let mut inverses = Vec::with_capacity(binds.len());
    for (bind, name) in binds.iter().zip(&names) {
        inverses.push(bind.try_inverse().ok_or_else(|| faults::singular_bind(name))?);
    }
    let maps = frames.iter().zip(inverses.iter().cycle());
    let mut maps: Vec<_> = maps.map(|(frame, inverse)| frame * inverse).collect();
    let idle = idle(joint_weights.as_deref(), &parents);
    let at_rest: Vec<_> = at_rest.iter().zip(&inverses).map(|(own, back)| own * back).collect();
    let scale = unscale(&mut maps, &at_rest, &idle);
    rest.as_flattened_mut().iter_mut().for_each(|x| *x *= scale);
    let mut warnings = scene.warnings.into_iter().map(Warning::from).collect();
    let (parents, roots) = join_roots(&names, parents, &mut warnings);
    let bound = binds.iter().map(|bind| rows(&rest_frame(bind, scale))).collect();
    let examples = Examples {
        rest,
        triangles: scene.triangles,
        engine: scene.engine,
        skeleton: Skeleton { names, parents, roots, rest: bound, ..Skeleton::default() },
        transforms: maps.iter().map(rows).collect(),
        split: vec![Split::Train; frame_len(&clips)],
        ranges: scene.ranges,
        clip_starts: clips.iter().map(|clip| clip.first).collect(),
        space: scene.space,
        joint_weights,
        ..Examples::default()
    };
    Ok(Loaded { examples, clips, warnings })
}

/// Sorts the posed meshes and their uses into the clips' order, if they follow another order; returns a warning then.
///
/// # Errors
/// Several orders fit.
fn sort(examples: &mut Examples, clips: &[Clip], placed: bool) -> Result<Option<Warning>, Error> {
    let Some(order) = best_order(examples, clips, placed) else { return Ok(None) };
    let other: Vec<_> = order.clips.iter().map(|&clip| clips[clip].name.clone()).collect();
    if order.is_one_of_several {
        let given: Vec<_> = clips.iter().map(|clip| clip.name.as_str()).collect();
        return Err(Error::mismatch(format!(
            "its meshes do not follow the scene's clips in their order, {}, but may in several others, as {}: export \
             the meshes over the clips in the scene's order",
            given.join(", "),
            other.join(", ")
        )));
    }
    take_meshes(examples, &order.frames(clips));
    Ok(Some(Warning::ClipsSorted { clips: other, percent: order.percent }))
}

/// Checks the number of posed meshes.
///
/// - `missing`: files missing from a numbered sequence.
fn check_frames(clips: &[Clip], meshes: &PosedMeshes, missing: Vec<String>) -> Result<(), Error> {
    let (expected, found) = (frame_len(clips), meshes.frame_len());
    if expected == found {
        return Ok(());
    }
    // A numbered sequence may also skip the frames between clips.
    let explains = found + missing.len() == expected;
    let remedy = match missing.as_slice() {
        [one] if explains => format!("{one} is missing"),
        [one, two] if explains => format!("{one} and {two} are missing"),
        [one, others @ ..] if explains => {
            format!("{one} and {} others are missing", others.len())
        }
        _ => "export both over the same frames, choose the clip with --clip, or sample it at the meshes' rate with \
              --fps"
            .to_owned(),
    };
    let clips: Vec<_> = clips.iter().map(Clip::describe).collect();
    Err(Error::mismatch(format!(
        "holds {found} meshes, the scene's clips have {expected} frames ({}): {remedy}",
        clips.join(", ")
    )))
}

/// Divides maps by the scale from the mesh's unit to the joints' unit, and returns the scale. Idle joints are ignored.
///
/// The scale is the one that all maps have, up to rounding. If joints stretch, or the character is scaled in some frames,
/// the scale is the median over the joints without animation. A median near 1 is noise, and the scale is then 1.
///
/// - `maps`: of all joints, frame-major.
/// - `at_rest`: without animation, J.
/// - `idle`: whether each joint is idle, J.
pub(super) fn unscale(maps: &mut [Matrix4<f64>], at_rest: &[Matrix4<f64>], idle: &[bool]) -> f64 {
    let scales = |maps: &[Matrix4<f64>]| -> Vec<f64> {
        let moving = maps.iter().zip(idle.iter().cycle()).filter(|(_, idle)| !**idle);
        moving.map(|(map, _)| map.fixed_view::<3, 3>(0, 0).determinant().abs().cbrt()).collect()
    };
    let all = scales(maps);
    let Some(&first) = all.first() else { return 1.0 };
    let is_shared = all.iter().all(|scale| (scale / first - 1.0).abs() < RIGID);
    let (scale, noise) = match is_shared {
        true => (first, RIGID),
        false => (median(scales(at_rest)), REPAIRABLE),
    };
    if (scale - 1.0).abs() <= noise || !scale.is_normal() {
        return 1.0;
    }
    maps.iter_mut().for_each(|map| map.fixed_view_mut::<3, 3>(0, 0).unscale_mut(scale));
    scale
}

/// Returns the middle of some numbers, or the upper one of two; 1 without numbers.
fn median(mut all: Vec<f64>) -> f64 {
    all.sort_by(f64::total_cmp);
    all.get(all.len() / 2).copied().unwrap_or(1.0)
}

/// Returns the rigid part of a joint's bind matrix, in the unit of the scaled rest mesh.
pub(super) fn rest_frame(bind: &Matrix4<f64>, scale: f64) -> Matrix4<f64> {
    let mut frame = Matrix4::identity();
    let svd = bind.fixed_view::<3, 3>(0, 0).into_owned().svd(true, true);
    if let (Some(u), Some(v)) = (svd.u, svd.v_t) {
        let turn: Matrix3<f64> = u * v;
        frame.fixed_view_mut::<3, 3>(0, 0).copy_from(&(turn * turn.determinant().signum()));
    }
    let origin = bind.fixed_view::<3, 1>(0, 3) * scale;
    frame.fixed_view_mut::<3, 1>(0, 3).copy_from(&origin);
    frame
}

pub(super) fn rows(map: &Matrix4<f64>) -> Matrix3x4 {
    std::array::from_fn(|row| std::array::from_fn(|column| map[(row, column)]))
}
