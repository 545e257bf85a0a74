//! glTF 2.0: reads characters, posed meshes, shapes and motion, as a viewer shows them.

mod file;
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
use super::scene::{
    JointNames, Motion, MotionJoints, SampledScene, Sampling, bound, faults, unique_names,
};
use crate::Error;
use ::gltf::Document;
use file::Parsed;
use meshes::{Meshes, Wanted, Welded};
use nalgebra::{Matrix4, Vector3};
use nodes::{ClipKeys, Nodes};
use rayon::prelude::*;
use rigged::shown_meshes;
use serde_json::Value;
use sinew_runtime::format::Space;
use skins::{Scene, Skins, move_mesh, no_skin, normal_matrix};
use std::path::Path;

/// Reads a rigged character: every mesh with a skin, its joints, and every clip that moves them.
///
/// # Errors
/// The file cannot be read, or a part is missing or damaged.
pub(crate) fn read(path: &Path, sampling: &Sampling<'_>) -> Result<SampledScene, Error> {
    let parsed = file::open(path)?;
    let Parsed { document, buffers, .. } = &parsed;
    let nodes = Nodes::read(document)?;
    let shown = nodes.shown(document);
    let wanted = Wanted { skinned_only: true, default_shape: true };
    let mut meshes = Meshes::read(document, buffers, |node| shown[node], wanted)?;
    if meshes.instances.is_empty() {
        return Err(match meshes.unskinned.is_empty() {
            _ if !shown.contains(&true) => faults::empty(),
            true => faults::no_mesh(),
            false => no_skin(),
        });
    }
    let skins = Skins::read(document, buffers, &nodes, &mut meshes, !sampling.shapes)?;
    let mut warnings = Vec::from_iter(skins.neutral(&nodes, &meshes));
    warnings.extend(meshes.warnings().chain(parsed.warning()));
    let scene = Scene::new(nodes, meshes, ClipKeys::read(document, buffers)?);
    let welded = Welded::new(&scene.meshes);
    if welded.repaired > 0 {
        warnings.push(FormatWarning::NormalsRepaired { count: welded.repaired });
    }
    let (names, equal) = skins.names(&scene.nodes);
    warnings.extend(equal);
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
    let parents = scene.nodes.parents_among(&skins.joints);
    let names = skins.joints.iter().map(|&node| names[node].clone()).collect();
    let morphs = moments.iter().any(|moment| moment.clip.shapes(|node| scene.shows(node)));
    let ranges = scene.meshes.ranges().into_iter();
    let ranges = ranges.map(|(name, range)| (name, welded.range(&range))).collect();
    let joint_weights = skins.weights_of(&scene.meshes, &welded.firsts);
    let rest = welded.pick(&scene.meshes.positions);
    let Welded { triangles, engine, .. } = welded;
    Ok(SampledScene {
        rest,
        triangles,
        engine,
        ranges,
        joint_weights: Some(joint_weights),
        space: Space::GLTF,
        names,
        parents,
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
    let Parsed { document, buffers, .. } = file::open(path)?;
    let nodes = Nodes::read(&document)?;
    let shown = nodes.shown(&document);
    let wanted = Wanted { skinned_only: false, default_shape: true };
    let mut meshes = Meshes::read(&document, &buffers, |node| shown[node], wanted)?;
    if meshes.instances.is_empty() {
        let is_empty = !shown.contains(&true);
        return Err(if is_empty { faults::empty() } else { faults::no_mesh() });
    }
    let skins = Skins::read(&document, &buffers, &nodes, &mut meshes, false)?;
    let scene = Scene::new(nodes, meshes, ClipKeys::read(&document, &buffers)?);
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
    let sampling = Sampling { fps: None, clips: &[], shapes: true, still: false, played: false };
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
    let Parsed { document, buffers, .. } = file::open(path)?;
    let nodes = Nodes::read(&document)?;
    let shown = nodes.shown(&document);
    let skinned_only =
        shown_meshes(&document, &nodes).iter().any(|(_, node)| node.skin().is_some());
    let wanted = Wanted { skinned_only, default_shape: true };
    let mut meshes = Meshes::read(&document, &buffers, |node| shown[node], wanted)?;
    if meshes.instances.is_empty() {
        let is_empty = !shown.contains(&true);
        return Err(if is_empty { faults::empty() } else { faults::no_mesh() });
    }
    Skins::read(&document, &buffers, &nodes, &mut meshes, true)?;
    let worlds = nodes.worlds(&nodes.locals);
    for instance in 0..meshes.instances.len() {
        if meshes.instances[instance].skin.is_none() {
            let world = worlds[meshes.instances[instance].node];
            move_mesh(&mut meshes, instance, &world);
        }
    }
    let welded = Welded::new(&meshes);
    let mut warnings: Vec<FormatWarning> = meshes.warnings().collect();
    if welded.repaired > 0 {
        warnings.push(FormatWarning::NormalsRepaired { count: welded.repaired });
    }
    let positions = welded.pick(&meshes.positions);
    let Welded { triangles, engine, .. } = welded;
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
    let Parsed { document, buffers, .. } = &parsed;
    let nodes = Nodes::read(document)?;
    if nodes.names.is_empty() {
        return Err(faults::empty());
    }
    // Skins that disagree have no common bind pose; the nodes then give the rest pose.
    let skins = Skins::all(document, buffers, &nodes).unwrap_or_default();
    let joints = MotionJoints::find(candidates(document, &nodes, &skins), character, names)?;
    let wanted = Wanted { skinned_only: true, default_shape: true };
    let meshes = Meshes::read(document, buffers, |_| false, wanted)?;
    let scene = Scene::new(nodes, meshes, ClipKeys::read(document, buffers)?);
    let found = &joints.nodes;
    let mut warnings = Vec::from_iter(parsed.warning());
    let (clips, moments) = scene.sample(found, sampling, &mut warnings)?;
    let at_rest = scene.nodes.worlds(&scene.nodes.locals);
    let mut binds = vec![None; at_rest.len()];
    for (&node, &bind) in skins.joints.iter().zip(&skins.binds) {
        binds[node] = Some(bind);
    }
    let binds = found.iter().map(|&node| bound(scene.nodes.upwards(node), &binds, &at_rest));
    let frames = moments.iter().flat_map(|moment| {
        let worlds = scene.nodes.worlds(&scene.at(moment).0);
        found.iter().map(|&node| worlds[node]).collect::<Vec<_>>()
    });
    Ok(Motion {
        space: Space::GLTF,
        rest: found.iter().map(|&node| at_rest[node]).collect(),
        binds: binds.collect(),
        frames: frames.collect(),
        joints,
        clips,
        warnings,
    })
}

/// Returns the names of the nodes that may be joints, if a file shows nodes but no mesh with a skin. `None` also for a
/// file that cannot be read.
pub(crate) fn joints_alone(path: &Path) -> Option<Vec<String>> {
    let Parsed { document, buffers, .. } = file::open(path).ok()?;
    let nodes = Nodes::read(&document).ok()?;
    let shown = nodes.shown(&document);
    let wanted = Wanted { skinned_only: true, default_shape: true };
    let meshes = Meshes::read(&document, &buffers, |node| shown[node], wanted).ok()?;
    if !meshes.instances.is_empty() || !shown.contains(&true) {
        return None;
    }
    let skins = Skins::all(&document, &buffers, &nodes).unwrap_or_default();
    Some(candidates(&document, &nodes, &skins).into_iter().map(|(_, name)| name).collect())
}

/// Lists the nodes that may be joints, with unique names; joints of skins come first.
///
/// Without a skin, every node without a mesh is a joint. If an armature has the name of a joint below it, only the joint
/// counts.
fn candidates(document: &Document, nodes: &Nodes, skins: &Skins) -> Vec<(usize, String)> {
    let shows: Vec<bool> = document.nodes().map(|node| node.mesh().is_some()).collect();
    let below = |node: usize, other: &usize| {
        let above = nodes.upwards(*other).skip(1).any(|above| above == node);
        above && nodes.names[*other] == nodes.names[node] && !shows[*other]
    };
    let is_joint = |node: usize| match skins.joints.is_empty() {
        false => skins.joints.contains(&node),
        true => !shows[node] && !(0..shows.len()).any(|other| below(node, &other)),
    };
    let (labels, _) = unique_names(&nodes.names, &nodes.parents, is_joint);
    let mut all: Vec<_> =
        labels.into_iter().enumerate().filter(|(node, _)| !shows[*node]).collect();
    all.sort_by_key(|(node, _)| !is_joint(*node));
    all
}

fn parse_shapes(bytes: &[u8], path: &Path) -> Result<ShapedMesh, Error> {
    let Parsed { document, buffers, .. } = file::parse(bytes, path)?;
    let tree = file::tree(bytes)?;
    let nodes = Nodes::read(&document)?;
    let shown = nodes.shown(&document);
    // Default weights are not part of a face at rest.
    let wanted = Wanted { skinned_only: false, default_shape: false };
    let meshes = Meshes::read(&document, &buffers, |node| shown[node], wanted)?;
    let (shaped, plain): (Vec<_>, Vec<_>) =
        (0..meshes.instances.len()).partition(|&at| !meshes.instances[at].morphs.is_empty());
    if shaped.is_empty() {
        let is_empty = !shown.contains(&true);
        return Err(if is_empty { faults::empty() } else { faults::no_shapes() });
    }
    let mut out = ShapedMesh { space: Space::GLTF, is_split: true, ..ShapedMesh::default() };
    out.warnings.extend(meshes.warnings());
    if !plain.is_empty() {
        let meshes = plain.iter().map(|&at| meshes.instances[at].name.clone()).collect();
        out.warnings.push(FormatWarning::UnshapedMeshes { meshes });
    }
    let worlds = nodes.worlds(&nodes.locals);
    let [has_normals, _, has_uv] = meshes.authored;
    let mut normals = Vec::new();
    let mut place_of = vec![None; meshes.positions.len()];
    for &at in &shaped {
        let (instance, own) = (&meshes.instances[at], meshes.vertices(at));
        let world = match instance.skin {
            Some(_) => Matrix4::identity(),
            None => worlds[instance.node],
        };
        let first = out.positions.len();
        let turned = |v: [f64; 3]| -> [f64; 3] { world.transform_vector(&v.into()).into() };
        for vertex in own {
            place_of[vertex] = Some(out.positions.len());
            let place = world.transform_point(&meshes.positions[vertex].into());
            out.positions.push(place.coords.into());
            out.uv.push(meshes.uv[vertex]);
            let normal =
                Vector3::from(normal_matrix(&world) * Vector3::from(meshes.normals[vertex]));
            normals.push(normal.try_normalize(0.0).unwrap_or_default().into());
        }
        let mesh = document.nodes().nth(instance.node).and_then(|node| node.mesh());
        let names = mesh.map(|mesh| &tree["meshes"][mesh.index()]["extras"]["targetNames"]);
        for (target, deltas) in instance.morphs.iter().enumerate() {
            let name = names.and_then(|names| names.get(target)).and_then(Value::as_str);
            let name = name.map_or_else(|| format!("target {target}"), str::to_owned);
            out.add(&name, deltas.iter().enumerate().map(|(own, by)| (first + own, turned(*by))));
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
