//! Reads sets of views, checks their points, and gives points the depths of a mesh.

use super::data::{Examples, Layer, View, ViewSet};
use super::elements::not_triangulated;
use super::json::{
    Written, WrittenMap, WrittenView, inferred, parameter, view, wrong_field, wrong_len,
};
use super::layers::{
    WrittenLayer, add_painted, add_pictures, checked_elements, clip_as_painted, in_layer, layered,
    painted_layers,
};
use super::proposed;
use crate::Error;
use crate::formats::json::read as read_json;
use crate::formats::layered::is_layered;
use crate::formats::obj;
use nalgebra::{DMatrix, Vector3};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::Value;
use std::path::{Path, PathBuf};

/// Value of `points` for proposed points.
const AUTO: &str = "auto";
/// Reads a set of views.
///
/// - `mesh`: an OBJ that gives depths. `mesh_vertex_index` lists the vertex of each point.
///
/// # Errors
/// A file cannot be read or is damaged; something is missing, such as points, layers or parameters; or views, layers
/// or elements are invalid.
pub fn read(path: &Path, mesh: Option<&Path>) -> Result<ViewSet, Error> {
    let written: Written = parsed(path)?;
    let stem = path.file_stem().map(|stem| stem.to_string_lossy().into_owned());
    let folder = path.parent().unwrap_or(Path::new(""));
    let is_auto = match written.points {
        None | Some(Value::Array(_)) => false,
        Some(Value::String(word)) if word == AUTO => true,
        Some(found) => {
            return Err(Error::value(format!(
                "\"points\" beside \"image_size\": expected \"auto\" or a list of names, found {found}"
            )));
        }
    };
    let all: Vec<WrittenMap> = std::iter::once(written.own).chain(written.maps).collect();
    if let Some(map) = all.iter().find(|map| map.train.is_empty() && !map.test.is_empty()) {
        let what = "has views, and \"train\" none to learn from";
        return Err(wrong_field(&map.name, "test", what));
    }
    let all: Vec<WrittenMap> = all.into_iter().filter(|map| !map.train.is_empty()).collect();
    if let Some(twice) =
        (1..all.len()).find(|&at| all[..at].iter().any(|map| map.name == all[at].name))
    {
        let what = "is the name of two motions: give each its own";
        return Err(wrong_field(&all[twice].name, "map", what));
    }
    let painted = painted_files(&all, folder);
    let painted: Vec<&Path> = painted.iter().map(PathBuf::as_path).collect();
    let mut layers = match written.layers {
        Some(layers) => layers,
        None if is_auto => painted_layers(&painted)?,
        None if painted.is_empty() => Vec::new(),
        None => {
            return Err(Error::missing(format!(
                "{} has layers: write \"points\": \"auto\", or name the layers with their points under \"layers\"",
                painted[0].display()
            )));
        }
    };
    if is_auto {
        layers.iter_mut().for_each(WrittenLayer::propose);
    }
    clip_as_painted(&painted, &mut layers)?;
    let layer_names: Vec<&str> = layers.iter().map(|layer| layer.name.as_str()).collect();
    let maps: Vec<Examples> =
        all.into_iter().map(|map| examples(map, &layer_names, folder)).collect::<Result<_, _>>()?;
    let mut set = ViewSet {
        name: written.name.or(stem).unwrap_or_default(),
        size: written.image_size,
        layers: Vec::new(),
        maps,
    };
    let has_layers = !layers.is_empty();
    let is_proposed = is_auto || layers.iter().any(WrittenLayer::is_proposed);
    check_points(&set, is_proposed)?;
    if let Some(mesh) = mesh {
        let missing = || {
            Error::missing(
                "there are no vertices under \"mesh_vertex_index\": list that of each point",
            )
        };
        add_depths(&mut set, mesh, &written.mesh_vertex_index.ok_or_else(missing)?)?;
    }
    let auto;
    (set.layers, auto) = if has_layers {
        layered(&set, layers)?
    } else {
        let elements = checked_elements(&set, &written.elements)?;
        let layer = Layer::whole(&set.name, set.point_len(), elements);
        (vec![layer], if is_auto { vec![0] } else { Vec::new() })
    };
    if is_proposed && set.has_depth() {
        let text = "proposed points have no depth: leave \"depth\" and the mesh out";
        return Err(Error::unsupported(text));
    }
    proposed::add(&mut set, &auto)?;
    check_points(&set, false)?;
    Ok(set)
}

