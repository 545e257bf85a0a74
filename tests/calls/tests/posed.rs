//! Poses of the caller's skeleton, compared with the runtime's calls.

use crate::handles::{NONE, done, get};
use crate::{Both, each};
use sinew_capi::*;
use sinew_runtime::envelope::{PoseFaultKind, Trs};
use sinew_runtime::{
    LocalTransform, Matrix3x4, gather_pose, matrix, mesh_hash_of, model_space_pose,
    skeleton_hash_of,
};
use std::ffi::{CStr, c_void};
use std::ptr::{null, null_mut};

fn rest(envelope: &sinew_runtime::Envelope<'_>) -> Vec<Matrix3x4> {
    let local: Vec<LocalTransform> = envelope.rest_locals().collect();
    let mut pose = vec![matrix::IDENTITY; local.len()];
    model_space_pose(envelope, &local, &mut pose).unwrap();
    pose
}

#[test]
fn rest_frames_are_copied_at_once() {
    each(|Both { c: (found, _), rust: (envelope, _), .. }| {
        let still = sinew_local_transform { rotation: [0.0; 4], translation: [0.0; 3] };
        let mut out = vec![still; envelope.joint_len()];
        let (at, len) = (out.as_mut_ptr(), out.len());
        // SAFETY: an open envelope and an array with its length.
        done(unsafe { sinew_envelope_rest_locals(found.handle, at, len, NONE) });
        for (found, expected) in out.iter().zip(envelope.rest_locals()) {
            assert_eq!(
                (found.rotation, found.translation),
                (expected.rotation, expected.translation)
            );
        }
    });
}

/// Removes a prefix, whose length the argument states.
unsafe extern "C" fn without_prefix(name: sinew_name, user: *mut c_void) -> sinew_name {
    // SAFETY: the test gives a length, and names that are longer.
    unsafe {
        let len = *user.cast::<usize>();
        sinew_name { name: name.name.add(len), name_len: name.name_len - len }
    }
}

