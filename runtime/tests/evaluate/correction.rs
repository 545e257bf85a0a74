//! The kernel maps' correction against an independent evaluation in f64.

use crate::common::{
    IDENTITY, apart, bits, confident_palette, max_difference, random_pose, stage_error,
    with_predictor,
};
use models::{GroupContent, Pieces, Rng, SMALL, Shape, sample_groups};
use sinew_runtime::envelope::{GroupConfidence, GroupKernel, Predictor};
use sinew_runtime::format::SectionKind;
use sinew_runtime::{Envelope, Matrix3x4, Model, stages};

type Wide = [[f64; 4]; 3];

fn wide(m: &Matrix3x4) -> Wide {
    m.map(|row| row.map(f64::from))
}

/// Parents and origins of the sample's joints, repeated here.
fn skeleton(joints: usize) -> (Vec<Option<usize>>, Vec<[f64; 3]>) {
    let order = [1, 2, 0].into_iter().chain(3..joints).collect::<Vec<_>>();
    let mut parents = vec![None; joints];
    let mut origins = vec![[0.0; 3]; joints];
    for (rank, pair) in order.windows(2).enumerate() {
        parents[pair[1]] = Some(pair[0]);
        origins[pair[1]][0] = (rank + 1) as f64;
    }
    (parents, origins)
}

/// S - I for the rows of a rotation R, from its trace and its odd part. S rotates by half the angle
/// about the same axis; its odd part fades like the quaternion's w.
fn reference_half(r: [[f64; 3]; 3]) -> [[f64; 3]; 3] {
    let odd = [(2, 1), (0, 2), (1, 0)].map(|(a, b)| r[a][b] - r[b][a]);
    let length = odd.iter().map(|x| x * x).sum::<f64>().sqrt();
    let (sine, w) = (length.atan2(r[0][0] + r[1][1] + r[2][2] - 1.0) / 2.0).sin_cos();
    let [x, y, z] = odd.map(|value| value / length.max(1e-300));
    let cross = [[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]];
    let faded = sine * (1.0 - (1.0 - w).powi(8));
    [0, 1, 2].map(|a| {
        [0, 1, 2].map(|b| {
            let twice = (0..3).map(|k| cross[a][k] * cross[k][b]).sum::<f64>();
            faded * cross[a][b] + (1.0 - w) * twice
        })
    })
}

/// Features from the motion of points: a joint's axes and origin in its parent's frame, then half
/// of the rotation.
fn reference_features(pose: &[Matrix3x4]) -> Vec<f64> {
    let (parents, origins) = skeleton(pose.len());
    let mut out = Vec::new();
    for (joint, parent) in parents.iter().enumerate() {
        let Some(parent) = *parent else {
            out.extend([0.0; 12]);
            continue;
        };
        let (own, parent) = (wide(&pose[joint]), wide(&pose[parent]));
        let moved = |p: [f64; 3], w: f64| {
            let x = own.map(|m| m[0] * p[0] + m[1] * p[1] + m[2] * p[2] + m[3] * w);
            let x = [0, 1, 2].map(|r| x[r] - parent[r][3] * w);
            [0, 1, 2].map(|r| (0..3).map(|k| parent[k][r] * x[k]).sum::<f64>())
        };
        let axis = |c: usize| [0, 1, 2].map(|r| if r == c { 1.0 } else { 0.0 });
        let columns = [0, 1, 2].map(|c| moved(axis(c), 0.0));
        let turn = reference_half([0, 1, 2].map(|r| columns.map(|column| column[r])));
        let origin = origins[joint];
        let shift = moved(origin, 1.0);
        out.extend((0..3).flat_map(|r| {
            let [x, y, z] = turn[r];
            [x, y, z, shift[r] - origin[r]]
        }));
    }
    out
}

fn reference_kernel(kernel: GroupKernel, s: f64) -> f64 {
    let r = s.sqrt();
    match kernel {
        GroupKernel::Gaussian => (-s).exp(),
        GroupKernel::Matern12 => (-r).exp(),
        GroupKernel::Matern32 => (1.0 + 3f64.sqrt() * r) * (-(3f64.sqrt()) * r).exp(),
        GroupKernel::Matern52 => {
            (1.0 + 5f64.sqrt() * r + 5.0 / 3.0 * s) * (-(5f64.sqrt()) * r).exp()
        }
    }
}

