//! Checks of frames against each other.

use super::made::{arm, chain, check, frames, kinds, only, swelling};
use sinew_trainer::check::finding::{Finding, Kind, Severity};
use sinew_trainer::examples::{Clip, Examples, Split};
use sinew_trainer::progress::Silent;

fn copy(examples: &mut Examples, from: usize, to: usize) {
    let (v, j) = (examples.vertex_len(), examples.joint_len());
    examples.vertices.copy_within(v * from..v * (from + 1), v * to);
    examples.transforms.copy_within(j * from..j * (from + 1), j * to);
}

#[test]
fn a_frame_that_repeats_another_is_noted() {
    let mut examples = arm();
    copy(&mut examples, 13, 30);
    let repeated = only(&examples, Kind::Repeated);
    assert_eq!((repeated.severity, frames(&repeated)), (Severity::Note, vec![30]));
    assert!(repeated.text.ends_with("30 as 13"), "{}", repeated.text);
    let redundant = check(&examples).predicted.unwrap().redundant;
    assert!(
        redundant.iter().any(|frame| [13, 30].contains(&frame.frame)),
        "one of the two is enough"
    );
}

#[test]
fn one_pose_with_two_meshes_is_warned_of() {
    let mut examples = arm();
    copy(&mut examples, 13, 30);
    let v = examples.vertex_len();
    for vertex in 0..v / 3 {
        examples.vertices[30 * v + vertex][1] += 0.03;
    }
    let found = check(&examples);
    let kinds: Vec<Kind> = found.findings.iter().map(|finding| finding.kind).collect();
    assert_eq!(kinds, [Kind::Contradicting, Kind::Broken]);
    let [apart, broken] = [0, 1].map(|k| &found.findings[k]);
    assert_eq!((apart.severity, frames(apart)), (Severity::Warning, vec![30, 13]));
    assert_eq!((broken.severity, frames(broken)), (Severity::Warning, vec![30]));
}

/// Gives each frame the mesh of a neighbouring frame.
fn out_of_step(shift: isize) -> Examples {
    let right = arm();
    let mut examples = right.clone();
    let last = right.frame_len() - 1;
    examples.vertices = (0..=last)
        .flat_map(|frame| right.frame(frame.saturating_add_signed(shift).min(last)).to_vec())
        .collect();
    examples
}

#[test]
fn meshes_of_the_frame_before_or_after_are_reported() {
    let of = |shift| check(&out_of_step(shift)).find(Kind::OutOfStep).cloned();
    assert!(of(0).is_none());
    for (shift, word) in [(-1, "one frame late"), (1, "one frame early")] {
        let found = of(shift).unwrap();
        assert_eq!(found.severity, Severity::Warning);
        assert!(found.text.contains("clip walk") && found.text.contains(word), "{}", found.text);
    }
}

/// Makes a bar that bends both hinges over 60 frames, slowly or fast.
fn bending(speed: f64, swell: f64) -> Examples {
    let of =
        |k: usize| [60.0 * (0.15 * speed * k as f64).sin(), 50.0 * (0.12 * speed * k as f64).cos()];
    swelling(&(0..60).map(|k| (of(k), Split::Train)).collect::<Vec<_>>(), swell)
}

/// Delays the meshes of some frames by `by` frames.
fn late(examples: &mut Examples, frames: std::ops::Range<usize>, by: isize) {
    let right = examples.clone();
    let len = right.vertex_len();
    for frame in frames {
        let mesh = frame.saturating_add_signed(-by).min(right.frame_len() - 1);
        examples.vertices[frame * len..][..len].copy_from_slice(right.frame(mesh));
    }
}

/// Asserts a single warning of this kind.
#[track_caller]
fn only_warning(examples: &Examples, kind: Kind) -> Finding {
    let mut found = check(examples).findings;
    found.retain(|finding| finding.severity == Severity::Warning);
    assert!(found.len() == 1 && found[0].kind == kind, "{kind:?} expected: {found:#?}");
    found.remove(0)
}

#[test]
fn late_meshes_are_reported_once_with_the_delay_in_frames() {
    for (speed, swell) in [(1.0, 0.0), (1.0, 0.1), (4.0, 0.0), (4.0, 0.1)] {
        for (by, words) in [
            (1, "one frame late"),
            (2, "2 frames late"),
            (-1, "one frame early"),
            (-3, "3 frames early"),
        ] {
            let mut examples = bending(speed, swell);
            late(&mut examples, 0..60, by);
            let found = only_warning(&examples, Kind::OutOfStep);
            let words = format!("the meshes of clip walk seem to be {words}: the error of LBS is ");
            assert!(found.text.starts_with(&words), "{speed} {swell}: {}", found.text);
        }
    }
}

