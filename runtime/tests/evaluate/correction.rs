//! The kernel maps' correction against an independent evaluation in f64.

use crate::common::{
    IDENTITY, Stretched, apart, bits, confident_palette, max_difference, palette_with, random_pose,
    stage_error, stretched_pose, with_predictor,
};
use models::{GroupContent, JOINTLESS, Pieces, Rng, SMALL, STRETCHING, Shape, sample_groups};
use sinew_runtime::envelope::{GroupConfidence, GroupKernel, Predictor};
use sinew_runtime::format::SectionKind;
use sinew_runtime::{Envelope, Matrix3x4, Model, stages};

type Wide = [[f64; 4]; 3];

fn wide(m: &Matrix3x4) -> Wide {
    m.map(|row| row.map(f64::from))
}

/// Parents and origins of the sample's joints, repeated here.
fn skeleton(joints: usize) -> (Vec<Option<usize>>, Vec<[f64; 3]>) {
    let order = [1, 2, 0].into_iter().chain(3..joints).take(joints).collect::<Vec<_>>();
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

/// Features from the motion of points: half of a joint's rotation relative to its parent, and the gap
/// between the joint's origin and where the parent carries it, in the parent's frame. Then strains,
/// if joints stretch, and curves.
fn reference_features(at: &Stretched, stretches: bool) -> Vec<f64> {
    let Stretched { pose, rigid, curves } = at;
    let (parents, origins) = skeleton(pose.len());
    let mut out = Vec::new();
    for (joint, parent) in parents.iter().enumerate() {
        let Some(parent) = *parent else {
            out.extend([0.0; 12]);
            continue;
        };
        let [own, above] = [joint, parent].map(|joint| wide(&rigid[joint]));
        let back = |x: [f64; 3]| [0, 1, 2].map(|r| (0..3).map(|k| above[k][r] * x[k]).sum::<f64>());
        let columns = [0, 1, 2].map(|c| back(own.map(|row| row[c])));
        let turn = reference_half([0, 1, 2].map(|r| columns.map(|column| column[r])));
        let origin = origins[joint];
        let place = |joint: usize| {
            wide(&pose[joint])
                .map(|m| m[0] * origin[0] + m[1] * origin[1] + m[2] * origin[2] + m[3])
        };
        let (own, carried) = (place(joint), place(parent));
        let gap = back([0, 1, 2].map(|r| own[r] - carried[r]));
        out.extend((0..3).flat_map(|r| {
            let [x, y, z] = turn[r];
            [x, y, z, gap[r]]
        }));
    }
    if stretches {
        out.extend(pose.iter().flat_map(reference_strain));
    }
    out.extend(curves.iter().map(|value| f64::from(*value)));
    out
}

/// Entries xx, xy, xz, yy, yz, zz of half of LᵀL - I.
fn reference_strain(map: &Matrix3x4) -> [f64; 6] {
    let map = wide(map);
    [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)].map(|(a, b)| {
        let product = map.iter().map(|row| row[a] * row[b]).sum::<f64>();
        (product - f64::from(u8::from(a == b))) / 2.0
    })
}

