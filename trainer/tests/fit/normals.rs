//! Normals by tangent coefficients (METHOD §1.8): closed forms, spaces, further meshes, and
//! reported errors.

use faer::Mat;
use nalgebra::{Matrix3, Matrix3x4, Rotation3, Vector3};
use sinew_runtime::envelope::Predictor;
use sinew_runtime::format::Space;
use sinew_runtime::{Envelope, Model, Skin};
use sinew_trainer::envelope::levels::Level;
use sinew_trainer::envelope::model::{EnvelopeModel, FileModel, Shapes, SkinModel};
use sinew_trainer::envelope::normals::{Fan, PosedSurface};
use sinew_trainer::envelope::oracle::Pose;
use sinew_trainer::envelope::s3::ProxyCount;
use sinew_trainer::envelope::{FileSkins, Options, Predict, train};
use sinew_trainer::evaluate::{Frames, evaluate};
use sinew_trainer::examples::demo::{DemoOptions, demo};
use sinew_trainer::examples::{Examples, Split};
use sinew_trainer::formats::Mesh;
use sinew_trainer::progress::Silent;

type Map = Matrix3x4<f64>;

fn arm(vertices: usize) -> Examples {
    demo(&DemoOptions { vertices, poses: 40, held_out: 12, seed: 2 })
}

fn options(predictor: Predictor) -> Options {
    let proxies = Some(ProxyCount::Fixed(6));
    Options { predictor: Predict::Only(predictor), proxies, ..Options::default() }
}

fn map(linear: Matrix3<f64>, offset: Vector3<f64>) -> Map {
    let [a, b, c] = [0, 1, 2].map(|k| linear.column(k).into_owned());
    Map::from_columns(&[a, b, c, offset])
}

/// Makes a skin of some vertices, without tangents.
fn skin(
    rest: &[[f64; 3]],
    rest_normals: Vec<[f64; 3]>,
    influences: Vec<Vec<(usize, f64)>>,
) -> SkinModel {
    SkinModel {
        name: "skin".to_owned(),
        envelope: Some(0),
        rest_positions: rest.to_vec(),
        rest_normals,
        rest_tangents: None,
        influences,
        tangent_coefficients: None,
        normal_errors: None,
        ranges: Vec::new(),
        shapes: Shapes::default(),
    }
}

/// Fits a skin to the meshes that it has under the palettes, one per pose, by linear blending.
fn fit(skin: &mut SkinModel, triangles: &[[usize; 3]], palettes: &[Vec<Map>]) {
    let stacked = Mat::from_fn(3 * palettes.len(), 4 * palettes[0].len(), |row, column| {
        palettes[row / 3][column / 4][(row % 3, column % 4)]
    });
    let posed = Mat::from_fn(3 * palettes.len(), skin.rest_positions.len(), |row, vertex| {
        let vertex = skin.vertex(vertex);
        (vertex.blend(&palettes[row / 3]) * vertex.position)[row % 3]
    });
    let surface = PosedSurface {
        rest: &skin.rest_positions.clone(),
        trajectories: &posed,
        palettes: &stacked,
        fans: &Fan::all(triangles, skin.rest_positions.len()),
        authored: false,
    };
    surface.fit(skin, 1.0, 4);
}

fn degrees(a: &Vector3<f64>, b: &Vector3<f64>) -> f64 {
    a.cross(b).norm().atan2(a.dot(b)).to_degrees()
}

