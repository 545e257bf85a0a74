//! Archives that are refused, and bytes that do no harm.

use super::made::{Node, file};
use super::*;
use crate::formats::testing::spoil;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

#[track_caller]
fn refused(bytes: &[u8], expected: &str) {
    let error = parse(bytes).expect_err("the file should be refused").to_string();
    assert!(error.starts_with(expected), "{error}, expected {expected}");
}

fn small() -> Vec<u8> {
    let reference = made::compound(".arbGeomParams", vec![points("Pref", &[quad(0.0)])]);
    let all = faces().into_iter().chain([points("P", &[0.0, 1.0, 2.0].map(quad)), reference]);
    let shift = |x: f64| vec![x, 2.0, 3.0, 0.0, 0.0, 1.0, 45.0];
    let above = moving("Rig", &[0x10, 0x20], &[shift(0.0), shift(1.0), shift(2.0)]);
    archive(vec![above.over(mesh("Leg", all.collect())), posed("Shoe", &[quad(3.0)])])
}

#[test]
fn what_is_no_archive_is_told_apart() {
    let hdf5 = "is Alembic in an HDF5 container, which is not read; export it again with Ogawa";
    refused(b"\x89HDF\r\n\x1a\n\0\0\0", hdf5);
    let none = "is no Alembic archive of Ogawa's version 1: it does not begin with Ogawa";
    refused(b"", none);
    refused(b"PK\x03\x04", none);
    refused(b"Ogawa\xff\0\x01", "is damaged: it ends in its header");
    let mut bytes = small();
    bytes[5] = 0;
    refused(&bytes, "was not closed by what wrote it; export it again, to the end");
    (bytes[5], bytes[7]) = (0xff, 2);
    refused(&bytes, "is no Alembic archive of Ogawa's version 1: it is of version 2");
    let wholes = |number: u8| Node::Data(vec![number, 0, 0, 0]);
    let laid_out = file(&Node::Group(vec![wholes(1), wholes(0)]));
    refused(&laid_out, "is no Alembic archive of Ogawa's version 1: its objects are laid out by");
}

#[test]
fn an_archive_without_a_mesh_is_refused() {
    let none = "holds no polygon mesh: export the character's mesh, as polygons";
    refused(&archive(Vec::new()), none);
    refused(&archive(vec![other("camera"), moving("Rig", &[0x10], &[vec![0.0; 3]])]), none);
    refused(&archive(vec![mesh("Leg", faces())]), "mesh Leg has no vertex; leave it out");
    refused(&archive(vec![posed("Leg", &[Vec::new()])]), "mesh Leg has no vertex; leave it out");
}

#[test]
fn what_changes_over_time_and_may_not_is_named_with_its_frame() {
    let mut frames: Vec<_> = [0., 0., 0., 1., 2.].map(quad).to_vec();
    frames[3].pop();
    let words = "mesh Leg has 4 vertices in frame 3, expected 5 as in the first; export it without";
    refused(&archive(vec![posed("Leg", &frames)]), words);
    let other = vec![3, 2, 1, 0, 4, 3, 2];
    let counts = wholes(".faceCounts", &[vec![4, 3]]);
    let corners = vec![3, 2, 1, 0, 4, 2, 3];
    let corners = wholes(".faceIndices", &[corners.clone(), corners.clone(), corners, other]);
    let turned = mesh("Leg", vec![counts, corners, points("P", &[0., 0., 1., 2.].map(quad))]);
    refused(&archive(vec![turned]), "mesh Leg has other faces in frame 3 than in the first");
    let two = vec![posed("Leg", &[0., 1., 2.].map(quad)), posed("Arm", &[0., 1.].map(quad))];
    let words = "mesh Arm has 2 samples, expected 1 or 3 as others have; export all over the same";
    refused(&archive(two), words);
    let above = moving("Rig", &[0x10], &[vec![0.0; 3], vec![1.0; 3]]);
    let words = "a transform above Rig has 2 samples, expected 1 or 3";
    refused(&archive(vec![above.over(posed("Leg", &[0., 1., 2.].map(quad)))]), words);
}

