//! Mistakes of a caller are refused, and nothing is written.

use crate::common::{
    IDENTITY, call_error, length_error, short_error, stage_error, with_envelope, with_predictor,
    with_skin,
};
use models::{JOINTLESS, Pieces, SMALL, STRETCHING, Shape, cells};
use sinew_runtime::envelope::Predictor;
use sinew_runtime::skin::Output;
use sinew_runtime::{
    Argument, CallError, CallErrorKind as Kind, Envelope, Matrix3x4, Model, Skin, SkinJob, stages,
};
use std::cell::Cell;

fn not_finite(joint: usize) -> CallError {
    CallError { index: joint, ..call_error(Kind::NonFinite, Argument::Pose) }
}

fn curve_not_finite(curve: usize) -> CallError {
    CallError { index: curve, ..call_error(Kind::NonFinite, Argument::Curves) }
}

/// Each predictor with shapes of every kind.
fn each() -> impl Iterator<Item = (Predictor, Shape)> {
    let of = |predictor: Predictor| [SMALL, STRETCHING].map(|shape| (predictor, shape));
    Predictor::ALL.into_iter().flat_map(of).chain([(Predictor::Kernel, JOINTLESS)])
}

#[test]
fn a_refused_palette_writes_nothing() {
    each().for_each(|(predictor, shape)| refused_palette(predictor, shape));
}

fn refused_palette(predictor: Predictor, shape: Shape) {
    with_predictor(predictor, shape, |envelope| {
        let (j, c, p) = (envelope.joint_len(), envelope.curve_len(), envelope.palette_len());
        let (pose, curves) = (vec![IDENTITY; j], vec![0.0; c]);
        let least = envelope.scratch_len();
        let refused = |pose: &[Matrix3x4], curves: &[f32], scratch_len: usize, out_len: usize| {
            let mut scratch = vec![-7.0; scratch_len];
            let mut out = vec![[[-7.0; 4]; 3]; out_len];
            let error = envelope.palette(pose, curves, &mut scratch, &mut out).unwrap_err();
            let same = envelope.base_palette(pose, curves, &mut scratch, &mut out);
            assert_eq!(same, Err(error));
            if predictor == Predictor::Rotational && error.argument != Argument::Curves {
                let same = envelope.rotational_palette(pose, &mut scratch, &mut out);
                assert_eq!(same, Err(error));
            }
            let mut confidence = [-7.0];
            let same = envelope.palettes(pose, curves, &mut scratch, &mut out, &mut confidence);
            assert_eq!((same, confidence), (Err(error), [-7.0]));
            assert_eq!(scratch, vec![-7.0; scratch_len]);
            assert_eq!(out, vec![[[-7.0; 4]; 3]; out_len]);
            error
        };
        let one_more = vec![IDENTITY; j + 1];
        let expected = length_error(Argument::Pose, j, j + 1);
        assert_eq!(refused(&one_more, &curves, least, p), expected);
        let expected = length_error(Argument::Curves, c, c + 1);
        assert_eq!(refused(&pose, &vec![0.0; c + 1], least, p), expected);
        if c > 0 {
            let expected = length_error(Argument::Curves, c, c - 1);
            assert_eq!(refused(&pose, &curves[1..], least, p), expected);
        }
        let expected = length_error(Argument::Palette, p, p + 1);
        assert_eq!(refused(&pose, &curves, least, p + 1), expected);
        let short = short_error(Argument::Scratch, least, least - 1);
        assert_eq!(refused(&pose, &curves, least - 1, p), short);
        for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            for (joint, entry) in (0..j).flat_map(|joint| (0..12).map(move |entry| (joint, entry)))
            {
                let mut pose = pose.clone();
                pose[joint].as_flattened_mut()[entry] = value;
                assert_eq!(refused(&pose, &curves, least, p), not_finite(joint));
            }
            for curve in 0..c {
                let mut curves = curves.clone();
                curves[curve] = value;
                assert_eq!(refused(&pose, &curves, least, p), curve_not_finite(curve));
            }
        }
    });
}

