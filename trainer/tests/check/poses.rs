//! Checks of the range of the poses, and of redundant poses.

use super::made::{Bend, bends, chain, check, swelling};
use models::shared;
use sinew_trainer::check::finding::Kind;
use sinew_trainer::examples::{Examples, Split, npz};
use sinew_trainer::progress::Silent;

#[test]
fn the_range_of_a_hinge_is_measured_in_degrees() {
    let angles: Vec<Bend> =
        (0..12).map(|k| ([10.0 * f64::from(k) - 20.0, 3.0], Split::Train)).collect();
    let found = check(&chain(&angles));
    let upper = &found.joints[1];
    assert_eq!(upper.joint, "upper");
    assert!((upper.axis[2].abs() - 1.0).abs() < 1e-9, "{:?}", upper.axis);
    assert!((upper.twist[0] + 20.0).abs() < 1e-6 && (upper.twist[1] - 90.0).abs() < 1e-6);
    assert!(upper.swing < 1e-5 && upper.slide_percent < 1e-6);
    assert!((upper.degrees - 90.0).abs() < 1e-6);
    assert_eq!(upper.distinct, 12, "10° apart, of 90°");
}

#[test]
fn frames_beyond_training_are_counted_and_measured() {
    let mut bends = bends();
    bends.extend([([80.0, 110.0], Split::HeldOut), ([40.0, 35.0], Split::HeldOut)]);
    bends.push(([-40.0, 0.0], Split::Extreme));
    let found = check(&chain(&bends));
    let [upper, lower] = [1, 2].map(|k| &found.joints[k].beyond);
    assert_eq!((upper.len(), lower.len()), (1, 1));
    assert_eq!((upper[0].frame.frame, lower[0].frame.frame), (27, 25));
    assert!((upper[0].degrees - 40.0).abs() < 1e-6 && (lower[0].degrees - 30.0).abs() < 1e-6);
    let advice = found.advice.join("\n");
    assert!(
        advice.contains("upper (1 frame, frame 27 by 40°), lower (1 frame, frame 25 by 30°)"),
        "{advice}"
    );
}

#[test]
fn joints_that_never_bend_together_are_named() {
    let apart: Vec<Bend> = bends().into_iter().filter(|([a, b], _)| a.min(*b) < 30.0).collect();
    let found = check(&chain(&apart));
    assert_eq!(found.never_together.len(), 1);
    let pair = &found.never_together[0];
    assert_eq!((pair.joint.as_str(), pair.parent.as_str()), ("lower", "upper"));
    assert!(check(&chain(&bends())).never_together.is_empty());
}

#[test]
fn a_joint_with_few_poses_is_named() {
    let few: Vec<Bend> = bends()
        .into_iter()
        .map(|([a, b], split)| ([if a > 30.0 { 80.0 } else { 0.0 }, b], split))
        .collect();
    let found = check(&chain(&few));
    assert_eq!([found.joints[1].distinct, found.joints[2].distinct], [2, 5]);
    let advice = found.advice.join("\n");
    assert!(advice.contains("few: upper (2 poses over 80°)\n"), "{advice}");
}

#[test]
fn a_pose_apart_is_isolated_and_poses_between_others_are_redundant() {
    let mut dense: Vec<Bend> =
        (0..31).map(|k| ([2.0 * f64::from(k), f64::from(k * k % 17)], Split::Train)).collect();
    dense.push(([115.0, 40.0], Split::Train));
    let found = check(&chain(&dense)).predicted.unwrap();
    assert_eq!(found.isolated[0].frame.frame, 31);
    assert!(found.redundant.len() > 10, "{found:?}");
    assert!(found.redundant.iter().all(|frame| frame.frame != 31));
    let all = found.enough.len() + found.redundant.len();
    assert_eq!((all, found.compared), (32, 32));
}

/// Makes a chain with a linear skin, and two curves of five values each in an order of their own. The curve `swell` alone
/// changes the skin.
fn swelling_by_curve() -> Examples {
    let value = |number: usize| 0.25 * (number % 5) as f64;
    let bend = |k: usize| [3.0 * (k * 7 % 25) as f64, 2.0 * (k * 11 % 25) as f64];
    swelling_by(&bend, &|k| [value(k), value(k / 5 + 2 * k)])
}

