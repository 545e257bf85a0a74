//! The checks of an object, in the order of FORMAT.md.

use super::counts::{
    CLIP_ELEMENTS_MAX, CLIPS_MAX, FITS_MAX, NO_VERTEX, NOTHING, RULES, ViewsCounts, place,
};
use super::view::{Layer, Views};
use crate::format::content::{check_counts, check_floats, check_index, check_names, outside};
use crate::format::part::{Asked, COUNTS, first_counts};
use crate::format::refusal::{Checked, Loading};
use crate::format::{FileErrorKind as Kind, MAGNITUDE_MAX, SectionKind, saturated};
use crate::kernel::{OutputKind, OutputRow};
use crate::linear::Le;

/// Checks an object's counts, and returns the requirements for its sections.
pub(crate) fn counts(words: &[u32; COUNTS], loading: &Loading<'_>) -> Checked<Asked> {
    // Vertices are u16 with the greatest value reserved. Elements and layers are sorted as u16 too.
    let most = u32::from(u16::MAX);
    let ranges = [
        (place::POINTS, 1, most),
        (place::VERTICES, 0, most),
        (place::WEIGHTS, 0, u32::MAX / 12),
        (place::ELEMENTS, 0, most),
        (place::LAYERS, 1, most),
        (place::VIEWS, 1, most),
        (place::MAPS, 1, most),
        (place::TEXTURES, 1, most),
        (place::TEXELS, 1, u32::MAX / 4),
        (place::SIZE[0], 1, most),
        (place::SIZE[1], 1, most),
    ];
    check_counts(loading, SectionKind::ViewsCounts, words, &ranges)?;
    Ok(ViewsCounts::from_words(first_counts(words)).asked())
}

/// Checks the content of an object. The lengths of all sections have been checked before.
///
/// - `part_len`: parts of the file.
/// - `outputs`: returns the output rows of a part if the part is a kernel.
pub(crate) fn content<'a>(
    views: &Views<'_>,
    loading: &Loading<'_>,
    part_len: usize,
    outputs: impl Fn(u16) -> Option<&'a [[u8; OutputRow::BYTES]]>,
) -> Checked {
    CHECKS.iter().try_for_each(|check| check(views, loading))?;
    for (index, part) in views.maps().iter().enumerate() {
        let section = SectionKind::Maps;
        let part = u32::from_le_bytes(*part);
        let Some(rows) = u16::try_from(part).ok().and_then(&outputs) else {
            return Err(loading.refuse(Kind::Index, Some(section), index, [part_len as u32, part]));
        };
        let ViewsCounts { point_len, view_len, layer_len, .. } = views.counts();
        let numbers = u64::from(view_len) + 2 * u64::from(layer_len);
        let expected = [saturated(2 * u64::from(point_len) + numbers), rows.len() as u32];
        if expected[0] != expected[1] {
            return Err(loading.refuse(Kind::Mismatch, Some(section), index, expected));
        }
        let (places, numbers) = rows.split_at(rows.len().min(point_len as usize));
        let is_of =
            |row: &[u8; OutputRow::BYTES], kind: OutputKind| row.first() == Some(&kind.number());
        let is_sound = places.iter().all(|row| is_of(row, OutputKind::Vector3))
            && numbers.iter().all(|row| is_of(row, OutputKind::Scalar));
        if !is_sound {
            return loading.invalid(section, index);
        }
    }
    Ok(())
}

/// The checks of the content, in order. A table keeps code small, as for an envelope.
static CHECKS: [fn(&Views<'_>, &Loading<'_>) -> Checked; 9] = [
    |views, loading| check_names(loading, views.names()),
    |views, loading| check_floats(loading, &views.0, &RULES),
    check_layers,
    check_vertices,
    check_elements,
    check_neighbours,
    check_view_textures,
    check_masks,
    check_textures,
];

/// Checks that each element belongs to one layer, that no layer clips itself through any chain, and
/// that the numbers of elements and key views stay within [`FITS_MAX`].
fn check_layers(views: &Views<'_>, loading: &Loading<'_>) -> Checked {
    let section = SectionKind::Layers;
    let ViewsCounts { element_len, layer_len, .. } = views.counts();
    let mut before = 0;
    for (index, row) in views.layers().iter().enumerate() {
        let [end, clip, flags] = row.map(u32::from_le_bytes);
        if end < before || flags & !Layer::FLAGS != 0 {
            return loading.invalid(section, index);
        }
        before = end;
        if clip != NOTHING {
            check_index(loading, section, 3 * index + 1, layer_len, clip)?;
        }
    }
    if before != element_len {
        let values = [element_len, before];
        return Err(loading.refuse(Kind::Mismatch, Some(section), layer_len as usize, values));
    }
    let mut clip_len = 0;
    for index in 0..views.layer_len() {
        // A longer chain may be a circle.
        if views.chain(index).nth(CLIPS_MAX).is_some() {
            return loading.invalid(section, index);
        }
        let clips = views.clips(index).filter_map(|layer| views.layer(layer));
        clip_len += clips.map(|layer| layer.end - layer.first).sum::<usize>();
        if clip_len > CLIP_ELEMENTS_MAX {
            return loading.invalid(section, index);
        }
    }
    let (found, elements) = (views.counts().view_len, clip_len + element_len as usize);
    let most = FITS_MAX.checked_div(elements).unwrap_or(FITS_MAX) as u32;
    if found <= most {
        return Ok(());
    }
    let section = SectionKind::ViewsCounts;
    Err(loading.refuse(Kind::Limit, Some(section), place::VIEWS, [most, found]))
}

