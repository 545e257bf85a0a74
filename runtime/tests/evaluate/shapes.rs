//! The stage `shapes`: sums, normals, tangents, bounds, and refused calls.

use crate::common::{IDENTITY, bits, call_error, length_error, short_error};
use models::{Pieces, Rng, SMALL, Shape, ShapeContent, cells, direction};
use sinew_runtime::envelope::Predictor;
use sinew_runtime::format::{Element, SectionKind};
use sinew_runtime::skin::{BLOCK, Output};
use sinew_runtime::{Argument, CallError, CallErrorKind, Model, ShapesJob, Skin, SkinJob};
use std::ops::Range;

const ELEMENTS: [Element; 3] = [Element::F32, Element::F16, Element::I8];

/// More than two blocks, the last one incomplete.
const VERTICES: usize = 2 * BLOCK + 9;
const SHAPES: usize = 8;

const SHAPE: Shape = Shape { vertices: VERTICES, coefficients: false, ..SMALL };

/// A skin with shapes, and the content of its shapes.
fn shaped(element: Element, shape: Shape) -> (Model<Vec<u8>>, ShapeContent) {
    let content = ShapeContent::sample(element, SHAPES, shape.vertices);
    let mut pieces = Pieces::sample(Predictor::Rotational, shape);
    pieces.set_shapes(&content);
    (Model::from_bytes(pieces.bytes()).unwrap(), content)
}

/// Weights, with every third 0.
fn weights(rng: &mut Rng) -> Vec<f32> {
    (0..SHAPES).map(|s| if s % 3 == 2 { 0.0 } else { rng.unit() * 1.5 + 0.5 }).collect()
}

/// Positions, normals and tangents of a range, vertex by vertex.
fn run(skin: Skin<'_>, weights: &[f32], vertices: Range<usize>) -> Vec<[f32; 10]> {
    let mut out = vec![[0.0; 10]; vertices.len()];
    let lent = cells(out.as_flattened_mut());
    let job = ShapesJob::new(skin, weights)
        .vertices(vertices)
        .positions(Output::shared(lent, 10))
        .normals(Output::shared(lent.get(3..).unwrap_or_default(), 10))
        .tangents(
            Some(Output::shared(lent.get(6..).unwrap_or_default(), 10))
                .filter(|_| skin.has_tangents()),
        );
    job.run().unwrap();
    out
}

#[test]
fn what_the_file_holds_is_read_back() {
    for element in ELEMENTS {
        let (model, content) = shaped(element, SHAPE);
        let skin = model.first::<Skin>().unwrap();
        assert_eq!((skin.shape_len(), skin.shape_element()), (SHAPES, element));
        assert_eq!(skin.shape_name(0), Some("shape 0"));
        assert_eq!(skin.shape_name(SHAPES - 1), Some("shape 7"));
        assert_eq!(skin.shape_name(SHAPES), None);
        assert_eq!(skin.ranges().map(|(name, _)| name).collect::<Vec<_>>(), ["upper", "lower"]);
        for (shape, vertex) in (0..SHAPES).flat_map(|s| (0..VERTICES).map(move |v| (s, v))) {
            assert_eq!(skin.shape_delta(shape, vertex), Some(content.delta(shape, vertex)));
            assert_eq!(skin.shape_slopes(shape, vertex), Some(content.slopes(shape, vertex)));
            let own = skin.deltas_of(vertex).find(|(own, _)| *own == shape);
            let moved = content.moved[shape][vertex].map(|_| content.delta(shape, vertex));
            assert_eq!(own.map(|(_, delta)| delta), moved);
            assert!(skin.shape_box(shape).unwrap().contains(content.delta(shape, vertex)));
        }
        let ascends = |v| skin.deltas_of(v).map(|(shape, _)| shape).is_sorted_by(|a, b| a < b);
        assert!((0..VERTICES).all(ascends));
        assert_eq!(skin.shape_delta(SHAPES, 0), None);
        assert_eq!(skin.shape_delta(0, VERTICES), None);
        assert_eq!(skin.shape_slopes(0, VERTICES), None);
        assert_eq!(skin.deltas_of(VERTICES + BLOCK).count(), 0);
        assert!(skin.shape_box(SHAPES).is_none());
        let errors = skin.shape_errors().unwrap();
        assert_eq!((errors.largest, errors.rms), (0.0625, 0.015625));
    }
}

