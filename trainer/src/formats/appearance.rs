//! What the meshes of a scene look like: beside what moves them, for who writes them again.
//! The appearance of a file's meshes, by its format.
//! Names, materials and images, as glTF states them.
//! The kinds of images that glTF knows, and what is said of those that are not there.

use super::error::FileError;
use super::extension::extension;
use super::{fbx, gltf};
use serde_json::{Map, Value, json};
use std::path::{Path, PathBuf};

/// Reads what the meshes of a scene look like (`.glb`, `.gltf`, `.fbx`), for the triangles in the order in
/// which its reader gives them; nothing is known of other files.
///
/// # Errors
/// A [`FileError`] that names the file, which cannot be read or is damaged. An image that cannot be read
/// is no error, but listed.
pub fn load(path: &Path) -> Result<Appearance, FileError> {
    let read = match extension(path).as_str() {
        "glb" | "gltf" => gltf::rigged::read_appearance(path),
        "fbx" => fbx::appearance::read(path),
        _ => Ok(Appearance::default()),
    };
    read.map_err(|error| FileError { file: path.to_owned(), error })
}

/// What the meshes of a scene look like.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Appearance {
    /// Name of the one mesh, where there is one; several have theirs among the ranges of the examples.
    pub mesh: Option<String>,
    /// Material of each triangle, T.
    pub of_triangles: Vec<Option<usize>>,
    /// Materials.
    pub materials: Vec<Value>,
    /// Textures that materials name.
    pub textures: Vec<Value>,
    /// Samplers that textures name.
    pub samplers: Vec<Value>,
    /// Images that textures name.
    pub images: Vec<Image>,
    /// Extensions that the file asks every reader to know, of those that are in these.
    pub required: Vec<String>,
    /// Images that cannot be read, by name and by where they were looked for; no material has them.
    pub missing: Vec<String>,
}

/// A picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// What is said of it, but where it is.
    pub members: Map<String, Value>,
    /// Its file, whole.
    pub bytes: Vec<u8>,
}

impl Appearance {
    /// Takes images in the place of the file's, of which some cannot be read, and takes those textures
    /// away that have none.
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

    /// Takes the textures away that need other coordinates than one set, or any at all where there are
    /// none.
    pub(crate) fn keep_uv(&mut self, uv: bool) {
        self.keep_textures(|texture| {
            let set = |at: &Value| at.get("texCoord").and_then(Value::as_u64);
            let transformed = texture["extensions"].get("KHR_texture_transform").and_then(set);
            (uv && transformed.or(set(texture)).unwrap_or(0) == 0).then_some(())
        });
    }

    /// Lists the extensions that are in use, in order.
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

    fn keep_textures(&mut self, keep: impl Fn(&mut Value) -> Option<()>) {
        self.materials.iter_mut().for_each(|material| keep_textures(material, &keep));
    }
}

/// Sets the image that a texture names, or one of its extensions for another kind of image; tells whether
/// there is one.
fn set_source(names: &mut Value, place: impl Fn(&Value) -> Option<usize>) -> bool {
    let Some(source) = names.get_mut("source") else { return false };
    let found = place(source);
    match found {
        Some(place) => *source = json!(place),
        None => drop(names.as_object_mut().and_then(|names| names.remove("source"))),
    }
    found.is_some()
}

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

/// Tells the media type of an image by its first bytes.
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

/// Names an image that cannot be read, with the files that it was looked for in.
pub(crate) fn missing_image(name: &str, looked_for: &[PathBuf]) -> String {
    match looked_for {
        [] => name.to_owned(),
        all => {
            let all: Vec<String> = all.iter().map(|file| file.display().to_string()).collect();
            format!("{name} (looked for as {})", all.join(" and "))
        }
    }
}
