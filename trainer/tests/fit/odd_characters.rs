//! Unusual characters that a fit must accept: other units, no motion, few triangles, separate
//! parts.

use sinew_runtime::envelope::Predictor;
use sinew_trainer::envelope::s3::ProxyCount;
use sinew_trainer::envelope::{Options, Predict, train};
use sinew_trainer::evaluate::{Evaluation, Frames, evaluate};
use sinew_trainer::examples::demo::{DemoOptions, demo};
use sinew_trainer::examples::{Examples, Split};
use sinew_trainer::progress::Silent;

fn arm() -> Examples {
    demo(&DemoOptions { vertices: 300, poses: 40, held_out: 10, seed: 5 })
}

/// Every predictor.
const ALL: [Predict; 2] = [Predict::Only(Predictor::Rotational), Predict::Only(Predictor::Kernel)];

fn measured(examples: &Examples, predictor: Predict, proxies: usize, split: Split) -> Evaluation {
    let proxies = Some(ProxyCount::Fixed(proxies));
    let options = Options { predictor, proxies, ..Options::default() };
    let model = train(examples, &options, &Silent).unwrap().model;
    evaluate(&model, None, examples, Frames::Of(split)).unwrap()
}

fn scaled(mut examples: Examples, scale: f64) -> Examples {
    let scale_points = |points: &mut [[f64; 3]]| {
        points.iter_mut().flatten().for_each(|x| *x *= scale);
    };
    scale_points(&mut examples.rest);
    scale_points(&mut examples.vertices);
    for map in examples.transforms.iter_mut().chain(&mut examples.skeleton.rest) {
        map.iter_mut().for_each(|row| row[3] *= scale);
    }
    examples
}

#[test]
fn the_unit_of_length_does_not_matter() {
    for predictor in ALL {
        let reference = measured(&arm(), predictor, 12, Split::HeldOut).errors;
        for scale in [1e-4, 1e4] {
            let found = measured(&scaled(arm(), scale), predictor, 12, Split::HeldOut).errors;
            let ratio = found.rms_percent / reference.rms_percent;
            assert!((ratio - 1.0).abs() < 1e-2, "{predictor:?}, scaled by {scale}: {ratio}");
        }
    }
}

#[test]
fn of_a_character_that_never_moves_there_is_nothing_to_learn() {
    let mut examples = arm();
    for frame in 0..examples.frame_len() {
        let (v, j) = (examples.vertex_len(), examples.joint_len());
        examples.vertices[frame * v..][..v].copy_from_slice(&examples.rest);
        let identity = [[1.0, 0., 0., 0.], [0., 1.0, 0., 0.], [0., 0., 1.0, 0.]];
        examples.transforms[frame * j..][..j].fill(identity);
    }
    let found = examples.frames_of(Split::Train).len();
    let refused = train(&examples, &Options::default(), &Silent).err().unwrap();
    let expected = format!("all {found} training frames are one pose: there is no motion to learn");
    assert_eq!(refused.to_string(), expected);
}

#[test]
fn the_place_of_the_character_does_not_matter() {
    let near = arm();
    let mut far = near.clone();
    let shift = [20.0, -10.0, 15.0];
    for position in far.rest.iter_mut().chain(&mut far.vertices) {
        (0..3).for_each(|axis| position[axis] += shift[axis]);
    }
    for frame in &mut far.skeleton.rest {
        (0..3).for_each(|axis| frame[axis][3] += shift[axis]);
    }
    for map in &mut far.transforms {
        let turned = map.map(|row| row[0] * shift[0] + row[1] * shift[1] + row[2] * shift[2]);
        (0..3).for_each(|axis| map[axis][3] += shift[axis] - turned[axis]);
    }
    for predictor in ALL {
        let reference = measured(&near, predictor, 12, Split::HeldOut).errors;
        let found = measured(&far, predictor, 12, Split::HeldOut).errors;
        // The difference is f32 rounding, which grows with the distance.
        let most = 1.03 * reference.rms_percent;
        assert!(found.rms_percent < most, "{predictor:?} {found:?} {reference:?}");
    }
}

#[test]
fn a_skin_that_is_lbs_is_reproduced() {
    let mut examples = arm();
    let (v, j) = (examples.vertex_len(), examples.joint_len());
    for frame in 0..examples.frame_len() {
        for vertex in 0..v {
            let [x, y, z] = examples.rest[vertex];
            let (a, b) = (vertex % j, (vertex / 7) % j);
            let moved = |joint: usize| {
                examples.transforms[frame * j + joint]
                    .map(|m| m[0] * x + m[1] * y + m[2] * z + m[3])
            };
            let (a, b) = (moved(a), moved(b));
            examples.vertices[frame * v + vertex] =
                [0, 1, 2].map(|axis| 0.7 * a[axis] + 0.3 * b[axis]);
        }
    }
    for predictor in ALL {
        let found = measured(&examples, predictor, 12, Split::HeldOut);
        assert!(found.errors.rms_percent < 0.02, "{found:?}");
    }
    let alone = measured(&examples, Predict::Only(Predictor::Kernel), 12, Split::HeldOut);
    assert_eq!(alone.proxies, 0, "the joints need no help");
}

#[test]
fn one_proxy_and_as_many_as_triangles_both_train() {
    let mut examples = arm();
    let triangles = examples.triangles.clone();
    for predictor in ALL {
        examples.triangles.clone_from(&triangles);
        let one = measured(&examples, predictor, 1, Split::HeldOut);
        assert!(one.errors.rms.is_finite() && one.proxies == 1);
        examples.triangles.truncate(30);
        let all = measured(&examples, predictor, 30, Split::Train);
        assert!(all.errors.rms.is_finite() && all.proxies == 30, "{predictor:?} {all:?}");
    }
}

#[test]
fn parts_that_share_no_vertex_train_together() {
    let mut examples = arm();
    // Drops every other triangle, which leaves many small parts, and vertices in no triangle.
    examples.triangles = examples
        .triangles
        .iter()
        .copied()
        .enumerate()
        .filter(|(k, _)| k % 7 == 0)
        .map(|p| p.1)
        .collect();
    for predictor in ALL {
        let found = measured(&examples, predictor, 12, Split::HeldOut);
        assert!(found.errors.rms_percent < found.lbs.rms_percent, "{predictor:?} {found:?}");
    }
}

#[test]
fn a_skeleton_of_one_joint_trains() {
    let mut examples = arm();
    let (joints, root) = (examples.joint_len(), examples.skeleton.root());
    examples.transforms = examples.transforms.chunks(joints).map(|pose| pose[root]).collect();
    let skeleton = &mut examples.skeleton;
    skeleton.names = vec![skeleton.names[root].clone()];
    skeleton.rest = vec![skeleton.rest[root]];
    skeleton.parents = vec![None];
    for predictor in ALL {
        let found = measured(&examples, predictor, 8, Split::HeldOut);
        assert!(found.errors.rms <= 1.1 * found.lbs.rms, "{predictor:?} {found:?}");
    }
}
