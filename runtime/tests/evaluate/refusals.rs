//! Mistakes of a caller are refused, and nothing is written.

use crate::common::{
    IDENTITY, call_error, job, length_error, output, short_error, stage_error, with_envelope,
    with_predictor, with_skin,
};
use models::{Pieces, SMALL, Shape};
use sinew_runtime::envelope::Predictor;
use sinew_runtime::skin::{Rest, cells};
use sinew_runtime::{
    Argument, CallError, CallErrorKind as Kind, Envelope, Matrix3x4, Model, SkinJob, stages,
};
use std::cell::Cell;

fn not_finite(joint: usize) -> CallError {
    CallError { index: joint, ..call_error(Kind::NonFinite, Argument::Pose) }
}

#[test]
fn a_refused_palette_writes_nothing() {
    Predictor::ALL.into_iter().for_each(refused_palette);
}

fn refused_palette(predictor: Predictor) {
    with_predictor(predictor, SMALL, |envelope| {
        let (j, p) = (envelope.joint_len(), envelope.palette_len());
        let pose = vec![IDENTITY; j];
        let least = envelope.scratch_len();
        let refused = |pose: &[Matrix3x4], scratch_len: usize, out_len: usize| {
            let mut scratch = vec![-7.0; scratch_len];
            let mut out = vec![[[-7.0; 4]; 3]; out_len];
            let error = envelope.palette(pose, &mut scratch, &mut out).unwrap_err();
            if predictor == Predictor::Rotational {
                let same = envelope.rotational_palette(pose, &mut scratch, &mut out);
                assert_eq!(same, Err(error));
            }
            let mut confidence = [-7.0];
            let same = envelope.palettes(pose, &mut scratch, &mut out, &mut confidence);
            assert_eq!((same, confidence), (Err(error), [-7.0]));
            assert_eq!(scratch, vec![-7.0; scratch_len]);
            assert_eq!(out, vec![[[-7.0; 4]; 3]; out_len]);
            error
        };
        assert_eq!(refused(&pose[1..], least, p), length_error(Argument::Pose, j, j - 1));
        assert_eq!(refused(&pose, least, p + 1), length_error(Argument::Palette, p, p + 1));
        let short = short_error(Argument::Scratch, least, least - 1);
        assert_eq!(refused(&pose, least - 1, p), short);
        for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            for joint in 0..j {
                for entry in 0..12 {
                    let mut pose = pose.clone();
                    pose[joint].as_flattened_mut()[entry] = value;
                    assert_eq!(refused(&pose, least, p), not_finite(joint));
                }
            }
        }
    });
}

#[test]
fn a_refused_batch_writes_nothing() {
    for predictor in Predictor::ALL {
        with_predictor(predictor, SMALL, |envelope| {
            let (j, p) = (envelope.joint_len(), envelope.palette_len());
            let poses = vec![IDENTITY; 3 * j];
            let least = envelope.scratch_len();
            let refused = |poses: &[Matrix3x4], scratch: usize, out: usize, confidences: usize| {
                let mut scratch = vec![-7.0; scratch];
                let mut out = vec![[[-7.0; 4]; 3]; out];
                let mut confidences = vec![-7.0; confidences];
                let result = envelope.palettes(poses, &mut scratch, &mut out, &mut confidences);
                let floats = out.as_flattened().as_flattened().iter().chain(&scratch);
                assert!(floats.chain(&confidences).all(|&x| x == -7.0));
                result.unwrap_err()
            };
            let pose = Argument::Pose;
            assert_eq!(refused(&poses, least, 3 * p, 2), length_error(pose, 2 * j, 3 * j));
            assert_eq!(refused(&poses[1..], least, 3 * p, 3), length_error(pose, 3 * j, 3 * j - 1));
            let palette = Argument::Palette;
            assert_eq!(refused(&poses, least, 2 * p, 3), length_error(palette, 3 * p, 2 * p));
            let short = short_error(Argument::Scratch, least, least - 1);
            assert_eq!(refused(&poses, least - 1, 3 * p, 3), short);
            // Only the last pose is invalid, and none is evaluated.
            let mut unsound = poses.clone();
            unsound[3 * j - 1][1][3] = f32::NAN;
            assert_eq!(refused(&unsound, least, 3 * p, 3), not_finite(3 * j - 1));
        });
    }
}

