//! Views as JSON.

use super::data::{Examples, Layer, Parameter, Values, View, ViewSet};
use super::depth::depths;
use super::error::SetError;
use super::image::Image;
use super::layers::{WrittenLayer, WrittenLayerView, checked, layer_views, layered};
use super::{painted, proposed};
use crate::formats::layered::is_layered;
use crate::formats::{FormatError, obj};
use serde::Deserialize;
use serde_json::Value;
use sinew_runtime::kernel::EulerOrder;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// What the name of an angle ends with where nothing declares it.
const DEGREES: &str = "_deg";
/// In place of points: propose them.
const AUTO: &str = "auto";
/// Angles that make one rotation where nothing declares it: about x, y and z.
const HEAD: [&str; 3] = ["pitch", "yaw", "roll"];

#[derive(Deserialize)]
struct Written {
    name: Option<String>,
    image_size: [usize; 2],
    #[serde(default)]
    elements: Vec<Vec<usize>>,
    layers: Option<Vec<WrittenLayer>>,
    /// Names of points, which nobody reads, or [`AUTO`].
    points: Option<Value>,
    mesh_vertex_index: Option<Vec<usize>>,
    #[serde(default)]
    maps: Vec<WrittenMap>,
    #[serde(flatten)]
    own: WrittenMap,
}

#[derive(Deserialize)]
struct WrittenMap {
    #[serde(rename = "map", default = "main")]
    name: String,
    parameters: Option<Vec<WrittenParameter>>,
    #[serde(default)]
    train: Vec<WrittenView>,
    #[serde(default)]
    test: Vec<WrittenView>,
}

#[derive(Deserialize)]
#[serde(untagged)]
enum WrittenParameter {
    Scalar(String),
    Rotation { angles: BTreeMap<Axis, String>, order: Option<String> },
}

#[derive(Clone, Copy, Deserialize, PartialEq, Eq, PartialOrd, Ord)]
#[serde(rename_all = "lowercase")]
enum Axis {
    X,
    Y,
    Z,
}

#[derive(Deserialize)]
struct WrittenView {
    image: Option<String>,
    mask: Option<String>,
    #[serde(default)]
    points: Vec<Option<[f64; 2]>>,
    visible: Option<Vec<Option<bool>>>,
    depth: Option<Vec<f64>>,
    #[serde(default)]
    layers: BTreeMap<String, WrittenLayerView>,
    #[serde(flatten)]
    values: BTreeMap<String, Value>,
}

fn main() -> String {
    "main".to_owned()
}

/// Reads a set of views.
///
/// - `mesh`: an OBJ, of whose vertices `mesh_vertex_index` are the points: depths come from it.
///
/// # Errors
/// [`SetError`].
pub fn read(path: &Path, mesh: Option<&Path>) -> Result<ViewSet, SetError> {
    let written: Written =
        serde_json::from_slice(&std::fs::read(path).map_err(FormatError::Read)?)?;
    let stem = path.file_stem().map(|stem| stem.to_string_lossy().into_owned());
    let folder = path.parent().unwrap_or(Path::new(""));
    let Written {
        name,
        image_size,
        elements: polygons,
        layers,
        points,
        mesh_vertex_index,
        maps,
        own,
    } = written;
    let is_auto = match points {
        None | Some(Value::Array(_)) => false,
        Some(Value::String(word)) if word == AUTO => true,
        Some(found) => return Err(SetError::Points { found: found.to_string() }),
    };
    let all: Vec<WrittenMap> = std::iter::once(own).chain(maps).collect();
    if let Some(map) = all.iter().find(|map| map.train.is_empty() && !map.test.is_empty()) {
        let what = "has views, and \"train\" none to learn from";
        return Err(SetError::field(&map.name, "test", what));
    }
    let all: Vec<WrittenMap> = all.into_iter().filter(|map| !map.train.is_empty()).collect();
    if let Some(twice) =
        (1..all.len()).find(|&at| all[..at].iter().any(|map| map.name == all[at].name))
    {
        let what = "is the name of two motions: give each its own";
        return Err(SetError::field(&all[twice].name, "map", what));
    }
    let painted = painted_files(&all, folder);
    let painted: Vec<&Path> = painted.iter().map(PathBuf::as_path).collect();
    let mut layers = match layers {
        Some(layers) => layers,
        None if is_auto => painted::written(&painted)?,
        None if painted.is_empty() => Vec::new(),
        None => return Err(SetError::Unnamed { file: painted[0].to_owned() }),
    };
    if is_auto {
        layers.iter_mut().for_each(WrittenLayer::propose);
    }
    painted::clip(&painted, &mut layers)?;
    let layer_names: Vec<&str> = layers.iter().map(|layer| layer.name.as_str()).collect();
    let maps: Vec<Examples> =
        all.into_iter().map(|map| examples(map, &layer_names, folder)).collect::<Result<_, _>>()?;
    let mut set = ViewSet {
        name: name.or(stem).unwrap_or_default(),
        size: image_size,
        layers: Vec::new(),
        maps,
    };
    let has_layers = !layers.is_empty();
    let is_proposed = is_auto || layers.iter().any(WrittenLayer::is_proposed);
    check_points(&set, is_proposed)?;
    if let Some(mesh) = mesh {
        let missing = "vertices under \"mesh_vertex_index\": list that of each point";
        add_depths(&mut set, mesh, &mesh_vertex_index.ok_or(SetError::Empty(missing))?)?;
    }
    let auto = if has_layers {
        let (layers, auto) = layered(&set, layers)?;
        set.layers = layers;
        auto
    } else {
        set.layers = vec![single(&set, &polygons)?];
        if is_auto { vec![0] } else { Vec::new() }
    };
    if is_proposed && set.has_depth() {
        return Err(SetError::Depths);
    }
    proposed::add(&mut set, &auto)?;
    check_points(&set, false)?;
    Ok(set)
}