#[test]
fn refused_confidences_write_nothing() {
    with_predictor(Predictor::Kernel, STRETCHING, |envelope| {
        let (pose, least) = (vec![IDENTITY; 4], envelope.scratch_len());
        let refused = |pose: &[Matrix3x4], curves: &[f32], scratch_len: usize| {
            let (mut scratch, mut out) = (vec![-7.0; scratch_len], [-7.0; 4]);
            let error = envelope.joint_confidences(pose, curves, &mut scratch, &mut out);
            assert!(scratch.iter().chain(&out).all(|x| *x == -7.0));
            error.unwrap_err()
        };
        assert_eq!(refused(&pose[1..], &[0.0; 3], least), length_error(Argument::Pose, 4, 3));
        assert_eq!(refused(&pose, &[0.0; 2], least), length_error(Argument::Curves, 3, 2));
        let short = short_error(Argument::Scratch, least, least - 1);
        assert_eq!(refused(&pose, &[0.0; 3], least - 1), short);
        assert_eq!(refused(&pose, &[0.0, 0.0, f32::NAN], least), curve_not_finite(2));
    });
}

#[test]
fn a_refused_batch_writes_nothing() {
    for (predictor, shape) in each() {
        with_predictor(predictor, shape, |envelope| {
            let (j, c, p) = (envelope.joint_len(), envelope.curve_len(), envelope.palette_len());
            let (poses, curves) = (vec![IDENTITY; 3 * j], vec![0.0; 3 * c]);
            let least = envelope.scratch_len();
            let refused = |poses: &[Matrix3x4], curves: &[f32], lens: [usize; 3]| {
                let mut scratch = vec![-7.0; lens[0]];
                let mut out = vec![[[-7.0; 4]; 3]; lens[1]];
                let mut confidences = vec![-7.0; lens[2]];
                let (to, found) = (&mut out, &mut confidences);
                let result = envelope.palettes(poses, curves, &mut scratch, to, found);
                let floats = out.as_flattened().as_flattened().iter().chain(&scratch);
                assert!(floats.chain(&confidences).all(|&x| x == -7.0));
                result.unwrap_err()
            };
            if j > 0 {
                let pose = Argument::Pose;
                let expected = length_error(pose, 2 * j, 3 * j);
                assert_eq!(refused(&poses, &curves, [least, 3 * p, 2]), expected);
                let expected = length_error(pose, 3 * j, 3 * j - 1);
                assert_eq!(refused(&poses[1..], &curves, [least, 3 * p, 3]), expected);
                // Only the last pose is invalid, and none is evaluated.
                let mut unsound = poses.clone();
                unsound[3 * j - 1][1][3] = f32::NAN;
                let found = refused(&unsound, &curves, [least, 3 * p, 3]);
                assert_eq!(found, not_finite(3 * j - 1));
            }
            if c > 0 {
                let expected = length_error(Argument::Curves, 3 * c, 3 * c - 1);
                assert_eq!(refused(&poses, &curves[1..], [least, 3 * p, 3]), expected);
                let mut unsound = curves.clone();
                unsound[3 * c - 1] = f32::INFINITY;
                let found = refused(&poses, &unsound, [least, 3 * p, 3]);
                assert_eq!(found, curve_not_finite(3 * c - 1));
            }
            let expected = length_error(Argument::Palette, 3 * p, 2 * p);
            assert_eq!(refused(&poses, &curves, [least, 2 * p, 3]), expected);
            let short = short_error(Argument::Scratch, least, least - 1);
            assert_eq!(refused(&poses, &curves, [least - 1, 3 * p, 3]), short);
        });
    }
}

/// A rotation of stage polar: three columns.
const TURN: [[f32; 3]; 3] = [[-7.0; 3]; 3];
/// A strain of stage polar.
const STRAIN: [f32; 6] = [-7.0; 6];

