//! Photoshop files: layers, groups and masks (Adobe, "Photoshop File Formats Specification").
//!
//! The existing crates for this format panic on damaged files. None of them reads masks, deflated channels and 16 bits.

mod bytes;

use super::tree::{DEPTH, Node, damaged, too_large};
use crate::Error;
use crate::formats::pixels::{Pixels, check_size, product};
use bytes::{Bytes, blocks};
use std::ops::Range;

/// Names and keys of blocks that change the look of a layer and are not supported.
const UNREAD: [(&str, &[&[u8; 4]]); 4] = [
    ("a layer style", &[b"lfx2", b"lmfx", b"lrFX"]),
    ("a vector mask", &[b"vmsk", b"vsms"]),
    ("a fill", &[b"SoCo", b"GdFl", b"PtFl"]),
    (
        "an adjustment",
        &[
            b"levl", b"curv", b"hue2", b"hue ", b"brit", b"blnc", b"selc", b"thrs", b"nvrt",
            b"post", b"grdm", b"phfl", b"mixr", b"expA", b"vibA", b"clrL", b"blwh",
        ],
    ),
];

/// A Photoshop file, with the records of its layers.
pub(super) struct Document {
    bytes: Vec<u8>,
    /// Bytes a sample.
    sample: usize,
    is_grey: bool,
    records: Vec<Record>,
}

impl Document {
    /// Reads a file's layers, and the width and height of its picture.
    ///
    /// # Errors
    /// The file is not a Photoshop file, is damaged or too large, or has another depth or colour mode.
    pub(super) fn read(bytes: Vec<u8>) -> Result<(Self, [usize; 2], Vec<Node>), Error> {
        let mut left = Bytes::new(&bytes);
        let is_psd = left.take(4).is_ok_and(|signature| signature.left == b"8BPS");
        if !is_psd {
            return Err(Error::damaged("expected a Photoshop file, which begins with 8BPS"));
        }
        let unread = |found: String, expected: &str| {
            Err(Error::unsupported(format!(
                "has {found}, expected {expected}: convert it and save it again"
            )))
        };
        let version = left.u16()?;
        if version != 1 {
            return unread(format!("version {version} (PSB)"), "a PSD file");
        }
        left.take(8)?;
        let [height, width] = [left.u32()? as usize, left.u32()? as usize];
        check_size([width, height]).map_err(too_large)?;
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
            // The mask of the whole file, then blocks. One of the blocks holds layers of 16 bits.
            section.block()?;
            layers = blocks(section, b"Lr16", 4)?.unwrap_or(layers);
        }
        let (records, nodes) = match layers.len() {
            0 => Default::default(),
            _ => records(layers)?,
        };
        Ok((Self { sample, is_grey, records, bytes }, [width, height], nodes))
    }

    /// Decodes the picture of a layer; also returns the position of its upper left corner.
    ///
    /// # Errors
    /// The fault, in words.
    pub(super) fn picture(&self, source: usize) -> Result<(Pixels, [i64; 2]), String> {
        let own = &self.records[source];
        let size = own.area.size;
        if size.contains(&0) {
            return Ok((Pixels::empty([0, 0]), own.area.corner));
        }
        check_size(size)?;
        let channel = |id: i16| match own.channel(id) {
            Some(range) => bytes::decode(&self.bytes[range.clone()], size, self.sample),
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

    /// Multiplies the coverage of a whole picture with the mask of a layer or group, if there is a mask.
    ///
    /// # Errors
    /// The fault, in words: the layer has an effect that is not part of its pixels.
    pub(super) fn mask(&self, source: usize, canvas: &mut Pixels) -> Result<(), String> {
        let own = &self.records[source];
        if let Some(unread) = &own.unread {
            return Err(unread.clone());
        }
        let (Some((area, outside)), Some(range)) = (&own.mask, own.channel(-2)) else {
            return Ok(());
        };
        let &Area { corner, size } = area;
        let mut found = Vec::new();
        if !size.contains(&0) {
            check_size(size)?;
            found = bytes::decode(&self.bytes[range.clone()], size, self.sample)?;
        }
        let width = canvas.size[0];
        for (at, pixel) in canvas.rgba.chunks_mut(4).enumerate() {
            let place = [(at % width) as i64 - corner[0], (at / width) as i64 - corner[1]];
            let is_inside = (0..2).all(|axis| (0..size[axis] as i64).contains(&place[axis]));
            let share = match is_inside {
                true => found[place[1] as usize * size[0] + place[0] as usize],
                false => *outside,
            };
            pixel[3] = product(pixel[3], share);
        }
        Ok(())
    }
}

/// Joins nodes into a tree of groups. Nodes go from back to front; a group begins with a node without a name.
fn tree(nodes: Vec<(Section, Node)>) -> Result<Vec<Node>, Error> {
    let mut open = vec![Vec::new()];
    for (section, node) in nodes {
        let members = match section {
            Section::Begin if open.len() > DEPTH => {
                return Err(damaged(format!("groups within groups, more than {DEPTH} deep")));
            }
            Section::Begin => {
                open.push(Vec::new());
                continue;
            }
            Section::Layer => None,
            Section::Group => open.pop(),
        };
        let unpaired = || damaged(format!("group \"{}\" has no beginning", node.name));
        open.last_mut().ok_or_else(unpaired)?.push(Node { members, ..node });
    }
    match open.pop() {
        Some(nodes) if open.is_empty() => Ok(nodes),
        _ => Err(damaged("a group has no end")),
    }
}

/// A layer, the end of a group, or the beginning of a group.
struct Record {
    area: Area,
    /// Rectangle of the mask, and its value outside the rectangle.
    mask: Option<(Area, u8)>,
    /// The fault of an unsupported block that changes the look, in words.
    unread: Option<String>,
    /// Channels and the range of their bytes in the file: 0 to 2 are colours, -1 is alpha, -2 the mask.
    channels: Vec<(i16, Range<usize>)>,
}

/// The role of a record; records go from back to front.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Section {
    Layer,
    /// Beginning of a group, below its members.
    Begin,
    /// End of a group, above its members, with the group's name.
    Group,
}

