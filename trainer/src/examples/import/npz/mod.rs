//! Examples as NumPy arrays: `X.npz`, with words and a few numbers in `X.json` beside it.
//!
//! | array | shape | |
//! |---|---|---|
//! | `rest` | V, 3 | rest positions |
//! | `quads`, `tris` | F, 4 and F, 3 | faces, at least one array; quads come first and are split into corners 0 1 2 and 0 2 3 |
//! | `vertices` | N, V, 3 | posed positions |
//! | `bone_transforms` | N, J, 4, 4 | rest pose to pose, for column vectors |
//! | `bone_names`, `bone_parents` | J | optional if the JSON has them; parent -1 is a root |
//! | `curves` | N, C | optional values of animation curves, 0 at rest; the rows about joints may then be missing |
//! | `curve_names` | C | names of the curves, optional if the JSON has them |
//! | `split` | N | optional: 0 train, 1 held out, 2 extreme; all train without it |
//! | `joint_world_rest` | J, 4, 4 | optional: rest frames of the joints |
//! | `uv` | U, 2 | optional texture coordinates, v upward; U = V without the next row |
//! | `quads_uv`, `tris_uv` | as `quads`, `tris` | optional: `uv` index of each corner; also `uv_quads`, `uv_tris` |
//! | `normals` | M, 3 | optional authored normals; M = V without the next row |
//! | `quads_normals`, `tris_normals` | as `quads`, `tris` | optional: `normals` index of each corner; differs at hard edges |
//! | `clip_names`, `clip_starts` | C | optional clips and their first frames: 0, then ascending; else one clip, named after the file |
//! | `fps` | | optional frames per second, 30 without |
//! | `frame_numbers` | N | optional: frame numbers of the source, whole and ascending in each clip |
//! | `mesh_names`, `mesh_starts` | M | optional joined meshes and their first vertices: 0, then ascending |
//! | `joint_weights` | V, J | optional: painted joint weights, which show the joints near a vertex |
//! | `importance` | V | optional: weight of each vertex; only ratios matter |
//! | `frame_weights` | N | optional: number of times each frame counts in a fit, whole numbers from 1 to 100 |
//! | `up`, `forward` | | optional axes: `x`, `-x`, `y`, `-y`, `z` or `-z` |
//! | `handedness` | | optional: `right` (default) or `left` |
//! | `unit` | | optional metres per unit of length |
//!
//! The JSON may hold `bone_names`, `curve_names`, `bone_parents` (numbers or names), and `joint_rest_positions` (name to x y z), used
//! without `joint_world_rest`. It may also hold the names and starts of clips and meshes, `fps`, axes, handedness and
//! unit. The JSON takes precedence over the arrays. Other content of both files is ignored. Numbers may have any width
//! and byte order. A single number or word may have one dimension or none.

mod fields;
mod save;
mod sidecar;

use std::path::Path;

pub use save::save_npz;

use self::fields::{
    FACES, MESHES, read_clips, read_curves, read_each, read_engine, read_faces, read_joint_weights,
    read_runs, read_space, read_split,
};
use self::sidecar::{Parent, Sidecar};
use super::clips::{selected, selected_rows};
use super::joined::Loaded;
use crate::Error;
use crate::examples::data::translation;
use crate::examples::distortion::REPAIRABLE;
use crate::examples::joints::join_roots;
use crate::examples::validate::{distorted, missing_parent, same};
use crate::examples::{Distortion, Examples, Matrix3x4, Skeleton, Split, Warning, numbered};
use crate::formats::FormatWarning;
use crate::formats::npz::{Archive, Rows, missing};
use crate::formats::posed_meshes::PosedMeshes;
use crate::formats::scene::Sampling;