#[test]
fn refused_stages_write_nothing() {
    for shape in [SMALL, STRETCHING] {
        with_envelope(shape, |envelope| refused_gradients(&envelope));
        with_predictor(Predictor::Kernel, shape, |envelope| refused_correction(&envelope));
    }
    with_predictor(Predictor::Kernel, STRETCHING, |envelope| {
        let pose = vec![IDENTITY; 4];
        let refused = |pose: &[Matrix3x4], turn_len: usize, strain_len: usize| {
            let (mut turns, mut strains) = (vec![TURN; turn_len], vec![STRAIN; strain_len]);
            let error = stages::polar(&envelope, pose, &mut turns, &mut strains).unwrap_err();
            assert!(turns.iter().all(|turn| *turn == TURN));
            assert!(strains.iter().all(|strain| *strain == STRAIN));
            error
        };
        assert_eq!(refused(&pose[1..], 4, 4), length_error(Argument::Pose, 4, 3));
        assert_eq!(refused(&pose, 3, 4), length_error(Argument::Turns, 4, 3));
        assert_eq!(refused(&pose, 4, 5), length_error(Argument::Strains, 4, 5));
        let mut unsound = pose.clone();
        unsound[2][1][3] = f32::NAN;
        assert_eq!(refused(&unsound, 4, 4), not_finite(2));
    });
}

/// Number of rotations and strains that later stages take: J, or 0 if no joint stretches.
fn split_len(envelope: &Envelope<'_>) -> usize {
    if envelope.stretches() { envelope.joint_len() } else { 0 }
}

fn refused_gradients(envelope: &Envelope<'_>) {
    let (j, p, split) = (envelope.joint_len(), envelope.proxy_len(), split_len(envelope));
    let pose = vec![IDENTITY; j];
    let refused = |relative: usize, turns: usize, strains: usize| {
        let mut q = vec![[-7.0; 3]; relative];
        let (mut theta, mut d) = (vec![[-7.0; 3]; j], vec![[-7.0; 3]; 3 * p]);
        let (turns, strains) = (vec![TURN; turns], vec![STRAIN; strains]);
        let split = (&turns[..], &strains[..]);
        let error = stages::gradients(envelope, &pose, split, &mut q, &mut theta, &mut d);
        assert!(q.iter().chain(&theta).chain(&d).all(|column| *column == [-7.0; 3]));
        error.unwrap_err()
    };
    let expected = length_error(Argument::Relative, 4 * j, 4 * j - 1);
    assert_eq!(refused(4 * j - 1, split, split), expected);
    let expected = length_error(Argument::Turns, split, split + 1);
    assert_eq!(refused(4 * j, split + 1, split), expected);
    let expected = length_error(Argument::Strains, split, split + 1);
    assert_eq!(refused(4 * j, split, split + 1), expected);

    let (theta, strains) = (vec![[0.0; 3]; j], vec![STRAIN; split]);
    let error = stages::confidence(envelope, &pose, &theta[1..], &strains);
    assert_eq!(error, Err(length_error(Argument::Rotations, j, j - 1)));
    let error = stages::confidence(envelope, &pose[1..], &theta, &strains);
    assert_eq!(error, Err(length_error(Argument::Pose, j, j - 1)));
    let error = stages::confidence(envelope, &pose, &theta, &vec![STRAIN; split + 1]);
    assert_eq!(error, Err(length_error(Argument::Strains, split, split + 1)));
}

