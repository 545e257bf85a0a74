//! Shapes of a skin: their content in a file, its cost, and the normals.

use nalgebra::Vector3;
use sinew_runtime::format::Space;
use sinew_runtime::{Envelope, Model, Skin};
use sinew_trainer::envelope::model::{FileModel, ShapeNumbers, Shapes, SkinModel};
use sinew_trainer::mesh::Surface;
use std::f64::consts::PI;

const NUMBERS: [ShapeNumbers; 3] = [ShapeNumbers::F32, ShapeNumbers::F16, ShapeNumbers::I8];

/// Makes a round cap of rings; the first ring is the pole. Triangles face outward.
fn cap(rings: usize, sides: usize) -> (Vec<[f64; 3]>, Vec<[usize; 3]>) {
    let mut positions = vec![[0.0, 0.0, 1.0]];
    for ring in 1..=rings {
        let polar = 1.2 * ring as f64 / rings as f64;
        for side in 0..sides {
            let around = 2.0 * PI * side as f64 / sides as f64;
            let (sine, cosine) = around.sin_cos();
            positions.push([polar.sin() * cosine, polar.sin() * sine, polar.cos()]);
        }
    }
    let at = |ring: usize, side: usize| 1 + (ring - 1) * sides + side % sides;
    let mut triangles: Vec<_> = (0..sides).map(|side| [0, at(1, side), at(1, side + 1)]).collect();
    for (ring, side) in (1..rings).flat_map(|ring| (0..sides).map(move |side| (ring, side))) {
        let [a, b] = [at(ring, side), at(ring, side + 1)];
        let [c, d] = [at(ring + 1, side), at(ring + 1, side + 1)];
        triangles.extend([[a, c, d], [a, d, b]]);
    }
    (positions, triangles)
}

/// Makes a face without an envelope: a cap with a bump, a pull to one side, and a shape that moves
/// nothing.
fn face(numbers: ShapeNumbers) -> (SkinModel, Vec<[usize; 3]>) {
    let (positions, triangles) = cap(9, 24);
    let near = |[x, y, z]: &[f64; 3]| {
        let away = (Vector3::new(*x, *y, *z) - Vector3::new(0.5, 0.2, 0.8)).norm();
        (1.0 - away / 0.5).max(0.0)
    };
    let bump = positions.iter().map(|x| [0.0, 0.0, 0.2 * near(x).powi(2)]).collect();
    let pull = positions.iter().map(|x| [0.1 * near(x), -0.05 * near(x), 0.0]).collect();
    let deltas: Vec<Vec<[f64; 3]>> = vec![bump, pull, vec![[0.0; 3]; positions.len()]];
    let surface = Surface { positions: &positions, triangles: &triangles, engine: None };
    let mut skin = SkinModel {
        name: "face".to_owned(),
        envelope: None,
        rest_normals: surface.normals(),
        rest_positions: positions.clone(),
        rest_tangents: None,
        influences: Vec::new(),
        tangent_coefficients: None,
        normal_errors: None,
        ranges: vec![("cap".to_owned(), 0..positions.len())],
        shapes: Shapes {
            names: ["bump", "pull", "still"].map(str::to_owned).to_vec(),
            slopes: Vec::new(),
            deltas,
            numbers,
        },
    };
    skin.tilt_shapes(&surface);
    (skin, triangles)
}

fn baked(skin: SkinModel) -> Model<Vec<u8>> {
    let file = FileModel {
        space: Space::default(),
        envelopes: Vec::new(),
        skins: vec![skin],
        ..FileModel::default()
    };
    Model::from_bytes(file.bake().unwrap()).unwrap()
}

fn shaped(skin: &Skin<'_>, weights: &[f32]) -> (Vec<[f32; 3]>, Vec<[f32; 3]>) {
    use sinew_runtime::ShapesJob;
    use sinew_runtime::skin::Output;
    let v = skin.vertex_len();
    let (mut positions, mut normals) = (vec![[0.0; 3]; v], vec![[0.0; 3]; v]);
    let to = |floats| Some(Output::new(floats, 3));
    ShapesJob::new(*skin, weights)
        .vertices(0..v)
        .positions(to(positions.as_flattened_mut()))
        .normals(to(normals.as_flattened_mut()))
        .run()
        .unwrap();
    (positions, normals)
}

#[test]
fn a_face_alone_is_a_file() {
    for numbers in NUMBERS {
        let (face, _) = face(numbers);
        let model = baked(face.clone());
        assert!(model.first::<Envelope>().is_none());
        let skin = model.named::<Skin>("face").unwrap();
        let names: Vec<_> = (0..3).map(|shape| skin.shape_name(shape).unwrap()).collect();
        assert_eq!(names, ["bump", "pull", "still"]);
        assert_eq!(skin.shape_element(), numbers.element());
        // A vertex that no shape moves, among vertices that do not move, costs nothing.
        let still = face.shapes.deltas[0].iter().filter(|delta| **delta == [0.0; 3]).count();
        assert!(still > 100 && (skin.counts().delta_len as usize) < 2 * (217 - still) + 60);
        let back = SkinModel::from_file(&skin);
        assert_eq!(back.shapes.names, face.shapes.names);
        assert_eq!(back.shapes.numbers, numbers);
    }
}