/// Returns K of a group's helpers, multiplied by w, and the explained and unexplained error.
fn reference_map(group: &GroupContent, phi: &[f64]) -> (Vec<Wide>, [f64; 2]) {
    let x = group.inputs.iter().map(|&(f, w)| f64::from(w) * phi[f as usize]);
    let x = x.collect::<Vec<_>>();
    let squared = |x: &[f64], t: &[f32]| {
        x.iter().zip(t).map(|(x, t)| (x - f64::from(*t)).powi(2)).sum::<f64>()
    };
    let change = |t: &Vec<f32>| {
        let [here, rest] = [squared(&x, t), squared(&vec![0.0; x.len()], t)];
        reference_kernel(group.kernel, here) - reference_kernel(group.kernel, rest)
    };
    let basis = group.centres.iter().map(change).collect::<Vec<_>>();
    let times = |rows: &[Vec<f32>], x: &[f64]| {
        let row = |row: &Vec<f32>| row.iter().zip(x).map(|(a, x)| f64::from(*a) * x).sum::<f64>();
        rows.iter().map(row).collect::<Vec<_>>()
    };
    let mut latent = times(&group.coefficients, &[basis.clone(), x.clone()].concat());
    let certainty = latent.split_off(latent.len() - group.certainty);
    let GroupConfidence { reach, linear, signal, noise } = group.confidence;
    let [reach, linear, signal, noise] = [reach, linear, signal, noise].map(f64::from);
    let apart = x.iter().map(|x| x * x).sum::<f64>();
    let prior = (1.0 - (1.0 + basis[0]).powi(2) + linear * apart).max(0.0);
    let smooth = |u: f64| 10.0 * u.powi(3) - 15.0 * u.powi(4) + 6.0 * u.powi(5);
    let near = smooth(((4.0 * reach - apart) / (3.0 * reach)).clamp(0.0, 1.0));
    let explained = near * certainty.iter().map(|h| h * h).sum::<f64>().min(prior);
    let error = if near > 0.0 {
        [signal * explained, noise * (prior - explained)]
    } else {
        [0.0, f64::INFINITY]
    };
    let w = smooth((8.0 * confidence_of(error)).min(1.0));
    let out = times(&group.outputs, &latent);
    let maps = out.chunks(12).map(|k| [0, 1, 2].map(|r| [0, 1, 2, 3].map(|c| w * k[4 * r + c])));
    (maps.collect(), error)
}

/// Returns the confidence of the explained and unexplained error.
fn confidence_of([explained, unexplained]: [f64; 2]) -> f64 {
    1.0 / (1.0 + unexplained / (1.0 + explained))
}

/// The palette after the correction of a base palette, and the pose's confidence.
fn reference(groups: &[GroupContent], pose: &[Matrix3x4], base: &[Matrix3x4]) -> (Vec<Wide>, f64) {
    let phi = reference_features(pose);
    let mut out = base.iter().map(wide).collect::<Vec<_>>();
    let proxies = groups.iter().map(|group| group.proxies).sum::<usize>();
    let mut at = out.len() - proxies;
    let mut known = [0.0; 2];
    for group in groups.iter().filter(|group| !group.centres.is_empty()) {
        let (maps, error) = reference_map(group, &phi);
        known = [0, 1].map(|k| known[k] + error[k]);
        let q = wide(&pose[group.joint]);
        for (l, map) in maps.iter().enumerate() {
            for (r, c) in (0..3).flat_map(|r| (0..4).map(move |c| (r, c))) {
                out[at + l][r][c] += (0..3).map(|k| q[r][k] * map[k][c]).sum::<f64>();
            }
        }
        at += group.proxies;
    }
    (out, confidence_of(known))
}

/// The palette before the correction: the joints, and the dominant joint's transform for each
/// helper.
fn base(groups: &[GroupContent], pose: &[Matrix3x4]) -> Vec<Matrix3x4> {
    let of_group = |g: &GroupContent| vec![pose[g.joint]; g.proxies];
    pose.iter().copied().chain(groups.iter().flat_map(of_group)).collect()
}

/// Runs the correction alone, in scratch of exactly the stated length.
fn corrected(
    envelope: &Envelope<'_>,
    pose: &[Matrix3x4],
    base: &[Matrix3x4],
) -> (Vec<Matrix3x4>, f32) {
    let mut phi = vec![[[f32::NAN; 4]; 3]; envelope.joint_len()];
    stages::features(envelope, pose, &mut phi).unwrap();
    let mut out = base.to_vec();
    let mut scratch = vec![f32::NAN; envelope.correction_len()];
    let confidence = stages::correction(envelope, pose, &phi, &mut scratch, &mut out).unwrap();
    (out, confidence)
}

