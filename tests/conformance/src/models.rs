//! Models under test: random ones of every shape, the demo character, and a real arm.

use crate::backend::Loaded;
use ::models::{Content, Pieces, eights, halves};
use faer::{Mat, MatRef};
use nalgebra::{Matrix3, UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sinew_runtime::envelope::{Certificate, GroupKernel, HelperKind, Predictor, STRAIN_LEN};
use sinew_runtime::format::SectionKind;
use sinew_trainer::envelope::model::{
    Curve, EnvelopeModel, FeatureOrder, FileModel, Group, Input, Key, Reconstruction, Shapes,
    Shear, SkinModel,
};
use sinew_trainer::envelope::s3::ProxyCount;
use sinew_trainer::envelope::{Options, Predict, train};
use sinew_trainer::examples::demo::{DemoOptions, demo};
use sinew_trainer::examples::{Examples, Skeleton, npz};
use sinew_trainer::numeric::trs::Place;
use sinew_trainer::progress::Silent;
use sinew_trainer::regression::confidence::MapConfidence;
use sinew_trainer::regression::map::KernelMap;
use std::path::Path;
use std::sync::OnceLock;

/// Counts of a random model.
#[derive(Clone, Copy, Debug)]
pub struct Shape {
    /// The predictor of the palette.
    pub predictor: Predictor,
    /// V.
    pub vertices: usize,
    /// J.
    pub joints: usize,
    /// P; an odd number leaves half of the last block of rows unused.
    pub proxies: usize,
    /// K.
    pub influences: usize,
    /// Whether the skin has tangents.
    pub tangents: bool,
    /// Whether the skin has tangent coefficients.
    pub coefficients: bool,
    /// Whether joints stretch.
    pub stretches: bool,
    /// C.
    pub curves: usize,
    /// Kind of the helpers.
    pub kind: HelperKind,
}

impl Shape {
    const fn new(predictor: Predictor, counts: [usize; 4], tangents: bool) -> Self {
        let [vertices, joints, proxies, influences] = counts;
        Self {
            predictor,
            vertices,
            joints,
            proxies,
            influences,
            tangents,
            coefficients: false,
            stretches: false,
            curves: 0,
            kind: HelperKind::Affine,
        }
    }

    const fn with_coefficients(self) -> Self {
        Self { coefficients: true, ..self }
    }

    const fn stretching(self) -> Self {
        Self { stretches: true, ..self }
    }

    const fn of_kind(self, kind: HelperKind) -> Self {
        Self { kind, ..self }
    }

    const fn with_curves(self, curves: usize) -> Self {
        Self { curves, ..self }
    }

    /// Returns the order of the features.
    pub const fn feature_order(self) -> FeatureOrder {
        FeatureOrder { joint_len: self.joints, stretches: self.stretches }
    }

    /// Returns the number of features.
    pub const fn feature_len(self) -> usize {
        let each = if self.stretches { 12 + STRAIN_LEN } else { 12 };
        each * self.joints + self.curves
    }
}

/// Odd counts, one and zero wherever they are allowed. The first shape with a correction has six
/// groups. Shapes with one joint and without joints follow curves too.
pub const SHAPES: [Shape; 22] = [
    Shape::new(Predictor::Rotational, [37, 6, 5, 4], true),
    Shape::new(Predictor::Rotational, [61, 3, 8, 3], false),
    Shape::new(Predictor::Rotational, [1, 1, 1, 1], true),
    Shape::new(Predictor::Rotational, [2, 2, 3, 7], true).with_coefficients(),
    Shape::new(Predictor::Rotational, [0, 2, 1, 2], true),
    Shape::new(Predictor::Kernel, [37, 6, 9, 4], true),
    Shape::new(Predictor::Kernel, [3, 2, 0, 2], true),
    Shape::new(Predictor::Kernel, [1, 1, 1, 1], true),
    Shape::new(Predictor::Kernel, [0, 2, 1, 2], false),
    Shape::new(Predictor::Kernel, [5, 2, 2, 3], false).with_coefficients(),
    Shape::new(Predictor::Kernel, [0, 1, 1, 1], true),
    Shape::new(Predictor::Rotational, [41, 6, 5, 4], true).with_coefficients(),
    Shape::new(Predictor::Kernel, [67, 6, 9, 4], false).with_coefficients(),
    Shape::new(Predictor::Rotational, [43, 6, 5, 4], true).stretching(),
    Shape::new(Predictor::Rotational, [4, 1, 2, 2], false).stretching(),
    Shape::new(Predictor::Kernel, [47, 6, 9, 4], true).stretching().with_curves(9),
    Shape::new(Predictor::Kernel, [6, 1, 3, 2], false).stretching().with_curves(1),
    Shape::new(Predictor::Kernel, [53, 0, 9, 4], true).with_coefficients().with_curves(11),
    Shape::new(Predictor::Kernel, [7, 3, 4, 3], false).with_curves(5),
    Shape::new(Predictor::Kernel, [59, 6, 9, 4], true).of_kind(HelperKind::Trs),
    Shape::new(Predictor::Kernel, [39, 6, 9, 4], false).stretching().of_kind(HelperKind::Trs),
    Shape::new(Predictor::Kernel, [9, 3, 4, 3], false).of_kind(HelperKind::Rigid),
];

/// Returns the first shape of a predictor.
///
/// # Panics
/// If there is none.
pub fn shape_of(predictor: Predictor) -> Shape {
    let mut shapes = SHAPES.into_iter().filter(|shape| shape.predictor == predictor);
    shapes.next().expect("every predictor has a shape")
}

/// Returns the first shape of a predictor whose joints stretch.
///
/// # Panics
/// If there is none.
pub fn stretching_shape_of(predictor: Predictor) -> Shape {
    let is_it = |shape: &Shape| shape.predictor == predictor && shape.stretches;
    SHAPES.into_iter().find(is_it).expect("every predictor has a shape whose joints stretch")
}

/// Returns the model of each shape, baked once in a process.
///
/// # Panics
/// If the bake refuses a model.
pub fn shapes() -> &'static [Vec<u8>; SHAPES.len()] {
    static MODELS: OnceLock<[Vec<u8>; SHAPES.len()]> = OnceLock::new();
    MODELS.get_or_init(|| SHAPES.map(random))
}