#[test]
fn meshes_that_are_late_in_a_part_of_a_clip_are_reported() {
    for (speed, swell) in [(1.0, 0.0), (1.0, 0.1), (4.0, 0.0), (4.0, 0.1)] {
        for (frames, first) in [(30..60, 30), (20..60, 20)] {
            let mut examples = bending(speed, swell);
            late(&mut examples, frames.clone(), 1);
            let found = only_warning(&examples, Kind::OutOfStep);
            let [at] = self::frames(&found)[..] else { panic!("{}", found.text) };
            assert!(at.abs_diff(first) <= 2, "{speed} {swell} {frames:?}: {}", found.text);
            assert!(found.text.contains("one frame late in the frames "), "{}", found.text);
        }
    }
}

#[test]
fn a_faulty_frame_is_reported_besides_late_meshes() {
    let mut examples = bending(1.0, 0.0);
    late(&mut examples, 0..60, 1);
    explode(&mut examples, 20, 0.05);
    let found = check(&examples);
    let broken = found.find(Kind::Broken).map(frames);
    assert!(found.find(Kind::OutOfStep).is_some() && broken == Some(vec![19]), "{found:#?}");
}

#[test]
fn frames_are_named_by_clip_and_held_out_frames_are_no_repeats() {
    let mut examples = arm();
    copy(&mut examples, 13, 30);
    copy(&mut examples, 14, 31);
    examples.split[31] = Split::HeldOut;
    let clip = |name: &str, first, len| Clip {
        name: name.to_owned(),
        first,
        times: (0..len).map(f64::from).collect(),
        numbers: None,
    };
    let clips = [clip("walk", 0, 25), clip("run", 25, 15)];
    let found = sinew_trainer::check::check(&examples, &clips, &Silent).unwrap();
    let repeated = found.find(Kind::Repeated).unwrap();
    assert!(
        repeated.text.ends_with("another, and may be left out: 30 (run 5) as 13 (walk 13)"),
        "{}",
        repeated.text
    );
}

#[test]
fn meshes_in_another_order_of_clips_are_reported() {
    let right = arm();
    let mut examples = right.clone();
    let (walk, stretch) = right.vertices.split_at(right.vertex_len() * 16);
    examples.vertices = [stretch, walk].concat();
    let clip = |name: &str, first: usize, len: usize| {
        let times = (0..len).map(|frame| frame as f64 / 30.0).collect();
        Clip { name: name.to_owned(), first, times, numbers: None }
    };
    let clips = [clip("walk", 0, 16), clip("stretch", 16, 24)];
    let check =
        |examples: &Examples| sinew_trainer::check::check(examples, &clips, &Silent).unwrap();
    let found = check(&examples);
    let order = found.find(Kind::ClipOrder).unwrap();
    let words = "the meshes fit the clips in another order, stretch, walk: vertices are then ";
    assert!(order.text.starts_with(words), "{}", order.text);
    assert_eq!((order.severity, frames(order)), (Severity::Warning, vec![0, 16]));
    assert!(check(&right).find(Kind::ClipOrder).is_none());
}

/// Makes sixteen frames in which the hinges sway by up to `sway` degrees, then five that bend both
/// hinges, or only the second.
fn action(sway: [f64; 2], both: bool) -> Examples {
    let idle =
        (0..16).map(|k| [0, 1].map(|hinge| sway[hinge] * (1.7 * k as f64 + hinge as f64).sin()));
    let bent = [25.0, 50.0, 70.0, 55.0, 30.0].map(|b| [if both { 0.8 * b } else { 0.0 }, b]);
    let train = |angles| (angles, Split::Train);
    chain(&idle.chain(bent).map(train).collect::<Vec<_>>())
}

#[test]
fn frames_that_alone_move_a_joint_are_not_called_wrong() {
    for sway in [[0.0, 0.0], [0.5, 0.5], [3.0, 3.0], [10.0, 10.0], [60.0, 0.0], [60.0, 2.0]] {
        for both in [false, true] {
            let found = check(&action(sway, both));
            assert!(!kinds(&found).contains(&Kind::Broken), "{sway:?} {both}: {found:#?}");
        }
    }
}