#[test]
fn one_affine_map_moves_normals_by_its_cofactors_whatever_the_coefficients() {
    let examples = arm(250);
    let maps: Vec<Map> = (0..8)
        .map(|pose| {
            let wave = |k: usize| (1.7 * (pose * 12 + k) as f64).sin();
            let bend = Matrix3::from_fn(|r, c| 0.3 * wave(4 * r + c)) + Matrix3::identity();
            map(bend, Vector3::new(wave(3), wave(7), wave(11)))
        })
        .collect();
    let palettes: Vec<Vec<Map>> = maps.iter().map(|map| vec![*map; 3]).collect();
    let influences = |v: usize| vec![(v % 3, 0.6), ((v + 1) % 3, 0.4)];
    let influences = (0..examples.vertex_len()).map(influences).collect();
    let mut fitted = skin(&examples.rest, examples.surface().normals(), influences);
    fit(&mut fitted, &examples.triangles, &palettes);
    let mut any = fitted.clone();
    any.tangent_coefficients = Some(
        (0..examples.vertex_len()).map(|v| vec![[v as f64, -3.0], [-(v as f64), 3.0]]).collect(),
    );
    for (pose, palette) in palettes.iter().enumerate() {
        let linear: Matrix3<f64> = maps[pose].fixed_columns::<3>(0).into();
        let cofactors = linear.try_inverse().unwrap().transpose() * linear.determinant();
        for skin in [&fitted, &any] {
            for (vertex, rest) in skin.vertices().zip(&skin.rest_normals) {
                let expected = (cofactors * Vector3::from(*rest)).normalize();
                let found = vertex.skinned(palette).normal;
                assert!((found - expected).norm() < 1e-9, "{pose}: {found} {expected}");
            }
        }
    }
    // Under a mirror, outward normals stay outward.
    let mirror = Matrix3::from_diagonal(&Vector3::new(-1.0, 1.0, 1.0));
    let mirrored = vec![map(mirror, Vector3::zeros()); 3];
    let plain = SkinModel { tangent_coefficients: None, ..fitted.clone() };
    for skin in [&fitted, &any, &plain] {
        for (vertex, rest) in skin.vertices().zip(&skin.rest_normals) {
            let found = vertex.skinned(&mirrored).normal;
            assert!((found - mirror * Vector3::from(*rest)).norm() < 1e-9);
        }
    }
}

/// A tube along x that is bent in its middle by two transforms, whose weights are a known function
/// of x. Its surface, tangents, normals and coefficients are then closed forms.
#[test]
fn a_bent_tube_has_the_normals_of_its_formula() {
    const RINGS: usize = 81;
    const SIDES: usize = 48;
    const RADIUS: f64 = 0.25;
    // Rises from 0 to 1 within a quarter to either side; returns the weight and its slope.
    let weight = |x: f64| {
        let u = (2.0 * x + 0.5).clamp(0.0, 1.0);
        (u * u * (3.0 - 2.0 * u), 2.0 * 6.0 * u * (1.0 - u))
    };
    let around = |side: usize| std::f64::consts::TAU * side as f64 / SIDES as f64;
    let along = |ring: usize| -0.5 + ring as f64 / (RINGS - 1) as f64;
    let outward = |side: usize| Vector3::new(0.0, around(side).cos(), around(side).sin());
    let vertices = || (0..RINGS).flat_map(|ring| (0..SIDES).map(move |side| (ring, side)));
    let rest: Vec<[f64; 3]> = vertices()
        .map(|(ring, side)| (Vector3::x() * along(ring) + outward(side) * RADIUS).into())
        .collect();
    let mut triangles = Vec::new();
    for (ring, side) in vertices().filter(|(ring, _)| ring + 1 < RINGS) {
        let at = |ring: usize, side: usize| ring * SIDES + side % SIDES;
        let [a, b] = [at(ring, side), at(ring, side + 1)];
        let [c, d] = [at(ring + 1, side), at(ring + 1, side + 1)];
        triangles.extend([[a, b, c], [b, d, c]]);
    }
    let influences = vertices().map(|(ring, _)| {
        let (w, _) = weight(along(ring));
        let mut list = vec![(0, 1.0 - w), (1, w)];
        list.sort_by(|a, b| b.1.total_cmp(&a.1));
        list.retain(|influence| influence.1 > 0.0);
        list
    });
    let normals = vertices().map(|(_, side)| outward(side).into()).collect();
    let mut bent = skin(&rest, normals, influences.collect());
    let palettes: Vec<Vec<Map>> = (1..=10)
        .map(|pose| {
            let axis = Vector3::new(0.1 * f64::from(pose % 3), 0.3, 1.0).normalize();
            let turn = Rotation3::from_scaled_axis(axis * 0.06 * f64::from(pose));
            let still = map(Matrix3::identity(), Vector3::zeros());
            vec![still, map(turn.into_inner(), Vector3::zeros())]
        })
        .collect();
    let cofactors = bent.clone();
    fit(&mut bent, &triangles, &palettes);

    let (mut most, mut most_by_cofactors) = (0.0_f64, 0.0_f64);
    let coefficients = bent.tangent_coefficients.as_ref().unwrap();
    // Not at the open ends, where the true normals are one-sided.
    for (number, (ring, side)) in
        vertices().enumerate().filter(|(_, (ring, _))| (1..RINGS - 1).contains(ring))
    {
        let vertex = bent.vertex(number);
        let (w, slope) = weight(along(ring));
        let x = Vector3::from(rest[number]);
        for palette in &palettes {
            let turn: Matrix3<f64> = palette[1].fixed_columns::<3>(0).into();
            let blend = Matrix3::identity() * (1.0 - w) + turn * w;
            let across = blend * Vector3::x().cross(&outward(side));
            let formula = blend * Vector3::x() + (turn * x - x) * slope;
            let truth = across.cross(&formula);
            most = most.max(degrees(&vertex.skinned(palette).normal, &truth));
            let plain = cofactors.vertex(number).skinned(palette).normal;
            most_by_cofactors = most_by_cofactors.max(degrees(&plain, &truth));
        }
        // The coefficients are the weights' gradient along the frame.
        let frame = vertex.frame();
        for ((index, _), found) in vertex.influences.iter().zip(&coefficients[number]) {
            let sign = if *index == 1 { 1.0 } else { -1.0 };
            for k in 0..2 {
                let expected = sign * slope * frame[k].x;
                // The rings are discrete, which smooths the gradient, most where the gradient
                // changes fastest.
                assert!((found[k] - expected).abs() < 0.1, "{number}: {} {expected}", found[k]);
            }
        }
    }
    assert!(most < 1.0 && most_by_cofactors > 10.0, "{most} {most_by_cofactors}");
}

