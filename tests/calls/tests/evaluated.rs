//! Poses, palettes and skins have the runtime's bits.

use crate::common::random_pose;
use crate::handles::{Loaded, NONE, done, name};
use crate::{Both, common, each, with};
use models::{Pieces, Rng, SMALL, cells, direction};
use sinew_capi::*;
use sinew_runtime::envelope::Predictor;
use sinew_runtime::skin::Output;
use sinew_runtime::{Model, ShapesJob, Skin, SkinJob};

#[test]
fn evaluation_has_the_bits_of_the_runtime() {
    each(|Both { c: (found, found_skin), rust: (envelope, skin), .. }| {
        let mut random = Rng(3);
        let (mut poses, mut palettes, mut confidences) = (Vec::new(), Vec::new(), Vec::new());
        let mut all_curves = Vec::new();
        for turn in [0.05, 0.5, 4.0] {
            let local = (0..envelope.joint_len()).map(|_| random.local(turn)).collect::<Vec<_>>();
            let mut pose = vec![common::IDENTITY; envelope.joint_len()];
            sinew_runtime::model_space_pose(&envelope, &local, &mut pose).unwrap();
            assert_eq!(found.pose(&local), pose);
            let curves = (0..envelope.curve_len()).map(|_| random.unit()).collect::<Vec<_>>();
            let mut scratch = vec![f32::NAN; envelope.scratch_len()];
            let mut palette = vec![[[f32::NAN; 4]; 3]; envelope.palette_len()];
            let confidence = envelope.palette(&pose, &curves, &mut scratch, &mut palette).unwrap();
            assert_eq!(found.curved_palette(&pose, &curves), (palette.clone(), confidence));
            if envelope.predictor() == Predictor::Rotational {
                assert_eq!(found.rotational_palette(&pose), (palette.clone(), confidence));
            }
            for rest_offset in [0.0, 0.25] {
                let bounds = skin.bounds(&palette, rest_offset).unwrap().unwrap();
                let found = found_skin.bounds(&palette, rest_offset);
                assert_eq!((found.min, found.max), (bounds.min, bounds.max));
            }
            let expected = common::skinned(skin, &palette);
            let all = found_skin.job(&palette, 0..skin.vertex_len());
            assert_eq!(found_skin.run(all), expected);
            poses.extend(pose);
            all_curves.extend(curves);
            palettes.extend(palette);
            confidences.push(confidence);
        }
        let together = found.palettes(&poses, &all_curves, confidences.len());
        assert_eq!(together, (palettes, confidences));
        assert_eq!(found.palettes(&[], &[], 0), (Vec::new(), Vec::new()));
    });
}

#[test]
fn a_job_takes_a_remap_and_a_rest_mesh() {
    each(|Both { c: (_, found), rust: (envelope, skin), .. }| {
        let mut random = Rng(11);
        let pose = random_pose(&envelope, &mut random, 0.3);
        let palette = common::palette(&envelope, &pose);
        let v = skin.vertex_len();
        let positions = (0..v).map(|_| direction(&mut random)).collect::<Vec<_>>();
        let normals = (0..v).map(|_| direction(&mut random)).collect::<Vec<_>>();
        let tangents = normals.iter().map(|[x, y, z]| [*y, *z, *x, -1.0]).collect::<Vec<_>>();
        let remap = (0..2 * v as u32).map(|i| i * 5 % v as u32).collect::<Vec<_>>();
        let given = SkinJob::new(skin, &palette).vertices(3..2 * v - 1).remap(&remap);
        let mut in_c = found.job(&palette, given.range());
        (in_c.remap, in_c.remap_len) = (remap.as_ptr(), remap.len());
        assert_eq!(found.run(in_c), common::run(&given));
        let given = given.rest_positions(&positions);
        in_c.rest_positions = positions.as_flattened().as_ptr();
        in_c.rest_len = v;
        assert_eq!(found.run(in_c), common::run(&given));
        if skin.has_tangents() {
            let given = given.rest_normals(&normals).rest_tangents(&tangents);
            in_c.rest_normals = normals.as_flattened().as_ptr();
            in_c.rest_tangents = tangents.as_flattened().as_ptr();
            assert_eq!(found.run(in_c), common::run(&given));
        }
    });
}

/// Outputs of one job may share a buffer, but no float: with a stride of 9 a tangent's handedness has the place of the
/// next vertex's first float.
#[test]
fn a_vertex_may_be_interleaved_and_outputs_may_not_overlap() {
    with(&Pieces::sample(Predictor::Kernel, SMALL).bytes(), |Both { c, rust, .. }| {
        let ((envelope, found), v) = (c, rust.1.vertex_len());
        let pose = random_pose(&rust.0, &mut Rng(5), 0.3);
        let (palette, _) = envelope.palette(&pose);
        let apart = found.run(found.job(&palette, 0..v));
        for stride in [4, 9, 10, 13] {
            let mut vertices = vec![f32::NAN; stride * v + 9];
            let (at, len) = (vertices.as_mut_ptr(), vertices.len());
            let shared = |first: usize| sinew_output {
                floats: at.wrapping_add(first),
                len: len - first,
                stride,
            };
            let mut job = found.job(&palette, 0..v);
            (job.positions, job.normals, job.tangents) = (shared(0), shared(3), shared(6));
            // SAFETY: three outputs within one buffer; no other reference to it is used.
            let status = unsafe { sinew_skin_run(&raw const job, NONE) };
            if stride < 10 {
                assert_eq!(status, sinew_status::Overlap);
                assert!(vertices.iter().all(|x| x.is_nan()), "a refused job wrote");
                continue;
            }
            assert_eq!(status, sinew_status::Ok);
            for vertex in 0..v {
                let of = |from: usize, n: usize| &apart[from * v + n * vertex..][..n];
                let found = &vertices[stride * vertex..];
                assert_eq!(found[..3], *of(0, 3));
                assert_eq!(found[3..6], *of(3, 3));
                assert_eq!(found[6..10], *of(6, 4));
                assert!(found[10..stride].iter().all(|x| x.is_nan()), "a gap was written");
            }
        }
    });
}

