//! The JSON of a set of views: how a set is written by hand, and how sinew writes a set.

use super::data::{Examples, Image, Layer, LayerView, Parameter, Values, View, ViewSet};
use super::layers::{WrittenLayer, WrittenLayerView, layer_views};
use crate::Error;
use crate::formats::layered::is_layered;
use serde::Deserialize;
use serde_json::{Value, json};
use sinew_runtime::kernel::EulerOrder;
use std::collections::BTreeMap;
use std::path::Path;

/// Suffix of the names of angles, in a set without `parameters`.
const DEGREES: &str = "_deg";
/// Angles about x, y and z that make one rotation, in a set without `parameters`.
const HEAD: [&str; 3] = ["pitch", "yaw", "roll"];

#[derive(Deserialize)]
pub(super) struct Written {
    pub(super) name: Option<String>,
    pub(super) image_size: [usize; 2],
    #[serde(default)]
    pub(super) elements: Vec<Vec<usize>>,
    pub(super) layers: Option<Vec<WrittenLayer>>,
    /// Names of points, which are ignored, or the word `"auto"`.
    pub(super) points: Option<Value>,
    pub(super) mesh_vertex_index: Option<Vec<usize>>,
    #[serde(default)]
    pub(super) maps: Vec<WrittenMap>,
    #[serde(flatten)]
    pub(super) own: WrittenMap,
}

#[derive(Deserialize)]
pub(super) struct WrittenMap {
    #[serde(rename = "map", default = "main")]
    pub(super) name: String,
    pub(super) parameters: Option<Vec<WrittenParameter>>,
    #[serde(default)]
    pub(super) train: Vec<WrittenView>,
    #[serde(default)]
    pub(super) test: Vec<WrittenView>,
}

#[derive(Deserialize)]
#[serde(untagged)]
pub(super) enum WrittenParameter {
    Scalar(String),
    Rotation { angles: BTreeMap<Axis, String>, order: Option<String> },
}

#[derive(Clone, Copy, Deserialize, PartialEq, Eq, PartialOrd, Ord)]
#[serde(rename_all = "lowercase")]
pub(super) enum Axis {
    X,
    Y,
    Z,
}

#[derive(Deserialize)]
pub(super) struct WrittenView {
    pub(super) image: Option<String>,
    mask: Option<String>,
    #[serde(default)]
    points: Vec<Option<[f64; 2]>>,
    visible: Option<Vec<Option<bool>>>,
    depth: Option<Vec<f64>>,
    #[serde(default)]
    pub(super) layers: BTreeMap<String, WrittenLayerView>,
    #[serde(flatten)]
    pub(super) values: BTreeMap<String, Value>,
}

fn main() -> String {
    "main".to_owned()
}

/// Reads a parameter.
///
/// # Errors
/// The order of the angles is unknown.
pub(super) fn parameter(written: WrittenParameter) -> Result<Parameter, Error> {
    let (angles, order) = match written {
        WrittenParameter::Scalar(name) => return Ok(Parameter::Scalar(name)),
        WrittenParameter::Rotation { angles, order } => (angles, order),
    };
    let known = |name: String| {
        let found = EulerOrder::ALL.into_iter().find(|order| order.name() == name);
        found.ok_or_else(|| {
            Error::value(format!(
                "parameters: parameter \"{name}\" is no order of angles: expected XYZ, XZY, YXZ, YZX, ZXY or ZYX"
            ))
        })
    };
    let order = order.map(known).transpose()?;
    let angle = |axis| angles.get(&axis).cloned();
    Ok(Parameter::Rotation { angles: [Axis::X, Axis::Y, Axis::Z].map(angle), order })
}

