//! Matches the meshes and vertices of posed meshes with a scene's.

use super::align::{self, Similarity, similarities};
use crate::Error;
use crate::examples::Warning;
use crate::examples::data::{bounds, diagonal, spread};
use crate::formats::posed_meshes::{Part, PosedMeshes};
use crate::mesh::Surface;
use crate::numeric::grid::Grid;
use nalgebra::Vector3;
use std::collections::HashSet;
use std::ops::Range;

/// Largest distance between copies of a vertex in any frame, relative to the diagonal.
const COPIES: f64 = 1e-5;
/// Largest distance between matched rest positions, relative to the diagonal; files round positions.
const PLACE: f64 = 1e-4;
/// Positions sampled for candidate similarities.
const SAMPLE: usize = 150;

/// Selects and sorts the meshes of a file into the scene's order: by name, or by a unique number of vertices. If
/// neither identifies the meshes, returns them unchanged.
///
/// - `ranges`: names and vertex ranges of the scene's meshes.
/// - `vertex_len`: number of the scene's vertices.
pub(super) fn arranged(
    ranges: &[(String, Range<usize>)],
    vertex_len: usize,
    meshes: PosedMeshes,
    warnings: &mut Vec<Warning>,
) -> PosedMeshes {
    let parts = &meshes.parts;
    let Some(picked) = picked(ranges, vertex_len, meshes.vertex_len, parts) else { return meshes };
    if picked.iter().copied().eq(0..parts.len()) {
        return meshes;
    }
    let left_out = (0..parts.len()).filter(|part| !picked.contains(part));
    let left_out: Vec<String> =
        left_out.filter_map(|part| parts[part].names.first().cloned()).collect();
    if !left_out.is_empty() {
        warnings.push(Warning::TargetsLeftOut(left_out));
    }
    let picked: Vec<&Part> = picked.into_iter().map(|part| &parts[part]).collect();
    let pick = |all: &[[f64; 3]]| -> Vec<[f64; 3]> {
        picked.iter().flat_map(|part| &all[part.range.clone()]).copied().collect()
    };
    let mut end = 0;
    let parts = picked.iter().map(|part| {
        let begin = end;
        end += part.range.len();
        Part { names: part.names.clone(), range: begin..end }
    });
    let parts: Vec<Part> = parts.collect();
    PosedMeshes {
        rest: meshes.rest.as_deref().map(pick),
        reference: meshes.reference.as_deref().map(pick),
        parts,
        ..PosedMeshes::bare(end, meshes.vertices.chunks(meshes.vertex_len).flat_map(pick).collect())
    }
}

/// Reorders posed meshes to the V vertices of a scene's mesh. Posed meshes may have V vertices or E engine vertices.
/// With a rest mesh or reference positions they may be in any order, otherwise in the scene's order.
///
/// # Errors
/// The count of vertices is another one, or copies of a vertex separate.
pub(super) fn matched(scene: &Surface<'_>, meshes: PosedMeshes) -> Result<PosedMeshes, Error> {
    let (expected, engine) = (scene.positions.len(), scene.engine_len());
    let found = meshes.vertex_len;
    if found != expected && found != engine {
        let expected = match engine == expected {
            true => expected.to_string(),
            false => format!("{expected}, for engines {engine}"),
        };
        return Err(Error::mismatch(format!(
            "holds meshes of {found} vertices, the scene's mesh has {expected}: export both from one mesh without \
             modifiers that change its vertices; glTF splits vertices along seams of texture and normals, FBX does not"
        )));
    }
    // Scene vertex of each posed vertex, if both have the same order.
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
        // Posed vertices at the position of each scene vertex, in any order.
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

/// Selects a part for each of the scene's meshes; `None` if any is not identified.
fn picked(
    ranges: &[(String, Range<usize>)],
    vertex_len: usize,
    found: usize,
    parts: &[Part],
) -> Option<Vec<usize>> {
    let one_of = |fits: &dyn Fn(&Part) -> bool| {
        let mut fitting = (0..parts.len()).filter(|&part| fits(&parts[part]));
        fitting.next().filter(|_| fitting.next().is_none())
    };
    let of_len = |len: usize| one_of(&|part| part.range.len() == len);
    if ranges.is_empty() {
        return (found != vertex_len).then(|| of_len(vertex_len)).flatten().map(|part| vec![part]);
    }
    let of = |(name, range): &(String, Range<usize>)| {
        let is_called = |part: &Part| part.names.iter().any(|own| plain(own) == plain(name));
        let named = one_of(&|part| part.range.len() == range.len() && is_called(part));
        named.or_else(|| of_len(range.len()))
    };
    let picked: Vec<usize> = ranges.iter().map(of).collect::<Option<_>>()?;
    let once: HashSet<&usize> = picked.iter().collect();
    (once.len() == picked.len()).then_some(picked)
}

/// Replaces the characters that programs replace in names.
fn plain(name: &str) -> String {
    name.chars().map(|c| if c.is_alphanumeric() { c } else { '_' }).collect()
}

/// Lists the vertices of another rest mesh at each position, up to a similarity. `None` if both meshes have the same
/// order, or if a position has no vertex.
fn found_by_place(positions: &[[f64; 3]], rest: &[[f64; 3]]) -> Option<Vec<Vec<usize>>> {
    if align::meshes(positions, rest).is_ok() {
        return None;
    }
    let grid = Grid::new(rest, PLACE * diagonal(rest.iter().copied()));
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

/// Lists the vertices with the reference position of each scene position, mesh by mesh. Reference positions serve
/// textures and may be scaled per axis and rotated. For example, Blender's `Pref` is rotated inside the mesh's bounding
/// box. So both are compared after scaling to a common box. `None` if every mesh has the scene's order.
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

/// Scales points so that each coordinate ranges from -1 to 1.
pub(super) fn in_one_box(points: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let [low, high] = bounds(points.iter().copied());
    let moved = |point: &[f64; 3]| {
        [0, 1, 2].map(|axis| {
            let half = (high[axis] - low[axis]) / 2.0;
            if half > 0.0 { (point[axis] - low[axis]) / half - 1.0 } else { 0.0 }
        })
    };
    points.iter().map(moved).collect()
}

/// Checks that the copies of each vertex coincide in all frames.
fn check_copies(meshes: &PosedMeshes, copies: &[Vec<usize>]) -> Result<(), Error> {
    let vertex_len = meshes.vertex_len.max(1);
    let first = meshes.vertices.chunks(vertex_len).next().unwrap_or_default();
    let diagonal = diagonal(meshes.rest.as_deref().unwrap_or(first).iter().copied());
    for (frame, posed) in meshes.vertices.chunks(vertex_len).enumerate() {
        for copies in copies {
            let Some((&first, others)) = copies.split_first() else { continue };
            for &second in others {
                let apart = (Vector3::from(posed[first]) - Vector3::from(posed[second])).norm();
                // NaN passes this comparison; a later check reports it with its location.
                if apart > COPIES * diagonal {
                    let percent = 100.0 * apart / diagonal;
                    let error = Error::mismatch(format!(
                        "its vertices {first} and {second} are copies of one vertex of the scene's mesh, split along a \
                         seam, but lie {percent:.4} % of the diagonal apart, expected 0.001 % at most; export both \
                         from one mesh"
                    ));
                    return Err(error.in_frame(frame));
                }
            }
        }
    }
    Ok(())
}
