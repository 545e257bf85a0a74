//! glTF 2.0: reads characters, posed meshes, shapes and motion, as a viewer shows them.

mod curves;
mod file;
mod keys;
mod meshes;
mod nodes;
pub(crate) mod rigged;
mod skins;
#[cfg(test)]
mod tests;
pub(crate) mod write;

use super::FormatWarning;
use super::mesh::{Mesh, MeshFile, ShapedMesh};
use super::posed_meshes::{Part, PosedMeshes};
use super::scene::{JointNames, Motion, MotionJoints, SampledScene, Sampling, faults};
use crate::Error;
use file::Parsed;
use meshes::{Meshes, Wanted, Welded};
use nalgebra::Vector3;
use rayon::prelude::*;
use rigged::shown_meshes;
use serde_json::Value;
use sinew_runtime::format::Space;
use skins::{Scene, Skins, move_mesh};
use std::path::Path;

/// Reads a rigged character: every mesh with a skin, its joints, and every clip that moves them.
///
/// # Errors
/// The file cannot be read, or a part is missing or damaged.
pub(crate) fn read(path: &Path, sampling: &Sampling<'_>) -> Result<SampledScene, Error> {
    let parsed = file::open(path)?;
    let wanted = Wanted { skinned_only: true, default_shape: true };
    let mut meshes = Meshes::required(&parsed, wanted)?;
    let skins = Skins::read(&parsed, &mut meshes, !sampling.shapes)?;
    let mut warnings = Vec::from_iter(skins.neutral(&parsed.nodes, &meshes));
    warnings.extend(meshes.warnings().chain(parsed.untargeted.clone()));
    let scene = Scene::new(&parsed, meshes, sampling.curves)?;
    let mut welded = Welded::new(&scene.meshes);
    let (names, equal) = parsed.nodes.tree.unique_names(|node| skins.joints.contains(&node));
    warnings.extend(welded.repaired.take().into_iter().chain(equal));
    let (clips, moments) = scene.sample(&skins.joints, sampling, &mut warnings)?;
    let posed: Vec<_> = moments
        .par_iter()
        .map(|moment| {
            let (locals, weights) = scene.at(moment);
            let worlds = scene.nodes.worlds(&locals);
            let joints: Vec<_> = skins.joints.iter().map(|&node| worlds[node]).collect();
            let shape = sampling.shapes.then(|| scene.skinned(&skins, &worlds, &weights));
            let shape = shape.map(|shape| welded.pick(&shape));
            (joints, shape.unwrap_or_default())
        })
        .collect();
    let (frames, shapes): (Vec<_>, Vec<_>) = posed.into_iter().unzip();
    let mut clips_played = moments.iter().filter_map(|moment| moment.clip);
    let morphs = clips_played.any(|clip| clip.shapes(|node| scene.shows(node)));
    let at_rest = scene.nodes.worlds(&scene.nodes.locals);
    Ok(SampledScene {
        at_rest: skins.joints.iter().map(|&node| at_rest[node]).collect(),
        curves: scene.curves(&moments),
        rest: welded.pick(&scene.meshes.positions),
        ranges: welded.ranges(&scene.meshes),
        joint_weights: Some(skins.weights_of(&scene.meshes, &welded.firsts)),
        triangles: welded.triangles,
        engine: welded.engine,
        space: Space::GLTF,
        names: skins.joints.iter().map(|&node| names[node].clone()).collect(),
        parents: scene.nodes.tree.parents_among(&skins.joints),
        binds: skins.binds,
        frames: frames.concat(),
        shapes: sampling.shapes.then(|| shapes.concat()),
        morphs,
        clips,
        warnings,
    })
}

