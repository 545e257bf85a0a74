//! Layers of a set as its pictures in layers have them.

use super::data::LayerView;
use super::error::SetError;
use super::image::Image;
use super::layers::WrittenLayer;
use crate::formats::layered::{LayeredPicture, PaintedLayer};
use crate::formats::{FileError, LayeredError};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Makes the layers of a set that names none. All its pictures must have the same layers, in any order;
/// points are proposed. A layer that is drawn in none of them is left out.
///
/// # Errors
/// [`SetError::File`] of a picture, and [`SetError::Layer`] of a layer that some picture lacks.
pub(super) fn written(files: &[&Path]) -> Result<Vec<WrittenLayer>, SetError> {
    let open = |file: &&Path| Ok((file.display().to_string(), LayeredPicture::open(file)?.layers));
    let pictures = files.iter().map(open).collect::<Result<Vec<_>, SetError>>()?;
    let Some(((first, layers), others)) = pictures.split_first() else { return Ok(Vec::new()) };
    for (other, second) in others {
        for (own, other, has, lacks) in
            [(first, other, layers, second), (other, first, second, layers)]
        {
            let is_lacking = |layer: &&PaintedLayer| lacks.iter().all(|own| own.path != layer.path);
            if let Some(layer) = has.iter().find(is_lacking) {
                let what = format!(
                    "it is in {own}, and not in {other}: add it there, empty if it is not seen"
                );
                return Err(SetError::Layer { layer: layer.path.clone(), what });
            }
        }
    }
    let is_drawn = |at: &usize| {
        pictures.iter().any(|(_, own)| {
            own.iter().any(|layer| layer.path == layers[*at].path && layer.is_shown(own))
        })
    };
    let name = |at: usize| {
        let is_only = layers.iter().filter(|other| other.name == layers[at].name).count() == 1;
        if is_only { layers[at].name.clone() } else { layers[at].path.clone() }
    };
    let drawn = (0..layers.len()).filter(is_drawn);
    Ok(drawn.map(|at| WrittenLayer::proposed(name(at))).collect())
}

/// Adds the layers of a view's picture, unless the view itself has a picture of them, with their opacities, and their
/// order if that is not the set's.
///
/// # Errors
/// [`SetError::File`], and [`SetError::Layer`] of a layer that the picture shows and the set does not have.
pub(super) fn add(file: &Path, names: &[&str], views: &mut [LayerView]) -> Result<(), SetError> {
    let (picture, places) = add_pictures(file, names, views)?;
    let known: BTreeSet<usize> = names.iter().filter_map(|name| picture.find(name).ok()).collect();
    let is_new = |at: &usize| !known.contains(at) && picture.layers[*at].is_shown(&picture.layers);
    if let Some(at) = (0..picture.layers.len()).find(is_new) {
        let file = file.display();
        let what =
            format!("{file} shows it, and the set has no such layer: name it, or hide it there");
        return Err(SetError::Layer { layer: picture.layers[at].path.clone(), what });
    }
    let numbers = (0..names.len()).filter(|&layer| places[layer].is_some());
    let mut sorted: Vec<usize> = places.iter().copied().flatten().collect();
    let is_reordered = !sorted.is_sorted();
    sorted.sort_unstable();
    // The number of the layer that is at each place of the set's order.
    let numbers: BTreeMap<usize, usize> = sorted.into_iter().zip(numbers).collect();
    for (view, place) in views.iter_mut().zip(&places) {
        let Some(place) = place else { continue };
        let opacity = picture.layers[*place].opacity;
        if opacity < 1.0 {
            view.opacity.get_or_insert(opacity);
        }
        if is_reordered {
            view.order.get_or_insert(numbers[place] as f64);
        }
    }
    Ok(())
}

/// Adds the pictures of a view's layers, unless the view itself has a picture of them, and lists which layer of the file
/// each is.
///
/// # Errors
/// [`SetError::File`].
pub(super) fn add_pictures(
    file: &Path,
    names: &[&str],
    views: &mut [LayerView],
) -> Result<(LayeredPicture, Vec<Option<usize>>), SetError> {
    let picture = LayeredPicture::open(file)?;
    let mut places = vec![None; views.len()];
    for ((name, view), place) in names.iter().zip(views).zip(&mut places) {
        if view.image.as_ref().is_none_or(|image| image.file == file) {
            *place = Some(picture.find(name).map_err(|error| named(file, error))?);
            view.image = Some(Image::of_layer(file.to_owned(), name));
        }
    }
    Ok((picture, places))
}

/// Clips layers as the pictures do, unless the set says so itself.
///
/// # Errors
/// [`SetError::File`], and [`SetError::Layer`]: the set does not name the layer that another is clipped to, or two
/// pictures clip one differently.
pub(super) fn clip(files: &[&Path], layers: &mut [WrittenLayer]) -> Result<(), SetError> {
    let names: Vec<String> = layers.iter().map(|own| own.name.clone()).collect();
    // Of each layer the first file that has it, and the layer that it is clipped to there.
    let mut known: Vec<Option<(&Path, Option<String>)>> = vec![None; layers.len()];
    for file in files {
        let picture = LayeredPicture::open(file)?;
        // A layer that is not in the file has its own pictures, or is reported with its view.
        let places: Vec<Option<usize>> = names.iter().map(|name| picture.find(name).ok()).collect();
        for (layer, known) in known.iter_mut().enumerate() {
            let Some(place) = places[layer].filter(|_| layers[layer].clip.is_none()) else {
                continue;
            };
            let wrong = |what: String| SetError::Layer { layer: names[layer].clone(), what };
            let base = match picture.layers[place].clip {
                None => None,
                Some(clip) => {
                    let found = places.iter().position(|other| *other == Some(clip));
                    let unknown = || {
                        let base = &picture.layers[clip].path;
                        wrong(format!(
                            "{} clips it to \"{base}\", no layer of the set",
                            file.display()
                        ))
                    };
                    Some(names[found.ok_or_else(unknown)?].clone())
                }
            };
            let (first, expected) = known.get_or_insert_with(|| (file, base.clone()));
            if base != *expected {
                let said = |file: &Path, base: &Option<String>| match base {
                    Some(base) => format!("{} clips it to \"{base}\"", file.display()),
                    None => format!("{} does not clip it", file.display()),
                };
                let (first, second) = (said(first, expected), said(file, &base));
                return Err(wrong(format!(
                    "{first}, {second}: clip it alike, or write its \"clip\""
                )));
            }
        }
    }
    for (own, known) in layers.iter_mut().zip(known) {
        own.clip = own.clip.take().or_else(|| known?.1);
    }
    Ok(())
}

fn named(file: &Path, error: LayeredError) -> SetError {
    FileError { file: file.to_owned(), error: error.into() }.into()
}