#[test]
fn refused_stages_write_nothing() {
    with_envelope(SMALL, |envelope| {
        let (j, p) = (envelope.joint_len(), envelope.proxy_len());
        let pose = vec![IDENTITY; j];
        let mut short = vec![[-7.0; 3]; 4 * j - 1];
        let (mut theta, mut d) = (vec![[-7.0; 3]; j], vec![[-7.0; 3]; 3 * p]);
        let error = stages::gradients(&envelope, &pose, &mut short, &mut theta, &mut d);
        assert_eq!(error, Err(length_error(Argument::Relative, 4 * j, 4 * j - 1)));
        let written = short.iter().chain(&theta).chain(&d).any(|column| *column != [-7.0; 3]);
        assert!(!written);
        let error = stages::confidence(&envelope, &short[..j - 1]);
        assert_eq!(error, Err(length_error(Argument::Rotations, j, j - 1)));
    });
    with_predictor(Predictor::Kernel, SMALL, |envelope| refused_correction(&envelope));
}

fn refused_correction(envelope: &Envelope<'_>) {
    let (j, len, least) = (4, envelope.palette_len(), envelope.correction_len());
    let pose = vec![IDENTITY; j];
    let refused = |joints: usize, phi: usize, scratch: usize, out: usize| {
        let (mut scratch, mut out) = (vec![-7.0; scratch], vec![[[-7.0; 4]; 3]; out]);
        let (pose, phi) = (&vec![IDENTITY; joints], &vec![IDENTITY; phi]);
        let error = stages::correction(envelope, pose, phi, &mut scratch, &mut out).unwrap_err();
        let written = out.as_flattened().as_flattened().iter().chain(&scratch).any(|&x| x != -7.0);
        assert!(!written);
        error
    };
    assert_eq!(refused(j - 1, j, least, len), length_error(Argument::Pose, j, j - 1));
    assert_eq!(refused(j, j + 1, least, len), length_error(Argument::Features, j, j + 1));
    let short = short_error(Argument::Scratch, least, least - 1);
    assert_eq!(refused(j, j, least - 1, len), short);
    assert_eq!(refused(j, j, least, len + 1), length_error(Argument::Palette, len, len + 1));

    let features = |pose: &[Matrix3x4], len: usize| {
        let mut out = vec![[[-7.0; 4]; 3]; len];
        let error = stages::features(envelope, pose, &mut out).unwrap_err();
        assert_eq!(out, vec![[[-7.0; 4]; 3]; len]);
        error
    };
    assert_eq!(features(&pose[1..], j), length_error(Argument::Pose, j, j - 1));
    assert_eq!(features(&pose, j - 1), length_error(Argument::Features, j, j - 1));
    let mut unsound = pose.clone();
    unsound[2][1][3] = f32::NAN;
    assert_eq!(features(&unsound, j), not_finite(2));
    if envelope.predictor() == Predictor::Kernel {
        let mut out = vec![[[-7.0; 4]; 3]; len];
        let error = stages::joints(envelope, &unsound, &mut out);
        assert_eq!(error, Err(not_finite(2)));
        assert_eq!(out, vec![[[-7.0; 4]; 3]; len]);
        let error = stages::joints(envelope, &pose, &mut out[1..]);
        assert_eq!(error, Err(length_error(Argument::Palette, len, len - 1)));
    }
}

