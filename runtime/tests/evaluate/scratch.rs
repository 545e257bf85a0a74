//! Batches and scratch: the bits do not depend on the scratch.

use crate::common::{
    Stretched, bits, palette, palette_with, random_pose, short_error, stretched_pose,
    with_predictor, with_skin,
};
use models::{JOINTLESS, Rng, SMALL, STRETCHING, Shape, direction};
use sinew_runtime::envelope::{EnvelopeCounts, Predictor, scratch_len};
use sinew_runtime::skin::{CacheLine, Output};
use sinew_runtime::{Argument, Envelope, Matrix3x4, Skin, SkinJob};

#[test]
fn positions_with_scratch_have_the_bits_of_positions_without() {
    for influences in 1..=4 {
        with_skin(Shape { influences, vertices: 19, ..SMALL }, |envelope, skin| {
            let v = skin.vertex_len();
            let posed = |turn| palette(&envelope, &random_pose(&envelope, &mut Rng(5), turn));
            let all = |value| vec![[[value; 4]; 3]; envelope.palette_len()];
            let mut palettes = vec![posed(0.3), posed(8.0), all(0.0), all(-0.0), all(-1e-45)];
            palettes.push(all(1e38));
            for palette in palettes {
                for (stride, vertices) in [(3, 0..v), (3, 2..3), (4, 1..v), (8, 5..5), (3, 7..12)] {
                    let job = SkinJob::new(skin, &palette).vertices(vertices.clone());
                    let len = vertices.len() * stride + 5;
                    let (mut expected, mut found) = (vec![-7.0; len], vec![-7.0; len]);
                    job.clone().positions(Output::new(&mut expected, stride)).run().unwrap();
                    let mut scratch = vec![CacheLine::default(); skin.scratch_len()];
                    let out = Output::new(&mut found, stride);
                    let job = job.scratch(&mut scratch).positions(out);
                    job.run().unwrap();
                    job.run().unwrap();
                    assert_eq!(bits(&found), bits(&expected), "{influences}, {stride}");
                }
            }
        });
    }
}

#[test]
fn vector_units_have_the_bits_of_one_vertex_at_a_time() {
    for influences in [1, 2, 3, 4, 5, 16, 17] {
        for (tangents, coefficients) in [(true, true), (false, true), (true, false)] {
            // Two whole blocks and a part. Some vertices follow one transform.
            let shape = Shape { influences, vertices: 21, tangents, coefficients, ..SMALL };
            with_skin(shape, |envelope, skin| jobs_agree(&envelope, skin));
        }
    }
}

/// Compares jobs of all kinds with and without vector units.
fn jobs_agree(envelope: &Envelope<'_>, skin: Skin<'_>) {
    let v = skin.vertex_len();
    let mut rng = Rng(7);
    // A remap that jumps, and one that doubles some vertices, as seams do.
    let jumps: Vec<u32> = (0..3 * v).map(|i| (i * i % v) as u32).collect();
    let seams: Vec<u32> = (0..3 * v).map(|i| ((i - i / 3) % v) as u32).collect();
    let positions: Vec<_> = (0..v).map(|_| [(); 3].map(|()| rng.unit())).collect();
    let normals: Vec<_> = (0..v).map(|_| direction(&mut rng)).collect();
    let tangents: Vec<_> = normals.iter().map(|[x, y, z]| [*z, *x, *y, -1.0]).collect();
    let posed = |turn| palette(envelope, &random_pose(envelope, &mut Rng(5), turn));
    let all = |value| vec![[[value; 4]; 3]; envelope.palette_len()];
    // Transforms without directions, far ones, one for all vertices, and mirrored ones.
    let mut palettes = vec![posed(0.3), posed(8.0), all(0.0), all(-0.0), all(1e38), all(1e-30)];
    palettes.push(vec![posed(8.0)[0]; envelope.palette_len()]);
    palettes.push(posed(2.0).into_iter().map(|[x, y, z]| [x.map(|x| -x), y, z]).collect());
    for palette in &palettes {
        for kind in 0..6 {
            let job = SkinJob::new(skin, palette);
            let job = match kind % 3 {
                0 => job,
                1 => job.remap(&jumps),
                _ => job.remap(&seams),
            };
            let given = job.clone().rest_positions(&positions).rest_normals(&normals);
            let given = if skin.has_tangents() { given.rest_tangents(&tangents) } else { given };
            let job = if kind > 2 { given } else { job };
            for vertices in [0..v, 3..v, 2..7, 8..16, 5..5] {
                for attributes in 1..8 {
                    if attributes & 4 > 0 && !skin.has_tangents() {
                        continue;
                    }
                    let [expected, found] = [false, true].map(|by_vectors| {
                        let mut out = vec![-7.0; 12 * v];
                        let outputs = Output::interleaved(&mut out, 12, [0, 4, 8]);
                        let has = |at: usize| {
                            Some(outputs[at].clone()).filter(|_| attributes >> at & 1 > 0)
                        };
                        let job = job.clone().vertices(vertices.clone());
                        let job = job.positions(has(0)).normals(has(1)).tangents(has(2));
                        if by_vectors {
                            job.run().unwrap();
                        } else {
                            job.one_by_one(0..vertices.len()).unwrap();
                        }
                        out
                    });
                    assert_eq!(bits(&found), bits(&expected), "{kind} {vertices:?} {attributes}");
                }
            }
        }
    }
}

