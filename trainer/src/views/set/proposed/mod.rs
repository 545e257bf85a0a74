//! Proposes points for a layer: corners of triangles over the silhouette in one view, and the matching places of the
//! layer's pictures in the other views.

mod affine;
mod bend;

use super::data::{Element, Parameter, Values, ViewSet};
use super::elements::{Silhouette, cropped};
use super::layers::never_shown;
use crate::Error;
use crate::page::picture::Picture;
use affine::{Field, affine_maps};
use bend::smooth_map;
use libm::remainder;
use nalgebra::Vector2;
use rayon::prelude::*;

/// Largest number of triangle sides along the longer side of a layer.
const ACROSS: f64 = 8.0;
/// Smallest side of a triangle, pixels.
const LEAST: f64 = 4.0;
/// Smallest margin around a silhouette that triangles cover, pixels.
const MARGIN: usize = 2;
/// Smallest margin, over the side of a triangle.
const MARGIN_PART: f64 = 0.25;
/// Longer side of the largest matched picture, pixels. Larger pictures are shrunk.
const SIDE: f64 = 128.0;
/// Relative difference below which two sums of distances are equal.
const EQUAL: f64 = 1e-9;

/// Adds points and elements to layers without points.
///
/// - `layers`: indices of the layers.
///
/// # Errors
/// A picture cannot be read or is damaged, or no view shows a layer.
pub(super) fn add(set: &mut ViewSet, layers: &[usize]) -> Result<(), Error> {
    let keys = set.key_views();
    for &layer in layers {
        let Proposed { points, triangles } = proposed(set, layer, &keys)?;
        let first = set.point_len();
        let len = points.iter().flatten().map(Vec::len).next().unwrap_or(0);
        for map in &mut set.maps {
            for view in map.train.iter_mut().chain(&mut map.test) {
                view.points.resize(first + len, None);
                // In views without pictures the visibility is unknown.
                view.visible.resize(first + len, !view.is_key());
            }
        }
        for (&(map, view), points) in keys.iter().zip(points) {
            let (view, Some(points)) = (&mut set.maps[map].train[view], points) else { continue };
            view.visible[first..].fill(true);
            view.points.truncate(first);
            view.points.extend(points.into_iter().map(Some));
        }
        let own = &mut set.layers[layer];
        own.points = (first..first + len).collect();
        let triangle = |face: [usize; 3]| Element::Triangle(face.map(|corner| first + corner));
        own.elements = triangles.into_iter().map(triangle).collect();
    }
    Ok(())
}

/// Proposed points of a layer.
struct Proposed {
    /// Positions of the points by key view; `None` if the layer has no picture, or an empty one.
    points: Vec<Option<Vec<[f64; 2]>>>,
    triangles: Vec<[usize; 3]>,
}

/// A picture of a layer, cropped to its covered pixels.
struct Cropped {
    key: usize,
    picture: Picture,
    corner: [usize; 2],
}

fn proposed(set: &ViewSet, layer: usize, keys: &[(usize, usize)]) -> Result<Proposed, Error> {
    let mut pictures = Vec::new();
    for (key, &own) in keys.iter().enumerate() {
        let Some(image) = set.view(own).picture(layer) else { continue };
        let cut = cropped(&image.load(set.size)?, 0);
        pictures.extend(cut.map(|(picture, corner)| Cropped { key, picture, corner }));
    }
    let sides = |own: &Cropped| own.picture.size.width.max(own.picture.size.height);
    let Some(longest) = pictures.iter().map(sides).max() else {
        return Err(never_shown(&set.layers[layer].name));
    };
    let scale = (SIDE / longest as f64).min(1.0);
    let field = |Cropped { picture, corner, .. }: &Cropped| {
        let size = [picture.size.width, picture.size.height];
        // Averages squares of pixels first, so that the blur in f64 stays small.
        let side = (0.5 / scale).max(1.0) as usize;
        Field::new(&picture.rgba, size, *corner, side).scaled(scale * side as f64)
    };
    let fields: Vec<Field> = pictures.par_iter().map(field).collect();
    let rest = central(set, &pictures.iter().map(|own| keys[own.key]).collect::<Vec<_>>());
    let reference = &pictures[rest];
    let across = (sides(reference) as f64 / LEAST).clamp(1.0, ACROSS);
    let side = sides(reference) as f64 / across;
    let margin = MARGIN.max((MARGIN_PART * side).ceil() as usize);
    let Silhouette { corners, faces } = Silhouette::of(&reference.picture, across, margin)?;
    let corner = Vector2::from(reference.corner.map(|x| x as f64));
    let places: Vec<Vector2<f64>> =
        corners.iter().map(|place| Vector2::from(*place) + corner).collect();
    let matched = |(number, other): (usize, &Field)| -> Vec<[f64; 2]> {
        if number == rest {
            return places.iter().map(|place| (*place).into()).collect();
        }
        let map = smooth_map(&fields[rest], other, &affine_maps(&fields[rest], other));
        let place = |place: &Vector2<f64>| {
            let found = map.as_ref().map_or(*place, |map| map.at(place * scale).0 / scale);
            found.into()
        };
        places.iter().map(place).collect()
    };
    let found: Vec<Vec<[f64; 2]>> = fields.par_iter().enumerate().map(matched).collect();
    let mut points = vec![None; keys.len()];
    for (Cropped { key, .. }, found) in pictures.iter().zip(found) {
        points[*key] = Some(found);
    }
    Ok(Proposed { points, triangles: faces })
}

/// Chooses the view whose parameters are nearest to those of the other views of its motion. The first of equals wins.
///
/// - `keys`: indices of the motion and the view. The chosen view is in the first motion.
fn central(set: &ViewSet, keys: &[(usize, usize)]) -> usize {
    let Some(&(first, _)) = keys.first() else { return 0 };
    let examples = &set.maps[first];
    let own = keys.iter().filter(|(map, _)| *map == first);
    let views: Vec<&Values> = own.map(|(_, view)| &examples.train[*view].values).collect();
    let mut sums = vec![0.0; views.len()];
    for parameter in &examples.parameters {
        let is_angle = matches!(parameter, Parameter::Rotation { .. });
        for name in parameter.names() {
            let value = |view: &Values| view.get(name).copied().unwrap_or_default();
            let square = |a: &Values, b: &Values| {
                let change = value(a) - value(b);
                (if is_angle { remainder(change, 360.0) } else { change }).powi(2)
            };
            let rows: Vec<Vec<f64>> =
                views.iter().map(|a| views.iter().map(|b| square(a, b)).collect()).collect();
            let most = rows.iter().flatten().copied().fold(f64::MIN_POSITIVE, f64::max);
            for (sum, row) in sums.iter_mut().zip(&rows) {
                *sum += row.iter().sum::<f64>() / most;
            }
        }
    }
    let least = sums.iter().copied().fold(f64::INFINITY, f64::min);
    sums.iter().position(|sum| *sum <= least * (1.0 + EQUAL)).unwrap_or(0)
}