/// A rectangle of the picture.
struct Area {
    /// x and y.
    corner: [i64; 2],
    /// Width and height.
    size: [usize; 2],
}

impl Record {
    /// Returns the range of a channel's bytes in the file.
    fn channel(&self, id: i16) -> Option<&Range<usize>> {
        self.channels.iter().find(|(own, _)| *own == id).map(|(_, range)| range)
    }
}

/// Reads the records of all layers, the hindmost first, and their tree.
///
/// # Errors
/// The records are cut off, or groups do not begin or end.
fn records(mut left: Bytes<'_>) -> Result<(Vec<Record>, Vec<Node>), Error> {
    // The sign only tells whether the flattened picture has transparency.
    let len = usize::from(left.i16()?.unsigned_abs());
    let all = (0..len).map(|source| record(&mut left, source)).collect::<Result<Vec<_>, _>>()?;
    let (mut out, nodes): (Vec<Record>, Vec<_>) = all.into_iter().unzip();
    for (_, range) in out.iter_mut().flat_map(|own| &mut own.channels) {
        let data = left.take(range.len())?;
        *range = data.start..data.start + data.len();
    }
    Ok((out, tree(nodes)?))
}

fn area(left: &mut Bytes<'_>) -> Result<Area, Error> {
    let [top, west, bottom, east] =
        [left.i32()?, left.i32()?, left.i32()?, left.i32()?].map(i64::from);
    let side = |low: i64, high: i64| usize::try_from(high - low).unwrap_or(0);
    Ok(Area { corner: [west, top], size: [side(west, east), side(top, bottom)] })
}

/// Reads a record; `source` is its index.
fn record(left: &mut Bytes<'_>, source: usize) -> Result<(Record, (Section, Node)), Error> {
    let area = area(left)?;
    let channel_len = left.u16()?;
    let channel = |_| Ok((left.i16()?, 0..left.u32()? as usize));
    let channels = (0..channel_len).map(channel).collect::<Result<_, Error>>()?;
    left.take(4)?;
    let mode: [u8; 4] = left.array()?;
    let [opacity, clipping, flags, _]: [u8; 4] = left.array()?;
    let mut extra = left.block()?;
    let mask = mask(extra.block()?)?;
    extra.block()?;
    let name_len = extra.u8()?;
    let name = extra.take(name_len.into())?.left;
    let padded = (usize::from(name_len) + 1).next_multiple_of(4) - 1 - usize::from(name_len);
    extra.take(padded.min(extra.len()))?;
    let name = match blocks(extra, b"luni", 1)? {
        Some(mut text) => unicode(&mut text)?,
        None => String::from_utf8_lossy(name).into_owned(),
    };
    // Opacity of the pixels, without effects.
    let fill = match blocks(extra, b"iOpa", 1)? {
        Some(mut fill) => fill.u8()?,
        None => 0xff,
    };
    let divider = match blocks(extra, b"lsct", 1)? {
        Some(divider) => Some(divider),
        None => blocks(extra, b"lsdk", 1)?,
    };
    let section = match divider.map(|mut divider| divider.u32()).transpose()? {
        Some(1 | 2) => Section::Group,
        Some(3) => Section::Begin,
        _ => Section::Layer,
    };
    let mut unread = None;
    for (what, keys) in UNREAD {
        for key in keys {
            if blocks(extra, key, 1)?.is_some() {
                let fault =
                    format!("\"{name}\" has {what}, expected pixels: rasterise or merge it");
                unread = Some(fault);
            }
        }
    }
    let is_normal = mode == *b"norm" || section == Section::Group && mode == *b"pass";
    let node = Node {
        name,
        source,
        opacity: f64::from(opacity) / 255.0 * (f64::from(fill) / 255.0),
        blend: (!is_normal).then(|| mode.escape_ascii().to_string().trim().to_owned()),
        is_hidden: flags & 2 != 0,
        is_clipped: clipping != 0,
        members: None,
    };
    Ok((Record { area, mask, unread, channels }, (section, node)))
}

/// Reads a mask; `None` if there is none, or the mask is disabled.
fn mask(mut left: Bytes<'_>) -> Result<Option<(Area, u8)>, Error> {
    if left.len() == 0 {
        return Ok(None);
    }
    let area = area(&mut left)?;
    let [outside, flags]: [u8; 2] = left.array()?;
    Ok((flags & 2 == 0).then_some((area, outside)))
}

fn unicode(text: &mut Bytes<'_>) -> Result<String, Error> {
    let len = text.u32()? as usize;
    let units = text.take(len.saturating_mul(2))?;
    let units = units.left.as_chunks::<2>().0.iter().map(|unit| u16::from_be_bytes(*unit));
    let units: Vec<u16> = units.collect();
    Ok(String::from_utf16_lossy(&units).trim_end_matches('\0').to_owned())
}