/// Loads examples from `path` and the JSON beside it, if there is one.
///
/// If there are several roots, the first becomes the parent of the others. A joint without a rest origin in either file
/// gets an estimate: the point that the joint and its parent move together best.
///
/// # Errors
/// A file cannot be read, lacks an array, has an array of another type or shape, or fails [`Examples::validate`]; the
/// error names the file.
pub fn load(path: &Path) -> Result<Loaded, Error> {
    let all = Sampling {
        fps: None,
        clips: &[],
        shapes: true,
        still: false,
        played: false,
        curves: false,
    };
    Ok(load_clips(path, &all)?.0)
}

/// Loads the requested clips to be played, at the requested rate or at the file's rate.
///
/// # Errors
/// As [`load_clips`].
pub(super) fn load_played(path: &Path, sampling: &Sampling<'_>) -> Result<Loaded, Error> {
    let (mut loaded, rate) = load_clips(path, sampling)?;
    match sampling.fps {
        Some(fps) => loaded.clips.iter_mut().for_each(|clip| clip.play_at(fps)),
        None if rate.is_none() && loaded.clips.iter().any(|clip| clip.times.len() > 1) => {
            loaded.warnings.push(Warning::NoRate);
        }
        None => {}
    }
    Ok(loaded)
}

/// Reads posed meshes: `vertices`; `rest` and faces, if present; and `split`, the use of each frame.
pub(super) fn read_posed_meshes(path: &Path) -> Result<(PosedMeshes, Option<Vec<Split>>), Error> {
    let mut archive = Archive::open(path)?;
    let Rows { lead, data: vertices } = archive.required::<f64, 3>("vertices", &[0, 3])?;
    let (frame_len, vertex_len) = (lead[0], lead[1]);
    let rest = archive.rows::<f64, 3>("rest", &[3])?.map(|rest| rest.data);
    if let Some(rest) = &rest {
        same("vertices", "rest", rest.len(), "vertices", vertex_len)?;
    }
    let faces = read_faces(&mut archive, FACES, vertex_len)?;
    let triangles = faces.map(|faces| faces.triangles);
    let split = read_split(&mut archive, frame_len)?;
    Ok((PosedMeshes { rest, triangles, ..PosedMeshes::bare(vertex_len, vertices) }, split))
}

/// Loads the requested clips like [`load`], and the frame rate if given.
///
/// # Errors
/// As [`load`]; also if a requested clip does not exist.
pub(super) fn load_clips(
    path: &Path,
    sampling: &Sampling<'_>,
) -> Result<(Loaded, Option<f64>), Error> {
    let beside = path.with_extension("json");
    let sidecar = Sidecar::read(&beside).map_err(|error| error.in_file(&beside))?;
    let archive = Archive::open(path);
    archive
        .and_then(|archive| read(archive, &sidecar, path, sampling))
        .map_err(|error| error.in_file(path))
}