#[test]
fn faces_and_transforms_must_fit_what_they_name() {
    let of = |counts: Vec<i32>, corners: Vec<i32>| {
        let faces = [wholes(".faceCounts", &[counts]), wholes(".faceIndices", &[corners])];
        archive(vec![mesh("Leg", faces.into_iter().chain([points("P", &[quad(0.)])]).collect())])
    };
    for (counts, corners) in
        [(vec![3], vec![0, 1, 5]), (vec![3], vec![0, 1, -1]), (vec![4], vec![0, 1, 2])]
    {
        refused(&of(counts, corners), "is damaged: the faces of mesh Leg name vertices or corners");
    }
    for (counts, corners) in [(vec![-3], vec![0, 1, 2]), (vec![3], vec![0, 1, 2, 3])] {
        refused(&of(counts, corners), "is damaged: the faces of mesh Leg name vertices or corners");
    }
    let short = moving("Rig", &[0x10, 0x10], &[vec![0.0; 5]]);
    let words = "is damaged: transform Rig has too few numbers or an operation that is not known";
    refused(&archive(vec![short.over(posed("Leg", &[quad(0.)]))]), words);
    let unknown = moving("Rig", &[0x70], &[vec![0.0; 5]]);
    refused(&archive(vec![unknown.over(posed("Leg", &[quad(0.)]))]), words);
}

#[test]
fn counts_that_lie_are_refused_before_anything_is_made() {
    let claiming = |counts| {
        let points = points("P", &[0., 1., 2.].map(quad)).claiming(counts);
        archive(vec![mesh("Leg", faces().into_iter().chain([points]).collect())])
    };
    assert!(parse(&claiming([3, 1, 2])).is_ok());
    refused(&claiming([4, 1, 3]), "is damaged: a group has no data as child 6");
    for counts in [[3, 0, 2], [3, 2, 1], [2, 1, 2]] {
        refused(&claiming(counts), "is damaged: a property changes before or behind its samples");
    }
    let large = "unfolds to more than 67108864 bytes, the most for a file of its size";
    refused(&claiming([u32::MAX, 1, 2]), large);
    refused(&claiming([u32::MAX, 0, 0]), large);
    assert_eq!(parse(&claiming([1000, 1, 2])).unwrap().vertices.len(), 5000);
}

#[test]
fn objects_that_name_themselves_come_to_an_end() {
    let mut chain = posed("Leg", &[quad(0.0)]);
    for _ in 0..300 {
        chain = other("x").over(chain);
    }
    refused(&archive(vec![chain]), "is damaged: its objects are more than 256 levels deep");
    // An object that is its own child, and objects that are each the two children of one.
    let mut bytes = archive(vec![other("a").over(other("b"))]);
    let top = child(&bytes, 8, None);
    let first = child(&bytes, top, Some(2));
    let first = child(&bytes, first, Some(1));
    put(&mut bytes, first, 1, first);
    refused(&bytes, "is damaged: its objects are more than 256 levels deep");

    let mut chain = other("x");
    for _ in 0..40 {
        chain = other("x").over(chain).over(other("y"));
    }
    let mut bytes = archive(vec![chain]);
    let top = child(&bytes, 8, None);
    let top = child(&bytes, top, Some(2));
    let mut level = child(&bytes, top, Some(1));
    for _ in 0..40 {
        let below = child(&bytes, level, Some(1));
        put(&mut bytes, level, 2, below);
        level = below;
    }
    refused(&bytes, "unfolds to more than 67108864 bytes");
}

/// The place that stands at a place, or that of a child of the group there.
fn child(bytes: &[u8], place: usize, child: Option<usize>) -> usize {
    let at = child.map_or(place, |child| place + 8 + 8 * child);
    u64::from_le_bytes(*bytes[at..].first_chunk().unwrap()) as usize
}

/// Makes a place a child of the group at a place.
fn put(bytes: &mut [u8], place: usize, child: usize, other: usize) {
    bytes[place + 8 + 8 * child..][..8].copy_from_slice(&(other as u64).to_le_bytes());
}

#[test]
fn spoiled_files_do_no_harm() {
    let bytes = small();
    assert_eq!(parse(&bytes).unwrap().vertices.len(), 30);
    for len in 0..bytes.len() {
        // What wrote the root at the end, as this does, leaves nothing to read of a part.
        assert!(parse(&bytes[..len]).is_err(), "{len}");
    }
    spoil(&bytes, |bytes| drop(parse(bytes)));
    let mut random = ChaCha8Rng::seed_from_u64(7);
    for _ in 0..20_000 {
        let mut spoiled = bytes.clone();
        for _ in 0..random.random_range(2..6) {
            let place = random.random_range(16..bytes.len());
            match random.random_range(0..3) {
                0 => spoiled[place] = random.random(),
                1 => spoiled[place] = 0,
                // Another place of the file, as one of a child.
                _ => {
                    let place = place / 8 * 8 % (bytes.len() - 8);
                    let other = random.random_range(0..bytes.len() as u64);
                    spoiled[place..place + 8].copy_from_slice(&other.to_le_bytes());
                }
            }
        }
        drop(parse(&spoiled));
    }
}