/// The file reports the largest and the RMS difference: the rounding of deltas to the element type.
#[test]
fn the_cost_of_smaller_numbers_is_measured() {
    for (numbers, step) in [
        (ShapeNumbers::F32, 2.0_f64.powi(-24)),
        (ShapeNumbers::F16, 2.0_f64.powi(-11)),
        (ShapeNumbers::I8, 0.5 / 127.0),
    ] {
        let (face, _) = face(numbers);
        let model = baked(face.clone());
        let skin = model.first::<Skin>().unwrap();
        let (mut largest, mut squares, mut len) = (0.0_f64, 0.0, 0);
        for (shape, deltas) in face.shapes.deltas.iter().enumerate() {
            for (vertex, delta) in deltas.iter().enumerate() {
                let found = skin.shape_delta(shape, vertex).unwrap().map(f64::from);
                let error = (Vector3::from(found) - Vector3::from(*delta)).norm();
                largest = largest.max(error);
                squares += error * error;
                len += usize::from(*delta != [0.0; 3]);
            }
        }
        let told = skin.shape_errors().unwrap();
        let near = |a: f32, b: f64| (f64::from(a) - b).abs() <= 1e-6 * b + 1e-12;
        assert!(near(told.largest, largest), "{told:?} {largest}");
        assert!(near(told.rms, (squares / len as f64).sqrt()), "{told:?}");
        // Half a step of the largest delta, in each of three coordinates.
        let most = 0.2;
        assert!(largest <= 3.0_f64.sqrt() * most * step * 1.01, "{numbers:?} {largest}");
        assert!(largest > 0.05 * most * step, "{numbers:?} {largest}");
    }
}

/// At weight 1 of a single shape, normals are those of the shaped surface. At smaller weights, they
/// are nearer to the shaped surface's normals than the rest normals are.
#[test]
fn normals_are_those_of_the_shaped_surface() {
    let (face, triangles) = face(ShapeNumbers::F32);
    let model = baked(face.clone());
    let skin = model.first::<Skin>().unwrap();
    let truth = |weights: &[f64]| {
        let moved: Vec<[f64; 3]> = face.shaped(weights).iter().map(|v| v.position.into()).collect();
        Surface { positions: &moved, triangles: &triangles, engine: None }.normals()
    };
    let angles = |normals: &[[f64; 3]], truth: &[[f64; 3]]| {
        let of = |(a, b): (&[f64; 3], &[f64; 3])| Vector3::from(*a).angle(&Vector3::from(*b));
        let all: Vec<f64> = normals.iter().zip(truth).map(of).collect();
        (all.iter().map(|x| x * x).sum::<f64>().sqrt(), all.iter().fold(0.0_f64, |m, x| m.max(*x)))
    };
    for (weights, secant) in [
        ([1.0, 0.0, 0.0], true),
        ([0.0, 1.0, 0.7], true),
        ([0.5, 0.0, 0.0], false),
        ([0.4, 0.8, -1.0], false),
        ([1.5, -0.5, 0.0], false),
    ] {
        let truth = truth(&weights);
        let (_, found) = shaped(&skin, &weights.map(|w| w as f32));
        let found: Vec<[f64; 3]> = found.iter().map(|n| n.map(f64::from)).collect();
        let (rms, largest) = angles(&found, &truth);
        let (without, _) = angles(&face.rest_normals, &truth);
        if secant {
            assert!(largest < 2e-3, "{weights:?}: {largest}");
        }
        assert!(rms < 0.5 * without, "{weights:?}: {rms} {without}");
        // The oracle gives the same normals.
        let oracle: Vec<[f64; 3]> =
            face.shaped(&weights).iter().map(|vertex| vertex.normal.into()).collect();
        assert!(angles(&found, &oracle).1 < 2e-3);
    }
}

#[test]
fn shapes_that_do_not_fit_are_refused() {
    let refused = |edit: &dyn Fn(&mut Shapes)| {
        let (mut face, _) = face(ShapeNumbers::I8);
        edit(&mut face.shapes);
        let file = FileModel {
            space: Space::default(),
            envelopes: Vec::new(),
            skins: vec![face],
            ..FileModel::default()
        };
        file.bake().unwrap_err().to_string()
    };
    let length =
        |what, expected, found| format!("{what}: expected {expected} elements, found {found}");
    let v = face(ShapeNumbers::F32).0.rest_positions.len();
    assert_eq!(refused(&|s| s.names.truncate(2)), length("deltas of all shapes", 2, 3));
    assert_eq!(refused(&|s| s.slopes.truncate(1)), length("slopes of all shapes", 3, 1));
    assert_eq!(refused(&|s| s.deltas[1].truncate(5)), length("deltas of a shape", v, 5));
    assert_eq!(refused(&|s| s.slopes[2].truncate(0)), length("slopes of a shape", v, 0));
    for bad in [f64::NAN, f64::INFINITY, 1e30] {
        let found = refused(&|s| s.deltas[0][7][1] = bad);
        assert!(found.starts_with("the runtime refuses the baked model: "), "{bad}: {found}");
    }
}
