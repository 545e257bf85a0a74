//! Views into JSON.

use super::data::{Examples, Parameter, View, ViewSet};
use serde_json::{Map, Value, json};
use std::path::Path;

/// Writes a set of one layer as [`super::read`] reads it; pictures are named as they lie in its folder.
pub fn as_json(set: &ViewSet) -> Value {
    let elements = set.layers.iter().flat_map(|layer| &layer.elements);
    let elements: Vec<&[usize]> = elements.map(|element| element.points()).collect();
    json!({
        "name": set.name,
        "image_size": set.size,
        "elements": elements,
        "maps": set.maps.iter().map(map).collect::<Vec<_>>(),
    })
}

fn map(examples: &Examples) -> Value {
    let views = |all: &[View]| all.iter().map(view).collect::<Vec<_>>();
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

fn view(view: &View) -> Value {
    let mut out = Map::new();
    let name = |path: &Path| json!(path.file_name().map(|name| name.to_string_lossy()));
    if let Some(image) = &view.image {
        out.insert("image".to_owned(), name(&image.file));
        if let Some(mask) = &image.mask {
            out.insert("mask".to_owned(), name(mask));
        }
    }
    out.extend(view.values.iter().map(|(name, value)| (name.clone(), json!(value))));
    out.insert("points".to_owned(), json!(view.points));
    out.insert("visible".to_owned(), json!(view.visible));
    if !view.depths.is_empty() {
        out.insert("depth".to_owned(), json!(view.depths));
    }
    Value::Object(out)
}
