//! Refused calls, the fields of their errors, and the conversion of the runtime's errors to C.

use crate::handles::{self, Loaded, NONE, done, get, matrices, output, unwritten};
use crate::{Both, EMPTY, common, with};
use models::{Pieces, SMALL, Shape};
use sinew_capi::*;
use sinew_runtime::envelope::Predictor;
use sinew_runtime::format::SectionKind;
use sinew_runtime::{Argument, CallError, CallErrorKind, FileError, FileErrorKind, Matrix3x4};
use std::fmt::Debug;
use std::ptr::{null, null_mut};

/// Calls refuse a part after its model has loaded another file. They do not read the old file, which Miri would report.
#[test]
fn a_stale_part_is_refused() {
    let file = Pieces::small(Predictor::Kernel).bytes();
    let mut model = Loaded::new(&file);
    let (envelope, skin) = (model.envelope(None, 0).unwrap(), model.skin(None, 0).unwrap());
    let (info, mesh) = (envelope.info(), skin.info());
    let pose = vec![common::IDENTITY; info.joint_len];
    let (palette, _) = envelope.palette(&pose);
    let mut positions = vec![f32::NAN; 3 * mesh.vertex_len];
    let mut job = skin.job(&palette, 0..mesh.vertex_len);
    job.positions = output(&mut positions, 3);
    let refused = || {
        let mut error = unwritten();
        let mut out_info = info;
        // SAFETY: an open envelope and two structures to be written.
        let by_envelope =
            unsafe { sinew_envelope_describe(envelope.handle, &raw mut out_info, &raw mut error) };
        let about_envelope = error.argument;
        // SAFETY: every pointer of the job comes with its length.
        let by_skin = unsafe { sinew_skin_run(&raw const job, &raw mut error) };
        [(by_envelope, about_envelope), (by_skin, error.argument)]
    };

    let same = file.clone();
    drop(file);
    done(model.load(&same));
    assert_eq!(envelope.palette(&pose).0, palette);

    let other = Pieces::small(Predictor::Rotational).bytes();
    done(model.load(&other));
    drop(same);
    let stale = sinew_status::Stale;
    assert_eq!(refused(), [(stale, sinew_argument::Envelope), (stale, sinew_argument::Skin)]);
    assert_eq!(model.load(&other[1..]), sinew_status::FileNotAModel);
    assert_eq!(refused(), [(stale, sinew_argument::Envelope), (stale, sinew_argument::Skin)]);
    let again = model.envelope(None, 0).unwrap();
    assert_eq!(again.info().predictor, sinew_predictor::Rotational);

    model.empty();
    drop(other);
    assert_eq!(refused(), [(sinew_status::NotLoaded, sinew_argument::Model); 2]);
    let anew = Pieces::small(Predictor::Kernel).bytes();
    done(model.load(&anew));
    assert_eq!(envelope.palette(&pose).0, palette);
}

/// A null name with a length is refused. Only a null name of length 0 matches every part.
#[test]
fn a_null_name_of_some_length_is_refused() {
    let file = Pieces::small(Predictor::Rotational).bytes();
    let model = Loaded::new(&file);
    let mut place = handles::memory(64);
    let (at, bytes) = (place.as_mut_ptr().cast(), size_of_val(&*place));
    let opened = |kind: u32, len: usize| {
        let mut error = unwritten();
        let out_error = &raw mut error;
        // SAFETY: a loaded model, memory with its length, and a value to be written; the name is null.
        let status =
            unsafe { sinew_part_open(model.handle, kind, null(), len, 0, at, bytes, out_error) };
        (status, error)
    };
    use sinew_part_kind as Kind;
    let every = [Kind::Envelope, Kind::Skin, Kind::Kernel, Kind::Prior, Kind::Views, Kind::Filter];
    for (kind, len) in every.into_iter().zip([1, 4, 1, 1, 1, usize::MAX]) {
        let (status, error) = opened(kind as u32, len);
        assert_eq!((status, error.argument), (sinew_status::Null, sinew_argument::Name));
    }
    assert_eq!(opened(Kind::Envelope as u32, 0).0, sinew_status::Ok);
    assert_eq!(opened(Kind::Skin as u32, 0).0, sinew_status::Ok);
    assert_eq!(opened(Kind::Kernel as u32, 0).0, sinew_status::NotFound);
    for kind in [0, 7, u32::MAX] {
        let (status, error) = opened(kind, 0);
        assert_eq!((status, error.argument), (sinew_status::OutOfRange, sinew_argument::Kind));
        assert_eq!((error.expected, error.found), (6, kind as usize));
    }
}

