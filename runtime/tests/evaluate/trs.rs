//! Helpers as bones of translation, rotation and scale.

use crate::common::{IDENTITY, length_error, palette_with, stretched_pose, with_predictor};
use models::{Rng, SMALL, STRETCHING, Shape};
use sinew_runtime::envelope::{HelperKind, Predictor, Trs};
use sinew_runtime::{Argument, Envelope, Matrix3x4};

/// Evaluates the bones of a pose. Returns their palette entries, and the bones.
fn bones(envelope: &Envelope<'_>, pose: &[Matrix3x4], curves: &[f32]) -> Vec<(Matrix3x4, Trs)> {
    let mut scratch = vec![f32::NAN; envelope.scratch_len()];
    let mut palette = vec![IDENTITY; envelope.palette_len()];
    let mut out = vec![Trs::IDENTITY; envelope.proxy_len()];
    let confidence =
        envelope.palette_trs(pose, curves, &mut scratch, &mut palette, &mut out).unwrap();
    assert_eq!(palette_with(envelope, pose, curves), (palette, confidence));
    let entry = |(helper, bone): (usize, &Trs)| {
        (bone.palette_entry(envelope.helper_centre(helper).unwrap()), *bone)
    };
    out.iter().enumerate().map(entry).collect()
}

/// Returns the largest difference of two linear parts, relative to the size of the first.
fn apart(a: &Matrix3x4, b: &Matrix3x4) -> f32 {
    let linear = |m: &Matrix3x4| m.map(|[x, y, z, _]| [x, y, z]);
    let (a, b) = (linear(a), linear(b));
    let size = a.as_flattened().iter().fold(0.0f32, |size, x| size.max(x.abs()));
    a.as_flattened().iter().zip(b.as_flattened()).fold(0.0f32, |w, (a, b)| w.max((a - b).abs()))
        / size
}

/// Calls `test` with the entry, the bone and its palette entry of helpers in random poses.
fn each(shape: Shape, mut test: impl FnMut(Matrix3x4, Trs, Matrix3x4)) {
    with_predictor(Predictor::Kernel, shape, |envelope| {
        let mut rng = Rng(5);
        for _ in 0..if cfg!(miri) { 2 } else { 200 } {
            let posed = stretched_pose(&envelope, &mut rng, 0.5);
            let (palette, _) = palette_with(&envelope, &posed.pose, &posed.curves);
            let helpers = &palette[envelope.joint_len()..];
            let bones = bones(&envelope, &posed.pose, &posed.curves);
            helpers.iter().zip(bones).for_each(|(map, (entry, bone))| test(*map, bone, entry));
        }
    });
}

#[test]
fn bones_hold_helpers_of_kind_trs_and_rigid_but_not_affine_ones() {
    for shape in [SMALL, STRETCHING] {
        let (mut sheared, mut scaled) = (0, 0);
        each(shape, |map, _, entry| sheared += usize::from(apart(&map, &entry) > 0.02));
        assert!(sheared > 10, "the control fails: {sheared}");
        let (mut stayed, mut all) = (0, 0);
        // Some helpers of the sample are flat, and keep their shear.
        let mut is_flat = |bone: &Trs| {
            all += 1;
            stayed += usize::from(bone.rotation == Trs::IDENTITY.rotation);
            bone.rotation == Trs::IDENTITY.rotation
        };
        each(Shape { kind: HelperKind::Trs, ..shape }, |map, bone, entry| {
            if is_flat(&bone) {
                return;
            }
            assert!(apart(&map, &entry) < 4e-6, "{map:?} {bone:?}");
            scaled += usize::from(bone.scale.iter().any(|scale| (scale - 1.0).abs() > 0.02));
        });
        assert!(scaled > 10, "the control fails: {scaled}");
        each(Shape { kind: HelperKind::Rigid, ..shape }, |map, bone, entry| {
            if is_flat(&bone) {
                return;
            }
            assert!(apart(&map, &entry) < 4e-6, "{map:?} {bone:?}");
            assert!(bone.scale.iter().all(|scale| (scale - 1.0).abs() < 4e-6), "{bone:?}");
        });
        assert!(2 * stayed < all, "{stayed} of {all}");
    }
}