/// Reads a JSON file.
fn parsed<T: DeserializeOwned>(path: &Path) -> Result<T, Error> {
    let text = std::fs::read(path).map_err(Error::read)?;
    read_json(&text)
}

/// Lists the training pictures that have layers.
fn painted_files(maps: &[WrittenMap], folder: &Path) -> Vec<PathBuf> {
    let views = maps.iter().flat_map(|map| &map.train);
    let files = views.filter_map(|view| view.image.as_ref()).map(|file| folder.join(file));
    files.filter(|file| is_layered(file)).collect()
}

/// Reads views of an instance. Each view names a key view of the prototype under `view`. A view has one picture, which
/// may have layers, or pictures of the prototype's layers.
///
/// - `layers`: names of the prototype's layers.
///
/// # Errors
/// A file cannot be read or is damaged; a view has a picture of a layer that the prototype does not have; or a view is
/// invalid as in a set.
pub fn read_instance(path: &Path, layers: &[&str]) -> Result<Vec<(String, View)>, Error> {
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
    let written: Instance = parsed(path)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let one = |Named { view: name, own }| {
        if let Some(layer) = own.layers.keys().find(|layer| !layers.contains(&layer.as_str())) {
            let expected = layers.join(", ");
            let what = format!(
                "view \"{name}\" of the instance has a picture of it; the prototype's layers are {expected}"
            );
            return Err(in_layer(layer, Error::value(what)));
        }
        let file = own.image.as_ref().map(|file| folder.join(file)).filter(|file| is_layered(file));
        let has_layers = !own.layers.is_empty() || (file.is_some() && layers.len() > 1);
        let layers = if has_layers { layers } else { &[] };
        let mut read = view(own, &[], layers, folder, &name)?;
        if let Some(file) = file {
            add_pictures(&file, layers, &mut read.layers)?;
        }
        Ok((name, read))
    };
    written.views.into_iter().map(one).collect()
}

fn examples(map: WrittenMap, layers: &[&str], folder: &Path) -> Result<Examples, Error> {
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
                add_painted(&image.file, layers, &mut view.layers)?;
            } else if !view.is_key() {
                let what = "is one picture of all layers: name pictures of them under \"layers\"";
                return Err(wrong_field(&named, "image", what));
            }
            Ok(view)
        };
        written.into_iter().enumerate().map(one).collect::<Result<Vec<_>, Error>>()
    };
    let (train, test) = (views(train, "train")?, views(test, "test")?);
    Ok(Examples { name, parameters, train, test })
}

/// Lists all views with their names.
fn all_views(set: &ViewSet) -> impl Iterator<Item = (String, &View)> {
    set.maps.iter().flat_map(|map| {
        let named = |split: &'static str| {
            move |(number, view)| (format!("{}, {split} view {number}", map.name), view)
        };
        let train = map.train.iter().enumerate().map(named("train"));
        train.chain(map.test.iter().enumerate().map(named("test")))
    })
}

/// Checks that all views have the same number of points, and that every point has a position in some view of each
/// motion.
///
/// - `is_proposed`: whether points may still be missing.
fn check_points(set: &ViewSet, is_proposed: bool) -> Result<(), Error> {
    let expected = set.point_len();
    if set.maps.is_empty() || (expected == 0 && !is_proposed) {
        let what = if set.maps.is_empty() { "views under \"train\"" } else { "points" };
        return Err(Error::missing(format!("there are no {what}")));
    }
    for (view, own) in all_views(set) {
        let found = own.points.len();
        if found != expected {
            return Err(wrong_len(&view, "points", expected, found));
        }
    }
    set.maps.iter().try_for_each(check_places)
}