#[test]
fn positions_are_the_sums_of_their_definition() {
    let mut rng = Rng(5);
    for element in ELEMENTS {
        let (model, content) = shaped(element, SHAPE);
        let skin = model.first::<Skin>().unwrap();
        for _ in 0..20 {
            let weights = weights(&mut rng);
            for (vertex, found) in run(skin, &weights, 0..VERTICES).iter().enumerate() {
                let rest = skin.rest_position(vertex).unwrap();
                for (c, (found, rest)) in found.iter().zip(rest).enumerate() {
                    let add =
                        |s: usize| f64::from(weights[s]) * f64::from(content.delta(s, vertex)[c]);
                    let (mut exact, mut magnitude) = (f64::from(rest), f64::from(rest.abs()));
                    (0..SHAPES).map(add).for_each(|x| {
                        exact += x;
                        magnitude += x.abs();
                    });
                    // Per shape a product of two steps, and a sum.
                    let bound = (SHAPES as f64 + 4.0) * f64::from(f32::EPSILON) * magnitude;
                    assert!((f64::from(*found) - exact).abs() <= bound, "{vertex} {found} {exact}");
                }
            }
        }
    }
}

#[test]
fn normals_and_tangents_are_tilted_by_the_sums_of_slopes() {
    let mut rng = Rng(6);
    for (element, tangents) in ELEMENTS.into_iter().flat_map(|e| [(e, true), (e, false)]) {
        let (model, content) = shaped(element, Shape { tangents, ..SHAPE });
        let skin = model.first::<Skin>().unwrap();
        let weights = weights(&mut rng);
        for (vertex, found) in run(skin, &weights, 0..VERTICES).iter().enumerate() {
            let sum = |i: usize| {
                let of = |s| f64::from(weights[s]) * f64::from(content.slopes(s, vertex)[i]);
                (0..SHAPES).map(of).sum::<f64>()
            };
            let (a, c) = (sum(0), sum(1));
            let n = skin.rest_normal(vertex).unwrap().map(f64::from);
            let tangent = skin.rest_tangent(vertex).map(|t| t.map(f64::from));
            let g = match tangent {
                Some([x, y, z, _]) => [x, y, z],
                None => tangent_of(n),
            };
            let h = cross(n, g);
            let tilted = unit([0, 1, 2].map(|i| n[i] - a * g[i] - c * h[i]));
            let lifted = unit([0, 1, 2].map(|i| g[i] + a * n[i]));
            for i in 0..3 {
                assert!((f64::from(found[3 + i]) - tilted[i]).abs() < 3e-6, "{vertex}");
                let expected = if tangents { lifted[i] } else { 0.0 };
                assert!((f64::from(found[6 + i]) - expected).abs() < 3e-6, "{vertex}");
            }
            assert_eq!(f64::from(found[9]), tangent.map_or(0.0, |t| t[3]));
        }
    }
}

/// A direction orthogonal to a normal, by the formula of Duff et al.
fn tangent_of([x, y, z]: [f64; 3]) -> [f64; 3] {
    let sign = 1.0_f64.copysign(z);
    let a = -1.0 / (sign + z);
    [1.0 + sign * x * x * a, sign * x * y * a, -sign * x]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn unit(v: [f64; 3]) -> [f64; 3] {
    let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
    v.map(|x| x / length)
}

#[test]
fn without_weights_the_mesh_is_at_rest() {
    let (model, _) = shaped(Element::F32, SHAPE);
    let skin = model.first::<Skin>().unwrap();
    for weight in [0.0, -0.0] {
        for (vertex, found) in run(skin, &[weight; SHAPES], 0..VERTICES).iter().enumerate() {
            assert_eq!(found[..3], skin.rest_position(vertex).unwrap().map(|x| x + 0.0));
            let near = |a: &[f32], b: &[f32]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 2e-7);
            assert!(near(&found[3..6], &skin.rest_normal(vertex).unwrap()));
            assert!(near(&found[6..], &skin.rest_tangent(vertex).unwrap()));
        }
    }
}

