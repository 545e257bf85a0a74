//! Tests of posed meshes: reading them, and matching their meshes and vertices with a scene.

use super::super::matched::{arranged, in_one_box, matched};
use super::super::npz;
use super::super::targets::{TargetMeshes, read};
use crate::ErrorKind;
use crate::examples::testing::triangle;
use crate::examples::{Split, Warning};
use crate::formats::posed_meshes::{Part, PosedMeshes};
use crate::formats::save_pc2;
use crate::formats::testing::Folder;
use crate::mesh::{EngineMesh, Surface};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::ops::Range;
use std::path::Path;

const VERTICES: usize = 40;
const FRAMES: usize = 3;
/// Vertices with a second engine vertex; the copies come last, as in glTF files.
const TWICE: [usize; 3] = [3, 7, 20];

/// Creates random points without symmetry, and their positions in some frames.
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

/// Copies positions to engine vertices, frame by frame.
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

/// Converts y up to z up, metres to centimetres, and translates.
fn converted(all: &[[f64; 3]]) -> Vec<[f64; 3]> {
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
    let there = converted(&posed);
    for (len, posed, at_rest) in [
        (VERTICES, there.clone(), converted(&rest)),
        (VERTICES + TWICE.len(), of_engine(&there), of_engine(&converted(&rest))),
    ] {
        let [posed, at_rest] = [posed, at_rest].map(|all| reversed(len, &all));
        let found = matched(&scene, meshes(len, posed, Some(at_rest))).unwrap();
        assert_eq!(found.vertex_len, VERTICES);
        assert_eq!((found.vertices, found.rest), (there.clone(), Some(converted(&rest))));
    }
}

#[test]
fn copies_that_separate_are_named() {
    let ((rest, posed), engine) = (cloud(), split());
    let scene = Surface { positions: &rest, triangles: &[], engine: Some(&engine) };
    let len = VERTICES + TWICE.len();
    let diagonal = 14_f64.sqrt();
    for (apart, parts) in [(0.2e-5, false), (0.01, true)] {
        let mut other = of_engine(&posed);
        other[len + VERTICES + 1][2] += apart * diagonal;
        let result = matched(&scene, meshes(len, other, Some(of_engine(&rest))));
        let error = result.err().map(|error| error.to_string()).unwrap_or_default();
        let words = "frame 1: its vertices 7 and 41 are copies of one vertex of the scene's mesh, split along a seam, but \
                     lie 1.";
        assert_eq!(error.starts_with(words), parts, "{error}");
    }
}

