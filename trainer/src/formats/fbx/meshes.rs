//! Meshes of a scene: joined into one, with the attributes of their corners and their blendshapes.

use super::file::{open, space};
use crate::Error;
use crate::formats::FormatWarning;
use crate::formats::mesh::ShapedMesh;
use crate::formats::polygons::Polygons;
use crate::formats::scene::faults;
use crate::mesh::{Corners, EngineMesh};
use nalgebra::Vector3;
use std::ops::Range;
use std::path::Path;
use ufbx::{BlendChannel, Matrix, Mesh, Node, Scene, SkinDeformer, Vec3, VertexVec3};

/// Property of a blendshape channel that holds its weight.
pub(super) const WEIGHT: &str = "DeformPercent";

/// A mesh and the node that shows it.
pub(super) struct MeshPart {
    /// Index of the node in the scene.
    pub(super) node: usize,
    /// Index of the mesh in the scene.
    pub(super) mesh: usize,
    /// Transform from the mesh to the space in which the joints are bound.
    pub(super) rest: Matrix,
}

/// All parts, joined into one mesh.
pub(super) struct Geometry {
    pub(super) rest: Vec<[f64; 3]>,
    pub(super) triangles: Vec<[usize; 3]>,
    pub(super) engine: Option<EngineMesh>,
    /// Names and vertex ranges of the parts; empty for a single part.
    pub(super) ranges: Vec<(String, Range<usize>)>,
}

/// Chooses the skinned meshes of a scene; if no mesh has a skin, all meshes.
pub(super) fn parts(
    scene: &Scene,
    warnings: &mut Vec<FormatWarning>,
) -> Result<Vec<MeshPart>, Error> {
    let shown: Vec<(&Node, &Mesh)> = shown(scene).collect();
    if shown.is_empty() {
        // The root node always exists.
        let is_empty = scene.nodes.len() < 2;
        return Err(if is_empty { faults::empty() } else { faults::no_mesh() });
    }
    let (skinned, other): (Vec<_>, Vec<_>) =
        shown.iter().copied().partition(|(_, mesh)| !mesh.skin_deformers.is_empty());
    if skinned.is_empty() {
        let part = |(node, mesh): (&Node, &Mesh)| part(node, mesh, node.geometry_to_world);
        return Ok(other.into_iter().map(part).collect());
    }
    let other = other.iter().map(|(node, _)| node.element.name.to_string()).collect();
    warnings.extend(FormatWarning::listed(FormatWarning::UnskinnedMeshes, other));
    skinned.into_iter().map(|(node, mesh)| bound_part(node, mesh)).collect()
}

/// Lists the meshes with vertices, and the nodes that show them.
pub(super) fn shown(scene: &Scene) -> impl Iterator<Item = (&Node, &Mesh)> {
    let all = scene.nodes.iter().filter_map(|node| Some((&**node, &**node.mesh.as_ref()?)));
    all.filter(|(_, mesh)| mesh.num_vertices > 0)
}

/// Joins the parts, in their order.
pub(super) fn join(
    scene: &Scene,
    parts: &[MeshPart],
    warnings: &mut Vec<FormatWarning>,
) -> Geometry {
    let mut rest = Vec::new();
    let (mut triangles, mut places) = (Vec::new(), Vec::new());
    let mut corners = Corners::default();
    let mut ranges = Vec::new();
    for part in parts {
        let (mesh, first) = (&scene.meshes[part.mesh], rest.len());
        let vertices = rest_vertices(scene, mesh);
        let positions: Vec<[f64; 3]> = vertices.iter().map(|&v| array(v)).collect();
        let mirrored = ufbx::matrix_determinant(&part.rest) < 0.0;
        let polygons = polygons(mesh);
        let (own, begin) = (polygons.corners(), corners.vertices.len());
        for [a, b, c] in polygons.corner_triangles(&positions) {
            let corners = if mirrored { [a, c, b] } else { [a, b, c] };
            triangles.push(corners.map(|corner| own[corner] + first));
            places.push(corners.map(|corner| corner + begin));
        }
        add_corners(&mut corners, mesh, first, &part.rest);
        let place = |&v: &Vec3| array(ufbx::transform_position(&part.rest, v));
        rest.extend(vertices.iter().map(place));
        ranges.push((scene.nodes[part.node].element.name.to_string(), first..rest.len()));
    }
    let (engine, count) = corners.engine_mesh(&rest, &places);
    warnings.extend(FormatWarning::repaired(count));
    let engine = (!engine.is_plain()).then_some(engine);
    if parts.len() < 2 {
        ranges.clear();
    }
    Geometry { rest, triangles, engine, ranges }
}

