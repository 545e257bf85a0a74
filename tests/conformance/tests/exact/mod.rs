//! The exact properties of the reduction (METHOD §1.7), in f64: identities of real arithmetic hold
//! up to rounding. Expected values are the rest mesh, moved meshes, the published formulas written
//! out, and the full reconstruction; never the reduction itself.

mod character;
mod published;
mod unreduced;

use character::{Character, moved_examples};
use conformance::models::demo_examples;
use conformance::poses::rigid_motion;
use conformance::tolerance::{Arithmetic, EXACT, Inexact, whole};
use faer::Mat;
use nalgebra::{Matrix3, Matrix3x4};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use sinew_runtime::envelope::Certificate;
use sinew_runtime::{Envelope, Model};
use sinew_trainer::envelope::correction::Search;
use sinew_trainer::envelope::correction::joint_sets::JointSets;
use sinew_trainer::envelope::fitted::Fitted;
use sinew_trainer::envelope::helpers::fit::HelperFit;
use sinew_trainer::envelope::lbs::projection::Projection;
use sinew_trainer::envelope::lbs::targets::Targets;
use sinew_trainer::envelope::lbs::training::Training;
use sinew_trainer::envelope::model::EnvelopeModel;
use sinew_trainer::envelope::s3::ProxyCount;
use sinew_trainer::envelope::s3::keys::predict_stacked;
use sinew_trainer::envelope::s3::reduce::{Anchors, Reduced, Regression};
use sinew_trainer::envelope::s3::{self, RotationalOptions};
use sinew_trainer::examples::{Examples, Importance, Split};
use sinew_trainer::numeric::affine::{after, from_rows, linear};
use sinew_trainer::progress::Silent;

type Transform = Matrix3x4<f64>;

/// Strong enough for a condition near 1e4, so that solving keeps the digits that the tests require.
const ANCHORS: Anchors = Anchors { near_rigid: 1e3, patch: 1e-2 };

/// Evaluates `t = c1 d + c2 q`: P transforms.
fn transforms(
    reduced: &Reduced,
    gradients: &[Matrix3<f64>],
    joints: &[Transform],
) -> Vec<Transform> {
    let d = Mat::from_fn(3 * gradients.len(), 3, |row, r| gradients[row / 3][(r, row % 3)]);
    let q = Mat::from_fn(4 * joints.len(), 3, |row, r| joints[row / 4][(r, row % 4)]);
    let t = &reduced.c1 * d + &reduced.c2 * q;
    (0..t.nrows() / 4).map(|l| Transform::from_fn(|r, c| t[(4 * l + c, r)])).collect()
}

/// Returns the largest distance of a character's skin, under transforms, from expected positions.
fn largest_distance(character: &Character, transforms: &[Transform], expected: &[[f64; 3]]) -> f64 {
    let skinned = character.skin(transforms);
    assert!(skinned.len() == expected.len() && !expected.is_empty());
    let distances =
        skinned.iter().zip(expected).map(|(y, e)| (y - nalgebra::Vector3::from(*e)).norm());
    distances.map(|d| if d.is_nan() { f64::INFINITY } else { d }).fold(0.0, f64::max)
}

fn rest_pose(character: &Character) -> (Vec<Matrix3<f64>>, Vec<Transform>) {
    let identity = vec![Matrix3::identity(); character.proxy_len()];
    (identity, vec![Transform::identity(); character.joint_len])
}

#[test]
fn the_rest_pose_gives_the_rest_mesh() {
    let examples = demo_examples(200);
    let character = Character::fit(&examples);
    let reduced = character.reduction(ANCHORS).run().unwrap();
    let (mut d, q) = rest_pose(&character);
    let rest = &character.training.rest;
    assert!(largest_distance(&character, &transforms(&reduced, &d, &q), rest) <= EXACT);
    // Control: one gradient off rest is detected.
    d[0] *= 1.0 + 1e-9;
    assert!(largest_distance(&character, &transforms(&reduced, &d, &q), rest) > EXACT);
}

#[test]
fn a_rigid_motion_of_gradients_and_joints_passes_through() {
    let examples = demo_examples(200);
    let character = Character::fit(&examples);
    let poses = &character.training.poses;
    let reduced = character.reduction(ANCHORS).run().unwrap();
    let mut random = ChaCha8Rng::seed_from_u64(3);
    for pose in 0..poses.len() {
        // Up to two diagonals away.
        let motion = rigid_motion(0.02, &mut random);
        let d: Vec<_> = character.sequences.iter().map(|sequence| sequence[pose]).collect();
        let q: Vec<_> = (0..poses.joint_len()).map(|joint| *poses.map(pose, joint)).collect();
        let moved_d: Vec<_> = d.iter().map(|d| linear(&motion) * d).collect();
        let moved_q: Vec<_> = q.iter().map(|b| after(&motion, b)).collect();
        let still = character.skin(&transforms(&reduced, &d, &q));
        let expected: Vec<[f64; 3]> = still.iter().map(|y| (motion * y.push(1.0)).into()).collect();
        let found = transforms(&reduced, &moved_d, &moved_q);
        let distance = largest_distance(&character, &found, &expected);
        assert!(distance <= EXACT, "pose {pose}: {distance}");
    }
}

