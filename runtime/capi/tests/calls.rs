//! The functions, called in this process: they give what the runtime gives.
#![allow(clippy::unwrap_used, reason = "a test's helpers fail as the test does")]

#[path = "../../tests/common/mod.rs"]
mod builder;
mod handles;

use builder::{Builder, SMALL, Shape, random_pose};
use handles::{Handles, NONE, done, matrices, name};
use sinew_capi::*;
use sinew_runtime::format::{Predictor, SectionKind};
use sinew_runtime::{Envelope, Limits, Matrix3x4, Model};
use std::mem::MaybeUninit;
use std::ptr::null_mut;

const BARE: Shape = Shape { tangents: false, ..SMALL };
const EMPTY: Shape = Shape { vertices: 0, ..SMALL };

/// Runs a test on a model of every predictor, with the C handles and the runtime's own view.
fn each(test: impl Fn(&Handles, Envelope<'_>)) {
    for predictor in Predictor::ALL {
        for shape in [SMALL, BARE] {
            with(&Builder::of(predictor, shape).bytes(), &test);
        }
    }
}

fn with(file: &[u8], test: impl Fn(&Handles, Envelope<'_>)) {
    let handles = Handles::load(file);
    test(&handles, Model::from_bytes(file).unwrap().envelope().unwrap());
}

/// Gets a value that a function writes.
fn get<T>(call: impl FnOnce(*mut T) -> sinew_status) -> T {
    let mut out = MaybeUninit::uninit();
    done(call(out.as_mut_ptr()));
    // SAFETY: the call succeeded and has written its result.
    unsafe { out.assume_init() }
}

#[test]
fn it_says_what_it_is() {
    assert_eq!(sinew_abi_version(), SINEW_ABI_VERSION);
    assert_eq!(sinew_format_version(), u32::from(sinew_runtime::format::VERSION));
    assert!(sinew_model_bytes() <= SINEW_MODEL_WORDS * size_of::<usize>());
    assert!(sinew_envelope_bytes() <= SINEW_ENVELOPE_WORDS * size_of::<usize>());
    assert_eq!(sinew_object_alignment(), align_of::<usize>());
    // SAFETY: a text of the library, ended by a zero.
    let version = unsafe { std::ffi::CStr::from_ptr(sinew_version()) };
    assert_eq!(version.to_str(), Ok(env!("CARGO_PKG_VERSION")));
    // SAFETY: one structure to be written.
    let limits = get(|out| unsafe { sinew_limits_default(out, NONE) });
    let Limits { file_bytes, vertices, joints, proxies, influences } = Limits::DEFAULT;
    assert_eq!(limits, sinew_limits { file_bytes, vertices, joints, proxies, influences });
}

#[test]
fn the_envelope_is_described() {
    each(|handles, envelope| {
        let info = handles.info();
        assert_eq!(name(info.name, info.name_len), envelope.name());
        assert_eq!(info.part as usize, envelope.part());
        assert_eq!(info.predictor as u32, u32::from(envelope.predictor().number()));
        assert_eq!(info.vertex_len, envelope.vertex_len());
        assert_eq!(info.joint_len, envelope.joint_len());
        assert_eq!(info.proxy_len, envelope.proxy_len());
        assert_eq!(info.palette_len, envelope.palette_len());
        assert_eq!(info.workspace_len, envelope.workspace_len());
        assert_eq!(info.influence_len, envelope.influence_len());
        assert_eq!(info.root as usize, envelope.root());
        assert_eq!(info.has_tangents == 1, envelope.has_tangents());
        let (found, expected) = (info.certificate, envelope.certificate());
        assert_eq!(found.diagonal, expected.diagonal);
        assert_eq!(found.training_rms, expected.training_rms);
        assert_eq!(found.cross_validated_rms, expected.cross_validated_rms);
        assert_eq!(found.lbs_training_rms, expected.lbs_training_rms);
        assert_eq!(found.correction_error, expected.correction_error);
    });
}

#[test]
fn joints_are_those_of_the_file() {
    each(|handles, envelope| {
        for joint in 0..envelope.joint_len() {
            // SAFETY: a loaded envelope and one structure to be written.
            let found =
                get(|out| unsafe { sinew_envelope_joint(handles.envelope(), joint, out, NONE) });
            assert_eq!(Some(name(found.name, found.name_len)), envelope.joint_name(joint));
            let parent = Some(found.parent).filter(|parent| *parent != SINEW_NO_JOINT);
            assert_eq!(parent.map(|parent| parent as usize), envelope.parent(joint));
            assert_eq!(Some(found.pose_range), envelope.pose_range(joint));
            assert_eq!(Some(found.inverse_bind.rows), envelope.inverse_bind(joint));
        }
        let mut order = vec![0; envelope.joint_len()];
        // SAFETY: a loaded envelope and an array with its length.
        done(unsafe {
            sinew_envelope_order(handles.envelope(), order.as_mut_ptr(), order.len(), NONE)
        });
        let order = order.into_iter().map(|joint| joint as usize).collect::<Vec<_>>();
        assert_eq!(order, envelope.evaluation_order().collect::<Vec<_>>());
    });
}

#[test]
fn the_mesh_is_that_of_the_file() {
    each(|handles, envelope| {
        let (v, e) = (envelope.vertex_len(), handles.envelope());
        for vertices in [0..v, 2..v - 1] {
            let (start, end) = (vertices.start, vertices.end);
            let n = vertices.len();
            let mut out = vec![0.0; 3 * n];
            // SAFETY: a loaded envelope and an array with its length.
            done(unsafe {
                sinew_envelope_rest_positions(e, start, end, out.as_mut_ptr(), 3 * n, NONE)
            });
            let rest = vertices.clone().flat_map(|v| envelope.rest_position(v).unwrap());
            assert_eq!(out, rest.collect::<Vec<_>>());
            // SAFETY: the same.
            done(unsafe {
                sinew_envelope_rest_normals(e, start, end, out.as_mut_ptr(), 3 * n, NONE)
            });
            let rest = vertices.clone().flat_map(|v| envelope.rest_normal(v).unwrap());
            assert_eq!(out, rest.collect::<Vec<_>>());
            let mut out = vec![0.0; 4 * n];
            // SAFETY: the same.
            let status = unsafe {
                sinew_envelope_rest_tangents(e, start, end, out.as_mut_ptr(), 4 * n, NONE)
            };
            if envelope.has_tangents() {
                let rest = vertices.clone().flat_map(|v| envelope.rest_tangent(v).unwrap());
                assert_eq!(out, rest.collect::<Vec<_>>());
            } else {
                assert_eq!(status, sinew_status::NoTangents);
            }
            let k = envelope.influence_len();
            let (mut indices, mut weights) = (vec![0; k * n], vec![0.0; k * n]);
            let (at, at_weights) = (indices.as_mut_ptr(), weights.as_mut_ptr());
            // SAFETY: a loaded envelope and two arrays with their lengths.
            done(unsafe {
                sinew_envelope_influences(e, start, end, at, k * n, at_weights, k * n, NONE)
            });
            let found = indices.iter().map(|index| usize::from(*index)).zip(weights);
            let expected = vertices.clone().flat_map(|vertex| envelope.influences(vertex));
            assert_eq!(found.collect::<Vec<_>>(), expected.collect::<Vec<_>>());
        }
    });
}

#[test]
fn the_blob_holds_every_section() {
    each(|handles, _| {
        let model = Model::from_bytes(handles.file()).unwrap();
        let mut bytes = 0;
        // SAFETY: a loaded model and two values to be written.
        let blob =
            get(|out| unsafe { sinew_model_blob(handles.model(), out, &raw mut bytes, NONE) });
        assert_eq!((blob, bytes), (model.blob().as_ptr(), model.blob().len()));
        for section in model.sections() {
            let kind = u32::from(section.row.kind);
            let part = u32::from(section.row.part);
            // SAFETY: a loaded model and one structure to be written.
            let found =
                get(|out| unsafe { sinew_model_section(handles.model(), part, kind, out, NONE) });
            assert_eq!((found.offset, found.bytes), (section.row.offset, section.row.bytes));
            let known = sinew_subject::from(SectionKind::from_number(section.row.kind).unwrap());
            assert_eq!(known as u32 - sinew_subject::Certificate as u32, kind);
        }
        assert!(model.sections().len() > 8);
    });
}

#[test]
fn evaluation_has_the_bits_of_the_runtime() {
    each(|handles, envelope| {
        let mut random = builder::Rng(3);
        for turn in [0.05, 0.5, 4.0] {
            let local = (0..envelope.joint_len()).map(|_| random.local(turn)).collect::<Vec<_>>();
            let mut pose = vec![builder::IDENTITY; envelope.joint_len()];
            sinew_runtime::model_space_pose(&envelope, &local, &mut pose).unwrap();
            assert_eq!(handles.pose(&local), pose);
            let (palette, confidence) = builder::confident_palette(&envelope, &pose);
            assert_eq!(handles.palette(&pose), (palette.clone(), confidence));
            if envelope.predictor() == Predictor::Rotational {
                let by_its_own = handles.palette_by(sinew_envelope_rotational_palette, &pose);
                assert_eq!(by_its_own, (palette.clone(), confidence));
            }
            let bounds = envelope.bounds(&palette).unwrap().unwrap();
            let maps = matrices(&palette);
            // SAFETY: a loaded envelope, an array with its length, a structure to be written.
            let found = get(|out| unsafe {
                sinew_envelope_bounds(handles.envelope(), maps, palette.len(), out, NONE)
            });
            assert_eq!((found.min, found.max), (bounds.min, bounds.max));
            if envelope.has_tangents() {
                let expected = builder::skin(envelope, &palette);
                assert_eq!(skin(handles, &palette, 0..envelope.vertex_len()), expected);
            }
        }
    });
}

/// Skins a range into one buffer for positions and normals and one for tangents.
fn skin(handles: &Handles, palette: &[Matrix3x4], vertices: std::ops::Range<usize>) -> Vec<f32> {
    let n = vertices.len();
    let (mut a, mut b) = (vec![f32::NAN; 6 * n], vec![f32::NAN; 4 * n]);
    let attribute = |buffer, offset, stride| sinew_attribute { buffer, offset, stride };
    let job = sinew_skin_job {
        envelope: handles.envelope(),
        palette: matrices(palette),
        palette_len: palette.len(),
        start: vertices.start,
        end: vertices.end,
        positions: attribute(sinew_buffer::A as u32, 0, 3),
        normals: attribute(sinew_buffer::A as u32, 3 * n, 3),
        tangents: attribute(sinew_buffer::B as u32, 0, 4),
        out_a: a.as_mut_ptr(),
        out_a_len: a.len(),
        out_b: b.as_mut_ptr(),
        out_b_len: b.len(),
    };
    // SAFETY: every pointer of the job comes with its length.
    done(unsafe { sinew_skin(&raw const job, NONE) });
    [a, b].concat()
}

#[test]
fn threads_share_models_and_skin_ranges_at_once() {
    with(&Builder::of(Predictor::Hybrid, SMALL).bytes(), |handles, envelope| {
        let pose = random_pose(&envelope, &mut builder::Rng(5), 0.3);
        let (palette, _) = handles.palette(&pose);
        let v = envelope.vertex_len();
        let whole = skin(handles, &palette, 0..v);
        let halves = std::thread::scope(|scope| {
            let palette = &palette;
            let run = |range| scope.spawn(move || skin(handles, palette, range));
            [run(0..3), run(3..v)].map(|half| half.join().unwrap())
        });
        let positions = [&halves[0][..9], &halves[1][..3 * (v - 3)]].concat();
        assert_eq!(positions, whole[..3 * v]);
    });
}

#[test]
fn objects_can_be_moved_and_files_lie_anywhere() {
    let file = Builder::of(Predictor::Kernel, SMALL).bytes();
    let mut shifted = vec![0; file.len() + 1];
    shifted[1..].copy_from_slice(&file);
    with(&shifted[1..], |handles, envelope| {
        let pose = random_pose(&envelope, &mut builder::Rng(5), 0.3);
        assert_eq!(handles.moved().palette(&pose), handles.palette(&pose));
    });
}

#[test]
fn a_mesh_without_vertices_has_no_bounds() {
    with(&Builder::of(Predictor::Rotational, EMPTY).bytes(), |handles, envelope| {
        let (palette, _) = handles.palette(&vec![builder::IDENTITY; envelope.joint_len()]);
        let mut bounds = sinew_bounds { min: [7.0; 3], max: [7.0; 3] };
        let (e, maps) = (handles.envelope(), matrices(&palette));
        // SAFETY: a loaded envelope, an array with its length, a structure to be written.
        let status =
            unsafe { sinew_envelope_bounds(e, maps, palette.len(), &raw mut bounds, NONE) };
        assert_eq!(status, sinew_status::NoVertices);
        assert_eq!(bounds, sinew_bounds { min: [7.0; 3], max: [7.0; 3] });
        assert!(skin(handles, &palette, 0..0).is_empty());
    });
}

#[test]
fn errors_say_what_was_expected_and_found() {
    with(&Builder::of(Predictor::Rotational, SMALL).bytes(), |handles, envelope| {
        let mut error = MaybeUninit::<sinew_error>::uninit();
        let (e, at) = (handles.envelope(), error.as_mut_ptr());
        let j = envelope.joint_len();
        // SAFETY: a loaded envelope; the array is null.
        let status = unsafe { sinew_envelope_order(e, null_mut(), 0, at) };
        // SAFETY: the call failed and has written the error.
        let error = unsafe { error.assume_init() };
        let expected = sinew_error {
            status: sinew_status::TooShort,
            subject: sinew_subject::Order,
            index: 0,
            expected: j as u64,
            found: 0,
        };
        assert_eq!((status, error), (sinew_status::TooShort, expected));
    });
}
