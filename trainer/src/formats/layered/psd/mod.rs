//! Photoshop files: layers, groups, masks (Adobe, "Photoshop File Formats Specification").
//!
//! The crates that read this format panic on damaged files, and none reads masks, deflated channels and 16 bits.

mod bytes;
mod channel;
mod record;

use super::error::LayeredError;
use super::tree::{DEPTH, Node};
use crate::formats::pixels::{Pixels, check_size, product};
use bytes::{Bytes, blocks};
use record::{Area, Record, Section};

/// Layers of a file.
pub(super) struct Document {
    bytes: Vec<u8>,
    /// Bytes a sample.
    sample: usize,
    is_grey: bool,
    records: Vec<Record>,
}

impl Document {
    /// Reads a file's list of layers: the pictures' width and height, and the layers.
    ///
    /// # Errors
    /// [`LayeredError`].
    pub(super) fn read(bytes: Vec<u8>) -> Result<(Self, [usize; 2], Vec<Node>), LayeredError> {
        let mut left = Bytes::new(&bytes);
        let is_psd = left.take(4).is_ok_and(|signature| signature.rest() == b"8BPS");
        if !is_psd {
            return Err(LayeredError::NoPsd);
        }
        let unread = |found: String, expected| Err(LayeredError::Unread { found, expected });
        let version = left.u16()?;
        if version != 1 {
            return unread(format!("version {version} (PSB)"), "a PSD file");
        }
        left.take(8)?;
        let [height, width] = [left.u32()? as usize, left.u32()? as usize];
        check_size([width, height]).map_err(LayeredError::TooLarge)?;
        let sample = match left.u16()? {
            8 => 1,
            16 => 2,
            other => return unread(format!("{other} bits a channel"), "8 or 16"),
        };
        let is_grey = match left.u16()? {
            3 => false,
            1 => true,
            other => {
                let names =
                    ["bitmap", "", "indexed", "", "CMYK", "", "", "multichannel", "duotone", "Lab"];
                let name = names.get(usize::from(other)).copied().unwrap_or("unknown");
                return unread(format!("colour mode {other} ({name})"), "RGB or greyscale");
            }
        };
        // Palette and resources.
        left.block()?;
        left.block()?;
        let mut section = left.block()?;
        let mut layers = if section.len() < 4 { section } else { section.block()? };
        if layers.len() == 0 && section.len() >= 4 {
            // The mask of the whole file, then blocks: layers of 16 bits are in one of them.
            section.block()?;
            layers = blocks(section, b"Lr16", 4)?.unwrap_or(layers);
        }
        let records = match layers.len() {
            0 => Vec::new(),
            _ => record::records(layers)?,
        };
        let nodes = nodes(&records)?;
        Ok((Self { sample, is_grey, records, bytes }, [width, height], nodes))
    }

    /// Decodes the picture of a layer, with its corner.
    ///
    /// # Errors
    /// The fault in words.
    pub(super) fn picture(&self, source: usize) -> Result<(Pixels, [i64; 2]), String> {
        let own = &self.records[source];
        let size = own.area.size;
        if size.contains(&0) {
            return Ok((Pixels::empty([0, 0]), own.area.corner));
        }
        check_size(size)?;
        let channel = |id: i16| match own.channel(id) {
            Some(range) => channel::decoded(&self.bytes[range.clone()], size, self.sample),
            None if id == -1 => Ok(vec![0xff; size[0] * size[1]]),
            None => Err(format!("it has no channel {id}")),
        };
        let colours = if self.is_grey { [0, 0, 0] } else { [0, 1, 2] };
        let [r, g, b] = [channel(colours[0])?, channel(colours[1])?, channel(colours[2])?];
        let alpha = channel(-1)?;
        let pixels = r.into_iter().zip(g).zip(b.into_iter().zip(alpha));
        let rgba = pixels.flat_map(|((r, g), (b, a))| [r, g, b, a]).collect();
        Ok((Pixels { size, rgba }, own.area.corner))
    }

    /// Multiplies the coverage of a whole picture with the mask of a layer or group, if it has one.
    ///
    /// # Errors
    /// The fault in words: what else it has must be a part of its pixels.
    pub(super) fn mask(&self, source: usize, canvas: &mut Pixels) -> Result<(), String> {
        let own = &self.records[source];
        if let Some(what) = own.unread {
            return Err(format!(
                "\"{}\" has {what}, expected pixels: rasterise or merge it",
                own.name
            ));
        }
        let (Some(mask), Some(range)) = (&own.mask, own.channel(-2)) else { return Ok(()) };
        let Area { corner, size } = mask.area;
        let mut found = Vec::new();
        if !size.contains(&0) {
            check_size(size)?;
            found = channel::decoded(&self.bytes[range.clone()], size, self.sample)?;
        }
        let width = canvas.size[0];
        for (at, pixel) in canvas.rgba.chunks_mut(4).enumerate() {
            let place = [(at % width) as i64 - corner[0], (at / width) as i64 - corner[1]];
            let is_inside = (0..2).all(|axis| (0..size[axis] as i64).contains(&place[axis]));
            let share = match is_inside {
                true => found[place[1] as usize * size[0] + place[0] as usize],
                false => mask.outside,
            };
            pixel[3] = product(pixel[3], share);
        }
        Ok(())
    }
}

/// Joins records, which are listed from back to front, into groups. A group begins with a record without a name.
fn nodes(records: &[Record]) -> Result<Vec<Node>, LayeredError> {
    let mut open = vec![Vec::new()];
    for (source, own) in records.iter().enumerate() {
        let members = match own.section {
            Section::Begin if open.len() > DEPTH => {
                let what = format!("groups within groups, more than {DEPTH} deep");
                return Err(LayeredError::Damaged(what));
            }
            Section::Begin => {
                open.push(Vec::new());
                continue;
            }
            Section::Layer => None,
            Section::Group => open.pop(),
        };
        let node = Node {
            name: own.name.clone(),
            source,
            opacity: own.opacity,
            blend: own.blend(),
            is_hidden: own.is_hidden,
            is_clipped: own.is_clipped,
            members,
        };
        let unpaired = || LayeredError::Damaged(format!("group \"{}\" has no beginning", own.name));
        open.last_mut().ok_or_else(unpaired)?.push(node);
    }
    match open.pop() {
        Some(nodes) if open.is_empty() => Ok(nodes),
        _ => Err(LayeredError::Damaged("a group has no end".to_owned())),
    }
}