/// Checks that every point has a position in some training view of a motion.
pub(in crate::views) fn check_places(map: &Examples) -> Result<(), Error> {
    let len = map.train.first().map_or(0, |view| view.points.len());
    let is_nowhere = |k: &usize| map.train.iter().all(|view| view.points[*k].is_none());
    let nowhere = |point: usize| {
        Error::missing(format!("point {point} has a place in no view of \"{}\"", map.name))
    };
    (0..len).find(is_nowhere).map_or(Ok(()), |point| Err(nowhere(point)))
}

/// Adds depths to training views without depths.
fn add_depths(set: &mut ViewSet, mesh: &Path, vertices: &[usize]) -> Result<(), Error> {
    let (expected, found) = (set.point_len(), vertices.len());
    if found != expected {
        return Err(wrong_len("mesh_vertex_index", "vertices", expected, found));
    }
    let mesh = obj::load(mesh)?;
    let vertex_len = mesh.positions.len();
    if let Some(point) = (0..found).find(|&k| vertices[k] >= vertex_len) {
        let vertex = vertices[point];
        return Err(Error::mismatch(format!(
            "point {point} is vertex {vertex} of the mesh, which has {vertex_len}"
        )));
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

/// Computes the depths of K positions in a view, in its pixels, growing away from the viewer. Depth is measured
/// orthogonal to the x and y of the affine projection that is nearest to the known points of the view.
///
/// # Errors
/// [`ErrorKind::Fit`](crate::ErrorKind::Fit): the known points do not determine a projection.
fn depths(view: &View, positions: &[[f64; 3]], named: &str) -> Result<Vec<f64>, Error> {
    let known: Vec<(&[f64; 3], [f64; 2])> =
        positions.iter().zip(&view.points).filter_map(|(p, point)| Some((p, (*point)?))).collect();
    // The last column gives the offset.
    let a = DMatrix::from_fn(known.len(), 4, |i, c| known[i].0.get(c).copied().unwrap_or(1.0));
    let b = DMatrix::from_fn(known.len(), 2, |i, c| known[i].1[c]);
    let svd = a.svd(true, true);
    let undetermined = || not_triangulated(named, "they do not determine a projection of the mesh");
    if svd.rank(1e-9 * svd.singular_values.max()) < 4 {
        return Err(undetermined());
    }
    let found = svd.solve(&b, 0.0).map_err(|_| undetermined())?;
    let [x, y] = [0, 1].map(|axis| Vector3::from_fn(|c, _| found[(c, axis)]));
    // The product of right and down points away. Its length is that of a pixel, squared.
    let away = x.cross(&y) / (x.norm() * y.norm()).sqrt();
    Ok(positions.iter().map(|p| away.dot(&Vector3::from(*p))).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn depth_is_recovered_from_a_frontal_view() {
        let positions =
            [[0.0, 0.0, 0.0], [1.0, 0.0, 2.0], [0.0, 1.0, -1.0], [1.0, 1.0, 0.5], [0.3, 0.9, 3.0]];
        // The viewer is at large z. y points up in space, and down in pixels.
        let points = positions.map(|[x, y, _]| Some([10.0 * x + 3.0, 50.0 - 10.0 * y]));
        let view = View {
            values: Default::default(),
            points: points.to_vec(),
            visible: vec![true; 5],
            depths: Vec::new(),
            image: None,
            layers: Vec::new(),
        };
        let found = depths(&view, &positions, "view 0").unwrap();
        for ([_, _, z], depth) in positions.iter().zip(found) {
            assert!((depth + 10.0 * z).abs() < 1e-9, "{z} {depth}");
        }
        let flat = positions.map(|[x, y, _]| [x, y, 0.0]);
        assert!(depths(&view, &flat, "view 0").is_err());
    }
}
