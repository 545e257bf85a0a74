//! Descriptions of models, envelopes and skins.

use crate::handles::{Loaded, NONE, done, get, name, unwritten};
use crate::{Both, each, with};
use models::{GOLDEN, GOLDEN_KIND, Pieces, SMALL, Shape, TURNED, head};
use sinew_capi::*;
use sinew_runtime::envelope::Predictor;
use sinew_runtime::format::{Axis, Handedness, Space};
use sinew_runtime::{Envelope, LocalTransform, Model, Skin};
use std::ops::Range;
use std::ptr::null;

#[test]
fn versions_and_sizes_are_right() {
    assert_eq!(sinew_abi_version(), SINEW_ABI_VERSION);
    assert_eq!(sinew_format_version(), u32::from(sinew_runtime::format::VERSION));
    assert!(sinew_model_bytes() <= SINEW_MODEL_WORDS * size_of::<usize>());
    assert!(sinew_part_bytes() <= SINEW_PART_WORDS * size_of::<usize>());
    // SAFETY: the library's text ends in a zero.
    let version = unsafe { std::ffi::CStr::from_ptr(sinew_version()) };
    assert_eq!(version.to_str(), Ok(env!("CARGO_PKG_VERSION")));
}

#[test]
fn default_limits_are_the_runtimes() {
    // SAFETY: one structure to be written.
    let found = get(|out| unsafe { sinew_limits_default(out, NONE) });
    let expected = sinew_runtime::Limits::DEFAULT;
    let sinew_limits { file_bytes, parts, sections, vertices, .. } = found;
    let sinew_limits { joints, proxies, influences, shapes, curves, .. } = found;
    let found = sinew_runtime::Limits {
        file_bytes,
        parts,
        sections,
        vertices,
        joints,
        proxies,
        influences,
        shapes,
        curves,
    };
    assert_eq!(found, expected);
}

#[test]
fn models_are_described() {
    let describe = |pieces: &Pieces| {
        let file = pieces.bytes();
        let model = Loaded::new(&file);
        // SAFETY: a loaded model and one structure to be written.
        get(|out| unsafe { sinew_model_describe(model.handle, out, NONE) })
    };
    let mut pieces = Pieces::several();
    let found = describe(&pieces);
    assert_eq!((found.part_len, found.envelope_len, found.skin_len), (5, 2, 3));
    assert_eq!(found.kernel_len, 0);
    for (number, up) in Axis::ALL.into_iter().enumerate() {
        let forward = Axis::ALL.into_iter().find(|axis| !axis.is_along(up));
        let (up, handedness) = (Some(up), [Handedness::Right, Handedness::Left][number % 2]);
        let unit = [None, Some(0.01)][number % 2];
        let space = Space { up, forward, handedness, unit };
        pieces.head[head::SPACE].copy_from_slice(&space.to_bytes());
        let found = describe(&pieces);
        let in_file = |axis: Option<Axis>| axis.map_or(0, |axis| u32::from(axis.number()));
        assert_eq!([found.up as u32, found.forward as u32], [in_file(up), in_file(forward)]);
        assert_eq!(found.handedness as u32, handedness as u32);
        assert_eq!(found.unit, unit.unwrap_or(0.0));
    }
    pieces.head[head::SPACE].copy_from_slice(&Space::default().to_bytes());
    let found = describe(&pieces);
    assert_eq!([found.up, found.forward], [sinew_axis::Unknown; 2]);
}

#[test]
fn parts_are_opened_by_name_and_number() {
    let file = Pieces::several().bytes();
    let (model, expected) = (Loaded::new(&file), Model::from_bytes(&*file).unwrap());
    for (index, envelope) in expected.all::<Envelope>().enumerate() {
        let info = model.envelope(None, index).unwrap().info();
        assert_eq!(info.part as usize, envelope.part());
        // Both envelopes have one name.
        let named = model.envelope(Some(envelope.name()), index).unwrap().info();
        assert_eq!(named.part as usize, envelope.part());
    }
    for (index, skin) in expected.all::<Skin>().enumerate() {
        let info = model.skin(None, index).unwrap().info();
        assert_eq!(info.part as usize, skin.part());
    }
    assert_eq!(model.skin(Some("eye"), 0).unwrap().info().part, 4);
    let missing = Some(sinew_status::NotFound);
    for (name, index) in [(None, 2), (Some("eye"), 0), (Some("arm"), 2), (Some(""), 0)] {
        assert_eq!(model.envelope(name, index).err(), missing, "{name:?} {index}");
    }
    for (name, index) in [(None, 3), (Some("eye"), 1), (Some("arm"), 0), (Some("\0"), 0)] {
        assert_eq!(model.skin(name, index).err(), missing, "{name:?} {index}");
    }
}

