//! The golden files, and hashes of every stage over seeded poses, which are equal on all CPUs.
//!
//! A module of the runtime's tests and of `tests/firmware`: no standard library, no allocation.

#[cfg(feature = "filter")]
#[path = "filters.rs"]
pub(crate) mod filters;
#[cfg(feature = "kernel")]
#[path = "kernels.rs"]
pub(crate) mod kernels;
#[cfg(feature = "prior")]
#[path = "priors.rs"]
pub(crate) mod priors;
#[path = "rng.rs"]
#[allow(unreachable_pub, reason = "other tests export it")]
mod rng;
#[cfg(feature = "views")]
#[path = "views.rs"]
pub(crate) mod views;

pub(crate) use rng::Rng;

#[cfg(feature = "shapes")]
use sinew_runtime::ShapesJob;
use sinew_runtime::envelope::{Predictor, STRAIN_LEN};
use sinew_runtime::skin::Output;
use sinew_runtime::{
    CallError, Envelope, LocalTransform, Matrix3x4, Skin, SkinJob, model_space_pose, stages,
};

/// A golden file, and a hash for each of its stages.
pub(crate) struct Golden {
    pub(crate) name: &'static str,
    pub(crate) predictor: Predictor,
    pub(crate) file: &'static [u8],
    pub(crate) bits: [u64; STAGES.len()],
}

/// Names of the stages. "palette" is the palette before the correction; "correction" is the
/// corrected palette with the confidence.
pub(crate) const STAGES: [&str; 9] =
    ["pose", "polar", "gradients", "palette", "features", "correction", "skin", "bounds", "shapes"];