/// Lists the pictures in layers of views to learn from.
fn painted_files(maps: &[WrittenMap], folder: &Path) -> Vec<PathBuf> {
    let views = maps.iter().flat_map(|map| &map.train);
    let files = views.filter_map(|view| view.image.as_ref()).map(|file| folder.join(file));
    files.filter(|file| is_layered(file)).collect()
}

/// Reads views of an instance. Each has the name of a prototype's key view under `view`, and its picture, which may have
/// layers, or pictures of the prototype's layers.
///
/// - `layers`: their names.
///
/// # Errors
/// [`SetError`] of reading, and of each view by itself.
pub fn read_instance(path: &Path, layers: &[&str]) -> Result<Vec<(String, View)>, SetError> {
    #[derive(Deserialize)]
    struct Instance {
        views: Vec<Named>,
    }
    #[derive(Deserialize)]
    struct Named {
        view: String,
        #[serde(flatten)]
        own: WrittenView,
    }
    let written: Instance =
        serde_json::from_slice(&std::fs::read(path).map_err(FormatError::Read)?)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let one = |Named { view: name, own }| {
        if let Some(layer) = own.layers.keys().find(|layer| !layers.contains(&layer.as_str())) {
            let expected = layers.join(", ");
            let what = format!(
                "view \"{name}\" of the instance has a picture of it; the prototype's layers are {expected}"
            );
            return Err(SetError::Layer { layer: layer.clone(), what });
        }
        let file = own.image.as_ref().map(|file| folder.join(file)).filter(|file| is_layered(file));
        let has_layers = !own.layers.is_empty() || (file.is_some() && layers.len() > 1);
        let layers = if has_layers { layers } else { &[] };
        let mut read = view(own, &[], layers, folder, &name)?;
        if let Some(file) = file {
            painted::add_pictures(&file, layers, &mut read.layers)?;
        }
        Ok((name, read))
    };
    written.views.into_iter().map(one).collect()
}

fn examples(map: WrittenMap, layers: &[&str], folder: &Path) -> Result<Examples, SetError> {
    let WrittenMap { name, parameters, train, test } = map;
    let parameters = match parameters {
        Some(written) => written.into_iter().map(parameter).collect::<Result<_, _>>()?,
        None => inferred(train.first().map(|view| &view.values)),
    };
    let views = |written: Vec<WrittenView>, split: &str| {
        let one = |(number, own): (usize, WrittenView)| {
            let named = format!("{name}, {split} view {number}");
            let mut view = view(own, &parameters, layers, folder, &named)?;
            let Some(image) =
                view.image.as_ref().filter(|_| split == "train" && !layers.is_empty())
            else {
                return Ok(view);
            };
            if is_layered(&image.file) {
                painted::add(&image.file, layers, &mut view.layers)?;
            } else if !view.is_key() {
                let what = "is one picture of all layers: name pictures of them under \"layers\"";
                return Err(SetError::field(&named, "image", what));
            }
            Ok(view)
        };
        written.into_iter().enumerate().map(one).collect::<Result<Vec<_>, SetError>>()
    };
    let (train, test) = (views(train, "train")?, views(test, "test")?);
    Ok(Examples { name, parameters, train, test })
}

fn parameter(written: WrittenParameter) -> Result<Parameter, SetError> {
    let (angles, order) = match written {
        WrittenParameter::Scalar(name) => return Ok(Parameter::Scalar(name)),
        WrittenParameter::Rotation { angles, order } => (angles, order),
    };
    let found = |name: &String| EulerOrder::ALL.into_iter().find(|order| order.name() == name);
    let known = match &order {
        Some(name) => Some(found(name).ok_or_else(|| SetError::Parameter {
            view: "parameters".to_owned(),
            name: name.clone(),
            what: "no order of angles: expected XYZ, XZY, YXZ, YZX, ZXY or ZYX",
        })?),
        None => None,
    };
    let angle = |axis| angles.get(&axis).cloned();
    Ok(Parameter::Rotation { angles: [Axis::X, Axis::Y, Axis::Z].map(angle), order: known })
}