fn read(
    mut archive: Archive,
    sidecar: &Sidecar,
    path: &Path,
    sampling: &Sampling<'_>,
) -> Result<(Loaded, Option<f64>), Error> {
    let has_joints = sidecar.bone_names.is_some()
        || ["bone_names", "bone_parents", "bone_transforms"].iter().any(|array| archive.has(array));
    let has_curves = archive.has("curves");
    if archive.has("vertices") && !has_joints && !has_curves {
        return Err(meshes_alone());
    }
    let rest = archive.required::<f64, 3>("rest", &[3])?.data;
    let faces = read_faces(&mut archive, FACES, rest.len())?;
    let faces = faces.ok_or_else(|| missing("quads or tris"))?;
    let (engine, repaired) = read_engine(&mut archive, &rest, &faces)?;

    let Rows { lead, data: vertices } = archive.required::<f64, 3>("vertices", &[0, 3])?;
    let (frame_len, posed_len) = (lead[0], lead[1]);
    same("vertices", "rest", rest.len(), "vertices", posed_len)?;
    let (clips, fps) = read_clips(&mut archive, sidecar, path, frame_len)?;
    let repaired = FormatWarning::repaired(repaired);
    let mut warnings: Vec<Warning> = repaired.into_iter().map(Warning::from).collect();
    let (skeleton, matrices) = if has_joints || !has_curves {
        read_joints(&mut archive, sidecar, frame_len, &mut warnings)?
    } else {
        let still = (0..frame_len).map(|_| STILL).collect();
        (Skeleton::still(), still)
    };
    let joint_len = skeleton.names.len();
    let (curve_names, curves) = read_curves(&mut archive, sidecar, frame_len)?;
    let split = read_split(&mut archive, frame_len)?;
    let split = split.unwrap_or_else(|| vec![Split::Train; frame_len]);
    let stated = (&sidecar.mesh_names, &sidecar.mesh_starts);
    let ranges = read_runs(&mut archive, &MESHES, stated, rest.len())?.unwrap_or_default();
    let joint_weights = read_joint_weights(&mut archive, [rest.len(), joint_len])?;
    let importance = read_each(&mut archive, "importance", ("vertices", "rest", rest.len()))?;
    let weights =
        read_each::<f64>(&mut archive, "frame_weights", ("frames", "vertices", frame_len))?;
    let space = read_space(&mut archive, sidecar)?;

    let known = clips.iter().map(|clip| clip.name.clone()).collect();
    sampling.check(known)?;
    let (clips, kept_frames) = selected(clips, sampling);
    let kept_frames = kept_frames.as_deref();
    let vertices = selected_rows(vertices, rest.len(), kept_frames);
    let matrices = selected_rows(matrices, joint_len, kept_frames);
    let split = selected_rows(split, 1, kept_frames);
    let weights = weights.map(|weights| selected_rows(weights, 1, kept_frames));
    let curves = selected_rows(curves, curve_names.len(), kept_frames);
    let transforms = affine(&matrices, Some(&split), &skeleton.names);
    let transforms = transforms.map_err(|error| numbered(error, &clips))?;
    drop(matrices);

    let mut examples = Examples {
        rest,
        triangles: faces.triangles,
        engine,
        skeleton,
        vertices,
        transforms,
        curve_names,
        curves,
        split,
        ranges,
        clip_starts: clips.iter().map(|clip| clip.first).collect(),
        space,
        joint_weights,
        ..Examples::default()
    };
    if let Some(importance) = importance {
        examples.set_importance(importance)?;
    }
    if let Some(weights) = weights {
        examples.repeat(&weights).map_err(|error| numbered(error, &clips))?;
    }
    warnings.extend(examples.unscale());
    let found = examples.validate().map_err(|error| numbered(error, &clips))?;
    warnings.extend(found.into_iter().map(|warning| warning.called(&clips)));
    examples.place_joints();
    Ok((Loaded { examples, clips, warnings }, fps))
}

/// Identity, as a matrix of a file.
const STILL: [f64; 16] =
    [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];

/// Reads the joints, and the N x J matrices of their poses.
fn read_joints(
    archive: &mut Archive,
    sidecar: &Sidecar,
    frame_len: usize,
    warnings: &mut Vec<Warning>,
) -> Result<(Skeleton, Vec<[f64; 16]>), Error> {
    let Rows { lead, data: matrices } =
        archive.required::<f64, 16>("bone_transforms", &[0, 4, 4])?;
    same("frames", "vertices", frame_len, "bone_transforms", lead[0])?;
    let joint_len = lead[1];
    let names = match &sidecar.bone_names {
        Some(names) => names.clone(),
        None => archive.texts("bone_names")?.ok_or_else(|| missing("bone_names"))?,
    };
    same("joints", "bone_names", names.len(), "bone_transforms", joint_len)?;
    let (parents, roots) = read_parents(archive, sidecar, &names, warnings)?;
    let frames = archive.rows::<f64, 16>("joint_world_rest", &[4, 4])?;
    let rest = match &frames {
        Some(frames) => {
            same("joints", "bone_names", joint_len, "joint_world_rest", frames.data.len())?;
            affine(&frames.data, None, &names)?
        }
        None => vec![translation([0.0; 3]); joint_len],
    };
    let mut skeleton = Skeleton { names, parents, roots, rest, ..Skeleton::default() };
    if frames.is_none() {
        place(&mut skeleton, sidecar)?;
    }
    Ok((skeleton, matrices))
}