/// Makes a parameter of every number of a view, and an angle of every number whose name ends in degrees.
pub(super) fn inferred(values: Option<&BTreeMap<String, Value>>) -> Vec<Parameter> {
    let numbers = || values.into_iter().flatten().filter(|(_, value)| value.is_number());
    let angle = |name: &str| numbers().any(|(key, _)| key.strip_suffix(DEGREES) == Some(name));
    let head = HEAD.map(|name| angle(name).then(|| name.to_owned()));
    let mut out = Vec::new();
    if head.iter().any(Option::is_some) {
        out.push(Parameter::Rotation { angles: head, order: None });
    }
    for (key, _) in numbers() {
        match key.strip_suffix(DEGREES) {
            Some(name) if HEAD.contains(&name) => {}
            Some(name) => out.push(Parameter::Rotation {
                angles: [None, None, Some(name.to_owned())],
                order: None,
            }),
            None => out.push(Parameter::Scalar(key.clone())),
        }
    }
    out
}

/// Makes the error of a view with the wrong number of values of a kind.
pub(super) fn wrong_len(named: &str, what: &str, expected: usize, found: usize) -> Error {
    Error::mismatch(format!("{named}: expected {expected} {what}, found {found}"))
}

/// Makes the error of an unknown or misplaced field of a view.
pub(super) fn wrong_field(named: &str, name: &str, what: &str) -> Error {
    Error::value(format!("{named}: \"{name}\" {what}"))
}

/// Makes the error of a missing parameter.
pub(super) fn missing_parameter(named: &str, name: &str) -> Error {
    Error::missing(format!("{named}: parameter \"{name}\" is missing"))
}

/// Reads a view.
///
/// - `named`: name of the view in errors.
///
/// # Errors
/// A parameter is missing or no number; a field is unknown or misplaced; a layer is unknown; numbers of points, marks
/// and depths differ; a visible point has no position; or a mark of visibility is missing.
pub(super) fn view(
    written: WrittenView,
    parameters: &[Parameter],
    layers: &[&str],
    folder: &Path,
    named: &str,
) -> Result<View, Error> {
    let WrittenView { image, mask, points, visible, depth, layers: own_layers, values: all } =
        written;
    let mut values = Values::new();
    for name in parameters.iter().flat_map(Parameter::names) {
        let own = all.get(name).or_else(|| all.get(&format!("{name}{DEGREES}")));
        let number = own.ok_or_else(|| missing_parameter(named, name))?.as_f64();
        let wrong = || Error::value(format!("{named}: parameter \"{name}\" is no number"));
        values.insert(name.to_owned(), number.ok_or_else(wrong)?);
    }
    let field = |name: &str, what: &str| Err(wrong_field(named, name, what));
    // A number may be a parameter of another motion.
    if let Some((name, _)) = all.iter().find(|(_, value)| !value.is_number()) {
        return field(
            name,
            "is neither a parameter nor one of image, mask, points, visible, depth, layers",
        );
    }
    match image.as_ref().map(|file| is_layered(Path::new(file))) {
        None if mask.is_some() => {
            return field("mask", "is the mask of an image, and there is none");
        }
        Some(true) if mask.is_some() => {
            return field("mask", "is the mask of a picture in layers: leave it out");
        }
        _ => {}
    }
    let all_known = || points.iter().map(|point| Some(point.is_some())).collect();
    let marks: Vec<Option<bool>> = visible.unwrap_or_else(all_known);
    let view = View {
        values,
        visible: marks.iter().map(|seen| seen.unwrap_or(true)).collect(),
        points,
        depths: depth.unwrap_or_default(),
        image: image.map(|file| {
            let mask = mask.map(|mask| folder.join(mask));
            Image { mask, ..Image::of_file(folder.join(file)) }
        }),
        layers: layer_views(own_layers, layers, folder, named)?,
    };
    let expected = view.points.len();
    let depths = if view.depths.is_empty() { expected } else { view.depths.len() };
    for (what, found) in [("marks of visibility", view.visible.len()), ("depths", depths)] {
        if found != expected {
            return Err(wrong_len(named, what, expected, found));
        }
    }
    let has_picture = view.image.is_some() || view.is_key();
    for (point, (seen, place)) in marks.into_iter().zip(&view.points).enumerate() {
        if seen == Some(true) && place.is_none() {
            let text = format!("{named}: point {point} is visible and has no place");
            return Err(Error::missing(text));
        }
        if seen.is_none() && (place.is_some() || has_picture) {
            return Err(Error::value(format!(
                "{named}: point {point}: \"visible\" is null, expected true or false where there is a place or a picture"
            )));
        }
    }
    Ok(view)
}