#[test]
fn envelopes_are_described() {
    each(|Both { c: (found, _), rust: (envelope, _), .. }| {
        let info = found.info();
        assert_eq!(name(info.name, info.name_len), envelope.name());
        assert_eq!(info.part as usize, envelope.part());
        assert_eq!(info.predictor as u32, u32::from(envelope.predictor().number()));
        assert_eq!(info.joint_len, envelope.joint_len());
        assert_eq!(info.curve_len, envelope.curve_len());
        assert_eq!(info.stretches == 1, envelope.stretches());
        assert_eq!(info.proxy_len, envelope.proxy_len());
        assert_eq!(info.palette_len, envelope.palette_len());
        assert_eq!(info.scratch_len, envelope.scratch_len());
        assert_eq!(info.root as usize, envelope.root());
        let (found, expected) = (info.certificate, envelope.certificate());
        assert_eq!(found.diagonal, expected.diagonal);
        assert_eq!(found.training_rms, expected.training_rms);
        assert_eq!(found.same_clips_rms, expected.same_clips_rms);
        assert_eq!(found.lbs_training_rms, expected.lbs_training_rms);
        assert_eq!(found.correction_error, expected.correction_error);
        assert_eq!(found.base_training_rms, expected.base_training_rms);
        assert_eq!(found.other_clip_rms, expected.other_clip_rms.unwrap_or(-1.0));
        assert_eq!(found.trs_error, expected.trs_error);
    });
}

#[test]
fn skins_are_described() {
    each(|Both { c: (_, found), rust: (_, skin), .. }| {
        let info = found.info();
        assert_eq!(name(info.name, info.name_len), skin.name());
        assert_eq!(info.part as usize, skin.part());
        assert_eq!(Some(info.envelope_part as usize), skin.envelope_part());
        assert_eq!(info.vertex_len, skin.vertex_len());
        assert_eq!(info.influence_len, skin.influence_len());
        assert_eq!(info.palette_len, skin.palette_len());
        assert_eq!(info.has_tangents == 1, skin.has_tangents());
        assert_eq!(info.has_coefficients == 1, skin.has_coefficients());
        assert_eq!(info.range_len, skin.ranges().count());
        for (index, (expected, vertices)) in skin.ranges().enumerate() {
            let range = found.range(index);
            assert_eq!(name(range.name, range.name_len), expected);
            assert_eq!(range.start..range.end, vertices);
        }
        assert!(info.range_len > 1);
    });
}

#[test]
fn joints_are_those_of_the_file() {
    each(|Both { c: (found, _), rust: (envelope, _), .. }| {
        for joint in 0..envelope.joint_len() {
            // SAFETY: an open envelope and one structure to be written.
            let found = get(|out| unsafe { sinew_envelope_joint(found.handle, joint, out, NONE) });
            assert_eq!(Some(name(found.name, found.name_len)), envelope.joint_name(joint));
            let parent = Some(found.parent).filter(|parent| *parent != SINEW_NO_JOINT);
            assert_eq!(parent.map(|parent| parent as usize), envelope.parent(joint));
            assert_eq!(Some(found.pose_range), envelope.pose_range(joint));
            assert_eq!(Some(found.pose_gap), envelope.pose_gap(joint));
            assert_eq!(Some(found.stretch_range), envelope.stretch_range(joint));
            assert_eq!(Some(found.inverse_bind.rows), envelope.inverse_bind(joint));
            let sinew_local_transform { rotation, translation } = found.rest_local;
            let local = LocalTransform { rotation, translation };
            assert_eq!(Some(local), envelope.rest_local(joint));
        }
    });
}

#[test]
fn curves_are_those_of_the_file() {
    each(|Both { c: (found, _), rust: (envelope, _), .. }| {
        for curve in 0..envelope.curve_len() {
            // SAFETY: an open envelope and one structure to be written.
            let found = get(|out| unsafe { sinew_envelope_curve(found.handle, curve, out, NONE) });
            assert_eq!(Some(name(found.name, found.name_len)), envelope.curve_name(curve));
            assert_eq!(Some([found.min, found.max]), envelope.curve_range(curve));
        }
        let mut out = sinew_curve { name: null(), name_len: 0, min: 0.0, max: 0.0 };
        let mut error = unwritten();
        let (len, out, out_error) = (envelope.curve_len(), &raw mut out, &raw mut error);
        // SAFETY: an open envelope and two structures to be written.
        let status = unsafe { sinew_envelope_curve(found.handle, len, out, out_error) };
        assert_eq!((status, error.found), (sinew_status::OutOfRange, len));
        assert_eq!(error.argument, sinew_argument::Curve);
    });
}

/// The files are the golden skins with tangent coefficients, and samples with and without each attribute.
#[test]
fn attributes_have_the_bits_of_the_file() {
    let any = [false, true];
    let have =
        any.into_iter().flat_map(|tangents| any.map(|coefficients| (tangents, coefficients)));
    let shapes = [1, 3, 4].into_iter().flat_map(|influences| {
        have.clone().map(move |(tangents, coefficients)| Shape {
            influences,
            tangents,
            coefficients,
            ..SMALL
        })
    });
    let samples = shapes.map(|shape| Pieces::sample(Predictor::Kernel, shape).bytes());
    for file in TURNED.map(<[u8]>::to_vec).into_iter().chain(samples) {
        with(&file, |Both { c: (_, found), rust: (_, skin), .. }| {
            let v = skin.vertex_len();
            for vertices in [0..v, 2..v - 1, v..v] {
                for (attribute, expected) in attributes(&skin, vertices.clone()) {
                    let bits = |floats: Vec<f32>| floats.into_iter().map(f32::to_bits).collect();
                    let expected = expected.map(bits).ok_or(sinew_status::NoAttribute);
                    let found = found.attribute(attribute, vertices.clone());
                    let found: Result<Vec<_>, _> = found.map(bits).map_err(|error| error.status);
                    assert_eq!(found, expected, "{attribute:?} {vertices:?}");
                }
            }
        });
    }
}

