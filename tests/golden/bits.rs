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
use sinew_runtime::envelope::Predictor;
use sinew_runtime::skin::{Output, Rest, cells};
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
pub(crate) const STAGES: [&str; 8] =
    ["pose", "gradients", "palette", "features", "correction", "skin", "bounds", "shapes"];

/// The promise of METHOD §7: change these hashes only with a reason that the commit states.
pub(crate) const GOLDEN: [Golden; 7] = [
    Golden {
        name: "rotational",
        predictor: Predictor::Rotational,
        file: include_bytes!("envelope-8-rotational.snw"),
        bits: [
            0x97d3_d7f7_0f77_bf91,
            0x831c_b019_d3a8_7b88,
            0xe00f_aad0_a34d_6eea,
            0,
            0x4cbe_b5e8_df9b_9055,
            0xf762_fb2e_2bd0_d6a0,
            0x6d26_a0d8_2bfc_0717,
            0,
        ],
    },
    Golden {
        name: "kernel",
        predictor: Predictor::Kernel,
        file: include_bytes!("envelope-8-kernel.snw"),
        bits: [
            0x97d3_d7f7_0f77_bf91,
            0,
            0x9c1e_3aa2_f08f_9a1b,
            0x478a_53c0_bbf3_526b,
            0x12b3_d484_f4de_b64e,
            0x4e03_ef71_6665_ffb1,
            0xcab6_4e1c_cdc4_9353,
            0,
        ],
    },
    Golden {
        name: "tangents",
        predictor: Predictor::Kernel,
        file: include_bytes!("skin-8-tangents.snw"),
        bits: [
            0x6d8f_7764_86bf_b108,
            0,
            0x8d6c_ffdd_2431_e4fa,
            0x10a4_410b_d031_19e1,
            0x26f9_461d_660e_297f,
            0x18ee_cbfc_7395_220f,
            0x8846_3907_63bd_9ed5,
            0,
        ],
    },
    Golden {
        name: "normals",
        predictor: Predictor::Kernel,
        file: include_bytes!("skin-8-normals.snw"),
        bits: [
            0x6d8f_7764_86bf_b108,
            0,
            0x8d6c_ffdd_2431_e4fa,
            0x10a4_410b_d031_19e1,
            0x26f9_461d_660e_297f,
            0x4df5_9efb_d006_c975,
            0x87b9_f3dd_7c5f_789a,
            0,
        ],
    },
    Golden {
        name: "shapes of f32",
        predictor: Predictor::Kernel,
        file: include_bytes!("shapes-8-f32.snw"),
        bits: [
            0x6d8f_7764_86bf_b108,
            0,
            0x8d6c_ffdd_2431_e4fa,
            0x10a4_410b_d031_19e1,
            0x26f9_461d_660e_297f,
            0xb181_1deb_7c52_f02b,
            0xf757_381e_3542_a06a,
            0xe259_edc7_8b03_56a5,
        ],
    },
    Golden {
        name: "shapes of f16",
        predictor: Predictor::Kernel,
        file: include_bytes!("shapes-8-f16.snw"),
        bits: [
            0x6d8f_7764_86bf_b108,
            0,
            0x8d6c_ffdd_2431_e4fa,
            0x10a4_410b_d031_19e1,
            0x26f9_461d_660e_297f,
            0x543d_8181_69aa_9330,
            0xf757_381e_3542_a06a,
            0x2581_ade0_e86d_391d,
        ],
    },
    Golden {
        name: "shapes of i8",
        predictor: Predictor::Kernel,
        file: include_bytes!("shapes-8-i8.snw"),
        bits: [
            0x6d8f_7764_86bf_b108,
            0,
            0x8d6c_ffdd_2431_e4fa,
            0x10a4_410b_d031_19e1,
            0x26f9_461d_660e_297f,
            0x74dd_fc03_166d_f350,
            0xf757_381e_3542_a06a,
            0x4ca7_1255_bafb_b196,
        ],
    },
];

/// Poses per hash.
pub(crate) const POSES: usize = 1024;

const JOINTS: usize = 24;
const PROXIES: usize = 24;
const VERTICES: usize = 1000;
const SHAPES: usize = 16;

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
    features: [Matrix3x4; JOINTS],
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
            features: [[[0.0; 4]; 3]; JOINTS],
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
    let (mut rng, mut weight) = (Rng(2007), Rng(2010));
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
        frame(envelope, skin, memory, &mut found)?;
    }
    Ok(found)
}

/// Evaluates the pose in `memory.local`, and adds the result of each stage to its hash.
fn frame(
    envelope: Envelope<'_>,
    skin: Skin<'_>,
    memory: &mut Memory,
    found: &mut Found,
) -> Result<(), CallError> {
    let (v, j, p) = (skin.vertex_len(), envelope.joint_len(), envelope.proxy_len());
    let Found {
        bits: [posed, gradient, base, feature, corrected, skinned, bounded, shaped], ..
    } = found;
    let pose = cut(&mut memory.pose, j);
    model_space_pose(&envelope, cut(&mut memory.local, j), pose)?;
    add(posed, pose.as_flattened().as_flattened());
    let palette = cut(&mut memory.palette, envelope.palette_len());
    if envelope.predictor().reconstructs() {
        let (relative, rotations) =
            (cut(&mut memory.relative, 4 * j), cut(&mut memory.rotations, j));
        let d = cut(&mut memory.gradients, 3 * p);
        stages::gradients(&envelope, pose, relative, rotations, d)?;
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
        let features = cut(&mut memory.features, j);
        stages::features(&envelope, pose, features)?;
        let scratch = cut(&mut memory.scratch, envelope.correction_len());
        let confidence = stages::correction(&envelope, pose, features, scratch, palette)?;
        add(feature, features.as_flattened().as_flattened());
        add(corrected, palette.as_flattened().as_flattened());
        confidence
    } else {
        envelope.palette(pose, cut(&mut memory.scratch, envelope.scratch_len()), palette)?
    };
    add(corrected, &[confidence]);
    found.faded += usize::from(confidence > 0.0 && confidence < 1.0);
    let vertices = cut(&mut memory.skin, 10 * v);
    vertices.fill(0.0);
    let lent = cells(vertices);
    let attribute = |start: usize| Some(Output { floats: lent.get(start..)?, stride: 10 });
    #[cfg(not(feature = "shapes"))]
    let _ = shaped;
    #[cfg(feature = "shapes")]
    if skin.shape_len() > 0 {
        let weights = cut(&mut memory.weights, skin.shape_len());
        let (positions, normals) = (attribute(0), attribute(3));
        let tangents = attribute(6).filter(|_| skin.has_tangents());
        ShapesJob { skin, weights, vertices: 0..v, positions, normals, tangents }.run()?;
        lent.iter().for_each(|x| add(shaped, &[x.get()]));
        if let Some(bounds) = skin.shaped_bounds(palette, weights)? {
            add(shaped, &bounds.min);
            add(shaped, &bounds.max);
        }
        lent.iter().for_each(|x| x.set(0.0));
    }
    let job = SkinJob {
        skin,
        palette,
        vertices: 0..v,
        remap: None,
        rest: Rest::default(),
        positions: attribute(0),
        normals: attribute(3),
        tangents: attribute(6).filter(|_| skin.has_tangents()),
    };
    if skin.has_coefficients() {
        // Without tangents, vertices are skinned side by side (SIMD).
        SkinJob { tangents: None, ..job.clone() }.run()?;
        lent.iter().for_each(|x| add(skinned, &[x.get()]));
    }
    job.run()?;
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