/// Bakes a model of random keys, coefficients and weights whose rest pose gives the rest mesh: the
/// root's blocks of c2 cancel the sum of the others, and corrections are 0 at rest.
///
/// # Panics
/// If the bake refuses the model.
pub fn random(shape: Shape) -> Vec<u8> {
    let groups = if shape.predictor.corrects() { groups(shape) } else { Vec::new() };
    let ranges = (0..shape.joints).map(|joint| [1.5, 0.5, 3.0, 1.0][joint % 4]);
    random_with(shape, groups, ranges.collect())
}

/// Bakes a model as [`random`] does, with the given groups and the given ranges of the joints, in
/// radians.
///
/// # Panics
/// If the bake refuses the model.
pub fn random_with(shape: Shape, groups: Vec<Group>, pose_ranges: Vec<f64>) -> Vec<u8> {
    let Shape { predictor, vertices, joints, proxies, influences, tangents, .. } = shape;
    let mut random = ChaCha8Rng::seed_from_u64(vertices as u64);
    let mut within = |size: f64| random.random_range(-size..=size);
    let root = joints / 2;
    // A chain up from the root, and a chain down.
    let parent = |joint: usize| match joint.cmp(&root) {
        std::cmp::Ordering::Less => Some(joint + 1),
        std::cmp::Ordering::Equal => None,
        std::cmp::Ordering::Greater => Some(joint - 1),
    };
    let c1: Vec<_> = (0..12 * proxies * proxies).map(|_| within(0.5)).collect();
    let mut c2: Vec<_> = (0..16 * proxies * joints).map(|_| within(0.5)).collect();
    let row_len = if joints > 0 { 4 * proxies } else { 0 };
    for row in 0..row_len {
        let (d, q) = (&c1[3 * proxies * row..][..3 * proxies], 4 * joints * row);
        for axis in 0..3 {
            let own = c2[q..q + 4 * joints].iter().skip(axis).step_by(4).sum::<f64>();
            let sum = own + d.iter().skip(axis).step_by(3).sum::<f64>();
            c2[q + 4 * root + axis] += f64::from(u8::from(row % 4 == axis)) - sum;
        }
    }
    let mut matrix = |size: f64| [(); 3].map(|()| [(); 3].map(|()| within(size)));
    let keys = (0..proxies).map(|l| Key {
        joint: (l + 1) % joints.max(1),
        twist: by_rows(matrix(1.0)),
        residual: (l % 2 == 0).then(|| (l % joints.max(1), by_rows(matrix(0.5)))),
        shear: {
            let mut entries = || [(); 36].map(|()| matrix(0.2)[0][0]);
            let (h, g) = (entries(), if shape.stretches { entries() } else { [0.0; 36] });
            Shear::from_fn(|r, c| if c < 6 { h[6 * r + c] } else { g[6 * r + c - 6] })
        },
    });
    let reconstruction = Reconstruction {
        keys: keys.collect(),
        c1: row_major(&c1, 4 * proxies, 3 * proxies),
        c2: row_major(&c2, 4 * proxies, 4 * joints),
    };
    // Some joints never stretch, and the ranges of curves need not hold 0.
    let stretch_range = |joint: usize| [0.5, 0.0, 2.0][joint % 3];
    let curve = |curve: usize| Curve {
        name: format!("curve {curve}"),
        range: [[0.0, 1.0], [-1.0, 1.0], [0.25, 0.5], [0.0, 0.0]][curve % 4],
    };
    let turned = |x: f64| UnitQuaternion::from_euler_angles(x, 2.0 * x, 3.0 * x);
    let at = |v: usize| v as f64 + 0.5;
    let unit = |v: usize| (turned(at(v)) * Vector3::z()).into();
    let tangent = |v: usize| {
        let [x, y, z] = (turned(at(v)) * Vector3::x()).into();
        [x, y, z, if v.is_multiple_of(3) { -1.0 } else { 1.0 }]
    };
    let palette_len = if predictor.reconstructs() { proxies } else { joints + proxies };
    let weights = |v: usize| {
        // The last vertex follows a single proxy.
        let len = if v + 1 == vertices { 1 } else { influences };
        (0..len).map(|k| ((v + k) % palette_len, 1.0 / (k + 1) as f64)).collect()
    };
    let frame = |joint: usize| {
        let m = turned(joint as f64).to_rotation_matrix();
        [0, 1, 2].map(|r| [m[(r, 0)], m[(r, 1)], m[(r, 2)], 0.7 * (joint + r) as f64])
    };
    let skin = SkinModel {
        name: "random".to_owned(),
        envelope: Some(0),
        rest_positions: (0..vertices).map(|_| matrix(2.0)[0]).collect(),
        rest_normals: (0..vertices).map(unit).collect(),
        rest_tangents: tangents.then(|| (0..vertices).map(tangent).collect()),
        influences: (0..vertices).map(weights).collect(),
        tangent_coefficients: None,
        normal_errors: None,
        ranges: Vec::new(),
        shapes: Shapes::default(),
    };
    let place = |l: usize| Place::at([0.3 * l as f64, 0.5, -0.2]);
    let envelope = EnvelopeModel {
        name: "random".to_owned(),
        skeleton: Skeleton {
            names: (0..joints).map(|joint| format!("joint {joint}")).collect(),
            parents: (0..joints).map(parent).collect(),
            rest: (0..joints).map(frame).collect(),
            is_still: joints == 0,
            ..Skeleton::default()
        },
        reconstruction: predictor.reconstructs().then_some(reconstruction),
        groups,
        helper_kind: shape.kind,
        places: (0..proxies).map(place).collect(),
        pose_ranges,
        pose_gaps: vec![0.0; joints],
        stretch_ranges: shape.stretches.then(|| (0..joints).map(stretch_range).collect()),
        curves: (0..shape.curves).map(curve).collect(),
        certificate: Certificate {
            diagonal: 4.0,
            training_rms: 0.0,
            same_clips_rms: 0.0,
            lbs_training_rms: 0.0,
            correction_error: 0.0,
            base_training_rms: 0.0,
            other_clip_rms: None,
            trs_error: 0.0,
        },
    };
    let model = FileModel { envelopes: vec![envelope], skins: vec![skin], ..Default::default() };
    let baked = model.bake().expect("a random model can be baked");
    if shape.coefficients { with_coefficients(&baked, 4.0) } else { baked }
}

