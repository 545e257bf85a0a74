//! Tests of archives: built for a test, refused, damaged, and real ones against another importer.

mod made;

use super::parse;
use crate::examples::{Examples, npz};
use crate::formats::posed_meshes::{Part, PosedMeshes};
use crate::formats::testing::{shared, spoil};
use made::{
    Node, Object, Property, archive, doubles, file, mesh, other, points, scalar, transform, wholes,
};
use nalgebra::{Matrix4, Point3, Rotation3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// A quad and a triangle on top of it.
const QUAD: [[f32; 3]; 5] =
    [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.], [0.5, 2., 0.25]];

/// Returns the quad, shifted along x.
fn quad(x: f32) -> Vec<[f32; 3]> {
    QUAD.map(|[own, y, z]| [own + x, y, z]).to_vec()
}

/// Returns the faces of the quad, wound as in Alembic.
fn faces() -> Vec<Property> {
    vec![wholes(".faceCounts", &[vec![4, 3]]), wholes(".faceIndices", &[vec![3, 2, 1, 0, 4, 2, 3]])]
}

/// Makes a mesh with the quad's faces and positions over time.
fn posed(name: &'static str, samples: &[Vec<[f32; 3]>]) -> Object {
    mesh(name, faces().into_iter().chain([points("P", samples)]).collect())
}

/// Makes a transform from operations and their channels over time.
fn moving(name: &'static str, operations: &[u8], samples: &[Vec<f64>]) -> Object {
    let operations = scalar(".ops", 1, operations.len() as u32, operations.to_vec());
    transform(name, vec![operations, doubles(".vals", false, samples)])
}

fn read(objects: Vec<Object>) -> PosedMeshes {
    parse(&archive(objects)).unwrap()
}

#[track_caller]
fn check(found: &[[f64; 3]], world: &Matrix4<f64>, expected: &[[f32; 3]]) {
    assert_eq!(found.len(), expected.len());
    for (found, expected) in found.iter().zip(expected) {
        let expected = world.transform_point(&Point3::from(*expected).cast::<f64>());
        let apart = (Point3::from(*found) - expected).norm();
        assert!(apart < 1e-12, "{found:?}, expected {expected}");
    }
}

#[test]
fn every_sample_is_a_frame_and_those_that_repeat_are_stored_once() {
    let frames: Vec<_> = [0., 0., 0., 1., 2., 2., 3., 3., 3.].map(quad).to_vec();
    let found = read(vec![posed("Quad", &frames)]);
    assert_eq!((found.vertex_len, found.vertices.len()), (5, 5 * 9));
    for (found, expected) in found.vertices.chunks(5).zip(&frames) {
        check(found, &Matrix4::identity(), expected);
    }
    assert_eq!((found.rest, found.reference), (None, None));
    assert_eq!(found.parts, [Part { names: vec!["Quad".into()], range: 0..5 }]);
}

#[test]
fn faces_turn_as_in_other_formats() {
    let found = read(vec![posed("Quad", &[quad(0.0)])]);
    assert_eq!(found.triangles, Some(vec![[0, 1, 2], [0, 2, 3], [3, 2, 4]]));
    let bare = mesh("Points", vec![points("P", &[quad(0.0)])]);
    assert_eq!(read(vec![bare]).triangles, None);
}

#[test]
fn transforms_above_a_mesh_move_it_frame_by_frame() {
    // A rotation by degrees about x, then about an axis; a changing shift and scale; a matrix for row vectors.
    let turns = moving("Root", &[0x40, 0x20], &[vec![90.0, 0.0, 0.0, 2.0, 30.0]]);
    let shift = |x: f64| vec![x, 2.0, 3.0, 2.0, 2.0, 0.5];
    let shifts = moving("Rig", &[0x10, 0x00], &[shift(0.0), shift(1.0), shift(1.0)]);
    let rows = Matrix4::new_translation(&Vector3::new(5.0, 6.0, 7.0)).as_slice().to_vec();
    let matrix = moving("Quad", &[0x30], &[rows]);
    let frames: Vec<_> = [0., 4., 5.].map(quad).to_vec();
    let mesh = posed("QuadShape", &frames);
    let found = read(vec![turns.over(other("group").over(shifts.over(matrix.over(mesh))))]);
    let turn = |axis: Vector3<f64>, degrees: f64| {
        Rotation3::new(axis * degrees.to_radians()).to_homogeneous()
    };
    let above = turn(Vector3::x(), 90.0) * turn(Vector3::z(), 30.0);
    for (frame, x) in [0.0, 1.0, 1.0].into_iter().enumerate() {
        let world = above
            * Matrix4::new_translation(&Vector3::new(x, 2.0, 3.0))
            * Matrix4::new_nonuniform_scaling(&Vector3::new(2.0, 2.0, 0.5))
            * Matrix4::new_translation(&Vector3::new(5.0, 6.0, 7.0));
        check(&found.vertices[5 * frame..][..5], &world, &frames[frame]);
    }
    let names = vec!["Quad".into(), "QuadShape".into()];
    assert_eq!(found.parts, [Part { names, range: 0..5 }]);
}

