//! Archives that are read, files that are refused, and what other importers made of real ones.

mod faults;
mod made;
mod real;

use super::read::parse;
use crate::formats::posed_meshes::{Part, PosedMeshes};
use made::{Object, Property, archive, doubles, mesh, other, points, scalar, transform, wholes};
use nalgebra::{Matrix4, Point3, Rotation3, Vector3};

/// A quad and a triangle on it.
const QUAD: [[f32; 3]; 5] =
    [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.], [0.5, 2., 0.25]];

/// The quad, moved along x.
fn quad(x: f32) -> Vec<[f32; 3]> {
    QUAD.map(|[own, y, z]| [own + x, y, z]).to_vec()
}

/// The faces of the quad, turning the other way as Alembic has them.
fn faces() -> Vec<Property> {
    vec![wholes(".faceCounts", &[vec![4, 3]]), wholes(".faceIndices", &[vec![3, 2, 1, 0, 4, 2, 3]])]
}

/// A mesh of the quad's faces, with positions over time.
fn posed(name: &'static str, samples: &[Vec<[f32; 3]>]) -> Object {
    mesh(name, faces().into_iter().chain([points("P", samples)]).collect())
}

/// A transform by operations and their channels over time.
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
    // A turn about x by degrees, then about an axis; a shift and a scale that change; a matrix for row vectors.
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
fn a_transform_may_stand_for_itself() {
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