#[test]
fn a_mesh_without_vertices_has_no_bounds() {
    with(
        &Pieces::sample(Predictor::Rotational, EMPTY).bytes(),
        |Both { c: (envelope, skin), .. }| {
            let pose = vec![common::IDENTITY; envelope.info().joint_len];
            let (palette, _) = envelope.palette(&pose);
            let mut bounds = sinew_bounds { min: [7.0; 3], max: [7.0; 3] };
            let (at, len, out) = (matrices(&palette), palette.len(), &raw mut bounds);
            // SAFETY: an open skin, an array with its length, a structure to be written.
            let status = unsafe { sinew_skin_bounds(skin.handle, at, len, 0.0, out, NONE) };
            assert_eq!(status, sinew_status::NoVertices);
            assert_eq!(bounds, sinew_bounds { min: [7.0; 3], max: [7.0; 3] });
            // An output of length 0 counts as an output; a job without outputs is refused.
            let mut none: [f32; 0] = [];
            let mut job = skin.job(&palette, 0..0);
            // SAFETY: every pointer of the job comes with its length.
            let run = |job: &sinew_skin_job| unsafe { sinew_skin_run(job, NONE) };
            assert_eq!(run(&job), sinew_status::NoOutput);
            job.normals = output(&mut none, 3);
            assert_eq!(run(&job), sinew_status::Ok);
            job.remap = [0u32; 0].as_ptr();
            assert_eq!(run(&job), sinew_status::Ok);
        },
    );
}

#[test]
fn errors_say_what_was_expected_and_found() {
    with(&Pieces::sample(Predictor::Rotational, SMALL).bytes(), |Both { model, c, rust }| {
        let mut error = unwritten();
        let plain = sinew_error {
            status: sinew_status::TooShort,
            argument: sinew_argument::Local,
            part: SINEW_NO_PART,
            section: 0,
            index: 0,
            expected: rust.0.joint_len(),
            found: 0,
        };
        // SAFETY: an open envelope; the array is null.
        let status =
            unsafe { sinew_envelope_rest_locals(c.0.handle, null_mut(), 0, &raw mut error) };
        assert_eq!((status, error), (plain.status, plain));
        let mut section = sinew_section { offset: 0, bytes: 0 };
        let not_found = |part, section| {
            let (status, argument) = (sinew_status::NotFound, sinew_argument::Section);
            sinew_error { status, argument, part, section, expected: 0, ..plain }
        };
        for (part, kind) in [(0, 999), (0, 65_536 + 1), (7, 1)] {
            let (out, at) = (&raw mut section, &raw mut error);
            // SAFETY: a loaded model and two structures to be written.
            let status = unsafe { sinew_model_section(model.handle, part, kind, out, at) };
            assert_eq!((status, error), (sinew_status::NotFound, not_found(part, kind)));
        }
        // The error about a limit names the section and the index of the count.
        // SAFETY: one structure to be written.
        let mut limits = get(|out| unsafe { sinew_limits_default(out, NONE) });
        limits.vertices = 1;
        let file = Pieces::small(Predictor::Rotational).bytes();
        let mut place = handles::memory(SINEW_MODEL_WORDS);
        let (at, bytes, mut out) = (place.as_mut_ptr().cast(), size_of_val(&*place), null());
        let (file, len, limits) = (file.as_ptr(), file.len(), &raw const limits);
        let (out, out_error) = (&raw mut out, &raw mut error);
        // SAFETY: memory and a file with their lengths, limits, and two values to be written.
        let status = unsafe { sinew_model_load(at, bytes, file, len, limits, out, out_error) };
        let too_many = sinew_error {
            status: sinew_status::FileLimit,
            argument: sinew_argument::File,
            part: 1,
            section: 19,
            index: 0,
            expected: 1,
            found: rust.1.vertex_len(),
        };
        assert_eq!((status, error), (too_many.status, too_many));
    });
}