#[test]
fn a_transform_may_not_inherit() {
    let far = moving("Far", &[0x10], &[vec![9.0, 9.0, 9.0]]);
    let operations = scalar(".ops", 1, 1, vec![0x50]);
    // Angles about y, as an array of one.
    let angles = doubles(".vals", true, &[vec![0.0], vec![90.0]]);
    let own = transform("Own", vec![scalar(".inherits", 0, 1, vec![0]), operations, angles]);
    let still = transform("Still", vec![scalar(".inherits", 0, 1, vec![1])]);
    let found = read(vec![far.over(own.over(still.over(posed("Quad", &[quad(1.0)]))))]);
    assert_eq!(found.vertices.len(), 10);
    check(&found.vertices[..5], &Matrix4::identity(), &quad(1.0));
    let turn = Rotation3::new(Vector3::y() * std::f64::consts::FRAC_PI_2).to_homogeneous();
    check(&found.vertices[5..], &turn, &quad(1.0));
}

#[test]
fn meshes_follow_one_another_and_still_ones_stay() {
    let still = posed("Shoe", &[vec![[1.0, 2.0, 3.0]; 5]]);
    let held = posed("Hat", &[vec![[4.0, 5.0, 6.0]; 5], vec![[4.0, 5.0, 6.0]; 5]]);
    let found = read(vec![posed("Leg", &[0.0, 1.0, 2.0].map(quad)), other("light"), still, held]);
    assert_eq!((found.vertex_len, found.vertices.len()), (15, 45));
    for (frame, posed) in found.vertices.chunks(15).enumerate() {
        check(&posed[..5], &Matrix4::identity(), &quad(frame as f32));
        assert_eq!((posed[5], posed[14]), ([1.0, 2.0, 3.0], [4.0, 5.0, 6.0]));
    }
    assert_eq!(found.triangles.unwrap()[3..6], [[5, 6, 7], [5, 7, 8], [8, 7, 9]]);
    let parts: Vec<_> =
        found.parts.iter().map(|part| (&*part.names[0], part.range.clone())).collect();
    assert_eq!(parts, [("Leg", 0..5), ("Shoe", 5..10), ("Hat", 10..15)]);
}

