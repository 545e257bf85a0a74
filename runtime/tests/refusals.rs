//! What a caller does wrong is refused, and nothing is written.
#![allow(clippy::unwrap_used, reason = "a test's helpers fail as the test does")]

mod common;

use common::{IDENTITY, SMALL, Shape, attribute, with_envelope, with_predictor};
use sinew_runtime::envelope::{
    Attribute, Buffer, SkinJob, confidence, correction, gradients, joints, palette,
};
use sinew_runtime::format::Predictor;
use sinew_runtime::pose::features;
use sinew_runtime::{Argument, Envelope, EvalError, Matrix3x4};

#[test]
fn a_refused_palette_writes_nothing() {
    Predictor::ALL.into_iter().for_each(refused_palette);
}

fn refused_palette(predictor: Predictor) {
    with_predictor(predictor, SMALL, |envelope| {
        let (j, p) = (envelope.joint_len(), envelope.palette_len());
        let pose = vec![IDENTITY; j];
        let least = envelope.workspace_len();
        let refused = |pose: &[Matrix3x4], workspace_len: usize, out_len: usize| {
            let mut workspace = vec![-7.0; workspace_len];
            let mut out = vec![[[-7.0; 4]; 3]; out_len];
            let error = envelope.palette(pose, &mut workspace, &mut out).unwrap_err();
            if predictor == Predictor::Rotational {
                let same = envelope.rotational_palette(pose, &mut workspace, &mut out);
                assert_eq!(same, Err(error));
            }
            assert_eq!(workspace, vec![-7.0; workspace_len]);
            assert_eq!(out, vec![[[-7.0; 4]; 3]; out_len]);
            error
        };
        let length = |argument, expected, found| EvalError::Length { argument, expected, found };
        assert_eq!(refused(&pose[1..], least, p), length(Argument::Pose, j, j - 1));
        assert_eq!(refused(&pose, least, p + 1), length(Argument::Palette, p, p + 1));
        assert_eq!(
            refused(&pose, least - 1, p),
            EvalError::TooShort { argument: Argument::Workspace, least, found: least - 1 }
        );
        for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            for joint in 0..j {
                for entry in 0..12 {
                    let mut pose = pose.clone();
                    pose[joint].as_flattened_mut()[entry] = value;
                    assert_eq!(refused(&pose, least, p), EvalError::NonFinite { joint });
                }
            }
        }
    });
}

#[test]
fn refused_stages_write_nothing() {
    let length = |argument, expected, found| EvalError::Length { argument, expected, found };
    with_envelope(SMALL, |envelope| {
        let (j, p) = (envelope.joint_len(), envelope.proxy_len());
        let pose = vec![IDENTITY; j];
        let mut short = vec![[-7.0; 3]; 4 * j - 1];
        let error = gradients::evaluate(
            &envelope,
            &pose,
            &mut short,
            &mut vec![[0.0; 3]; j],
            &mut vec![[0.0; 3]; 3 * p],
        );
        assert_eq!(error, Err(length(Argument::Relative, 4 * j, 4 * j - 1)));
        let error = confidence::evaluate(&envelope, &short[..j - 1]);
        assert_eq!(error, Err(length(Argument::Rotations, j, j - 1)));
    });
    for predictor in [Predictor::Kernel, Predictor::Hybrid] {
        with_predictor(predictor, SMALL, |envelope| refused_correction(&envelope));
    }
}

