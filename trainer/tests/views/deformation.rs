//! Lends the motion of one head to other heads, and compares the result with the true motion of those heads.

use super::common::{apart, head, points, rms, turned};
use models::shared;
use npyz::NpyFile;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sinew_trainer::views::fit::{FitOptions, fit};
use sinew_trainer::views::object::{Deformation, Deformations, centred};
use std::fs::File;
use zip::ZipArchive;

/// Pixels per unit of the heads' mesh.
const SCALE: f64 = 256.0 / 30.0;
/// Largest RMS error, over that of the prototype's own points.
const OVER_PROTOTYPE: f64 = 0.5;
/// Expressions in the pictures: smile and open jaw.
const EXPRESSIONS: [[f64; 2]; 4] = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]];

/// Points of the heads in space: the neutral face, the two expressions, and the identities.
struct Heads {
    neutral: Vec<[f64; 3]>,
    expressions: [Vec<[f64; 3]>; 2],
    identities: Vec<Vec<[f64; 3]>>,
}

fn heads() -> Option<Heads> {
    let (file, views) = (shared("ict-facekit/ict_head.npz")?, shared("ict-views/views.json")?);
    let views: serde_json::Value = serde_json::from_slice(&std::fs::read(views).unwrap()).unwrap();
    let vertices: Vec<usize> = serde_json::from_value(views["mesh_vertex_index"].clone()).unwrap();
    let mut zip = ZipArchive::new(File::open(file).unwrap()).unwrap();
    let names: Vec<String> =
        NpyFile::new(zip.by_name("expression_names.npy").unwrap()).unwrap().into_vec().unwrap();
    let mut shapes = |name: &str| {
        let array = NpyFile::new(zip.by_name(&format!("{name}.npy")).unwrap()).unwrap();
        let all: Vec<f32> = array.into_vec().unwrap();
        let of = |mesh: &[f32]| {
            let vertex = |&v: &usize| [0, 1, 2].map(|axis| f64::from(mesh[3 * v + axis]));
            vertices.iter().map(vertex).collect::<Vec<_>>()
        };
        all.chunks(3 * 11_248).map(of).collect::<Vec<_>>()
    };
    let (neutral, deltas, identities) =
        (shapes("neutral").remove(0), shapes("expression_deltas"), shapes("identity_deltas"));
    let named = |name: &str| &deltas[names.iter().position(|other| other == name).unwrap()];
    let smile = sum(named("mouthSmile_L"), named("mouthSmile_R"), 1.0);
    Some(Heads { neutral, expressions: [smile, named("jawOpen").clone()], identities })
}

fn sum(a: &[[f64; 3]], b: &[[f64; 3]], weight: f64) -> Vec<[f64; 3]> {
    a.iter().zip(b).map(|(a, b)| [0, 1, 2].map(|axis| a[axis] + weight * b[axis])).collect()
}

impl Heads {
    /// Makes a head of the coefficients of an identity, in an expression, and projects it. Subtracts the barycentre.
    fn seen(&self, identity: &[f64], expression: [f64; 2], yaw: f64, pitch: f64) -> Vec<[f64; 2]> {
        let mut mesh = self.neutral.clone();
        for (delta, weight) in self.identities.iter().zip(identity) {
            mesh = sum(&mesh, delta, *weight);
        }
        for (delta, weight) in self.expressions.iter().zip(expression) {
            mesh = sum(&mesh, delta, weight);
        }
        let point = |p: &[f64; 3]| {
            let [x, y, _] = turned(*p, yaw, pitch);
            [SCALE * x, -SCALE * y]
        };
        centred(&mesh.iter().map(point).collect::<Vec<_>>()).0
    }
}

/// Returns numbers of the standard normal distribution, by Box and Muller.
fn normal(seed: u64, len: usize) -> Vec<f64> {
    let mut stream = ChaCha8Rng::seed_from_u64(seed);
    let mut one = || {
        let (u, v): (f64, f64) =
            (stream.random_range(f64::EPSILON..1.0), stream.random_range(0.0..1.0));
        (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * v).cos()
    };
    (0..len).map(|_| one()).collect()
}

#[test]
fn other_heads_move_nearer_to_themselves_than_to_the_prototype() {
    let (Some(set), Some(heads)) = (head(), heads()) else { return };
    let examples = &set.maps[0];
    for view in &examples.train {
        let of = |name: &str| view.values[name];
        let seen = heads.seen(&[], [of("smile"), of("jawOpen")], of("yaw"), of("pitch"));
        let off = rms(&apart(&seen, &centred(&view.known()).0));
        assert!(off < 0.001, "the camera is that of the pictures: {off}");
    }
    let map = fit(examples, &[], FitOptions::default()).unwrap();
    let at = |expression: [f64; 2], yaw: f64, pitch: f64| {
        let values =
            [("yaw", yaw), ("pitch", pitch), ("smile", expression[0]), ("jawOpen", expression[1])];
        points(&map, &values.map(|(name, value)| (name.to_owned(), value)).into())
    };
    let front = at(EXPRESSIONS[0], 0.0, 0.0);
    for by_size in [false, true] {
        let (mut own, mut prototype) = (Vec::new(), Vec::new());
        for seed in [1, 2, 3] {
            let identity = normal(seed, heads.identities.len());
            let instance = heads.seen(&identity, EXPRESSIONS[0], 0.0, 0.0);
            let keys = vec![Deformation::new(&front, &instance, by_size)];
            let deformations = Deformations { keys };
            for yaw in [-30.0, -15.0, 0.0, 15.0, 30.0] {
                for pitch in [-15.0, 0.0, 15.0] {
                    for expression in EXPRESSIONS {
                        let truth = heads.seen(&identity, expression, yaw, pitch);
                        let moved = at(expression, yaw, pitch);
                        let found = centred(&deformations.moved(&moved, &[1.0])).0;
                        own.extend(apart(&found, &truth));
                        prototype.extend(apart(&centred(&moved).0, &truth));
                    }
                }
            }
        }
        let share = rms(&own) / rms(&prototype);
        println!("by size {by_size}: {:.3} px of {:.3}: {share:.3}", rms(&own), rms(&prototype));
        assert!(share <= OVER_PROTOTYPE, "{share}");
    }
}
