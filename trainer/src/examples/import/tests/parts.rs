//! Which meshes of a file are which of a scene's.

use super::super::parts::arranged;
use crate::examples::Warning;
use crate::formats::posed_meshes::{Part, PosedMeshes};
use std::ops::Range;

/// Two frames of meshes with some names and counts of vertices, each vertex with its mesh's number as x.
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

/// The meshes by which those of a scene are taken, and those that are left out.
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
        Warning::TargetsLeftOut { meshes } => meshes,
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
fn meshes_are_known_by_their_counts_where_one_alone_has_each() {
    let scene = [("Body", 4), ("Shoes", 3)];
    assert_eq!(picked(&scene, &[("b", 3), ("a", 4)]), (vec![1, 0], vec![]));
    // One mesh of a scene, whose name is not known.
    assert_eq!(picked(&[("Body", 4)], &[("b", 3), ("a", 4)]), (vec![1], vec!["b".to_owned()]));
    assert_eq!(picked(&[("Body", 7)], &[("b", 3), ("a", 4)]), (vec![0, 1], vec![]));
}

#[test]
fn meshes_that_nothing_tells_apart_stay_as_they_are() {
    let scene = [("Left", 3), ("Right", 3)];
    assert_eq!(picked(&scene, &[("a", 3), ("b", 3)]), (vec![0, 1], vec![]));
    assert_eq!(picked(&scene, &[("a", 3), ("b", 2), ("c", 1)]), (vec![0, 1, 2], vec![]));
}
