//! What meshes look like, in a document: their parts by name and material.

use std::ops::Range;

use serde_json::{Value, json};

use super::mesh::SkinnedMesh;
use crate::formats::appearance::{Appearance, image_kind};
use crate::formats::gltf::write::Document;

/// A part of a mesh: its name, its vertices, and the triangles of each of its materials.
pub(super) struct Part<'a> {
    name: &'a str,
    vertices: Range<usize>,
    primitives: Vec<(Option<usize>, Vec<[usize; 3]>)>,
}

/// Parts a mesh by the ranges of its vertices, or makes one part of it, and each by material, in the order
/// in which they come. A range without a triangle is left out.
pub(super) fn parts<'a>(
    name: &'a str,
    ranges: &'a [(String, Range<usize>)],
    vertex_len: usize,
    triangles: &[[usize; 3]],
    materials: &[Option<usize>],
) -> Vec<Part<'a>> {
    let whole = [(name, 0..vertex_len)];
    let named = ranges.iter().map(|(name, range)| (name.as_str(), range.clone()));
    let all: Vec<_> = if ranges.is_empty() { whole.into() } else { named.collect() };
    let mut parts: Vec<_> = all
        .into_iter()
        .map(|(name, vertices)| Part { name, vertices, primitives: Vec::new() })
        .collect();
    let materials = materials.iter().copied().chain(std::iter::repeat(None));
    for (triangle, material) in triangles.iter().zip(materials) {
        // The meshes that were joined follow one another.
        let part = parts.partition_point(|part| part.vertices.end <= triangle[0]);
        let Some(Part { vertices, primitives, .. }) = parts.get_mut(part) else { continue };
        let own = triangle.map(|vertex| vertex - vertices.start);
        match primitives.iter_mut().find(|(other, _)| *other == material) {
            Some((_, triangles)) => triangles.push(own),
            None => primitives.push((material, vec![own])),
        }
    }
    parts.retain(|part| !part.primitives.is_empty());
    parts
}

impl Part<'_> {
    /// Cuts the part out of the mesh that it is a part of.
    pub(super) fn of<'a>(&'a self, mesh: &SkinnedMesh<'a>) -> SkinnedMesh<'a> {
        let own = self.vertices.clone();
        SkinnedMesh {
            name: self.name,
            positions: &mesh.positions[own.clone()],
            normals: &mesh.normals[own.clone()],
            uv: mesh.uv.map(|uv| &uv[own.clone()]),
            influences: &mesh.influences[own],
            primitives: &self.primitives,
        }
    }
}

impl Document {
    /// Adds materials, and what they name; textures only where there are coordinates for them.
    pub(super) fn dress(&mut self, appearance: &Appearance, uv: bool) {
        let mut appearance = appearance.clone();
        appearance.keep_uv(uv);
        let extensions = appearance.extensions();
        let Appearance { materials, textures, samplers, images, required, .. } = appearance;
        let picture = |image: crate::formats::appearance::Image| {
            let mut members = image.members;
            if let Some(kind) = image_kind(&image.bytes) {
                members.insert("mimeType".to_owned(), json!(kind));
            }
            members.insert("bufferView".to_owned(), json!(self.view(image.bytes)));
            Value::Object(members)
        };
        let images: Vec<Value> = images.into_iter().map(picture).collect();
        for (name, items) in [
            ("materials", materials),
            ("textures", textures),
            ("samplers", samplers),
            ("images", images),
            ("extensionsUsed", extensions.into_iter().map(Value::from).collect()),
            ("extensionsRequired", required.into_iter().map(Value::from).collect()),
        ] {
            if !items.is_empty() {
                self.root.insert(name.to_owned(), Value::Array(items));
            }
        }
    }
}