/// Returns whether the scene poses all parts by itself: each has a skin, and none has a point cache.
pub(super) fn are_posed(
    scene: &Scene,
    parts: &[MeshPart],
    warnings: &mut Vec<FormatWarning>,
) -> bool {
    let cached = parts.iter().filter(|part| !scene.meshes[part.mesh].cache_deformers.is_empty());
    let meshes: Vec<String> =
        cached.map(|part| scene.nodes[part.node].element.name.to_string()).collect();
    let whole = meshes.is_empty();
    warnings.extend(FormatWarning::listed(FormatWarning::CacheIgnored, meshes));
    whole && parts.iter().all(|part| skin(&scene.meshes[part.mesh]).is_some())
}

/// Returns the weights of the parts' skins, V x J, for the joints at these nodes; `None` without a skin.
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

/// Warns of vertices in skinned parts that have no joint weights.
pub(super) fn unweighted(scene: &Scene, parts: &[MeshPart], warnings: &mut Vec<FormatWarning>) {
    let skins = parts.iter().filter_map(|part| skin(&scene.meshes[part.mesh]));
    let bare = skins.flat_map(|skin| &skin.vertices).filter(|vertex| vertex.num_weights == 0);
    let count = bare.count();
    if count > 0 {
        warnings.push(FormatWarning::Unweighted { count, follow: "their mesh's node" });
    }
}

/// Returns the skin of a mesh.
pub(super) fn skin(mesh: &Mesh) -> Option<&SkinDeformer> {
    mesh.skin_deformers.into_iter().next()
}

/// Reads the meshes with blendshapes as one mesh.
///
/// Channels of one name on several meshes become one shape. A channel with in-between shapes gives its last shape.
///
/// # Errors
/// The file cannot be read, or a part is missing or damaged.
pub(crate) fn read_shapes(path: &Path) -> Result<ShapedMesh, Error> {
    parse_shapes(&std::fs::read(path).map_err(Error::read)?)
}