#[test]
fn a_skeleton_is_bound_and_gathered() {
    each(|Both { c: (found, _), rust: (envelope, _), .. }| {
        // The engine's skeleton: an extra joint, then the file's joints in reverse order without the last one.
        let len = envelope.joint_len();
        let missing_joint = (0..len).rev().find(|joint| *joint != envelope.root());
        let own = (0..len).rev().filter(|joint| Some(*joint) != missing_joint);
        let own: Vec<&str> = own.map(|joint| envelope.joint_name(joint).unwrap()).collect();
        let names: Vec<&str> = ["weapon"].into_iter().chain(own).collect();
        let in_c = |name: &&str| sinew_name { name: name.as_ptr().cast(), name_len: name.len() };
        let all: Vec<sinew_name> = names.iter().map(in_c).collect();
        let mut expected = vec![0; len];
        let bound = envelope.bind_joints(&names, &mut expected).unwrap();
        assert_eq!(missing_joint.map(|joint| expected[joint]), missing_joint.map(|_| SINEW_FOLDED));
        let mut map = vec![0; len];
        let (at, handle) = (map.as_mut_ptr(), found.handle);
        // SAFETY: an open envelope, arrays with their lengths, and one structure to be written.
        let result = get(|out| unsafe {
            sinew_envelope_bind(
                handle,
                all.as_ptr(),
                all.len(),
                None,
                null_mut(),
                at,
                len,
                out,
                NONE,
            )
        });
        assert_eq!((&map, result.found_len as usize), (&expected, bound.found_len));
        let missing = bound.missing_parent.map_or(SINEW_NO_JOINT, |joint| joint as u32);
        assert_eq!((result.missing_parent, missing), (SINEW_NO_JOINT, SINEW_NO_JOINT));
        let at = map.as_mut_ptr();
        let bind_as = |names: &[sinew_name], rename: sinew_rename, mut prefix_len: usize| {
            let (names, names_len, bound) = (names.as_ptr(), names.len(), null_mut());
            let user = (&raw mut prefix_len).cast();
            // SAFETY: an open envelope, and arrays with their lengths; the function takes this argument.
            unsafe {
                sinew_envelope_bind(handle, names, names_len, rename, user, at, len, bound, NONE)
            }
        };
        let bind = |names: &[sinew_name]| bind_as(names, None, 0);
        assert_eq!(bind(&all[..1]), sinew_status::NoRoot);
        let prefixed: Vec<String> = names.iter().map(|name| format!("rig:{name}")).collect();
        let prefixed: Vec<&str> = prefixed.iter().map(String::as_str).collect();
        let prefixed = prefixed.iter().map(in_c).collect::<Vec<_>>();
        assert_eq!(bind(&prefixed), sinew_status::OtherName);
        assert_eq!(bind_as(&prefixed, Some(without_prefix), 4), sinew_status::Ok);
        assert_eq!(map, expected);
        assert_eq!(bind_as(&prefixed, Some(without_prefix), 3), sinew_status::OtherName);
        let root = envelope.joint_name(envelope.root()).unwrap();
        let alone = if len > 1 { sinew_status::NoJoints } else { sinew_status::Ok };
        assert_eq!(bind(&[in_c(&root)]), alone);
        assert_eq!(map, expected);

        let turned = [[0.0, -1.0, 0.0, 2.0], [1.0, 0.0, 0.0, -0.25], [0.0, 0.0, 1.0, 3.5]];
        let world = vec![sinew_matrix { rows: turned }; names.len()];
        let frames = vec![turned; names.len()];
        for root in [None, Some(turned)] {
            let mut expected = vec![matrix::IDENTITY; len];
            gather_pose(&envelope, &map, &frames, root.as_ref(), &mut expected).unwrap();
            let root = root.map(|rows| sinew_matrix { rows });
            let root = root.as_ref().map_or(null(), std::ptr::from_ref);
            let mut pose = vec![sinew_matrix { rows: [[0.0; 4]; 3] }; len];
            let (map, world, out) =
                (map.as_ptr(), (world.as_ptr(), world.len()), pose.as_mut_ptr());
            // SAFETY: an open envelope, arrays with their lengths, and a matrix or none.
            done(unsafe {
                sinew_envelope_gather(handle, map, len, world.0, world.1, root, out, len, NONE)
            });
            assert_eq!(pose.iter().map(|m| m.rows).collect::<Vec<_>>(), expected);
        }
    });
}

#[test]
fn curves_are_bound_by_name() {
    each(|Both { c: (found, _), rust: (envelope, _), .. }| {
        // The engine's curves: an extra one, then the file's in reverse order.
        let len = envelope.curve_len();
        let own = (0..len).rev().map(|curve| envelope.curve_name(curve).unwrap());
        let names: Vec<&str> = ["smile"].into_iter().chain(own).collect();
        let in_c = |name: &&str| sinew_name { name: name.as_ptr().cast(), name_len: name.len() };
        let all: Vec<sinew_name> = names.iter().map(in_c).collect();
        let mut expected = vec![0; len];
        envelope.bind_curves(&names, &mut expected).unwrap();
        let mut map = vec![0; len];
        let (handle, at) = (found.handle, map.as_mut_ptr());
        let bind = |names: &[sinew_name], len: usize| {
            // SAFETY: an open envelope, and arrays with their lengths.
            unsafe {
                sinew_envelope_bind_curves(handle, names.as_ptr(), names.len(), at, len, NONE)
            }
        };
        done(bind(&all, len));
        let missing = if len > 0 { sinew_status::NoCurve } else { sinew_status::Ok };
        assert_eq!(bind(&all[..1], len), missing);
        assert_eq!(map, expected);
        let mut room = vec![0; len + 1];
        let (names, room_at) = (all.as_ptr(), room.as_mut_ptr());
        // SAFETY: an open envelope, and arrays with their lengths.
        let status =
            unsafe { sinew_envelope_bind_curves(handle, names, all.len(), room_at, len + 1, NONE) };
        assert_eq!(status, sinew_status::Length);
    });
}

