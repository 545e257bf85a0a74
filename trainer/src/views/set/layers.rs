//! Layers of a set, as JSON has them.

use super::data::{Layer, LayerView, ViewSet};
use super::elements::Element;
use super::error::SetError;
use super::image::Image;
use super::joined::check_elements;
use serde::Deserialize;
use sinew_runtime::views::CLIPS_MAX;
use std::collections::BTreeMap;
use std::path::Path;

/// A layer of a set.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct WrittenLayer {
    pub(super) name: String,
    points: Option<WrittenPoints>,
    #[serde(default)]
    elements: Vec<Vec<usize>>,
    pub(super) clip: Option<String>,
}

/// Points of a layer: their numbers, or that they are to be proposed.
#[derive(Deserialize)]
#[serde(untagged, expecting = "expected \"auto\" or a list of numbers of points")]
enum WrittenPoints {
    Auto(Auto),
    Given(Vec<usize>),
}

/// The word in place of points that are to be proposed.
#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Auto {
    Auto,
}

impl WrittenLayer {
    /// Makes a layer whose points are to be proposed.
    pub(super) fn proposed(name: String) -> Self {
        Self {
            name,
            points: Some(WrittenPoints::Auto(Auto::Auto)),
            elements: Vec::new(),
            clip: None,
        }
    }

    /// Whether its points are to be proposed.
    pub(super) fn is_proposed(&self) -> bool {
        matches!(self.points, Some(WrittenPoints::Auto(_)))
    }

    /// Proposes the layer's points unless they are given.
    pub(super) fn propose(&mut self) {
        self.points.get_or_insert(WrittenPoints::Auto(Auto::Auto));
    }
}

/// A layer of a view: its picture, and what else is known of it.
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

/// Takes what a view says of its layers.
///
/// # Errors
/// [`SetError::Layer`] of a name that no layer has, and of an opacity beyond 0 to 1.
pub(super) fn layer_views(
    written: BTreeMap<String, WrittenLayerView>,
    names: &[&str],
    folder: &Path,
    named: &str,
) -> Result<Vec<LayerView>, SetError> {
    if let Some(unknown) = written.keys().find(|name| !names.contains(&name.as_str())) {
        let what = format!("{named} has a picture of it, and the set no such layer");
        return Err(SetError::Layer { layer: unknown.clone(), what });
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
            return Err(SetError::Layer { layer: (*name).to_owned(), what });
        }
        let image = file.map(|file| Image::of_layer(folder.join(file), name));
        Ok(LayerView { image, opacity, order })
    };
    names.iter().map(own).collect()
}

/// Makes the layers of a set whose views are read, and lists those without points, which are to be proposed.
///
/// # Errors
/// [`SetError::Layer`], and those of elements.
pub(super) fn layered(
    set: &ViewSet,
    written: Vec<WrittenLayer>,
) -> Result<(Vec<Layer>, Vec<usize>), SetError> {
    let names: Vec<String> = written.iter().map(|layer| layer.name.clone()).collect();
    let wrong = |layer: &str, what: String| SetError::Layer { layer: layer.to_owned(), what };
    let twice = (1..names.len()).find(|&at| names[..at].contains(&names[at]));
    if let Some(at) = twice {
        return Err(wrong(&names[at], "two layers have this name".to_owned()));
    }
    let (mut out, mut auto) = (Vec::new(), Vec::new());
    for WrittenLayer { name, points, elements, clip } in written {
        let clip = match clip {
            None => None,
            Some(other) => {
                let found = names.iter().position(|name| *name == other);
                let unknown = || wrong(&name, format!("it is clipped by \"{other}\", no layer"));
                Some(found.ok_or_else(unknown)?)
            }
        };
        let points = match points {
            Some(WrittenPoints::Auto(Auto::Auto)) if elements.is_empty() => {
                auto.push(out.len());
                Vec::new()
            }
            Some(WrittenPoints::Auto(Auto::Auto)) => {
                return Err(wrong(&name, "it has elements, but no points yet".to_owned()));
            }
            Some(WrittenPoints::Given(points)) if !points.is_empty() => points,
            _ => return Err(wrong(&name, "it has no points".to_owned())),
        };
        let elements = checked(set, &elements)?;
        out.push(Layer { name, points, elements, clip });
    }
    check_points(set, &out)?;
    check_clips(&out)?;
    check_pictures(set, &out)?;
    Ok((out, auto))
}