/// Gives the skin of a file random tangent coefficients up to `size`, some of them 0, replacing any
/// that it has.
///
/// # Panics
/// If the file has no skin.
pub fn with_coefficients(file: &[u8], size: f64) -> Vec<u8> {
    let mut pieces = Pieces::of(file).expect("a sound file");
    let skin = Loaded::new(file).skin;
    let mut random = ChaCha8Rng::seed_from_u64(skin.vertex_len() as u64);
    let mut half = || match half_of(random.random_range(-size..=size)) {
        bits if bits % 7 == 3 => bits & 0x8000,
        bits => bits,
    };
    let len = 2 * skin.vertex_len() * (skin.influence_len() - 1);
    let bits: Vec<u16> = (0..len).map(|_| half()).collect();
    let (part, kind) = (skin.part() as u16, SectionKind::TangentCoefficients);
    pieces.sections.retain(|own| (own.part, own.kind) != (part, kind.number()));
    let bytes = eights(&halves(&bits), skin.influence_len() - 1, 4);
    pieces.sections.push(Content { flags: 0, ..Content::new(kind, part, bytes) });
    pieces.bytes()
}

/// Rounds a number toward 0 to half precision; 0 where that would be subnormal.
fn half_of(x: f64) -> u16 {
    let bits = (x as f32).to_bits();
    let (sign, exponent) = ((bits >> 16) as u16 & 0x8000, (bits >> 23 & 0xff) as u16);
    let mantissa = (bits >> 13) as u16 & 0x3ff;
    if exponent < 113 { sign } else { sign | (((exponent - 112) << 10) + mantissa) }
}

