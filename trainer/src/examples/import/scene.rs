//! Converts a scene, with separate posed meshes or its own, to examples.

use nalgebra::{Matrix3, Matrix4};

use super::align::{self, Similarity, is_shuffled};
use super::clips::{PosedClips, check_even, selected, selected_rows};
use super::matched::{arranged, matched};
use super::targets::TargetMeshes;
use crate::Error;
use crate::examples::joints::{idle, join_roots};
use crate::examples::validate::{Origin, numbers, vertex};
use crate::examples::{Clip, Examples, Matrix3x4, RIGID, Skeleton, Split, Warning};
use crate::formats::FormatWarning;
use crate::formats::posed_meshes::PosedMeshes;
use crate::formats::scene::{SampledScene, Sampling, faults};
use crate::mesh::Surface;

/// Unchecked examples, their clips, and warnings.
type Joined = (Examples, Vec<Clip>, Vec<Warning>);

/// Joins poses with posed meshes from `targets`, or with the scene's own meshes.
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
    targets: Option<TargetMeshes>,
    sampling: &Sampling<'_>,
) -> Result<Joined, Error> {
    let mut poses = ScenePoses::of(&mut scene)?;
    let Some(targets) = targets else {
        if !scene.morphs {
            poses.warnings.push(Warning::PlainSkin);
        }
        let vertices = scene.shapes.take().ok_or_else(no_shapes)?;
        let (mut examples, clips, warnings) = to_examples(scene, poses, vertices, None);
        examples.own_skin = true;
        return Ok((examples, clips, warnings));
    };
    // Checked first: otherwise positions that are not finite would be reported as far from the joints.
    targets.check_numbers(&scene.clips)?;
    if sampling.fps.is_none() {
        check_even(&scene.clips)?;
    }
    let path = targets.path.clone();
    let all = join_targets(scene, poses, targets).map_err(|error| error.in_file(path))?;
    Ok(cut(all, sampling))
}