#[test]
fn stages_of_another_predictor_are_refused() {
    for predictor in Predictor::ALL {
        with_predictor(predictor, SMALL, |envelope| {
            let pose = vec![IDENTITY; 4];
            let (mut q, mut theta, mut d) = (vec![[0.0; 3]; 16], vec![[0.0; 3]; 4], [[0.0; 3]; 9]);
            let mut out = vec![IDENTITY; envelope.palette_len()];
            let mut phi = vec![IDENTITY; 4];
            let mut scratch = vec![0.0; envelope.correction_len()];
            let of = |is_part: bool, result: Result<(), CallError>| {
                let other = Err(stage_error(predictor));
                assert_eq!(result, if is_part { Ok(()) } else { other });
            };
            let (base, corrects) = (predictor.reconstructs(), predictor.corrects());
            of(base, stages::gradients(&envelope, &pose, &mut q, &mut theta, &mut d));
            of(base, stages::palette(&envelope, &pose[0], &q, &d, &mut out));
            of(!base, stages::joints(&envelope, &pose, &mut out));
            of(corrects, stages::features(&envelope, &pose, &mut phi));
            let corrected = stages::correction(&envelope, &pose, &phi, &mut scratch, &mut out);
            of(corrects, corrected.map(|_| ()));
        });
    }
    let error = stage_error(Predictor::Kernel);
    assert_eq!(error.to_string(), "the stage is not part of the envelope's predictor, number 2");
}

/// Runs a job of the sample after `edit`. A refused job must write nothing.
fn refuse(
    shape: Shape,
    edit: impl for<'a> Fn(&mut SkinJob<'a>, &'a Lent<'a>),
) -> Option<CallError> {
    let mut error = None;
    with_skin(shape, |envelope, skin| {
        let palette = vec![IDENTITY; envelope.palette_len()];
        let v = skin.vertex_len();
        let (mut a, mut b) = (vec![-7.0; 6 * v], vec![-7.0; 4 * v]);
        {
            let lent = Lent { a: cells(&mut a), b: cells(&mut b) };
            let mut job = SkinJob {
                positions: output(lent.a, 6),
                normals: output(&lent.a[3..], 6),
                tangents: output(lent.b, 4).filter(|_| skin.has_tangents()),
                ..job(skin, &palette)
            };
            edit(&mut job, &lent);
            error = job.run().err();
        }
        assert!(error.is_none() || a.iter().chain(&b).all(|&x| x == -7.0));
    });
    error
}

/// Floats of a refused job: six per vertex, and four.
struct Lent<'a> {
    a: &'a [Cell<f32>],
    b: &'a [Cell<f32>],
}

#[test]
fn a_refused_skin_job_writes_nothing() {
    let v = SMALL.vertices;
    assert_eq!(refuse(SMALL, |_, _| {}), None);
    let nothing = |job: &mut SkinJob<'_>, _: &Lent<'_>| {
        (job.positions, job.normals, job.tangents) = (None, None, None);
    };
    let error = refuse(SMALL, nothing).unwrap();
    assert_eq!(error, call_error(Kind::NoOutput, Argument::Call));
    assert_eq!(error.to_string(), "nothing to write to");
    assert_eq!(
        refuse(SMALL, |job, _| job.palette = &job.palette[1..]),
        Some(length_error(Argument::Palette, 3, 2))
    );
    for (start, end) in [(0, v + 1), (v + 1, v + 1), (usize::MAX, 0), (2, 1)] {
        let error = call_error(Kind::OutOfRange, Argument::Vertices);
        assert_eq!(
            refuse(SMALL, |job, _| job.vertices = start..end),
            Some(CallError { index: start, expected: v, found: end, ..error })
        );
    }
    let stride = |argument, expected, found| {
        Some(CallError { expected, found, ..call_error(Kind::Stride, argument) })
    };
    assert_eq!(
        refuse(SMALL, |job, lent| job.positions = output(lent.a, 2)),
        stride(Argument::Positions, 3, 2)
    );
    assert_eq!(
        refuse(SMALL, |job, lent| job.normals = output(lent.a, 0)),
        stride(Argument::Normals, 3, 0)
    );
    assert_eq!(
        refuse(SMALL, |job, lent| job.tangents = output(lent.b, 3)),
        stride(Argument::Tangents, 4, 3)
    );
    assert_eq!(
        refuse(SMALL, |job, lent| job.normals = output(&lent.a[4..], 6)),
        Some(short_error(Argument::Normals, 6 * v - 3, 6 * v - 4))
    );
    assert_eq!(
        refuse(SMALL, |job, lent| job.tangents = output(lent.b, usize::MAX)),
        Some(short_error(Argument::Tangents, usize::MAX, 4 * v))
    );
    assert_eq!(
        refuse(SMALL, |job, lent| job.tangents = output(&lent.b[..3], 4)),
        Some(short_error(Argument::Tangents, 4 * v, 3))
    );
    let none = Shape { tangents: false, ..SMALL };
    assert_eq!(
        refuse(none, |job, lent| job.tangents = output(lent.b, 4)),
        Some(call_error(Kind::NoAttribute, Argument::Tangents))
    );
}