/// Returns a matrix from its rows.
fn by_rows(rows: [[f64; 3]; 3]) -> Matrix3<f64> {
    Matrix3::from_fn(|r, c| rows[r][c])
}

/// Returns a matrix from its rows, one after another.
pub fn row_major(values: &[f64], rows: usize, columns: usize) -> Mat<f64> {
    MatRef::from_row_major_slice(values, rows, columns).to_owned()
}

/// Makes random groups of one proxy, two, one, and so on until there are P, each with another
/// kernel. The first group's outputs are its latent values, one at a time. The fourth has one of
/// everything, the fifth has no centres, and the last is large.
fn groups(shape: Shape) -> Vec<Group> {
    let Shape { predictor, joints, proxies, .. } = shape;
    let order = shape.feature_order();
    let first = usize::from(predictor.number());
    let mut random = ChaCha8Rng::seed_from_u64((proxies + first) as u64);
    let mut list = |len: usize, size: f64| -> Vec<_> {
        (0..len).map(|_| random.random_range(-size..=size)).collect()
    };
    let mut out = Vec::new();
    let mut left = proxies;
    while left > 0 {
        let g = out.len();
        let own = left.min(1 + g % 2);
        left -= own;
        let [d, n, r] = match g {
            3 => [1, 1, 1],
            4 => [0, 0, 0],
            _ if left == 0 => [33, 41, 17],
            _ => [5 + 2 * g, 13 - 2 * g, 11 - 2 * g],
        };
        // Each latent value separately, or all of them mixed.
        let picked = (0..12 * own * r).map(|i| f64::from(u8::from(i / r % r == i % r)));
        let feature = |i: usize| order.feature((7 * i + 12 * (g + 1)) % shape.feature_len());
        let inputs = (0..d).map(|i| Input { feature: feature(i), weight: list(1, 1.0)[0] });
        let inputs = inputs.collect();
        // Centre by centre, one column each.
        let centres = list(n * d, 0.6);
        let coefficients = list((r + 3) * (n + d), 0.5);
        let outputs = if g == 0 { picked.collect() } else { list(12 * own * r, 0.2) };
        out.push(Group {
            joint: g % joints.max(1),
            proxies: proxies - left - own..proxies - left,
            inputs,
            map: KernelMap {
                kernel: GroupKernel::ALL[(first + g) % GroupKernel::ALL.len()],
                centres: Mat::from_fn(d, n, |i, k| centres[k * d + i]),
                coefficients: row_major(&coefficients, r + 3, n + d),
                confidence: MapConfidence {
                    len: 3,
                    reach: 0.2 * d as f64,
                    linear: 0.5,
                    signal: 4.0,
                    noise: 40.0,
                },
            },
            outputs: row_major(&outputs, 12 * own, r),
        });
    }
    out
}