#[test]
fn the_image_of_the_centre_and_unit_length_stay() {
    for kind in HelperKind::ALL {
        with_predictor(Predictor::Kernel, Shape { kind, ..STRETCHING }, |envelope| {
            let posed = stretched_pose(&envelope, &mut Rng(6), 0.5);
            let (palette, _) = palette_with(&envelope, &posed.pose, &posed.curves);
            let found = bones(&envelope, &posed.pose, &posed.curves);
            for (l, (map, (_, bone))) in
                palette[envelope.joint_len()..].iter().zip(found).enumerate()
            {
                let [x, y, z] = envelope.helper_centre(l).unwrap();
                let image = map.map(|[a, b, c, shift]| a * x + b * y + c * z + shift);
                assert_eq!(bone.translation, image);
                let square: f32 = bone.rotation.iter().map(|x| x * x).sum();
                assert!((square - 1.0).abs() < 4e-7 && bone.rotation[3] >= 0.0, "{bone:?}");
            }
        });
    }
}

#[test]
fn bones_are_at_rest_in_the_rest_pose_bit_for_bit() {
    for (predictor, kind) in [(Predictor::Rotational, HelperKind::Affine)]
        .into_iter()
        .chain(HelperKind::ALL.map(|kind| (Predictor::Kernel, kind)))
    {
        with_predictor(predictor, Shape { kind, ..SMALL }, |envelope| {
            let rest = vec![IDENTITY; envelope.joint_len()];
            for (helper, (entry, bone)) in bones(&envelope, &rest, &[]).into_iter().enumerate() {
                let translation = envelope.helper_centre(helper).unwrap();
                assert_eq!(bone, Trs { translation, ..Trs::IDENTITY }, "{predictor:?} {kind:?}");
                assert_eq!(entry, IDENTITY);
            }
        });
    }
}

#[test]
fn a_hidden_or_mirrored_character_has_finite_bones() {
    for kind in HelperKind::ALL {
        with_predictor(Predictor::Kernel, Shape { kind, ..STRETCHING }, |envelope| {
            let curves = vec![0.0; envelope.curve_len()];
            let mut pose = vec![IDENTITY; envelope.joint_len()];
            for (scale, expected) in [(0.0, 0.0), (1e-4, 1e-4), (1e4, 1e4)] {
                pose.iter_mut().flatten().enumerate().for_each(|(at, row)| row[at % 3] = scale);
                for (_, bone) in bones(&envelope, &pose, &curves) {
                    assert_eq!(bone.rotation, Trs::IDENTITY.rotation, "{kind:?}");
                    assert!((bone.scale[1] - expected).abs() <= 1e-6 * expected, "{bone:?}");
                }
            }
            pose.iter_mut().flatten().enumerate().for_each(|(at, row)| row[at % 3] = -1.0);
            for (entry, bone) in bones(&envelope, &pose, &curves) {
                assert_eq!(bone.scale, [-1.0; 3], "{kind:?}");
                assert_eq!(apart(&pose[0], &entry), 0.0);
            }
        });
    }
}

#[test]
fn other_lengths_are_refused_and_nothing_is_written() {
    with_predictor(Predictor::Kernel, SMALL, |envelope| {
        let pose = vec![IDENTITY; envelope.joint_len()];
        let mut scratch = vec![0.0; envelope.scratch_len()];
        for (palette_len, bone_len) in [(7, 2), (7, 4), (6, 3)] {
            let mut palette = vec![[[7.0; 4]; 3]; palette_len];
            let mut out = vec![Trs::IDENTITY; bone_len];
            let expected = match bone_len {
                3 => length_error(Argument::Palette, 7, palette_len),
                _ => length_error(Argument::Bones, 3, bone_len),
            };
            let refused = envelope.palette_trs(&pose, &[], &mut scratch, &mut palette, &mut out);
            assert_eq!(refused, Err(expected));
            assert!(palette.iter().all(|map| *map == [[7.0; 4]; 3]));
            assert!(out.iter().all(|bone| *bone == Trs::IDENTITY));
        }
    });
}

/// Hash of the bones of 200 poses; change it only with a reason that the commit states.
const BITS: u64 = 0xb1e9_1728_ccd9_504c;

#[test]
#[cfg(not(miri))]
fn bits_of_bones_are_those_of_every_other_cpu() {
    let mut hash = 0xcbf2_9ce4_8422_2325u64;
    each(STRETCHING, |_, Trs { translation, rotation, scale }, _| {
        for x in translation.into_iter().chain(rotation).chain(scale) {
            hash = (hash ^ u64::from(x.to_bits())).wrapping_mul(0x0100_0000_01b3);
        }
    });
    assert_eq!(hash, BITS, "found {hash:#018x}");
}
