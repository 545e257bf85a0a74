//! The meshes of a scene, joined into one.

use std::ops::Range;
use ufbx::{Matrix, Mesh, Node, Scene, SkinDeformer};

use super::blends::rest_vertices;
use super::corners::{CornerLists, polygons};
use crate::formats::scene::SceneError;
use crate::formats::warning::FormatWarning;
use crate::mesh::EngineMesh;

/// A mesh as a node shows it.
pub(super) struct MeshPart {
    /// The node, by its place in the scene.
    pub(super) node: usize,
    /// The mesh, by its place in the scene.
    pub(super) mesh: usize,
    /// From the mesh to the space in which the joints are bound.
    pub(super) rest: Matrix,
}

/// The parts as one mesh.
pub(super) struct Geometry {
    pub(super) rest: Vec<[f64; 3]>,
    pub(super) triangles: Vec<[usize; 3]>,
    pub(super) engine: Option<EngineMesh>,
    /// The parts by name, where there are several.
    pub(super) ranges: Vec<(String, Range<usize>)>,
}

/// Chooses the skinned meshes of a scene, or all where none is skinned.
pub(super) fn parts(
    scene: &Scene,
    warnings: &mut Vec<FormatWarning>,
) -> Result<Vec<MeshPart>, SceneError> {
    let shown = scene.nodes.iter().filter_map(|node| Some((&**node, &**node.mesh.as_ref()?)));
    let shown: Vec<(&Node, &Mesh)> = shown.filter(|(_, mesh)| mesh.num_vertices > 0).collect();
    if shown.is_empty() {
        // The root node is there always.
        let is_empty = scene.nodes.len() < 2;
        return Err(if is_empty { SceneError::Empty } else { SceneError::NoMesh });
    }
    let (skinned, other): (Vec<_>, Vec<_>) =
        shown.iter().copied().partition(|(_, mesh)| !mesh.skin_deformers.is_empty());
    if skinned.is_empty() {
        let part = |(node, mesh): (&Node, &Mesh)| part(node, mesh, node.geometry_to_world);
        return Ok(other.into_iter().map(part).collect());
    }
    if !other.is_empty() {
        let meshes = other.iter().map(|(node, _)| node.element.name.to_string()).collect();
        warnings.push(FormatWarning::UnskinnedMeshes { meshes });
    }
    skinned.into_iter().map(|(node, mesh)| bound(node, mesh)).collect()
}

/// Joins the parts, in their order.
pub(super) fn join(
    scene: &Scene,
    parts: &[MeshPart],
    warnings: &mut Vec<FormatWarning>,
) -> Geometry {
    let mut rest = Vec::new();
    let (mut triangles, mut places) = (Vec::new(), Vec::new());
    let mut corners = CornerLists::default();
    let mut ranges = Vec::new();
    for part in parts {
        let (mesh, first) = (&scene.meshes[part.mesh], rest.len());
        let vertices = rest_vertices(scene, mesh);
        let positions: Vec<[f64; 3]> = vertices.iter().map(|v| [v.x, v.y, v.z]).collect();
        let mirrored = ufbx::matrix_determinant(&part.rest) < 0.0;
        let polygons = polygons(mesh);
        let (own, begin) = (polygons.corners(), corners.len());
        for [a, b, c] in polygons.corner_triangles(&positions) {
            let corners = if mirrored { [a, c, b] } else { [a, b, c] };
            triangles.push(corners.map(|corner| own[corner] + first));
            places.push(corners.map(|corner| corner + begin));
        }
        corners.add(mesh, first, &part.rest);
        let place = |&v: &ufbx::Vec3| {
            let v = ufbx::transform_position(&part.rest, v);
            [v.x, v.y, v.z]
        };
        rest.extend(vertices.iter().map(place));
        ranges.push((scene.nodes[part.node].element.name.to_string(), first..rest.len()));
    }
    let (engine, count) = corners.finish().engine_mesh(&rest, &places);
    if count > 0 {
        warnings.push(FormatWarning::NormalsRepaired { count });
    }
    let engine = (!engine.is_plain()).then_some(engine);
    if parts.len() < 2 {
        ranges.clear();
    }
    Geometry { rest, triangles, engine, ranges }
}

