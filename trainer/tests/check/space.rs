//! Checks of scale, place, and the common space of mesh and skeleton.

use super::made::{arm, check, frames, kinds, only};
use nalgebra::{Matrix3, Vector3};
use sinew_trainer::check::Check;
use sinew_trainer::check::finding::{Kind, Severity};
use sinew_trainer::envelope::{Options, train};
use sinew_trainer::examples::{Clip, Examples, Matrix3x4};
use sinew_trainer::progress::Silent;

type Points = [[f64; 3]];

fn apply(points: &mut Points, linear: &Matrix3<f64>, shift: &Vector3<f64>) {
    points.iter_mut().for_each(|x| *x = (linear * Vector3::from(*x) + shift).into());
}

/// Converts maps for points that were moved by `y = linear x + shift`; `linear` is a rotation times
/// a scale.
fn conjugate(maps: &mut [Matrix3x4], linear: &Matrix3<f64>, shift: &Vector3<f64>) {
    let inverse = linear.try_inverse().unwrap();
    for map in maps {
        let own = Matrix3::from_fn(|r, c| map[r][c]);
        let turned = linear * own * inverse;
        let moved = linear * Vector3::from_fn(|r, _| map[r][3]) + shift - turned * shift;
        *map = [0, 1, 2].map(|r| [turned[(r, 0)], turned[(r, 1)], turned[(r, 2)], moved[r]]);
    }
}

fn moved(linear: Matrix3<f64>, shift: Vector3<f64>) -> Examples {
    let mut examples = arm();
    apply(&mut examples.rest, &linear, &shift);
    apply(&mut examples.vertices, &linear, &shift);
    conjugate(&mut examples.transforms, &linear, &shift);
    for map in &mut examples.skeleton.rest {
        let at = linear * Vector3::from_fn(|r, _| map[r][3]) + shift;
        (0..3).for_each(|r| map[r][3] = at[r]);
    }
    examples
}

fn scale(factor: f64) -> Matrix3<f64> {
    Matrix3::identity() * factor
}

/// y-up to z-up: 90 degrees about x.
fn z_up() -> Matrix3<f64> {
    Matrix3::new(1.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 1.0, 0.0)
}

#[test]
fn the_size_reveals_the_unit() {
    let of = |factor| check(&moved(scale(factor), Vector3::zeros())).size;
    for (factor, unit) in [(1.0, "metres"), (100.0, "centimetres"), (1000.0, "millimetres")] {
        let size = of(factor);
        let (units, metres): (Vec<_>, Vec<_>) = size.units.into_iter().unzip();
        assert_eq!(units, [unit]);
        assert!((metres[0] - 0.88).abs() < 0.02, "{metres:?}");
        assert!((size.extents[0] / size.diagonal - 0.93).abs() < 0.02 && size.longest == 'x');
    }
    let odd = only(&moved(scale(1e-3), Vector3::zeros()), Kind::OddSize);
    assert_eq!(odd.severity, Severity::Note);
}

#[test]
fn a_known_unit_is_held_against_the_size() {
    let of = |unit| {
        let mut examples = moved(scale(100.0), Vector3::zeros());
        examples.space.unit = Some(unit);
        examples
    };
    let odd = only(&of(1.0), Kind::OddSize);
    assert!(odd.text.contains("in centimetres it would be 0.87 m"), "{}", odd.text);
    let size = check(&of(0.01)).size;
    assert!((size.metres.unwrap() - 0.88).abs() < 0.02, "{size:?}");
    assert!(check(&of(0.01)).find(Kind::OddSize).is_none());
}

#[test]
fn the_ground_is_the_axis_on_which_the_mesh_stands() {
    let mut standing = arm();
    let lowest = standing.rest.iter().map(|x| x[1]).fold(f64::INFINITY, f64::min);
    assert_eq!(check(&standing).size.ground, None);
    standing = moved(scale(1.0), Vector3::new(3.0, -lowest, 3.0));
    assert_eq!(check(&standing).size.ground, Some('y'));
}

#[test]
fn distance_from_the_origin_costs_bits() {
    let far = |x: f64| moved(scale(1.0), Vector3::new(x, 0.0, 0.0));
    let note = only(&far(20.0), Kind::FarAway);
    assert_eq!(note.severity, Severity::Note);
    assert!(note.text.contains("costs 4 of the 24 bits"), "{}", note.text);
    assert_eq!(only(&far(200.0), Kind::FarAway).severity, Severity::Warning);
}

