//! Points proposed for a layer: corners of triangles over its silhouette in one view, and where the layer's pictures
//! match them in the others.

mod affine;
mod bend;
mod field;
mod lattice;

use super::data::ViewSet;
use super::elements::Element;
use super::error::SetError;
use super::silhouette::Silhouette;
use crate::page::camera::Resolution;
use crate::page::picture::Picture;
use affine::affine;
use bend::bent;
use field::{Field, Moments};
use nalgebra::Vector2;
use rayon::prelude::*;

/// Sides of triangles along the longer side of a layer, at most, and how long each is at the least, pixels.
const ACROSS: f64 = 8.0;
const LEAST: f64 = 4.0;
/// Pixels around a silhouette that triangles cover at the least, and as a part of their sides.
const MARGIN: usize = 2;
const MARGIN_PART: f64 = 0.25;
/// Longer side of the largest picture that is matched, pixels. Larger ones are shrunk.
const SIDE: f64 = 128.0;
/// Samples of a picture across and down for the choice of the reference, and how far they reach, in radii.
const SAMPLES: i32 = 16;
const REACH: f64 = 2.5;

/// Adds points and elements to layers without points.
///
/// - `layers`: the layers, by number.
///
/// # Errors
/// [`SetError`] of a picture, and [`SetError::Layer`]: no view shows a layer.
pub(super) fn add(set: &mut ViewSet, layers: &[usize]) -> Result<(), SetError> {
    let keys = set.key_views();
    let mut found = Vec::new();
    for &layer in layers {
        found.push(proposed(set, layer, &keys)?);
    }
    for (&layer, Proposed { points, triangles }) in layers.iter().zip(found) {
        let first = set.point_len();
        let len = points.iter().flatten().map(Vec::len).next().unwrap_or(0);
        for map in &mut set.maps {
            for view in map.train.iter_mut().chain(&mut map.test) {
                view.points.resize(first + len, None);
                view.visible.resize(first + len, false);
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

/// Points of a layer.
struct Proposed {
    /// By key view where the points are; `None` where the layer has no picture, or an empty one.
    points: Vec<Option<Vec<[f64; 2]>>>,
    triangles: Vec<[usize; 3]>,
}

/// A picture of a layer, cut to its covered pixels.
struct Shown {
    key: usize,
    picture: Picture,
    corner: [usize; 2],
}

fn proposed(set: &ViewSet, layer: usize, keys: &[(usize, usize)]) -> Result<Proposed, SetError> {
    let mut shown = Vec::new();
    for (key, &(map, view)) in keys.iter().enumerate() {
        let Some(image) = set.maps[map].train[view].picture(layer) else { continue };
        let cut = cropped(&image.load(set.size)?);
        shown.extend(cut.map(|(picture, corner)| Shown { key, picture, corner }));
    }
    let sides = |own: &Shown| own.picture.size.width.max(own.picture.size.height);
    let Some(longest) = shown.iter().map(sides).max() else {
        let what = "no view has a picture of it: name one, or leave it out".to_owned();
        return Err(SetError::Layer { layer: set.layers[layer].name.clone(), what });
    };
    let scale = (SIDE / longest as f64).min(1.0);
    let field = |Shown { picture, corner, .. }: &Shown| {
        let size = [picture.size.width, picture.size.height];
        Field::new(&picture.rgba, size, *corner).scaled(scale)
    };
    let fields: Vec<Field> = shown.par_iter().map(field).collect();
    let rest = central(&fields);
    let reference = &shown[rest];
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
        let start = affine(&fields[rest], other);
        let map = bent(&fields[rest], other, &start);
        places.iter().map(|place| (map.at(place * scale).0 / scale).into()).collect()
    };
    let found: Vec<Vec<[f64; 2]>> = fields.par_iter().enumerate().map(matched).collect();
    let mut points = vec![None; keys.len()];
    for (Shown { key, .. }, found) in shown.iter().zip(found) {
        points[*key] = Some(found);
    }
    Ok(Proposed { points, triangles: faces })
}

/// Cuts a picture to its covered pixels; `None` if there are none.
fn cropped(whole: &Picture) -> Option<(Picture, [usize; 2])> {
    let [width, height] = [whole.size.width, whole.size.height];
    let covered = (0..width * height).filter(|at| whole.rgba[4 * at + 3] > 0);
    let ends = covered.fold(None, |ends: Option<[[usize; 2]; 2]>, at| {
        let own = [at % width, at / width];
        let [low, high] = ends.unwrap_or([own, own]);
        let axes = [0, 1];
        Some([
            axes.map(|axis| low[axis].min(own[axis])),
            axes.map(|axis| high[axis].max(own[axis])),
        ])
    });
    let [low, high] = ends?;
    let size = Resolution { width: high[0] + 1 - low[0], height: high[1] + 1 - low[1] };
    let row = |y: usize| {
        let first = y * width + low[0];
        whole.rgba[4 * first..4 * (first + size.width)].iter().copied()
    };
    Some((Picture { size, rgba: (low[1]..=high[1]).flat_map(row).collect() }, low))
}

/// Chooses the picture that is nearest to all others, each about its own centre; the first of equals.
fn central(fields: &[Field]) -> usize {
    let moments: Vec<Moments> = fields.iter().map(Field::moments).collect();
    let radius = moments.iter().map(Moments::radius).fold(0.0, f64::max);
    let step = 2.0 * REACH * radius / f64::from(SAMPLES);
    let sampled = |(field, own): (&Field, &Moments)| -> Vec<f64> {
        let blurred = field.blurred(0.5 * step);
        let place = |k: i32| {
            let [x, y] = [k % SAMPLES, k / SAMPLES].map(|k| f64::from(k) + 0.5);
            own.mean + Vector2::new(x * step, y * step) - Vector2::repeat(REACH * radius)
        };
        (0..SAMPLES * SAMPLES).flat_map(|k| blurred.sample(place(k)).0).collect()
    };
    let all: Vec<Vec<f64>> = fields.iter().zip(&moments).map(sampled).collect();
    let apart = |own: &Vec<f64>| -> f64 {
        let square = |other: &Vec<f64>| -> f64 {
            own.iter().zip(other).map(|(a, b)| (a - b) * (a - b)).sum()
        };
        all.iter().map(square).sum()
    };
    let sums: Vec<f64> = all.iter().map(apart).collect();
    (0..sums.len()).min_by(|a, b| sums[*a].total_cmp(&sums[*b])).unwrap_or(0)
}
