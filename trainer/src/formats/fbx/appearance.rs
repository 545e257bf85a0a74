//! Materials and images of an FBX file as glTF states them: names, base colours and their textures.

use std::path::{Path, PathBuf};

use serde_json::{Map, Value, json};
use ufbx::{Material, Mesh, Node, Texture};

use super::file::open;
use super::meshes;
use crate::Error;
use crate::formats::appearance::{Appearance, Image, image_kind, missing_image};

/// Reads the appearance of the meshes that [`read`](super::read) reads.
///
/// # Errors
/// The file cannot be read, or a part is missing or damaged.
pub(in crate::formats) fn read(path: &Path) -> Result<Appearance, Error> {
    let bytes = std::fs::read(path).map_err(Error::read)?;
    let scene = open(&bytes)?;
    let parts = meshes::parts(&scene, &mut Vec::new())?;
    let shown: Vec<(&Node, &Mesh)> =
        parts.iter().map(|part| (&scene.nodes[part.node], &scene.meshes[part.mesh])).collect();
    let images: Vec<_> = scene.textures.iter().map(|texture| picture(texture, path)).collect();
    let mut appearance = Appearance {
        mesh: match shown.as_slice() {
            [(node, _)] => Some(node.element.name.to_string()),
            _ => None,
        },
        of_triangles: shown.iter().flat_map(|(node, mesh)| of_triangles(node, mesh)).collect(),
        materials: scene
            .materials
            .iter()
            .map(|material| material_json(material, &images))
            .collect(),
        textures: (0..scene.textures.len()).map(|texture| json!({ "source": texture })).collect(),
        ..Appearance::default()
    };
    let missing = scene.textures.iter().zip(&images).filter(|(_, image)| image.is_none());
    let missing = missing.map(|(texture, _)| missing_image(&name(texture), &places(texture, path)));
    appearance.missing = missing.collect();
    appearance.set_images(images);
    Ok(appearance)
}

/// Returns the material of each triangle of a mesh; a face of n corners has n - 2 triangles.
fn of_triangles(node: &Node, mesh: &Mesh) -> Vec<Option<usize>> {
    let of_slot = |slot: u32| {
        let materials = if node.materials.is_empty() { &mesh.materials } else { &node.materials };
        materials.get(slot as usize).map(|material| material.element.typed_id as usize)
    };
    let slots = mesh.face_material.iter().map(Some).chain(std::iter::repeat(None));
    let faces = mesh.faces.iter().zip(slots).flat_map(|(face, slot)| {
        let slot = slot.copied().unwrap_or(0);
        std::iter::repeat_n(of_slot(slot), (face.num_indices as usize).saturating_sub(2))
    });
    faces.collect()
}

/// Returns a material as glTF states it.
fn material_json(material: &Material, images: &[Option<Image>]) -> Value {
    let colour = &material.pbr.base_color;
    let factor = &material.pbr.base_factor;
    let factor = if factor.has_value { factor.value_vec4.x } else { 1.0 };
    let value = &colour.value_vec4;
    let part = |x: f64| json!((x * factor).clamp(0.0, 1.0));
    let mut surface = json!({ "metallicFactor": 0 });
    let texture = colour.texture.as_ref().filter(|_| colour.texture_enabled);
    let texture = texture.map(|texture| texture.element.typed_id as usize);
    match texture.filter(|&texture| images.get(texture).is_some_and(Option::is_some)) {
        // A texture replaces the colour.
        Some(texture) => surface["baseColorTexture"] = json!({ "index": texture }),
        None if colour.has_value => {
            surface["baseColorFactor"] = json!([part(value.x), part(value.y), part(value.z), 1]);
        }
        None => {}
    }
    json!({ "name": material.element.name.to_string(), "pbrMetallicRoughness": surface })
}

/// Reads a texture's file, from the first of its possible places that has an image.
fn picture(texture: &Texture, scene: &Path) -> Option<Image> {
    let bytes = places(texture, scene).into_iter().find_map(|place| {
        let bytes = std::fs::read(place).ok()?;
        image_kind(&bytes).map(|_| bytes)
    })?;
    let mut members = Map::new();
    members.insert("name".to_owned(), json!(name(texture)));
    Some(Image { members, bytes })
}

/// Lists the possible places of a texture's file: its path relative to the scene, and its name in the scene's folder.
fn places(texture: &Texture, scene: &Path) -> Vec<PathBuf> {
    let relative = texture.relative_filename.replace('\\', "/");
    let places = [relative, name(texture)].into_iter().filter(|place| !place.is_empty());
    let mut places: Vec<PathBuf> = places.map(|place| scene.with_file_name(place)).collect();
    places.dedup();
    places
}

/// Names a texture after its file.
fn name(texture: &Texture) -> String {
    let file = texture.filename.replace('\\', "/");
    let name = Path::new(&file).file_name().map(|name| name.to_string_lossy().into_owned());
    name.unwrap_or_else(|| texture.element.name.to_string())
}