#[test]
fn other_units_are_named_with_their_file() {
    let mut rest = arm();
    apply(&mut rest.rest, &scale(100.0), &Vector3::zeros());
    let found = check(&rest);
    let text = &found.find(Kind::OtherUnits).unwrap().text;
    assert!(text.starts_with("the rest mesh should be 0.01 times the size"), "{text}");

    let mut posed = arm();
    apply(&mut posed.vertices, &scale(0.1), &Vector3::zeros());
    let found = check(&posed);
    let text = &found.find(Kind::OtherUnits).unwrap().text;
    assert!(text.starts_with("the posed meshes should be 10 times the size"), "{text}");

    let mut joints = arm();
    conjugate(&mut joints.transforms, &scale(0.01), &Vector3::zeros());
    let found = check(&joints);
    let text = &found.find(Kind::OtherUnits).unwrap().text;
    assert!(text.starts_with("the joints should be 100 times the size"), "{text}");
}

#[test]
fn other_axes_are_named_with_their_file() {
    let zero = Vector3::zeros();
    let mut rest = arm();
    apply(&mut rest.rest, &z_up(), &zero);
    let mut posed = arm();
    apply(&mut posed.vertices, &z_up(), &zero);
    let mut joints = arm();
    conjugate(&mut joints.transforms, &z_up(), &zero);
    // The remedy converts (x, -z, y) back to (x, y, z).
    for (examples, what) in
        [(rest, "the rest mesh"), (posed, "the posed meshes"), (joints, "the joints")]
    {
        let found = check(&examples);
        let text = &found.find(Kind::OtherAxes).unwrap().text;
        assert!(text.starts_with(&format!("{what} should have the axes (x, z, -y)")), "{text}");
    }
}

#[test]
fn a_shift_is_measured() {
    let by = Vector3::new(0.3, -0.4, 0.1);
    let mut rest = arm();
    apply(&mut rest.rest, &scale(1.0), &by);
    let mut joints = arm();
    conjugate(&mut joints.transforms, &scale(1.0), &by);
    for (examples, what) in [(rest, "the rest mesh"), (joints, "the joints")] {
        let found = check(&examples);
        let text = &found.find(Kind::Shifted).unwrap().text;
        let numbers = text.strip_prefix(&format!("{what} should be moved by (")).expect(text);
        let numbers: Vec<f64> =
            numbers[..numbers.find(')').unwrap()].split(", ").map(|x| x.parse().unwrap()).collect();
        let off = Vector3::from_column_slice(&numbers) + by;
        assert!(off.norm() < 0.03, "{text}");
    }
}

#[test]
fn vertices_in_another_order_are_reported() {
    let mut examples = arm();
    let len = examples.vertex_len();
    examples.vertices.chunks_mut(len).for_each(<[_]>::reverse);
    let found = check(&examples);
    let order = found.find(Kind::VertexOrder).unwrap();
    assert_eq!(order.severity, Severity::Warning);
    let words = "the posed meshes have the vertices of the rest mesh in another order: export both";
    assert!(order.text.starts_with(words), "{}", order.text);
}

/// Moves the mesh of a frame by `by` diagonals along y.
fn lift(examples: &mut Examples, frame: usize, by: f64) {
    let (len, diagonal) = (examples.vertex_len(), examples.diagonal());
    examples.vertices[frame * len..][..len].iter_mut().for_each(|x| x[1] += by * diagonal);
}

#[test]
fn meshes_with_a_motion_that_the_joints_lack_are_reported() {
    let mut travelling = arm();
    (0..40).for_each(|frame| lift(&mut travelling, frame, 0.1 * frame as f64));
    let found = check(&travelling);
    let elsewhere = found.find(Kind::Elsewhere).unwrap();
    assert_eq!(elsewhere.severity, Severity::Warning);
    assert!(
        elsewhere.text.contains("perhaps the root moves only in the meshes or only in the joints")
    );
    assert!(frames(elsewhere).len() >= 20);
}

#[test]
fn frames_with_a_common_motion_are_named_without_other_findings() {
    for moved in [5..14, 5..23] {
        let mut examples = arm();
        moved.clone().for_each(|frame| lift(&mut examples, frame, 0.2));
        let broken = only(&examples, Kind::Broken);
        let mut named = frames(&broken);
        named.sort_unstable();
        assert_eq!(named, Vec::from_iter(moved.clone()));
        let stay = broken.text.contains("training keeps them");
        assert_eq!(stay, moved.len() > 10, "{}", broken.text);
    }
}

/// Checks the arm as two clips, `walk` of `walk` frames and `reach`, after damaging the examples.
fn in_clips(walk: usize, spoil: impl Fn(&mut Examples)) -> Check {
    let clip = |name: &str, first: usize, end: usize| Clip {
        name: name.to_owned(),
        first,
        times: (first..end).map(|frame| frame as f64).collect(),
        numbers: None,
    };
    let mut examples = arm();
    examples.clip_starts = vec![0, walk];
    spoil(&mut examples);
    let clips = [clip("walk", 0, walk), clip("reach", walk, 40)];
    sinew_trainer::check::check(&examples, &clips, &Silent).unwrap()
}