#[test]
fn reference_positions_of_every_mesh_come_along() {
    let with = |name, place: &'static str| {
        let reference = made::compound(".arbGeomParams", vec![points(place, &[quad(-1.0)])]);
        let all = faces().into_iter().chain([points("P", &[quad(0.0), quad(1.0)]), reference]);
        moving("Up", &[0x10], &[vec![0.0, 1.0, 0.0]]).over(mesh(name, all.collect()))
    };
    let found = read(vec![with("a", "Pref"), with("b", "Pref")]);
    check(&found.reference.unwrap(), &Matrix4::identity(), &[quad(-1.0), quad(-1.0)].concat());
    assert_eq!(read(vec![with("a", "Pref"), with("b", "rest")]).reference, None);
}

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
fn files_that_are_not_archives_are_refused() {
    let hdf5 = "is Alembic in an HDF5 container, which is not read; export it again with Ogawa";
    refused(b"\x89HDF\r\n\x1a\n\0\0\0", hdf5);
    let none = "is no Alembic archive of Ogawa's version 1: it does not begin with Ogawa";
    refused(b"", none);
    refused(b"PK\x03\x04", none);
    refused(b"Ogawa\xff\0\x01", "is damaged: it ends in its header");
    let mut bytes = small();
    bytes[5] = 0;
    refused(&bytes, "is incomplete: the program that wrote it did not finish; export it again");
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
fn forbidden_changes_over_time_are_named_with_their_frame() {
    let mut frames: Vec<_> = [0., 0., 0., 1., 2.].map(quad).to_vec();
    frames[3].pop();
    let words = "frame 3: mesh Leg has 4 vertices, expected 5 as in the first; export it without";
    refused(&archive(vec![posed("Leg", &frames)]), words);
    let other = vec![3, 2, 1, 0, 4, 3, 2];
    let counts = wholes(".faceCounts", &[vec![4, 3]]);
    let corners = vec![3, 2, 1, 0, 4, 2, 3];
    let corners = wholes(".faceIndices", &[corners.clone(), corners.clone(), corners, other]);
    let turned = mesh("Leg", vec![counts, corners, points("P", &[0., 0., 1., 2.].map(quad))]);
    refused(&archive(vec![turned]), "frame 3: mesh Leg has other faces than in the first");
    let two = vec![posed("Leg", &[0., 1., 2.].map(quad)), posed("Arm", &[0., 1.].map(quad))];
    let words = "mesh Arm has 2 samples, expected 1 or 3 as others have; export all over the same";
    refused(&archive(two), words);
    let above = moving("Rig", &[0x10], &[vec![0.0; 3], vec![1.0; 3]]);
    let words = "a transform above Rig has 2 samples, expected 1 or 3";
    refused(&archive(vec![above.over(posed("Leg", &[0., 1., 2.].map(quad)))]), words);
}

#[test]
fn faces_and_transforms_must_fit_their_data() {
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
fn wrong_counts_are_refused_before_allocation() {
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
fn cyclic_objects_are_refused() {
    let mut chain = posed("Leg", &[quad(0.0)]);
    for _ in 0..300 {
        chain = other("x").over(chain);
    }
    refused(&archive(vec![chain]), "is damaged: its objects are more than 256 levels deep");
    // An object that is its own child; then objects whose two children are one object.
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

/// Reads the place stored at a byte, or the place of a child of the group there.
fn child(bytes: &[u8], place: usize, child: Option<usize>) -> usize {
    let at = child.map_or(place, |child| place + 8 + 8 * child);
    u64::from_le_bytes(*bytes[at..].first_chunk().unwrap()) as usize
}

/// Overwrites the place of a child of the group at a byte.
fn put(bytes: &mut [u8], place: usize, child: usize, other: usize) {
    bytes[place + 8 + 8 * child..][..8].copy_from_slice(&(other as u64).to_le_bytes());
}

#[test]
fn spoiled_files_do_not_panic() {
    let bytes = small();
    assert_eq!(parse(&bytes).unwrap().vertices.len(), 30);
    for len in 0..bytes.len() {
        // The root is written last, so a file cut short has no root.
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
                // The place of another child.
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

/// Reads an archive with y up, and the arrays with z up that Blender made of it.
fn both(archive: &str, arrays: &str) -> Option<(PosedMeshes, Examples)> {
    let bytes = std::fs::read(shared(archive)?).unwrap();
    Some((parse(&bytes).unwrap(), npz::load(&shared(arrays)?).unwrap().examples))
}

/// Returns the largest difference between positions with y up and positions with z up.
fn farthest(found: &[[f64; 3]], expected: &[[f64; 3]]) -> f64 {
    assert_eq!(found.len(), expected.len());
    let apart = |(&[x, y, z], expected): (&[f64; 3], &[f64; 3])| {
        let differences = [x, -z, y].into_iter().zip(expected).map(|(a, b)| (a - b).abs());
        differences.fold(0.0, f64::max)
    };
    found.iter().zip(expected).map(apart).fold(0.0, f64::max)
}

/// An archive from Maya: a transform above the mesh, and only every other sample stored.
#[test]
fn an_archive_from_maya_is_as_blender_reads_it() {
    let Some((found, expected)) = both("dem-bones/Bone_Anim.abc", "dem-bones/bone.npz") else {
        return;
    };
    assert_eq!((found.vertex_len, found.vertices.len()), (754, 754 * 400));
    // In every frame the arrays lie 9.8e-6 higher than the archive's transform says.
    let lifted: Vec<_> = found.vertices.iter().map(|&[x, y, z]| [x, y + 9.8e-6, z]).collect();
    assert!(farthest(&lifted, &expected.vertices) < 5e-7);
    assert_eq!(found.triangles, Some(expected.triangles));
    assert_eq!((found.rest, found.reference), (None, None));
    assert_eq!(found.parts[0].names, ["Bone", "BoneShape"]);
}

/// An archive from Blender, with texture coordinates.
#[test]
fn an_archive_from_blender_holds_its_meshes() {
    let Some((found, expected)) = both("leg/leg.abc", "leg/leg.npz") else { return };
    assert_eq!((found.vertex_len, found.vertices.len()), (3938, 3938 * 122));
    assert_eq!(farthest(&found.vertices, &expected.vertices), 0.0);
    assert_eq!(found.reference.unwrap().len(), 3938);
    assert_eq!(found.triangles, Some(expected.triangles));
    assert_eq!(found.parts[0].names, ["Leg", "LegMesh"]);
}

#[test]
fn spoiled_real_archives_do_not_panic() {
    let Some(file) = shared("dem-bones/Bone_Anim.abc") else { return };
    let mut bytes = std::fs::read(file).unwrap();
    let len = bytes.len();
    for len in (0..len).step_by(len / 40) {
        assert!(parse(&bytes[..len]).is_err());
    }
    // Samples are at the front of the file, and the headers at the end.
    let random = (0..80).map(|number| number * 7919 * 31 % len);
    for place in random.chain((len - len / 60..len).step_by(997)) {
        for change in [0x01, 0x80, 0xff] {
            bytes[place] ^= change;
            drop(parse(&bytes));
            bytes[place] ^= change;
        }
    }
}
