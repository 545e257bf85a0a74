//! Trains a model on a set of views.

use super::fit::{Choice, FitOptions, FittedMap, fit};
use super::mesh::Mesh;
use super::model::{LayerModel, Reached, ViewsModel};
use super::object::KeyView;
use super::set::{Layer, View, ViewSet, cropped, triangulated};
use crate::Error;
use std::collections::BTreeSet;

/// A model, and the choices made for its maps.
#[derive(Clone, Debug)]
pub struct Trained {
    /// The model.
    pub model: ViewsModel,
    /// Choices for each map.
    pub choices: Vec<Choice>,
}

/// Fits every motion of a set, and loads the pictures of its key views.
///
/// # Errors
/// The set has no pictures; a motion cannot be fitted; a picture cannot be read or is damaged; or points cannot be
/// triangulated.
pub fn train(set: &ViewSet, options: FitOptions) -> Result<Trained, Error> {
    let keys = set.key_views();
    if keys.is_empty() {
        return Err(Error::missing("there are no pictures"));
    }
    let mut maps: Vec<FittedMap> = Vec::new();
    for (number, examples) in set.maps.iter().enumerate() {
        let own: Vec<Option<usize>> =
            keys.iter().map(|&(map, view)| (map == number).then_some(view)).collect();
        let wrong = |error: Error| error.within(format_args!("\"{}\"", examples.name));
        maps.push(fit(examples, &own, options).map_err(wrong)?);
    }
    let mut pictures = Vec::new();
    for (&(map, view), name) in keys.iter().zip(names(set, &keys)) {
        let examples = &set.maps[map];
        let wrong = |error: Error| error.within(format_args!("\"{}\"", examples.name));
        let predicted = maps[map].shown(&examples.train[view].values).map_err(wrong)?.points;
        pictures.push(key_view(set, name, &examples.train[view], &predicted)?);
    }
    let views = || set.maps.iter().flat_map(|map| &map.train);
    let fades = |number: usize| {
        let mut opacities = views().filter_map(|view| view.layers.get(number)?.opacity);
        opacities.any(|opacity| opacity != 1.0)
    };
    let is_whole = is_whole(set, &keys);
    let layer = |(number, layer): (usize, &Layer)| LayerModel {
        name: layer.name.clone(),
        clip: layer.clip,
        has_depth: set.has_depth(),
        // Elements between points overlap where points are hidden.
        is_group: is_whole || !layer.elements.is_empty() || fades(number),
        // The frame around these elements stays. Where elements turn over, other elements cover the same place.
        is_one_sided: is_whole && layer.elements.is_empty() && !set.has_depth(),
    };
    let model = ViewsModel {
        name: set.name.clone(),
        size: set.size,
        point_len: set.point_len(),
        mesh: mesh(set, &keys, &pictures)?,
        layers: set.layers.iter().enumerate().map(layer).collect(),
        keys: pictures,
        fit: reached(set, &maps),
        maps: maps.iter().map(|map| map.model.clone()).collect(),
    };
    Ok(Trained { model, choices: maps.into_iter().map(|map| map.choice).collect() })
}

/// Names key views after their pictures, or after the pictures of their first layers, without the ending. If two names
/// would be equal, names them after motion and index.
fn names(set: &ViewSet, keys: &[(usize, usize)]) -> Vec<String> {
    let stem = |&key: &(usize, usize)| {
        let own = set.view(key);
        let first = || own.layers.iter().find_map(|layer| layer.image.as_ref());
        let stem = own.image.as_ref().or_else(first)?.file.file_stem()?;
        Some(stem.to_string_lossy().into_owned())
    };
    let stems: BTreeSet<String> = keys.iter().filter_map(stem).collect();
    let number = |&(map, view): &(usize, usize)| format!("{} {view}", set.maps[map].name);
    let is_unique = stems.len() == keys.len();
    keys.iter().map(|key| stem(key).filter(|_| is_unique).unwrap_or_else(|| number(key))).collect()
}