/// The promise of METHOD §7: change these hashes only with a reason that the commit states.
pub(crate) const GOLDEN: [Golden; 9 + 2 * cfg!(feature = "trs") as usize] = [
    Golden {
        name: "rotational",
        predictor: Predictor::Rotational,
        file: include_bytes!("envelope-11-rotational.snw"),
        bits: [
            0x97d3_d7f7_0f77_bf91,
            0,
            0x831c_b019_d3a8_7b88,
            0xe00f_aad0_a34d_6eea,
            0,
            0x4cbe_b5e8_df9b_9055,
            0x77f4_986f_3187_1df9,
            0x6d26_a0d8_2bfc_0717,
            0,
        ],
    },
    Golden {
        name: "kernel",
        predictor: Predictor::Kernel,
        file: include_bytes!("envelope-11-kernel.snw"),
        bits: [
            0x97d3_d7f7_0f77_bf91,
            0,
            0,
            0x9c1e_3aa2_f08f_9a1b,
            0x2916_af47_4df4_8a71,
            0x1754_062f_3d14_41b2,
            0x08b0_e957_9048_db76,
            0xa59c_90df_1c04_726d,
            0,
        ],
    },
    Golden {
        name: "rotational that stretches",
        predictor: Predictor::Rotational,
        file: include_bytes!("envelope-11-stretch-rotational.snw"),
        bits: [
            0x7f86_2534_1c7e_685e,
            0x0a4f_a87a_737f_321a,
            0x3c0c_6e7c_83bf_3575,
            0x5c91_1e72_934f_9064,
            0,
            0x2586_2591_012d_f3bc,
            0xd4b2_161e_91be_d7e6,
            0xc2ea_6e20_2328_0ce5,
            0,
        ],
    },
    Golden {
        name: "kernel that stretches",
        predictor: Predictor::Kernel,
        file: include_bytes!("envelope-11-stretch.snw"),
        bits: [
            0x7f86_2534_1c7e_685e,
            0x0a4f_a87a_737f_321a,
            0,
            0x79e3_0df3_74d3_4bd6,
            0xb87e_13ae_6f19_11ab,
            0x0d7e_1269_52f1_2e20,
            0x216d_b8bf_783b_eff3,
            0xf50f_872a_f68b_ca5f,
            0,
        ],
    },
    #[cfg(feature = "trs")]
    Golden {
        name: "kernel with helpers of kind trs",
        predictor: Predictor::Kernel,
        file: include_bytes!("envelope-11-trs.snw"),
        bits: [
            0x7f86_2534_1c7e_685e,
            0x0a4f_a87a_737f_321a,
            0,
            0x79e3_0df3_74d3_4bd6,
            0xb87e_13ae_6f19_11ab,
            0xe045_c8c1_2d7f_8cba,
            0x6f42_7a65_0a8c_94e2,
            0xd2cb_6398_6d22_b59b,
            0,
        ],
    },
    #[cfg(feature = "trs")]
    Golden {
        name: "kernel with rigid helpers",
        predictor: Predictor::Kernel,
        file: include_bytes!("envelope-11-rigid.snw"),
        bits: [
            0x97d3_d7f7_0f77_bf91,
            0,
            0,
            0x9c1e_3aa2_f08f_9a1b,
            0x2916_af47_4df4_8a71,
            0xfd9a_446b_6acc_2ded,
            0xaf9d_fb4c_52fd_bf43,
            0x8976_7e4a_0ac2_3201,
            0,
        ],
    },
    Golden {
        name: "tangents",
        predictor: Predictor::Kernel,
        file: include_bytes!("skin-11-tangents.snw"),
        bits: [
            0x6d8f_7764_86bf_b108,
            0,
            0,
            0x8d6c_ffdd_2431_e4fa,
            0xa510_c250_0cb1_ed06,
            0xecc2_13b7_e835_d2ed,
            0xccd1_2d54_62f8_d227,
            0x286f_7268_0a47_4cc9,
            0,
        ],
    },
    Golden {
        name: "normals",
        predictor: Predictor::Kernel,
        file: include_bytes!("skin-11-normals.snw"),
        bits: [
            0x6d8f_7764_86bf_b108,
            0,
            0,
            0x8d6c_ffdd_2431_e4fa,
            0xa510_c250_0cb1_ed06,
            0xecc2_13b7_e835_d2ed,
            0xf8a2_c076_4f40_3bed,
            0x8970_398c_92ad_329b,
            0,
        ],
    },
    Golden {
        name: "shapes of f32",
        predictor: Predictor::Kernel,
        file: include_bytes!("shapes-11-f32.snw"),
        bits: [
            0x6d8f_7764_86bf_b108,
            0,
            0,
            0x8d6c_ffdd_2431_e4fa,
            0xa510_c250_0cb1_ed06,
            0xecc2_13b7_e835_d2ed,
            0x8714_f13e_f107_7653,
            0x6689_66c2_fdd3_7b70,
            0xf97a_025f_a801_df32,
        ],
    },
    Golden {
        name: "shapes of f16",
        predictor: Predictor::Kernel,
        file: include_bytes!("shapes-11-f16.snw"),
        bits: [
            0x6d8f_7764_86bf_b108,
            0,
            0,
            0x8d6c_ffdd_2431_e4fa,
            0xa510_c250_0cb1_ed06,
            0xecc2_13b7_e835_d2ed,
            0x3038_bc3d_f461_91e1,
            0x6689_66c2_fdd3_7b70,
            0x5744_5b8b_cf1b_134f,
        ],
    },
    Golden {
        name: "shapes of i8",
        predictor: Predictor::Kernel,
        file: include_bytes!("shapes-11-i8.snw"),
        bits: [
            0x6d8f_7764_86bf_b108,
            0,
            0,
            0x8d6c_ffdd_2431_e4fa,
            0xa510_c250_0cb1_ed06,
            0xecc2_13b7_e835_d2ed,
            0x2fc0_eef6_92dd_1bf2,
            0x6689_66c2_fdd3_7b70,
            0xb3df_8d14_1998_58ad,
        ],
    },
];

/// Poses per hash.
pub(crate) const POSES: usize = 1024;

const JOINTS: usize = 24;
const PROXIES: usize = 24;
const VERTICES: usize = 1000;
const SHAPES: usize = 16;
const CURVES: usize = 8;

/// Room for every array of a frame, filled with zeros.
pub(crate) struct Memory {
    pub(crate) local: [LocalTransform; JOINTS],
    pub(crate) pose: [Matrix3x4; JOINTS],
    pub(crate) palette: [Matrix3x4; JOINTS + PROXIES],
    pub(crate) scratch: [f32; 1024],
    pub(crate) skin: [f32; 10 * VERTICES],
    weights: [f32; SHAPES],
    relative: [[f32; 3]; 4 * JOINTS],
    rotations: [[f32; 3]; JOINTS],
    gradients: [[f32; 3]; 3 * PROXIES],
    turns: [[[f32; 3]; 3]; JOINTS],
    /// Features, or only the strains of a rotational model.
    features: [f32; (12 + STRAIN_LEN) * JOINTS + CURVES],
    curves: [f32; CURVES],
}