/// A rigid pose without curves.
fn rigid(pose: &[Matrix3x4]) -> Stretched {
    Stretched { pose: pose.to_vec(), rigid: pose.to_vec(), curves: Vec::new() }
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

/// The palette after the correction of a base palette, and the confidence of the groups.
///
/// - `phi`: features of the pose.
fn reference(
    groups: &[GroupContent],
    pose: &[Matrix3x4],
    phi: &[f64],
    base: &[Matrix3x4],
) -> (Vec<Wide>, f64) {
    let mut out = base.iter().map(wide).collect::<Vec<_>>();
    let proxies = groups.iter().map(|group| group.proxies).sum::<usize>();
    let mut at = out.len() - proxies;
    let mut known = [0.0; 2];
    for group in groups.iter().filter(|group| !group.centres.is_empty()) {
        let (maps, error) = reference_map(group, phi);
        known = [0, 1].map(|k| known[k] + error[k]);
        let q = wide(pose.get(group.joint).unwrap_or(&IDENTITY));
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
/// helper; the identity without joints.
fn base(groups: &[GroupContent], pose: &[Matrix3x4]) -> Vec<Matrix3x4> {
    let dominant = |joint: usize| *pose.get(joint).unwrap_or(&IDENTITY);
    let of_group = |g: &GroupContent| vec![dominant(g.joint); g.proxies];
    pose.iter().copied().chain(groups.iter().flat_map(of_group)).collect()
}

/// Runs stages polar, if joints stretch, and features.
fn features(envelope: &Envelope<'_>, pose: &[Matrix3x4], curves: &[f32]) -> Vec<f32> {
    let mut phi = vec![f32::NAN; envelope.counts().feature_len()];
    let len = if envelope.stretches() { pose.len() } else { 0 };
    let mut turns = vec![[[f32::NAN; 3]; 3]; len];
    if envelope.stretches() {
        let strains = phi[12 * len..18 * len].as_chunks_mut().0;
        stages::polar(envelope, pose, &mut turns, strains).unwrap();
    }
    stages::features(envelope, pose, curves, &turns, &mut phi).unwrap();
    phi
}

/// Runs the correction after its features, in scratch of exactly the stated length.
fn corrected(
    envelope: &Envelope<'_>,
    pose: &[Matrix3x4],
    curves: &[f32],
    base: &[Matrix3x4],
) -> (Vec<Matrix3x4>, f32) {
    let phi = features(envelope, pose, curves);
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
    for shape in [SMALL, STRETCHING, JOINTLESS] {
        let shape = Shape { joints: 3 * shape.joints / 2, ..shape };
        with_predictor(Predictor::Kernel, shape, |envelope| {
            let mut rng = Rng(3);
            for _ in (0..200).step_by(apart(50)) {
                let at = stretched_pose(&envelope, &mut rng, 1.0);
                let found = features(&envelope, &at.pose, &at.curves);
                let expected = reference_features(&at, shape.stretches);
                let expected = expected.iter().map(|&x| x as f32).collect::<Vec<_>>();
                let difference = max_difference(&found, &expected);
                // About ten roundings of displacements up to 10; rotations of joints that stretch are
                // off by some more.
                let most = if shape.stretches { 1e-4 } else { 1e-5 };
                assert!(difference < most, "{difference}");
                if shape.joints > 0 {
                    assert_eq!(found[12 * envelope.root()..][..12], [0.0; 12]);
                }
            }
        });
    }
}

#[test]
fn corrections_agree_with_f64() {
    let wide_shape =
        Shape { vertices: 3, joints: 7, proxies: 9, influences: 3, tangents: false, ..SMALL };
    for shape in [SMALL, wide_shape, STRETCHING, JOINTLESS] {
        let groups = sample_groups(shape);
        let is_rigid = !shape.stretches && shape.curves == 0;
        with_predictor(Predictor::Kernel, shape, |envelope| {
            let mut rng = Rng(11);
            let mut between = 0;
            for i in (0..300).step_by(apart(149)) {
                let turn = [0.05, 0.2, 0.5][i % 3];
                let at = stretched_pose(&envelope, &mut rng, turn);
                let base = base(&groups, &at.pose);
                let (found, confidence) = palette_with(&envelope, &at.pose, &at.curves);
                let phi = reference_features(&at, shape.stretches);
                let (expected, expected_confidence) = reference(&groups, &at.pose, &phi, &base);
                let expected = narrow(&expected);
                let largest = expected.iter().fold(1.0f32, |a, x| a.max(x.abs()));
                let difference = max_difference(flat(&found), &expected);
                // About 50 roundings of terms close to the largest; rotations of joints that stretch
                // are off by some more.
                let most = if shape.stretches { 1e-4 } else { 4e-6 };
                assert!(difference < most * largest, "{difference} of {largest}");
                // Strains and curves have ranges, which lower the confidence further.
                let difference = f64::from(confidence) - expected_confidence;
                let is_lower = !is_rigid && difference < 1e-4;
                assert!(is_lower || difference.abs() < 2e-6, "{confidence} {expected_confidence}");
                between += usize::from(confidence > 0.01 && confidence < 0.99);
            }
            assert!(
                cfg!(miri) || between > 50 || !is_rigid,
                "{between} poses have a confidence between 0 and 1"
            );
        });
    }
}

#[test]
fn each_number_of_a_group_matters() {
    let groups = sample_groups(SMALL);
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
        assert_eq!(features(&envelope, &rest, &[]), vec![0.0; 12 * rest.len()]);
        let (palette, confidence) = confident_palette(&envelope, &rest);
        let identity = vec![IDENTITY; envelope.palette_len()];
        assert_eq!(flat_bits(&palette), flat_bits(&identity));
        assert!(confidence > 0.0, "the maps have run");
    });
    // A value at rest that is off by a last place must matter. A Gaussian has no values at rest.
    let mut pieces = Pieces::sample(Predictor::Kernel, SMALL);
    let mut groups = sample_groups(SMALL);
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
    let groups = sample_groups(SMALL);
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
            let (palette, confidence) = corrected(&envelope, pose, &[], &base);
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
            let phi = vec![value; 12 * 4];
            let confidence = stages::correction(&envelope, &pose, &phi, &mut scratch, &mut out);
            assert!(confidence.is_ok_and(|confidence| confidence < 1e-29), "{value}");
            assert_eq!(out, vec![IDENTITY; 7]);
        }
    });
}

