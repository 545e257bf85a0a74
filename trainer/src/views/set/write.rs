//! Views into JSON.

use super::data::{Examples, Layer, LayerView, Parameter, View, ViewSet};
use super::image::Image;
use serde_json::{Map, Value, json};
use std::path::Path;

/// Writes a set as [`super::read`] reads it.
///
/// - `folder`: where the set is to lie; pictures are named from there.
pub fn as_json(set: &ViewSet, folder: &Path) -> Value {
    let mut out = Map::new();
    out.insert("name".to_owned(), json!(set.name));
    out.insert("image_size".to_owned(), json!(set.size));
    match &set.layers[..] {
        [whole] if !has_layers(set) => {
            out.insert("elements".to_owned(), elements(whole));
        }
        layers => {
            let all = layers.iter().map(|own| layer(own, layers)).collect::<Vec<_>>();
            out.insert("layers".to_owned(), json!(all));
        }
    }
    let maps = set.maps.iter().map(|own| map(own, &set.layers, folder)).collect::<Vec<_>>();
    out.insert("maps".to_owned(), json!(maps));
    Value::Object(out)
}

/// Whether views have pictures of layers.
fn has_layers(set: &ViewSet) -> bool {
    set.maps.iter().flat_map(|map| &map.train).any(|view| !view.layers.is_empty())
}

fn elements(layer: &Layer) -> Value {
    json!(layer.elements.iter().map(|element| element.points()).collect::<Vec<_>>())
}

fn layer(own: &Layer, all: &[Layer]) -> Value {
    let mut out = json!({ "name": own.name, "points": own.points, "elements": elements(own) });
    if let Some(clip) = own.clip {
        out["clip"] = json!(all[clip].name);
    }
    out
}

fn map(examples: &Examples, layers: &[Layer], folder: &Path) -> Value {
    let views = |all: &[View]| all.iter().map(|own| view(own, layers, folder)).collect::<Vec<_>>();
    json!({
        "map": examples.name,
        "parameters": examples.parameters.iter().map(parameter).collect::<Vec<_>>(),
        "train": views(&examples.train),
        "test": views(&examples.test),
    })
}

fn parameter(parameter: &Parameter) -> Value {
    match parameter {
        Parameter::Scalar(name) => json!(name),
        Parameter::Rotation { angles, order } => {
            let named = ["x", "y", "z"].into_iter().zip(angles);
            let named: Map<String, Value> = named
                .filter_map(|(axis, name)| Some((axis.to_owned(), json!(name.as_ref()?))))
                .collect();
            json!({ "angles": named, "order": order.map(|order| order.name()) })
        }
    }
}

fn name(path: &Path, folder: &Path) -> Value {
    json!(path.strip_prefix(folder).unwrap_or(path).to_string_lossy())
}

/// Writes a layer of a view, without the picture if the view's picture in layers has it.
fn layer_view(own: &LayerView, whole: Option<&Image>, folder: &Path) -> Value {
    let mut out = Map::new();
    let is_implied = |image: &Image| {
        image.layer.is_some() && whole.is_some_and(|whole| whole.file == image.file)
    };
    if let Some(image) = own.image.as_ref().filter(|image| !is_implied(image)) {
        out.insert("image".to_owned(), name(&image.file, folder));
    }
    for (name, value) in [("opacity", own.opacity), ("order", own.order)] {
        if let Some(value) = value {
            out.insert(name.to_owned(), json!(value));
        }
    }
    Value::Object(out)
}

fn view(view: &View, layers: &[Layer], folder: &Path) -> Value {
    let mut out = Map::new();
    if let Some(image) = &view.image {
        out.insert("image".to_owned(), name(&image.file, folder));
        if let Some(mask) = &image.mask {
            out.insert("mask".to_owned(), name(mask, folder));
        }
    }
    if !view.layers.is_empty() {
        let all = layers.iter().zip(&view.layers);
        let own = |(layer, own): (&Layer, &LayerView)| {
            (layer.name.clone(), layer_view(own, view.image.as_ref(), folder))
        };
        out.insert("layers".to_owned(), Value::Object(all.map(own).collect()));
    }
    out.extend(view.values.iter().map(|(name, value)| (name.clone(), json!(value))));
    out.insert("points".to_owned(), json!(view.points));
    out.insert("visible".to_owned(), json!(view.seen().collect::<Vec<_>>()));
    if !view.depths.is_empty() {
        out.insert("depth".to_owned(), json!(view.depths));
    }
    Value::Object(out)
}
