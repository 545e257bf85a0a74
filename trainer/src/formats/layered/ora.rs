//! OpenRaster: a zip archive of a `stack.xml` and a PNG for each layer.

use super::tree::{DEPTH, Node, damaged, too_large, wrongly_clipped};
use crate::Error;
use crate::formats::pixels::{Pixels, check_size, read_png};
use roxmltree::Document;
use std::cell::RefCell;
use std::fmt::Display;
use std::fs::File;
use std::io::{BufReader, Cursor, Read};
use zip::ZipArchive;
use zip::result::ZipError;

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
    /// File and position (x and y) of each layer or group, by its index in the file.
    entries: Vec<(String, [i64; 2])>,
}

impl Archive {
    /// Opens an archive; returns its layers, and the width and height of the picture.
    ///
    /// # Errors
    /// The file is not a zip archive, lacks its list of layers, is damaged or too large, or a layer is clipped to several
    /// layers.
    pub(super) fn open(file: File) -> Result<(Self, [usize; 2], Vec<Node>), Error> {
        let no_archive = |error: ZipError| {
            let what = format!("expected an OpenRaster file, which is a zip archive: {error}");
            Error::damaged(what).caused_by(error)
        };
        let zip = ZipArchive::new(BufReader::new(file));
        let zip = RefCell::new(zip.map_err(no_archive)?);
        let text = String::from_utf8(entry(&zip, "stack.xml", LIST)?).map_err(wrong_list)?;
        let spaces = text.matches("xmlns").count();
        if spaces > SPACES {
            let what = format!("stack.xml: {spaces} namespaces, expected at most {SPACES}");
            return Err(too_large(what));
        }
        let document = Document::parse(&text).map_err(wrong_list)?;
        let image = document.root_element();
        let size = ["w", "h"].map(|name| number::<usize>(image, name).transpose());
        let [Some(width), Some(height)] = size else {
            return Err(wrong_list("image: expected w and h"));
        };
        let size = [width?, height?];
        check_size(size).map_err(too_large)?;
        let mut entries = Vec::new();
        let root = image.children().find(|node| node.has_tag_name("stack"));
        let root = root.ok_or_else(|| wrong_list("image: no stack"))?;
        let nodes = members(root, &mut entries, DEPTH)?;
        Ok((Self { zip, entries }, size, nodes))
    }

    /// Decodes the picture of a layer; also returns the position of its upper left corner.
    ///
    /// # Errors
    /// The fault, in words.
    pub(super) fn picture(&self, source: usize) -> Result<(Pixels, [i64; 2]), String> {
        let (file, corner) = &self.entries[source];
        let bytes = entry(&self.zip, file, PICTURE).map_err(|error| error.to_string())?;
        let pixels = read_png(Cursor::new(bytes)).map_err(|error| format!("{file}: {error}"))?;
        Ok((pixels, *corner))
    }
}

/// Makes the error of a list of layers that cannot be read.
fn wrong_list(what: impl Display) -> Error {
    Error::damaged(format!("stack.xml: {what}"))
}

/// Reads a file of the archive, of at most `most` bytes.
fn entry(
    zip: &RefCell<ZipArchive<BufReader<File>>>,
    name: &str,
    most: u64,
) -> Result<Vec<u8>, Error> {
    let mut zip = zip.borrow_mut();
    let missing = || Error::missing(format!("has no {name}: expected an OpenRaster file"));
    let index = zip.index_for_name(name).ok_or_else(missing)?;
    let damaged = |error: &dyn Display| damaged(format!("{name}: {error}"));
    let file = zip.by_index(index).map_err(|error| damaged(&error))?;
    let mut bytes = Vec::new();
    file.take(most + 1).read_to_end(&mut bytes).map_err(|error| damaged(&error))?;
    if bytes.len() as u64 > most {
        return Err(too_large(format!("{name}, expected at most {most} bytes")));
    }
    Ok(bytes)
}

/// Parses a numeric attribute; `None` if it is missing.
fn number<T: std::str::FromStr>(
    node: roxmltree::Node<'_, '_>,
    name: &str,
) -> Result<Option<T>, Error> {
    let Some(text) = node.attribute(name) else { return Ok(None) };
    let wrong = || {
        let own = node.attribute("name").unwrap_or(node.tag_name().name());
        wrong_list(format!("{own}: {name} is \"{text}\", expected a number"))
    };
    text.trim().parse().map(Some).map_err(|_| wrong())
}

/// Reads the members of a stack, the hindmost first; the file lists the front first.
fn members(
    stack: roxmltree::Node<'_, '_>,
    entries: &mut Vec<(String, [i64; 2])>,
    depth: usize,
) -> Result<Vec<Node>, Error> {
    if depth == 0 {
        return Err(wrong_list(format!("groups within groups, more than {DEPTH} deep")));
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
            (false, None) => return Err(wrong_list(format!("{name}: it has no src"))),
        };
        entries.push((file, corner));
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
            return Err(wrongly_clipped(&node.name, base));
        }
        below += usize::from(!node.is_clipped);
    }
    Ok(out)
}
