//! Posed meshes of a scene's vertices or of an engine's, in any order.

use super::super::matched::matched;
use crate::formats::posed_meshes::{Part, PosedMeshes};
use crate::mesh::{EngineMesh, Surface};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const VERTICES: usize = 40;
const FRAMES: usize = 3;
/// Vertices that an engine has twice, the copies behind the others as a glTF file may have them.
const TWICE: [usize; 3] = [3, 7, 20];

/// A cloud without symmetry, and its positions in some frames.
fn cloud() -> (Vec<[f64; 3]>, Vec<[f64; 3]>) {
    let mut random = ChaCha8Rng::seed_from_u64(5);
    let mut within = |most: f64| random.random_range(0.0..most);
    let rest: Vec<[f64; 3]> =
        (0..VERTICES).map(|_| [within(3.0), within(2.0), within(1.0)]).collect();
    let posed = (0..FRAMES * VERTICES).map(|_| [within(3.0), within(2.0), within(1.0)]).collect();
    (rest, posed)
}

fn split() -> EngineMesh {
    EngineMesh {
        copy_of: (0..VERTICES).chain(TWICE).collect(),
        triangles: Vec::new(),
        normals: None,
        tangents: None,
        uv: None,
    }
}

/// What an engine has of positions, frame by frame.
fn of_engine(all: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let copies = split().copy_of;
    all.chunks(VERTICES)
        .flat_map(|frame| copies.iter().map(|&v| frame[v]).collect::<Vec<_>>())
        .collect()
}

fn meshes(vertex_len: usize, vertices: Vec<[f64; 3]>, rest: Option<Vec<[f64; 3]>>) -> PosedMeshes {
    PosedMeshes { rest, ..PosedMeshes::bare(vertex_len, vertices) }
}

/// Reverses the order of the vertices in each frame.
fn reversed(vertex_len: usize, all: &[[f64; 3]]) -> Vec<[f64; 3]> {
    all.chunks(vertex_len)
        .flat_map(|frame| frame.iter().rev().copied().collect::<Vec<_>>())
        .collect()
}

/// y up to z up, metres to centimetres, and to another place.
fn elsewhere(all: &[[f64; 3]]) -> Vec<[f64; 3]> {
    all.iter().map(|&[x, y, z]| [100.0 * x + 7.0, -100.0 * z, 100.0 * y]).collect()
}

#[test]
fn either_count_is_matched_by_number() {
    let ((rest, posed), engine) = (cloud(), split());
    let scene = Surface { positions: &rest, triangles: &[], engine: Some(&engine) };
    let len = VERTICES + TWICE.len();
    let own = meshes(VERTICES, posed.clone(), None);
    assert_eq!(matched(&scene, own.clone()).unwrap(), own);
    assert_eq!(matched(&scene, meshes(len, of_engine(&posed), None)).unwrap(), own);
    let found = matched(&scene, meshes(len, of_engine(&posed), Some(of_engine(&rest)))).unwrap();
    assert_eq!((found.vertices, found.rest), (posed, Some(rest.clone())));
    let error = matched(&scene, meshes(39, Vec::new(), None)).unwrap_err().to_string();
    let words = "holds meshes of 39 vertices, the scene's mesh has 40, for engines 43: export both";
    assert!(error.starts_with(words), "{error}");
}

#[test]
fn another_order_is_matched_by_place_in_any_axes_and_unit() {
    let ((rest, posed), engine) = (cloud(), split());
    let scene = Surface { positions: &rest, triangles: &[], engine: Some(&engine) };
    let there = elsewhere(&posed);
    for (len, posed, at_rest) in [
        (VERTICES, there.clone(), elsewhere(&rest)),
        (VERTICES + TWICE.len(), of_engine(&there), of_engine(&elsewhere(&rest))),
    ] {
        let [posed, at_rest] = [posed, at_rest].map(|all| reversed(len, &all));
        let found = matched(&scene, meshes(len, posed, Some(at_rest))).unwrap();
        assert_eq!(found.vertex_len, VERTICES);
        assert_eq!((found.vertices, found.rest), (there.clone(), Some(elsewhere(&rest))));
    }
}

#[test]
fn copies_that_part_are_named() {
    let ((rest, posed), engine) = (cloud(), split());
    let scene = Surface { positions: &rest, triangles: &[], engine: Some(&engine) };
    let len = VERTICES + TWICE.len();
    let diagonal = 14_f64.sqrt();
    for (apart, parts) in [(0.2e-5, false), (0.01, true)] {
        let mut other = of_engine(&posed);
        other[len + VERTICES + 1][2] += apart * diagonal;
        let result = matched(&scene, meshes(len, other, Some(of_engine(&rest))));
        let error = result.err().map(|error| error.to_string()).unwrap_or_default();
        let words =
            "its vertices 7 and 41 are one of the scene's mesh, split along a seam, but lie 1.";
        assert!(
            error.starts_with(words) == parts && error.contains("in frame 1") == parts,
            "{error}"
        );
    }
}

/// Coordinates for textures stand in for a rest mesh: turned inside the box around it, as Blender has them.
#[test]
fn another_order_is_known_by_reference_positions_mesh_by_mesh() {
    let (rest, posed) = cloud();
    let scene = Surface { positions: &rest, triangles: &[], engine: None };
    let half = VERTICES / 2;
    let turned = |all: &[[f64; 3]]| -> Vec<[f64; 3]> {
        let turned = all.chunks(half).flat_map(|part| {
            let unit = super::super::matched::in_one_box(part);
            unit.into_iter().map(|[x, y, z]| [3.0 * x + 1.0, 2.0 * z, -0.5 * y]).collect::<Vec<_>>()
        });
        turned.collect()
    };
    // The first half keeps its order.
    let shuffled = |all: &[[f64; 3]]| -> Vec<[f64; 3]> {
        let frames = all.chunks(VERTICES);
        frames
            .flat_map(|all| [all[..half].to_vec(), reversed(half, &all[half..])].concat())
            .collect()
    };
    let part = |range| Part { names: Vec::new(), range };
    let found = PosedMeshes {
        reference: Some(shuffled(&turned(&rest))),
        parts: vec![part(0..half), part(half..VERTICES)],
        ..meshes(VERTICES, shuffled(&posed), None)
    };
    let ordered = matched(&scene, found.clone()).unwrap();
    assert_eq!((ordered.vertices, ordered.rest), (posed.clone(), None));
    // What is no reference of this mesh says nothing.
    let other = PosedMeshes { reference: Some(posed[..VERTICES].to_vec()), ..found };
    assert_eq!(matched(&scene, other).unwrap().vertices, shuffled(&posed));
}