#[test]
fn an_exact_linear_skin_has_no_wrong_frames() {
    // Each vertex follows one joint, so LBS is exact up to rounding.
    let mut examples = action([0.0, 0.0], true);
    let (v, j) = (examples.vertex_len(), examples.joint_len());
    for frame in 0..examples.frame_len() {
        for (vertex, x) in examples.rest.iter().enumerate() {
            let joint = [1.0, 2.0].iter().filter(|hinge| x[0] > **hinge).count();
            let map = &examples.transforms[frame * j + joint];
            let at = |row: &[f64; 4]| row[0] * x[0] + row[1] * x[1] + row[2] * x[2] + row[3];
            examples.vertices[frame * v + vertex] =
                map.each_ref().map(|row| f64::from(at(row) as f32));
        }
    }
    let found = check(&examples);
    assert!(!kinds(&found).contains(&Kind::Broken), "{found:#?}");
}

/// Moves each vertex of a frame in a different direction, by `size` diagonals RMS.
fn explode(examples: &mut Examples, frame: usize, size: f64) {
    let (len, size) =
        (examples.vertex_len(), 2f64.sqrt() / 3f64.sqrt() * size * examples.diagonal());
    let own = examples.vertices[frame * len..][..len].as_flattened_mut();
    own.iter_mut()
        .enumerate()
        .for_each(|(i, x)| *x += size * (12.9898 * (i * i + frame) as f64).sin());
}

/// Makes frames at rest, then some that bend both hinges in different ways.
fn punch(rest: usize, bent: usize, swell: f64) -> Examples {
    let angles =
        |k: usize| [70.0 * (2.4 * k as f64 + 1.0).sin(), 80.0 * (1.9 * k as f64 + 2.0).cos()];
    let bent = (0..bent).map(angles);
    let all = std::iter::repeat_n([0.0; 2], rest).chain(bent);
    swelling(&all.map(|angles| (angles, Split::Train)).collect::<Vec<_>>(), swell)
}

#[test]
fn exact_frames_are_not_called_wrong_for_a_faulty_one_at_rest() {
    for (frames_len, bent) in
        [12, 20, 40].into_iter().flat_map(|n| (1..=6).map(move |bent| (n, bent)))
    {
        for size in [0.02, 0.2] {
            for faulty in [vec![3], vec![3, 5]] {
                let mut examples = punch(frames_len - bent, bent, 0.0);
                faulty.iter().for_each(|&frame| explode(&mut examples, frame, size));
                let found = check(&examples);
                let broken = found.find(Kind::Broken).unwrap();
                let mut named = frames(broken);
                named.sort_unstable();
                let case = format!("{bent} of {frames_len}, {size}");
                assert_eq!(named, faulty, "{case}: {}", broken.text);
                assert!(broken.text.contains("a training leaves out"), "{case}: {}", broken.text);
                assert!(!kinds(&found).contains(&Kind::VertexOrder), "{case}: {found:#?}");
            }
        }
    }
}

#[test]
fn frames_that_move_alone_and_bulge_are_not_called_wrong() {
    for (frames_len, bent) in
        [12, 20, 40].into_iter().flat_map(|n| (1..=6).map(move |bent| (n, bent)))
    {
        for faulty in [None, Some(3)] {
            let mut examples = punch(frames_len - bent, bent, 0.1);
            faulty.into_iter().for_each(|frame| explode(&mut examples, frame, 0.05));
            let named = check(&examples).find(Kind::Broken).map(frames);
            assert_eq!(named, faulty.map(|frame| vec![frame]), "{bent} of {frames_len}");
        }
    }
}

#[test]
fn the_error_of_a_wrong_frame_is_reported_with_the_usual_error() {
    let mut examples = punch(30, 6, 0.0);
    explode(&mut examples, 3, 0.05);
    let text = check(&examples).find(Kind::Broken).unwrap().text.clone();
    let expected = "frame 3 (off by 5.";
    assert!(
        text.contains(expected) && text.ends_with(" % of the diagonal, 0.00 % is usual)"),
        "{text}"
    );
    examples.space.unit = Some(1.0);
    let text = check(&examples).find(Kind::Broken).unwrap().text.clone();
    assert!(text.contains(" mm), 0.00 % is usual"), "{text}");
}