/// Returns examples of the demo character with few poses.
pub fn demo_examples(vertices: usize) -> Examples {
    demo(&DemoOptions { vertices, poses: 60, held_out: 0, seed: 1 })
}

/// Returns the demo character of about 300 vertices, trained with 13 proxies for each predictor,
/// once in a process.
///
/// # Panics
/// If the training fails.
pub fn trained() -> &'static [Vec<u8>; 2] {
    static MODELS: OnceLock<[Vec<u8>; 2]> = OnceLock::new();
    MODELS.get_or_init(|| fit(&demo_examples(300)))
}

/// Returns a real arm, trained as [`trained`]; `None` if the data is missing beside the repository.
///
/// # Panics
/// If the training fails, or if `CI` is set and the data is missing.
pub fn arm() -> Option<&'static [Vec<u8>; 2]> {
    static MODELS: OnceLock<Option<[Vec<u8>; 2]>> = OnceLock::new();
    let models = MODELS.get_or_init(|| {
        let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
        if !data.is_dir() {
            assert!(std::env::var_os("CI").is_none(), "CI is set, but there is no {data:?}");
            eprintln!("not run on the real arm: there is no {}", data.display());
            return None;
        }
        let mut examples = npz::load(&data.join("mpfb-arm/mpfb_arm.npz"))
            .expect("the real arm can be loaded")
            .examples;
        keep_frames(&mut examples, 60);
        Some(fit(&examples))
    });
    models.as_ref()
}

/// Returns the trained character of the kernel predictor with random tangent coefficients: weights
/// change by up to 30 over the diagonal.
///
/// # Panics
/// As [`trained`].
pub fn turned() -> &'static [u8] {
    static MODEL: OnceLock<Vec<u8>> = OnceLock::new();
    MODEL.get_or_init(|| {
        let file = &trained()[1];
        let diagonal = Loaded::new(file).envelope.certificate().diagonal;
        with_coefficients(file, 30.0 / f64::from(diagonal))
    })
}

fn fit(examples: &Examples) -> [Vec<u8>; 2] {
    Predictor::ALL.map(|predictor| {
        let proxies = Some(ProxyCount::Fixed(13));
        let predictor = Predict::Only(predictor);
        let options = Options { predictor, proxies, ..Options::default() };
        train(examples, &options, &Silent).expect("the training succeeds").model
    })
}

/// Keeps the first `count` frames.
fn keep_frames(examples: &mut Examples, count: usize) {
    examples.vertices.truncate(count * examples.vertex_len());
    examples.transforms.truncate(count * examples.joint_len());
    examples.curves.truncate(count * examples.curve_names.len());
    examples.split.truncate(count);
}
