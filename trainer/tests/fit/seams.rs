//! Authored surfaces: texture seams stay invisible, hard edges stay hard.

use nalgebra::{Rotation3, Vector3};
use sinew_runtime::envelope::Predictor;
use sinew_runtime::format::Space;
use sinew_runtime::{Model, Skin};
use sinew_trainer::envelope::normals::TrueNormals;
use sinew_trainer::envelope::s3::ProxyCount;
use sinew_trainer::envelope::{Options, Predict, train};
use sinew_trainer::evaluate::{Character, Frames, evaluate, skin};
use sinew_trainer::examples::{Examples, Skeleton, Split};
use sinew_trainer::mesh::{Corners, EngineMesh};
use sinew_trainer::progress::Silent;

const FRAMES: usize = 16;
const IDENTITY: [[f64; 4]; 3] = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];

/// Bends a mesh along x from -1 to 1 about z, by two joints with smoothly blended weights.
fn bent(rest: Vec<[f64; 3]>, triangles: Vec<[usize; 3]>) -> Examples {
    let turn = |frame: usize| {
        let angle = 1.2 * (frame as f64 / FRAMES as f64 * 5.0).sin();
        Rotation3::from_axis_angle(&Vector3::z_axis(), angle)
    };
    let posed = |frame: usize| {
        let turn = turn(frame);
        let bend = move |x: &[f64; 3]| {
            let u = (0.5 + 0.6 * x[0]).clamp(0.0, 1.0);
            let share = u * u * (3.0 - 2.0 * u);
            let x = Vector3::from(*x);
            (x * (1.0 - share) + turn * x * share).into()
        };
        rest.iter().map(bend).collect::<Vec<_>>()
    };
    let rows = |turn: Rotation3<f64>| {
        std::array::from_fn(|r| std::array::from_fn(|c| if c < 3 { turn[(r, c)] } else { 0.0 }))
    };
    Examples {
        vertices: (0..FRAMES).flat_map(posed).collect(),
        rest: rest.clone(),
        triangles,
        engine: None,
        skeleton: Skeleton {
            names: vec!["root".into(), "tip".into()],
            parents: vec![None, Some(0)],
            rest: vec![IDENTITY; 2],
            ..Skeleton::default()
        },
        transforms: (0..FRAMES).flat_map(|frame| [IDENTITY, rows(turn(frame))]).collect(),
        curve_names: Vec::new(),
        curves: Vec::new(),
        split: (0..FRAMES)
            .map(|frame| if frame % 4 == 3 { Split::HeldOut } else { Split::Train })
            .collect(),
        ranges: Vec::new(),
        clip_starts: vec![0],
        space: Space::default(),
        joint_weights: None,
        importance: None,
        frame_weights: None,
        own_skin: false,
    }
}

const RINGS: usize = 10;
const STEPS: usize = 14;

/// Makes a sphere with one vertex per place, and a globe's texture coordinates at the corners of
/// its triangles.
fn sphere() -> (Examples, Vec<[f64; 2]>) {
    let mut rest = vec![[-1.0, 0.0, 0.0]];
    for ring in 1..RINGS {
        let along = std::f64::consts::PI * ring as f64 / RINGS as f64;
        for step in 0..STEPS {
            let around = std::f64::consts::TAU * step as f64 / STEPS as f64;
            rest.push([-along.cos(), along.sin() * around.cos(), along.sin() * around.sin()]);
        }
    }
    rest.push([1.0, 0.0, 0.0]);
    let last = rest.len() - 1;
    let number = |ring: usize, step: usize| match ring {
        0 => 0,
        RINGS => last,
        _ => 1 + (ring - 1) * STEPS + step % STEPS,
    };
    let uv = |ring: usize, step: usize| [step as f64 / STEPS as f64, ring as f64 / RINGS as f64];
    let (mut triangles, mut corners) = (Vec::new(), Vec::new());
    for ring in 0..RINGS {
        for step in 0..STEPS {
            for triangle in [
                [(ring, step), (ring + 1, step + 1), (ring + 1, step)],
                [(ring, step), (ring, step + 1), (ring + 1, step + 1)],
            ] {
                let vertices = triangle.map(|(ring, step)| number(ring, step));
                if vertices[0] != vertices[1] && vertices[1] != vertices[2] {
                    triangles.push(vertices);
                    corners.extend(triangle.map(|(ring, step)| uv(ring, step)));
                }
            }
        }
    }
    (bent(rest, triangles), corners)
}

