//! Tests of scenes whose joints stretch, scale, hide or mirror.

use super::super::curves::SampledCurves;
use super::super::scene::join;
use super::super::targets::TargetMeshes;
use super::scene::{FRAMES, KEYS, VERTICES, limb, targets};
use crate::ErrorKind;
use crate::examples::validate::Origin;
use crate::examples::{Loaded, Warning};
use crate::formats::scene::SampledScene;
use nalgebra::{Matrix4, Vector3};

fn joined(scene: SampledScene, targets: Option<TargetMeshes>) -> Loaded {
    join(scene, SampledCurves::default(), targets, &KEYS).unwrap()
}

/// Scales the limb: a unit of the mesh is 100 of the joints'.
fn in_centimetres(scene: &mut SampledScene) {
    let unit = Matrix4::new_scaling(100.0);
    let back = Matrix4::new_scaling(0.01);
    scene.rest.as_flattened_mut().iter_mut().for_each(|x| *x *= 100.0);
    scene.binds.iter_mut().for_each(|bind| *bind = unit * *bind * back);
    // The joints' frames have the armature's scale.
    let frames = scene.frames.iter_mut().chain(&mut scene.at_rest);
    frames.for_each(|frame| *frame *= back);
}

/// Scale of the whole character in a frame.
fn growth(frame: usize) -> f64 {
    1.0 + 0.2 * frame as f64
}

/// Stretch of the lower joint along its x axis in a frame.
fn stretch(frame: usize) -> Matrix4<f64> {
    let by = 1.0 + 0.05 * frame as f64;
    Matrix4::new_nonuniform_scaling(&Vector3::new(by, 1.0, 1.0))
}

/// The limb without a bulge: the root grows, and the lower joint stretches.
fn growing() -> SampledScene {
    let (mut scene, _) = limb();
    for (frame, pose) in scene.frames.chunks_exact_mut(2).enumerate() {
        let growth = Matrix4::new_scaling(growth(frame));
        pose[0] = growth * pose[0];
        pose[1] = growth * pose[1] * stretch(frame);
    }
    let shapes = scene.frames.chunks_exact(2).flat_map(|pose| {
        let lower = pose[1] * Matrix4::new_translation(&-Vector3::x());
        let moved = scene.rest.iter().map(move |&x| (if x[0] > 1.0 { lower } else { pose[0] }, x));
        moved.map(|(map, x)| map.transform_point(&x.into()).into()).collect::<Vec<_>>()
    });
    scene.shapes = Some(shapes.collect());
    scene
}

#[test]
fn a_growing_character_with_a_stretching_spine_is_told_from_its_unit() {
    let plain = joined(growing(), None);
    let mut scaled = growing();
    in_centimetres(&mut scaled);
    let scaled = joined(scaled, None);
    for Loaded { examples, warnings, .. } in [&plain, &scaled] {
        assert_eq!(
            warnings,
            &[
                Warning::PlainSkin,
                Warning::FramesScaled {
                    joint: "upper".into(),
                    frames: FRAMES - 1,
                    most: growth(FRAMES - 1)
                }
            ]
        );
        assert_eq!(examples.stretching_joints(), [false, true]);
        for frame in 0..FRAMES {
            let [root, lower] = [0, 1].map(|joint| examples.pose(frame)[joint]);
            let linear = nalgebra::Matrix3::from_fn(|row, column| lower[row][column]);
            let sigma = linear.singular_values();
            let expected = stretch(frame).m11;
            assert!((sigma[0] - expected).abs() < 1e-9 && (sigma[2] - 1.0).abs() < 1e-9, "{sigma}");
            assert!((root[0][0] - 1.0).abs() < 1e-12);
        }
    }
    // The rest mesh and the posed meshes are in the joints' unit.
    let near = |a: &[[f64; 3]], b: &[[f64; 3]]| {
        let apart = a.as_flattened().iter().zip(b.as_flattened()).map(|(a, b)| (a - b).abs());
        apart.fold(0.0, f64::max) < 1e-9
    };
    assert!(near(&plain.examples.rest, &limb().0.rest));
    assert!(near(&scaled.examples.rest, &plain.examples.rest));
    assert!(near(&scaled.examples.vertices, &plain.examples.vertices));
    let origin = |loaded: &Loaded| loaded.examples.skeleton.rest[1].map(|row| row[3]);
    assert!(near(&[origin(&scaled)], &[origin(&plain)]));
    plain.checked(&Origin::SCENE).unwrap();
    scaled.checked(&Origin::SCENE).unwrap();
}

/// A leaf that scales evenly is no scale of the character, whatever its place in the file.
#[test]
fn the_root_is_found_by_its_parent() {
    let mut scene = growing();
    scene.shapes.as_mut().unwrap().truncate(VERTICES);
    scene.clips[0].times.truncate(1);
    scene.frames.truncate(2);
    scene.frames[1] *= Matrix4::new_scaling(1.5);
    for joints in [&mut scene.frames, &mut scene.binds, &mut scene.at_rest] {
        joints.swap(0, 1);
    }
    scene.names.swap(0, 1);
    scene.parents = vec![Some(1), None];
    let Loaded { examples, warnings, .. } = joined(scene, None);
    assert_eq!(warnings, [Warning::PlainSkin]);
    assert!((examples.pose(0)[0][0][0] - 1.5).abs() < 1e-12, "{:?}", examples.pose(0));
}

/// The posed meshes of a scene come from a sequence of files.
#[test]
fn joints_that_hide_or_mirror_are_refused_by_joint_and_frame() {
    for (scale, words) in [
        (0.0, "joint lower is scaled to 0: leave the frames out in which it is hidden, or"),
        (-1.0, "joint lower is mirrored: apply the scale of the armature"),
    ] {
        let (mut scene, posed) = limb();
        let by = Vector3::new(1.0, 1.0, scale);
        scene.frames[2 * 4 + 1] *= Matrix4::new_nonuniform_scaling(&by);
        let loaded = joined(scene, Some(targets(posed)));
        let error = loaded.checked(&Origin::SCENE).unwrap_err();
        assert_eq!((error.kind(), error.frame()), (ErrorKind::Value, Some(4)));
        assert!(error.message().starts_with(words), "{error}");
    }
}
