//! OpenRaster: a zip archive of a `stack.xml` and a PNG for each layer.

use super::tree::{DEPTH, Node};
use crate::formats::error::LayeredError;
use crate::formats::pixels::{Pixels, check_size, read_png};
use roxmltree::Document;
use std::cell::RefCell;
use std::fs::File;
use std::io::{BufReader, Cursor, Read};
use zip::ZipArchive;

/// Most bytes of `stack.xml`, enough for thousands of layers. Parsing time grows with the square of the number of an
/// element's attributes, and of all namespaces.
const LIST: u64 = 1 << 19;
/// Most declarations of namespaces.
const SPACES: usize = 64;
/// Most bytes of a layer's PNG.
const PICTURE: u64 = 1 << 29;
/// Blend mode of layers that lie over the layers below.
const NORMAL: &str = "svg:src-over";
/// Blend mode of layers that show only within the layers below.
const CLIPPED: &str = "svg:src-atop";

/// An open archive.
pub(super) struct Archive {
    zip: RefCell<ZipArchive<BufReader<File>>>,
    /// File and position of each layer or group, by its index in the file.
    entries: Vec<Entry>,
}

struct Entry {
    file: String,
    corner: [i64; 2],
}

impl Archive {
    /// Opens an archive; returns its layers, and the width and height of the picture.
    ///
    /// # Errors
    /// [`LayeredError`]
    pub(super) fn open(file: File) -> Result<(Self, [usize; 2], Vec<Node>), LayeredError> {
        let zip = ZipArchive::new(BufReader::new(file));
        let zip = RefCell::new(zip.map_err(|error| LayeredError::Archive(error.to_string()))?);
        let text = String::from_utf8(entry(&zip, "stack.xml", LIST)?)
            .map_err(|error| LayeredError::Stack(error.to_string()))?;
        let spaces = text.matches("xmlns").count();
        if spaces > SPACES {
            let what = format!("stack.xml: {spaces} namespaces, expected at most {SPACES}");
            return Err(LayeredError::TooLarge(what));
        }
        let document =
            Document::parse(&text).map_err(|error| LayeredError::Stack(error.to_string()))?;
        let image = document.root_element();
        let size = ["w", "h"].map(|name| number::<usize>(image, name).transpose());
        let [Some(width), Some(height)] = size else {
            return Err(LayeredError::Stack("image: expected w and h".to_owned()));
        };
        let size = [width?, height?];
        check_size(size).map_err(LayeredError::TooLarge)?;
        let mut entries = Vec::new();
        let root = image.children().find(|node| node.has_tag_name("stack"));
        let root = root.ok_or_else(|| LayeredError::Stack("image: no stack".to_owned()))?;
        let nodes = members(root, &mut entries, DEPTH)?;
        Ok((Self { zip, entries }, size, nodes))
    }

    /// Decodes the picture of a layer; also returns the position of its upper left corner.
    ///
    /// # Errors
    /// The fault, in words.
    pub(super) fn picture(&self, source: usize) -> Result<(Pixels, [i64; 2]), String> {
        let Entry { file, corner } = &self.entries[source];
        let bytes = entry(&self.zip, file, PICTURE).map_err(|error| error.to_string())?;
        let pixels = read_png(Cursor::new(bytes)).map_err(|error| format!("{file}: {error}"))?;
        Ok((pixels, *corner))
    }
}

/// Reads a file of the archive, of at most `most` bytes.
fn entry(
    zip: &RefCell<ZipArchive<BufReader<File>>>,
    name: &str,
    most: u64,
) -> Result<Vec<u8>, LayeredError> {
    let mut zip = zip.borrow_mut();
    let index = zip.index_for_name(name).ok_or_else(|| LayeredError::Missing(name.to_owned()))?;
    let damaged = |error: &dyn std::fmt::Display| LayeredError::Damaged(format!("{name}: {error}"));
    let file = zip.by_index(index).map_err(|error| damaged(&error))?;
    let mut bytes = Vec::new();
    file.take(most + 1).read_to_end(&mut bytes).map_err(|error| damaged(&error))?;
    if bytes.len() as u64 > most {
        return Err(LayeredError::TooLarge(format!("{name}, expected at most {most} bytes")));
    }
    Ok(bytes)
}

/// Parses a numeric attribute; `None` if it is missing.
fn number<T: std::str::FromStr>(
    node: roxmltree::Node<'_, '_>,
    name: &str,
) -> Result<Option<T>, LayeredError> {
    let Some(text) = node.attribute(name) else { return Ok(None) };
    let wrong = || {
        let own = node.attribute("name").unwrap_or(node.tag_name().name());
        LayeredError::Stack(format!("{own}: {name} is \"{text}\", expected a number"))
    };
    text.trim().parse().map(Some).map_err(|_| wrong())
}

/// Reads the members of a stack, the hindmost first; the file lists the front first.
fn members(
    stack: roxmltree::Node<'_, '_>,
    entries: &mut Vec<Entry>,
    depth: usize,
) -> Result<Vec<Node>, LayeredError> {
    if depth == 0 {
        return Err(LayeredError::Stack(format!("groups within groups, more than {DEPTH} deep")));
    }
    let mut out = Vec::new();
    for node in stack.children().filter(roxmltree::Node::is_element) {
        let is_group = node.has_tag_name("stack");
        if !is_group && !node.has_tag_name("layer") {
            continue;
        }
        let name = node.attribute("name").unwrap_or_default().to_owned();
        let source = entries.len();
        let corner = [number(node, "x")?.unwrap_or(0), number(node, "y")?.unwrap_or(0)];
        let file = match (is_group, node.attribute("src")) {
            (_, Some(file)) => file.to_owned(),
            (true, None) => String::new(),
            (false, None) => return Err(LayeredError::Stack(format!("{name}: it has no src"))),
        };
        entries.push(Entry { file, corner });
        let mode = node.attribute("composite-op").unwrap_or(NORMAL);
        out.push(Node {
            name,
            source,
            opacity: number(node, "opacity")?.unwrap_or(1.0f64).clamp(0.0, 1.0),
            blend: (mode != NORMAL && mode != CLIPPED).then(|| mode.to_owned()),
            is_hidden: node.attribute("visibility") == Some("hidden"),
            is_clipped: mode == CLIPPED,
            members: is_group.then(|| members(node, entries, depth - 1)).transpose()?,
        });
    }
    out.reverse();
    // A layer that shows only within several layers below cannot be represented.
    let mut below = 0;
    for node in &out {
        if node.is_clipped && !node.is_hidden && below > 1 {
            let base = format!("all of {below} layers below it");
            return Err(LayeredError::Clip { layer: node.name.clone(), base });
        }
        below += usize::from(!node.is_clipped);
    }
    Ok(out)
}
