//! Lends the motion of one object to another of its class (METHOD §6.6): maps of the prototype with pictures and
//! references of the instance.

use super::fit::MapOutputs;
use super::mesh::{Mesh, Vertex};
use super::model::{LayerModel, Reached, ViewsModel};
use super::object::{Deformation, KeyView};
use super::set::{Element, LayerView, View, cropped};
use crate::Error;
use crate::scattered::model::KernelModel;
use faer::Mat;
use sinew_runtime::Model;
use sinew_runtime::views::Views;
use std::collections::BTreeSet;

/// Makes an instance of the prototype in a file.
///
/// - `views`: views of the instance, each with the name of a key view of the prototype. A view has one picture, or
///   pictures of the prototype's layers in order. All points have a position. A layer without a picture is not drawn
///   from that view.
/// - `by_size`: whether the motion scales with the size of the instance.
///
/// # Errors
/// The file has no views, or its motion is lent itself; there is no view; a view is not a key view of the prototype, is
/// given twice, or has another number of points; a point has no position; the pictures of a view do not match the
/// layers; or a picture cannot be read or is damaged.
pub fn transfer(
    model: &Model<Vec<u8>>,
    name: &str,
    views: &[(String, View)],
    by_size: bool,
) -> Result<ViewsModel, Error> {
    let object = model.first::<Views>().ok_or_else(|| Error::missing("it has no views"))?;
    if object.is_transferred() {
        return Err(Error::unsupported("its motion is lent itself: take its prototype"));
    }
    if views.is_empty() {
        return Err(Error::missing("there are no views of the instance"));
    }
    let mut kept = Vec::new();
    let mut keys = Vec::new();
    for (named, view) in views {
        let number = key_of(&object, named, &kept)?;
        keys.push(key_view(&object, number, named, view, by_size)?);
        kept.push(number);
    }
    let maps = (0..).map_while(|map| model.map_of(&object, map));
    let all = MapOutputs::of(&object);
    let of = |map| restricted(KernelModel::from_file(&map), all, &kept);
    let layer = |number| {
        let layer = object.layer(number)?;
        let name = object.layer_name(number).unwrap_or_default().to_owned();
        Some(LayerModel {
            name,
            clip: layer.clip,
            has_depth: layer.has_depth,
            is_group: layer.is_group,
            is_one_sided: layer.is_one_sided,
        })
    };
    let fit = object.fit();
    Ok(ViewsModel {
        name: name.to_owned(),
        point_len: object.point_len(),
        size: object.size(),
        mesh: mesh(&Mesh::from_file(&object), &keys),
        layers: (0..).map_while(layer).collect(),
        keys,
        maps: maps.map(of).collect(),
        fit: Reached { visibility: fit.visibility.into(), ..Reached::default() },
    })
}

/// Adds the name of a view to an error.
fn in_view_of_instance(named: &str, error: Error) -> Error {
    error.within(format_args!("view \"{named}\" of the instance"))
}

fn key_of(object: &Views<'_>, named: &str, taken: &[usize]) -> Result<usize, Error> {
    let names: Vec<&str> = (0..).map_while(|view| object.view_name(view)).collect();
    let wrong = |what: &str| {
        let text = format!("{what}; the prototype's are {}", names.join(", "));
        in_view_of_instance(named, Error::value(text))
    };
    let number = names.iter().position(|name| *name == named);
    let number = number.ok_or_else(|| wrong("no key view"))?;
    if taken.contains(&number) { Err(wrong("it is there twice")) } else { Ok(number) }
}