#[test]
fn a_refused_remap_or_rest_mesh_writes_nothing() {
    const V: usize = SMALL.vertices;
    static BEYOND: [u32; 6] = [0, 6, 7, 3, u32::MAX, 1];
    let beyond = |vertices: std::ops::Range<usize>| {
        refuse(SMALL, |job, _| (job.remap, job.vertices) = (Some(&BEYOND[..]), vertices.clone()))
    };
    let error = |index, found| {
        let error = call_error(Kind::OutOfRange, Argument::Remap);
        Some(CallError { index, expected: V - 1, found, ..error })
    };
    // Only the part of the remap inside the range is checked.
    assert_eq!((beyond(0..2), beyond(3..4), beyond(5..6)), (None, None, None));
    assert_eq!((beyond(0..3), beyond(2..5)), (error(2, 7), error(2, 7)));
    assert_eq!(beyond(3..6), error(4, u32::MAX as usize));
    // The range counts entries of the remap, which may be shorter or longer than the mesh.
    let range = call_error(Kind::OutOfRange, Argument::Vertices);
    assert_eq!(beyond(0..7), Some(CallError { expected: 6, found: 7, ..range }));

    static POSITIONS: [[f32; 3]; V + 1] = [[0.0; 3]; V + 1];
    static TANGENTS: [[f32; 4]; V] = [[1.0, 0.0, 0.0, 1.0]; V];
    let rest = |rest| refuse(SMALL, |job, _| job.rest = rest);
    for len in [V - 1, V + 1] {
        let (three, argument) = (Some(&POSITIONS[..len]), length_error(Argument::Call, V, len));
        let positions = Rest { positions: three, ..Rest::default() };
        let expected = CallError { argument: Argument::RestPositions, ..argument };
        assert_eq!(rest(positions), Some(expected));
        let normals = Rest { normals: three, ..Rest::default() };
        let expected = CallError { argument: Argument::RestNormals, ..argument };
        assert_eq!(rest(normals), Some(expected));
    }
    let tangents = Rest { tangents: Some(&TANGENTS[1..]), ..Rest::default() };
    assert_eq!(rest(tangents), Some(length_error(Argument::RestTangents, V, V - 1)));
    // The caller's tangents replace missing tangents of the skin.
    let none = Shape { tangents: false, ..SMALL };
    let given = refuse(none, |job, lent| {
        job.tangents = output(lent.b, 4);
        job.rest.tangents = Some(&TANGENTS);
    });
    assert_eq!(given, None);
}

#[test]
fn refused_bounds_say_why() {
    with_skin(SMALL, |envelope, skin| {
        let palette = vec![IDENTITY; envelope.palette_len()];
        let short = skin.bounds(&palette[1..], 0.0);
        assert_eq!(short, Err(length_error(Argument::Palette, 3, 2)));
        let error = call_error(Kind::OutOfRange, Argument::RestPositions);
        for offset in [-1e-9, f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            assert_eq!(skin.bounds(&palette, offset), Err(error), "{offset}");
        }
        let mut short = vec![[-7.0; 3]; 6];
        let error = skin.skin_positions(&palette, &mut short);
        assert_eq!(error, Err(short_error(Argument::Positions, 21, 18)));
        let error = skin.skin_positions(&palette[1..], &mut short);
        assert_eq!(error, Err(length_error(Argument::Palette, 3, 2)));
        assert_eq!(short, vec![[-7.0; 3]; 6]);
    });
    // A skin without an envelope takes no palette.
    let model = Model::from_bytes(Pieces::loose(SMALL).bytes()).unwrap();
    let error = model.skin().unwrap().bounds(&[IDENTITY], 0.0);
    assert_eq!(error, Err(length_error(Argument::Palette, 0, 1)));
}