/// Lists the attributes of vertices by the runtime; `None` if the skin lacks the attribute.
fn attributes(skin: &Skin<'_>, vertices: Range<usize>) -> [(sinew_attribute, Option<Vec<f32>>); 4] {
    use sinew_attribute as A;
    let positions = vertices.clone().flat_map(|v| skin.rest_position(v).unwrap()).collect();
    let normals = vertices.clone().flat_map(|v| skin.rest_normal(v).unwrap()).collect();
    let tangents = vertices.clone().map(|v| skin.rest_tangent(v));
    let tangents = tangents.collect::<Option<Vec<_>>>().map(|rows| rows.concat());
    let coefficients = vertices.flat_map(|v| skin.tangent_coefficients(v)).flatten().collect();
    [
        (A::Position, Some(positions)),
        (A::Normal, Some(normals)),
        (A::Tangent, tangents.filter(|_| skin.has_tangents())),
        (A::TangentCoefficients, skin.has_coefficients().then_some(coefficients)),
    ]
}

#[test]
fn golden_skins_have_three_and_four_influences() {
    let counts = TURNED.map(|file| {
        let model = Loaded::new(file);
        let info = model.skin(None, 0).unwrap().info();
        (info.influence_len, info.has_tangents, info.has_coefficients)
    });
    assert_eq!(counts, [(4, 1, 1), (3, 0, 1)]);
}

#[test]
fn errors_of_normals_are_those_of_the_file() {
    let bare = Shape { coefficients: false, ..SMALL };
    let bare = Pieces::sample(Predictor::Kernel, bare).bytes();
    for (file, has_errors) in [(TURNED[0], true), (TURNED[1], true), (&bare, false)] {
        with(file, |Both { c: (_, found), rust: (_, skin), .. }| {
            let expected = skin.normal_errors();
            assert_eq!(expected.is_some(), has_errors);
            let expected = expected.map_or([-1.0; 3], |it| [it.model, it.cofactors, it.lbs]);
            assert_eq!(found.info().normal_errors, expected);
        });
    }
}

#[test]
fn helper_kinds_are_those_of_the_file() {
    use sinew_helper_kind as Kind;
    let files = [GOLDEN[0], GOLDEN[1], GOLDEN_KIND[0], GOLDEN_KIND[1]];
    for (file, kind) in files.into_iter().zip([Kind::Affine, Kind::Affine, Kind::Trs, Kind::Rigid])
    {
        with(file, |Both { c: (found, _), rust: (envelope, _), .. }| {
            assert_eq!(found.info().helper_kind, kind);
            assert_eq!(kind as u32, u32::from(envelope.helper_kind().number()));
        });
    }
}

#[test]
fn influences_are_those_of_the_file() {
    each(|Both { c: (_, found), rust: (_, skin), .. }| {
        let (v, s) = (skin.vertex_len(), found.handle);
        for vertices in [0..v, 2..v - 1] {
            let (start, end) = (vertices.start, vertices.end);
            let n = vertices.len();
            let k = skin.influence_len();
            let (mut indices, mut weights) = (vec![0; k * n], vec![0.0; k * n]);
            let (at, at_weights) = (indices.as_mut_ptr(), weights.as_mut_ptr());
            // SAFETY: an open skin and two arrays with their lengths.
            done(unsafe {
                sinew_skin_influences(s, start, end, at, k * n, at_weights, k * n, NONE)
            });
            let found = indices.iter().map(|index| usize::from(*index)).zip(weights);
            let expected = vertices.clone().flat_map(|vertex| skin.influences(vertex));
            assert_eq!(found.collect::<Vec<_>>(), expected.collect::<Vec<_>>());
        }
    });
}

#[test]
fn the_blob_holds_every_section() {
    let file = Pieces::several().bytes();
    let (found, model) = (Loaded::new(&file), Model::from_bytes(&*file).unwrap());
    let mut bytes = 0;
    // SAFETY: a loaded model and two values to be written.
    let blob = get(|out| unsafe { sinew_model_blob(found.handle, out, &raw mut bytes, NONE) });
    assert_eq!((blob, bytes), (model.blob().as_ptr(), model.blob().len()));
    for section in model.sections() {
        let (part, kind) = (u32::from(section.row.part), u32::from(section.row.kind));
        // SAFETY: a loaded model and one structure to be written.
        let found = get(|out| unsafe { sinew_model_section(found.handle, part, kind, out, NONE) });
        assert_eq!((found.offset, found.bytes), (section.row.offset, section.row.bytes));
    }
    assert!(model.sections().len() > 30);
}
