//! A glTF file, its buffers, and the arrays and triangles in them.

use super::nodes::Nodes;
use crate::Error;
use crate::formats::FormatWarning;
use crate::formats::extension::{empty_file, unmarked};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use gltf::accessor::DataType;
use gltf::binary::Glb;
use gltf::buffer::Source;
use gltf::json::validation::Checked;
use gltf::mesh::Mode;
use gltf::{Document, Primitive};
use percent_encoding::percent_decode_str;
use serde_json::{Map, Value, json};
use std::borrow::Cow;
use std::fmt::Display;
use std::path::{Path, PathBuf};

/// Bytes of a binary file's header: magic, version and total length.
const HEADER_BYTES: usize = 12;

/// Supported extensions: they do not concern shapes and motion, or are read (integer positions), or lose their channels
/// with a warning (pointers).
const HARMLESS: [&str; 6] = [
    "KHR_materials_",
    "KHR_texture_",
    "EXT_texture_",
    "KHR_lights_",
    "KHR_mesh_quantization",
    "KHR_animation_pointer",
];

/// Most elements that a sparse accessor may leave at zero without data.
const ZEROS_MAX: usize = 10_000_000;

/// The bytes of each buffer.
pub(super) type Buffers = Vec<Vec<u8>>;

/// A file, its buffers and its nodes.
pub(super) struct Parsed {
    pub(super) document: Document,
    pub(super) buffers: Buffers,
    pub(super) nodes: Nodes,
    /// A warning if clips have channels that name no node; these channels were left out.
    pub(super) untargeted: Option<FormatWarning>,
}

/// Reads a file and its buffers, embedded or in files beside it.
pub(super) fn open(path: &Path) -> Result<Parsed, Error> {
    parse(&read(path)?, path)
}

/// Reads the bytes of a file; an empty file is an error.
pub(super) fn read(path: &Path) -> Result<Vec<u8>, Error> {
    let bytes = std::fs::read(path).map_err(Error::read)?;
    if bytes.is_empty() { Err(empty_file()) } else { Ok(bytes) }
}

/// Parses the bytes of a file and reads its nodes, and its buffers, embedded or in files beside it.
pub(super) fn parse(bytes: &[u8], path: &Path) -> Result<Parsed, Error> {
    check_whole(bytes)?;
    let mut tree = tree(bytes)?;
    let untargeted = drop_untargeted(&mut tree);
    let untargeted = FormatWarning::listed(FormatWarning::UntargetedChannels, untargeted);
    state_nodes(&mut tree);
    let mut json: gltf::json::Root =
        serde_json::from_value(Value::Object(tree)).map_err(not_gltf)?;
    check_indices(&json)?;
    check_extensions(&json)?;
    // The library refuses every extension that it does not know, even a harmless one.
    json.extensions_required.clear();
    let document = Document::from_json(json).map_err(not_gltf)?;
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
        let damaged =
            |reason: String| Error::damaged(format!("buffer {}: {reason}", buffer.index()));
        buffers.push(bytes.map_err(damaged)?);
    }
    let nodes = Nodes::read(&document)?;
    Ok(Parsed { document, buffers, nodes, untargeted })
}

/// Returns the JSON of a file; `bytes` is as for [`parse`].
///
/// # Errors
/// The file is not glTF 2.0.
pub(super) fn tree(bytes: &[u8]) -> Result<Map<String, Value>, Error> {
    let (json, _) = chunks(bytes)?;
    serde_json::from_slice(&json).map_err(not_gltf)
}

/// Makes a name for a clip that has none.
pub(super) fn unnamed_clip(number: usize) -> String {
    format!("animation {number}")
}

/// Reads the content of a URI: embedded data, or a file beside `path`.
pub(super) fn resource(uri: &str, path: &Path) -> Result<Vec<u8>, String> {
    if let Some(data) = uri.strip_prefix("data:") {
        let (_, text) = data.split_once(";base64,").ok_or("its data URI is not base64")?;
        return STANDARD.decode(text).map_err(|error| error.to_string());
    }
    let file = beside(uri, path)?;
    std::fs::read(&file).map_err(|error| format!("{}: {error}", file.display()))
}