fn key_view(
    object: &Views<'_>,
    number: usize,
    named: &str,
    view: &View,
    by_size: bool,
) -> Result<KeyView, Error> {
    let (expected, found) = (object.point_len(), view.points.len());
    if expected != found {
        let text = format!("expected {expected} points, found {found}");
        return Err(in_view_of_instance(named, Error::mismatch(text)));
    }
    if let Some(point) = view.points.iter().position(Option::is_none) {
        let text = format!("point {point} has no place");
        return Err(in_view_of_instance(named, Error::missing(text)));
    }
    check_layers(object, named, view)?;
    // All pictures have the size of the first picture.
    let mut size = None;
    let mut pictures = Vec::new();
    for layer in 0..object.layer_len() {
        let Some(image) = view.picture(layer) else {
            pictures.push(None);
            continue;
        };
        let whole = match size {
            None => image.load_any()?,
            Some(size) => image.load(size)?,
        };
        size = Some([whole.size.width, whole.size.height]);
        pictures.push(cropped(&whole, 1));
    }
    let own = (0..).map_while(|point| object.reference(number, point));
    let own: Vec<[f64; 2]> = own.map(|point| point.map(f64::from)).collect();
    let points = view.known();
    Ok(KeyView {
        name: named.to_owned(),
        pictures,
        deformation: Some(Deformation::new(&own, &points, by_size)),
        points,
        visible: view.visible.clone(),
    })
}

/// Checks that the pictures of a view match the layers of the prototype.
fn check_layers(object: &Views<'_>, named: &str, view: &View) -> Result<(), Error> {
    let wrong = |what: String| in_view_of_instance(named, Error::mismatch(what));
    let names: Vec<&str> = (0..).map_while(|layer| object.layer_name(layer)).collect();
    let (expected, found) = (names.len(), view.layers.len());
    if found == 0 && expected > 1 {
        let names = names.join(", ");
        return Err(wrong(format!(
            "expected pictures of {expected} layers, found none under \"layers\"; the prototype's are {names}"
        )));
    }
    if found != 0 && found != expected {
        return Err(wrong(format!("expected {expected} layers, found {found}")));
    }
    let has_own = |layer: &LayerView| layer.opacity.is_some() || layer.order.is_some();
    if let Some(layer) = view.layers.iter().position(has_own) {
        let name = names[layer];
        return Err(wrong(format!(
            "layer \"{name}\" has an opacity or an order, which are the prototype's: leave them out"
        )));
    }
    if !view.is_key() {
        return Err(Error::missing("there are no pictures"));
    }
    Ok(())
}

/// Makes the mesh of the instance. Elements between points are the prototype's. A layer that is warped as a whole gets
/// a grid over the instance's own pictures.
fn mesh(prototype: &Mesh, keys: &[KeyView]) -> Mesh {
    let mut out = Mesh::default();
    for (number, elements) in prototype.layers.iter().enumerate() {
        match warped_points(prototype, elements) {
            Some(points) => out.add_warped(number, &points, keys),
            None => out.add_layer(elements, |at| prototype.vertices[at].clone()),
        }
    }
    out
}

/// Lists the points of a layer that is warped as a whole, whose vertices lie between points. `None` for any other
/// layer.
fn warped_points(prototype: &Mesh, elements: &[Element]) -> Option<Vec<usize>> {
    let vertices =
        || elements.iter().flat_map(Element::vertices).map(|&at| &prototype.vertices[at]);
    let is_between = |vertex: &Vertex| match vertex.weights[..] {
        [] => false,
        [(point, _)] => *vertex != Vertex::of_point(point),
        _ => true,
    };
    let points = vertices().flat_map(|vertex| vertex.weights.iter().map(|(point, _)| *point));
    let points: BTreeSet<usize> = points.collect();
    vertices().any(is_between).then(|| points.into_iter().collect())
}

/// Removes the scores of all key views but the kept ones from a map.
fn restricted(mut model: KernelModel, all: MapOutputs, kept: &[usize]) -> KernelModel {
    let MapOutputs { points, views, layers } = all;
    let rows = |first: usize| -> Vec<usize> {
        let scores = kept.iter().map(|view| first + view);
        let others = first + views..first + views + 2 * layers;
        (0..first).chain(scores).chain(others).collect()
    };
    let outputs = rows(2 * points).into_iter();
    model.outputs = outputs.filter_map(|output| model.outputs.get(output).cloned()).collect();
    let (values, own) = (rows(4 * points), &model.sum.coefficients);
    model.sum.coefficients = Mat::from_fn(values.len(), own.ncols(), |r, c| own[(values[r], c)]);
    model
}