/// Curves are checked as a pose is: length, pointer, and memory that is written.
#[test]
fn curves_are_refused_as_a_pose_is() {
    let file = Pieces::small(Predictor::Kernel).bytes();
    with(&file, |Both { c: (envelope, _), .. }| {
        let info = envelope.info();
        let pose = vec![common::IDENTITY; info.joint_len];
        let mut palette = vec![[[0.0; 4]; 3]; info.palette_len];
        let mut scratch = vec![0.0; info.scratch_len + info.curve_len + 1];
        let (at, out, out_len) = (scratch.as_mut_ptr(), palette.as_mut_ptr().cast(), palette.len());
        let call = |curves: *const f32, curves_len: usize| {
            let (e, from, len) = (envelope.handle, matrices(&pose), pose.len());
            let mut error = unwritten();
            let (s_len, none, out_error) = (info.scratch_len, null_mut(), &raw mut error);
            // SAFETY: an open envelope and arrays with their lengths; the call refuses the curves.
            let status = unsafe {
                sinew_envelope_palette(
                    e, from, len, curves, curves_len, at, s_len, out, out_len, none, out_error,
                )
            };
            (status, error.argument, error.expected, error.found)
        };
        let (len, curves) = (info.curve_len, sinew_argument::Curves);
        let free = at.wrapping_add(info.scratch_len);
        assert_eq!(call(free, len + 1), (sinew_status::Length, curves, len, len + 1));
        assert_eq!(call(null(), len + 1), (sinew_status::Null, curves, 0, 0));
        assert_eq!(call(at, len + 1), (sinew_status::Overlap, sinew_argument::Scratch, 0, 0));
        assert!(palette.iter().all(|transform| *transform == [[0.0; 4]; 3]));
    });
}

#[test]
fn wrong_calls_for_attributes_are_refused() {
    use sinew_argument as Argument;
    use sinew_attribute as A;
    use sinew_status as Status;
    let file = Pieces::small(Predictor::Kernel).bytes();
    with(&file, |Both { model, c: (_, skin), rust: (_, mesh) }| {
        let v = mesh.vertex_len();
        let pair_len = mesh.influence_len() - 1;
        let mut out = vec![7.0f32; 8 * v];
        let at = out.as_mut_ptr();
        let call = |from: *const sinew_skin, number, start, end, at: *mut f32, len| {
            let mut error = unwritten();
            let out_error = &raw mut error;
            // SAFETY: an open skin or null, and an array with its length, which the call refuses.
            let status =
                unsafe { sinew_skin_attribute(from, number, start, end, at, len, out_error) };
            (status, error)
        };
        let refused =
            |(status, error): (_, sinew_error), argument, [expected, found]: [usize; 2]| {
                assert_eq!((error.status, error.argument), (status, argument));
                assert_eq!([error.expected, error.found], [expected, found]);
                status
            };
        for number in [0, 5, u32::MAX] {
            let found = call(skin.handle, number, 0, v, at, 8 * v);
            let status = refused(found, Argument::Attribute, [4, number as usize]);
            assert_eq!(status, Status::OutOfRange);
        }
        for (attribute, argument, float_len) in [
            (A::Position, Argument::Positions, 3),
            (A::Normal, Argument::Normals, 3),
            (A::Tangent, Argument::Tangents, 4),
            (A::TangentCoefficients, Argument::Coefficients, 2 * pair_len),
        ] {
            let len = float_len * v;
            let call =
                |from, start, end, at, len| call(from, attribute as u32, start, end, at, len);
            let with = |at, len| call(skin.handle, 0, v, at, len);
            let short = refused(with(at, len - 1), argument, [len, len - 1]);
            assert_eq!(short, Status::TooShort);
            for (start, end) in [(0, v + 1), (3, 2), (usize::MAX, usize::MAX), (usize::MAX, 0)] {
                let found = call(skin.handle, start, end, at, len);
                assert_eq!(found.1.index, start);
                assert_eq!(refused(found, Argument::Vertices, [v, end]), Status::OutOfRange);
            }
            assert_eq!(refused(with(null_mut(), len), argument, [0, 0]), Status::Null);
            let found = call(null(), 0, v, at, len);
            assert_eq!(refused(found, Argument::Skin, [0, 0]), Status::Null);
            let odd = with(at.wrapping_byte_add(2), len);
            assert_eq!(refused(odd, argument, [4, odd.1.found]), Status::Misaligned);
            let many = isize::MAX as usize / 4 + 1;
            assert_eq!(refused(with(at, many), argument, [0, many]), Status::TooLong);
            let file_at = file.as_ptr().wrapping_add(file.as_ptr().align_offset(4));
            let reads: [*const f32; 3] = [skin.handle.cast(), model.handle.cast(), file_at.cast()];
            for read in reads {
                let found = with(read.cast_mut(), len);
                assert_eq!(refused(found, argument, [0, 0]), Status::Overlap);
            }
        }
        assert!(out.iter().all(|float| *float == 7.0));
    });
}