/// Returns the path of the file beside `path` that a URI names.
pub(super) fn beside(uri: &str, path: &Path) -> Result<PathBuf, String> {
    if uri.contains(':') {
        return Err(format!("{uri} is no file beside this one"));
    }
    let name = percent_decode_str(uri).decode_utf8().map_err(|error| error.to_string())?;
    Ok(path.with_file_name(&*name))
}

/// Reads an accessor whose elements have `width` components. Returns all components of all elements, in order;
/// normalised integers are scaled to [0, 1] or [-1, 1].
///
/// # Errors
/// The elements have another width, or lie outside their buffer.
pub(super) fn numbers(
    accessor: &gltf::Accessor<'_>,
    buffers: &Buffers,
    width: usize,
) -> Result<Vec<f64>, Error> {
    let damaged =
        |reason: String| Error::damaged(format!("accessor {} {reason}", accessor.index()));
    let found = accessor.dimensions().multiplicity();
    if found != width {
        return Err(damaged(format!("has {found} components an element, expected {width}")));
    }
    let outside = || damaged("reaches beyond its buffer".to_owned());
    let kind = accessor.data_type();
    let read = |view: gltf::buffer::View<'_>, offset, count| {
        let elements = elements(&view, buffers, offset, count, width * kind.size())?;
        let numbers = elements.flat_map(|element| element.chunks_exact(kind.size()));
        let number = |bytes| component(bytes, kind, accessor.normalized());
        Some(numbers.map(number).collect::<Vec<f64>>())
    };
    let count = accessor.count();
    let mut all = match accessor.view() {
        Some(view) => read(view, accessor.offset(), count).ok_or_else(outside)?,
        // No data bounds the number of implied zeros, so only a bounded sparse accessor may have them.
        None if accessor.sparse().is_none() || count > ZEROS_MAX => {
            return Err(damaged("has no buffer view".to_owned()));
        }
        None => vec![0.0; width * count],
    };
    let Some(sparse) = accessor.sparse() else { return Ok(all) };
    let values = read(sparse.values().view(), sparse.values().offset(), sparse.count())
        .ok_or_else(outside)?;
    let indices = sparse.indices();
    let bytes = indices.index_type().size();
    let places = elements(&indices.view(), buffers, indices.offset(), sparse.count(), bytes)
        .ok_or_else(outside)?;
    for (place, values) in places.zip(values.chunks_exact(width)) {
        let place = whole(place);
        let element = all.chunks_exact_mut(width).nth(place).ok_or_else(outside)?;
        element.copy_from_slice(values);
    }
    Ok(all)
}

/// Returns true for a primitive of triangles, and false for points and lines.
pub(super) fn is_surface(primitive: &Primitive<'_>) -> bool {
    matches!(primitive.mode(), Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan)
}

/// Lists the corners of a primitive's triangles, as indices of its `vertex_len` vertices.
///
/// Strips and fans may repeat a corner to join two parts; triangles with a repeated corner are left out. As in engines,
/// the largest index of the index type restarts a strip or fan.
///
/// # Errors
/// The indices cannot be read, a vertex does not exist, or the list ends within a triangle.
pub(super) fn triangles(
    primitive: &Primitive<'_>,
    buffers: &Buffers,
    vertex_len: usize,
    place: impl Fn() -> String,
) -> Result<Vec<[usize; 3]>, Error> {
    let mode = primitive.mode();
    let indices = primitive.indices();
    let restart = indices.as_ref().and_then(|indices| restart(indices.data_type()));
    let corners: Vec<usize> = match indices {
        Some(indices) => numbers(&indices, buffers, 1)?.into_iter().map(|x| x as usize).collect(),
        None => (0..vertex_len).collect(),
    };
    let is_restart = |corner: &usize| mode != Mode::Triangles && Some(*corner) == restart;
    let missing = |corner: &&usize| **corner >= vertex_len && !is_restart(corner);
    if let Some(&found) = corners.iter().find(missing) {
        return Err(no_such(place(), "vertex", found, vertex_len));
    }
    if mode == Mode::Triangles {
        let (triangles, rest) = corners.as_chunks::<3>();
        if !rest.is_empty() {
            let (expected, found) = (3 * triangles.len(), corners.len());
            return Err(other_count(place(), "corners in whole triangles", expected, found));
        }
        return Ok(triangles.to_vec());
    }
    let runs = corners.split(is_restart);
    let of_run = |run: &[usize]| -> Vec<[usize; 3]> {
        let triangle = |(number, own): (usize, &[usize])| match (mode, number % 2) {
            (Mode::TriangleFan, _) => [own[1], own[2], run[0]],
            (_, 0) => [own[0], own[1], own[2]],
            _ => [own[0], own[2], own[1]],
        };
        run.windows(3).enumerate().map(triangle).collect()
    };
    let all = runs.flat_map(of_run);
    Ok(all.filter(|[a, b, c]| a != b && b != c && c != a).collect())
}

