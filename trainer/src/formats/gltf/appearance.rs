//! Materials and images of a glTF file, member by member.

use std::path::Path;

use ::gltf::{Document, Semantic};
use serde_json::{Map, Value};

use super::file::{self, Buffers, Parsed};
use super::nodes::Nodes;
use super::rigged::shown_meshes;
use super::triangles::{is_surface, triangles};
use crate::formats::appearance::data::{Appearance, Image};
use crate::formats::appearance::image;
use crate::formats::error::FormatError;

/// Reads what the meshes look like that [`read`](super::read) reads.
///
/// # Errors
/// [`FormatError::Read`] and [`FormatError::Scene`].
pub(in crate::formats) fn read(path: &Path) -> Result<Appearance, FormatError> {
    let bytes = file::read(path)?;
    let Parsed { document, buffers, .. } = file::parse(&bytes, path)?;
    let mut tree = file::tree(&bytes)?;
    let meshes = shown_meshes(&document, &Nodes::read(&document)?);
    let primitives = meshes.iter().flat_map(|(mesh, _)| mesh.primitives());
    let mut of_triangles = Vec::new();
    for primitive in primitives.filter(is_surface) {
        let positions = primitive.get(&Semantic::Positions);
        let vertex_len = positions.map_or(0, |positions| positions.count());
        let place = || "the meshes".to_owned();
        let count = triangles(&primitive, &buffers, vertex_len, place)?.len();
        of_triangles.extend(std::iter::repeat_n(primitive.material().index(), count));
    }
    let mut list = |name: &str| match tree.remove(name) {
        Some(Value::Array(items)) => items,
        _ => Vec::new(),
    };
    let mut appearance = Appearance {
        mesh: match meshes.as_slice() {
            [(mesh, node)] => node.name().or(mesh.name()).map(str::to_owned),
            _ => None,
        },
        of_triangles,
        materials: list("materials"),
        textures: list("textures"),
        samplers: list("samplers"),
        ..Appearance::default()
    };
    let mut images = Vec::new();
    for (number, members) in list("images").into_iter().enumerate() {
        let Value::Object(members) = members else { continue };
        let name = ["name", "uri"].iter().find_map(|name| members.get(*name)?.as_str());
        let name = name.filter(|name| !name.starts_with("data:")).map(str::to_owned);
        let uri = members.get("uri").and_then(Value::as_str);
        let looked_for = uri.and_then(|uri| file::beside(uri, path).ok());
        let found = picture(members, &document, &buffers, path);
        if found.is_none() {
            let name = name.unwrap_or_else(|| format!("image {number}"));
            appearance.missing.push(image::missing(&name, looked_for.as_slice()));
        }
        images.push(found);
    }
    appearance.set_images(images);
    let required = list("extensionsRequired");
    let used = appearance.extensions();
    let required = required.into_iter().filter_map(|name| name.as_str().map(str::to_owned));
    appearance.required = required.filter(|name| used.contains(name)).collect();
    Ok(appearance)
}

fn picture(
    mut members: Map<String, Value>,
    document: &Document,
    buffers: &Buffers,
    path: &Path,
) -> Option<Image> {
    members.remove("mimeType");
    let bytes = match (members.remove("bufferView"), members.remove("uri")) {
        (Some(view), _) => {
            let view = document.views().nth(view.as_u64()? as usize)?;
            let buffer = buffers.get(view.buffer().index())?;
            let end = view.offset().checked_add(view.length())?;
            buffer.get(view.offset()..end)?.to_vec()
        }
        (None, uri) => file::resource(uri?.as_str()?, path).ok()?,
    };
    image::kind(&bytes)?;
    Some(Image { members, bytes })
}
