//! The functions, called in this process: they give what the runtime gives.
#![allow(clippy::unwrap_used, reason = "a test's helpers fail as the test does")]

#[path = "../../tests/common/mod.rs"]
mod builder;
mod handles;

use builder::{Builder, SMALL, Shape, random_pose};
use handles::{Loaded, NONE, done, get, matrices, name, output};
use sinew_capi::*;
use sinew_runtime::envelope::Predictor;
use sinew_runtime::format::{Axis, Handedness, Space};
use sinew_runtime::skin::Rest;
use sinew_runtime::{Envelope, Matrix3x4, Model, Skin, SkinJob};
use std::ptr::{null, null_mut};
use std::sync::LazyLock;

const BARE: Shape = Shape { tangents: false, ..SMALL };
const EMPTY: Shape = Shape { vertices: 0, ..SMALL };

/// The first envelope and the first skin of a file, through C and as the runtime has them.
struct Both<'a> {
    model: Loaded,
    c: (handles::Envelope, handles::Skin),
    rust: (Envelope<'a>, Skin<'a>),
}

/// Runs a test on a model of every predictor, with and without tangents. They are made once: under
/// Miri that takes seconds.
fn each(test: impl Fn(Both<'_>)) {
    static FILES: LazyLock<Vec<Vec<u8>>> = LazyLock::new(|| {
        let each = Predictor::ALL.into_iter().flat_map(|each| [SMALL, BARE].map(|s| (each, s)));
        each.map(|(predictor, shape)| Builder::of(predictor, shape).bytes()).collect()
    });
    FILES.iter().for_each(|file| with(file, &test));
}

fn with(file: &[u8], test: impl Fn(Both<'_>)) {
    let model = Loaded::new(file);
    let c = (model.envelope(None, 0).unwrap(), model.skin(None, 0).unwrap());
    let rust = Model::from_bytes(file).unwrap();
    test(Both { model, c, rust: (rust.envelope().unwrap(), rust.skin().unwrap()) });
}

#[test]
fn it_says_what_it_is() {
    assert_eq!(sinew_abi_version(), SINEW_ABI_VERSION);
    assert_eq!(sinew_format_version(), u32::from(sinew_runtime::format::VERSION));
    assert!(sinew_model_bytes() <= SINEW_MODEL_WORDS * size_of::<usize>());
    assert!(sinew_envelope_bytes() <= SINEW_ENVELOPE_WORDS * size_of::<usize>());
    assert!(sinew_skin_bytes() <= SINEW_SKIN_WORDS * size_of::<usize>());
    // SAFETY: a text of the library, ended by a zero.
    let version = unsafe { std::ffi::CStr::from_ptr(sinew_version()) };
    assert_eq!(version.to_str(), Ok(env!("CARGO_PKG_VERSION")));
}

#[test]
fn default_limits_are_the_runtimes() {
    // SAFETY: one structure to be written.
    let found = get(|out| unsafe { sinew_limits_default(out, NONE) });
    let expected = sinew_runtime::Limits::DEFAULT;
    assert_eq!(sinew_runtime::Limits::from(&found), expected);
    assert_eq!((found.parts, found.sections), (expected.parts, expected.sections));
}

#[test]
fn a_model_says_what_it_holds_and_in_which_space() {
    let describe = |builder: &Builder| {
        let file = builder.bytes();
        let model = Loaded::new(&file);
        // SAFETY: a loaded model and one structure to be written.
        get(|out| unsafe { sinew_model_describe(model.handle, out, NONE) })
    };
    let mut builder = Builder::several();
    let found = describe(&builder);
    assert_eq!((found.part_len, found.envelope_len, found.skin_len), (5, 2, 3));
    for (number, up) in Axis::ALL.into_iter().enumerate() {
        let forward = Axis::ALL.into_iter().find(|axis| !axis.is_along(up));
        let (up, handedness) = (Some(up), [Handedness::Right, Handedness::Left][number % 2]);
        let unit = [None, Some(0.01)][number % 2];
        builder.space = Space { up, forward, handedness, unit }.to_bytes();
        let found = describe(&builder);
        let in_file = |axis: Option<Axis>| axis.map_or(0, |axis| u32::from(axis.number()));
        assert_eq!([found.up as u32, found.forward as u32], [in_file(up), in_file(forward)]);
        assert_eq!(found.handedness as u32, handedness as u32);
        assert_eq!(found.unit, unit.unwrap_or(0.0));
    }
    builder.space = Space::default().to_bytes();
    let found = describe(&builder);
    assert_eq!([found.up, found.forward], [sinew_axis::Unknown; 2]);
}

#[test]
fn parts_are_opened_by_name_and_number() {
    let file = Builder::several().bytes();
    let (model, expected) = (Loaded::new(&file), Model::from_bytes(&*file).unwrap());
    for (index, envelope) in expected.envelopes().enumerate() {
        let info = model.envelope(None, index).unwrap().info();
        assert_eq!(info.part as usize, envelope.part());
        // Both have one name.
        let named = model.envelope(Some(envelope.name()), index).unwrap().info();
        assert_eq!(named.part as usize, envelope.part());
    }
    for (index, skin) in expected.skins().enumerate() {
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
        assert_eq!(info.proxy_len, envelope.proxy_len());
        assert_eq!(info.palette_len, envelope.palette_len());
        assert_eq!(info.scratch_len, envelope.scratch_len());
        assert_eq!(info.root as usize, envelope.root());
        let (found, expected) = (info.certificate, envelope.certificate());
        assert_eq!(found.diagonal, expected.diagonal);
        assert_eq!(found.training_rms, expected.training_rms);
        assert_eq!(found.cross_validated_rms, expected.cross_validated_rms);
        assert_eq!(found.lbs_training_rms, expected.lbs_training_rms);
        assert_eq!(found.correction_error, expected.correction_error);
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
            assert_eq!(Some(found.inverse_bind.rows), envelope.inverse_bind(joint));
        }
        let mut order = vec![0; envelope.joint_len()];
        let (at, len) = (order.as_mut_ptr(), order.len());
        // SAFETY: an open envelope and an array with its length.
        done(unsafe { sinew_envelope_order(found.handle, at, len, NONE) });
        let order = order.into_iter().map(|joint| joint as usize).collect::<Vec<_>>();
        assert_eq!(order, envelope.evaluation_order().collect::<Vec<_>>());
    });
}

