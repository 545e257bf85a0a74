//! A model as parts of a file: its maps, kernels, and the object, as FORMAT.md has them.

use super::model::{KeyView, MARGIN, ViewsModel};
use super::set::Element;
use crate::bake::sections::{floats, names, narrow, words};
use crate::bake::{BakeError, Part, Sections};
use crate::kernel;
use sinew_runtime::format::{Element as Number, PartKind, SectionKind};
use sinew_runtime::views::{NO_POINT, ViewsCounts};

/// Bits of a word of a mask.
const BITS: usize = 32;

/// Writes a model: its maps first, then the object.
///
/// # Errors
/// [`BakeError::Size`] of a count that does not fit the file.
pub fn parts(model: &ViewsModel) -> Result<Vec<Part>, BakeError> {
    let maps = model.maps.iter().map(kernel::bake::part);
    let mut out = maps.collect::<Result<Vec<_>, _>>()?;
    out.push(object(model)?);
    Ok(out)
}

fn object(model: &ViewsModel) -> Result<Part, BakeError> {
    let texels = model.keys.iter().map(|key| key.picture.rgba.len() / 4);
    let counts = ViewsCounts {
        point_len: narrow("points", model.point_len)?,
        element_len: narrow("elements", model.elements.len())?,
        view_len: narrow("key views", model.keys.len())?,
        map_len: narrow("maps", model.maps.len())?,
        texture_len: narrow("textures", model.keys.len())?,
        texel_len: narrow("texels", texels.clone().sum())?,
    };
    let numbers =
        |len: usize| (0..len).map(|n| narrow("key views", n)).collect::<Result<Vec<u32>, _>>();
    let mut textures = Vec::new();
    let mut start = 0;
    for (key, texels) in model.keys.iter().zip(texels) {
        let size = key.picture.size;
        for (what, number) in [
            ("a texture's width", size.width),
            ("a texture's height", size.height),
            ("texels", start),
        ] {
            textures.push(narrow(what, number)?);
        }
        start += texels;
    }
    let named = std::iter::once(&model.name).chain(model.keys.iter().map(|key| &key.name));
    let points = |key: &KeyView| floats(key.points.as_flattened());
    let mut sections: Sections = vec![
        (SectionKind::ViewsCounts, true, words(&counts.words())),
        (SectionKind::Names, true, names(named)?),
        (SectionKind::Maps, true, words(&numbers(model.maps.len())?)),
        (SectionKind::Elements, true, elements(&model.elements)?),
        (SectionKind::ViewTextures, true, words(&numbers(model.keys.len())?)),
        (SectionKind::References, true, model.keys.iter().flat_map(points).collect()),
        (SectionKind::ViewMasks, true, words(&masks(&model.keys))),
        (SectionKind::Textures, true, words(&textures)),
        (
            SectionKind::Texels,
            true,
            model.keys.iter().flat_map(|key| key.picture.rgba.clone()).collect(),
        ),
    ];
    let references: Option<Vec<_>> = model.keys.iter().map(|key| key.reference.as_ref()).collect();
    if let Some(references) = references.filter(|all| !all.is_empty()) {
        let own = references.iter().flat_map(|reference| {
            let pairs = reference.prototype.iter().zip(&reference.instance);
            let offset = |(own, other): (&[f64; 2], &[f64; 2])| {
                [0, 1].map(|axis| other[axis] - reference.scale * own[axis])
            };
            let offsets: Vec<[f64; 2]> = pairs.map(offset).collect();
            floats(&[&[reference.scale], offsets.as_flattened()].concat())
        });
        sections.push((SectionKind::Deformations, true, own.collect()));
    }
    let fit = [MARGIN, model.fit.rms, model.fit.left_out, model.fit.visibility];
    sections.push((SectionKind::ViewsFit, true, floats(&fit)));
    Ok(Part { kind: PartKind::Views, sections, element: Number::F32 })
}

fn elements(elements: &[Element]) -> Result<Vec<u8>, BakeError> {
    let mut out = Vec::new();
    for element in elements {
        for corner in 0..4 {
            let point = match element.points().get(corner) {
                Some(&point) => narrow("points", point)?,
                None => NO_POINT,
            };
            out.extend(point.to_le_bytes());
        }
    }
    Ok(out)
}

/// Writes a bit a point and key view, those of each view in words of its own.
fn masks(keys: &[KeyView]) -> Vec<u32> {
    let word = |seen: &[bool]| {
        seen.iter().enumerate().fold(0, |word, (bit, seen)| word | u32::from(*seen) << bit)
    };
    keys.iter().flat_map(|key| key.visible.chunks(BITS).map(word)).collect()
}