#[test]
fn a_rigid_motion_of_the_examples_moves_the_palette_by_the_root() {
    let examples = demo_examples(200);
    let (moved, motions) = moved_examples(&examples);
    let character = Character::fit(&examples);
    let Training { unit, poses: still, .. } = &character.training;
    let reduced = character.reduction(ANCHORS).run().unwrap();
    let predictors = character.predictors(&examples);
    let carried = Training::new(&moved, &Silent).unwrap().poses;
    let palettes =
        [still, &carried].map(|poses| reduced.palette(&predict_stacked(&predictors, poses), poses));
    let root = still.root();
    for (i, frame) in examples.frames_of(Split::Train).into_iter().enumerate() {
        let at = |palette: &Mat<f64>, l: usize| {
            let scale = |c: usize| if c == 3 { *unit } else { 1.0 };
            Transform::from_fn(|r, c| palette[(3 * i + r, 4 * l + c)] * scale(c))
        };
        let root_of = |pose: &[[[f64; 4]; 3]]| from_rows(&pose[root]);
        let (still_root, moved_root) = (root_of(examples.pose(frame)), root_of(moved.pose(frame)));
        for l in 0..character.proxy_len() {
            let expected = after(&motions[frame], &after(&still_root, &at(&palettes[0], l)));
            let found = after(&moved_root, &at(&palettes[1], l));
            let scale = expected.amax().max(1.0);
            assert!((found - expected).amax() <= EXACT * scale, "frame {frame}, proxy {l}");
        }
    }
}

#[test]
fn refinement_keeps_the_rest_pose_and_lowers_the_error() {
    let examples = demo_examples(200);
    let character = Character::fit(&examples);
    let Training { rest, poses, trajectories, .. } = &character.training;
    let reduced = character.reduction(ANCHORS).run().unwrap();
    let predicted = predict_stacked(&character.predictors(&examples), poses);
    let importance = Importance::UNIFORM;
    let targets = Targets { rest, weights: &character.proxies, trajectories, importance };
    let palette = reduced.palette(&predicted, poses);
    let residual = Projection::new(&targets, character.proxy_len()).residual(&palette);
    let regression = Regression::new(&predicted, poses, &residual, &[]);
    let (d, q) = rest_pose(&character);
    for strength in [1e-1, 1e-4, 1e-7] {
        let refined = regression.refine(&reduced, strength);
        let distance = largest_distance(&character, &transforms(&refined, &d, &q), rest);
        assert!(distance <= EXACT, "{strength}: {distance}");
        let moved = (&refined.c1 - &reduced.c1).norm_max();
        assert!(moved > 1e-6, "the refinement did something at {strength}");
        let after = targets.rms(&refined.palette(&predicted, poses));
        assert!(after < targets.rms(&palette), "and something good");
    }
}

#[test]
fn a_file_evaluates_as_it_was_fitted() {
    let examples = demo_examples(300);
    let options =
        RotationalOptions { proxies: ProxyCount::Fixed(9), ..RotationalOptions::default() };
    let training = Training::new(&examples, &Silent).unwrap();
    let rotational = s3::fit(&training, &options, &Silent).unwrap();
    let helpers =
        HelperFit::new(&training, sinew_runtime::envelope::HelperKind::Affine).unwrap().run(9, 4);
    let groups =
        |target| Search::new(target, &JointSets::new(), &Silent).fit(usize::MAX).unwrap().groups;
    for fitted in
        [rotational.fitted(&training), helpers.fitted(&training, groups(helpers.target(&training)))]
    {
        evaluates_as_fitted(&examples, &training, &fitted);
    }
}

fn evaluates_as_fitted(examples: &Examples, training: &Training, fitted: &Fitted) {
    let bytes = fitted.file_model(training, Certificate::default()).bake().unwrap();
    let model = Model::from_bytes(bytes).unwrap();
    let oracle = EnvelopeModel::from_file(&model.first::<Envelope>().unwrap());
    let frames: Vec<_> = (0..examples.frame_len()).collect();
    let (poses, _) = training.view(examples, &frames);
    let expected = fitted.envelope.palettes(&poses);
    for frame in frames {
        let pose: Vec<_> = examples.pose(frame).iter().map(from_rows).collect();
        let none = vec![[0.0; 3]; pose.len()];
        let root = pose[oracle.skeleton.root()];
        // Each of the file's numbers has an error of u, which is less than the rounding of an f32
        // evaluation.
        let curves = examples.curves_of(frame);
        let (found, _) = whole(&oracle, &Inexact::exact(pose), curves, &none, Arithmetic::IEEE);
        for (l, (transform, error)) in found.value.iter().zip(&found.error).enumerate() {
            let mut t = Transform::from_fn(|r, c| expected[(3 * frame + r, 4 * l + c)]);
            // Training uses its own unit and centre.
            let centre = nalgebra::Vector3::from(training.centre);
            let origin = t.column(3) * training.unit + centre - linear(&t) * centre;
            t.set_column(3, &origin);
            let off = (transform - after(&root, &t)).abs() - error;
            assert!(off.max() <= EXACT, "frame {frame}, transform {l}: {off}");
        }
    }
}
