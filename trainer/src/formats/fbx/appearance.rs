//! Materials and images of an FBX file as glTF states them: names, base colours and their textures.

use std::path::{Path, PathBuf};

use serde_json::{Map, Value, json};
use ufbx::{Material, Mesh, Node, Texture};

use super::meshes;
use super::read::open;
use crate::formats::appearance::data::{Appearance, Image};
use crate::formats::appearance::image;
use crate::formats::error::FormatError;

/// Reads what the meshes look like that [`read`](super::read()) reads.
///
/// # Errors
/// [`FormatError::Read`] and [`FormatError::Scene`].
pub(in crate::formats) fn read(path: &Path) -> Result<Appearance, FormatError> {
    let bytes = std::fs::read(path).map_err(FormatError::Read)?;
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
        materials: scene.materials.iter().map(|material| stated(material, &images)).collect(),
        textures: (0..scene.textures.len()).map(|texture| json!({ "source": texture })).collect(),
        ..Appearance::default()
    };
    let names = scene.textures.iter().map(|texture| texture.element.name.to_string());
    let missing = names.zip(&images).filter(|(_, image)| image.is_none()).map(|(name, _)| name);
    appearance.missing = missing.collect();
    appearance.set_images(images);
    Ok(appearance)
}

/// Gives the material of each triangle of a mesh: a face of n corners becomes n - 2.
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

fn stated(material: &Material, images: &[Option<Image>]) -> Value {
    let colour = &material.pbr.base_color;
    let factor = &material.pbr.base_factor;
    let factor = if factor.has_value { factor.value_vec4.x } else { 1.0 };
    let value = &colour.value_vec4;
    let part = |x: f64| json!((x * factor).clamp(0.0, 1.0));
    let mut surface = json!({ "metallicFactor": 0 });
    let texture = colour.texture.as_ref().filter(|_| colour.texture_enabled);
    let texture = texture.map(|texture| texture.element.typed_id as usize);
    match texture.filter(|&texture| images.get(texture).is_some_and(Option::is_some)) {
        // A texture takes the place of the colour.
        Some(texture) => surface["baseColorTexture"] = json!({ "index": texture }),
        None if colour.has_value => {
            surface["baseColorFactor"] = json!([part(value.x), part(value.y), part(value.z), 1]);
        }
        None => {}
    }
    json!({ "name": material.element.name.to_string(), "pbrMetallicRoughness": surface })
}

/// Reads a texture's file, where it says it is beside the scene or in the same folder.
fn picture(texture: &Texture, scene: &Path) -> Option<Image> {
    let beside = |name: &str| {
        let name = name.replace('\\', "/");
        let last = Path::new(&name).file_name().map(PathBuf::from);
        [Some(PathBuf::from(&name)), last]
    };
    let names = [&texture.relative_filename, &texture.filename];
    let mut places = names.into_iter().flat_map(|name| beside(name)).flatten();
    let bytes = places.find_map(|place| {
        let bytes = std::fs::read(scene.with_file_name(place)).ok()?;
        image::kind(&bytes).map(|_| bytes)
    })?;
    let mut members = Map::new();
    members.insert("name".to_owned(), json!(texture.element.name.to_string()));
    Some(Image { members, bytes })
}
