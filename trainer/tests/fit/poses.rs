//! Tests on real sets which poses a runtime accepts for a skeleton.

use models::shared;
use sinew_runtime::envelope::{Certificate, HelperKind, PoseFaultKind as Kind};
use sinew_runtime::{Envelope, Matrix3x4, Model, gather_pose};
use sinew_trainer::envelope::lbs::poses::Poses;
use sinew_trainer::envelope::model::{EnvelopeModel, FileModel};
use sinew_trainer::examples::{Examples, Split, npz};

/// Reads a set, and makes a file of its joints and of the range of its training poses.
fn set(file: &str) -> Option<(Examples, Vec<u8>)> {
    let examples = npz::load(&shared(file)?).unwrap().examples;
    let poses = Poses::new(&examples, &examples.frames_of(Split::Train));
    let skeleton = examples.skeleton.clone();
    let origins: Vec<_> = skeleton.rest.iter().map(|m| m.map(|row| row[3]).into()).collect();
    let envelope = EnvelopeModel {
        name: "joints".to_owned(),
        reconstruction: None,
        groups: Vec::new(),
        helper_kind: HelperKind::Affine,
        places: Vec::new(),
        pose_ranges: poses.angle_ranges(),
        pose_gaps: poses.gaps(&skeleton.parents, &origins),
        stretch_ranges: None,
        curves: Vec::new(),
        certificate: Certificate { diagonal: examples.diagonal() as f32, ..Certificate::default() },
        skeleton,
    };
    let file = FileModel { envelopes: vec![envelope], ..FileModel::default() };
    Some((examples, file.bake().unwrap()))
}

/// Returns the poses of all frames in f32, as an engine has them.
fn poses(examples: &Examples) -> Vec<Vec<Matrix3x4>> {
    let single = |m: &[[f64; 4]; 3]| m.map(|row| row.map(|x| x as f32));
    let pose = |frame| examples.pose(frame).iter().map(single).collect();
    (0..examples.frame_len()).map(pose).collect()
}

/// Converts a matrix to other axes: axis i becomes axis `axes[i]`, counted from 1 and negative if
/// flipped. Lengths are multiplied by `factor`.
fn converted(m: &Matrix3x4, axes: [i8; 3], factor: f32) -> Matrix3x4 {
    let mut out = [[0.0; 4]; 3];
    for (r, row) in m.iter().enumerate() {
        let place = |axis: usize| usize::from(axes[axis].unsigned_abs()) - 1;
        let sign = |axis: usize| f32::from(axes[axis].signum());
        for c in 0..3 {
            out[place(r)][place(c)] = sign(r) * sign(c) * row[c];
        }
        out[place(r)][3] = factor * sign(r) * row[3];
    }
    out
}

fn transposed(m: &Matrix3x4, keeps_shift: bool) -> Matrix3x4 {
    let mut out = *m;
    for (r, row) in out.iter_mut().enumerate() {
        for c in 0..3 {
            row[c] = m[c][r];
        }
        row[3] *= f32::from(u8::from(keeps_shift));
    }
    out
}

fn scaled(m: &Matrix3x4, factor: f32) -> Matrix3x4 {
    m.map(|row| row.map(|x| factor * x))
}

