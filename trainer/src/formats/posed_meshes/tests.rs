//! Tests of posed meshes: read back, and refused.

use std::path::{Path, PathBuf};

use super::cache::save_pc2;
use super::sequence::{missing, read};
use super::{PosedMeshes, cache};
use crate::formats::testing::{Folder, spoil};
use crate::{Error, ErrorKind};

/// Two frames of three points, as numbers that single precision holds exactly.
const FRAMES: [[f64; 3]; 6] = [
    [0.0, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.5, -0.25, 1024.0],
    [1.5, -0.0, 3e-5f32 as f64],
    [-7.0, 8.0, 9.0],
];

fn pc2_bytes(points: i32, frames: i32, version: i32) -> Vec<u8> {
    let mut bytes = b"POINTCACHE2\0".to_vec();
    bytes.extend([version, points].map(i32::to_le_bytes).as_flattened());
    bytes.extend([1.0f32, 0.5].map(f32::to_le_bytes).as_flattened());
    bytes.extend(frames.to_le_bytes());
    bytes.extend(FRAMES.as_flattened().iter().flat_map(|&number| (number as f32).to_le_bytes()));
    bytes
}

fn mdd_bytes(points: i32, frames: i32) -> Vec<u8> {
    let mut bytes = [frames, points].map(i32::to_be_bytes).as_flattened().to_vec();
    bytes.extend([0.0f32, 0.04].map(f32::to_be_bytes).as_flattened());
    bytes.extend(FRAMES.as_flattened().iter().flat_map(|&number| (number as f32).to_be_bytes()));
    bytes
}

fn bare(vertex_len: usize, vertices: &[[f64; 3]]) -> PosedMeshes {
    PosedMeshes::bare(vertex_len, vertices.to_vec())
}

#[track_caller]
fn refused(path: &Path, at: &Path, expected: &str) {
    let error = read(path).expect_err("the file should be refused");
    assert_eq!((error.file(), error.message()), (Some(at), expected));
}

#[test]
fn point_caches_are_read_in_either_order_of_bytes() {
    let folder = Folder::new("caches");
    let little = folder.write("a.pc2", pc2_bytes(3, 2, 1));
    assert_eq!(cache::read_pc2(&little).unwrap(), bare(3, &FRAMES));
    let big = folder.write("a.mdd", mdd_bytes(3, 2));
    assert_eq!(cache::read_mdd(&big).unwrap(), bare(3, &FRAMES));
    assert_eq!(cache::parse_pc2(&pc2_bytes(2, 3, 1)).unwrap().vertex_len, 2);
}

#[test]
fn a_saved_pc2_reads_back() {
    let folder = Folder::new("save-pc2");
    let file = folder.0.join("b.pc2");
    save_pc2(&file, 3, &FRAMES).unwrap();
    assert_eq!(cache::read_pc2(&file).unwrap(), bare(3, &FRAMES));
    let bytes = std::fs::read(&file).unwrap();
    // First frame 0 and step 1; everything else equals the bytes above.
    assert_eq!(bytes[20..28], [0, 0, 0, 0, 0, 0, 0x80, 0x3f]);
    let expected = pc2_bytes(3, 2, 1);
    assert!(bytes[..20] == expected[..20] && bytes[28..] == expected[28..]);
    for vertex_len in [0, 4, 12] {
        let error = save_pc2(&file, vertex_len, &FRAMES).unwrap_err();
        let expected =
            format!("cannot be written: 6 positions are no whole frames of {vertex_len}");
        assert_eq!(error.message(), expected);
    }
    assert!(save_pc2(&file, 3, &[]).is_err());
    assert_eq!(std::fs::read(&file).unwrap(), bytes, "what cannot be written leaves the old file");
    let error = save_pc2(&folder.0.join("none/c.pc2"), 3, &FRAMES).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Write);
    assert!(error.file().is_some_and(|file| file.ends_with("c.pc2")), "{error}");
}

