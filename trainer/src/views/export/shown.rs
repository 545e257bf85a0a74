//! An object at a node, as the runtime draws it: positions, order of layers, and shares of key views.

use crate::page::camera::Resolution;
use crate::views::player::{Played, Player};
use sinew_runtime::views::{Element, Views};
use std::collections::HashMap;

/// An object at a node.
pub(super) struct Shown<'a> {
    views: &'a Views<'a>,
    played: &'a Played,
    /// Positions of the V vertices on the screen, and their depths, pixels.
    pub(super) places: Vec<[f64; 3]>,
}

impl<'a> Shown<'a> {
    /// Places the vertices.
    pub(super) fn new(player: &'a Player<'a>, played: &'a Played) -> Self {
        let views = player.views();
        let places =
            player.vertices(played).into_iter().map(|place| place.map(f64::from)).collect();
        Self { views, played, places }
    }

    /// Lists the layers, the hindmost first.
    pub(super) fn layers(&self) -> Vec<usize> {
        let layers = &self.played.layers;
        let mut out: Vec<usize> = (0..layers.len()).collect();
        out.sort_by(|&a, &b| layers[a][1].total_cmp(&layers[b][1]));
        out
    }

    /// Returns the opacity of a layer.
    pub(super) fn opacity(&self, layer: usize) -> f64 {
        f64::from(self.played.layers[layer][0])
    }

    /// Lists the key views, the highest score first.
    pub(super) fn ranking(&self) -> Vec<usize> {
        descending(&self.played.scores.iter().copied().map(f64::from).collect::<Vec<_>>())
    }

    /// Returns the key view that textures an element: the first in `ranking` that shows all of the element, or else the
    /// first. Views without a picture of the layer are skipped.
    pub(super) fn texture(
        &self,
        layer: usize,
        element: &Element,
        ranking: &[usize],
    ) -> Option<usize> {
        let points = points(self.views, element);
        let is_pictured = |view: &usize| self.views.view_texture(*view, layer).is_some();
        let mut pictured = ranking.iter().copied().filter(is_pictured);
        let first = pictured.clone().next();
        pictured.find(|&view| shows(self.views, view, &points)).or(first)
    }

    /// Whether part of an element is visible.
    pub(super) fn is_seen(&self, element: &Element) -> bool {
        let points = points(self.views, element);
        points.is_empty() || points.iter().any(|&at| self.played.visibility[at] > 0.5)
    }

    /// Returns the share of each key view in a layer without depth: the mean over the elements, weighted by area. A
    /// view without a picture of the layer has a share, too, and shows nothing.
    pub(super) fn shares(&self, layer: usize) -> Vec<f64> {
        let mut out = vec![0.0; self.views.view_len()];
        let mut whole = 0.0;
        let job = self.played.job(*self.views);
        for (number, element) in elements(self.views, layer) {
            let Some(blend) = job.blend(layer, number) else { continue };
            let area = self.area(&element).abs();
            whole += area;
            blend.views().iter().for_each(|(view, share)| out[*view] += area * f64::from(*share));
        }
        out.iter_mut().for_each(|out| *out /= whole.max(f64::MIN_POSITIVE));
        out
    }

    fn area(&self, element: &Element) -> f64 {
        let corners: Vec<[f64; 3]> =
            element.vertices().iter().map(|&vertex| self.places[vertex]).collect();
        let next = corners.iter().cycle().skip(1);
        corners.iter().zip(next).map(|([ax, ay, _], [bx, by, _])| ax * by - bx * ay).sum()
    }
}

/// Lists the indices of numbers, the largest number first.
pub(super) fn descending(numbers: &[f64]) -> Vec<usize> {
    let mut out: Vec<usize> = (0..numbers.len()).collect();
    out.sort_by(|&a, &b| numbers[b].total_cmp(&numbers[a]));
    out
}

/// Returns the position of a vertex in its layer's picture in a key view, pixels.
pub(super) fn texel(views: &Views<'_>, view: usize, vertex: usize) -> [f32; 2] {
    views.texel(view, vertex).unwrap_or_default()
}

/// Returns the positions of vertices in the picture of a key view, in shares of width and height.
pub(super) fn uvs(
    views: &Views<'_>,
    view: usize,
    vertices: &[usize],
    size: Resolution,
) -> Vec<[f32; 2]> {
    let sides = [size.width, size.height].map(|side| side as f32);
    let places = vertices.iter().map(|&vertex| texel(views, view, vertex));
    places.map(|place| [0, 1].map(|axis| place[axis] / sides[axis])).collect()
}

/// Names a picture after its key view, and after its layer if there are several.
pub(super) fn name(views: &Views<'_>, layer: usize, view: usize) -> String {
    let key = views.view_name(view).unwrap_or_default();
    match views.layer_name(layer) {
        Some(layer) if views.layer_len() > 1 => format!("{layer} {key}"),
        _ => key.to_owned(),
    }
}

/// Lists the elements of a layer with their indices.
pub(super) fn elements<'a>(
    views: &'a Views<'a>,
    layer: usize,
) -> impl Iterator<Item = (usize, Element)> + use<'a> {
    let range = views.layer(layer).map_or(0..0, |layer| layer.first..layer.end);
    range.filter_map(|number| Some((number, views.element(number)?)))
}

/// Splits an element into triangles.
pub(super) fn triangles(element: &Element) -> Vec<[usize; 3]> {
    match *element {
        Element::Triangle(vertices) => vec![vertices],
        Element::Quad([a, b, c, d]) => vec![[a, b, c], [a, c, d]],
    }
}

/// Renumbers the vertices of triangles from 0. Returns the index in the object of each vertex, and the triangles with
/// the new numbers.
pub(super) fn numbered(triangles: &[[usize; 3]]) -> (Vec<usize>, Vec<[usize; 3]>) {
    let (mut vertices, mut places) = (Vec::new(), HashMap::new());
    let mut place = |vertex: usize| {
        *places.entry(vertex).or_insert_with(|| {
            vertices.push(vertex);
            vertices.len() - 1
        })
    };
    let triangles = triangles.iter().map(|corners| corners.map(&mut place)).collect();
    (vertices, triangles)
}

/// Lists the points that coincide with vertices of an element.
fn points(views: &Views<'_>, element: &Element) -> Vec<usize> {
    let vertices = element.vertices().iter();
    vertices.filter_map(|&vertex| views.vertex(vertex)?.point()).collect()
}

/// Whether all points are visible in a key view.
fn shows(views: &Views<'_>, view: usize, points: &[usize]) -> bool {
    points.iter().all(|&point| views.is_visible(view, point) == Some(true))
}