#[test]
fn the_mesh_is_that_of_the_file() {
    each(|Both { c: (_, found), rust: (_, skin), .. }| {
        let (v, s) = (skin.vertex_len(), found.handle);
        for vertices in [0..v, 2..v - 1] {
            let (start, end) = (vertices.start, vertices.end);
            let n = vertices.len();
            let mut out = vec![0.0; 3 * n];
            let at = out.as_mut_ptr();
            // SAFETY: an open skin and an array with its length.
            done(unsafe { sinew_skin_rest_positions(s, start, end, at, 3 * n, NONE) });
            let rest = vertices.clone().flat_map(|v| skin.rest_position(v).unwrap());
            assert_eq!(out, rest.collect::<Vec<_>>());
            let at = out.as_mut_ptr();
            // SAFETY: the same.
            done(unsafe { sinew_skin_rest_normals(s, start, end, at, 3 * n, NONE) });
            let rest = vertices.clone().flat_map(|v| skin.rest_normal(v).unwrap());
            assert_eq!(out, rest.collect::<Vec<_>>());
            let mut out = vec![0.0; 4 * n];
            let at = out.as_mut_ptr();
            // SAFETY: the same.
            let status = unsafe { sinew_skin_rest_tangents(s, start, end, at, 4 * n, NONE) };
            if skin.has_tangents() {
                let rest = vertices.clone().flat_map(|v| skin.rest_tangent(v).unwrap());
                assert_eq!(out, rest.collect::<Vec<_>>());
            } else {
                assert_eq!(status, sinew_status::NoAttribute);
            }
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
    let file = Builder::several().bytes();
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

#[test]
fn evaluation_has_the_bits_of_the_runtime() {
    each(|Both { c: (found, found_skin), rust: (envelope, skin), .. }| {
        let mut random = builder::Rng(3);
        let (mut poses, mut palettes, mut confidences) = (Vec::new(), Vec::new(), Vec::new());
        for turn in [0.05, 0.5, 4.0] {
            let local = (0..envelope.joint_len()).map(|_| random.local(turn)).collect::<Vec<_>>();
            let mut pose = vec![builder::IDENTITY; envelope.joint_len()];
            sinew_runtime::model_space_pose(&envelope, &local, &mut pose).unwrap();
            assert_eq!(found.pose(&local), pose);
            let (palette, confidence) = builder::confident_palette(&envelope, &pose);
            assert_eq!(found.palette(&pose), (palette.clone(), confidence));
            if envelope.predictor() == Predictor::Rotational {
                let by_its_own = found.palette_by(sinew_envelope_rotational_palette, &pose);
                assert_eq!(by_its_own, (palette.clone(), confidence));
            }
            for rest_offset in [0.0, 0.25] {
                let bounds = skin.bounds(&palette, rest_offset).unwrap().unwrap();
                let found = found_skin.bounds(&palette, rest_offset);
                assert_eq!((found.min, found.max), (bounds.min, bounds.max));
            }
            let expected = builder::skinned(skin, &palette);
            let all = found_skin.job(&palette, 0..skin.vertex_len());
            assert_eq!(found_skin.run(all), expected);
            poses.extend(pose);
            palettes.extend(palette);
            confidences.push(confidence);
        }
        assert_eq!(found.palettes(&poses, confidences.len()), (palettes, confidences));
        assert_eq!(found.palettes(&[], 0), (Vec::new(), Vec::new()));
    });
}

#[test]
fn a_job_takes_a_remap_and_a_rest_mesh() {
    each(|Both { c: (_, found), rust: (envelope, skin), .. }| {
        let mut random = builder::Rng(11);
        let pose = random_pose(&envelope, &mut random, 0.3);
        let palette = builder::palette(&envelope, &pose);
        let v = skin.vertex_len();
        let positions = (0..v).map(|_| builder::direction(&mut random)).collect::<Vec<_>>();
        let normals = (0..v).map(|_| builder::direction(&mut random)).collect::<Vec<_>>();
        let tangents = normals.iter().map(|[x, y, z]| [*y, *z, *x, -1.0]).collect::<Vec<_>>();
        let remap = (0..2 * v as u32).map(|i| i * 5 % v as u32).collect::<Vec<_>>();
        let mut given =
            SkinJob { vertices: 3..2 * v - 1, remap: Some(&remap), ..builder::job(skin, &palette) };
        let mut in_c = found.job(&palette, given.vertices.clone());
        (in_c.remap, in_c.remap_len) = (remap.as_ptr(), remap.len());
        assert_eq!(found.run(in_c), builder::run(&given));
        given.rest.positions = Some(&positions);
        in_c.rest_positions = positions.as_flattened().as_ptr();
        in_c.rest_len = v;
        assert_eq!(found.run(in_c), builder::run(&given));
        if skin.has_tangents() {
            let (positions, normals) = (Some(&*positions), Some(&*normals));
            given.rest = Rest { positions, normals, tangents: Some(&tangents) };
            in_c.rest_normals = normals.unwrap().as_flattened().as_ptr();
            in_c.rest_tangents = tangents.as_flattened().as_ptr();
            assert_eq!(found.run(in_c), builder::run(&given));
        }
    });
}

/// Outputs of one job may share their floats in every way: here as one vertex after the other, and the
/// tangents' handedness over the next vertex's first float, which is written later.
#[test]
fn a_vertex_may_be_interleaved_and_outputs_may_overlap() {
    with(&Builder::of(Predictor::Hybrid, SMALL).bytes(), |Both { c, rust, .. }| {
        let ((envelope, found), v) = (c, rust.1.vertex_len());
        let pose = random_pose(&rust.0, &mut builder::Rng(5), 0.3);
        let (palette, _) = envelope.palette(&pose);
        let apart = found.run(found.job(&palette, 0..v));
        for stride in [9, 10, 13] {
            let mut vertices = vec![f32::NAN; stride * v + 3];
            let (at, len) = (vertices.as_mut_ptr(), vertices.len());
            let shared = |first: usize| sinew_output {
                floats: at.wrapping_add(first),
                len: len - first,
                stride,
            };
            let mut job = found.job(&palette, 0..v);
            (job.positions, job.normals, job.tangents) = (shared(0), shared(3), shared(6));
            // SAFETY: three outputs within one buffer; no other reference to it is used.
            done(unsafe { sinew_skin_run(&raw const job, NONE) });
            for vertex in 0..v {
                let of = |from: usize, n: usize| &apart[from * v + n * vertex..][..n];
                let found = &vertices[stride * vertex..];
                // With a stride of 9 the next vertex's position stands where the handedness was.
                let kept = if stride == 9 && vertex + 1 < v { 3 } else { 4 };
                assert_eq!(found[..3], *of(0, 3));
                assert_eq!(found[3..6], *of(3, 3));
                assert_eq!(found[6..6 + kept], of(6, 4)[..kept]);
                if stride > 10 {
                    assert!(found[10..stride].iter().all(|x| x.is_nan()), "a gap was written");
                }
            }
        }
        // One place for all three: the later field wins.
        let mut one = vec![f32::NAN; 4 * v];
        let mut job = found.job(&palette, 0..v);
        job.positions = output(&mut one, 4);
        (job.normals, job.tangents) = (job.positions, job.positions);
        // SAFETY: three outputs that are one buffer.
        done(unsafe { sinew_skin_run(&raw const job, NONE) });
        assert_eq!(one, apart[6 * v..]);
    });
}

#[test]
fn a_skin_without_an_envelope_stays_at_rest() {
    let file = Builder::loose(SMALL).bytes();
    let (model, expected) = (Loaded::new(&file), Model::from_bytes(&*file).unwrap());
    assert_eq!(model.envelope(None, 0).err(), Some(sinew_status::NotFound));
    let (found, skin) = (model.skin(None, 0).unwrap(), expected.skin().unwrap());
    let info = found.info();
    assert_eq!((info.envelope_part, info.palette_len, info.influence_len), (SINEW_NO_PART, 0, 0));
    let at_rest = found.run(found.job(&[], 0..info.vertex_len));
    assert_eq!(at_rest, builder::skinned(skin, &[]));
    assert_eq!(at_rest[..3 * info.vertex_len], builder::rest(skin)[..3 * info.vertex_len]);
    let bounds = skin.bounds(&[], 0.0).unwrap().unwrap();
    let found = found.bounds(&[], 0.0);
    assert_eq!((found.min, found.max), (bounds.min, bounds.max));
}

#[test]
fn threads_share_models_and_skin_ranges_at_once() {
    with(
        &Builder::of(Predictor::Hybrid, SMALL).bytes(),
        |Both { c: (envelope, skin), rust, .. }| {
            let pose = random_pose(&rust.0, &mut builder::Rng(5), 0.3);
            let (palette, _) = envelope.palette(&pose);
            let v = rust.1.vertex_len();
            let whole = skin.run(skin.job(&palette, 0..v));
            let halves = std::thread::scope(|scope| {
                let (palette, skin) = (&palette, &skin);
                let run = |range| scope.spawn(move || skin.run(skin.job(palette, range)));
                [run(0..3), run(3..v)].map(|half| half.join().unwrap())
            });
            let positions = [&halves[0][..9], &halves[1][..3 * (v - 3)]].concat();
            assert_eq!(positions, whole[..3 * v]);
        },
    );
}

#[test]
fn parts_can_be_moved_and_files_lie_anywhere() {
    let file = Builder::of(Predictor::Kernel, SMALL).bytes();
    let mut shifted = vec![0; file.len() + 1];
    shifted[1..].copy_from_slice(&file);
    with(&shifted[1..], |Both { c: (envelope, skin), rust, .. }| {
        let pose = random_pose(&rust.0, &mut builder::Rng(5), 0.3);
        let palette = envelope.palette(&pose);
        assert_eq!(envelope.moved().palette(&pose), palette);
        let (palette, moved) = (&palette.0, skin.moved());
        let all = 0..rust.1.vertex_len();
        assert_eq!(moved.run(moved.job(palette, all.clone())), skin.run(skin.job(palette, all)));
    });
}

/// What was opened of a file is refused once its model holds another, and nothing of the file that is
/// gone is read: under Miri that would be an error.
#[test]
fn a_stale_part_is_refused() {
    let file = Builder::small(Predictor::Hybrid).bytes();
    let mut model = Loaded::new(&file);
    let (envelope, skin) = (model.envelope(None, 0).unwrap(), model.skin(None, 0).unwrap());
    let (info, mesh) = (envelope.info(), skin.info());
    let pose = vec![builder::IDENTITY; info.joint_len];
    let (palette, _) = envelope.palette(&pose);
    let mut positions = vec![f32::NAN; 3 * mesh.vertex_len];
    let mut job = skin.job(&palette, 0..mesh.vertex_len);
    job.positions = output(&mut positions, 3);
    let refused = || {
        let mut error = sinew_error::from(builder::file_error(sinew_runtime::FileErrorKind::Index));
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

    let other = Builder::small(Predictor::Rotational).bytes();
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
    let anew = Builder::small(Predictor::Hybrid).bytes();
    done(model.load(&anew));
    assert_eq!(envelope.palette(&pose).0, palette);
}

#[test]
fn a_mesh_without_vertices_has_no_bounds() {
    with(
        &Builder::of(Predictor::Rotational, EMPTY).bytes(),
        |Both { c: (envelope, skin), .. }| {
            let pose = vec![builder::IDENTITY; envelope.info().joint_len];
            let (palette, _) = envelope.palette(&pose);
            let mut bounds = sinew_bounds { min: [7.0; 3], max: [7.0; 3] };
            let (at, len, out) = (matrices(&palette), palette.len(), &raw mut bounds);
            // SAFETY: an open skin, an array with its length, a structure to be written.
            let status = unsafe { sinew_skin_bounds(skin.handle, at, len, 0.0, out, NONE) };
            assert_eq!(status, sinew_status::NoVertices);
            assert_eq!(bounds, sinew_bounds { min: [7.0; 3], max: [7.0; 3] });
            // Outputs of no length are outputs; without any there is nothing to do.
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
    with(&Builder::of(Predictor::Rotational, SMALL).bytes(), |Both { model, c, rust }| {
        let untouched = builder::file_error(sinew_runtime::FileErrorKind::Index);
        let mut error = sinew_error::from(untouched);
        let plain = sinew_error {
            status: sinew_status::TooShort,
            argument: sinew_argument::Order,
            part: SINEW_NO_PART,
            section: 0,
            index: 0,
            expected: rust.0.joint_len(),
            found: 0,
        };
        // SAFETY: an open envelope; the array is null.
        let status = unsafe { sinew_envelope_order(c.0.handle, null_mut(), 0, &raw mut error) };
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
        // A limit names the count of its section.
        // SAFETY: one structure to be written.
        let mut limits = get(|out| unsafe { sinew_limits_default(out, NONE) });
        limits.vertices = 1;
        let file = Builder::small(Predictor::Rotational).bytes();
        let mut place = handles::memory(SINEW_MODEL_WORDS);
        let (at, bytes, mut out) = (place.as_mut_ptr().cast(), size_of_val(&*place), null());
        let (file, len, limits) = (file.as_ptr(), file.len(), &raw const limits);
        let (out, told) = (&raw mut out, &raw mut error);
        // SAFETY: memory and a file with their lengths, limits, and two values to be written.
        let status = unsafe { sinew_model_load(at, bytes, file, len, limits, out, told) };
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

/// Each output is compared with all that is read, and with nothing else.
#[test]
fn an_output_over_an_input_is_refused() {
    let file = Builder::small(Predictor::Rotational).bytes();
    with(&file, |Both { model, c: (envelope, skin), .. }| {
        let v = skin.info().vertex_len;
        let pose = vec![builder::IDENTITY; envelope.info().joint_len];
        let (mut palette, _) = envelope.palette(&pose);
        let mut rest = vec![[0.0f32; 4]; 3 * v];
        let (mut remap, mut out) = (vec![0u32; v], vec![f32::NAN; 4 * v]);
        let place = palette.as_mut_ptr();
        // SAFETY: the palette, by the pointer that outputs are drawn from too.
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
            let mut error =
                sinew_error::from(builder::file_error(sinew_runtime::FileErrorKind::Index));
            // SAFETY: the job's own memory; every pointer of it comes with its length.
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
    });
}