/// Bytes of a part of a file.
type Chunk<'a> = Cow<'a, [u8]>;

/// Returns the JSON of a file, and the binary chunk if the file has one.
fn chunks(bytes: &[u8]) -> Result<(Chunk<'_>, Option<Chunk<'_>>), Error> {
    if !bytes.starts_with(b"glTF") {
        return Ok((bytes.into(), None));
    }
    let damaged = |error: gltf::Error| match error {
        gltf::Error::Binary(gltf::binary::Error::Io(_)) => not_gltf("its chunks are cut short"),
        other => not_gltf(other),
    };
    let Glb { json, bin, .. } = Glb::from_slice(bytes).map_err(damaged)?;
    Ok((json, bin))
}

/// Drops the animation channels without a node, which readers must ignore by the specification, and channels with a
/// pointer, whose target an extension names. Returns the clips that had such channels.
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

/// Adds an empty list to scenes without nodes, because the library expects a list.
fn state_nodes(tree: &mut Map<String, Value>) {
    let scenes = tree.get_mut("scenes").and_then(Value::as_array_mut);
    for scene in scenes.into_iter().flatten().filter_map(Value::as_object_mut) {
        scene.entry("nodes").or_insert_with(|| json!([]));
    }
}

/// Checks that a file begins as glTF, and that a binary file is as long as its header says.
fn check_whole(bytes: &[u8]) -> Result<(), Error> {
    if !b"glTF".starts_with(&bytes[..bytes.len().min(4)]) {
        let text = unmarked(bytes).trim_ascii_start();
        return match text.first() {
            Some(b'{') => Ok(()),
            _ => Err(not_gltf("it begins neither with glTF nor, as JSON, with a brace")),
        };
    }
    let expected = whole(bytes.get(8..HEADER_BYTES).unwrap_or_default());
    match (expected.max(HEADER_BYTES), bytes.len()) {
        (expected, found) if found < expected => Err(Error::damaged(format!(
            "is cut short: expected at least {expected} bytes, found {found}; export it, or copy it, again"
        ))),
        _ => Ok(()),
    }
}

/// Checks indices that the library does not check. gltf-json 1.4 reads the accessors of a primitive's positions before
/// checking that they exist, and never checks the target and sampler of a channel.
fn check_indices(json: &gltf::json::Root) -> Result<(), Error> {
    let check = |place: String, what, len: usize, found: usize| match found < len {
        true => Ok(()),
        false => Err(no_such(place, what, found, len)),
    };
    for (number, mesh) in json.meshes.iter().enumerate() {
        for accessor in mesh.primitives.iter().flat_map(|p| p.attributes.values()) {
            check(format!("mesh {number}"), "accessor", json.accessors.len(), accessor.value())?;
        }
    }
    for (number, animation) in json.animations.iter().enumerate() {
        let place = || format!("animation {number}");
        for channel in &animation.channels {
            check(place(), "node", json.nodes.len(), channel.target.node.value())?;
            if channel.target.path == Checked::Invalid {
                return Err(not_gltf(format!("animation {number} animates an unknown property")));
            }
            check(place(), "sampler", animation.samplers.len(), channel.sampler.value())?;
        }
    }
    Ok(())
}