#[test]
fn mistakes_are_named_and_scales_removed() {
    each(|Both { c: (found, _), rust: (envelope, _), .. }| {
        let curves = vec![0.0; envelope.curve_len()];
        let check = |pose: &[Matrix3x4]| {
            let at = pose.as_ptr().cast();
            // SAFETY: an open envelope, two arrays with their lengths, and one structure to be written.
            get(|out| unsafe {
                let (c, c_len) = (curves.as_ptr(), curves.len());
                sinew_envelope_check_pose(found.handle, at, pose.len(), c, c_len, out, NONE)
            })
        };
        let mut pose = rest(&envelope);
        let sound = check(&pose);
        assert_eq!((sound.kind, sound.axes), (sinew_pose_fault_kind::None, [0; 3]));
        let before = pose.clone();
        sinew_runtime::scale_palette(&mut pose, 2.0);
        let expected = envelope.check_pose(&pose, &curves).unwrap_err();
        let fault = check(&pose);
        assert_eq!(fault.kind, sinew_pose_fault_kind::Scaled);
        assert_eq!((fault.joint as usize, fault.factor), (expected.joint, expected.factor));
        assert_eq!((fault.found, fault.allowed), (expected.found, expected.allowed));
        assert_eq!(fault.axes, [1, 2, 3]);
        let (at, len) = (pose.as_mut_ptr().cast(), pose.len());
        // SAFETY: an array with its length, and one number to be written.
        let scale = get(|out| unsafe { sinew_pose_take_scale(at, len, out, NONE) });
        assert_eq!((scale, &pose), (2.0, &before));
        let at = pose.as_mut_ptr().cast();
        // SAFETY: an array with its length.
        done(unsafe { sinew_palette_scale(at, len, scale, NONE) });
        assert_eq!(pose[0], before[0].map(|row| row.map(|x| 2.0 * x)));
    });
    let text = |kind: u32| {
        // SAFETY: the library's texts end in a zero and stay valid.
        unsafe { CStr::from_ptr(sinew_pose_fault_text(kind)) }.to_str().unwrap()
    };
    for kind in PoseFaultKind::ALL {
        let is_known = !matches!(kind, PoseFaultKind::Length | PoseFaultKind::CurveLength);
        assert_eq!(text(kind as u32) != "unknown mistake", is_known, "{kind:?}");
    }
    assert!(text(0).starts_with("nothing"));
    assert_eq!([1, 16, 18].map(text), ["unknown mistake"; 3]);
}

#[test]
fn the_base_has_the_bits_of_the_runtime() {
    each(|Both { c: (found, _), rust: (envelope, _), .. }| {
        let pose = rest(&envelope);
        let (j, p, s) = (pose.len(), envelope.palette_len(), envelope.scratch_len());
        let (mut scratch, curves) = (vec![0.0; s], vec![0.25; envelope.curve_len()]);
        let mut expected = vec![[[0.0; 4]; 3]; p];
        let confidence =
            envelope.base_palette(&pose, &curves, &mut scratch, &mut expected).unwrap();
        let mut palette = vec![[[0.0; 4]; 3]; p];
        let (from, to, at) =
            (pose.as_ptr().cast(), palette.as_mut_ptr().cast(), scratch.as_mut_ptr());
        let (e, c, c_len) = (found.handle, curves.as_ptr(), curves.len());
        // SAFETY: an open envelope, arrays with their lengths, and one number to be written.
        let result = get(|out| unsafe {
            sinew_envelope_base_palette(e, from, j, c, c_len, at, s, to, p, out, NONE)
        });
        assert_eq!((result, palette), (confidence, expected));
    });
}