/// Reads posed meshes without joints. Every mesh is shaped by its morph targets, and moved by its skin or else by its
/// node.
///
/// # Errors
/// As [`read`], except that meshes may lack a skin. Also: no animation plays a morph target, and no mesh has a skin.
pub(crate) fn read_posed_meshes(path: &Path) -> Result<PosedMeshes, Error> {
    let parsed = file::open(path)?;
    let wanted = Wanted { skinned_only: false, default_shape: true };
    let mut meshes = Meshes::required(&parsed, wanted)?;
    let skins = Skins::read(&parsed, &mut meshes, false)?;
    let scene = Scene::new(&parsed, meshes, false)?;
    let plays = scene.animations.iter().any(|clip| clip.shapes(|node| scene.shows(node)));
    if !plays && skins.joints.is_empty() {
        return Err(Error::missing(
            "has neither a skin nor morph targets that an animation plays, and so no shapes to learn: \
             export the shapes' keys with the animation, or give the posed meshes as .abc, .pc2, .mdd, .npz \
             or numbered .obj",
        ));
    }
    let instances = &scene.meshes.instances;
    let unskinned = instances.iter().filter(|instance| instance.skin.is_none());
    let moving = skins.joints.iter().copied().chain(unskinned.map(|instance| instance.node));
    let moving: Vec<usize> = moving.collect();
    let sampling = Sampling {
        fps: None,
        clips: &[],
        shapes: true,
        still: false,
        played: false,
        curves: false,
    };
    let (_, moments) = scene.sample(&moving, &sampling, &mut Vec::new())?;
    let shapes: Vec<_> = moments
        .par_iter()
        .map(|moment| {
            let (locals, weights) = scene.at(moment);
            scene.skinned(&skins, &scene.nodes.worlds(&locals), &weights)
        })
        .collect();
    let parts = instances.iter().enumerate().map(|(number, instance)| Part {
        names: vec![instance.name.clone()],
        range: scene.meshes.vertices(number),
    });
    Ok(PosedMeshes {
        parts: parts.collect(),
        reference: Some(scene.meshes.positions.clone()),
        ..PosedMeshes::bare(scene.meshes.positions.len(), shapes.concat())
    })
}

/// Reads the meshes of a file as one mesh: skinned meshes in their bind pose; without any skin, all meshes as their
/// nodes place them.
///
/// # Errors
/// The file cannot be read, or a part is missing or damaged.
pub(in crate::formats) fn read_mesh(path: &Path) -> Result<MeshFile, Error> {
    let parsed = file::open(path)?;
    let skinned_only = shown_meshes(&parsed).iter().any(|(_, node)| node.skin().is_some());
    let mut meshes = Meshes::required(&parsed, Wanted { skinned_only, default_shape: true })?;
    Skins::read(&parsed, &mut meshes, true)?;
    let worlds = parsed.nodes.worlds(&parsed.nodes.locals);
    for instance in 0..meshes.instances.len() {
        if meshes.instances[instance].skin.is_none() {
            let world = worlds[meshes.instances[instance].node];
            move_mesh(&mut meshes, instance, &world);
        }
    }
    let welded = Welded::new(&meshes);
    let positions = welded.pick(&meshes.positions);
    let Welded { triangles, engine, repaired, .. } = welded;
    let warnings = meshes.warnings().chain(repaired).collect();
    let mesh = Mesh { positions, triangles, engine }.checked()?;
    Ok(MeshFile { mesh, space: Some(Space::GLTF), warnings })
}

/// Reads the meshes with morph targets as one mesh; targets of one name on several meshes become one shape.
///
/// A mesh with a skin is in its bind pose; another mesh is placed by its node.
///
/// # Errors
/// The file cannot be read, or a part is missing or damaged.
pub(crate) fn read_shapes(path: &Path) -> Result<ShapedMesh, Error> {
    parse_shapes(&file::read(path)?, path)
}

/// Reads the motion of the nodes that are joints of a character, by name.
///
/// # Errors
/// The file cannot be read, or a part is missing or damaged.
pub(crate) fn read_motion(
    path: &Path,
    character: &[String],
    names: &JointNames<'_>,
    sampling: &Sampling<'_>,
) -> Result<Motion, Error> {
    let parsed = file::open(path)?;
    let tree = &parsed.nodes.tree;
    if tree.names.is_empty() {
        return Err(faults::empty());
    }
    // Skins that disagree have no common bind pose; the nodes then give the rest pose.
    let skins = Skins::all(&parsed).unwrap_or_default();
    let joints = MotionJoints::find(candidates(&parsed, &skins), character, names)?;
    let scene = Scene::new(&parsed, Meshes::default(), sampling.curves)?;
    let found = &joints.nodes;
    let mut warnings = Vec::from_iter(parsed.untargeted.clone());
    let (clips, moments) = scene.sample(found, sampling, &mut warnings)?;
    let at_rest = scene.nodes.worlds(&scene.nodes.locals);
    let binds = skins.binds_of_nodes(&parsed.nodes);
    let binds = found.iter().map(|&node| tree.bound(node, &binds, &at_rest));
    let frames = moments.iter().flat_map(|moment| {
        let worlds = scene.nodes.worlds(&scene.at(moment).0);
        found.iter().map(|&node| worlds[node]).collect::<Vec<_>>()
    });
    Ok(Motion {
        space: Space::GLTF,
        rest: found.iter().map(|&node| at_rest[node]).collect(),
        binds: binds.collect(),
        frames: frames.collect(),
        curves: scene.curves(&moments),
        joints,
        clips,
        warnings,
    })
}

