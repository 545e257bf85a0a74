//! The blendshapes of an FBX file by name.

use std::path::Path;

use super::corners::polygons;
use super::meshes;
use super::read::{open, space};
use crate::formats::error::FormatError;
use crate::formats::scene::SceneError;
use crate::formats::shaped::ShapedMesh;
use crate::formats::warning::FormatWarning;

/// Reads the meshes that have blendshapes, as one; channels of one name on several meshes are one shape, and of a
/// channel with shapes between it is the last.
///
/// # Errors
/// [`FormatError::Read`], and [`FormatError::Scene`] with what is missing or damaged.
pub(crate) fn read_shapes(path: &Path) -> Result<ShapedMesh, FormatError> {
    let bytes = std::fs::read(path).map_err(FormatError::Read)?;
    Ok(parse_shapes(&bytes)?)
}

pub(super) fn parse_shapes(bytes: &[u8]) -> Result<ShapedMesh, SceneError> {
    let scene = open(bytes)?;
    let mut out = ShapedMesh { space: space(&scene.settings), ..ShapedMesh::default() };
    let mut left_out = Vec::new();
    let (mut has_uv, mut between) = (true, Vec::new());
    for part in meshes::parts(&scene, &mut out.warnings)? {
        let mesh = &scene.meshes[part.mesh];
        if mesh.blend_deformers.is_empty() {
            left_out.push(scene.nodes[part.node].element.name.to_string());
            continue;
        }
        let first = out.positions.len();
        let place = |v: &ufbx::Vec3| {
            let v = ufbx::transform_position(&part.rest, *v);
            [v.x, v.y, v.z]
        };
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
        let channels = mesh.blend_deformers.iter().flat_map(|blend| blend.channels.iter());
        for channel in channels {
            let Some(shape) = channel.keyframes.iter().last().map(|key| &key.shape) else {
                continue;
            };
            let name = channel.element.name.to_string();
            if channel.keyframes.len() > 1 {
                between.push(name.clone());
            }
            let len = mesh.num_vertices;
            let moved = shape.offset_vertices.iter().zip(shape.position_offsets.iter());
            let moved = moved.filter(|(vertex, _)| (**vertex as usize) < len);
            let moved: Vec<_> = moved
                .map(|(&vertex, &by)| {
                    let by = ufbx::transform_direction(&part.rest, by);
                    (first + vertex as usize, [by.x, by.y, by.z])
                })
                .collect();
            out.add(&name, moved.into_iter());
        }
    }
    if out.shapes.is_empty() {
        return Err(SceneError::NoShapes);
    }
    out.shapes.iter_mut().for_each(|shape| shape.deltas.resize(out.positions.len(), [0.0; 3]));
    if !has_uv || out.uv.is_empty() {
        (out.uv, out.uv_faces) = Default::default();
    }
    if !left_out.is_empty() {
        out.warnings.push(FormatWarning::UnshapedMeshes { meshes: left_out });
    }
    if !between.is_empty() {
        out.warnings.push(FormatWarning::ShapesBetween { channels: between });
    }
    Ok(out)
}
