//! Records of layers.

use super::super::error::LayeredError;
use super::bytes::{Bytes, blocks};
use std::ops::Range;

/// Names of blocks that change the look of a layer, and their keys.
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

/// A layer, the end of a group, or its beginning.
pub(super) struct Record {
    pub(super) name: String,
    pub(super) area: Area,
    pub(super) mask: Option<Mask>,
    /// From 0 to 1.
    pub(super) opacity: f64,
    pub(super) is_hidden: bool,
    pub(super) is_clipped: bool,
    pub(super) section: Section,
    /// The name of a block that changes its look and is not read.
    pub(super) unread: Option<&'static str>,
    mode: [u8; 4],
    /// Channels and where their bytes are in the file: 0 to 2 colours, -1 alpha, -2 the mask.
    channels: Vec<(i16, Range<usize>)>,
}

/// The role of a record. Records are listed from back to front.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Section {
    Layer,
    /// Below the members of a group.
    Begin,
    /// Above the members of a group, with its name.
    Group,
}

/// A rectangle of the picture.
pub(super) struct Area {
    /// x and y.
    pub(super) corner: [i64; 2],
    /// Width and height.
    pub(super) size: [usize; 2],
}

pub(super) struct Mask {
    pub(super) area: Area,
    /// The mask beyond its rectangle.
    pub(super) outside: u8,
}

impl Record {
    /// Returns where the bytes of a channel are.
    pub(super) fn channel(&self, id: i16) -> Option<&Range<usize>> {
        self.channels.iter().find(|(own, _)| *own == id).map(|(_, range)| range)
    }

    /// Returns the blend mode, unless it is normal.
    pub(super) fn blend(&self) -> Option<String> {
        let is_normal = match self.section {
            Section::Group => matches!(&self.mode, b"pass" | b"norm"),
            _ => self.mode == *b"norm",
        };
        (!is_normal).then(|| self.mode.escape_ascii().to_string().trim().to_owned())
    }
}

/// Reads the records of all layers, the hindmost first.
///
/// # Errors
/// [`LayeredError::Damaged`].
pub(super) fn records(mut left: Bytes<'_>) -> Result<Vec<Record>, LayeredError> {
    // A negative number says that the flattened picture is transparent.
    let len = left.i16()?.unsigned_abs();
    let mut out = (0..len).map(|_| record(&mut left)).collect::<Result<Vec<_>, _>>()?;
    for (_, range) in out.iter_mut().flat_map(|own| &mut own.channels) {
        let data = left.take(range.len())?;
        *range = data.at()..data.at() + data.len();
    }
    Ok(out)
}

fn area(left: &mut Bytes<'_>) -> Result<Area, LayeredError> {
    let [top, west, bottom, east] =
        [left.i32()?, left.i32()?, left.i32()?, left.i32()?].map(i64::from);
    let side = |low: i64, high: i64| usize::try_from(high - low).unwrap_or(0);
    Ok(Area { corner: [west, top], size: [side(west, east), side(top, bottom)] })
}

fn record(left: &mut Bytes<'_>) -> Result<Record, LayeredError> {
    let area = area(left)?;
    let channel_len = left.u16()?;
    let channel = |_| Ok((left.i16()?, 0..left.u32()? as usize));
    let channels = (0..channel_len).map(channel).collect::<Result<_, LayeredError>>()?;
    left.take(4)?;
    let mode: [u8; 4] = left.array()?;
    let [opacity, clipping, flags, _]: [u8; 4] = left.array()?;
    let mut extra = left.block()?;
    let mask = mask(extra.block()?)?;
    extra.block()?;
    let name_len = extra.u8()?;
    let name = extra.take(name_len.into())?.rest();
    let padded = (usize::from(name_len) + 1).next_multiple_of(4) - 1 - usize::from(name_len);
    extra.take(padded.min(extra.len()))?;
    let name = match blocks(extra, b"luni", 1)? {
        Some(mut text) => unicode(&mut text)?,
        None => String::from_utf8_lossy(name).into_owned(),
    };
    // How opaque the pixels are, apart from effects.
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
                unread = Some(what);
            }
        }
    }
    Ok(Record {
        name,
        area,
        mask,
        opacity: f64::from(opacity) / 255.0 * (f64::from(fill) / 255.0),
        is_hidden: flags & 2 != 0,
        is_clipped: clipping != 0,
        section,
        unread,
        mode,
        channels,
    })
}

/// Reads a mask; none if there is none, or it is switched off.
fn mask(mut left: Bytes<'_>) -> Result<Option<Mask>, LayeredError> {
    if left.len() == 0 {
        return Ok(None);
    }
    let area = area(&mut left)?;
    let [outside, flags]: [u8; 2] = left.array()?;
    Ok((flags & 2 == 0).then_some(Mask { area, outside }))
}

fn unicode(text: &mut Bytes<'_>) -> Result<String, LayeredError> {
    let len = text.u32()? as usize;
    let units = text.take(len.saturating_mul(2))?;
    let units = units.rest().as_chunks::<2>().0.iter().map(|unit| u16::from_be_bytes(*unit));
    let units: Vec<u16> = units.collect();
    Ok(String::from_utf16_lossy(&units).trim_end_matches('\0').to_owned())
}