#[test]
fn units_divide_coefficients_and_a_mirror_turns_h_around() {
    let examples = Examples { space: Space::GLTF, ..arm(300) };
    let mut moved = examples.clone();
    assert!(moved.convert_to(&Space::UNREAL).unwrap().is_mirrored());
    let [own, other] = [examples, moved].map(|examples| {
        let model = train(&examples, &options(Predictor::Kernel), &Silent).unwrap().model;
        SkinModel::from_file(&Model::from_bytes(&model).unwrap().first::<Skin>().unwrap())
    });
    let (mut compared, mut largest) = (0, 0.0_f64);
    for vertex in 0..own.rest_positions.len() {
        let order = |skin: &SkinModel| -> Vec<usize> {
            skin.influences[vertex].iter().map(|influence| influence.0).collect()
        };
        if order(&own) != order(&other) {
            continue;
        }
        let [own, other] =
            [&own, &other].map(|s| &s.tangent_coefficients.as_ref().unwrap()[vertex]);
        let size = own.iter().flatten().fold(0.0_f64, |most, c| most.max(c.abs()));
        for ([g, h], [other_g, other_h]) in own.iter().zip(other) {
            for (found, expected) in [(100.0 * other_g, g), (-100.0 * other_h, h)] {
                // Rounding of both to f16, and f16 underflow of coefficients in centimetres.
                let most = 4e-3 * size + 100.0 * 4.0 * 2.0_f64.powi(-14);
                assert!((found - expected).abs() < most, "{vertex}: {found} {expected}");
            }
        }
        compared += 1;
        largest = largest.max(size);
    }
    assert!(10 * compared > 9 * own.rest_positions.len() && largest > 10.0, "{compared} {largest}");
}