/// Loads the pictures of a key view, each cropped to its covered pixels.
///
/// - `predicted`: positions of the points by the map, for points without a known position.
fn key_view(
    set: &ViewSet,
    name: String,
    view: &View,
    predicted: &[[f64; 2]],
) -> Result<KeyView, Error> {
    let mut pictures = Vec::new();
    for layer in 0..set.layers.len() {
        let whole = view.picture(layer).map(|image| image.load(set.size)).transpose()?;
        pictures.push(whole.and_then(|whole| cropped(&whole, 1)));
    }
    let known = view.points.iter().zip(predicted).map(|(known, found)| known.unwrap_or(*found));
    Ok(KeyView {
        name,
        pictures,
        points: known.collect(),
        visible: view.visible.clone(),
        deformation: None,
    })
}

/// Whether each key view has one picture for all layers.
fn is_whole(set: &ViewSet, keys: &[(usize, usize)]) -> bool {
    keys.iter().all(|&key| set.view(key).layers.is_empty())
}

/// Makes the vertices and elements of all layers.
fn mesh(set: &ViewSet, keys: &[(usize, usize)], pictures: &[KeyView]) -> Result<Mesh, Error> {
    let mut out = Mesh::default();
    for (number, layer) in set.layers.iter().enumerate() {
        let seen = |view: &View| layer.points.iter().filter(|&&k| view.visible[k]).count();
        if !layer.elements.is_empty() {
            out.add_elements(&layer.elements, set.point_len(), &[]);
        } else if is_whole(set, keys) {
            // The first of the key views with the most visible points.
            let most =
                keys.iter().rev().copied().max_by_key(|&key| seen(set.view(key))).unwrap_or((0, 0));
            let mut frame = if set.has_depth() { Vec::new() } else { frame(set.size) };
            // A visible point replaces a place of the frame at the same position.
            let view = set.view(most);
            let seen: Vec<[f64; 2]> = (0..view.points.len())
                .filter(|&k| view.visible[k])
                .filter_map(|k| view.points[k])
                .collect();
            frame.retain(|place| !seen.contains(place));
            let elements = triangulated(view, &frame, &set.view_name(most))?;
            out.add_elements(&elements, set.point_len(), &frame);
        } else {
            out.add_warped(number, &layer.points, pictures);
        }
    }
    Ok(out)
}

/// Lists the corners of a picture and the middles of its sides, which stay fixed while points move.
fn frame([width, height]: [usize; 2]) -> Vec<[f64; 2]> {
    let [x, y] = [width, height].map(|side| side as f64);
    let places = [
        [0.0, 0.0],
        [0.5, 0.0],
        [1.0, 0.0],
        [1.0, 0.5],
        [1.0, 1.0],
        [0.5, 1.0],
        [0.0, 1.0],
        [0.0, 0.5],
    ];
    places.map(|[a, b]| [a * x, b * y]).into()
}

/// Measures the errors of the maps on the training views.
fn reached(set: &ViewSet, maps: &[FittedMap]) -> Reached {
    let rms = |of: &dyn Fn(&FittedMap) -> f64| {
        let squares = maps.iter().map(|map| of(map).powi(2)).sum::<f64>();
        (squares / maps.len().max(1) as f64).sqrt()
    };
    let (mut right, mut count) = (0, 0);
    for (examples, map) in set.maps.iter().zip(maps) {
        for view in &examples.train {
            let Ok(shown) = map.shown(&view.values) else { continue };
            for (own, seen) in shown.visible.iter().zip(view.seen()) {
                let Some(seen) = seen else { continue };
                (right, count) = (right + usize::from(*own == seen), count + 1);
            }
        }
    }
    Reached {
        rms: rms(&|map| map.model.fit.residual_rms),
        left_out: rms(&|map| map.model.fit.left_out_rms),
        visibility: right as f64 / count.max(1) as f64,
    }
}