/// Returns the names of the nodes that may be joints, if a file shows nodes but no mesh with a skin. `None` also for a
/// file that cannot be read.
pub(crate) fn joints_alone(path: &Path) -> Option<Vec<String>> {
    let parsed = file::open(path).ok()?;
    let wanted = Wanted { skinned_only: true, default_shape: true };
    let meshes = Meshes::read(&parsed, wanted).ok()?;
    if !meshes.instances.is_empty() || parsed.nodes.is_empty() {
        return None;
    }
    let skins = Skins::all(&parsed).unwrap_or_default();
    Some(candidates(&parsed, &skins).into_iter().map(|(_, name)| name).collect())
}

/// Lists the nodes that may be joints, with unique names; joints of skins come first.
///
/// Without a skin, every node without a mesh is a joint. If an armature has the name of a joint below it, only the joint
/// counts.
fn candidates(file: &Parsed, skins: &Skins) -> Vec<(usize, String)> {
    let tree = &file.nodes.tree;
    let shows: Vec<bool> = file.document.nodes().map(|node| node.mesh().is_some()).collect();
    let below = |node: usize, other: &usize| {
        let above = tree.upwards(*other).skip(1).any(|above| above == node);
        above && tree.names[*other] == tree.names[node] && !shows[*other]
    };
    let is_joint = |node: usize| match skins.joints.is_empty() {
        false => skins.joints.contains(&node),
        true => !shows[node] && !(0..shows.len()).any(|other| below(node, &other)),
    };
    tree.candidates(is_joint, |node| shows[node])
}

fn parse_shapes(bytes: &[u8], path: &Path) -> Result<ShapedMesh, Error> {
    let parsed = file::parse(bytes, path)?;
    let nodes = &parsed.nodes;
    let tree = file::tree(bytes)?;
    // Default weights are not part of a face at rest.
    let wanted = Wanted { skinned_only: false, default_shape: false };
    let mut meshes = Meshes::read(&parsed, wanted)?;
    let (shaped, plain): (Vec<_>, Vec<_>) =
        (0..meshes.instances.len()).partition(|&at| !meshes.instances[at].morphs.is_empty());
    if shaped.is_empty() {
        return Err(if nodes.is_empty() { faults::empty() } else { faults::no_shapes() });
    }
    let mut out = ShapedMesh { space: Space::GLTF, is_split: true, ..ShapedMesh::default() };
    out.warnings.extend(meshes.warnings());
    let plain = plain.iter().map(|&at| meshes.instances[at].name.clone()).collect();
    out.warnings.extend(FormatWarning::listed(FormatWarning::UnshapedMeshes, plain));
    let worlds = nodes.worlds(&nodes.locals);
    let [has_normals, _, has_uv] = meshes.authored;
    let mut normals = Vec::new();
    let mut place_of = vec![None; meshes.positions.len()];
    for &at in &shaped {
        if meshes.instances[at].skin.is_none() {
            let world = worlds[meshes.instances[at].node];
            move_mesh(&mut meshes, at, &world);
        }
        let (instance, first) = (&meshes.instances[at], out.positions.len());
        for vertex in meshes.vertices(at) {
            place_of[vertex] = Some(out.positions.len());
            out.positions.push(meshes.positions[vertex]);
            out.uv.push(meshes.uv[vertex]);
            let normal = Vector3::from(meshes.normals[vertex]);
            normals.push(normal.try_normalize(0.0).unwrap_or_default().into());
        }
        let mesh = parsed.document.nodes().nth(instance.node).and_then(|node| node.mesh());
        let names = mesh.map(|mesh| &tree["meshes"][mesh.index()]["extras"]["targetNames"]);
        for (target, deltas) in instance.morphs.iter().enumerate() {
            let name = names.and_then(|names| names.get(target)).and_then(Value::as_str);
            let name = name.map_or_else(|| format!("target {target}"), str::to_owned);
            out.add(&name, deltas.iter().enumerate().map(|(own, by)| (first + own, *by)));
        }
    }
    out.shapes.iter_mut().for_each(|shape| shape.deltas.resize(out.positions.len(), [0.0; 3]));
    let faces = meshes.triangles.iter().filter_map(|corners| {
        let [a, b, c] = corners.map(|corner| place_of[corner]);
        Some(vec![a?, b?, c?])
    });
    out.faces = faces.collect();
    match has_uv {
        true => out.uv_faces.clone_from(&out.faces),
        false => out.uv.clear(),
    }
    out.normals = has_normals.then_some(normals);
    Ok(out)
}