/// A mistake, its conversion, the factor that undoes its lengths, and its expected name.
type Mistake = (&'static str, fn(&Matrix3x4) -> Matrix3x4, f32, Kind);

const MISTAKES: [Mistake; 9] = [
    ("metres", |m| converted(m, [1, 2, 3], 0.1), 10.0, Kind::Units),
    ("millimetres", |m| converted(m, [1, 2, 3], 100.0), 0.01, Kind::Units),
    ("y up", |m| converted(m, [1, -3, 2], 1.0), 1.0, Kind::Axes),
    ("x up", |m| converted(m, [2, 3, 1], 1.0), 1.0, Kind::Axes),
    ("mirrored axis", |m| converted(m, [-1, 2, 3], 1.0), 1.0, Kind::Handedness),
    ("swapped axes", |m| converted(m, [1, 3, 2], 1.0), 1.0, Kind::Handedness),
    ("left-handed centimetres", |m| converted(m, [2, 1, 3], 10.0), 0.1, Kind::Handedness),
    ("transposed", |m| transposed(m, true), 1.0, Kind::Transposed),
    ("transposed and cut", |m| transposed(m, false), 1.0, Kind::Transposed),
];

/// Counts the refused poses, and the poses refused with the right name and factor.
fn named(
    envelope: &Envelope<'_>,
    poses: &[Vec<Matrix3x4>],
    (_, _, factor, kind): &Mistake,
) -> [usize; 2] {
    let faults = poses.iter().filter_map(|pose| envelope.check_pose(pose, &[]).err());
    faults.fold([0, 0], |[refused, right], fault| {
        let has_name = fault.kind == *kind && (fault.factor / factor - 1.0).abs() < 0.01;
        [refused + 1, right + usize::from(has_name)]
    })
}

#[test]
fn poses_of_a_body_are_accepted_and_mistakes_named() {
    let Some((examples, file)) = set("mpfb-body/mpfb_body.npz") else { return };
    let model = Model::from_bytes(file).unwrap();
    let envelope = model.first::<Envelope>().unwrap();
    let poses = poses(&examples);
    assert_eq!(poses.len(), 220);
    for pose in &poses {
        assert_eq!(envelope.check_pose(pose, &[]), Ok(()));
    }
    let all = poses.len();
    let enough = |[refused, right]: [usize; 2], what: &str| {
        println!("{what}: {refused} of {all} refused, {right} by name");
        assert!(refused == all && 100 * right >= 95 * all, "{what}: {refused}, {right}");
    };
    let each = |change: &dyn Fn(&Matrix3x4) -> Matrix3x4| -> Vec<Vec<Matrix3x4>> {
        poses.iter().map(|pose| pose.iter().map(change).collect()).collect()
    };
    let larger = ("scaled", |m: &Matrix3x4| scaled(m, 1.1), 1.1, Kind::Scaled);
    enough(named(&envelope, &each(&larger.1), &(larger.0, larger.1, larger.2, larger.3)), "scaled");
    let mirrored: Mistake = ("mirrored", |m| [m[0].map(|x| -x), m[1], m[2]], 1.0, Kind::Mirrored);
    enough(named(&envelope, &each(&mirrored.1), &mirrored), "mirrored");
    let map: Vec<u32> = (0..envelope.joint_len() as u32).collect();
    let frames: Vec<Vec<Matrix3x4>> = poses
        .iter()
        .map(|pose| {
            let rest =
                |(joint, m): (usize, &Matrix3x4)| after(m, &envelope.rest_frame(joint).unwrap());
            pose.iter().enumerate().map(rest).collect()
        })
        .collect();
    for mistake in &MISTAKES {
        enough(named(&envelope, &each(&mistake.1), mistake), mistake.0);
        // Repeats the test with frames, which are gathered with the file's inverse bind matrices.
        let gathered: Vec<_> = frames
            .iter()
            .map(|frames| {
                let frames: Vec<_> = frames.iter().map(mistake.1).collect();
                let mut pose = vec![[[0.0; 4]; 3]; map.len()];
                gather_pose(&envelope, &map, &frames, None, &mut pose).unwrap();
                pose
            })
            .collect();
        enough(named(&envelope, &gathered, mistake), &format!("frames, {}", mistake.0));
    }
    let gathered = |frames: &Vec<Matrix3x4>| {
        let mut pose = vec![[[0.0; 4]; 3]; map.len()];
        gather_pose(&envelope, &map, frames, None, &mut pose).unwrap();
        pose
    };
    let local = |frames: &Vec<Matrix3x4>| -> Vec<Matrix3x4> {
        let above = |joint: usize| Some(inverse(&frames[envelope.parent(joint)?]));
        let all = frames.iter().enumerate();
        all.map(|(joint, m)| above(joint).map_or(*m, |above| after(&above, m))).collect()
    };
    let locals: Vec<_> = frames.iter().map(local).collect();
    for (what, kind, poses) in [
        ("no inverse bind", Kind::Frames, frames.clone()),
        ("inverse bind twice", Kind::BoundTwice, poses.iter().map(gathered).collect()),
        ("local", Kind::Local, locals.clone()),
        ("local, gathered", Kind::Local, locals.iter().map(gathered).collect()),
        ("zero", Kind::Unset, vec![vec![[[0.0; 4]; 3]; map.len()]; all]),
    ] {
        enough(named(&envelope, &poses, &(what, |m| *m, 1.0, kind)), what);
    }
}

/// Inverts a rigid matrix.
fn inverse(m: &Matrix3x4) -> Matrix3x4 {
    std::array::from_fn(|r| {
        let [x, y, z] = m.map(|row| row[r]);
        [x, y, z, -(x * m[0][3] + y * m[1][3] + z * m[2][3])]
    })
}

fn after(a: &Matrix3x4, b: &Matrix3x4) -> Matrix3x4 {
    let entry = |row: &[f32; 4], c: usize| {
        let shift = if c == 3 { row[3] } else { 0.0 };
        (0..3).map(|k| row[k] * b[k][c]).sum::<f32>() + shift
    };
    a.map(|row| std::array::from_fn(|c| entry(&row, c)))
}

#[test]
fn joints_that_part_are_accepted_within_their_trained_range() {
    let Some((examples, file)) = set("dem-bones/bone.npz") else { return };
    let model = Model::from_bytes(file).unwrap();
    let envelope = model.first::<Envelope>().unwrap();
    let poses = poses(&examples);
    assert_eq!(poses.len(), 400);
    let gaps: Vec<_> = (0..envelope.joint_len()).map(|j| envelope.pose_gap(j).unwrap()).collect();
    for pose in &poses {
        assert_eq!(envelope.check_pose(pose, &[]), Ok(()));
    }
    assert!(gaps.iter().any(|gap| *gap > 0.01 * envelope.certificate().diagonal), "{gaps:?}");
}