/// Takes every number of a view for a parameter: those that end as degrees for angles.
fn inferred(values: Option<&BTreeMap<String, Value>>) -> Vec<Parameter> {
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

fn view(
    written: WrittenView,
    parameters: &[Parameter],
    layers: &[&str],
    folder: &Path,
    named: &str,
) -> Result<View, SetError> {
    let WrittenView { image, mask, points, visible, depth, layers: own_layers, values: all } =
        written;
    let mut values = Values::new();
    for name in parameters.iter().flat_map(Parameter::names) {
        let own = all.get(name).or_else(|| all.get(&format!("{name}{DEGREES}")));
        let wrong =
            |what| SetError::Parameter { view: named.to_owned(), name: name.to_owned(), what };
        let number = own.ok_or_else(|| wrong("missing"))?.as_f64();
        values.insert(name.to_owned(), number.ok_or_else(|| wrong("no number"))?);
    }
    let field = |name: &str, what: &str| Err(SetError::field(named, name, what));
    // A number may be a parameter of another map.
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
        image: image.map(|file| Image {
            file: folder.join(file),
            mask: mask.map(|mask| folder.join(mask)),
            layer: None,
        }),
        layers: layer_views(own_layers, layers, folder, named)?,
    };
    let expected = view.points.len();
    let depths = if view.depths.is_empty() { expected } else { view.depths.len() };
    for (what, found) in [("marks of visibility", view.visible.len()), ("depths", depths)] {
        if found != expected {
            return Err(SetError::Length { view: named.to_owned(), what, expected, found });
        }
    }
    let has_picture = view.image.is_some() || view.is_key();
    for (point, (seen, place)) in marks.into_iter().zip(&view.points).enumerate() {
        let view = || named.to_owned();
        match (seen, place) {
            (Some(true), None) => return Err(SetError::Unknown { view: view(), point }),
            (None, Some(_)) => return Err(SetError::Unsaid { view: view(), point }),
            (None, None) if has_picture => return Err(SetError::Unsaid { view: view(), point }),
            _ => {}
        }
    }
    Ok(view)
}

/// Lists all views with what they are called.
fn all_views(set: &ViewSet) -> impl Iterator<Item = (String, &View)> {
    set.maps.iter().flat_map(|map| {
        let named = |split: &'static str| {
            move |(number, view)| (format!("{}, {split} view {number}", map.name), view)
        };
        let train = map.train.iter().enumerate().map(named("train"));
        train.chain(map.test.iter().enumerate().map(named("test")))
    })
}

/// Checks that all views have as many points, and every point a place in some view of each motion.
///
/// - `is_proposed`: whether there may be no points yet.
fn check_points(set: &ViewSet, is_proposed: bool) -> Result<(), SetError> {
    let expected = set.point_len();
    if set.maps.is_empty() || (expected == 0 && !is_proposed) {
        let what = if set.maps.is_empty() { "views under \"train\"" } else { "points" };
        return Err(SetError::Empty(what));
    }
    for (view, own) in all_views(set) {
        let found = own.points.len();
        if found != expected {
            return Err(SetError::Length { view, what: "points", expected, found });
        }
    }
    for map in &set.maps {
        let nowhere = |k: &usize| map.train.iter().all(|view| view.points[*k].is_none());
        if let Some(point) = (0..expected).find(nowhere) {
            return Err(SetError::Nowhere { map: map.name.clone(), point });
        }
    }
    Ok(())
}

/// Gives depths to training views that have none.
fn add_depths(set: &mut ViewSet, mesh: &Path, vertices: &[usize]) -> Result<(), SetError> {
    let (expected, found) = (set.point_len(), vertices.len());
    if found != expected {
        let view = "mesh_vertex_index".to_owned();
        return Err(SetError::Length { view, what: "vertices", expected, found });
    }
    let mesh = obj::load(mesh)?;
    let vertex_len = mesh.positions.len();
    if let Some(point) = (0..found).find(|&k| vertices[k] >= vertex_len) {
        return Err(SetError::Vertex { point, vertex: vertices[point], vertices: vertex_len });
    }
    let positions: Vec<[f64; 3]> = vertices.iter().map(|&vertex| mesh.positions[vertex]).collect();
    for map in &mut set.maps {
        for (number, view) in map.train.iter_mut().enumerate() {
            if view.depths.is_empty() {
                view.depths = depths(view, &positions, &format!("train view {number}"))?;
            }
        }
    }
    Ok(())
}

/// Makes the layer of a set that names none, of the elements that are given.
fn single(set: &ViewSet, polygons: &[Vec<usize>]) -> Result<Layer, SetError> {
    Ok(Layer::whole(&set.name, set.point_len(), checked(set, polygons)?))
}
