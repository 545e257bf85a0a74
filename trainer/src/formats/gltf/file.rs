//! A glTF file and the buffers it refers to.

use std::path::{Path, PathBuf};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use gltf::Document;
use gltf::binary::Glb;
use gltf::buffer::Source;
use gltf::json::validation::Checked;
use percent_encoding::percent_decode_str;
use serde_json::{Map, Value, json};
use std::borrow::Cow;

use crate::formats::error::FormatError;
use crate::formats::mark::unmarked;
use crate::formats::scene::SceneError;
use crate::formats::warning::FormatWarning;

/// The bytes of each buffer.
pub(super) type Buffers = Vec<Vec<u8>>;

/// A file and its buffers.
pub(super) struct Parsed {
    pub(super) document: Document,
    pub(super) buffers: Buffers,
    /// Clips with channels that name no node, and were left out.
    pub(super) untargeted: Vec<String>,
}

impl Parsed {
    /// Tells of the channels that were left out.
    pub(super) fn warning(&self) -> Option<FormatWarning> {
        let clips = self.untargeted.clone();
        (!clips.is_empty()).then_some(FormatWarning::UntargetedChannels { clips })
    }
}

/// Reads a file and every buffer that it names, inside it or beside it.
pub(super) fn open(path: &Path) -> Result<Parsed, FormatError> {
    Ok(parse(&read(path)?, path)?)
}

/// Reads the bytes of a file and refuses an empty one.
pub(super) fn read(path: &Path) -> Result<Vec<u8>, FormatError> {
    let bytes = std::fs::read(path).map_err(FormatError::Read)?;
    if bytes.is_empty() { Err(FormatError::Empty) } else { Ok(bytes) }
}

/// Parses the bytes of a file and reads every buffer that it names, inside it or beside it.
pub(super) fn parse(bytes: &[u8], path: &Path) -> Result<Parsed, SceneError> {
    check_whole(bytes)?;
    let mut tree = tree(bytes)?;
    let untargeted = drop_untargeted(&mut tree);
    state_nodes(&mut tree);
    let mut json: gltf::json::Root = serde_json::from_value(Value::Object(tree))
        .map_err(|error| SceneError::NotGltf { reason: error.to_string() })?;
    check_indices(&json)?;
    check_extensions(&json)?;
    // The library refuses those that it does not know, whatever they are about.
    json.extensions_required.clear();
    let document = Document::from_json(json)
        .map_err(|error| SceneError::NotGltf { reason: error.to_string() })?;
    let mut blob = chunks(bytes)?.1.map(Cow::into_owned);
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
    Ok(Parsed { document, buffers, untargeted })
}

/// Gives all the members of a file whose bytes [`parse`] takes.
///
/// # Errors
/// [`SceneError::NotGltf`]
pub(super) fn tree(bytes: &[u8]) -> Result<Map<String, Value>, SceneError> {
    let (json, _) = chunks(bytes)?;
    serde_json::from_slice(&json).map_err(|error| SceneError::NotGltf { reason: error.to_string() })
}

/// Bytes of a part of a file.
type Chunk<'a> = Cow<'a, [u8]>;

/// Gives the JSON of a file, and the bytes that follow it in a binary file.
fn chunks(bytes: &[u8]) -> Result<(Chunk<'_>, Option<Chunk<'_>>), SceneError> {
    if !bytes.starts_with(b"glTF") {
        return Ok((bytes.into(), None));
    }
    let not_gltf = |error: gltf::Error| {
        let reason = match error {
            gltf::Error::Binary(gltf::binary::Error::Io(_)) => {
                "its chunks are cut short".to_owned()
            }
            other => other.to_string(),
        };
        SceneError::NotGltf { reason }
    };
    let Glb { json, bin, .. } = Glb::from_slice(bytes).map_err(not_gltf)?;
    Ok((json, bin))
}

/// Drops the animation channels without a node, which the specification has readers ignore, and those of pointers,
/// whose node an extension names; returns the clips that had any.
fn drop_untargeted(tree: &mut Map<String, Value>) -> Vec<String> {
    let mut clips = Vec::new();
    let animations = tree.get_mut("animations").and_then(Value::as_array_mut);
    for (number, animation) in animations.into_iter().flatten().enumerate() {
        let name = animation.get("name").and_then(Value::as_str);
        let name = name.map_or_else(|| unnamed_clip(number), str::to_owned);
        let Some(Value::Array(channels)) = animation.get_mut("channels") else { continue };
        let before = channels.len();
        channels.retain(|channel| {
            let Some(target) = channel.get("target") else { return true };
            target.get("node").is_some() && target.get("path") != Some(&json!("pointer"))
        });
        if channels.len() < before {
            clips.push(name);
        }
    }
    clips
}

/// Names a clip whose file does not.
pub(super) fn unnamed_clip(number: usize) -> String {
    format!("animation {number}")
}

/// Gives scenes without nodes an empty list, which the library expects.
fn state_nodes(tree: &mut Map<String, Value>) {
    let scenes = tree.get_mut("scenes").and_then(Value::as_array_mut);
    for scene in scenes.into_iter().flatten().filter_map(Value::as_object_mut) {
        scene.entry("nodes").or_insert_with(|| json!([]));
    }
}

/// Bytes of a binary file's header: magic, version and the length of the whole.
const HEADER_BYTES: usize = 12;

/// Checks that a file begins as glTF does, and that a binary one has as many bytes as it says.
fn check_whole(bytes: &[u8]) -> Result<(), SceneError> {
    if !b"glTF".starts_with(&bytes[..bytes.len().min(4)]) {
        let text = unmarked(bytes).trim_ascii_start();
        let reason = || "it begins neither with glTF nor, as JSON, with a brace".to_owned();
        return match text.first() {
            Some(b'{') => Ok(()),
            _ => Err(SceneError::NotGltf { reason: reason() }),
        };
    }
    let len = bytes.get(8..HEADER_BYTES).unwrap_or_default();
    let expected = len.iter().rev().fold(0, |all, &byte| all << 8 | usize::from(byte));
    match (expected.max(HEADER_BYTES), bytes.len()) {
        (expected, found) if found < expected => Err(SceneError::CutShort { expected, found }),
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

/// Extensions that change nothing of shapes and motion, that are read (integers for positions), or whose channels are
/// left out with a warning (pointers).
const HARMLESS: [&str; 6] = [
    "KHR_materials_",
    "KHR_texture_",
    "EXT_texture_",
    "KHR_lights_",
    "KHR_mesh_quantization",
    "KHR_animation_pointer",
];

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