#[test]
fn wrong_headers_are_refused_before_allocation() {
    let fault = |result: Result<PosedMeshes, Error>| result.unwrap_err().to_string();
    let found = fault(cache::parse_pc2(&pc2_bytes(4, 2, 1)));
    assert_eq!(
        found,
        "should have 128 bytes by its header, found 104; export the point cache again"
    );
    let found = fault(cache::parse_mdd(&mdd_bytes(3, 3)));
    assert_eq!(
        found,
        "should have 128 bytes by its header, found 88; export the point cache again"
    );
    let found = fault(cache::parse_pc2(&pc2_bytes(i32::MAX, i32::MAX, 1)));
    let expected = "counts 2147483647 points in 2147483647 frames, more than a file can hold; export \
                    the point cache again";
    assert_eq!([found, fault(cache::parse_mdd(&mdd_bytes(i32::MAX, i32::MAX)))], [expected; 2]);
    for (points, frames, what) in [(0, 2, "0 points"), (3, -2, "-2 frames"), (-1, 0, "-1 points")] {
        for found in [
            cache::parse_pc2(&pc2_bytes(points, frames, 1)),
            cache::parse_mdd(&mdd_bytes(points, frames)),
        ] {
            let expected =
                format!("counts {what}, expected 1 at least; export the point cache again");
            assert_eq!(fault(found), expected);
        }
    }
    let expected =
        "is no PointCache2 file of version 1: it is of version 2; export it as .pc2 again";
    assert_eq!(fault(cache::parse_pc2(&pc2_bytes(3, 2, 2))), expected);
    let expected = "is no PointCache2 file of version 1: it does not begin with POINTCACHE2; export \
                    it as .pc2 again";
    assert_eq!(fault(cache::parse_pc2(&mdd_bytes(3, 2))), expected);
}

#[test]
fn truncated_and_too_long_caches_are_refused_without_panic() {
    let (mut pc2, mut mdd) = (pc2_bytes(3, 2, 1), mdd_bytes(3, 2));
    for len in 0..pc2.len() {
        assert!(cache::parse_pc2(&pc2[..len]).is_err(), "{len}");
    }
    for len in 0..mdd.len() {
        assert!(cache::parse_mdd(&mdd[..len]).is_err(), "{len}");
    }
    spoil(&pc2, |bytes| drop(cache::parse_pc2(bytes)));
    spoil(&mdd, |bytes| drop(cache::parse_mdd(bytes)));
    pc2.push(0);
    mdd.push(0);
    let fault = cache::parse_pc2(&pc2).unwrap_err();
    assert_eq!(
        fault.message(),
        "should have 104 bytes by its header, found 105; export the point cache again"
    );
    assert!(cache::parse_mdd(&mdd).is_err());
}

fn shape(number: usize) -> String {
    format!("v 0 0 {number}\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n")
}

/// Writes the meshes of some numbers under the given names.
fn sequence(test: &str, files: &[(&str, usize)]) -> (Folder, Vec<PathBuf>) {
    let folder = Folder::new(test);
    let files = files.iter().map(|&(name, number)| folder.write(name, shape(number))).collect();
    (folder, files)
}

fn heights(meshes: &PosedMeshes) -> Vec<f64> {
    meshes.vertices.iter().step_by(meshes.vertex_len).map(|vertex| vertex[2]).collect()
}

#[test]
fn numbered_meshes_are_read_by_number() {
    let (folder, files) = sequence(
        "numbers",
        &[("pose_10.obj", 10), ("pose_9.obj", 9), ("pose_0002.OBJ", 2), ("pose_400.obj", 400)],
    );
    folder.write("pose_3.txt", "no mesh");
    folder.write("._pose_4.obj", "what a system keeps");
    for path in [&folder.0, &files[0], &files[2]] {
        let meshes = read(path).unwrap();
        assert_eq!(heights(&meshes), [2.0, 9.0, 10.0, 400.0]);
        assert_eq!(meshes.vertex_len, 4);
        assert_eq!(meshes.triangles, Some(vec![[0, 1, 2], [0, 2, 3]]));
        assert_eq!(meshes.rest, None);
    }
    folder.write("run5.obj", shape(5));
    folder.write("rest.obj", shape(0));
    assert_eq!(heights(&read(&files[1]).unwrap()), [2.0, 9.0, 10.0, 400.0], "of its own name");
    assert_eq!(heights(&read(&folder.0.join("run5.obj")).unwrap()), [5.0]);
    let expected =
        "has no frame number before .obj; export one file a frame: pose_1.obj, pose_2.obj";
    refused(&folder.0, &folder.0.join("rest.obj"), expected);
    refused(&folder.0.join("rest.obj"), &folder.0.join("rest.obj"), expected);
    let beyond = folder.write("pose_99999999999999999999.obj", shape(1));
    refused(&beyond, &beyond, expected);
}