#[test]
fn a_clip_in_another_space_is_named() {
    let in_space = |linear: Matrix3<f64>, shift: Vector3<f64>| {
        in_clips(25, |examples| {
            let len = examples.vertex_len();
            apply(&mut examples.vertices[25 * len..], &linear, &shift);
        })
    };
    let zero = Vector3::zeros();
    for (found, kind, words) in [
        (in_space(scale(100.0), zero), Kind::OtherUnits, "the posed meshes should be 0.01 times"),
        (in_space(z_up(), zero), Kind::OtherAxes, "the posed meshes should have the axes (x, z"),
        (in_space(scale(1.0), Vector3::y()), Kind::Shifted, "the posed meshes should be moved by"),
    ] {
        let [first, others @ ..] = &found.findings[..] else { panic!("{kind:?} expected") };
        assert_eq!((first.kind, first.severity), (kind, Severity::Warning));
        assert!(first.text.starts_with(&format!("in clip reach, {words}")), "{}", first.text);
        assert_eq!(frames(first), [25]);
        let broken = others.iter().filter(|other| other.kind == Kind::Broken);
        assert!(broken.flat_map(frames).all(|frame| frame >= 25), "{others:#?}");
    }
    assert!(in_space(scale(1.0), zero).findings.is_empty());
}

#[test]
fn a_short_clip_is_named_though_its_frames_are_left_out() {
    let found = in_clips(32, |examples| {
        let len = examples.vertex_len();
        apply(&mut examples.vertices[32 * len..], &scale(1.0), &Vector3::y());
    });
    let shifted = found.find(Kind::Shifted).unwrap();
    assert!(shifted.text.starts_with("in clip reach, the posed meshes should be moved by"));
    let broken = found.find(Kind::Broken).unwrap();
    assert!(broken.text.contains("a training leaves out the frames named here"), "{}", broken.text);
}

#[test]
fn frames_that_explode_are_no_wrong_clip() {
    let found = in_clips(25, |examples| {
        let (len, size) = (examples.vertex_len(), 0.07 * examples.diagonal());
        let exploding = examples.vertices[30 * len..36 * len].iter_mut().flatten().enumerate();
        exploding.for_each(|(i, x)| *x += size * (12.9898 * i as f64).sin());
    });
    let broken = found.find(Kind::Broken).unwrap();
    let mut named = frames(broken);
    named.sort_unstable();
    assert_eq!(named, Vec::from_iter(30..36));
    assert!(found.find(Kind::WrongClip).is_none(), "{found:#?}");
}

#[test]
fn a_clip_with_the_meshes_of_another_is_named() {
    let found = in_clips(25, |examples| {
        let len = examples.vertex_len();
        examples.vertices.copy_within(..15 * len, 25 * len);
    });
    let wrong = found.find(Kind::WrongClip).unwrap();
    assert_eq!((wrong.severity, frames(wrong)), (Severity::Warning, vec![25]));
    let words = "the meshes of clip reach do not belong to the joints";
    assert!(wrong.text.starts_with(words), "{}", wrong.text);
}

#[test]
fn clips_whose_joints_have_other_orders_are_reported() {
    let found = in_clips(25, |examples| {
        let joints = examples.joint_len();
        let poses = examples.transforms[25 * joints..].chunks_mut(joints);
        poses.for_each(|pose| pose.swap(1, 4));
    });
    let unlike = found.find(Kind::UnlikeClips).unwrap();
    assert_eq!((unlike.severity, frames(unlike)), (Severity::Warning, vec![0, 25]));
    assert!(unlike.text.starts_with("no weights fit all clips"), "{}", unlike.text);
}

/// Rounds positions and maps to single precision.
fn rounded(mut examples: Examples) -> Examples {
    let positions = examples.rest.iter_mut().chain(&mut examples.vertices).flatten();
    let maps = examples.transforms.iter_mut().flatten().flatten();
    positions.chain(maps).for_each(|x| *x = f64::from(*x as f32));
    examples
}

#[test]
fn a_character_too_far_from_the_origin_for_single_precision_is_refused() {
    let far =
        |diagonals: f64| moved(scale(1.0), Vector3::new(diagonals * arm().diagonal(), 0.0, 0.0));
    let examples = rounded(far(3e4));
    let found = check(&examples);
    let told = found.find(Kind::TooFar).unwrap();
    assert_eq!(kinds(&found), [Kind::TooFar], "{found:#?}");
    let words = " diagonals from the origin, where positions in single precision are 0.36 % of the diagonal apart: move ";
    assert!(
        told.text.starts_with("the character stands 29984") && told.text.contains(words),
        "{}",
        told.text
    );
    let error = train(&examples, &Options::default(), &Silent).err().unwrap();
    assert_eq!(error.to_string(), told.text);
    // Nearer to the origin, a rounded mesh does not look like another sculpt; positions in higher
    // precision may lie anywhere.
    for examples in [rounded(far(3e3)), far(3e4)] {
        let found = check(&examples);
        assert_eq!(kinds(&found), [Kind::FarAway], "{found:#?}");
    }
}