pub(super) fn parse_shapes(bytes: &[u8]) -> Result<ShapedMesh, Error> {
    let scene = open(bytes)?;
    let mut out = ShapedMesh { space: space(&scene.settings), ..ShapedMesh::default() };
    let mut left_out = Vec::new();
    let (mut has_uv, mut between) = (true, Vec::new());
    for part in parts(&scene, &mut out.warnings)? {
        let mesh = &scene.meshes[part.mesh];
        if mesh.blend_deformers.is_empty() {
            left_out.push(scene.nodes[part.node].element.name.to_string());
            continue;
        }
        let first = out.positions.len();
        let place = |&v: &Vec3| array(ufbx::transform_position(&part.rest, v));
        out.positions.extend(mesh.vertices.iter().map(place));
        let mut corner = 0;
        let first_uv = out.uv.len();
        out.uv.extend(mesh.vertex_uv.values.iter().map(|uv| [uv.x, uv.y]));
        let mirrored = ufbx::matrix_determinant(&part.rest) < 0.0;
        for face in polygons(mesh).iter() {
            let corners = corner..corner + face.len();
            corner = corners.end;
            let uv = corners.map(|corner| mesh.vertex_uv.indices.get(corner));
            let mut uv: Vec<Option<usize>> =
                uv.map(|place| place.map(|&place| first_uv + place as usize)).collect();
            let mut face: Vec<usize> = face.iter().map(|vertex| first + vertex).collect();
            if mirrored {
                face.reverse();
                uv.reverse();
            }
            has_uv &= uv.iter().all(Option::is_some);
            out.faces.push(face);
            out.uv_faces.push(uv.into_iter().flatten().collect());
        }
        for channel in channels(mesh) {
            let Some(shape) = channel.keyframes.iter().last().map(|key| &key.shape) else {
                continue;
            };
            let name = channel.element.name.to_string();
            if channel.keyframes.len() > 1 {
                between.push(name.clone());
            }
            let moved = shape.offset_vertices.iter().zip(shape.position_offsets.iter());
            let moved = moved.filter(|(vertex, _)| (**vertex as usize) < mesh.num_vertices);
            let moved = moved.map(|(&vertex, &by)| {
                (first + vertex as usize, array(ufbx::transform_direction(&part.rest, by)))
            });
            out.add(&name, moved);
        }
    }
    if out.shapes.is_empty() {
        return Err(faults::no_shapes());
    }
    out.shapes.iter_mut().for_each(|shape| shape.deltas.resize(out.positions.len(), [0.0; 3]));
    if !has_uv || out.uv.is_empty() {
        (out.uv, out.uv_faces) = Default::default();
    }
    out.warnings.extend(FormatWarning::listed(FormatWarning::UnshapedMeshes, left_out));
    out.warnings.extend(FormatWarning::listed(FormatWarning::ShapesBetween, between));
    Ok(out)
}

/// Returns the vertices of a mesh at rest.
///
/// A channel that no clip animates is constant, so its offsets belong to the rest mesh. An animated channel is off at
/// rest: its stored weight is that of the frame in which the scene was saved.
fn rest_vertices(scene: &Scene, mesh: &Mesh) -> Vec<Vec3> {
    let mut vertices = mesh.vertices.to_vec();
    for channel in channels(mesh).filter(|channel| !is_keyed(scene, channel)) {
        for keyframe in &channel.keyframes {
            let weight = keyframe.effective_weight;
            ufbx::add_blend_shape_vertex_offsets(&keyframe.shape, &mut vertices, weight);
        }
    }
    vertices
}

/// Returns whether animated channels move a mesh of a posed scene.
pub(super) fn is_shaped(scene: &Scene, posed: &Mesh) -> bool {
    let mut keyed = channels(posed).filter(|channel| is_keyed(scene, channel));
    keyed.any(|channel| channel.keyframes.iter().any(|key| key.effective_weight != 0.0))
}

/// Lists the blendshape channels of a mesh.
pub(super) fn channels(mesh: &Mesh) -> impl Iterator<Item = &BlendChannel> {
    mesh.blend_deformers.iter().flat_map(|blend| blend.channels.iter()).map(|channel| &**channel)
}

/// Returns the faces of a mesh.
fn polygons(mesh: &Mesh) -> Polygons {
    let mut polygons = Polygons::default();
    for face in &mesh.faces {
        let corners = mesh.vertex_indices.iter().skip(face.index_begin as usize);
        polygons.push(corners.take(face.num_indices as usize).map(|&vertex| vertex as usize));
    }
    polygons
}

fn part(node: &Node, mesh: &Mesh, rest: Matrix) -> MeshPart {
    MeshPart { node: node.element.typed_id as usize, mesh: mesh.element.typed_id as usize, rest }
}

/// Makes a part of a skinned mesh. Its bind frame places the part, whatever its node does.
fn bound_part(node: &Node, mesh: &Mesh) -> Result<MeshPart, Error> {
    let name = &node.element.name;
    let found = mesh.skin_deformers.len();
    if found > 1 {
        return Err(Error::unsupported(format!(
            "mesh {name} has {found} skins, expected one; bake them into one skin cluster"
        )));
    }
    let clusters = skin(mesh).into_iter().flat_map(|skin| &skin.clusters);
    let Some(cluster) = clusters.into_iter().find(|cluster| cluster.bone_node.is_some()) else {
        return Err(Error::missing(format!(
            "the skin of mesh {name} has no joint; bind it again, or export its joints with it"
        )));
    };
    let rest = ufbx::matrix_mul(&cluster.bind_to_world, &cluster.geometry_to_bone);
    Ok(part(node, mesh, rest))
}

