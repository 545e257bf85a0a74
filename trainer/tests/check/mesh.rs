//! Checks of faces, at rest and in poses.

use super::made::{arm, check, frames, only, triangles};
use nalgebra::Vector3;
use sinew_trainer::check::finding::{Kind, Place, Severity};
use sinew_trainer::examples::Examples;

fn posed(examples: &mut Examples, frame: usize, vertex: usize) -> &mut [f64; 3] {
    let at = frame * examples.vertex_len() + vertex;
    &mut examples.vertices[at]
}

/// Makes the arm without texture, so that its triangles can be changed.
fn plain() -> Examples {
    Examples { engine: None, ..arm() }
}

/// Adds copies of vertices that move with their originals in every frame.
fn doubled(examples: &Examples, source: &[usize]) -> Examples {
    let mut out = examples.clone();
    out.engine = None;
    let pick = |points: &[[f64; 3]]| source.iter().map(|&v| points[v]).collect::<Vec<_>>();
    out.rest = pick(&examples.rest);
    out.vertices = (0..examples.frame_len()).flat_map(|f| pick(examples.frame(f))).collect();
    out
}

#[test]
fn a_triangle_without_area_is_named() {
    let mut examples = plain();
    examples.triangles.push([4, 4, 5]);
    let number = examples.triangles.len() - 1;
    assert_eq!(triangles(&only(&examples, Kind::NoArea)), [number]);
}

#[test]
fn a_triangle_that_is_wound_the_other_way_is_named_first() {
    let mut examples = plain();
    examples.triangles[123].swap(0, 1);
    let found = check(&examples);
    let winding = found.find(Kind::Winding).unwrap();
    assert_eq!((winding.severity, triangles(winding)[0]), (Severity::Warning, 123));
    assert!(winding.text.starts_with("3 edges join"), "{}", winding.text);
}

#[test]
fn an_edge_of_three_triangles_is_named() {
    let mut examples = plain();
    let [a, b, c] = examples.triangles[50];
    let far = (0..examples.vertex_len()).find(|v| ![a, b, c].contains(v) && *v > c + 40).unwrap();
    examples.triangles.push([a, b, far]);
    let found = check(&examples);
    let edge = found.find(Kind::NonManifold).unwrap();
    assert_eq!(edge.places, [Place::Edge([a.min(b), a.max(b)])]);
}

#[test]
fn a_vertex_of_no_triangle_is_named() {
    let arm = arm();
    let len = arm.vertex_len();
    let source: Vec<usize> = (0..len).chain([7]).collect();
    let mut examples = doubled(&arm, &source);
    for frame in 0..examples.frame_len() {
        posed(&mut examples, frame, len)[0] += 1e-3;
    }
    examples.rest[len][0] += 1e-3;
    assert_eq!(only(&examples, Kind::Unreferenced).places, [Place::Vertex(len)]);
}

#[test]
fn loose_triangles_are_warned_of_and_seams_only_noted() {
    let arm = arm();
    let mut loose = doubled(&arm, arm.triangles.as_flattened());
    loose.triangles = (0..arm.triangles.len()).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    let found = check(&loose);
    assert_eq!(found.find(Kind::Unwelded).unwrap().severity, Severity::Warning);
    assert_eq!((found.faces.pieces, found.faces.welded_pieces), (arm.triangles.len(), 1));
    assert_eq!(found.faces.border_edges, 3 * arm.triangles.len());

    let len = arm.vertex_len();
    let source: Vec<usize> = (0..len).chain([30]).collect();
    let mut seam = doubled(&arm, &source);
    let user = seam.triangles.iter().position(|t| t.contains(&30)).unwrap();
    seam.triangles[user].iter_mut().filter(|v| **v == 30).for_each(|v| *v = len);
    let note = only(&seam, Kind::Unwelded);
    assert_eq!(note.severity, Severity::Note);
    assert_eq!(note.places, [Place::Vertex(30), Place::Vertex(len)]);
}

#[test]
fn a_triangle_that_collapses_in_a_pose_is_named_with_the_frame() {
    let mut examples = arm();
    let [a, b, _] = examples.triangles[200];
    *posed(&mut examples, 9, a) = *posed(&mut examples, 9, b);
    let found = check(&examples);
    let collapsed = found.find(Kind::Collapsed).unwrap();
    let edge = |t: &usize| {
        let corners = examples.triangles[*t];
        corners.contains(&a) && corners.contains(&b)
    };
    let both: Vec<usize> = (0..examples.triangles.len()).filter(edge).collect();
    assert_eq!((triangles(collapsed), frames(collapsed)), (both, vec![9]));
}

#[test]
fn a_triangle_that_folds_over_in_a_pose_is_named_with_the_frame() {
    let mut examples = arm();
    let [a, b, c] = examples.triangles[200];
    let [at, p, q] = [a, b, c].map(|v| Vector3::from(*posed(&mut examples, 9, v)));
    // To the other side of the opposite edge.
    let across = at + ((p + q) / 2.0 - at) * 2.5;
    *posed(&mut examples, 9, a) = across.into();
    let found = check(&examples);
    let folded = found.find(Kind::Folded).unwrap();
    assert_eq!((frames(folded), folded.severity), (vec![9], Severity::Note));
    assert!(triangles(folded).contains(&200), "{folded:?}");
    assert!(triangles(folded).iter().all(|t| examples.triangles[*t].contains(&a)), "{folded:?}");
    assert!(found.find(Kind::Flipped).is_none());
}

#[test]
fn a_mirrored_mesh_is_warned_of() {
    let mut examples = arm();
    for vertex in 0..examples.vertex_len() {
        posed(&mut examples, 9, vertex)[2] *= -1.0;
    }
    let found = check(&examples);
    let flipped = found.find(Kind::Flipped).unwrap();
    assert_eq!((flipped.severity, frames(flipped)), (Severity::Warning, vec![9]));
}
