//! Tests of joining scenes and posed meshes: here with a real rig and its posed meshes, in every pair of formats.

mod curves;
mod meshes;
mod scene;
mod stretch;

use super::source::{Source, load};
use crate::examples::{Examples, Loaded, Warning};
use crate::formats::save_pc2;
use crate::formats::testing::{Folder, shared};

/// Frames of the clips Walk Cycle and Stretch, in timeline order.
const WALK: usize = 66;
const STRETCH: usize = 56;

fn leg(scene: &str, targets: &str) -> Option<(Loaded, Examples)> {
    let [scene, targets, all] =
        [scene, targets, "leg.npz"].map(|file| shared(&format!("leg/{file}")));
    let (scene, targets, all) = (scene?, targets?, all?);
    let loaded = load(&Source { targets: Some(&targets), ..Source::file(&scene) });
    let expected = load(&Source::file(&all)).unwrap().examples;
    Some((loaded.unwrap_or_else(|error| panic!("{error}")), expected))
}

/// Compares the paths of some vertices with the arrays' vertices at the same rest positions.
///
/// - `frames`: the arrays' frame of each frame.
fn check(found: &Examples, expected: &Examples, frames: &[usize], unit: f64, y_up: bool) {
    let there = |[x, y, z]: [f64; 3]| {
        let [x, y, z] = [x, y, z].map(|x| x * unit);
        if y_up { [x, -z, y] } else { [x, y, z] }
    };
    let apart =
        |a: [f64; 3], b: [f64; 3]| (0..3).map(|axis| (a[axis] - b[axis]).abs()).fold(0.0, f64::max);
    assert_eq!(found.frame_len(), frames.len());
    let mut worst: f64 = 0.0;
    for v in (0..found.vertex_len()).step_by(37) {
        let at_rest = there(found.rest[v]);
        let near = |&a: &usize, &b: &usize| {
            apart(expected.rest[a], at_rest).total_cmp(&apart(expected.rest[b], at_rest))
        };
        let other = (0..expected.vertex_len()).min_by(near).unwrap();
        assert!(apart(expected.rest[other], at_rest) < 1e-5);
        for (frame, &other_frame) in frames.iter().enumerate() {
            let (a, b) = (there(found.frame(frame)[v]), expected.frame(other_frame)[other]);
            worst = worst.max(apart(a, b));
        }
    }
    assert!(worst < 1e-5, "{worst:e}");
}

#[test]
fn an_archive_follows_the_clips_of_an_fbx() {
    let Some((Loaded { examples, clips, warnings }, expected)) = leg("leg_strips.fbx", "leg.abc")
    else {
        return;
    };
    let lens: Vec<_> = clips.iter().map(|clip| clip.times.len()).collect();
    assert_eq!(lens, [WALK, STRETCH], "{warnings:?}");
    let frames: Vec<usize> = (0..WALK + STRETCH).collect();
    check(&examples, &expected, &frames, 0.01, true);
}

/// glTF changes the order of vertices.
#[test]
fn vertices_reordered_by_gltf_are_matched() {
    for targets in ["leg.npz", "leg.abc"] {
        let Some((Loaded { examples, clips, warnings }, expected)) = leg("leg.glb", targets) else {
            return;
        };
        let lens: Vec<_> = clips.iter().map(|clip| clip.times.len()).collect();
        assert_eq!(lens, [WALK, STRETCH]);
        assert!(!warnings.iter().any(|warning| matches!(warning, Warning::ClipsSorted { .. })));
        let frames: Vec<usize> = (0..WALK + STRETCH).collect();
        // The arrays' rest mesh defines the axes; the archive has no rest mesh.
        check(&examples, &expected, &frames, 1.0, targets == "leg.abc");
    }
}

/// The vertices have their own order and follow the file's own joints and shapes.
#[test]
fn a_skinned_gltf_serves_as_targets() {
    for (scene, unit) in [("leg.glb", 1.0), ("leg_strips.fbx", 0.01)] {
        let Some((Loaded { examples, .. }, _)) = leg(scene, "leg.glb") else { return };
        let expected = load(&Source::file(&shared("leg/leg.glb").unwrap())).unwrap().examples;
        let frames: Vec<usize> = (0..WALK + STRETCH).collect();
        check(&examples, &expected, &frames, unit, false);
    }
}

/// The stretch's meshes come before the walk's.
#[test]
fn meshes_that_follow_the_clips_in_another_order_are_sorted() {
    let Some(arrays) = shared("leg/leg.npz") else { return };
    let expected = load(&Source::file(&arrays)).unwrap().examples;
    let (walk, stretch) = expected.vertices.split_at(WALK * expected.vertex_len());
    let folder = Folder::new("leg-order");
    let targets = folder.0.join("leg.pc2");
    save_pc2(&targets, expected.vertex_len(), &[stretch, walk].concat()).unwrap();
    let scene = shared("leg/leg_strips.fbx").unwrap();
    let loaded = load(&Source { targets: Some(&targets), ..Source::file(&scene) });
    let Loaded { examples, warnings, .. } = loaded.unwrap_or_else(|error| panic!("{error}"));
    let frames: Vec<usize> = (0..WALK + STRETCH).collect();
    check(&examples, &expected, &frames, 0.01, true);
    let sorted = warnings.iter().find_map(|warning| match warning {
        Warning::ClipsSorted { clips, percent } => Some((clips, percent)),
        _ => None,
    });
    let (clips, [sorted, given]) = sorted.unwrap();
    assert!(clips.iter().map(String::as_str).eq(["Stretch", "Walk Cycle"]), "{clips:?}");
    assert!(*sorted < 2.0 && *given > 4.0 * sorted, "{sorted}, {given}");
}