/// Writes a set in the format that [`super::read()`] reads.
///
/// - `folder`: folder of the set. Pictures are named relative to the folder.
pub fn as_json(set: &ViewSet, folder: &Path) -> Value {
    let maps: Value = set.maps.iter().map(|own| map_json(own, &set.layers, folder)).collect();
    let mut out = json!({ "name": set.name, "image_size": set.size, "maps": maps });
    match &set.layers[..] {
        [whole] if !has_layers(set) => out["elements"] = elements_json(whole),
        layers => out["layers"] = layers.iter().map(|own| layer_json(own, layers)).collect(),
    }
    out
}

/// Drops the fields without a value from an object.
fn without_nulls(object: Value) -> Value {
    let fields = object.as_object().into_iter().flatten().filter(|(_, value)| !value.is_null());
    fields.map(|(name, value)| (name.clone(), value.clone())).collect()
}

/// Whether views have pictures of layers.
fn has_layers(set: &ViewSet) -> bool {
    set.maps.iter().flat_map(|map| &map.train).any(|view| !view.layers.is_empty())
}

fn elements_json(layer: &Layer) -> Value {
    json!(layer.elements.iter().map(|element| element.vertices()).collect::<Vec<_>>())
}

fn layer_json(own: &Layer, all: &[Layer]) -> Value {
    without_nulls(json!({
        "name": own.name,
        "points": own.points,
        "elements": elements_json(own),
        "clip": own.clip.map(|clip| &all[clip].name),
    }))
}

fn map_json(examples: &Examples, layers: &[Layer], folder: &Path) -> Value {
    let views =
        |all: &[View]| all.iter().map(|own| view_json(own, layers, folder)).collect::<Vec<_>>();
    json!({
        "map": examples.name,
        "parameters": examples.parameters.iter().map(parameter_json).collect::<Vec<_>>(),
        "train": views(&examples.train),
        "test": views(&examples.test),
    })
}

fn parameter_json(parameter: &Parameter) -> Value {
    match parameter {
        Parameter::Scalar(name) => json!(name),
        Parameter::Rotation { angles: [x, y, z], order } => {
            let angles = without_nulls(json!({ "x": x, "y": y, "z": z }));
            json!({ "angles": angles, "order": order.map(|order| order.name()) })
        }
    }
}

fn path_json(path: &Path, folder: &Path) -> Value {
    json!(path.strip_prefix(folder).unwrap_or(path).to_string_lossy())
}

/// Writes a layer of a view. The picture is omitted if the view's own picture contains the layer.
fn layer_view_json(own: &LayerView, whole: Option<&Image>, folder: &Path) -> Value {
    let is_implied = |image: &Image| {
        image.layer.is_some() && whole.is_some_and(|whole| whole.file == image.file)
    };
    let image = own.image.as_ref().filter(|image| !is_implied(image));
    without_nulls(json!({
        "image": image.map(|image| path_json(&image.file, folder)),
        "opacity": own.opacity,
        "order": own.order,
    }))
}

fn view_json(view: &View, layers: &[Layer], folder: &Path) -> Value {
    let whole = view.image.as_ref();
    let layer = |(layer, own): (&Layer, &LayerView)| {
        (layer.name.clone(), layer_view_json(own, whole, folder))
    };
    let layers = layers.iter().zip(&view.layers).map(layer);
    let mut out = json!({
        "image": whole.map(|image| path_json(&image.file, folder)),
        "mask": whole.and_then(|image| Some(path_json(image.mask.as_ref()?, folder))),
        "layers": (!view.layers.is_empty()).then(|| layers.collect::<Value>()),
        "points": view.points,
        "visible": view.seen().collect::<Vec<_>>(),
        "depth": (!view.depths.is_empty()).then_some(&view.depths),
    });
    view.values.iter().for_each(|(name, value)| out[name] = json!(value));
    without_nulls(out)
}