fn model(examples: &Examples) -> Vec<u8> {
    let options = Options {
        predictor: Predict::Only(Predictor::Kernel),
        proxies: Some(ProxyCount::Fixed(6)),
        ..Options::default()
    };
    train(examples, &options, &Silent).unwrap().model
}

fn degrees(a: &Vector3<f64>, b: &Vector3<f64>) -> f64 {
    a.cross(b).norm().atan2(a.dot(b)).to_degrees()
}

#[test]
fn a_split_sphere_is_shaded_as_the_whole_one() {
    let (whole, uv) = sphere();
    let mut split = whole.clone();
    split.engine = Some(EngineMesh::of_corners(&whole.rest, &whole.triangles, uv));
    split.validate().unwrap();
    let surface = split.surface();
    // The seam from pole to pole, and one coordinate per triangle at each pole.
    let expected = whole.vertex_len() + (RINGS - 1) + 2 * (STEPS - 1);
    assert_eq!(surface.engine_len(), expected);
    assert_eq!(surface.normals(), surface.copied(&whole.surface().normals()));

    let (one, other) = (model(&whole), model(&split));
    let runtime = Model::from_bytes(&other[..]).unwrap();
    assert_eq!(runtime.first::<Skin>().unwrap().vertex_len(), expected);
    assert!(runtime.first::<Skin>().unwrap().has_tangents());
    let one = Character::open(&one, None, &whole).unwrap();
    let other_character = Character::open(&other, None, &split).unwrap();
    for frame in 0..FRAMES {
        let plain = skin(&one, &whole, frame).unwrap();
        let seamed = skin(&other_character, &split, frame).unwrap();
        for copy in 0..expected {
            let (a, b) = (plain.vertex(surface.copy_of(copy)), seamed.vertex(copy));
            assert_eq!(a.0, b.0, "copies stand where their vertex does");
            assert!(degrees(&a.1, &b.1) < 0.1, "{frame}, {copy}: {}", degrees(&a.1, &b.1));
        }
    }
    let figures = |model: &[u8], examples| {
        evaluate(model, None, examples, Frames::Of(Split::HeldOut)).unwrap()
    };
    let (a, b) = (figures(&model(&whole), &whole), figures(&other, &split));
    assert_eq!((a.errors.rms, a.lbs.rms), (b.errors.rms, b.lbs.rms));
    assert!((a.errors.normal_rms_degrees - b.errors.normal_rms_degrees).abs() < 0.05);
}

const CELLS: [usize; 3] = [12, 2, 2];

/// Makes a box along x with one vertex per place, and the normal of the side at each corner of its
/// triangles.
fn hard_box() -> (Examples, Vec<[f64; 3]>) {
    let mut numbers = std::collections::BTreeMap::new();
    let mut rest = Vec::new();
    let (mut triangles, mut normals) = (Vec::new(), Vec::new());
    for axis in 0..3 {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        for side in [0, CELLS[axis]] {
            for (a, b) in (0..CELLS[u]).flat_map(|a| (0..CELLS[v]).map(move |b| (a, b))) {
                let mut quad = [(a, b), (a + 1, b), (a + 1, b + 1), (a, b + 1)].map(|(a, b)| {
                    let mut cell = [0; 3];
                    (cell[axis], cell[u], cell[v]) = (side, a, b);
                    *numbers.entry(cell).or_insert_with(|| {
                        let at = |k: usize| 2.0 * cell[k] as f64 / CELLS[k] as f64 - 1.0;
                        rest.push([at(0), 0.3 * at(1), 0.2 * at(2)]);
                        rest.len() - 1
                    })
                });
                let mut normal = [0.0; 3];
                normal[axis] = if side == 0 { -1.0 } else { 1.0 };
                if side == 0 {
                    quad.reverse();
                }
                let [a, b, c, d] = quad;
                triangles.extend([[a, b, c], [a, c, d]]);
                normals.extend([normal; 6]);
            }
        }
    }
    (bent(rest, triangles), normals)
}

fn authored(examples: &Examples, normals: Vec<[f64; 3]>) -> EngineMesh {
    let vertices = examples.triangles.as_flattened().to_vec();
    let places: Vec<usize> = (0..vertices.len()).collect();
    let corners = Corners { vertices, normals: Some(normals), ..Corners::default() };
    corners.engine_mesh(&examples.rest, places.as_chunks().0).0
}

