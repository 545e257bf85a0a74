//! Checks of joints, and of the rest mesh on them.

use super::made::{arm, bends, chain, check, frames, joints, kinds, only};
use nalgebra::{Matrix3, Rotation3, Vector3};
use sinew_trainer::check::finding::{Kind, Severity};
use sinew_trainer::examples::{Examples, Matrix3x4, Split};

fn map(examples: &mut Examples, frame: usize, joint: usize) -> &mut Matrix3x4 {
    let at = frame * examples.joint_len() + joint;
    &mut examples.transforms[at]
}

fn number(examples: &Examples, name: &str) -> usize {
    examples.skeleton.names.iter().position(|joint| joint == name).unwrap()
}

#[test]
fn a_scaled_joint_is_named_with_its_worst_frame() {
    let mut examples = arm();
    let hand = number(&examples, "hand");
    for row in map(&mut examples, 5, hand) {
        (0..3).for_each(|c| row[c] *= 1.005);
    }
    let found = check(&examples);
    let rigid = found.find(Kind::NonRigid).unwrap();
    assert_eq!(
        (rigid.severity, joints(rigid), frames(rigid)),
        (Severity::Warning, vec!["hand"], vec![5])
    );
    assert!(rigid.text.contains("scaled by 1.0050"), "{}", rigid.text);

    let mut examples = arm();
    map(&mut examples, 5, hand).iter_mut().for_each(|row| row[0] *= 1.005);
    let found = check(&examples);
    let text = &found.find(Kind::NonRigid).unwrap().text;
    assert!(text.contains("stretched by 1.0000 to 1.0050"), "{text}");
}

#[test]
fn a_joint_that_never_moves_is_named() {
    let still: Vec<_> = bends().into_iter().map(|([a, _], split)| ([a, 0.0], split)).collect();
    let found = check(&chain(&still));
    assert_eq!(joints(found.find(Kind::Still).unwrap()), ["lower"]);
    assert!(!found.joints[2].moves() && found.joints[1].moves() && !found.joints[0].moves());
}

#[test]
fn a_joint_near_a_half_turn_is_named_with_its_frame() {
    let mut far = bends();
    far.push(([175.0, 0.0], Split::Train));
    let found = check(&chain(&far));
    let turn = found.find(Kind::HalfTurn).unwrap();
    assert_eq!((joints(turn), frames(turn)), (vec!["upper"], vec![far.len() - 1]));
    assert!(turn.text.contains("upper by 175°"), "{}", turn.text);
}

#[test]
fn a_joint_that_moves_no_vertex_is_named() {
    let mut examples = chain(&bends());
    let joint_len = examples.joint_len();
    examples.skeleton.names.push("prop".into());
    examples.skeleton.parents.push(Some(0));
    examples.skeleton.rest.push(examples.skeleton.rest[0]);
    let mut transforms = Vec::new();
    for (frame, pose) in examples.transforms.chunks(joint_len).enumerate() {
        transforms.extend_from_slice(pose);
        let turn = Rotation3::new(Vector3::new(0.5, 1.0, 0.2) * (frame as f64).sin());
        let [x, y, z] = [0, 1, 2].map(|r| [turn[(r, 0)], turn[(r, 1)], turn[(r, 2)], 9.0]);
        transforms.push([x, y, z]);
    }
    examples.transforms = transforms;
    let found = check(&examples);
    assert_eq!(joints(found.find(Kind::Idle).unwrap()), ["prop"]);
}

#[test]
fn joint_weights_of_another_skin_are_named_and_ignored() {
    let mut examples = chain(&bends());
    // Displacements that no weights explain: otherwise the poses would determine the weights.
    for (k, x) in examples.vertices.as_flattened_mut().iter_mut().enumerate() {
        *x += 0.1 * (7.0 * k as f64).sin();
    }
    // The weights that made the chain.
    let weights = |x: f64| {
        let [a, b] = [1.0, 2.0].map(|at| ((x - at) / 0.5 + 0.5).clamp(0.0, 1.0));
        [1.0 - a, a * (1.0 - b), a * b]
    };
    let painted: Vec<f64> = examples.rest.iter().flat_map(|x| weights(x[0])).collect();
    let without = check(&examples);
    assert_eq!(without.lbs.own_weights_percent, None);
    examples.joint_weights = Some(painted);
    let found = check(&examples);
    assert_eq!(found.find(Kind::Weights), None);
    // The error of these weights: waves along three axes, relative to the diagonal of 3 x 0.4 x
    // 0.4.
    let own = found.lbs.own_weights_percent.unwrap();
    let waves = 100.0 * 0.1 * f64::sqrt(1.5) / f64::sqrt(9.0 + 2.0 * 0.16);
    assert!((own / waves - 1.0).abs() < 0.02, "{own} {waves}");
    // The tip keeps the weights of the root.
    let weights = examples.joint_weights.iter_mut().flat_map(|all| all.chunks_exact_mut(3));
    for (row, _) in weights.zip(&examples.rest).filter(|(_, x)| x[0] > 2.9) {
        row.copy_from_slice(&[1.0, 0.0, 0.0]);
    }
    let found = check(&examples);
    let finding = found.find(Kind::Weights).unwrap();
    assert_eq!((finding.severity, joints(finding)), (Severity::Warning, vec!["root"]));
    assert!((found.lbs.rms_percent / without.lbs.rms_percent - 1.0).abs() < 0.1);
    assert!(found.lbs.own_weights_percent.unwrap() > 2.0 * own);
}