#[test]
fn joints_are_copied_bit_for_bit() {
    let groups = sample_groups(SMALL);
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
    let mut groups = sample_groups(SMALL);
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
        let phi = reference_features(&rigid(&pose), false);
        let (expected, expected_confidence) = reference(&groups, &pose, &phi, &base);
        assert!(max_difference(flat(&palette), &narrow(&expected)) < 2e-5);
        assert!((f64::from(confidence) - expected_confidence).abs() < 2e-6);
        assert_eq!(palette[5..], base[5..], "the second group's helpers");
        assert_eq!(palette[4] == base[4], groups[0].centres.is_empty());
    }
}

#[test]
fn whole_palettes_are_their_stages() {
    for shape in [SMALL, STRETCHING, JOINTLESS] {
        let groups = sample_groups(shape);
        with_predictor(Predictor::Kernel, shape, |envelope| {
            let Stretched { pose, curves, .. } = stretched_pose(&envelope, &mut Rng(6), 0.2);
            let (whole, confidence) = palette_with(&envelope, &pose, &curves);
            let base = base(&groups, &pose);
            let (parts, of_parts) = corrected(&envelope, &pose, &curves, &base);
            assert_eq!((flat_bits(&whole), confidence), (flat_bits(&parts), of_parts));
            assert!(confidence > 0.0 || shape.curves > 0);
            assert_ne!(whole, base);
        });
    }
}