/// Returns whether a clip has keys for a channel's weight.
fn is_keyed(scene: &Scene, channel: &BlendChannel) -> bool {
    let layers = scene.anim_stacks.iter().flat_map(|stack| stack.layers.iter());
    let mut properties = layers.flat_map(|layer| layer.anim_props.iter());
    properties.any(|property| {
        let own = property.element.element_id == channel.element.element_id;
        let curves = &property.anim_value.curves;
        let has_keys = curves.iter().flatten().any(|curve| !curve.keyframes.is_empty());
        own && *property.prop_name == *WEIGHT && has_keys
    })
}

/// Appends the corners of a mesh's faces.
///
/// - `first`: index of the mesh's first vertex among all vertices.
/// - `rest`: from the mesh to its bind pose.
fn add_corners(all: &mut Corners, mesh: &Mesh, first: usize, rest: &Matrix) {
    let begin = all.vertices.len();
    let faces = mesh.faces.iter();
    let corners = faces.flat_map(|face| face.index_begin..face.index_begin + face.num_indices);
    let corners: Vec<usize> = corners.map(|corner| corner as usize).collect();
    let vertices = corners.iter().map(|&corner| first + mesh.vertex_indices[corner] as usize);
    all.vertices.extend(vertices);
    let turn = ufbx::matrix_for_normals(rest);
    // A mirrored cross product changes the handedness.
    let side = if ufbx::matrix_determinant(rest) < 0.0 { -1.0 } else { 1.0 };
    let normal = |corner| {
        at(&mesh.vertex_normal, corner).map(|n| array(ufbx::transform_direction(&turn, n)))
    };
    let tangent = |corner| {
        let tangent = at(&mesh.vertex_tangent, corner)?;
        let [x, y, z] = array(ufbx::transform_direction(rest, tangent));
        Some([x, y, z, side * handedness(mesh, corner, tangent)])
    };
    let uv = |corner: usize| {
        let uv = &mesh.vertex_uv;
        let place = *uv.indices.get(corner)? as usize;
        uv.values.get(place).map(|uv| [uv.x, uv.y])
    };
    extend(&mut all.normals, begin, &corners, normal);
    extend(&mut all.tangents, begin, &corners, tangent);
    extend(&mut all.uv, begin, &corners, uv);
}

/// Appends an attribute of a mesh's corners; 0 for corners and earlier meshes without the attribute.
fn extend<T: Copy + Default>(
    all: &mut Option<Vec<T>>,
    begin: usize,
    corners: &[usize],
    of: impl Fn(usize) -> Option<T>,
) {
    let found: Vec<Option<T>> = corners.iter().map(|&corner| of(corner)).collect();
    if all.is_none() && found.iter().all(Option::is_none) {
        return;
    }
    let all = all.get_or_insert_with(|| vec![T::default(); begin]);
    all.extend(found.into_iter().map(Option::unwrap_or_default));
}

/// Returns the direction in which v grows, relative to normal x tangent: -1 or 1.
fn handedness(mesh: &Mesh, corner: usize, tangent: Vec3) -> f64 {
    let [normal, across] = [&mesh.vertex_normal, &mesh.vertex_bitangent]
        .map(|attribute| at(attribute, corner).map(|v| Vector3::from(array(v))));
    let tangent = Vector3::from(array(tangent));
    let side = normal.zip(across).map(|(normal, across)| normal.cross(&tangent).dot(&across));
    if side.is_some_and(|side| side < 0.0) { -1.0 } else { 1.0 }
}

fn at(attribute: &VertexVec3, corner: usize) -> Option<Vec3> {
    let place = *attribute.indices.get(corner)? as usize;
    attribute.values.get(place).copied()
}

fn array(v: Vec3) -> [f64; 3] {
    [v.x, v.y, v.z]
}