impl Memory {
    pub(crate) const fn new() -> Self {
        Self {
            local: [LocalTransform { rotation: [0.0; 4], translation: [0.0; 3] }; JOINTS],
            pose: [[[0.0; 4]; 3]; JOINTS],
            palette: [[[0.0; 4]; 3]; JOINTS + PROXIES],
            scratch: [0.0; 1024],
            skin: [0.0; 10 * VERTICES],
            weights: [0.0; SHAPES],
            relative: [[0.0; 3]; 4 * JOINTS],
            rotations: [[0.0; 3]; JOINTS],
            gradients: [[0.0; 3]; 3 * PROXIES],
            turns: [[[0.0; 3]; 3]; JOINTS],
            features: [0.0; (12 + STRAIN_LEN) * JOINTS + CURVES],
            curves: [0.0; CURVES],
        }
    }
}

/// Results of all poses.
pub(crate) struct Found {
    /// A hash per stage.
    pub(crate) bits: [u64; STAGES.len()],
    /// Number of poses whose confidence lies strictly between 0 and 1.
    pub(crate) faded: usize,
    /// Whether every float of the skin was finite.
    pub(crate) finite: bool,
}

/// Hashes the stages over seeded poses; `nudge` is added to numbers of each pose.
///
/// # Errors
/// Errors of the stages; a length error if the model does not fit in the memory.
pub(crate) fn hashes(
    envelope: Envelope<'_>,
    skin: Skin<'_>,
    poses: usize,
    nudge: f32,
    memory: &mut Memory,
) -> Result<Found, CallError> {
    let mut found = Found { bits: [0; STAGES.len()], faded: 0, finite: true };
    let (mut rng, mut weight, mut curve) = (Rng(2007), Rng(2010), Rng(2013));
    let mut stretch = Rng(2016);
    for i in 0..poses {
        // Small, usual and large rotations, so that every branch of the logarithm runs.
        let turn = [0.01, 0.3, 1.0, 8.0][i % 4];
        let local = cut(&mut memory.local, envelope.joint_len());
        local.iter_mut().for_each(|local| *local = rng.local(turn));
        if let Some(first) = local.first_mut() {
            first.translation[0] += nudge;
        }
        local.iter_mut().for_each(|local| local.rotation[0] += nudge);
        let weights = cut(&mut memory.weights, skin.shape_len());
        // From -1 to 2, with a few zeros.
        for out in weights {
            let number = weight.unit();
            *out = if number.abs() < 0.25 { 0.0 } else { number * 1.5 + 0.5 + nudge };
        }
        // Beyond the trained ranges too.
        let curves = cut(&mut memory.curves, envelope.curve_len());
        curves.iter_mut().for_each(|value| *value = 1.5 * curve.unit() + nudge);
        let pose = cut(&mut memory.pose, envelope.joint_len());
        model_space_pose(&envelope, cut(&mut memory.local, envelope.joint_len()), pose)?;
        if envelope.stretches() {
            stretch_all(&envelope, pose, [0.2, 0.2, 0.1, 0.5][i % 4], &mut stretch);
            // Every sixteenth pose hides a joint, every other one of them by a mirror.
            let hidden = pose.first_mut().filter(|_| i % 16 == 5);
            let scale = if i % 32 == 5 { 0.0 } else { -1.0 };
            hidden.into_iter().flatten().for_each(|row| row[0] *= scale);
        }
        frame(envelope, skin, memory, &mut found)?;
    }
    Ok(found)
}

/// Scales and shears the joints that stretched in training, by seeded numbers up to `size`.
fn stretch_all(envelope: &Envelope<'_>, pose: &mut [Matrix3x4], size: f32, rng: &mut Rng) {
    let joints = pose.iter_mut().enumerate();
    for (_, map) in joints.filter(|(joint, _)| envelope.stretch_range(*joint) > Some(0.0)) {
        let mut unit = || rng.unit() * size;
        let [x, y, z] = [1.0 + unit(), 1.0 + unit(), 1.0 + unit()];
        let [a, b, c] = [unit() * 0.5, unit() * 0.5, unit() * 0.5];
        for [p, q, r, _] in map {
            let row =
                [*p * x + *q * a + *r * b, *p * a + *q * y + *r * c, *p * b + *q * c + *r * z];
            [*p, *q, *r] = row;
        }
    }
}