#[test]
fn the_file_states_the_errors_of_its_normals() {
    let examples = arm(400);
    for predictor in Predictor::ALL {
        let model = train(&examples, &options(predictor), &Silent).unwrap().model;
        let says =
            Model::from_bytes(&model).unwrap().first::<Skin>().unwrap().normal_errors().unwrap();
        let of = |model: &[u8]| evaluate(model, None, &examples, Frames::Of(Split::Train)).unwrap();
        let (found, plain) = (of(&model), of(&without_coefficients(&model, "skin")));
        assert!(says.cofactors > 1.5 * says.model, "{says:?}");
        for (says, found) in [
            (says.model, found.errors.normal_rms_degrees),
            (says.cofactors, plain.errors.normal_rms_degrees),
            (says.lbs, found.lbs.normal_rms_degrees),
        ] {
            let ratio = f64::from(says).to_degrees() / found;
            assert!((ratio - 1.0).abs() < 1e-5, "{predictor:?}: {says} {found}");
        }
    }
}

#[test]
fn proxies_in_another_order_predict_the_same_bits() {
    let examples = arm(300);
    let model = train(&examples, &options(Predictor::Rotational), &Silent).unwrap().model;
    let model = Model::from_bytes(&model).unwrap();
    let envelope = EnvelopeModel::from_file(&model.first::<Envelope>().unwrap());
    for first in 0..envelope.proxy_len() {
        let order = envelope.order_from(first);
        assert_eq!(order[0], first);
        let other = envelope.ordered(&order);
        for frame in [3, 17] {
            let pose: Vec<Map> =
                examples.pose(frame).iter().map(|rows| Map::from_fn(|r, c| rows[r][c])).collect();
            let pose = Pose { joints: &pose, curves: &[] };
            let (expected, found) = (envelope.evaluate(pose).0, other.evaluate(pose).0);
            for (place, &proxy) in order.iter().enumerate() {
                assert_eq!(found[place], expected[proxy], "{first} {place}");
            }
        }
    }
}

#[test]
fn normals_are_nearer_the_truth_than_by_cofactors_for_every_predictor_and_further_meshes() {
    let (examples, coarse) = (arm(600), arm(300));
    let Examples { rest, triangles, engine, .. } = coarse.clone();
    let mesh = Mesh { positions: rest, triangles, engine };
    let level = Level { name: "lod1".to_owned(), mesh, is_placed: false };
    for predictor in Predictor::ALL {
        let meshes = FileSkins::Skins(vec![level.clone()]);
        let options = Options { meshes, ..options(predictor) };
        let model = train(&examples, &options, &Silent).unwrap().model;
        let loaded = Model::from_bytes(&model).unwrap();
        assert!(loaded.all::<Skin>().all(|skin| skin.has_coefficients()));
        // A further mesh has no true mesh to measure against.
        assert!(loaded.named::<Skin>("lod1").unwrap().normal_errors().is_none());
        for (name, examples) in [("skin", &examples), ("lod1", &coarse)] {
            let plain = without_coefficients(&model, name);
            let of = |model: &[u8], name| {
                evaluate(model, Some(name), examples, Frames::Of(Split::HeldOut)).unwrap().errors
            };
            let (found, cofactors) = (of(&model, name), of(&plain, name));
            // Weights are normalised once more.
            assert!((found.rms / cofactors.rms - 1.0).abs() < 1e-5);
            let share = found.normal_rms_degrees / cofactors.normal_rms_degrees;
            println!(
                "{}, {name}: {:.2} against {:.2} degrees",
                predictor.name(),
                found.normal_rms_degrees,
                cofactors.normal_rms_degrees
            );
            assert!(share < 0.6, "{predictor:?} {name}: {share}");
        }
    }
}

/// Returns the file without a skin's tangent coefficients.
fn without_coefficients(model: &[u8], skin: &str) -> Vec<u8> {
    let loaded = Model::from_bytes(model).unwrap();
    let skins = loaded.all::<Skin>().map(|s| SkinModel::from_file(&s));
    let skins = skins.map(|s| {
        let plain = s.name == skin;
        SkinModel { tangent_coefficients: s.tangent_coefficients.filter(|_| !plain), ..s }
    });
    let model = FileModel {
        space: loaded.space(),
        envelopes: loaded.all::<Envelope>().map(|e| EnvelopeModel::from_file(&e)).collect(),
        skins: skins.collect(),
        ..FileModel::default()
    };
    model.bake().unwrap()
}