/// Checks that vertices refer to points of the object.
fn check_vertices(views: &Views<'_>, loading: &Loading<'_>) -> Checked {
    let (section, found) = (SectionKind::Vertices, views.counts().weight_len);
    let mut before = 0;
    for (index, [end, x, y]) in views.vertices().iter().enumerate() {
        let end = u32::from_le_bytes(*end);
        if end < before {
            return loading.invalid(section, index);
        }
        before = end;
        if let Some(at) = outside(&[*x, *y], [-MAGNITUDE_MAX, MAGNITUDE_MAX]) {
            return Err(loading.refuse(Kind::Float, Some(section), 3 * index + 1 + at, [0; 2]));
        }
    }
    if before != found {
        let values = [found, before];
        return Err(loading.refuse(Kind::Mismatch, Some(section), views.vertex_len(), values));
    }
    for (index, [point, ..]) in views.weights().iter().enumerate() {
        let (section, point) = (SectionKind::VertexWeights, u32::from_le_bytes(*point));
        check_index(loading, section, 3 * index, views.counts().point_len, point)?;
    }
    Ok(())
}

/// Checks that elements refer to vertices of the object, with no vertex twice in an element.
fn check_elements(views: &Views<'_>, loading: &Loading<'_>) -> Checked {
    let section = SectionKind::Elements;
    for (index, row) in views.elements().iter().enumerate() {
        let vertices = row.map(u16::from_le_bytes);
        let [a, b, c, d] = vertices;
        let len = if d == NO_VERTEX { 3 } else { 4 };
        for (corner, vertex) in vertices.iter().take(len).enumerate() {
            let (at, below) = (4 * index + corner, views.counts().vertex_len);
            check_index(loading, section, at, below, (*vertex).into())?;
        }
        if a == b || a == c || a == d || b == c || b == d || c == d {
            return loading.invalid(section, index);
        }
    }
    Ok(())
}

/// Checks that neighbours are elements of the object.
fn check_neighbours(views: &Views<'_>, loading: &Loading<'_>) -> Checked {
    let section = SectionKind::Neighbours;
    for (index, other) in views.neighbour_rows().as_flattened().iter().enumerate() {
        let other = u16::from_le_bytes(*other);
        if other != NO_VERTEX {
            check_index(loading, section, index, views.counts().element_len, other.into())?;
        }
    }
    Ok(())
}

/// Checks that the layers of key views refer to textures of the object.
fn check_view_textures(views: &Views<'_>, loading: &Loading<'_>) -> Checked {
    let below = views.counts().texture_len;
    for (index, texture) in views.view_textures().iter().enumerate() {
        let texture = u32::from_le_bytes(*texture);
        if texture != NOTHING {
            check_index(loading, SectionKind::ViewTextures, index, below, texture)?;
        }
    }
    Ok(())
}

/// Checks that the mask bits behind the last point are 0.
fn check_masks(views: &Views<'_>, loading: &Loading<'_>) -> Checked {
    let point_len = views.point_len();
    let words = point_len.div_ceil(32);
    let Some(bits) = point_len.checked_rem(32).filter(|bits| *bits > 0) else { return Ok(()) };
    let is_unsound = |le: &Le| u32::from_le_bytes(*le) >> bits != 0;
    let lasts = views.masks().chunks_exact(words.max(1)).filter_map(<[_]>::last);
    match lasts.map(is_unsound).position(|unsound| unsound) {
        None => Ok(()),
        Some(view) => loading.invalid(SectionKind::ViewMasks, view),
    }
}

/// Checks that textures are not empty, and that their texels follow each other and use the whole
/// section.
fn check_textures(views: &Views<'_>, loading: &Loading<'_>) -> Checked {
    let section = SectionKind::Textures;
    let mut end = 0;
    for (index, row) in views.textures().iter().enumerate() {
        let [width, height, start] = row.map(u32::from_le_bytes);
        let most = u32::from(u16::MAX);
        let is_sized = (1..=most).contains(&width) && (1..=most).contains(&height);
        if !is_sized {
            return loading.invalid(section, index);
        }
        if u64::from(start) != end {
            let values = [saturated(end), start];
            return Err(loading.refuse(Kind::Mismatch, Some(section), index, values));
        }
        end += u64::from(width) * u64::from(height);
    }
    let found = views.counts().texel_len;
    if end == u64::from(found) {
        return Ok(());
    }
    let values = [saturated(end), found];
    Err(loading.refuse(Kind::Mismatch, Some(SectionKind::ViewsCounts), place::TEXELS, values))
}