#[test]
fn a_skin_without_an_envelope_stays_at_rest() {
    let file = Pieces::loose(SMALL).bytes();
    let (model, expected) = (Loaded::new(&file), Model::from_bytes(&*file).unwrap());
    assert_eq!(model.envelope(None, 0).err(), Some(sinew_status::NotFound));
    let (found, skin) = (model.skin(None, 0).unwrap(), expected.first::<Skin>().unwrap());
    let info = found.info();
    assert_eq!((info.envelope_part, info.palette_len, info.influence_len), (SINEW_NO_PART, 0, 0));
    let at_rest = found.run(found.job(&[], 0..info.vertex_len));
    assert_eq!(at_rest, common::skinned(skin, &[]));
    assert_eq!(at_rest[..3 * info.vertex_len], common::rest(skin)[..3 * info.vertex_len]);
    let bounds = skin.bounds(&[], 0.0).unwrap().unwrap();
    let found = found.bounds(&[], 0.0);
    assert_eq!((found.min, found.max), (bounds.min, bounds.max));
}

#[test]
fn threads_share_models_and_skin_ranges_at_once() {
    with(
        &Pieces::sample(Predictor::Kernel, SMALL).bytes(),
        |Both { c: (envelope, skin), rust, .. }| {
            let pose = random_pose(&rust.0, &mut Rng(5), 0.3);
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
    let file = Pieces::sample(Predictor::Kernel, SMALL).bytes();
    let mut shifted = vec![0; file.len() + 1];
    shifted[1..].copy_from_slice(&file);
    with(&shifted[1..], |Both { c: (envelope, skin), rust, .. }| {
        let pose = random_pose(&rust.0, &mut Rng(5), 0.3);
        let palette = envelope.palette(&pose);
        assert_eq!(envelope.moved().palette(&pose), palette);
        let (palette, moved) = (&palette.0, skin.moved());
        let all = 0..rust.1.vertex_len();
        assert_eq!(moved.run(moved.job(palette, all.clone())), skin.run(skin.job(palette, all)));
    });
}

#[test]
fn shapes_have_the_bits_of_the_runtime() {
    for pieces in Pieces::shaped() {
        let file = pieces.bytes();
        let (model, rust) = (Loaded::new(&file), Model::from_bytes(&file).unwrap());
        let (found, skin) = (model.skin(None, 0).unwrap(), rust.first::<Skin>().unwrap());
        let (v, s) = (skin.vertex_len(), skin.shape_len());
        assert_eq!(found.info().shape_len, s);
        for shape in 0..s {
            let (in_c, bounds) = (found.shape(shape), skin.shape_box(shape).unwrap());
            assert_eq!(name(in_c.name, in_c.name_len), skin.shape_name(shape).unwrap());
            assert_eq!((in_c.bounds.min, in_c.bounds.max), (bounds.min, bounds.max));
        }
        let mut random = Rng(13);
        let weights: Vec<f32> = (0..s).map(|_| random.unit() * 1.5 + 0.5).collect();
        let palette = vec![common::IDENTITY; skin.palette_len()];
        let bounds = skin.shaped_bounds(&palette, &weights).unwrap().unwrap();
        let bounds_in_c = found.shaped_bounds(&palette, &weights);
        assert_eq!((bounds_in_c.min, bounds_in_c.max), (bounds.min, bounds.max));
        let vertices = v / 3..v;
        let (mut in_c, mut in_rust) = (vec![f32::NAN; 10 * v], vec![f32::NAN; 10 * v]);
        let lent = cells(&mut in_rust);
        let to = |first: usize| Some(Output::shared(&lent[first..], 10));
        ShapesJob::new(skin, &weights)
            .vertices(vertices.clone())
            .positions(to(0))
            .normals(to(3))
            .tangents(to(6).filter(|_| skin.has_tangents()))
            .run()
            .unwrap();
        let (at, len) = (in_c.as_mut_ptr(), in_c.len());
        let shared = |first: usize| sinew_output {
            floats: at.wrapping_add(first),
            len: len - first,
            stride: 10,
        };
        let mut job = found.shapes_job(&weights, vertices);
        (job.positions, job.normals) = (shared(0), shared(3));
        if skin.has_tangents() {
            job.tangents = shared(6);
        }
        // SAFETY: three outputs within one buffer; no other reference to it is used.
        done(unsafe { sinew_shapes_run(&raw const job, NONE) });
        assert_eq!(common::bits(&in_c), common::bits(&in_rust));
    }
}
