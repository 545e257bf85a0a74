//! How a scene and its targets become examples.

use super::super::error::ImportError;
use super::super::scene::join;
use super::super::targets::TargetMeshes;
use crate::examples::{Clip, Examples, ExamplesError, Split, Warning};
use crate::formats::posed_meshes::PosedMeshes;
use crate::formats::scene::{SampledScene, Sampling};
use nalgebra::{Matrix4, Rotation3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sinew_runtime::format::Space;

const FRAMES: usize = 6;
const VERTICES: usize = 60;

/// A limb along x that bends at a joint and bulges there, without symmetry.
fn limb() -> (SampledScene, Vec<[f64; 3]>) {
    let mut random = ChaCha8Rng::seed_from_u64(3);
    let mut within = |low: f64, high: f64| random.random_range(low..high);
    let rest: Vec<[f64; 3]> =
        (0..VERTICES).map(|_| [within(0.0, 2.0), within(-0.2, 0.3), within(-0.1, 0.2)]).collect();
    let bind = |x| Matrix4::new_translation(&Vector3::new(x, 0.0, 0.0));
    let turn = |frame: usize| {
        let axis = Vector3::new(0.1, 0.4, 1.0) * (0.2 * frame as f64);
        bind(1.0) * Rotation3::new(axis).to_homogeneous()
    };
    let frames: Vec<_> = (0..FRAMES).flat_map(|frame| [bind(0.0), turn(frame)]).collect();
    let posed = (0..FRAMES).flat_map(|frame| {
        let map = turn(frame) * bind(-1.0);
        rest.iter().map(move |&[x, y, z]| {
            let bulge = 1.0 + 0.1 * frame as f64 * (-8.0 * (x - 0.8).powi(2)).exp();
            let point = nalgebra::Point3::new(x, y * bulge, z * bulge);
            if x > 1.0 { map.transform_point(&point).into() } else { point.into() }
        })
    });
    let posed: Vec<[f64; 3]> = posed.collect();
    let times = (0..FRAMES).map(|frame| frame as f64 / 24.0).collect();
    let scene = SampledScene {
        rest,
        triangles: vec![[0, 1, 2]],
        engine: None,
        ranges: Vec::new(),
        space: Space::default(),
        names: vec!["upper".into(), "lower".into()],
        parents: vec![None, Some(0)],
        binds: vec![bind(0.0), bind(1.0)],
        frames,
        shapes: None,
        morphs: false,
        clips: vec![Clip { name: "bend".into(), first: 0, times, numbers: None }],
        warnings: Vec::new(),
    };
    (scene, posed)
}

fn targets(vertices: Vec<[f64; 3]>) -> TargetMeshes {
    let meshes = PosedMeshes { vertex_len: VERTICES, vertices, rest: None, triangles: None };
    TargetMeshes { meshes, split: None }
}

const KEYS: Sampling<'_> = Sampling { fps: None, clips: &[], shapes: true };

/// y up to z up, metres to centimetres.
fn elsewhere([x, y, z]: [f64; 3]) -> [f64; 3] {
    [100.0 * x, -100.0 * z, 100.0 * y]
}

fn farthest(a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    let differences = a.as_flattened().iter().zip(b.as_flattened()).map(|(a, b)| (a - b).abs());
    differences.fold(0.0, f64::max)
}

#[test]
fn targets_in_place_stay_as_they_are() {
    let (scene, posed) = limb();
    let (examples, clips, warnings) = join(scene, Some(targets(posed.clone())), &KEYS).unwrap();
    assert_eq!(examples.vertices, posed);
    assert_eq!(warnings, []);
    assert_eq!(clips[0].times.len(), FRAMES);
    assert_eq!(examples.split, [Split::Train; FRAMES]);
}

#[test]
fn targets_in_other_axes_and_units_are_brought_to_the_joints() {
    let (scene, posed) = limb();
    let moved = posed.iter().copied().map(elsewhere).collect();
    let (examples, _, warnings) = join(scene, Some(targets(moved)), &KEYS).unwrap();
    assert!(farthest(&examples.vertices, &posed) < 1e-12);
    let how = "(x, z, -y) x 0.01".to_owned();
    assert_eq!(warnings, [Warning::Moved { what: "targets", how }]);
}

/// A rest mesh decides the space: the joints come to it, and carry it there as they did here.
#[test]
fn joints_are_brought_to_a_rest_mesh() {
    let (scene, posed) = limb();
    let shifted = |x| {
        let [x, y, z] = elsewhere(x);
        [x + 7.0, y, z - 300.0]
    };
    let here = join(limb().0, Some(targets(posed.clone())), &KEYS).unwrap().0;
    let mut there = targets(posed.iter().copied().map(shifted).collect());
    there.meshes.rest = Some(scene.rest.iter().copied().map(shifted).collect());
    there.meshes.triangles = Some(vec![[2, 1, 0]]);
    there.split = Some(vec![Split::HeldOut; FRAMES]);
    let rest = there.meshes.rest.clone().unwrap();
    let (examples, _, warnings) = join(scene, Some(there), &KEYS).unwrap();
    assert_eq!((&examples.rest, &examples.triangles), (&rest, &vec![[2, 1, 0]]));
    assert_eq!(examples.split, [Split::HeldOut; FRAMES]);
    assert!(matches!(&warnings[..], [Warning::Moved { what: "joints", .. }]), "{warnings:?}");
    let carry = |examples: &Examples, x: [f64; 3]| {
        let map = &examples.pose(4)[1];
        let x = [x[0], x[1], x[2], 1.0];
        [0, 1, 2].map(|row| map[row].iter().zip(x).map(|(m, x)| m * x).sum::<f64>())
    };
    for (x, moved) in here.rest.iter().zip(&rest) {
        assert!(farthest(&[carry(&examples, *moved)], &[shifted(carry(&here, *x))]) < 1e-10);
    }
    let origin = examples.skeleton.rest[1].map(|row| row[3]);
    assert!(farthest(&[origin], &[shifted([1.0, 0.0, 0.0])]) < 1e-10);
}

#[test]
fn targets_of_another_character_are_refused() {
    let (scene, posed) = limb();
    let mut random = ChaCha8Rng::seed_from_u64(4);
    let noise = posed.iter().map(|_| [0; 3].map(|_| random.random_range(-1.0..1.0))).collect();
    let error = join(scene, Some(targets(noise)), &KEYS).unwrap_err();
    assert!(matches!(error, ExamplesError::Import(ImportError::TargetsApart { .. })), "{error}");

    let (scene, posed) = limb();
    let mut other = targets(posed);
    other.meshes.rest = Some(scene.rest.iter().map(|&[x, y, z]| [x, y, 1.2 * z]).collect());
    let error = join(scene, Some(other), &KEYS).unwrap_err();
    assert!(matches!(error, ExamplesError::Import(ImportError::TargetsApart { .. })), "{error}");
}

#[test]
fn counts_that_differ_are_told_with_what_to_do() {
    let (scene, posed) = limb();
    let error = join(scene, Some(targets(posed[VERTICES..].to_vec())), &KEYS).unwrap_err();
    let words = "holds 5 meshes, the scene's clips have 6 frames (bend: 6): export both";
    assert!(error.to_string().starts_with(words), "{error}");

    let (scene, posed) = limb();
    let mut other = targets(posed);
    other.meshes.vertex_len = VERTICES / 2;
    let error = join(scene, Some(other), &KEYS).unwrap_err();
    let words = "holds meshes of 30 vertices, the scene's mesh has 60: export both";
    assert!(error.to_string().starts_with(words), "{error}");
}

#[test]
fn meshes_at_one_rate_need_keys_at_one_rate() {
    let uneven = || {
        let (mut scene, posed) = limb();
        scene.clips[0].times[5] += 1.0;
        (scene, targets(posed))
    };
    let (scene, posed) = uneven();
    let error = join(scene, Some(posed), &KEYS).unwrap_err().to_string();
    assert!(error.contains("clip bend has non-uniform key times"), "{error}");
    assert!(error.contains("--fps"), "{error}");
    let (scene, posed) = uneven();
    assert!(
        join(scene, Some(posed), &Sampling { fps: Some(24.0), clips: &[], shapes: true }).is_ok()
    );
}

#[test]
fn poses_without_meshes_are_refused() {
    let error = join(limb().0, None, &KEYS).unwrap_err();
    assert!(matches!(error, ExamplesError::Import(ImportError::NoShapes)), "{error}");
}