#[test]
fn scratch_of_a_job_that_is_too_short_is_refused() {
    with_skin(SMALL, |envelope, skin| {
        let palette = palette(&envelope, &random_pose(&envelope, &mut Rng(5), 0.3));
        let (mut out, least) = (vec![-7.0; 3 * skin.vertex_len()], skin.scratch_len());
        for found in [1, least - 1] {
            let mut scratch = vec![CacheLine::default(); found];
            let job = SkinJob::new(skin, &palette).scratch(&mut scratch);
            let refused = job.positions(Output::new(&mut out, 3)).run();
            assert_eq!(refused, Err(short_error(Argument::Scratch, least, found)));
        }
        assert!(out.iter().all(|x| *x == -7.0));
        let job = SkinJob::new(skin, &palette).scratch(&mut []);
        job.positions(Output::new(&mut out, 3)).run().unwrap();
    });
}

#[test]
fn a_batch_has_the_bits_of_single_poses() {
    for (predictor, shape) in each() {
        with_predictor(predictor, shape, |envelope| {
            let mut rng = Rng(17);
            let turns = [0.0, 0.05, 0.2, 1.0, 8.0];
            let poses = turns.map(|turn| {
                let Stretched { pose, curves, .. } = stretched_pose(&envelope, &mut rng, turn);
                (pose, curves)
            });
            let alone =
                poses.each_ref().map(|(pose, curves)| palette_with(&envelope, pose, curves));
            let expected = alone.each_ref().map(|(palette, _)| palette.as_slice()).concat();
            let mut out = vec![[[f32::NAN; 4]; 3]; expected.len()];
            let mut confidences = [f32::NAN; 5];
            let mut scratch = vec![f32::NAN; envelope.scratch_len()];
            let curves = poses.each_ref().map(|(_, curves)| curves.as_slice()).concat();
            let poses = poses.each_ref().map(|(pose, _)| pose.as_slice()).concat();
            let (to, found) = (&mut out, &mut confidences);
            envelope.palettes(&poses, &curves, &mut scratch, to, found).unwrap();
            let flat = |palettes: &[Matrix3x4]| bits(palettes.as_flattened().as_flattened());
            assert_eq!(flat(&out), flat(&expected));
            assert_eq!(bits(&confidences), bits(&alone.each_ref().map(|(_, found)| *found)));
            // The poses differ from each other.
            let first = envelope.palette_len();
            assert_ne!(out[..first], out[first..2 * first]);
            assert_eq!(envelope.palettes(&[], &[], &mut scratch, &mut [], &mut []), Ok(()));
        });
    }
}

/// Each predictor with shapes of every kind.
fn each() -> impl Iterator<Item = (Predictor, Shape)> {
    let of = |predictor: Predictor| [SMALL, STRETCHING].map(|shape| (predictor, shape));
    Predictor::ALL.into_iter().flat_map(of).chain([(Predictor::Kernel, JOINTLESS)])
}

/// Counts of a sample of 3 proxies.
const fn counts(predictor: Predictor, shape: Shape, correction_len: u32) -> EnvelopeCounts {
    let curves = if predictor.corrects() { shape.curves } else { 0 };
    EnvelopeCounts {
        predictor,
        joint_len: shape.joints as u32,
        proxy_len: 3,
        root: 0,
        group_len: 0,
        correction_len,
        stretches: shape.stretches,
        curve_len: curves as u32,
        helper_kind: shape.kind,
    }
}

#[test]
fn the_scratch_has_the_promised_length() {
    let len = |predictor, shape, correction| scratch_len(&counts(predictor, shape, correction));
    // 12 J + 3 J + 9 P, and 15 J more if joints stretch.
    assert_eq!(len(Predictor::Rotational, SMALL, 0), 87);
    assert_eq!(len(Predictor::Rotational, STRETCHING, 0), 87 + 60);
    // The features and the correction, and 9 J more if joints stretch; nothing without a correction.
    assert_eq!(len(Predictor::Kernel, SMALL, 40), 48 + 40);
    assert_eq!(len(Predictor::Kernel, STRETCHING, 40), 75 + 36 + 40);
    assert_eq!(len(Predictor::Kernel, JOINTLESS, 40), 5 + 40);
    assert_eq!(len(Predictor::Kernel, STRETCHING, 0), 0);
    for (predictor, shape) in each() {
        with_predictor(predictor, shape, |envelope| {
            let correction = if predictor.corrects() { 56 } else { 0 };
            assert_eq!(envelope.correction_len(), correction);
            assert_eq!(envelope.scratch_len(), len(predictor, shape, correction as u32));
            // The previous content does not matter.
            let pose = random_pose(&envelope, &mut Rng(9), 0.2);
            let curves = vec![0.25; envelope.curve_len()];
            let palettes = [0.0, f32::NAN, -3.0].map(|content| {
                let mut scratch = vec![content; envelope.scratch_len()];
                let mut out = vec![[[content; 4]; 3]; envelope.palette_len()];
                envelope.palette(&pose, &curves, &mut scratch, &mut out).unwrap();
                out
            });
            assert!(palettes[0] == palettes[1] && palettes[1] == palettes[2]);
        });
    }
}