fn flat(transforms: &[Matrix3x4]) -> &[f32] {
    transforms.as_flattened().as_flattened()
}

fn flat_bits(transforms: &[Matrix3x4]) -> Vec<u32> {
    bits(flat(transforms))
}

fn narrow(transforms: &[Wide]) -> Vec<f32> {
    transforms.as_flattened().as_flattened().iter().map(|&x| x as f32).collect()
}

#[test]
fn features_agree_with_f64() {
    let shape = Shape { joints: 6, ..SMALL };
    with_predictor(Predictor::Kernel, shape, |envelope| {
        let mut rng = Rng(3);
        for _ in (0..200).step_by(apart(50)) {
            let pose = random_pose(&envelope, &mut rng, 1.0);
            let mut found = vec![[[f32::NAN; 4]; 3]; 6];
            stages::features(&envelope, &pose, &mut found).unwrap();
            let expected = reference_features(&pose);
            let expected = expected.iter().map(|&x| x as f32).collect::<Vec<_>>();
            let difference = max_difference(flat(&found), &expected);
            // About ten roundings of displacements up to 10.
            assert!(difference < 1e-5, "{difference}");
            assert_eq!(found[envelope.root()], [[0.0; 4]; 3]);
        }
    });
}

#[test]
fn corrections_agree_with_f64() {
    let wide_shape = Shape {
        vertices: 3,
        joints: 7,
        proxies: 9,
        influences: 3,
        tangents: false,
        coefficients: true,
    };
    for shape in [SMALL, wide_shape] {
        let groups = sample_groups(shape.joints, shape.proxies);
        with_predictor(Predictor::Kernel, shape, |envelope| {
            let mut rng = Rng(11);
            let mut between = 0;
            for i in (0..300).step_by(apart(149)) {
                let turn = [0.05, 0.2, 0.5][i % 3];
                let pose = random_pose(&envelope, &mut rng, turn);
                let base = base(&groups, &pose);
                let (found, confidence) = corrected(&envelope, &pose, &base);
                let (expected, expected_confidence) = reference(&groups, &pose, &base);
                let expected = narrow(&expected);
                let largest = expected.iter().fold(1.0f32, |a, x| a.max(x.abs()));
                let difference = max_difference(flat(&found), &expected);
                // About 50 roundings of terms close to the largest.
                assert!(difference < 4e-6 * largest, "{difference} of {largest}");
                let difference = (f64::from(confidence) - expected_confidence).abs();
                assert!(difference < 2e-6, "{confidence} {expected_confidence}");
                between += usize::from(confidence > 0.01 && confidence < 0.99);
            }
            assert!(
                cfg!(miri) || between > 50,
                "{between} poses have a confidence between 0 and 1"
            );
        });
    }
}

#[test]
fn each_number_of_a_group_matters() {
    let groups = sample_groups(SMALL.joints, SMALL.proxies);
    let mut pieces = Pieces::sample(Predictor::Kernel, SMALL);
    let pose_of = |envelope: &Envelope<'_>| random_pose(envelope, &mut Rng(8), 0.2);
    let evaluate = |pieces: &Pieces| {
        let model = Model::from_bytes(pieces.bytes()).unwrap();
        let envelope = model.envelope().unwrap();
        let (palette, confidence) = confident_palette(&envelope, &pose_of(&envelope));
        [flat(&palette), &[confidence]].concat()
    };
    let still = evaluate(&pieces);
    let edits = [
        (|g| g.inputs[1].0 += 1) as fn(&mut GroupContent),
        |g| g.inputs[1].1 += 0.1,
        |g| g.centres[10][4] += 0.1,
        |g| g.coefficients[2][0] += 0.1,
        |g| g.coefficients[2][10] += 0.1,
        |g| g.coefficients[2][11] += 0.1,
        |g| g.coefficients[0][12] += 0.1,
        |g| g.outputs[11][2] += 0.1,
        |g| g.joint = 2,
        |g| g.confidence.reach = 1e-3,
        |g| g.confidence.linear = 0.5,
        |g| g.confidence.signal = 1.0,
        |g| g.confidence.noise = 1.0,
        |g| g.coefficients[3][2] += 0.5,
        |g| g.coefficients[4][13] += 0.5,
        |g| g.kernel = GroupKernel::Matern32,
    ];
    for (index, edit) in edits.into_iter().enumerate() {
        let mut groups = groups.clone();
        assert_ne!(groups[0].kernel, GroupKernel::Matern32);
        edit(&mut groups[0]);
        pieces.set_groups(&groups);
        let difference = max_difference(&evaluate(&pieces), &still);
        assert!(difference > 1e-5, "edit {index}: {difference}");
    }
}