/// Makes the chain of [`swelling_by_curve`] from the hinges' angles and the curves of each frame.
fn swelling_by(bend: &dyn Fn(usize) -> [f64; 2], curves: &dyn Fn(usize) -> [f64; 2]) -> Examples {
    let bends: Vec<_> = (0..25).map(|k| (bend(k), Split::Train)).collect();
    let mut examples = swelling(&bends, 0.0);
    examples.curve_names = ["swell", "other"].map(str::to_owned).into();
    examples.curves = (0..25).flat_map(curves).collect();
    let rest = examples.rest.clone();
    for (frame, mesh) in examples.vertices.chunks_mut(rest.len()).enumerate() {
        // The hinges turn about z.
        let swell = examples.curves[2 * frame];
        mesh.iter_mut().zip(&rest).for_each(|(x, rest)| x[2] *= 1.0 + swell * rest[0]);
    }
    examples
}

#[test]
fn a_curve_has_a_range_and_a_share_of_the_motion() {
    let mut examples = swelling_by_curve();
    examples.split[24] = Split::HeldOut;
    examples.curves[48] = 1.2;
    let found = check(&examples).curves;
    let [swell, other] = &found[..] else { panic!("two curves") };
    assert_eq!((swell.curve.as_str(), swell.range, swell.distinct), ("swell", [0.0, 1.0], 5));
    assert_eq!([swell.beyond, other.beyond], [1, 0]);
    assert!(swell.explained_percent > 90.0 && other.explained_percent < 10.0, "{found:?}");
}

#[test]
fn a_skin_that_the_pose_does_not_explain_is_warned_of() {
    let Some(path) = shared("curves/set.npz") else { return };
    let loaded = npz::load(&path).unwrap();
    let (mut examples, clips) = (loaded.examples, loaded.clips);
    let check = |examples: &Examples| {
        let found = sinew_trainer::check::check(examples, &clips, &Silent).unwrap();
        found.find(Kind::Unexplained).map(|finding| finding.text.clone())
    };
    assert_eq!(check(&examples), None);
    examples.keep_curves(&[]).unwrap();
    // In the other clips some frames are even called wrong.
    for held_out in &clips {
        examples.split.fill(Split::Train);
        examples.split[held_out.first..][..held_out.times.len()].fill(Split::HeldOut);
        let text = check(&examples).expect("a warning");
        assert!(text.starts_with("the pose does not explain the skin: "), "{text}");
    }
}

#[test]
fn frames_of_one_pose_differ_by_their_curves() {
    let mut examples = swelling_by_curve();
    let (joints, vertices) = (examples.joint_len(), examples.vertex_len());
    // Frame 1 takes the joints of frame 0, and keeps its own swelling.
    examples.transforms.copy_within(..joints, joints);
    let lie = |x: &[f64; 3], rest: &[f64; 3]| [x[0], x[1], rest[2] * (1.0 + 0.25 * rest[0])];
    let mesh: Vec<_> =
        examples.frame(0).iter().zip(&examples.rest).map(|(x, r)| lie(x, r)).collect();
    examples.vertices[vertices..2 * vertices].copy_from_slice(&mesh);
    let contradicts = |examples: &Examples| {
        let found = check(examples);
        found.find(Kind::Contradicting).or(found.find(Kind::Repeated)).is_some()
    };
    assert!(!contradicts(&examples));
    examples.keep_curves(&[]).unwrap();
    assert!(contradicts(&examples));
}

#[test]
fn still_joints_do_not_judge_the_steps_of_a_mesh_that_curves_drive() {
    let curves = |k: usize| if k < 10 { [0.0; 2] } else { [(12.9898 * k as f64).sin().abs(), 0.0] };
    let found = check(&swelling_by(&|_| [0.0; 2], &curves));
    assert!(found.find(Kind::OutOfStep).is_none(), "{found:?}");
}

#[test]
fn a_joint_that_stretches_has_its_factors() {
    let mut examples = chain(&bends());
    for frame in 0..examples.frame_len() {
        let by = 1.0 + 0.02 * frame as f64;
        let joints = examples.joint_len();
        let map = &mut examples.transforms[joints * frame + 2];
        map.iter_mut().for_each(|row| row[1] *= by);
    }
    let found = check(&examples);
    assert_eq!(found.joints[1].stretch, [1.0, 1.0]);
    let [least, most] = found.joints[2].stretch;
    assert!((least - 1.0).abs() < 1e-9 && (most - 1.48).abs() < 1e-9, "{least} {most}");
}
