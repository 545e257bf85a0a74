//! Materials, textures and images of a scene's meshes, as glTF states them.

use serde_json::{Map, Value, json};
use std::path::PathBuf;

/// Appearance of the meshes of a scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Appearance {
    /// Name of the mesh, if there is only one; the ranges of the examples name several meshes.
    pub mesh: Option<String>,
    /// Material of each triangle, T.
    pub of_triangles: Vec<Option<usize>>,
    /// Materials.
    pub materials: Vec<Value>,
    /// Textures that the materials use.
    pub textures: Vec<Value>,
    /// Samplers that the textures use.
    pub samplers: Vec<Value>,
    /// Images that the textures use.
    pub images: Vec<Image>,
    /// Extensions of materials, textures, samplers or images that the file requires every reader to support.
    pub required: Vec<String>,
    /// Images that cannot be read, with the paths that were tried; no material uses them.
    pub missing: Vec<String>,
}

/// An image.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Members of the glTF image, without its location.
    pub members: Map<String, Value>,
    /// Content of the image file.
    pub bytes: Vec<u8>,
}

impl Appearance {
    /// Sets the images, one for each image of the file; removes every texture whose image is `None`.
    pub(in crate::formats) fn set_images(&mut self, images: Vec<Option<Image>>) {
        let mut places = Vec::new();
        for image in images {
            places.push(image.is_some().then_some(self.images.len()));
            self.images.extend(image);
        }
        let place = |number: &Value| places.get(number.as_u64()? as usize).copied().flatten();
        let mut numbers = Vec::new();
        for mut texture in std::mem::take(&mut self.textures) {
            let mut found = set_source(&mut texture, place);
            let extensions = texture.get_mut("extensions").and_then(Value::as_object_mut);
            for extension in extensions.into_iter().flat_map(|map| map.values_mut()) {
                found |= set_source(extension, place);
            }
            numbers.push(found.then_some(self.textures.len()));
            self.textures.extend(found.then_some(texture));
        }
        self.keep_textures(|texture| {
            let number = numbers.get(texture["index"].as_u64()? as usize).copied().flatten();
            number.map(|number| texture["index"] = json!(number))
        });
    }

    /// Keeps the textures that use the first set of texture coordinates; removes all textures if `uv` is false.
    pub(crate) fn keep_uv(&mut self, uv: bool) {
        self.keep_textures(|texture| {
            let set = |at: &Value| at.get("texCoord").and_then(Value::as_u64);
            let transformed = texture["extensions"].get("KHR_texture_transform").and_then(set);
            (uv && transformed.or(set(texture)).unwrap_or(0) == 0).then_some(())
        });
    }

    /// Lists the extensions in use, sorted.
    pub(crate) fn extensions(&self) -> Vec<String> {
        let images = self.images.iter().flat_map(|image| image.members.get("extensions"));
        let mut found: Vec<String> =
            images.flat_map(Value::as_object).flat_map(|map| map.keys().cloned()).collect();
        let all = self.materials.iter().chain(&self.textures).chain(&self.samplers);
        all.for_each(|value| extensions(value, &mut found));
        found.sort();
        found.dedup();
        found
    }

    /// Updates each texture of the materials with `keep`, and removes it if `keep` returns `None`.
    fn keep_textures(&mut self, keep: impl Fn(&mut Value) -> Option<()>) {
        self.materials.iter_mut().for_each(|material| keep_textures(material, &keep));
    }
}

/// Returns the media type of an image, by its first bytes.
pub(crate) fn image_kind(bytes: &[u8]) -> Option<&'static str> {
    let begins = |with: &[u8]| bytes.starts_with(with);
    match () {
        () if begins(b"\x89PNG\r\n\x1a\n") => Some("image/png"),
        () if begins(b"\xff\xd8\xff") => Some("image/jpeg"),
        () if begins(b"RIFF") && bytes.get(8..12) == Some(b"WEBP") => Some("image/webp"),
        () if begins(b"\xabKTX 20\xbb") => Some("image/ktx2"),
        () => None,
    }
}

/// Describes an image that cannot be read, with the paths that were tried.
pub(crate) fn missing_image(name: &str, looked_for: &[PathBuf]) -> String {
    match looked_for {
        [] => name.to_owned(),
        all => {
            let all: Vec<String> = all.iter().map(|file| file.display().to_string()).collect();
            format!("{name} (looked for as {})", all.join(" and "))
        }
    }
}

/// Sets the image of a texture, or of an extension for another image format; returns whether the image exists.
fn set_source(names: &mut Value, place: impl Fn(&Value) -> Option<usize>) -> bool {
    let Some(source) = names.get_mut("source") else { return false };
    let found = place(source);
    match found {
        Some(place) => *source = json!(place),
        None => drop(names.as_object_mut().and_then(|names| names.remove("source"))),
    }
    found.is_some()
}

/// Applies `keep` to every texture in a JSON value, at any depth.
fn keep_textures(value: &mut Value, keep: &impl Fn(&mut Value) -> Option<()>) {
    match value {
        Value::Object(members) => {
            members.retain(|name, value| {
                let is_texture = name.ends_with("Texture") && value.is_object();
                !is_texture || keep(value).is_some()
            });
            members.values_mut().for_each(|value| keep_textures(value, keep));
        }
        Value::Array(items) => items.iter_mut().for_each(|value| keep_textures(value, keep)),
        _ => {}
    }
}

/// Collects the names of the extensions in a JSON value, at any depth.
fn extensions(value: &Value, found: &mut Vec<String>) {
    match value {
        Value::Object(members) => {
            let own = members.get("extensions").and_then(Value::as_object);
            found.extend(own.into_iter().flat_map(|own| own.keys().cloned()));
            members.values().for_each(|value| extensions(value, found));
        }
        Value::Array(items) => items.iter().for_each(|value| extensions(value, found)),
        _ => {}
    }
}
