//! Layers of a set as its pictures in layers have them.

use super::data::LayerView;
use super::error::SetError;
use super::image::Image;
use super::layers::WrittenLayer;
use crate::formats::layered::LayeredPicture;
use crate::formats::{FileError, LayeredError};
use std::path::Path;

/// Makes the layers of a set that names none. All its pictures must have the same layers; points are proposed.
///
/// # Errors
/// [`SetError::File`] of a picture, and [`SetError::Layer`] of a layer that some picture lacks.
pub(super) fn written(files: &[&Path]) -> Result<Vec<WrittenLayer>, SetError> {
    let mut first: Option<(&Path, LayeredPicture)> = None;
    for file in files {
        let own = LayeredPicture::open(file)?;
        let Some((other, known)) = &first else {
            first = Some((file, own));
            continue;
        };
        let paths = |picture: &LayeredPicture| -> Vec<String> {
            picture.layers.iter().map(|layer| layer.path.clone()).collect()
        };
        let (known, own) = (paths(known), paths(&own));
        let [other, file] = [*other, *file].map(|file| file.display().to_string());
        for (has, lacks, has_name, lacks_name) in
            [(&known, &own, &other, &file), (&own, &known, &file, &other)]
        {
            if let Some(layer) = has.iter().find(|layer| !lacks.contains(layer)) {
                let what = format!(
                    "it is in {has_name}, and not in {lacks_name}: add it there, empty if it is not seen"
                );
                return Err(SetError::Layer { layer: layer.clone(), what });
            }
        }
        if let Some(at) = (0..own.len()).find(|&at| own[at] != known[at]) {
            let what = format!("it has another place in {file} than in {other}: order them alike");
            return Err(SetError::Layer { layer: own[at].clone(), what });
        }
    }
    let Some((_, picture)) = first else { return Ok(Vec::new()) };
    let layers = &picture.layers;
    let name = |at: usize| {
        let is_only = layers.iter().filter(|other| other.name == layers[at].name).count() == 1;
        if is_only { layers[at].name.clone() } else { layers[at].path.clone() }
    };
    Ok((0..layers.len()).map(|at| WrittenLayer::proposed(name(at))).collect())
}

/// Adds the layers of a view's picture, unless the view itself has a picture of them.
///
/// # Errors
/// [`SetError::File`].
pub(super) fn add(file: &Path, names: &[&str], views: &mut [LayerView]) -> Result<(), SetError> {
    let picture = LayeredPicture::open(file)?;
    for (name, own) in names.iter().zip(views) {
        if own.image.is_some() {
            continue;
        }
        let found = picture.find(name).map_err(|error| named(file, error))?;
        let layer = Some((*name).to_owned());
        own.image = Some(Image { layer, ..Image::of_file(file.to_owned()) });
        let opacity = picture.layers[found].opacity;
        if own.opacity.is_none() && opacity < 1.0 {
            own.opacity = Some(opacity);
        }
    }
    Ok(())
}

/// Clips layers as the first picture does, unless the set says so itself.
///
/// # Errors
/// [`SetError::File`], and [`SetError::Layer`]: the set does not name the layer that another is clipped to.
pub(super) fn clip(file: &Path, layers: &mut [WrittenLayer]) -> Result<(), SetError> {
    let picture = LayeredPicture::open(file)?;
    // A layer that is not in the file has pictures of its own, or is reported with its view.
    let places: Vec<Option<usize>> =
        layers.iter().map(|own| picture.find(&own.name).ok()).collect();
    let names: Vec<String> = layers.iter().map(|own| own.name.clone()).collect();
    for (own, &place) in layers.iter_mut().zip(&places) {
        let base = place.and_then(|place| picture.layers[place].clip);
        let (None, Some(base)) = (&own.clip, base) else { continue };
        let found = places.iter().position(|other| *other == Some(base));
        let unknown = || {
            let base = &picture.layers[base].path;
            let what = format!("{} clips it to \"{base}\", no layer of the set", file.display());
            SetError::Layer { layer: own.name.clone(), what }
        };
        own.clip = Some(names[found.ok_or_else(unknown)?].clone());
    }
    Ok(())
}

fn named(file: &Path, error: LayeredError) -> SetError {
    FileError { file: file.to_owned(), error: error.into() }.into()
}
