//! The morph targets of a glTF file by name.

use std::path::Path;

use nalgebra::{Matrix4, Vector3};
use serde_json::Value;
use sinew_runtime::format::Space;

use super::file::{self, Parsed};
use super::meshes::{Meshes, Wanted};
use super::nodes::Nodes;
use crate::formats::error::FormatError;
use crate::formats::scene::SceneError;
use crate::formats::shaped::ShapedMesh;
use crate::formats::warning::FormatWarning;

/// Reads the meshes that have morph targets, as one; targets of one name on several meshes are one shape.
///
/// A mesh with a skin stands as it is bound, one without where its node is.
///
/// # Errors
/// [`FormatError::Read`], and [`FormatError::Scene`] with what is missing or damaged.
pub(crate) fn read_shapes(path: &Path) -> Result<ShapedMesh, FormatError> {
    let bytes = file::read(path)?;
    Ok(parse_shapes(&bytes, path)?)
}

pub(super) fn parse_shapes(bytes: &[u8], path: &Path) -> Result<ShapedMesh, SceneError> {
    let Parsed { document, buffers, .. } = file::parse(bytes, path)?;
    let tree = file::tree(bytes)?;
    let nodes = Nodes::read(&document)?;
    let shown = nodes.shown(&document);
    // The weights that a file has by default are no part of a face at rest.
    let wanted = Wanted { skinned_only: false, default_shape: false };
    let meshes = Meshes::read(&document, &buffers, |node| shown[node], wanted)?;
    let (shaped, plain): (Vec<_>, Vec<_>) =
        (0..meshes.instances.len()).partition(|&at| !meshes.instances[at].morphs.is_empty());
    if shaped.is_empty() {
        let is_empty = !shown.contains(&true);
        return Err(if is_empty { SceneError::Empty } else { SceneError::NoShapes });
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

/// Turns normals as a placement turns a surface.
fn normal_matrix(world: &Matrix4<f64>) -> nalgebra::Matrix3<f64> {
    let linear = world.fixed_view::<3, 3>(0, 0).into_owned();
    linear.try_inverse().map_or(linear, |inverse| inverse.transpose())
}