#[test]
fn a_box_keeps_its_hard_edges_in_every_pose() {
    let (mut examples, normals) = hard_box();
    examples.engine = Some(authored(&examples, normals));
    examples.validate().unwrap();
    let engine = examples.engine.clone().unwrap();
    let authored = engine.normals.as_ref().unwrap();
    // The eight corners have three normals each, the edges between them two.
    let edges = 4 * CELLS.iter().map(|cells| cells - 1).sum::<usize>();
    assert_eq!(engine.copy_of.len(), examples.vertex_len() + 2 * 8 + edges);
    let bytes = model(&examples);
    let character = Character::open(&bytes, None, &examples).unwrap();
    let truth = TrueNormals::new(examples.surface());
    for frame in examples.frames_of(Split::HeldOut) {
        let at = |v: usize| Vector3::from(examples.frame(frame)[v]);
        // The faces of each copy, found from its triangles.
        let mut expected = vec![Vector3::zeros(); engine.copy_of.len()];
        for (corners, triangle) in engine.triangles.iter().zip(&examples.triangles) {
            let [a, b, c] = triangle.map(at);
            corners.iter().for_each(|&corner| expected[corner] += (b - a).cross(&(c - a)));
        }
        let skinned = skin(&character, &examples, frame).unwrap();
        for (copy, truth) in truth.posed(examples.frame(frame)).into_iter().enumerate() {
            assert!((Vector3::from(truth) - expected[copy].normalize()).norm() < 1e-9);
            let found = skinned.vertex(copy).1;
            let off = degrees(&found, &expected[copy]);
            assert!(off < 45.0, "frame {frame}, copy {copy}: {off}, nearer to another side");
            // Copies with another normal stay perpendicular to it, as they are at rest.
            if copy > 0 && engine.copy_of[copy] == engine.copy_of[copy - 1] {
                assert!(authored[copy] != authored[copy - 1]);
                let between = degrees(&found, &skinned.vertex(copy - 1).1);
                assert!(between > 50.0, "frame {frame}, copy {copy}: {between}");
            }
        }
    }
    let found = evaluate(&bytes, None, &examples, Frames::Of(Split::HeldOut)).unwrap();
    println!("{:?}", found.errors);
    assert!(found.errors.normal_rms_degrees < 1.5, "{:?}", found.errors);
    assert!(found.vertices == engine.copy_of.len());
}

#[test]
fn normals_that_lean_go_with_the_surface() {
    let (mut examples, normals) = hard_box();
    // Artists bend the normals of a card toward those of a ball.
    let places = examples.triangles.as_flattened();
    let lean = |(normal, &vertex): (&[f64; 3], &usize)| {
        let [_, y, z] = examples.rest[vertex];
        (Vector3::from(*normal) + Vector3::new(0.0, y, z)).normalize().into()
    };
    let leaning = normals.iter().zip(places).map(lean).collect();
    examples.engine = Some(authored(&examples, leaning));
    let bytes = model(&examples);
    let model = Model::from_bytes(&bytes[..]).unwrap();
    let baked = model.first::<Skin>().unwrap();
    let engine = examples.engine.as_ref().unwrap();
    for (copy, normal) in engine.normals.as_ref().unwrap().iter().enumerate() {
        let found = baked.rest_normal(copy).unwrap().map(f64::from);
        assert!((Vector3::from(found) - Vector3::from(*normal)).norm() < 1e-6);
    }
    let found = evaluate(&bytes, None, &examples, Frames::Of(Split::HeldOut)).unwrap();
    println!("{:?}", found.errors);
    assert!(found.errors.normal_rms_degrees < 1.5, "{:?}", found.errors);
    assert!(found.lbs.normal_rms_degrees > 2.0 * found.errors.normal_rms_degrees);
}

#[test]
fn named_ranges_hold_all_copies() {
    let (mut examples, uv) = sphere();
    let (half, len) = (50, examples.vertex_len());
    examples.ranges = vec![("low".to_owned(), 0..half), ("high".to_owned(), half..len)];
    examples.engine = Some(EngineMesh::of_corners(&examples.rest, &examples.triangles, uv));
    let bytes = model(&examples);
    let model = Model::from_bytes(&bytes[..]).unwrap();
    let surface = examples.surface();
    for (name, range) in model.first::<Skin>().unwrap().ranges() {
        let own = if name == "low" { 0..half } else { half..len };
        for copy in 0..surface.engine_len() {
            assert_eq!(range.contains(&copy), own.contains(&surface.copy_of(copy)));
        }
    }
}