#[test]
fn the_rest_pose_is_exact_bit_for_bit() {
    with_predictor(Predictor::Kernel, SMALL, |envelope| {
        let rest = vec![IDENTITY; envelope.joint_len()];
        let mut phi = vec![[[f32::NAN; 4]; 3]; envelope.joint_len()];
        stages::features(&envelope, &rest, &mut phi).unwrap();
        assert_eq!(phi, vec![[[0.0; 4]; 3]; envelope.joint_len()]);
        let (palette, confidence) = confident_palette(&envelope, &rest);
        let identity = vec![IDENTITY; envelope.palette_len()];
        assert_eq!(flat_bits(&palette), flat_bits(&identity));
        assert!(confidence > 0.0, "the maps have run");
    });
    // A value at rest that is off by a last place must matter. A Gaussian has no values at rest.
    let mut pieces = Pieces::sample(Predictor::Kernel, SMALL);
    let mut groups = sample_groups(SMALL.joints, SMALL.proxies);
    groups[0].kernel = GroupKernel::Matern52;
    pieces.set_groups(&groups);
    // 8 features and 8 weights, 2 blocks of 5 columns of centres, then the values at rest.
    let at = 8 + 8 + 8 * 2 * 5;
    let section = SectionKind::Corrections;
    let words = pieces.section(section).as_chunks::<4>().0;
    let rest = f32::from_le_bytes(words[at]);
    pieces.set_float(section, at, rest.next_up());
    let model = Model::from_bytes(pieces.bytes()).unwrap();
    let envelope = model.envelope().unwrap();
    let (palette, _) = confident_palette(&envelope, &vec![IDENTITY; envelope.joint_len()]);
    assert_ne!(palette, vec![IDENTITY; envelope.palette_len()]);
}

#[test]
fn far_poses_have_no_confidence_and_keep_their_base() {
    let groups = sample_groups(SMALL.joints, SMALL.proxies);
    with_predictor(Predictor::Kernel, SMALL, |envelope| {
        // Every joint far from its parent.
        let far = (0..4).map(|joint| {
            let mut map = IDENTITY;
            map[0][3] = [40.0, 0.0, 20.0, 60.0][joint];
            map[1][3] = [-0.0, 30.0, 60.0, 90.0][joint];
            map
        });
        let far = far.collect::<Vec<_>>();
        let kept = |pose: &[Matrix3x4]| {
            let base = base(&groups, pose);
            let (palette, confidence) = corrected(&envelope, pose, &base);
            assert_eq!(flat_bits(&palette), flat_bits(&base));
            assert!(confidence < 1e-29, "{confidence}");
        };
        kept(&far);
        // So far that distances overflow: only the base is left.
        let mut lost = far.clone();
        lost[3][0] = [1e30, 0.0, 0.0, 1e30];
        lost[0][1] = [0.0, 3e38, 0.0, -3e38];
        kept(&lost);
    });
}

#[test]
fn features_that_are_nan_add_nothing() {
    with_predictor(Predictor::Kernel, SMALL, |envelope| {
        let pose = vec![IDENTITY; 4];
        for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX] {
            let mut out = vec![IDENTITY; 7];
            let mut scratch = vec![f32::NAN; envelope.correction_len()];
            let phi = vec![[[value; 4]; 3]; 4];
            let confidence = stages::correction(&envelope, &pose, &phi, &mut scratch, &mut out);
            assert!(confidence.is_ok_and(|confidence| confidence < 1e-29), "{value}");
            assert_eq!(out, vec![IDENTITY; 7]);
        }
    });
}

#[test]
fn joints_are_copied_bit_for_bit() {
    let groups = sample_groups(SMALL.joints, SMALL.proxies);
    with_predictor(Predictor::Kernel, SMALL, |envelope| {
        let mut pose = random_pose(&envelope, &mut Rng(2), 1.0);
        pose[2][1][1] = -0.0;
        let (palette, _) = confident_palette(&envelope, &pose);
        assert_eq!(flat_bits(&palette[..4]), flat_bits(&pose));
        assert_ne!(palette[4], pose[groups[0].joint], "the helpers are moved");
        let mut joints_only = vec![[[f32::NAN; 4]; 3]; 7];
        stages::joints(&envelope, &pose, &mut joints_only).unwrap();
        assert_eq!(flat_bits(&joints_only), flat_bits(&base(&groups, &pose)));
    });
    // Without helpers the envelope is linear blend skinning, with confidence 1.
    with_predictor(Predictor::Kernel, Shape { proxies: 0, ..SMALL }, |envelope| {
        let pose = random_pose(&envelope, &mut Rng(2), 1.0);
        assert_eq!(confident_palette(&envelope, &pose), (pose, 1.0));
    });
}