fn check_extensions(json: &gltf::json::Root) -> Result<(), Error> {
    let harmless = |name: &&String| HARMLESS.iter().any(|known| name.starts_with(known));
    match json.extensions_required.iter().find(|name| !harmless(name)) {
        None => Ok(()),
        Some(name) => Err(unread_extension(name)),
    }
}

/// Makes the error for a required extension that is not supported.
pub(super) fn unread_extension(name: &str) -> Error {
    Error::unsupported(format!(
        "needs the glTF extension {name}, which is not read: export without compression, and without \
         instancing"
    ))
}

/// Makes the error for two counts that must agree but differ.
pub(super) fn other_count(place: impl Display, what: &str, expected: usize, found: usize) -> Error {
    Error::mismatch(format!("{place}: expected {expected} {what}, found {found}"))
}

/// Makes the error for an index of an item that does not exist; there are `len` items.
pub(super) fn no_such(place: impl Display, what: &str, found: usize, len: usize) -> Error {
    Error::damaged(format!("{place} names {what} {found} of {len}"))
}

fn not_gltf(reason: impl Display) -> Error {
    Error::damaged(format!("is no glTF 2.0: {reason}"))
}

/// Returns the bytes of each of `count` elements of a buffer view, from `offset` on; `None` if they lie outside the
/// view or its buffer.
///
/// - `bytes`: bytes of an element.
fn elements<'a>(
    view: &gltf::buffer::View<'_>,
    buffers: &'a Buffers,
    offset: usize,
    count: usize,
    bytes: usize,
) -> Option<impl Iterator<Item = &'a [u8]> + use<'a>> {
    let stride = view.stride().unwrap_or(bytes);
    if stride < bytes {
        return None;
    }
    let begin = view.offset();
    let view = buffers.get(view.buffer().index())?.get(begin..begin.checked_add(view.length())?)?;
    let span = match count.checked_sub(1) {
        Some(last) => last.checked_mul(stride)?.checked_add(bytes)?,
        None => 0,
    };
    let data = view.get(offset..offset.checked_add(span)?)?;
    Some(data.chunks(stride).map(move |element| &element[..bytes]))
}

/// Reads a number; normalised integers are scaled to [0, 1] or [-1, 1].
fn component(bytes: &[u8], kind: DataType, normalized: bool) -> f64 {
    let (number, most) = match (kind, bytes) {
        (DataType::I8, &[a]) => (f64::from(a as i8), f64::from(i8::MAX)),
        (DataType::U8, &[a]) => (f64::from(a), f64::from(u8::MAX)),
        (DataType::I16, &[a, b]) => (f64::from(i16::from_le_bytes([a, b])), f64::from(i16::MAX)),
        (DataType::U16, &[a, b]) => (f64::from(u16::from_le_bytes([a, b])), f64::from(u16::MAX)),
        (DataType::U32, &[a, b, c, d]) => {
            (f64::from(u32::from_le_bytes([a, b, c, d])), f64::from(u32::MAX))
        }
        (_, &[a, b, c, d]) => return f64::from(f32::from_le_bytes([a, b, c, d])),
        _ => return f64::NAN,
    };
    if normalized { (number / most).max(-1.0) } else { number }
}

/// Reads a whole number that is not negative, of any number of bytes.
fn whole(bytes: &[u8]) -> usize {
    bytes.iter().rev().fold(0, |all, &byte| all << 8 | usize::from(byte))
}

/// Returns the index that restarts a strip or fan.
fn restart(kind: DataType) -> Option<usize> {
    match kind {
        DataType::U8 => Some(u8::MAX.into()),
        DataType::U16 => Some(u16::MAX.into()),
        DataType::U32 => usize::try_from(u32::MAX).ok(),
        _ => None,
    }
}
