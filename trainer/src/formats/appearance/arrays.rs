//! Materials and images of examples in arrays, as `blender_export.py` writes them.
//!
//! | array | shape | |
//! |---|---|---|
//! | `quads_material`, `tris_material` | F | index of each face's material; -1 for none |
//! | `materials` | 1 | glTF members `materials`, `textures` and `images` as JSON; images have a `name` and no place |
//! | `image_0`, `image_1`, ... | bytes | content of the image files |

use super::{Appearance, Image, image_kind, missing_image};
use crate::Error;
use crate::formats::npz::Archive;
use serde::Deserialize;
use serde_json::{Map, Value};
use std::path::Path;

/// Members of a glTF file.
#[derive(Default, Deserialize)]
#[serde(default)]
struct Members {
    materials: Vec<Value>,
    textures: Vec<Value>,
    images: Vec<Map<String, Value>>,
}

/// Reads the appearance; without an array `materials` only the name of a single mesh.
///
/// # Errors
/// An array cannot be read, has another shape, or names a material that does not exist.
pub(super) fn read(path: &Path) -> Result<Appearance, Error> {
    let mut archive = Archive::open(path)?;
    let names = archive.texts("mesh_names")?.unwrap_or_default();
    let mesh = <[String; 1]>::try_from(names).ok().map(|[name]| name);
    let Some(text) = archive.text("materials")? else {
        return Ok(Appearance { mesh, ..Appearance::default() });
    };
    let Members { materials, textures, images } = serde_json::from_str(&text).map_err(|error| {
        let words = format!("array materials does not describe materials as glTF: {error}");
        Error::damaged(words).caused_by(error)
    })?;
    let of_triangles = of_triangles(&mut archive, materials.len())?;
    let mut appearance =
        Appearance { mesh, of_triangles, materials, textures, ..Appearance::default() };
    let mut found = Vec::new();
    for (number, members) in images.into_iter().enumerate() {
        let bytes = archive.rows::<i64, 1>(&format!("image_{number}"), &[])?;
        let bytes = bytes.map(|rows| rows.data.into_flattened());
        let bytes: Vec<u8> = bytes.into_iter().flatten().map(|byte| byte as u8).collect();
        let is_known = image_kind(&bytes).is_some();
        if !is_known {
            let name = members.get("name").and_then(Value::as_str).unwrap_or("without a name");
            appearance.missing.push(missing_image(name, &[]));
        }
        found.push(is_known.then_some(Image { members, bytes }));
    }
    appearance.set_images(found);
    Ok(appearance)
}

/// Returns the material of each triangle, T. Quads come first, and have two triangles.
fn of_triangles(archive: &mut Archive, material_len: usize) -> Result<Vec<Option<usize>>, Error> {
    let mut all = Vec::new();
    for (array, triangles) in [("quads_material", 2), ("tris_material", 1)] {
        let Some(rows) = archive.rows::<i64, 1>(array, &[])? else { continue };
        for (face, [number]) in rows.data.into_iter().enumerate() {
            let material = usize::try_from(number).ok();
            if material.is_some_and(|material| material >= material_len) || number < -1 {
                return Err(Error::value(format!(
                    "array {array} has material {number} at face {face}, expected -1 to {}",
                    material_len as i64 - 1
                )));
            }
            all.extend(std::iter::repeat_n(material, triangles));
        }
    }
    Ok(all)
}
