//! Which vertex of posed meshes is which of a scene's.

use nalgebra::Vector3;
use std::collections::HashMap;

use super::align::{self, Similarity, similarities};
use super::error::ImportError;
use crate::examples::sample::spread;
use crate::formats::posed_meshes::{Part, PosedMeshes};
use crate::mesh::Surface;

/// Farthest that copies of one vertex may lie apart in any frame, over the diagonal.
const COPIES: f64 = 1e-5;
/// Farthest from a vertex at rest that what is taken for it may lie, over the diagonal; files round positions.
const PLACE: f64 = 1e-4;
/// Positions that are looked at before all are.
const SAMPLE: usize = 150;

/// Brings posed meshes to the V vertices of a scene's mesh and their order. They may have these, or the E that an
/// engine has of it; in the scene's order, or, with a rest mesh or reference positions of their own, in any.
///
/// # Errors
/// [`ImportError::TargetVertices`] for another count, [`ImportError::CopiesApart`] where copies of one vertex go
/// different ways.
pub(super) fn matched(
    scene: &Surface<'_>,
    meshes: PosedMeshes,
) -> Result<PosedMeshes, ImportError> {
    let (expected, engine) = (scene.positions.len(), scene.engine_len());
    let found = meshes.vertex_len;
    if found != expected && found != engine {
        return Err(ImportError::TargetVertices { expected, engine, found });
    }
    // The scene's vertices as the meshes have them, where they have its order.
    let one_each = found == expected;
    let own: Vec<usize> = (0..found).map(|v| if one_each { v } else { scene.copy_of(v) }).collect();
    let at_rest: Vec<[f64; 3]> = own.iter().map(|&vertex| scene.positions[vertex]).collect();
    let by_place = match (&meshes.rest, &meshes.reference) {
        (Some(rest), _) => found_by_place(&at_rest, rest),
        (None, Some(reference)) => found_by_reference(&at_rest, reference, &meshes.parts),
        (None, None) => None,
    };
    let mut copies = vec![Vec::new(); expected];
    match by_place {
        // What stands in the place of a vertex, in whatever order.
        Some(places) => {
            for (&vertex, places) in own.iter().zip(places) {
                copies[vertex].extend(places);
            }
        }
        None if one_each => return Ok(meshes),
        None => own.iter().enumerate().for_each(|(copy, &vertex)| copies[vertex].push(copy)),
    }
    check_copies(&meshes, &copies)?;
    let pick = |all: &[[f64; 3]]| -> Vec<[f64; 3]> {
        copies.iter().filter_map(|copies| all.get(*copies.first()?).copied()).collect()
    };
    let rest = meshes.rest.as_deref().map(pick);
    let vertices = meshes.vertices.chunks(found.max(1)).flat_map(pick).collect();
    Ok(PosedMeshes { rest, ..PosedMeshes::bare(expected, vertices) })
}

/// Lists what of another rest mesh stands in the place of each position, in whatever axes and unit; `None` where
/// they follow one another in one order, or where something stands in no place.
fn found_by_place(positions: &[[f64; 3]], rest: &[[f64; 3]]) -> Option<Vec<Vec<usize>>> {
    if align::meshes(positions, rest).is_ok() {
        return None;
    }
    let grid = Grid::new(rest);
    let looked = spread(positions.len(), SAMPLE);
    let near = |similarity: &Similarity, v: usize| {
        let mut point = [positions[v]];
        similarity.move_points(&mut point);
        grid.near(point[0])
    };
    let fits = |similarity: &Similarity| looked.iter().all(|&v| !near(similarity, v).is_empty());
    let similarity = similarities(positions, rest).find(fits)?;
    let places: Vec<_> = (0..positions.len()).map(|v| near(&similarity, v)).collect();
    places.iter().all(|places| !places.is_empty()).then_some(places)
}