/// Evaluates the pose in `memory`, and adds the result of each stage to its hash.
fn frame(
    envelope: Envelope<'_>,
    skin: Skin<'_>,
    memory: &mut Memory,
    found: &mut Found,
) -> Result<(), CallError> {
    let (v, j, p) = (skin.vertex_len(), envelope.joint_len(), envelope.proxy_len());
    let Found {
        bits: [posed, split, gradient, base, feature, corrected, skinned, bounded, shaped],
        ..
    } = found;
    let (pose, curves) =
        (&*cut(&mut memory.pose, j), &*cut(&mut memory.curves, envelope.curve_len()));
    add(posed, pose.as_flattened().as_flattened());
    let stretching = if envelope.stretches() { j } else { 0 };
    let turns = cut(&mut memory.turns, stretching);
    let features = cut(&mut memory.features, envelope.counts().feature_len());
    // The strains of a kernel model are features.
    let first = if envelope.predictor().corrects() { 12 * j } else { 0 };
    let strains = features.get_mut(first..first + STRAIN_LEN * stretching).unwrap_or_default();
    let strains = strains.as_chunks_mut::<STRAIN_LEN>().0;
    if stretching > 0 {
        stages::polar(&envelope, pose, turns, strains)?;
        add(split, turns.as_flattened().as_flattened());
        add(split, strains.as_flattened());
    }
    let turns = &*turns;
    let palette = cut(&mut memory.palette, envelope.palette_len());
    if envelope.predictor().reconstructs() {
        let (relative, rotations) =
            (cut(&mut memory.relative, 4 * j), cut(&mut memory.rotations, j));
        let d = cut(&mut memory.gradients, 3 * p);
        stages::gradients(&envelope, pose, (turns, &*strains), relative, rotations, d)?;
        let root = pose.get(envelope.root()).unwrap_or(&[[0.0; 4]; 3]);
        stages::palette(&envelope, root, relative, d, palette)?;
        add(gradient, relative.as_flattened());
        add(gradient, rotations.as_flattened());
        add(gradient, d.as_flattened());
    } else {
        stages::joints(&envelope, pose, palette)?;
    }
    add(base, palette.as_flattened().as_flattened());
    let confidence = if envelope.predictor().corrects() {
        stages::features(&envelope, pose, curves, turns, features)?;
        let scratch = cut(&mut memory.scratch, envelope.correction_len());
        let confidence = stages::correction(&envelope, pose, features, scratch, palette)?;
        add(feature, features);
        add(corrected, palette.as_flattened().as_flattened());
        confidence
    } else {
        let scratch = cut(&mut memory.scratch, envelope.scratch_len());
        envelope.palette(pose, curves, scratch, palette)?
    };
    add(corrected, &[confidence]);
    found.faded += usize::from(confidence > 0.0 && confidence < 1.0);
    let vertices = cut(&mut memory.skin, 10 * v);
    vertices.fill(0.0);
    #[cfg(not(feature = "shapes"))]
    let _ = shaped;
    #[cfg(feature = "shapes")]
    if skin.shape_len() > 0 {
        let weights = cut(&mut memory.weights, skin.shape_len());
        let [positions, normals, tangents] = Output::interleaved(vertices, 10, [0, 3, 6]);
        ShapesJob::new(skin, weights)
            .positions(positions)
            .normals(normals)
            .tangents(Some(tangents).filter(|_| skin.has_tangents()))
            .run()?;
        vertices.iter().for_each(|x| add(shaped, &[*x]));
        if let Some(bounds) = skin.shaped_bounds(palette, weights)? {
            add(shaped, &bounds.min);
            add(shaped, &bounds.max);
        }
        vertices.fill(0.0);
    }
    if skin.has_coefficients() {
        // Without tangents, vertices are skinned side by side (SIMD).
        let [positions, normals] = Output::interleaved(vertices, 10, [0, 3]);
        SkinJob::new(skin, palette).positions(positions).normals(normals).run()?;
        vertices.iter().for_each(|x| add(skinned, &[*x]));
    }
    let [positions, normals, tangents] = Output::interleaved(vertices, 10, [0, 3, 6]);
    SkinJob::new(skin, palette)
        .positions(positions)
        .normals(normals)
        .tangents(Some(tangents).filter(|_| skin.has_tangents()))
        .run()?;
    found.finite &= vertices.iter().all(|x| x.is_finite());
    add(skinned, vertices);
    if let Some(bounds) = skin.bounds(palette, 0.0)? {
        add(bounded, &bounds.min);
        add(bounded, &bounds.max);
    }
    Ok(())
}

/// Adds the bits of floats, in order, to a hash (FNV-1a); 0 is the hash of a stage that never ran.
fn add(hash: &mut u64, values: &[f32]) {
    let start = if *hash == 0 { 0xcbf2_9ce4_8422_2325 } else { *hash };
    let bytes = values.iter().flat_map(|x| x.to_bits().to_le_bytes());
    *hash = bytes.fold(start, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3));
}

/// Returns the first `len` elements, or all if there are fewer, which the runtime then refuses.
pub(crate) fn cut<T>(all: &mut [T], len: usize) -> &mut [T] {
    let len = len.min(all.len());
    all.get_mut(..len).unwrap_or_default()
}