#[test]
fn only_rotational_models_have_a_palette_without_kernel_maps() {
    let each = Predictor::ALL.into_iter().flat_map(|each| [SMALL, STRETCHING].map(|s| (each, s)));
    for (predictor, shape) in each {
        with_predictor(predictor, shape, |envelope| {
            let Stretched { pose, .. } = stretched_pose(&envelope, &mut Rng(6), 2.0);
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

#[test]
fn hidden_and_mirrored_joints_are_at_rest_and_have_no_confidence() {
    let hide = |map: &Matrix3x4, by: [f32; 3]| {
        map.map(|[x, y, z, shift]| [by[0] * x, by[1] * y, by[2] * z, shift])
    };
    with_predictor(Predictor::Kernel, STRETCHING, |envelope| {
        let Stretched { rigid: pose, curves, .. } = stretched_pose(&envelope, &mut Rng(3), 0.2);
        let shown = features(&envelope, &pose, &curves);
        // A scale of 0, one axis of 0, a scale of 0.05, a mirror; joint 3 has no child.
        for by in [[0.0; 3], [1.0, 0.0, 1.0], [0.05; 3], [-1.0, 1.0, 1.0]] {
            let mut other = pose.clone();
            other[3] = hide(&pose[3], by);
            let found = features(&envelope, &other, &curves);
            assert_eq!(found[36..48], [0.0; 12]);
            assert_eq!(found[66..72], [0.0; 6], "the strain");
            assert_eq!((&found[..36], &found[48..66]), (&shown[..36], &shown[48..66]));
            assert_eq!(found[72..], shown[72..], "the curves");
            let (palette, confidence) = palette_with(&envelope, &other, &curves);
            assert_eq!((palette[3], confidence), (other[3], 0.0));
            assert!(flat(&palette).iter().all(|x| x.is_finite()));
            let mut joints = vec![f32::NAN; 4];
            let mut scratch = vec![f32::NAN; envelope.scratch_len()];
            envelope.joint_confidences(&other, &curves, &mut scratch, &mut joints).unwrap();
            assert_eq!(joints[3], 0.0);
            assert!(joints[..3].iter().all(|confidence| *confidence > 0.0), "{joints:?}");
        }
        // A child of a hidden joint is at rest too, and the root may be hidden.
        for joint in 0..4 {
            let mut other = pose.clone();
            other[joint] = hide(&pose[joint], [0.0; 3]);
            let found = features(&envelope, &other, &curves);
            for child in (0..4).filter(|child| envelope.parent(*child) == Some(joint)) {
                assert_eq!(found[12 * child..][..12], [0.0; 12]);
            }
            assert_eq!(palette_with(&envelope, &other, &curves).1, 0.0);
        }
    });
    // A rigid model hides joints too.
    with_predictor(Predictor::Kernel, SMALL, |envelope| {
        let mut pose = random_pose(&envelope, &mut Rng(3), 0.2);
        pose[3] = hide(&pose[3], [0.0; 3]);
        assert_eq!(features(&envelope, &pose, &[])[36..48], [0.0; 12]);
        assert_eq!(confident_palette(&envelope, &pose).1, 0.0);
    });
}

#[test]
fn a_joint_that_never_stretched_keeps_its_linear_part() {
    // Joints 0 and 3 have a stretch range of 0. A stretch along x and y leaves the rotation I.
    let map = [[1.5, 0.25, 0.0, 7.0], [0.25, 0.75, 0.0, 7.0], [0.0, 0.0, 1.0, 7.0]];
    let linear = [[1.5, 0.25, 0.0], [0.25, 0.75, 0.0], [0.0, 0.0, 1.0]];
    for predictor in Predictor::ALL {
        with_predictor(predictor, STRETCHING, |envelope| {
            let mut turns = vec![[[f32::NAN; 3]; 3]; 4];
            let mut strains = vec![[f32::NAN; 6]; 4];
            stages::polar(&envelope, &[map; 4], &mut turns, &mut strains).unwrap();
            let identity = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
            for (joint, turn) in turns.iter().enumerate() {
                let expected = if joint % 3 == 0 { linear } else { identity };
                let off = max_difference(turn.as_flattened(), expected.as_flattened());
                assert!(off < 1e-6 && (off == 0.0 || joint % 3 > 0), "{joint}: {off}");
            }
            // Every product is exact; xx is half of 1.5² + 0.25² - 1.
            assert_eq!(strains, [[0.656_25, 0.281_25, 0.0, -0.187_5, 0.0, 0.0]; 4]);
        });
    }
}

#[test]
fn a_curve_outside_its_range_lowers_the_confidence() {
    let shape = Shape { joints: 0, curves: 4, ..SMALL };
    let mut pieces = Pieces::sample(Predictor::Kernel, shape);
    // Curve 0 is the only input, so curve 3 is known by its range alone.
    let mut groups = sample_groups(shape);
    for group in &mut groups {
        group.inputs.iter_mut().for_each(|input| input.0 = 0);
    }
    pieces.set_groups(&groups);
    let confidence = |least: f32, most: f32, value: f32| {
        let mut pieces = pieces.clone();
        for (at, end) in [least, most].into_iter().enumerate() {
            pieces.set_float(SectionKind::CurveRanges, 6 + at, end);
        }
        let model = Model::from_bytes(pieces.bytes()).unwrap();
        let envelope = model.envelope().unwrap();
        let (palette, confidence) = palette_with(&envelope, &[], &[0.0, 0.0, 0.25, value]);
        assert_eq!(palette, vec![IDENTITY; 3], "it moves nothing");
        confidence
    };
    // The distance from the middle against 1.5 times half of the range; 0 from 2 times and 0.1 on.
    for value in [-0.2499, 0.0, 0.5, 1.0, 1.2499] {
        assert_eq!(confidence(0.0, 1.0, value), 1.0, "{value}");
    }
    for value in [-0.61, 1.61, 100.0, -1e30] {
        assert_eq!(confidence(0.0, 1.0, value), 0.0, "{value}");
    }
    // Half of the way from 1.25 to 1.6.
    for value in [1.425, -0.425] {
        assert!((confidence(0.0, 1.0, value) - 0.5).abs() < 1e-5);
    }
    // A curve that never moved has no range: only 0.1 is left.
    assert_eq!([0.0, 0.11, -0.11].map(|value| confidence(0.0, 0.0, value)), [1.0, 0.0, 0.0]);
    assert!((confidence(0.0, 0.0, -0.05) - 0.5).abs() < 1e-5);
}

#[test]
fn a_joint_stretched_beyond_its_range_lowers_the_confidence() {
    // Joint 2 has a stretch range of 0.5, joint 3 of 0.
    for predictor in Predictor::ALL {
        with_predictor(predictor, Shape { curves: 0, ..STRETCHING }, |envelope| {
            let confidence = |joint: usize, strain: f32| {
                // A stretch along x whose strain is `strain`.
                let mut pose = vec![IDENTITY; 4];
                pose[joint][0][0] = (2.0 * strain + 1.0).sqrt();
                // The scale moves the joint's origin, so that its parent carries it.
                let origin = [2.0, 0.0, 1.0, 3.0][joint];
                pose[joint][0][3] = origin * (1.0 - pose[joint][0][0]);
                confident_palette(&envelope, &pose).1
            };
            let of_rotational = predictor == Predictor::Rotational;
            for (joint, range, most) in [(2, 0.5f32, 0.75f32), (3, 0.0, 0.0)] {
                let end = most + 0.5 * range + 0.1;
                let within = confidence(joint, most - 1e-4 * range);
                assert!(!of_rotational || within == 1.0);
                assert_eq!(confidence(joint, end + 1e-3), 0.0, "{joint}");
                let half = confidence(joint, 0.5 * (most + end));
                assert!((half - 0.5).abs() < 1e-3 || !of_rotational && half < 0.5, "{half}");
                assert!(half > 0.0);
            }
        });
    }
}