/// Texture coordinates replace a rest mesh: rotated inside its box, as in Blender.
#[test]
fn another_order_is_matched_by_reference_positions_mesh_by_mesh() {
    let (rest, posed) = cloud();
    let scene = Surface { positions: &rest, triangles: &[], engine: None };
    let half = VERTICES / 2;
    let turned = |all: &[[f64; 3]]| -> Vec<[f64; 3]> {
        let turned = all.chunks(half).flat_map(|part| {
            let unit = in_one_box(part);
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
    // Reference positions of another mesh are ignored.
    let other = PosedMeshes { reference: Some(posed[..VERTICES].to_vec()), ..found };
    assert_eq!(matched(&scene, other).unwrap().vertices, shuffled(&posed));
}

/// Creates two frames of meshes with names and numbers of vertices; x is the number of the vertex's mesh.
fn file(meshes: &[(&str, usize)]) -> PosedMeshes {
    let mut parts = Vec::new();
    let mut frame = Vec::new();
    for (number, (name, len)) in meshes.iter().enumerate() {
        let first = frame.len();
        frame.resize(first + len, [number as f64, 0.0, 0.0]);
        let names = vec![name.to_string(), format!("{name}Shape")];
        parts.push(Part { names, range: first..frame.len() });
    }
    PosedMeshes { parts, ..PosedMeshes::bare(frame.len(), frame.repeat(2)) }
}

fn scene(meshes: &[(&str, usize)]) -> (Vec<(String, Range<usize>)>, usize) {
    let parts = file(meshes).parts;
    let ranges = parts.into_iter().map(|part| (part.names[0].clone(), part.range));
    (ranges.collect(), meshes.iter().map(|(_, len)| len).sum())
}

/// Returns the numbers of the meshes matched with a scene, and the names of the ignored meshes.
fn picked(of_scene: &[(&str, usize)], of_file: &[(&str, usize)]) -> (Vec<usize>, Vec<String>) {
    let (ranges, vertex_len) = scene(of_scene);
    let ranges = if ranges.len() < 2 { Vec::new() } else { ranges };
    let mut warnings = Vec::new();
    let found = arranged(&ranges, vertex_len, file(of_file), &mut warnings);
    assert_eq!(found.vertices.len(), 2 * found.vertex_len);
    let (first, second) = found.vertices.split_at(found.vertex_len);
    assert_eq!(first, second);
    let numbers = found.parts.iter().map(|part| {
        let own = &first[part.range.clone()];
        assert!(own.iter().all(|x| x == &own[0]));
        own[0][0] as usize
    });
    let left_out = warnings.into_iter().flat_map(|warning| match warning {
        Warning::TargetsLeftOut(meshes) => meshes,
        other => panic!("{other}"),
    });
    (numbers.collect(), left_out.collect())
}

#[test]
fn meshes_are_sorted_by_name() {
    let scene = [("Body", 4), ("Left.Shoe", 3), ("Right.Shoe", 3)];
    let sorted = [("Right_Shoe", 3), ("Body", 4), ("Left_Shoe", 3)];
    assert_eq!(picked(&scene, &sorted), (vec![1, 2, 0], vec![]));
    let with_eyes = [("Eyes", 3), ("Body", 4), ("Left_Shoe", 3), ("Right_Shoe", 3)];
    assert_eq!(picked(&scene, &with_eyes), (vec![1, 2, 3], vec!["Eyes".to_owned()]));
}

#[test]
fn meshes_are_matched_by_unique_counts() {
    let scene = [("Body", 4), ("Shoes", 3)];
    assert_eq!(picked(&scene, &[("b", 3), ("a", 4)]), (vec![1, 0], vec![]));
    // The scene's single mesh has no name.
    assert_eq!(picked(&[("Body", 4)], &[("b", 3), ("a", 4)]), (vec![1], vec!["b".to_owned()]));
    assert_eq!(picked(&[("Body", 7)], &[("b", 3), ("a", 4)]), (vec![0, 1], vec![]));
}

#[test]
fn ambiguous_meshes_stay_as_they_are() {
    let scene = [("Left", 3), ("Right", 3)];
    assert_eq!(picked(&scene, &[("a", 3), ("b", 3)]), (vec![0, 1], vec![]));
    assert_eq!(picked(&scene, &[("a", 3), ("b", 2), ("c", 1)]), (vec![0, 1, 2], vec![]));
}

#[track_caller]
fn refused(path: &Path, at: &Path, expected: &str) {
    let error = read(path).expect_err("the file should be refused");
    assert_eq!((error.file(), error.message()), (Some(at), expected));
}

#[test]
fn arrays_are_read_as_posed_meshes() {
    let folder = Folder::new("arrays");
    let mut examples = triangle(4);
    examples.vertices[5] = [0.25, -3.5, 1e-3];
    examples.split[2] = Split::Extreme;
    let file = folder.0.join("set.npz");
    npz::save_npz(&file, &examples, &[]).unwrap();
    let meshes = PosedMeshes {
        rest: Some(examples.rest.clone()),
        triangles: Some(examples.triangles.clone()),
        ..PosedMeshes::bare(3, examples.vertices.clone())
    };
    let split = Some(examples.split.clone());
    let expected = TargetMeshes { split, ..TargetMeshes::new(&file, meshes) };
    assert_eq!(read(&file).unwrap(), expected);
}

#[test]
fn endings_may_be_in_capitals() {
    let folder = Folder::new("capitals");
    let file = folder.0.join("a.PC2");
    let vertices = vec![[0.5, -0.25, 1024.0], [1.0, 2.0, 3.0]];
    save_pc2(&file, 1, &vertices).unwrap();
    let meshes = PosedMeshes::bare(1, vertices);
    assert_eq!(read(&file).unwrap(), TargetMeshes::new(&file, meshes));
}

#[test]
fn other_kinds_of_files_are_refused_by_name() {
    let folder = Folder::new("kinds");
    let kinds = "expected a file that ends in .abc, .pc2, .mdd, .npz, .glb, .gltf or .obj";
    for (name, found) in [("a.txt", ".txt"), ("a", "none"), ("a.FBX", ".fbx")] {
        let path = folder.0.join(name);
        let expected = format!("{kinds}, found {found}");
        refused(&path, &path, &expected);
    }
    let expected = "is a folder without an .obj file; export one a frame, numbered: pose_1.obj, \
                    pose_2.obj";
    refused(&folder.0, &folder.0, expected);
    for name in ["a.pc2", "a.mdd", "a.npz"] {
        let error = read(&folder.0.join(name)).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::Read);
        assert_eq!(error.file(), Some(folder.0.join(name).as_path()));
    }
    let error = read(&folder.0.join("none/a1.obj")).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Read);
    assert_eq!(error.file(), Some(folder.0.join("none").as_path()));
}
