//! Layers of a set, as JSON and as pictures in layers define them.

use super::data::{Element, Image, Layer, LayerView, ViewSet, elements_of};
use super::elements::check_elements;
use crate::Error;
use crate::formats::layered::{LayeredPicture, PaintedLayer};
use serde::Deserialize;
use sinew_runtime::views::CLIPS_MAX;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// A layer of a set in JSON.
#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct WrittenLayer {
    pub(super) name: String,
    points: Option<WrittenPoints>,
    #[serde(default)]
    elements: Vec<Vec<usize>>,
    pub(super) clip: Option<String>,
}

/// Points of a layer: their indices, or the word for proposed points.
#[derive(Deserialize)]
#[serde(untagged, expecting = "expected \"auto\" or a list of numbers of points")]
enum WrittenPoints {
    Auto(Auto),
    Given(Vec<usize>),
}

/// The word for proposed points.
#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Auto {
    Auto,
}

impl WrittenLayer {
    /// Whether the points are proposed.
    pub(super) fn is_proposed(&self) -> bool {
        matches!(self.points, Some(WrittenPoints::Auto(_)))
    }

    /// Marks the points as proposed, unless they are given.
    pub(super) fn propose(&mut self) {
        self.points.get_or_insert(WrittenPoints::Auto(Auto::Auto));
    }
}