#[test]
fn joint_confidences_have_the_bits_of_the_runtime() {
    each(|Both { c: (found, _), rust: (envelope, _), .. }| {
        let pose = rest(&envelope);
        let (j, s) = (pose.len(), envelope.scratch_len());
        let (mut scratch, mut expected) = (vec![0.0; s], vec![0.5; j]);
        let curves = vec![0.25; envelope.curve_len()];
        let done = envelope.joint_confidences(&pose, &curves, &mut scratch, &mut expected);
        let mut result = vec![0.5_f32; j];
        let (from, at, out) = (pose.as_ptr().cast(), scratch.as_mut_ptr(), result.as_mut_ptr());
        let (e, c, c_len) = (found.handle, curves.as_ptr(), curves.len());
        // SAFETY: an open envelope, and arrays with their lengths.
        let status =
            unsafe { sinew_envelope_joint_confidences(e, from, j, c, c_len, at, s, out, j, NONE) };
        let is_known = if done.is_ok() { sinew_status::Ok } else { sinew_status::NoStage };
        assert_eq!((status, result), (is_known, expected));
    });
}

#[test]
fn bones_have_the_bits_of_the_runtime() {
    each(|Both { c: (found, _), rust: (envelope, _), .. }| {
        let (pose, p) = (rest(&envelope), envelope.proxy_len());
        let (mut scratch, mut palette) =
            (vec![0.0; envelope.scratch_len()], vec![[[0.0; 4]; 3]; envelope.palette_len()]);
        let (curves, mut expected) = (vec![0.25; envelope.curve_len()], vec![Trs::IDENTITY; p]);
        envelope.palette_trs(&pose, &curves, &mut scratch, &mut palette, &mut expected).unwrap();
        let empty = sinew_bone {
            translation: [0.5; 3],
            rotation: [0.5; 4],
            scale: [0.5; 3],
            centre: [0.5; 3],
        };
        let mut result = vec![empty; p];
        let (from, len, out) = (palette.as_ptr().cast(), palette.len(), result.as_mut_ptr());
        // SAFETY: an open envelope, and arrays with their lengths.
        done(unsafe { sinew_envelope_bones(found.handle, from, len, out, p, NONE) });
        for (helper, (bone, own)) in result.iter().zip(&expected).enumerate() {
            let in_c = (bone.translation, bone.rotation, bone.scale);
            assert_eq!(in_c, (own.translation, own.rotation, own.scale));
            assert_eq!(Some(bone.centre), envelope.helper_centre(helper));
        }
    });
}

#[test]
fn hashes_are_those_of_the_runtime() {
    each(|Both { c: (found, mesh), rust: (envelope, skin), .. }| {
        let joints = 0..envelope.joint_len();
        let names: Vec<&str> = joints.clone().filter_map(|j| envelope.joint_name(j)).collect();
        let parents = || joints.clone().map(|joint| envelope.parent(joint));
        let expected = skeleton_hash_of(&names, parents());
        assert_eq!((found.info().skeleton_hash, envelope.skeleton_hash()), (expected, expected));
        let in_c = |name: &&str| sinew_name { name: name.as_ptr().cast(), name_len: name.len() };
        let all: Vec<sinew_name> = names.iter().map(in_c).collect();
        let numbers: Vec<u32> =
            parents().map(|parent| parent.map_or(SINEW_NO_JOINT, |p| p as u32)).collect();
        let (at, above, len) = (all.as_ptr(), numbers.as_ptr(), all.len());
        // SAFETY: arrays with their length, and one number to be written.
        let result = get(|out| unsafe { sinew_skeleton_hash(at, above, len, out, NONE) });
        assert_eq!(result, expected);
        let positions: Vec<[f32; 3]> = skin.rest_positions().collect();
        let expected = mesh_hash_of(&positions);
        assert_eq!(skin.mesh_hash(), expected);
        let (at, len) = (positions.as_ptr().cast(), positions.len());
        // SAFETY: an array with its length, and one number to be written.
        assert_eq!(get(|out| unsafe { sinew_mesh_hash(at, len, out, NONE) }), expected);
        // SAFETY: an open skin, and one number to be written.
        assert_eq!(get(|out| unsafe { sinew_skin_mesh_hash(mesh.handle, out, NONE) }), expected);
        assert_ne!(expected, mesh_hash_of(&positions[1..]));
    });
}