/// Lists what has the place of each position among reference positions, mesh by mesh. These may have each axis scaled
/// and be turned, as what is made for textures is (Blender's `Pref` is turned inside the box around the mesh), so that
/// they are compared in boxes of one size. `None` where no mesh has another order.
fn found_by_reference(
    positions: &[[f64; 3]],
    reference: &[[f64; 3]],
    parts: &[Part],
) -> Option<Vec<Vec<usize>>> {
    let mut places: Vec<Vec<usize>> = (0..positions.len()).map(|v| vec![v]).collect();
    let mut is_other = false;
    for Part { range, .. } in parts {
        let boxed = |all: &[[f64; 3]]| in_one_box(&all[range.clone()]);
        let Some(found) = found_by_place(&boxed(positions), &boxed(reference)) else { continue };
        is_other = true;
        for (v, own) in range.clone().zip(found) {
            places[v] = own.into_iter().map(|place| place + range.start).collect();
        }
    }
    is_other.then_some(places)
}

/// Moves points to where each coordinate reaches from -1 to 1.
pub(super) fn in_one_box(points: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let bounds = [0, 1, 2].map(|axis| bounds(points, axis));
    let moved = |point: &[f64; 3]| {
        std::array::from_fn(|axis| {
            let (low, high) = bounds[axis];
            let half = (high - low) / 2.0;
            if half > 0.0 { (point[axis] - low) / half - 1.0 } else { 0.0 }
        })
    };
    points.iter().map(moved).collect()
}

/// Gives the least and the greatest of a coordinate.
fn bounds(points: &[[f64; 3]], axis: usize) -> (f64, f64) {
    let all = points.iter().map(|point| point[axis]);
    (all.clone().fold(f64::MAX, f64::min), all.fold(f64::MIN, f64::max))
}

/// Checks that the copies of each vertex stay together.
fn check_copies(meshes: &PosedMeshes, copies: &[Vec<usize>]) -> Result<(), ImportError> {
    let vertex_len = meshes.vertex_len.max(1);
    let first = meshes.vertices.chunks(vertex_len).next().unwrap_or_default();
    let diagonal = diagonal(meshes.rest.as_deref().unwrap_or(first));
    for (frame, posed) in meshes.vertices.chunks(vertex_len).enumerate() {
        for copies in copies {
            let Some((&first, others)) = copies.split_first() else { continue };
            for &second in others {
                let apart = (Vector3::from(posed[first]) - Vector3::from(posed[second])).norm();
                // What is not finite is told of by its place later.
                if apart > COPIES * diagonal {
                    let percent = 100.0 * apart / diagonal;
                    return Err(ImportError::CopiesApart { first, second, frame, percent });
                }
            }
        }
    }
    Ok(())
}

fn diagonal(points: &[[f64; 3]]) -> f64 {
    [0, 1, 2]
        .map(|axis| bounds(points, axis))
        .iter()
        .map(|(low, high)| (high - low).powi(2))
        .sum::<f64>()
        .sqrt()
}

/// Points by the cells they are in.
struct Grid<'a> {
    points: &'a [[f64; 3]],
    reach: f64,
    cells: HashMap<[i64; 3], Vec<usize>>,
}

impl<'a> Grid<'a> {
    fn new(points: &'a [[f64; 3]]) -> Self {
        let reach = (PLACE * diagonal(points)).max(f64::MIN_POSITIVE);
        let mut cells: HashMap<_, Vec<usize>> = HashMap::new();
        for (number, point) in points.iter().enumerate() {
            cells.entry(cell(point, reach)).or_default().push(number);
        }
        Self { points, reach, cells }
    }

    /// Lists the points within reach of one, ascending.
    fn near(&self, point: [f64; 3]) -> Vec<usize> {
        let middle = cell(&point, self.reach);
        let mut found = Vec::new();
        for place in 0..27 {
            let step = [place % 3, place / 3 % 3, place / 9].map(|step| step - 1);
            let cell: [i64; 3] =
                std::array::from_fn(|axis| middle[axis].saturating_add(step[axis]));
            for &number in self.cells.get(&cell).into_iter().flatten() {
                let apart = Vector3::from(self.points[number]) - Vector3::from(point);
                if apart.norm() <= self.reach {
                    found.push(number);
                }
            }
        }
        found.sort_unstable();
        found
    }
}

fn cell(point: &[f64; 3], size: f64) -> [i64; 3] {
    point.map(|x| (x / size).floor() as i64)
}