#[test]
fn ranges_have_the_bits_of_the_whole() {
    let (model, _) = shaped(Element::I8, SHAPE);
    let skin = model.first::<Skin>().unwrap();
    let weights = weights(&mut Rng(7));
    let whole = run(skin, &weights, 0..VERTICES);
    let all = [0..0, 0..1, 5..70, 63..64, 64..128, 63..129, 128..VERTICES, VERTICES..VERTICES];
    for range in all {
        let found = run(skin, &weights, range.clone());
        assert_eq!(bits(found.as_flattened()), bits(whole[range].as_flattened()));
    }
}

#[test]
fn positions_alone_have_the_same_bits() {
    let (model, _) = shaped(Element::F16, SHAPE);
    let skin = model.first::<Skin>().unwrap();
    let weights = &weights(&mut Rng(8))[..];
    let mut out = vec![[0.0; 3]; VERTICES];
    let positions = Output::new(out.as_flattened_mut(), 3);
    ShapesJob::new(skin, weights).positions(positions).run().unwrap();
    for (alone, all) in out.iter().zip(run(skin, weights, 0..VERTICES)) {
        assert_eq!(bits(alone), bits(&all[..3]));
    }
}

#[test]
fn a_skin_without_shapes_takes_no_weights() {
    let model = Model::from_bytes(Pieces::sample(Predictor::Rotational, SHAPE).bytes()).unwrap();
    let skin = model.first::<Skin>().unwrap();
    assert_eq!((skin.shape_len(), skin.shape_name(0), skin.shape_errors()), (0, None, None));
    let found = run(skin, &[], 0..VERTICES);
    assert!(
        (0..VERTICES)
            .all(|v| Some(&found[v][..3]) == skin.rest_position(v).as_ref().map(|x| &x[..]))
    );
    let bounds = skin.shaped_bounds(&[IDENTITY; 3], &[]).unwrap();
    assert_eq!(bounds, skin.bounds(&[IDENTITY; 3], 0.0).unwrap());
}

#[test]
fn bounds_hold_every_shaped_and_posed_vertex() {
    let mut rng = Rng(9);
    let with = |pieces: Pieces, rng: &mut Rng| {
        let model = Model::from_bytes(pieces.bytes()).unwrap();
        let skin = model.first::<Skin>().unwrap();
        let mut on_its_face = false;
        for turn in 0..40 {
            // The ends of the usual range of weights, and values between.
            let weights: Vec<f32> = (0..SHAPES)
                .map(|_| [-1.0, 2.0, 0.0, rng.unit() * 1.5 + 0.5][rng.next_u64() as usize % 4])
                .collect();
            let any = |rng: &mut Rng| [(); 3].map(|()| [(); 4].map(|()| 100.0 * rng.unit()));
            let palette: Vec<_> = (0..skin.palette_len())
                .map(|_| if turn % 2 == 0 { IDENTITY } else { any(rng) })
                .collect();
            let bounds = skin.shaped_bounds(&palette, &weights).unwrap().unwrap();
            let rest: Vec<[f32; 3]> = run(skin, &weights, 0..VERTICES)
                .iter()
                .map(|vertex| [vertex[0], vertex[1], vertex[2]])
                .collect();
            let mut posed = vec![[0.0; 3]; VERTICES];
            let job = SkinJob::new(skin, &palette)
                .rest_positions(&rest)
                .positions(Output::new(posed.as_flattened_mut(), 3));
            job.run().unwrap();
            assert!(posed.iter().all(|x| bounds.contains(*x)), "{weights:?}");
            let still = skin.bounds(&palette, 0.0).unwrap().unwrap();
            on_its_face |= posed.iter().any(|x| !still.contains(*x));
        }
        assert!(on_its_face, "shapes take vertices out of the box at rest");
    };
    for element in ELEMENTS {
        let content = ShapeContent::sample(element, SHAPES, VERTICES);
        let mut pieces = Pieces::sample(Predictor::Rotational, SHAPE);
        pieces.set_shapes(&content);
        let mut loose = pieces.clone();
        loose.loosen();
        with(pieces, &mut rng);
        with(loose, &mut rng);
    }
}

