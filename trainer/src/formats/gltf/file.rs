//! A glTF file and the buffers it refers to.

use std::path::{Path, PathBuf};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use gltf::binary::Glb;
use gltf::buffer::Source;
use gltf::json::validation::Checked;
use gltf::{Document, Gltf};
use percent_encoding::percent_decode_str;
use serde_json::{Map, Value};

use crate::formats::error::FormatError;
use crate::formats::scene::SceneError;

/// The bytes of each buffer.
pub(super) type Buffers = Vec<Vec<u8>>;

/// Reads a file and every buffer that it names, inside it or beside it.
pub(super) fn open(path: &Path) -> Result<(Document, Buffers), FormatError> {
    let bytes = std::fs::read(path).map_err(FormatError::Read)?;
    Ok(parse(&bytes, path)?)
}

/// Parses the bytes of a file and reads every buffer that it names, inside it or beside it.
pub(super) fn parse(bytes: &[u8], path: &Path) -> Result<(Document, Buffers), SceneError> {
    check_whole(bytes)?;
    let not_gltf = |error: gltf::Error| SceneError::NotGltf { reason: error.to_string() };
    let Gltf { document, mut blob } =
        Gltf::from_slice_without_validation(bytes).map_err(not_gltf)?;
    let mut json = document.into_json();
    check_indices(&json)?;
    check_extensions(&json)?;
    // The library refuses those that it does not know, whatever they are about.
    json.extensions_required.clear();
    let document = Document::from_json(json).map_err(not_gltf)?;
    let mut buffers = Vec::new();
    for buffer in document.buffers() {
        let bytes = match buffer.source() {
            Source::Bin => blob.take().ok_or("the file has no binary chunk".to_owned()),
            Source::Uri(uri) => resource(uri, path),
        };
        let expected = buffer.length();
        let bytes = bytes.and_then(|bytes| match bytes.len() {
            found if found < expected => Err(format!("expected {expected} bytes, found {found}")),
            _ => Ok(bytes),
        });
        let damaged = |reason| SceneError::Buffer { buffer: buffer.index(), reason };
        buffers.push(bytes.map_err(damaged)?);
    }
    Ok((document, buffers))
}

/// Gives all the members of a file whose bytes [`parse`] takes.
///
/// # Errors
/// [`SceneError::NotGltf`]
pub(super) fn tree(bytes: &[u8]) -> Result<Map<String, Value>, SceneError> {
    let not_gltf = |reason: String| SceneError::NotGltf { reason };
    let json = match bytes.starts_with(b"glTF") {
        true => Glb::from_slice(bytes).map_err(|error| not_gltf(error.to_string()))?.json,
        false => bytes.into(),
    };
    serde_json::from_slice(&json).map_err(|error| not_gltf(error.to_string()))
}

/// Checks that a binary file has as many bytes as it says.
fn check_whole(bytes: &[u8]) -> Result<(), SceneError> {
    let (Some(b"glTF"), Some(len)) = (bytes.first_chunk(), bytes.get(8..12)) else { return Ok(()) };
    let expected = len.iter().rev().fold(0, |all, &byte| all << 8 | usize::from(byte));
    match bytes.len() {
        found if found < expected => Err(SceneError::CutShort { expected, found }),
        _ => Ok(()),
    }
}

/// Checks the indices that the library trusts: gltf-json 1.4 looks into the accessors of a
/// primitive's positions before it knows that they are there, and does not look at a channel's
/// target and sampler at all.
fn check_indices(json: &gltf::json::Root) -> Result<(), SceneError> {
    let check = |place: String, what, len: usize, found: usize| {
        if found < len {
            return Ok(());
        }
        Err(SceneError::NoSuch { place, what, found, len })
    };
    for (number, mesh) in json.meshes.iter().enumerate() {
        for accessor in mesh.primitives.iter().flat_map(|p| p.attributes.values()) {
            let place = format!("mesh {number}");
            check(place, "accessor", json.accessors.len(), accessor.value())?;
        }
    }
    for (number, animation) in json.animations.iter().enumerate() {
        let place = || format!("animation {number}");
        for channel in &animation.channels {
            check(place(), "node", json.nodes.len(), channel.target.node.value())?;
            if channel.target.path == Checked::Invalid {
                let reason = format!("animation {number} animates an unknown property");
                return Err(SceneError::NotGltf { reason });
            }
            check(place(), "sampler", animation.samplers.len(), channel.sampler.value())?;
        }
    }
    Ok(())
}

/// Extensions that change nothing of shapes and motion, or that are read: integers for positions.
const HARMLESS: [&str; 5] =
    ["KHR_materials_", "KHR_texture_", "EXT_texture_", "KHR_lights_", "KHR_mesh_quantization"];

fn check_extensions(json: &gltf::json::Root) -> Result<(), SceneError> {
    let harmless = |name: &&String| HARMLESS.iter().any(|known| name.starts_with(known));
    match json.extensions_required.iter().find(|name| !harmless(name)) {
        None => Ok(()),
        Some(name) => Err(SceneError::Extension { name: name.clone() }),
    }
}

/// Reads what a URI names: data within it, or a file beside `path`.
pub(super) fn resource(uri: &str, path: &Path) -> Result<Vec<u8>, String> {
    if let Some(data) = uri.strip_prefix("data:") {
        let (_, text) = data.split_once(";base64,").ok_or("its data URI is not base64")?;
        return STANDARD.decode(text).map_err(|error| error.to_string());
    }
    let file = beside(uri, path)?;
    std::fs::read(&file).map_err(|error| format!("{}: {error}", file.display()))
}

/// Gives the file beside `path` that a URI names.
pub(super) fn beside(uri: &str, path: &Path) -> Result<PathBuf, String> {
    if uri.contains(':') {
        return Err(format!("{uri} is no file beside this one"));
    }
    let name = percent_decode_str(uri).decode_utf8().map_err(|error| error.to_string())?;
    Ok(path.with_file_name(&*name))
}