/// Tells whether the scene itself holds all that poses its meshes.
pub(super) fn are_posed(
    scene: &Scene,
    parts: &[MeshPart],
    warnings: &mut Vec<FormatWarning>,
) -> bool {
    let cached = parts.iter().filter(|part| !scene.meshes[part.mesh].cache_deformers.is_empty());
    let meshes: Vec<String> =
        cached.map(|part| scene.nodes[part.node].element.name.to_string()).collect();
    let whole = meshes.is_empty();
    if !whole {
        warnings.push(FormatWarning::CacheIgnored { meshes });
    }
    whole && parts.iter().all(|part| skin(&scene.meshes[part.mesh]).is_some())
}

/// Gives the joint weights of the parts' skins, V x J, of the joints at these nodes; none without a skin.
pub(super) fn joint_weights(
    scene: &Scene,
    parts: &[MeshPart],
    nodes: &[usize],
) -> Option<Vec<f64>> {
    let mut all = Vec::new();
    for part in parts {
        let (mesh, first) = (&scene.meshes[part.mesh], all.len());
        all.resize(first + mesh.num_vertices * nodes.len(), 0.0);
        let Some(skin) = skin(mesh) else { continue };
        let joints = skin.clusters.iter().map(|cluster| {
            let node = cluster.bone_node.as_ref()?.element.typed_id as usize;
            nodes.iter().position(|&joint| joint == node)
        });
        let joints: Vec<Option<usize>> = joints.collect();
        for (row, own) in all[first..].chunks_exact_mut(nodes.len()).zip(&skin.vertices) {
            let begin = own.weight_begin as usize;
            let weights = &skin.weights.as_ref()[begin..begin + own.num_weights as usize];
            for weight in weights {
                if let Some(joint) = joints[weight.cluster_index as usize] {
                    row[joint] += weight.weight.max(0.0);
                }
            }
        }
    }
    parts.iter().any(|part| skin(&scene.meshes[part.mesh]).is_some()).then_some(all)
}

/// Tells of vertices of skinned parts that no joint moves.
pub(super) fn unweighted(scene: &Scene, parts: &[MeshPart], warnings: &mut Vec<FormatWarning>) {
    let skins = parts.iter().filter_map(|part| skin(&scene.meshes[part.mesh]));
    let bare = skins.flat_map(|skin| &skin.vertices).filter(|vertex| vertex.num_weights == 0);
    let count = bare.count();
    if count > 0 {
        warnings.push(FormatWarning::Unweighted { count, follow: "their mesh's node" });
    }
}

/// Gives the skin of a mesh.
pub(super) fn skin(mesh: &Mesh) -> Option<&SkinDeformer> {
    mesh.skin_deformers.into_iter().next()
}

fn part(node: &Node, mesh: &Mesh, rest: Matrix) -> MeshPart {
    MeshPart { node: node.element.typed_id as usize, mesh: mesh.element.typed_id as usize, rest }
}

/// Makes a part of a skinned mesh, which stands where it is bound, whatever its node does.
fn bound(node: &Node, mesh: &Mesh) -> Result<MeshPart, SceneError> {
    let name = || node.element.name.to_string();
    let found = mesh.skin_deformers.len();
    if found > 1 {
        return Err(SceneError::SeveralSkins { mesh: name(), found });
    }
    let clusters = skin(mesh).into_iter().flat_map(|skin| &skin.clusters);
    let Some(cluster) = clusters.into_iter().find(|cluster| cluster.bone_node.is_some()) else {
        return Err(SceneError::EmptySkin { mesh: name() });
    };
    let rest = ufbx::matrix_mul(&cluster.bind_to_world, &cluster.geometry_to_bone);
    Ok(part(node, mesh, rest))
}