/// A layer of a view in JSON: a picture, and optionally opacity and order.
#[derive(Deserialize)]
#[serde(
    untagged,
    expecting = "layers of a view: expected the name of a picture, or \"image\", \"opacity\" and \"order\""
)]
pub(super) enum WrittenLayerView {
    Picture(String),
    Whole(WholeLayerView),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct WholeLayerView {
    image: Option<String>,
    opacity: Option<f64>,
    order: Option<f64>,
}

/// Adds the name of a layer to an error.
pub(super) fn in_layer(layer: &str, error: Error) -> Error {
    error.within(format_args!("layer \"{layer}\""))
}

/// Makes the error of a layer that no view shows.
pub(super) fn never_shown(layer: &str) -> Error {
    in_layer(layer, Error::missing("no view has a picture of it: name one, or leave it out"))
}

/// Reads the layers of a view.
///
/// - `names`: names of the set's layers.
/// - `named`: name of the view in errors.
///
/// # Errors
/// [`ErrorKind::Value`](crate::ErrorKind::Value): no layer has a name, or an opacity is outside 0 to 1.
pub(super) fn layer_views(
    written: BTreeMap<String, WrittenLayerView>,
    names: &[&str],
    folder: &Path,
    named: &str,
) -> Result<Vec<LayerView>, Error> {
    if let Some(unknown) = written.keys().find(|name| !names.contains(&name.as_str())) {
        let what = format!("{named} has a picture of it, and the set no such layer");
        return Err(in_layer(unknown, Error::value(what)));
    }
    let mut written = written;
    let own = |name: &&str| {
        let (file, opacity, order) = match written.remove(*name) {
            None => (None, None, None),
            Some(WrittenLayerView::Picture(file)) => (Some(file), None, None),
            Some(WrittenLayerView::Whole(own)) => (own.image, own.opacity, own.order),
        };
        if let Some(opacity) = opacity.filter(|opacity| !(0.0..=1.0).contains(opacity)) {
            let what = format!("{named} gives it the opacity {opacity}, expected 0 to 1");
            return Err(in_layer(name, Error::value(what)));
        }
        let image = file.map(|file| Image::of_layer(folder.join(file), name));
        Ok(LayerView { image, opacity, order })
    };
    names.iter().map(own).collect()
}

/// Makes the layers of a set whose views are read. Also lists the layers without points, whose points are to be
/// proposed.
///
/// # Errors
/// A layer is invalid, or has no points or no picture; a point is in no layer; the errors of elements.
pub(super) fn layered(
    set: &ViewSet,
    written: Vec<WrittenLayer>,
) -> Result<(Vec<Layer>, Vec<usize>), Error> {
    let names: Vec<String> = written.iter().map(|layer| layer.name.clone()).collect();
    let twice = (1..names.len()).find(|&at| names[..at].contains(&names[at]));
    if let Some(at) = twice {
        return Err(in_layer(&names[at], Error::value("two layers have this name")));
    }
    let (mut out, mut auto) = (Vec::new(), Vec::new());
    for WrittenLayer { name, points, elements, clip } in written {
        let number = |other: String| {
            let what = format!("it is clipped by \"{other}\", no layer");
            let found = names.iter().position(|name| *name == other);
            found.ok_or_else(|| in_layer(&name, Error::value(what)))
        };
        let clip = clip.map(number).transpose()?;
        let points = match points {
            Some(WrittenPoints::Auto(Auto::Auto)) if elements.is_empty() => {
                auto.push(out.len());
                Vec::new()
            }
            Some(WrittenPoints::Auto(Auto::Auto)) => {
                let error = Error::missing("it has elements, but no points yet");
                return Err(in_layer(&name, error));
            }
            Some(WrittenPoints::Given(points)) if !points.is_empty() => points,
            _ => return Err(in_layer(&name, Error::missing("it has no points"))),
        };
        let elements = checked_elements(set, &elements)?;
        out.push(Layer { name, points, elements, clip });
    }
    check_points(set, &out)?;
    check_clips(&out)?;
    check_pictures(set, &out)?;
    Ok((out, auto))
}

/// Makes elements of polygons, and checks the elements in every key view.
///
/// # Errors
/// The errors of [`elements_of`] and [`check_elements`].
pub(super) fn checked_elements(
    set: &ViewSet,
    polygons: &[Vec<usize>],
) -> Result<Vec<Element>, Error> {
    let (mut out, mut sources) = (Vec::new(), Vec::new());
    for (number, polygon) in polygons.iter().enumerate() {
        out.extend(elements_of(number, polygon, set.point_len())?);
        sources.resize(out.len(), number);
    }
    for key in set.key_views() {
        check_elements(&out, &sources, set.view(key), &set.view_name(key))?;
    }
    Ok(out)
}

/// Checks that each point is in one layer, and that elements use points of their own layer.
fn check_points(set: &ViewSet, layers: &[Layer]) -> Result<(), Error> {
    let mut owner: Vec<Option<&Layer>> = vec![None; set.point_len()];
    for layer in layers {
        let wrong = |what: String| in_layer(&layer.name, Error::value(what));
        for &point in &layer.points {
            let len = owner.len();
            let own = owner.get_mut(point);
            let own = own.ok_or_else(|| wrong(format!("point {point}, of {len}")))?;
            if let Some(other) = own.replace(layer) {
                let what = format!("point {point} is in \"{}\", too", other.name);
                return Err(wrong(what));
            }
        }
        let mut corners = layer.elements.iter().flat_map(Element::vertices);
        if let Some(point) = corners.find(|point| !layer.points.contains(point)) {
            return Err(wrong(format!("an element has point {point}, which is not its own")));
        }
    }
    match owner.iter().position(Option::is_none) {
        None => Ok(()),
        Some(point) => Err(Error::missing(format!("point {point} is in no layer"))),
    }
}

/// Checks that no layer clips itself, directly or through others, and that chains of clips are short enough.
fn check_clips(layers: &[Layer]) -> Result<(), Error> {
    for (number, layer) in layers.iter().enumerate() {
        let (mut at, mut way) = (layer.clip, vec![layer.name.as_str()]);
        while let Some(clip) = at {
            way.push(&layers[clip].name);
            if clip == number || way.len() > layers.len() {
                let what = format!("it is clipped by itself: {}", way.join(" by "));
                return Err(in_layer(&layer.name, Error::value(what)));
            }
            at = layers[clip].clip;
        }
        let clips = way.len() - 1;
        if clips > CLIPS_MAX {
            let what = format!(
                "{clips} layers clip it, each the one before: expected at most {CLIPS_MAX}"
            );
            return Err(in_layer(&layer.name, Error::limit(what)));
        }
    }
    Ok(())
}

/// Checks that each layer has a picture, and that a key view has a picture of each layer with a visible point.
fn check_pictures(set: &ViewSet, layers: &[Layer]) -> Result<(), Error> {
    let keys = set.key_views();
    for &key in &keys {
        let view = set.view(key);
        for (layer, own) in layers.iter().enumerate() {
            let seen = own.points.iter().find(|&&point| view.visible[point]);
            if let (None, Some(point)) = (view.picture(layer), seen) {
                let key = set.view_name(key);
                let what = format!(
                    "{key} has no picture of it, but shows point {point}: name a picture, \
                     or mark its points as not visible"
                );
                return Err(in_layer(&own.name, Error::missing(what)));
            }
        }
    }
    let shown = |layer: usize| keys.iter().any(|&key| set.view(key).picture(layer).is_some());
    match (0..layers.len()).find(|&layer| !shown(layer)) {
        Some(layer) if !keys.is_empty() => Err(never_shown(&layers[layer].name)),
        _ => Ok(()),
    }
}

/// Makes the layers of a set without `layers`, whose points are to be proposed. All pictures must have the same layers, in any
/// order. A layer that no picture shows is dropped.
///
/// # Errors
/// A picture cannot be read or is damaged, or lacks a layer of another picture.
pub(super) fn painted_layers(files: &[&Path]) -> Result<Vec<WrittenLayer>, Error> {
    let open = |file: &&Path| Ok((file.display().to_string(), LayeredPicture::open(file)?.layers));
    let pictures = files.iter().map(open).collect::<Result<Vec<_>, Error>>()?;
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
                return Err(in_layer(&layer.path, Error::mismatch(what)));
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
    Ok(drawn.map(|at| WrittenLayer { name: name(at), ..WrittenLayer::default() }).collect())
}

/// Adds the layers of a view's picture, with their opacities. The order is added if it differs from the set's. A
/// picture that the view names itself stays.
///
/// # Errors
/// The picture cannot be read, is damaged, lacks a layer, or shows a layer that the set does not have.
pub(super) fn add_painted(
    file: &Path,
    names: &[&str],
    views: &mut [LayerView],
) -> Result<(), Error> {
    let (picture, places) = add_pictures(file, names, views)?;
    let known: BTreeSet<usize> = names.iter().filter_map(|name| picture.find(name).ok()).collect();
    let is_new = |at: &usize| !known.contains(at) && picture.layers[*at].is_shown(&picture.layers);
    if let Some(at) = (0..picture.layers.len()).find(is_new) {
        let file = file.display();
        let what =
            format!("{file} shows it, and the set has no such layer: name it, or hide it there");
        return Err(in_layer(&picture.layers[at].path, Error::mismatch(what)));
    }
    let numbers = (0..names.len()).filter(|&layer| places[layer].is_some());
    let mut sorted: Vec<usize> = places.iter().copied().flatten().collect();
    let is_reordered = !sorted.is_sorted();
    sorted.sort_unstable();
    // Order of each layer of the file among the layers of the set.
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

/// Adds the pictures of a view's layers. A picture that the view names itself stays. Also lists the index in the file
/// of each layer.
///
/// # Errors
/// The picture cannot be read, is damaged, or lacks a layer.
pub(super) fn add_pictures(
    file: &Path,
    names: &[&str],
    views: &mut [LayerView],
) -> Result<(LayeredPicture, Vec<Option<usize>>), Error> {
    let picture = LayeredPicture::open(file)?;
    let mut places = vec![None; views.len()];
    for ((name, view), place) in names.iter().zip(views).zip(&mut places) {
        if view.image.as_ref().is_none_or(|image| image.file == file) {
            *place = Some(picture.find(name).map_err(|error| error.in_file(file))?);
            view.image = Some(Image::of_layer(file.to_owned(), name));
        }
    }
    Ok((picture, places))
}

/// Clips layers as the pictures do. A `clip` of the set stays.
///
/// # Errors
/// A picture cannot be read or is damaged; the set does not have the clipping layer; or two pictures clip a layer
/// differently.
pub(super) fn clip_as_painted(files: &[&Path], layers: &mut [WrittenLayer]) -> Result<(), Error> {
    let names: Vec<String> = layers.iter().map(|own| own.name.clone()).collect();
    // For each layer: the first file that has the layer, and its clipping layer there.
    let mut known: Vec<Option<(&Path, Option<String>)>> = vec![None; layers.len()];
    for file in files {
        let picture = LayeredPicture::open(file)?;
        // A layer that is not in the file has other pictures, or causes an error with its view.
        let places: Vec<Option<usize>> = names.iter().map(|name| picture.find(name).ok()).collect();
        for (layer, known) in known.iter_mut().enumerate() {
            let Some(place) = places[layer].filter(|_| layers[layer].clip.is_none()) else {
                continue;
            };
            let wrong = |what: String| in_layer(&names[layer], Error::mismatch(what));
            let name = |clip: usize| {
                let found = places.iter().position(|other| *other == Some(clip));
                let (file, base) = (file.display(), &picture.layers[clip].path);
                let what = format!("{file} clips it to \"{base}\", no layer of the set");
                found.map(|found| names[found].clone()).ok_or_else(|| wrong(what))
            };
            let base = picture.layers[place].clip.map(name).transpose()?;
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