fn refused_correction(envelope: &Envelope<'_>) {
    let (j, len, least) = (4, envelope.palette_len(), envelope.correction_len());
    let (c, f, split) =
        (envelope.curve_len(), envelope.counts().feature_len(), split_len(envelope));
    let pose = vec![IDENTITY; j];
    let refused = |joints: usize, phi: usize, scratch: usize, out: usize| {
        let (mut scratch, mut out) = (vec![-7.0; scratch], vec![[[-7.0; 4]; 3]; out]);
        let (pose, phi) = (&vec![IDENTITY; joints], &vec![0.0; phi]);
        let error = stages::correction(envelope, pose, phi, &mut scratch, &mut out).unwrap_err();
        let written = out.as_flattened().as_flattened().iter().chain(&scratch).any(|&x| x != -7.0);
        assert!(!written);
        error
    };
    assert_eq!(refused(j - 1, f, least, len), length_error(Argument::Pose, j, j - 1));
    assert_eq!(refused(j, f + 1, least, len), length_error(Argument::Features, f, f + 1));
    let short = short_error(Argument::Scratch, least, least - 1);
    assert_eq!(refused(j, f, least - 1, len), short);
    assert_eq!(refused(j, f, least, len + 1), length_error(Argument::Palette, len, len + 1));

    let features = |pose: &[Matrix3x4], curves: &[f32], turn_len: usize, len: usize| {
        let (mut out, turns) = (vec![-7.0; len], vec![TURN; turn_len]);
        let error = stages::features(envelope, pose, curves, &turns, &mut out).unwrap_err();
        assert_eq!(out, vec![-7.0; len]);
        error
    };
    let curves = &vec![0.0; c][..];
    let expected = length_error(Argument::Pose, j, j - 1);
    assert_eq!(features(&pose[1..], curves, split, f), expected);
    let expected = length_error(Argument::Features, f, f - 1);
    assert_eq!(features(&pose, curves, split, f - 1), expected);
    let expected = length_error(Argument::Turns, split, split + 1);
    assert_eq!(features(&pose, curves, split + 1, f), expected);
    let expected = length_error(Argument::Curves, c, c + 1);
    assert_eq!(features(&pose, &vec![0.0; c + 1], split, f), expected);
    if c > 0 {
        let expected = curve_not_finite(c - 1);
        assert_eq!(features(&pose, &[&curves[1..], &[f32::NAN]].concat(), split, f), expected);
    }
    let mut unsound = pose.clone();
    unsound[2][1][3] = f32::NAN;
    assert_eq!(features(&unsound, curves, split, f), not_finite(2));
    let mut out = vec![[[-7.0; 4]; 3]; len];
    let error = stages::joints(envelope, &unsound, &mut out);
    assert_eq!(error, Err(not_finite(2)));
    assert_eq!(out, vec![[[-7.0; 4]; 3]; len]);
    let error = stages::joints(envelope, &pose, &mut out[1..]);
    assert_eq!(error, Err(length_error(Argument::Palette, len, len - 1)));
}