#[test]
fn a_missing_attribute_is_refused() {
    let bare = Shape { tangents: false, coefficients: false, ..SMALL };
    with(&Pieces::sample(Predictor::Kernel, bare).bytes(), |Both { c: (_, skin), .. }| {
        let error = |attribute| skin.attribute(attribute, 0..1).unwrap_err();
        for (attribute, argument) in [
            (sinew_attribute::Tangent, sinew_argument::Tangents),
            (sinew_attribute::TangentCoefficients, sinew_argument::Coefficients),
        ] {
            let error = error(attribute);
            let expected = (sinew_status::NoAttribute, argument);
            assert_eq!((error.status, error.argument), expected);
        }
        let found = text(&error(sinew_attribute::TangentCoefficients), 100).0;
        assert_eq!(found, "tangent coefficients: the part has no such attribute");
    });
}

/// Each output is compared with all memory that the job reads, and with no other memory.
#[test]
fn an_output_over_an_input_is_refused() {
    let file = Pieces::small(Predictor::Rotational).bytes();
    with(&file, |Both { model, c: (envelope, skin), .. }| {
        let v = skin.info().vertex_len;
        let pose = vec![common::IDENTITY; envelope.info().joint_len];
        let (mut palette, _) = envelope.palette(&pose);
        let mut rest = vec![[0.0f32; 4]; 3 * v];
        let (mut remap, mut out) = (vec![0u32; v], vec![f32::NAN; 4 * v]);
        let place = palette.as_mut_ptr();
        // SAFETY: the palette, through the pointer that outputs are derived from.
        let transforms: &[Matrix3x4] = unsafe { std::slice::from_raw_parts(place, palette.len()) };
        let mut job = skin.job(transforms, 0..v);
        let [positions, normals, tangents] =
            [0, 1, 2].map(|i| rest.as_mut_ptr().wrapping_add(i * v).cast::<f32>());
        (job.rest_positions, job.rest_normals, job.rest_tangents) = (positions, normals, tangents);
        (job.rest_len, job.remap, job.remap_len) = (v, remap.as_mut_ptr(), v);
        let mut room = job;
        let (job_at, file_at) = (&raw mut room, file.as_ptr());
        let reads = [
            place.cast::<f32>(),
            positions,
            normals,
            tangents,
            job.remap.cast_mut().cast(),
            job.skin.cast_mut().cast(),
            model.handle.cast_mut().cast(),
            job_at.cast(),
            file_at.wrapping_add(file_at.align_offset(4)).cast_mut().cast(),
        ];
        let with = |number: usize, output| {
            let mut job = job;
            let outputs = [&mut job.positions, &mut job.normals, &mut job.tangents];
            *outputs.into_iter().nth(number).unwrap() = output;
            job
        };
        let arguments =
            [sinew_argument::Positions, sinew_argument::Normals, sinew_argument::Tangents];
        let run = |wanted: sinew_skin_job| {
            let mut error = unwritten();
            // SAFETY: memory for a job; each pointer of the job comes with its length.
            let status = unsafe {
                job_at.write(wanted);
                sinew_skin_run(job_at, &raw mut error)
            };
            (status, error.argument)
        };
        for (number, argument) in arguments.into_iter().enumerate() {
            assert_eq!(run(with(number, output(&mut out, 4))).0, sinew_status::Ok);
            for floats in reads {
                let over = sinew_output { floats, len: 4, stride: 4 };
                let unsound = sinew_skin_job { end: 1, ..with(number, over) };
                assert_eq!(run(unsound), (sinew_status::Overlap, argument));
            }
        }
        // Scratch overlaps neither memory that the job reads nor an output.
        let job = with(0, output(&mut out, 4));
        let scratched = |scratch, scratch_len| run(sinew_skin_job { scratch, scratch_len, ..job });
        let len = skin.info().scratch_len;
        for scratch in reads {
            assert_eq!(scratched(scratch, len), (sinew_status::Overlap, sinew_argument::Scratch));
        }
        let refused = scratched(job.positions.floats, len);
        assert_eq!(refused, (sinew_status::Overlap, sinew_argument::Positions));
        assert_eq!(scratched(null_mut(), len), (sinew_status::Null, sinew_argument::Scratch));
        let mut scratch = vec![0.0; len];
        for short in [0, len - 1] {
            let refused = scratched(scratch.as_mut_ptr(), short);
            assert_eq!(refused, (sinew_status::TooShort, sinew_argument::Scratch));
        }
        assert_eq!(scratched(scratch.as_mut_ptr(), len).0, sinew_status::Ok);
    });
}