#[test]
fn groups_without_centres_add_nothing_and_have_no_confidence() {
    let mut groups = sample_groups(SMALL.joints, SMALL.proxies);
    groups[1].centres.clear();
    groups[1].coefficients.iter_mut().for_each(|row| row.truncate(9));
    for groups in [vec![groups[0].clone(), groups[1].clone()], {
        let mut all = groups.clone();
        all[0].centres.clear();
        all[0].coefficients.iter_mut().for_each(|row| row.truncate(5));
        all
    }] {
        let mut pieces = Pieces::sample(Predictor::Kernel, SMALL);
        pieces.set_groups(&groups);
        let model = Model::from_bytes(pieces.bytes()).unwrap();
        let envelope = model.envelope().unwrap();
        let pose = random_pose(&envelope, &mut Rng(4), 0.3);
        let (palette, confidence) = confident_palette(&envelope, &pose);
        let base = base(&groups, &pose);
        let (expected, expected_confidence) = reference(&groups, &pose, &base);
        assert!(max_difference(flat(&palette), &narrow(&expected)) < 2e-5);
        assert!((f64::from(confidence) - expected_confidence).abs() < 2e-6);
        assert_eq!(palette[5..], base[5..], "the second group's helpers");
        assert_eq!(palette[4] == base[4], groups[0].centres.is_empty());
    }
}

#[test]
fn whole_palettes_are_their_stages() {
    let groups = sample_groups(SMALL.joints, SMALL.proxies);
    with_predictor(Predictor::Kernel, SMALL, |envelope| {
        let pose = random_pose(&envelope, &mut Rng(6), 0.2);
        let (whole, confidence) = confident_palette(&envelope, &pose);
        let base = if Predictor::Kernel == Predictor::Kernel {
            base(&groups, &pose)
        } else {
            // A rotational model with equal reconstruction.
            let model =
                Model::from_bytes(Pieces::sample(Predictor::Rotational, SMALL).bytes()).unwrap();
            let rotational = model.envelope().unwrap();
            confident_palette(&rotational, &pose).0
        };
        let (parts, of_parts) = corrected(&envelope, &pose, &base);
        assert_eq!((flat_bits(&whole), confidence), (flat_bits(&parts), of_parts));
        assert!(confidence > 0.0 && whole != base);
    });
}

#[test]
fn only_rotational_models_have_a_palette_without_kernel_maps() {
    for predictor in Predictor::ALL {
        with_predictor(predictor, SMALL, |envelope| {
            let pose = random_pose(&envelope, &mut Rng(6), 2.0);
            let mut scratch = vec![f32::NAN; envelope.scratch_len()];
            let mut out = vec![IDENTITY; envelope.palette_len()];
            let confidence = envelope.rotational_palette(&pose, &mut scratch, &mut out);
            if predictor == Predictor::Rotational {
                let (whole, expected) = confident_palette(&envelope, &pose);
                assert_eq!((flat_bits(&out), confidence), (flat_bits(&whole), Ok(expected)));
            } else {
                assert_eq!(confidence, Err(stage_error(predictor)));
                assert!(out.iter().all(|map| *map == IDENTITY));
            }
        });
    }
}

#[test]
fn a_rotational_model_is_confident_within_its_ranges() {
    // The sample's ranges are 1.5, so the confidence reaches 0 at 1.5 + 0.85.
    with_predictor(Predictor::Rotational, SMALL, |envelope| {
        let turned = |angle: f32| {
            let (s, c) = angle.sin_cos();
            let mut pose = vec![IDENTITY; 4];
            pose[3] = [[c, -s, 0.0, 0.0], [s, c, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
            confident_palette(&envelope, &pose).1
        };
        assert_eq!([0.0, 1.0, 1.499, 2.351, 3.0].map(turned), [1.0, 1.0, 1.0, 0.0, 0.0]);
        // Half of the way, and a quarter of the way: 1 - (10/64 - 15/256 + 6/1024).
        for (angle, expected) in [(1.925, 0.5), (1.7125, 1.0 - 0.103_515_625)] {
            assert!((turned(angle) - expected).abs() < 1e-5, "{angle} {}", turned(angle));
        }
    });
}