/// Joins poses with posed meshes of all clips. Every error is about the posed meshes.
fn join_targets(
    mut scene: SampledScene,
    mut poses: ScenePoses,
    targets: TargetMeshes,
) -> Result<Joined, Error> {
    let TargetMeshes { meshes, mut split, missing, .. } = targets;
    let surface = Surface {
        positions: &scene.rest,
        triangles: &scene.triangles,
        engine: scene.engine.as_ref(),
    };
    let meshes = arranged(&scene.ranges, scene.rest.len(), meshes, &mut poses.warnings);
    let meshes = matched(&surface, meshes)?;
    check_frames(&scene, &meshes, missing)?;
    let PosedMeshes { mut vertices, rest, triangles, .. } = meshes;
    let clips = &scene.clips;
    match rest {
        Some(rest) => {
            let similarity = align::meshes(&scene.rest, &rest).map_err(align::targets_apart)?;
            similarity.move_joints(&mut poses.skeleton, &mut poses.transforms);
            scene.space = similarity.space(&scene.space);
            poses.report_move(&similarity, "joints");
            poses.sort(&rest, &mut vertices, &mut split, clips, true)?;
            scene.rest = rest;
            similarity.turn(scene.engine.as_mut());
            // Authored data belongs to the scene's own triangles.
            let others = triangles.filter(|_| scene.engine.is_none());
            scene.triangles = others.unwrap_or(scene.triangles);
        }
        None => {
            poses.sort(&scene.rest, &mut vertices, &mut split, clips, false)?;
            let similarity = align::poses(&scene.rest, &poses.transforms, &vertices);
            let similarity = similarity.map_err(|error| {
                let shuffled = is_shuffled(&scene.rest, &poses.transforms, &vertices);
                if shuffled { vertex_order() } else { error }
            })?;
            similarity.move_points(&mut vertices);
            poses.report_move(&similarity, "targets");
        }
    }
    let weights = scene.joint_weights.as_deref().unwrap_or_default();
    let rows = weights.chunks_exact(scene.names.len().max(1));
    let count = rows.filter(|row| row.iter().all(|weight| *weight == 0.0)).count();
    if count > 0 {
        let unweighted = FormatWarning::Unweighted { count, follow: "the targets" };
        poses.warnings.push(unweighted.into());
    }
    Ok(to_examples(scene, poses, vertices, split))
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
fn cut((mut examples, clips, mut warnings): Joined, sampling: &Sampling<'_>) -> Joined {
    let held = examples.frame_len();
    let (clips, frames) = selected(clips, sampling);
    let Some(frames) = frames else { return (examples, clips, warnings) };
    let names = clips.iter().map(|clip| clip.name.clone()).collect();
    warnings.push(Warning::TargetsCut { clips: names, frames: frames.len(), held });
    let (vertex_len, joint_len) = (examples.vertex_len(), examples.joint_len());
    examples.vertices = selected_rows(examples.vertices, vertex_len, Some(&frames));
    examples.transforms = selected_rows(examples.transforms, joint_len, Some(&frames));
    examples.split = selected_rows(examples.split, 1, Some(&frames));
    (examples, clips, warnings)
}

/// Returns the poses with the rest mesh in every frame.
///
/// # Errors
/// A bind matrix has no inverse, a number is not finite, or a number of the rest mesh is too large.
pub(super) fn still(mut scene: SampledScene) -> Result<Joined, Error> {
    let poses = ScenePoses::of(&mut scene)?;
    let vertices = scene.rest.repeat(frame_len(&scene));
    Ok(to_examples(scene, poses, vertices, None))
}

/// Poses of a scene, as maps from the rest pose.
struct ScenePoses {
    skeleton: Skeleton,
    transforms: Vec<Matrix3x4>,
    warnings: Vec<Warning>,
}

impl ScenePoses {
    /// Converts a scene's poses to maps from the rest pose, on a skeleton with one root. The maps are rigid if the
    /// scene's are.
    ///
    /// Mesh and joints of a scene may have different units. The rest mesh is scaled to the joints' unit.
    ///
    /// # Errors
    /// A bind matrix has no inverse, a number is not finite, or a number of the rest mesh is too large.
    fn of(scene: &mut SampledScene) -> Result<Self, Error> {
        let origin = Origin::SCENE;
        numbers(origin.rest, scene.rest.iter().map(<[_; 3]>::as_slice), None, vertex, |_| true)?;
        let joint = |number: usize| format!("joint {}", scene.names[number]);
        let frames = scene.frames.iter().map(Matrix4::as_slice);
        numbers(origin.pose, frames, Some(scene.binds.len()), joint, |_| false)?;
        let mut inverses = Vec::with_capacity(scene.binds.len());
        for (bind, name) in scene.binds.iter().zip(&scene.names) {
            inverses.push(bind.try_inverse().ok_or_else(|| faults::singular_bind(name))?);
        }
        let joint_len = scene.binds.len().max(1);
        let maps = scene.frames.iter().enumerate();
        let mut maps: Vec<_> =
            maps.map(|(number, frame)| frame * inverses[number % joint_len]).collect();
        let idle = idle(scene.joint_weights.as_deref(), &scene.parents);
        let scale = unscale(&mut maps, &idle);
        for position in scene.rest.as_flattened_mut() {
            *position *= scale;
        }
        let mut warnings = scene.warnings.drain(..).map(Warning::from).collect();
        let (parents, roots) = join_roots(&scene.names, scene.parents.clone(), &mut warnings);
        let rest = scene.binds.iter().map(|bind| rows(&rest_frame(bind, scale))).collect();
        let skeleton =
            Skeleton { names: scene.names.clone(), parents, roots, unplaced: Vec::new(), rest };
        Ok(Self { skeleton, transforms: maps.iter().map(rows).collect(), warnings })
    }

    /// Sorts posed meshes (N x V) and the split into the clips' order, if they follow another order.
    ///
    /// # Errors
    /// Several orders fit.
    fn sort(
        &mut self,
        rest: &[[f64; 3]],
        vertices: &mut Vec<[f64; 3]>,
        split: &mut Option<Vec<Split>>,
        clips: &[Clip],
        placed: bool,
    ) -> Result<(), Error> {
        let lens: Vec<usize> = clips.iter().map(|clip| clip.times.len()).collect();
        let transforms = &self.transforms;
        let given = PosedClips { rest, transforms, posed: vertices, lens: &lens, placed };
        let Some(order) = given.order() else { return Ok(()) };
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
        *vertices = order.sorted(vertices, rest.len(), &lens);
        if let Some(split) = split {
            *split = order.sorted(split, 1, &lens);
        }
        self.warnings.push(Warning::ClipsSorted { clips: other, percent: order.percent });
        Ok(())
    }

    fn report_move(&mut self, similarity: &Similarity, what: &'static str) {
        if !similarity.is_identity() {
            self.warnings.push(Warning::Moved { what, how: similarity.to_string() });
        }
    }
}

fn to_examples(
    scene: SampledScene,
    poses: ScenePoses,
    vertices: Vec<[f64; 3]>,
    split: Option<Vec<Split>>,
) -> Joined {
    let split = split.unwrap_or_else(|| vec![Split::Train; frame_len(&scene)]);
    let SampledScene { rest, triangles, engine, ranges, joint_weights, space, clips, .. } = scene;
    let ScenePoses { skeleton, transforms, mut warnings } = poses;
    let mut examples = Examples {
        rest,
        triangles,
        engine,
        skeleton,
        vertices,
        transforms,
        split,
        ranges,
        clip_starts: clips.iter().map(|clip| clip.first).collect(),
        space,
        joint_weights,
        importance: None,
        frame_weights: None,
        own_skin: false,
    };
    warnings.extend(examples.unscale_idle_joints());
    (examples, clips, warnings)
}

/// Counts the frames of a scene's clips.
pub(super) fn frame_len(scene: &SampledScene) -> usize {
    scene.clips.iter().map(|clip| clip.times.len()).sum()
}

fn check_frames(
    scene: &SampledScene,
    meshes: &PosedMeshes,
    mut missing: Vec<String>,
) -> Result<(), Error> {
    let (expected, found) = (frame_len(scene), meshes.frame_len());
    if expected != found {
        let clips: Vec<_> = scene.clips.iter().map(Clip::describe).collect();
        // A numbered sequence may also skip the frames between clips.
        if found + missing.len() != expected {
            missing.clear();
        }
        return Err(Error::mismatch(format!(
            "holds {found} meshes, the scene's clips have {expected} frames ({}): {}",
            clips.join(", "),
            remedy(&missing)
        )));
    }
    Ok(())
}

/// Returns the advice for a wrong number of meshes.
///
/// - `missing`: files missing from a numbered sequence.
fn remedy(missing: &[String]) -> String {
    match missing {
        [] => "export both over the same frames, choose the clip with --clip, or sample it at the meshes' rate with \
               --fps"
            .to_owned(),
        [one] => format!("{one} is missing"),
        [one, two] => format!("{one} and {two} are missing"),
        [one, others @ ..] => format!("{one} and {} others are missing", others.len()),
    }
}

/// Divides maps by their common scale and returns the scale. Returns 1 if the maps are rigid or have no common scale,
/// which the checks of examples then report. Idle joints are ignored.
///
/// - `maps`: of all joints, frame-major.
/// - `idle`: whether each joint is idle.
pub(super) fn unscale(maps: &mut [Matrix4<f64>], idle: &[bool]) -> f64 {
    let scale = |map: &Matrix4<f64>| map.fixed_view::<3, 3>(0, 0).determinant().abs().cbrt();
    let mut scales =
        maps.iter().zip(idle.iter().cycle()).filter(|(_, idle)| !**idle).map(|(map, _)| scale(map));
    let Some(first) = scales.next() else { return 1.0 };
    let shared = scales.all(|scale| (scale / first - 1.0).abs() < RIGID);
    if !shared || (first - 1.0).abs() <= RIGID || !first.is_normal() {
        return 1.0;
    }
    maps.iter_mut().for_each(|map| map.fixed_view_mut::<3, 3>(0, 0).unscale_mut(first));
    first
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
