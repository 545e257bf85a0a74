//! Characters for the tests to damage.

use nalgebra::{Isometry3, Point3, Rotation3, Translation3, Vector3};
use sinew_runtime::format::Space;
use sinew_trainer::check::Check;
use sinew_trainer::check::finding::{Finding, Kind, Place};
use sinew_trainer::examples::demo::{DemoOptions, demo};
use sinew_trainer::examples::{Clip, Examples, Matrix3x4, Skeleton, Split};
use sinew_trainer::progress::Silent;

/// Makes the demo's arm, with the rest pose as frame 0.
pub(crate) fn arm() -> Examples {
    let mut arm = demo(&DemoOptions { vertices: 300, poses: 40, held_out: 0, seed: 5 });
    let (v, j) = (arm.vertex_len(), arm.joint_len());
    arm.vertices[..v].copy_from_slice(&arm.rest);
    arm.transforms[..j].fill([[1.0, 0., 0., 0.], [0., 1.0, 0., 0.], [0., 0., 1.0, 0.]]);
    arm
}

/// Angles of a chain's two hinges in degrees, and the use of the frame.
pub(crate) type Bend = ([f64; 2], Split);

/// Lists bends that cover both hinges, alone and together.
pub(crate) fn bends() -> Vec<Bend> {
    let angles = [0.0, 20.0, 40.0, 60.0, 80.0];
    let both = |a| angles.map(|b| ([a, b], Split::Train));
    angles.into_iter().flat_map(both).collect()
}

/// Makes a bar along x on joints `root`, `upper` at x = 1 and `lower` at x = 2, which rotate about
/// z. Its skin follows the nearer joint, half of each at a hinge, and swells as the square of the
/// angles.
pub(crate) fn chain(bends: &[Bend]) -> Examples {
    swelling(bends, 0.1)
}

/// Makes the bar of [`chain`], with a skin that swells by `most` at an angle of 2 rad; without
/// swelling, the skin is linear.
pub(crate) fn swelling(bends: &[Bend], most: f64) -> Examples {
    let ring = |x: f64| [[x, 0.2, 0.2], [x, -0.2, 0.2], [x, -0.2, -0.2], [x, 0.2, -0.2]];
    let rings = 13;
    let rest: Vec<[f64; 3]> = (0..rings).flat_map(|k| ring(0.25 * k as f64)).collect();
    let side = |k: usize, s: usize| {
        let [a, b] = [4 * k + s, 4 * k + (s + 1) % 4];
        [[a, b, a + 4], [b, b + 4, a + 4]]
    };
    let triangles = (0..rings - 1).flat_map(|k| (0..4).flat_map(move |s| side(k, s))).collect();
    let shares = |x: f64, at: f64| ((x - at) / 0.5 + 0.5).clamp(0.0, 1.0);
    let (mut vertices, mut transforms) = (Vec::new(), Vec::new());
    for ([first, second], _) in bends {
        let upper = hinge(1.0, *first);
        let lower = upper * hinge(2.0, *second);
        for x in &rest {
            let swell = |angle: f64| most * (angle.to_radians() / 2.0).powi(2);
            let mut at = Point3::from(*x);
            at.z *= 1.0 + swell(*first) * shares(x[0], 0.5) + swell(*second) * shares(x[0], 1.5);
            let [a, b] = [shares(x[0], 1.0), shares(x[0], 2.0)];
            let mixed = at.coords * (1.0 - a)
                + (upper * at).coords * (a * (1.0 - b))
                + (lower * at).coords * (a * b);
            vertices.push(mixed.into());
        }
        transforms.extend([rows(&Isometry3::identity()), rows(&upper), rows(&lower)]);
    }
    let at = |x| rows(&Isometry3::from(Translation3::new(x, 0.0, 0.0)));
    Examples {
        rest,
        triangles,
        engine: None,
        skeleton: Skeleton {
            names: ["root", "upper", "lower"].map(str::to_owned).into(),
            parents: vec![None, Some(0), Some(1)],
            rest: vec![at(0.0), at(1.0), at(2.0)],
            ..Skeleton::default()
        },
        vertices,
        transforms,
        curve_names: Vec::new(),
        curves: Vec::new(),
        split: bends.iter().map(|bend| bend.1).collect(),
        ranges: Vec::new(),
        clip_starts: vec![0],
        space: Space::default(),
        joint_weights: None,
        importance: None,
        frame_weights: None,
        own_skin: false,
    }
}

fn hinge(x: f64, degrees: f64) -> Isometry3<f64> {
    let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), degrees.to_radians());
    let about = Translation3::new(x, 0.0, 0.0);
    about * Isometry3::from_parts(Translation3::identity(), turn.into()) * about.inverse()
}

fn rows(map: &Isometry3<f64>) -> Matrix3x4 {
    let m = map.to_homogeneous();
    [0, 1, 2].map(|r| [0, 1, 2, 3].map(|c| m[(r, c)]))
}

/// Checks a character whose frames are one clip.
pub(crate) fn check(examples: &Examples) -> Check {
    let times = (0..examples.frame_len()).map(|frame| frame as f64 / 30.0).collect();
    let clip = Clip { name: "walk".to_owned(), first: 0, times, numbers: None };
    sinew_trainer::check::check(examples, &[clip], &Silent).unwrap()
}

pub(crate) fn kinds(check: &Check) -> Vec<Kind> {
    check.findings.iter().map(|finding| finding.kind).collect()
}

/// Asserts a single finding of this kind.
#[track_caller]
pub(crate) fn only(examples: &Examples, kind: Kind) -> Finding {
    let mut found = check(examples).findings;
    assert!(found.len() == 1 && found[0].kind == kind, "{kind:?} expected: {found:#?}");
    found.remove(0)
}

/// Lists the frames among the places of a finding, in order.
pub(crate) fn frames(finding: &Finding) -> Vec<usize> {
    let frame =
        |place: &Place| if let Place::Frame(name) = place { Some(name.frame) } else { None };
    finding.places.iter().filter_map(frame).collect()
}

/// Lists the triangles among the places of a finding, in order.
pub(crate) fn triangles(finding: &Finding) -> Vec<usize> {
    let number = |place: &Place| if let Place::Triangle(t) = place { Some(*t) } else { None };
    finding.places.iter().filter_map(number).collect()
}

/// Lists the names of the joints among the places of a finding, in order.
pub(crate) fn joints(finding: &Finding) -> Vec<&str> {
    let mut names = Vec::new();
    for place in &finding.places {
        if let Place::Joint(name) = place {
            names.push(name.as_str());
        }
    }
    names
}