/// Creates the error of a file of posed meshes that is given as a scene.
pub(super) fn meshes_alone() -> Error {
    Error::missing(
        "holds posed meshes, but no joints to learn from: give the scene with the joints (.fbx, .glb, .gltf), and this \
         file as --targets",
    )
}

/// Reads the parent of each joint, and makes the first root the parent of the other roots. Also returns the other
/// roots.
fn read_parents(
    archive: &mut Archive,
    sidecar: &Sidecar,
    names: &[String],
    warnings: &mut Vec<Warning>,
) -> Result<(Vec<Option<usize>>, Vec<usize>), Error> {
    let parents = match &sidecar.bone_parents {
        Some(parents) => parents.clone(),
        None => {
            let numbers = archive.required::<i64, 1>("bone_parents", &[])?.data;
            numbers.into_iter().map(|[number]| Some(Parent::Number(number))).collect()
        }
    };
    same("joints", "bone_names", names.len(), "bone_parents", parents.len())?;
    let mut found = Vec::with_capacity(names.len());
    for (joint, parent) in names.iter().zip(parents) {
        found.push(match parent {
            None | Some(Parent::Number(-1)) => None,
            Some(Parent::Number(number)) => {
                let inside = usize::try_from(number).ok().filter(|&inside| inside < names.len());
                Some(inside.ok_or_else(|| missing_parent(joint, number))?)
            }
            Some(Parent::Name(name)) => {
                let number = names.iter().position(|other| *other == name);
                Some(number.ok_or_else(|| missing_parent(joint, name))?)
            }
        });
    }
    Ok(join_roots(names, found, warnings))
}

/// Removes the last row of 4 x 4 matrices, which must be 0 0 0 1 in training frames.
fn affine(
    matrices: &[[f64; 16]],
    frames: Option<&[Split]>,
    names: &[String],
) -> Result<Vec<Matrix3x4>, Error> {
    let mut maps = Vec::with_capacity(matrices.len());
    for (number, matrix) in matrices.iter().enumerate() {
        let row = |row: usize| [0, 1, 2, 3].map(|column| matrix[4 * row + column]);
        let last = row(3).into_iter().zip([0.0, 0.0, 0.0, 1.0]);
        let deviation = last.map(|(found, wanted)| (found - wanted).abs()).fold(0.0, f64::max);
        let frame = frames.map(|_| number / names.len());
        let read = frames.is_none_or(|split| split[number / names.len()] == Split::Train);
        if deviation > REPAIRABLE && read {
            return Err(distorted(&names[number % names.len()], &Distortion::Projects, frame));
        }
        maps.push([row(0), row(1), row(2)]);
    }
    Ok(maps)
}

/// Sets the rest positions given in the JSON; marks other joints as unplaced.
fn place(skeleton: &mut Skeleton, sidecar: &Sidecar) -> Result<(), Error> {
    let is_unplaced =
        |joint: &usize| !sidecar.joint_rest_positions.contains_key(&skeleton.names[*joint]);
    skeleton.unplaced = (0..skeleton.names.len()).filter(is_unplaced).collect();
    for (name, &position) in &sidecar.joint_rest_positions {
        let Some(joint) = skeleton.names.iter().position(|joint| joint == name) else {
            return Err(Error::missing(format!(
                "joint_rest_positions names joint {name}, which does not exist"
            )));
        };
        skeleton.rest[joint] = translation(position);
    }
    Ok(())
}

#[cfg(test)]
mod tests;