#[test]
fn another_sculpt_at_rest_is_warned_of_where_it_differs() {
    let mut examples = arm();
    let hand = examples.skeleton.rest[number(&examples, "hand")];
    let wrist = Vector3::new(hand[0][3], hand[1][3], hand[2][3]);
    for position in &mut examples.rest {
        let out = Vector3::from(*position) - wrist;
        if out.x > 0.0 {
            let swollen = wrist + Matrix3::from_diagonal(&Vector3::new(1.1, 1.4, 1.4)) * out;
            *position = swollen.into();
        }
    }
    let found = check(&examples);
    let rest = found.find(Kind::RestDiffers).unwrap();
    assert_eq!((rest.severity, joints(rest)[0]), (Severity::Warning, "hand"), "{}", rest.text);
    assert!(!joints(rest).contains(&"chest"), "{}", rest.text);
    assert_eq!(found.rest.nearest.frame, 0);
}

#[test]
fn a_frame_that_equals_the_rest_mesh_shows_that_it_belongs() {
    let mut examples = arm();
    // Muscles that tense without any joint: half of the frames have the rest pose and another mesh.
    let len = examples.vertex_len();
    let identity = examples.transforms[..examples.joint_len()].to_vec();
    for frame in (1..examples.frame_len()).step_by(2) {
        examples.transforms[frame * identity.len()..][..identity.len()].copy_from_slice(&identity);
        for vertex in 0..len {
            let [x, y, z] = examples.rest[vertex];
            examples.vertices[frame * len + vertex] =
                [x, y, z * (1.0 + 0.3 * (20.0 * x).sin().abs())];
        }
    }
    // The frame that equals the rest mesh is neither the first nor the last frame in the rest pose.
    let middle = examples.frame_len() / 2;
    let rest = examples.rest.clone();
    examples.vertices.copy_within(middle * len..(middle + 1) * len, 0);
    examples.transforms.copy_within(middle * identity.len()..(middle + 1) * identity.len(), 0);
    examples.vertices[middle * len..][..len].copy_from_slice(&rest);
    examples.transforms[middle * identity.len()..][..identity.len()].copy_from_slice(&identity);
    let found = check(&examples);
    assert!(found.find(Kind::RestDiffers).is_none(), "{:?}", found.findings);
    // Without that frame, the meshes look like another sculpt.
    examples.split[middle] = Split::HeldOut;
    assert!(check(&examples).find(Kind::RestDiffers).is_some());
}

#[test]
fn a_linear_skin_needs_no_frame_near_rest() {
    let bent = bends().into_iter().map(|([a, b], split)| ([0.5 * a + 30.0, 0.5 * b + 30.0], split));
    let mut examples = chain(&bent.collect::<Vec<_>>());
    for (frame, pose) in examples.transforms.chunks(3).enumerate() {
        for (vertex, rest) in examples.rest.iter().enumerate() {
            let joint = pose[(vertex / 4 / 5).min(2)];
            let at =
                joint.map(|row| (0..3).map(|axis| row[axis] * rest[axis]).sum::<f64>() + row[3]);
            examples.vertices[frame * examples.rest.len() + vertex] = at;
        }
    }
    assert!(check(&examples).find(Kind::RestUntested).is_none());
}

#[test]
fn frames_that_are_all_bent_leave_the_rest_mesh_untested() {
    let bent: Vec<_> = bends()
        .into_iter()
        .map(|([a, b], split)| ([0.5 * a + 30.0, 0.5 * b + 30.0], split))
        .collect();
    let examples = chain(&bent);
    let untested = only(&examples, Kind::RestUntested);
    assert_eq!((untested.severity, frames(&untested)), (Severity::Note, vec![0]));
    let found = check(&examples);
    assert_eq!((found.rest.tested, found.rest.joints), (0, 3));
    assert!((found.rest.nearest_degrees - 30.0).abs() < 1e-6);
    assert_eq!(kinds(&check(&chain(&bends()))), []);
}