/// Every kind; `header.rs` compares the number of the header's statuses with them.
const CALL_KINDS: [CallErrorKind; 13] = {
    use CallErrorKind::*;
    [
        Length,
        TooShort,
        NonFinite,
        ZeroRotation,
        OutOfRange,
        Stride,
        NoAttribute,
        NoStage,
        NoOutput,
        NoRoot,
        OtherName,
        NoJoints,
        NoCurve,
    ]
};
const FILE_KINDS: [FileErrorKind; 21] = {
    use FileErrorKind::*;
    [
        NotAModel,
        Version,
        Malformed,
        Checksum,
        Limit,
        Unsupported,
        PartIndex,
        Alignment,
        Overlap,
        Bounds,
        Duplicate,
        Missing,
        Unexpected,
        Length,
        Empty,
        Float,
        Index,
        Mismatch,
        Invalid,
        Truncated,
        Space,
    ]
};

fn name(value: impl Debug) -> String {
    format!("{value:?}")
}

#[test]
fn kinds_and_arguments_keep_their_names_and_order() {
    for (kind, number) in CALL_KINDS.into_iter().zip(1..) {
        let status = sinew_status::from(kind);
        assert_eq!((name(status), status as i32), (name(kind), number));
    }
    for (kind, number) in FILE_KINDS.into_iter().zip(100..) {
        let status = sinew_status::from(kind);
        assert_eq!((name(status), status as i32), (format!("File{kind:?}"), number));
    }
    for argument in Argument::ALL {
        let same = sinew_argument::from(argument);
        assert_eq!(same as u32, argument as u32);
        assert!(name(same).ends_with(&name(argument)), "{same:?} {argument:?}");
        let found = text(&error(sinew_status::Null, same), 100).0;
        assert_eq!(found, format!("{}: a pointer is null", argument.name()));
    }
}

#[test]
fn errors_keep_every_field() {
    let (argument, kind) = (Argument::Remap, CallErrorKind::OutOfRange);
    let (index, expected, found) = (6, usize::MAX, 8);
    assert_eq!(
        sinew_error::from(CallError { kind, argument, index, expected, found }),
        sinew_error {
            status: sinew_status::OutOfRange,
            argument: sinew_argument::Remap,
            part: SINEW_NO_PART,
            section: 0,
            index,
            expected,
            found,
        }
    );
    let (kind, section) = (FileErrorKind::Index, Some(SectionKind::C1));
    let error = FileError { kind, part: Some(3), section, index: 6, expected: 7, found: u32::MAX };
    let in_c = sinew_error {
        status: sinew_status::FileIndex,
        argument: sinew_argument::File,
        part: 3,
        section: 10,
        index: 6,
        expected: 7,
        found: u32::MAX as usize,
    };
    assert_eq!(sinew_error::from(error), in_c);
    assert_eq!(
        sinew_error::from(FileError { part: None, section: None, ..error }),
        sinew_error { part: SINEW_NO_PART, section: 0, ..in_c }
    );
}

fn error(status: sinew_status, argument: sinew_argument) -> sinew_error {
    let part = SINEW_NO_PART;
    sinew_error { status, argument, part, section: 0, index: 7, expected: 53, found: 12 }
}

/// Returns the text of an error, in memory of `len` bytes, and the length of the whole text.
fn text(error: &sinew_error, len: usize) -> (String, usize) {
    let mut out = vec![b'x'; len + 1];
    // SAFETY: an error, and memory with its length.
    let whole = unsafe { sinew_error_text(error, out.as_mut_ptr().cast(), len) };
    assert_eq!(out[len], b'x', "written behind the memory");
    let end = out.iter().position(|byte| *byte == 0).unwrap_or(0);
    (String::from_utf8(out[..end].to_vec()).unwrap(), whole)
}

#[test]
fn an_error_becomes_a_text_with_the_fields_of_its_status() {
    let length = error(sinew_status::Length, sinew_argument::Pose);
    let expected = "pose: an array has the wrong length, expected 53, found 12";
    assert_eq!(text(&length, 100), (expected.to_owned(), expected.len()));
    assert_eq!(text(&length, 5), ("pose".to_owned(), expected.len()));
    assert_eq!(text(&length, 1), (String::new(), expected.len()));
    assert_eq!(text(&length, 0), (String::new(), expected.len()));
    let file =
        sinew_error { part: 1, section: 4, ..error(sinew_status::FileFloat, sinew_argument::File) };
    assert_eq!(text(&file, 100).0, "file: a float is out of range, part 1, section 4, index 7");
    let missing = error(sinew_status::Null, sinew_argument::Job);
    assert_eq!(text(&missing, 100).0, "job: a pointer is null");
    let mut out = [b'x'];
    // SAFETY: no error, and memory with its length, or none.
    let lens = unsafe {
        [
            sinew_error_text(null(), out.as_mut_ptr().cast(), 1),
            sinew_error_text(&length, null_mut(), 100),
        ]
    };
    assert_eq!((lens, out), ([0, expected.len()], [0]));
}