#[test]
fn stages_of_another_predictor_are_refused() {
    for (predictor, shape) in each().filter(|(_, shape)| shape.joints > 0) {
        with_predictor(predictor, shape, |envelope| {
            let pose = vec![IDENTITY; 4];
            let (mut q, mut theta, mut d) = (vec![[0.0; 3]; 16], vec![[0.0; 3]; 4], [[0.0; 3]; 9]);
            let mut out = vec![IDENTITY; envelope.palette_len()];
            let mut phi = vec![0.0; envelope.counts().feature_len()];
            let curves = vec![0.0; envelope.curve_len()];
            let mut scratch = vec![0.0; envelope.correction_len()];
            let (mut turns, mut strains) = (vec![TURN; 4], vec![STRAIN; 4]);
            let of = |is_part: bool, result: Result<(), CallError>| {
                let other = Err(stage_error(predictor));
                assert_eq!(result, if is_part { Ok(()) } else { other });
            };
            let (base, corrects) = (predictor.reconstructs(), predictor.corrects());
            of(shape.stretches, stages::polar(&envelope, &pose, &mut turns, &mut strains));
            let split = split_len(&envelope);
            let split = (&turns[..split], &strains[..split]);
            of(base, stages::gradients(&envelope, &pose, split, &mut q, &mut theta, &mut d));
            of(base, stages::palette(&envelope, &pose[0], &q, &d, &mut out));
            of(!base, stages::joints(&envelope, &pose, &mut out));
            of(corrects, stages::features(&envelope, &pose, &curves, split.0, &mut phi));
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
    edit: impl for<'a> Fn(SkinJob<'a>, &'a Lent<'a>) -> SkinJob<'a>,
) -> Option<CallError> {
    let mut error = None;
    with_skin(shape, |envelope, skin| {
        let palette = vec![IDENTITY; envelope.palette_len()];
        let v = skin.vertex_len();
        let (mut a, mut b) = (vec![-7.0; 6 * v], vec![-7.0; 4 * v]);
        {
            let lent = Lent { a: cells(&mut a), b: cells(&mut b) };
            let job = SkinJob::new(skin, &palette)
                .positions(Output::shared(lent.a, 6))
                .normals(Output::shared(&lent.a[3..], 6))
                .tangents(Some(Output::shared(lent.b, 4)).filter(|_| skin.has_tangents()));
            error = edit(job, &lent).run().err();
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
    assert_eq!(refuse(SMALL, |job, _| job), None);
    let error = refuse(SMALL, |job, _| job.positions(None).normals(None).tangents(None)).unwrap();
    assert_eq!(error, call_error(Kind::NoOutput, Argument::Call));
    assert_eq!(error.to_string(), "nothing to write to");
    with_skin(SMALL, |_, skin| {
        let (palette, mut out) = ([IDENTITY; 2], vec![-7.0; 3 * v]);
        let refused = SkinJob::new(skin, &palette).positions(Output::new(&mut out, 3)).run();
        assert_eq!(refused, Err(length_error(Argument::Palette, 3, 2)));
        assert!(out.iter().all(|&x| x == -7.0));
    });
    for (start, end) in [(0, v + 1), (v + 1, v + 1), (usize::MAX, 0), (2, 1)] {
        let error = call_error(Kind::OutOfRange, Argument::Vertices);
        assert_eq!(
            refuse(SMALL, |job, _| job.vertices(start..end)),
            Some(CallError { index: start, expected: v, found: end, ..error })
        );
    }
    let backwards =
        CallError { index: 5, found: 3, ..call_error(Kind::OutOfRange, Argument::Vertices) };
    assert_eq!(backwards.to_string(), "vertices: the range 5..3 ends before its start");
    let stride = |argument, expected, found| {
        Some(CallError { expected, found, ..call_error(Kind::Stride, argument) })
    };
    assert_eq!(
        refuse(SMALL, |job, lent| job.positions(Output::shared(lent.a, 2))),
        stride(Argument::Positions, 3, 2)
    );
    assert_eq!(
        refuse(SMALL, |job, lent| job.normals(Output::shared(lent.a, 0))),
        stride(Argument::Normals, 3, 0)
    );
    assert_eq!(
        refuse(SMALL, |job, lent| job.tangents(Output::shared(lent.b, 3))),
        stride(Argument::Tangents, 4, 3)
    );
    assert_eq!(
        refuse(SMALL, |job, lent| job.normals(Output::shared(&lent.a[4..], 6))),
        Some(short_error(Argument::Normals, 6 * v - 3, 6 * v - 4))
    );
    assert_eq!(
        refuse(SMALL, |job, lent| job.tangents(Output::shared(lent.b, usize::MAX))),
        Some(short_error(Argument::Tangents, usize::MAX, 4 * v))
    );
    assert_eq!(
        refuse(SMALL, |job, lent| job.tangents(Output::shared(&lent.b[..3], 4))),
        Some(short_error(Argument::Tangents, 4 * v, 3))
    );
    let none = Shape { tangents: false, ..SMALL };
    assert_eq!(
        refuse(none, |job, lent| job.tangents(Output::shared(lent.b, 4))),
        Some(call_error(Kind::NoAttribute, Argument::Tangents))
    );
}

#[test]
fn overlapping_attributes_are_refused() {
    let overlap = |argument| Some(call_error(Kind::Overlap, argument));
    // Positions have floats 0 to 2 of 6.
    for (from, expected) in [
        (0, overlap(Argument::Normals)),
        (1, overlap(Argument::Normals)),
        (2, overlap(Argument::Normals)),
        (3, None),
    ] {
        let found = refuse(SMALL, |job, lent| {
            // The last vertex has no float behind its normal.
            job.vertices(0..3).normals(Output::shared(&lent.a[from..], 6))
        });
        assert_eq!(found, expected, "{from}");
    }
    // Normals that reach into the next vertex's position.
    for from in [4, 5] {
        let found = refuse(SMALL, |job, lent| {
            job.vertices(0..3).normals(Output::shared(&lent.a[from..], 6))
        });
        assert_eq!(found, overlap(Argument::Normals), "{from}");
    }
    // One vertex behind the other in other strides is apart; mixed strides are not.
    let found = refuse(SMALL, |job, lent| {
        let (positions, normals) = lent.a.split_at(9);
        job.vertices(0..3)
            .positions(Output::shared(positions, 3))
            .normals(Output::shared(normals, 4))
    });
    assert_eq!(found, None);
    let found = refuse(SMALL, |job, lent| {
        let (positions, normals) = (lent.a, &lent.a[8..]);
        job.vertices(0..3)
            .positions(Output::shared(positions, 3))
            .normals(Output::shared(normals, 4))
    });
    assert_eq!(found, overlap(Argument::Normals));
    let found = refuse(SMALL, |job, lent| job.tangents(Output::shared(&lent.a[2..], 6)));
    assert_eq!(found, overlap(Argument::Tangents));
    assert_eq!(found.unwrap().to_string(), "tangents: overlap another attribute in memory");
}

#[test]
fn a_refused_remap_or_rest_mesh_writes_nothing() {
    const V: usize = SMALL.vertices;
    static BEYOND: [u32; 6] = [0, 6, 7, 3, u32::MAX, 1];
    let beyond = |vertices: std::ops::Range<usize>| {
        refuse(SMALL, |job, _| job.remap(&BEYOND).vertices(vertices.clone()))
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
    for len in [V - 1, V + 1] {
        let (three, error) = (&POSITIONS[..len], length_error(Argument::Call, V, len));
        let expected = CallError { argument: Argument::RestPositions, ..error };
        assert_eq!(refuse(SMALL, |job, _| job.rest_positions(three)), Some(expected));
        let expected = CallError { argument: Argument::RestNormals, ..error };
        assert_eq!(refuse(SMALL, |job, _| job.rest_normals(three)), Some(expected));
    }
    let tangents = refuse(SMALL, |job, _| job.rest_tangents(&TANGENTS[1..]));
    assert_eq!(tangents, Some(length_error(Argument::RestTangents, V, V - 1)));
    // The caller's tangents replace missing tangents of the skin.
    let none = Shape { tangents: false, ..SMALL };
    let given =
        refuse(none, |job, lent| job.tangents(Output::shared(lent.b, 4)).rest_tangents(&TANGENTS));
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
        assert_eq!(error.to_string(), "rest offset: expected a finite number of at least 0");
        let mut short = vec![[-7.0; 3]; 6];
        let error = skin.skin_positions(&palette, &mut short);
        assert_eq!(error, Err(short_error(Argument::Positions, 21, 18)));
        let said = error.unwrap_err().to_string();
        assert_eq!(said, "positions: expected at least 21 floats, found 18");
        let error = skin.skin_positions(&palette[1..], &mut short);
        assert_eq!(error, Err(length_error(Argument::Palette, 3, 2)));
        assert_eq!(short, vec![[-7.0; 3]; 6]);
    });
    // A skin without an envelope takes no palette.
    let model = Model::from_bytes(Pieces::loose(SMALL).bytes()).unwrap();
    let error = model.first::<Skin>().unwrap().bounds(&[IDENTITY], 0.0);
    assert_eq!(error, Err(length_error(Argument::Palette, 0, 1)));
}