#[test]
fn normals_of_length_zero_stay_zero() {
    let mut pieces = Pieces::sample(Predictor::Rotational, SHAPE);
    pieces.edit_vertices(SectionKind::RestNormals, |numbers| numbers[..12].fill(0));
    pieces.set_shapes(&ShapeContent::sample(Element::F32, SHAPES, VERTICES));
    let model = Model::from_bytes(pieces.bytes()).unwrap();
    let found = run(model.first::<Skin>().unwrap(), &[1.0; SHAPES], 0..1);
    assert_eq!(found[0][3..6], [0.0; 3]);
    assert!(direction(&mut Rng(1)).iter().all(|x| x.is_finite()));
}

#[test]
fn bad_calls_are_refused_and_write_nothing() {
    let (model, _) = shaped(Element::F32, SHAPE);
    let skin = model.first::<Skin>().unwrap();
    let mut out = vec![7.0; 4 * VERTICES];
    let weights = [1.0; SHAPES];
    let lent = cells(&mut out);
    let job = ShapesJob::new(skin, &weights).positions(Output::shared(lent, 3));
    let refused = |job: ShapesJob<'_>| job.run().unwrap_err();
    let found = refused(job.clone().positions(None));
    assert_eq!(found, call_error(CallErrorKind::NoOutput, Argument::Call));
    let found = refused(ShapesJob::new(skin, &weights[1..]).positions(Output::shared(lent, 3)));
    assert_eq!(found, length_error(Argument::Weights, SHAPES, SHAPES - 1));
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let mut weights = weights;
        weights[5] = bad;
        let error =
            CallError { index: 5, ..call_error(CallErrorKind::NonFinite, Argument::Weights) };
        assert_eq!(
            refused(ShapesJob::new(skin, &weights).positions(Output::shared(lent, 3))),
            error
        );
        assert_eq!(error.to_string(), "shape weights: shape 5 is not finite");
        assert_eq!(skin.shaped_bounds(&[IDENTITY; 3], &weights), Err(error));
    }
    let range = call_error(CallErrorKind::OutOfRange, Argument::Vertices);
    for (vertices, index) in [
        (0..VERTICES + 1, 0),
        (usize::MAX..usize::MAX, usize::MAX),
        (Range { start: 9, end: 8 }, 9),
    ] {
        let error = CallError { index, expected: VERTICES, found: vertices.end, ..range };
        assert_eq!(refused(job.clone().vertices(vertices)), error);
    }
    let stride = refused(job.clone().positions(None).tangents(Output::shared(lent, 3)));
    let error = call_error(CallErrorKind::Stride, Argument::Tangents);
    assert_eq!(stride, CallError { expected: 4, found: 3, ..error });
    let short = refused(job.clone().positions(Output::shared(&lent[..3 * VERTICES - 1], 3)));
    assert_eq!(short, short_error(Argument::Positions, 3 * VERTICES, 3 * VERTICES - 1));
    let (plain, _) = shaped(Element::F32, Shape { tangents: false, ..SHAPE });
    let found = refused(
        ShapesJob::new(plain.first::<Skin>().unwrap(), &weights).tangents(Output::shared(lent, 4)),
    );
    assert_eq!(found, call_error(CallErrorKind::NoAttribute, Argument::Tangents));
    let error = skin.shaped_bounds(&[IDENTITY; 2], &weights).unwrap_err();
    assert_eq!(error, length_error(Argument::Palette, 3, 2));
    assert!(out.iter().all(|x| *x == 7.0));
}