#[test]
fn two_meshes_of_one_number_are_refused() {
    let (folder, files) = sequence("twice", &[("pose_1.obj", 1), ("pose_01.obj", 2)]);
    let expected =
        "has the frame number of pose_01.obj, 1; keep one of them, or one sequence a folder";
    refused(&folder.0, &files[0], expected);
    refused(&files[1], &files[0], expected);
}

#[test]
fn missing_files_are_named_like_their_neighbours() {
    let leaves_out = |files: &[&str]| missing(&files.iter().map(PathBuf::from).collect::<Vec<_>>());
    assert_eq!(leaves_out(&["leg0048.obj", "leg0049.obj", "leg0051.obj"]), ["leg0050.obj"]);
    assert_eq!(
        leaves_out(&["a_8.OBJ", "a_9.OBJ", "a_12.OBJ", "a_13.OBJ"]),
        ["a_10.obj", "a_11.obj"]
    );
    assert_eq!(leaves_out(&["p5.obj", "p10.obj", "p20.obj", "p25.obj"]), ["p15.obj"]);
    let none: [&str; 0] = [];
    // Every fifth frame; one file; no file; uneven numbers; clips far apart.
    assert_eq!(leaves_out(&["p5.obj", "p10.obj", "p15.obj"]), none);
    assert_eq!(leaves_out(&["p5.obj"]), none);
    assert_eq!(leaves_out(&[]), none);
    assert_eq!(leaves_out(&["p0.obj", "p5.obj", "p10.obj", "p17.obj"]), none);
    assert_eq!(leaves_out(&["p1.obj", "p2.obj", "p3.obj", "p1000000000000.obj"]), none);
}

#[test]
fn every_mesh_must_have_the_vertices_and_faces_of_the_first() {
    let (folder, files) = sequence("others", &[("p1.obj", 1), ("p2.obj", 2), ("p3.obj", 3)]);
    folder.write("p2.obj", format!("v 7 7 7\n{}", shape(2)));
    let expected = "has 5 vertices, expected 4 as in p1.obj; export every frame with the same \
                    vertices in the same order";
    refused(&files[2], &files[1], expected);
    folder.write("p2.obj", shape(2) + "f 1 2 3\n");
    let expected = "has other faces than p1.obj, from face 2 on (2 in all, expected 1); export every \
                    frame with the same faces, not triangulated anew";
    refused(&files[2], &files[1], expected);
    folder.write("p2.obj", shape(2).replace("1 2 3 4", "2 3 4 1"));
    assert!(read(&files[2]).unwrap_err().message().contains("from face 1 on (1 in all"));
    // The error names the first faulty file in order, whichever thread finds a fault first.
    folder.write("p3.obj", "v 1\n");
    let error = read(&files[2]).unwrap_err();
    assert!(error.file().is_some_and(|file| file.ends_with("p2.obj")), "{error}");
    folder.write("p2.obj", shape(2));
    let expected = "line 1 is no vertex, texture coordinate, normal or face of numbers: v 1";
    refused(&files[0], &files[2], expected);
}

#[test]
fn points_without_faces_are_shapes_too() {
    let folder = Folder::new("points");
    let file = folder.write("p1.obj", "v 1 2 3\n");
    assert_eq!(read(&file).unwrap(), bare(1, &[[1.0, 2.0, 3.0]]));
}