/// Makes elements of polygons, and checks them in every key view.
///
/// # Errors
/// Those of [`Element::of_polygon`] and [`check_elements`].
pub(super) fn checked(set: &ViewSet, polygons: &[Vec<usize>]) -> Result<Vec<Element>, SetError> {
    let (mut out, mut sources) = (Vec::new(), Vec::new());
    for (number, polygon) in polygons.iter().enumerate() {
        out.extend(Element::of_polygon(number, polygon, set.point_len())?);
        sources.resize(out.len(), number);
    }
    for (map, view) in set.key_views() {
        let own = &set.maps[map].train[view];
        check_elements(&out, &sources, own, &set.view_name((map, view)))?;
    }
    Ok(out)
}

/// Checks that each point is of one layer, and elements of their layer's points.
fn check_points(set: &ViewSet, layers: &[Layer]) -> Result<(), SetError> {
    let mut owner: Vec<Option<&Layer>> = vec![None; set.point_len()];
    for layer in layers {
        let wrong = |what: String| SetError::Layer { layer: layer.name.clone(), what };
        for &point in &layer.points {
            let len = owner.len();
            let own = owner.get_mut(point);
            let own = own.ok_or_else(|| wrong(format!("point {point}, of {len}")))?;
            if let Some(other) = own.replace(layer) {
                let what = format!("point {point} is in \"{}\", too", other.name);
                return Err(wrong(what));
            }
        }
        let mut corners = layer.elements.iter().flat_map(Element::points);
        if let Some(point) = corners.find(|point| !layer.points.contains(point)) {
            return Err(wrong(format!("an element has point {point}, which is not its own")));
        }
    }
    match owner.iter().position(Option::is_none) {
        None => Ok(()),
        Some(point) => Err(SetError::NoLayer { point }),
    }
}

/// Checks that no layer is clipped by itself, directly or through others, or by too many.
fn check_clips(layers: &[Layer]) -> Result<(), SetError> {
    for (number, layer) in layers.iter().enumerate() {
        let (mut at, mut way) = (layer.clip, vec![layer.name.as_str()]);
        while let Some(clip) = at {
            way.push(&layers[clip].name);
            if clip == number || way.len() > layers.len() {
                let what = format!("it is clipped by itself: {}", way.join(" by "));
                return Err(SetError::Layer { layer: layer.name.clone(), what });
            }
            at = layers[clip].clip;
        }
        let clips = way.len() - 1;
        if clips > CLIPS_MAX {
            let what = format!(
                "{clips} layers clip it, each the one before: expected at most {CLIPS_MAX}"
            );
            return Err(SetError::Layer { layer: layer.name.clone(), what });
        }
    }
    Ok(())
}

/// Checks that each layer has a picture, and that a key view has one of each layer that shows a point.
fn check_pictures(set: &ViewSet, layers: &[Layer]) -> Result<(), SetError> {
    for (map, number) in set.key_views() {
        let view = &set.maps[map].train[number];
        for (layer, own) in layers.iter().enumerate() {
            let seen = own.points.iter().find(|&&point| view.visible[point]);
            if let (None, Some(point)) = (view.picture(layer), seen) {
                let key = set.view_name((map, number));
                let what = format!(
                    "{key} has no picture of it, but shows point {point}: name a picture, \
                     or mark its points as not visible"
                );
                return Err(SetError::Layer { layer: own.name.clone(), what });
            }
        }
    }
    let keys = set.key_views();
    let shown = |layer: usize| {
        keys.iter().any(|&(map, view)| set.maps[map].train[view].picture(layer).is_some())
    };
    match (0..layers.len()).find(|&layer| !shown(layer)) {
        Some(layer) if !keys.is_empty() => Err(SetError::never_shown(&layers[layer].name)),
        _ => Ok(()),
    }
}