fn refused_correction(envelope: &Envelope<'_>) {
    let length = |argument, expected, found| EvalError::Length { argument, expected, found };
    let (j, len, least) = (4, envelope.palette_len(), envelope.scratch_len());
    let pose = vec![IDENTITY; j];
    let refused = |joints: usize, phi: usize, scratch: usize, out: usize| {
        let (mut scratch, mut out) = (vec![-7.0; scratch], vec![[[-7.0; 4]; 3]; out]);
        let (pose, phi) = (&vec![IDENTITY; joints], &vec![IDENTITY; phi]);
        let error = correction::evaluate(envelope, pose, phi, &mut scratch, &mut out).unwrap_err();
        let written = out.as_flattened().as_flattened().iter().chain(&scratch).any(|&x| x != -7.0);
        assert!(!written);
        error
    };
    assert_eq!(refused(j - 1, j, least, len), length(Argument::Pose, j, j - 1));
    assert_eq!(refused(j, j + 1, least, len), length(Argument::Features, j, j + 1));
    let short = EvalError::TooShort { argument: Argument::Scratch, least, found: least - 1 };
    assert_eq!(refused(j, j, least - 1, len), short);
    assert_eq!(refused(j, j, least, len + 1), length(Argument::Palette, len, len + 1));

    let features = |pose: &[Matrix3x4], len: usize| {
        let mut out = vec![[[-7.0; 4]; 3]; len];
        let error = features::evaluate(envelope, pose, &mut out).unwrap_err();
        assert_eq!(out, vec![[[-7.0; 4]; 3]; len]);
        error
    };
    assert_eq!(features(&pose[1..], j), length(Argument::Pose, j, j - 1));
    assert_eq!(features(&pose, j - 1), length(Argument::Features, j, j - 1));
    let mut unsound = pose.clone();
    unsound[2][1][3] = f32::NAN;
    assert_eq!(features(&unsound, j), EvalError::NonFinite { joint: 2 });
    if envelope.predictor() == Predictor::Kernel {
        let mut out = vec![[[-7.0; 4]; 3]; len];
        let error = joints::evaluate(envelope, &unsound, &mut out);
        assert_eq!(error, Err(EvalError::NonFinite { joint: 2 }));
        assert_eq!(out, vec![[[-7.0; 4]; 3]; len]);
        let error = joints::evaluate(envelope, &pose, &mut out[1..]);
        assert_eq!(error, Err(length(Argument::Palette, len, len - 1)));
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
            let mut scratch = vec![0.0; envelope.scratch_len()];
            let of = |is_part: bool, result: Result<(), EvalError>| {
                let other = Err(EvalError::Predictor { found: predictor });
                assert_eq!(result, if is_part { Ok(()) } else { other });
            };
            let (base, corrects) = (predictor.reconstructs(), predictor.corrects());
            of(base, gradients::evaluate(&envelope, &pose, &mut q, &mut theta, &mut d));
            of(base, palette::evaluate(&envelope, &pose[0], &q, &d, &mut out));
            of(!base, joints::evaluate(&envelope, &pose, &mut out));
            of(corrects, features::evaluate(&envelope, &pose, &mut phi));
            let corrected = correction::evaluate(&envelope, &pose, &phi, &mut scratch, &mut out);
            of(corrects, corrected.map(|_| ()));
        });
    }
    let error = EvalError::Predictor { found: Predictor::Kernel };
    assert_eq!(error.to_string(), "predictor kernel has no such stage");
}

#[test]
fn a_refused_skin_job_writes_nothing() {
    let refuse = |shape: Shape, edit: &dyn Fn(&mut SkinJob<'_>)| {
        let mut error = None;
        with_envelope(shape, |envelope| {
            let v = envelope.vertex_len();
            let maps = vec![IDENTITY; envelope.palette_len()];
            let (mut a, mut b) = (vec![-7.0; 6 * v], vec![-7.0; 4 * v]);
            let mut job = SkinJob {
                envelope,
                palette: &maps,
                vertices: 0..v,
                positions: attribute(Buffer::A, 0, 6),
                normals: attribute(Buffer::A, 3, 6),
                tangents: envelope.has_tangents().then_some(Attribute {
                    buffer: Buffer::B,
                    offset: 0,
                    stride: 4,
                }),
                out_a: &mut a,
                out_b: &mut b,
            };
            edit(&mut job);
            error = job.run().err();
            assert!(error.is_none() || a.iter().chain(&b).all(|&x| x == -7.0));
        });
        error
    };
    let v = SMALL.vertices;
    assert_eq!(refuse(SMALL, &|_| {}), None);
    assert_eq!(
        refuse(SMALL, &|job| job.palette = &job.palette[1..]),
        Some(EvalError::Length { argument: Argument::Palette, expected: 3, found: 2 })
    );
    for (start, end) in [(0, v + 1), (v + 1, v + 1), (usize::MAX, 0), (2, 1)] {
        assert_eq!(
            refuse(SMALL, &|job| job.vertices = start..end),
            Some(EvalError::VertexRange { start, end, vertex_len: v })
        );
    }
    assert_eq!(
        refuse(SMALL, &|job| job.positions = attribute(Buffer::A, 0, 2)),
        Some(EvalError::Stride { least: 3, found: 2 })
    );
    assert_eq!(
        refuse(SMALL, &|job| job.tangents = attribute(Buffer::B, 0, 3)),
        Some(EvalError::Stride { least: 4, found: 3 })
    );
    assert_eq!(
        refuse(SMALL, &|job| job.normals = attribute(Buffer::A, 4, 6)),
        Some(EvalError::TooShort { argument: Argument::OutA, least: 6 * v + 1, found: 6 * v })
    );
    assert_eq!(
        refuse(SMALL, &|job| job.tangents = attribute(Buffer::B, usize::MAX - 2, 4)),
        Some(EvalError::TooShort { argument: Argument::OutB, least: usize::MAX, found: 4 * v })
    );
    let none = Shape { tangents: false, ..SMALL };
    assert_eq!(
        refuse(none, &|job| job.tangents = attribute(Buffer::B, 0, 4)),
        Some(EvalError::NoTangents)
    );
}
