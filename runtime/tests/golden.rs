//! The golden files stay loadable, and their evaluation has the same bits on every CPU.
#![allow(clippy::unwrap_used, reason = "a test's helpers fail as the test does")]
// A hash takes all its poses, which is hours under Miri; `evaluate.rs` walks the same code there.
#![cfg(not(miri))]

mod common;

use common::{IDENTITY, Rng};
use sinew_runtime::envelope::{Attribute, Buffer, SkinJob, correction, gradients, joints, palette};
use sinew_runtime::format::Predictor;
use sinew_runtime::pose::features;
use sinew_runtime::{Envelope, Model, model_space_pose};

/// A golden file, and a hash of the bits of each of its stages.
struct Golden {
    predictor: Predictor,
    file: &'static [u8],
    bits: [u64; STAGES.len()],
}

/// The palette before it is corrected is "palette"; "correction" is what it is then, with the
/// confidence.
const STAGES: [&str; 7] =
    ["pose", "gradients", "palette", "features", "correction", "skin", "bounds"];

/// Change these only with a reason that the commit states: they are the promise of METHOD §7.
const GOLDEN: [Golden; 3] = [
    Golden {
        predictor: Predictor::Rotational,
        file: include_bytes!("../../tests/golden/envelope-2-rotational.snw"),
        bits: [
            0x97d3_d7f7_0f77_bf91,
            0x831c_b019_d3a8_7b88,
            0xe00f_aad0_a34d_6eea,
            0,
            0x4cbe_b5e8_df9b_9055,
            0x9cee_3dec_bf52_30a0,
            0x6d26_a0d8_2bfc_0717,
        ],
    },
    Golden {
        predictor: Predictor::Kernel,
        file: include_bytes!("../../tests/golden/envelope-2-kernel.snw"),
        bits: [
            0x97d3_d7f7_0f77_bf91,
            0,
            0x9c1e_3aa2_f08f_9a1b,
            0x55a2_0a1b_ef88_aef2,
            0x6a87_d1c8_7900_204b,
            0xed78_2484_cf1f_3fce,
            0x72a4_ecdb_bc86_1b49,
        ],
    },
    Golden {
        predictor: Predictor::Hybrid,
        file: include_bytes!("../../tests/golden/envelope-2-hybrid.snw"),
        bits: [
            0x97d3_d7f7_0f77_bf91,
            0x831c_b019_d3a8_7b88,
            0xe00f_aad0_a34d_6eea,
            0x55a2_0a1b_ef88_aef2,
            0x1b83_1b67_4845_effd,
            0xaad1_56fb_56f7_1b8e,
            0x4527_a260_da4b_cad9,
        ],
    },
];

/// FNV-1a over the bits of floats, in order; 0 stands for a stage that never ran.
#[derive(Clone, Copy)]
struct Bits(u64);

impl Bits {
    fn add(&mut self, values: &[f32]) {
        let state = if self.0 == 0 { 0xcbf2_9ce4_8422_2325 } else { self.0 };
        let bytes = values.iter().flat_map(|x| x.to_bits().to_le_bytes());
        let step = |state: u64, byte| (state ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        self.0 = bytes.fold(state, step);
    }
}

/// Hashes the stages over seeded poses; returns also how many poses lie in the fade.
fn hashes(envelope: Envelope<'_>, nudge: f32) -> ([u64; STAGES.len()], usize) {
    let (v, j, p) = (envelope.vertex_len(), envelope.joint_len(), envelope.proxy_len());
    let mut bits = [Bits(0); STAGES.len()];
    let mut faded = 0;
    let mut rng = Rng(2007);
    for i in 0..1024 {
        let mut pose = vec![IDENTITY; j];
        // Small, usual and wild rotations, through every branch of the logarithm.
        let turn = [0.01, 0.3, 1.0, 8.0][i % 4];
        let mut local = (0..j).map(|_| rng.local(turn)).collect::<Vec<_>>();
        local[0].translation[0] += nudge;
        local.iter_mut().for_each(|local| local.rotation[0] += nudge);
        model_space_pose(&envelope, &local, &mut pose).unwrap();
        let mut maps = vec![IDENTITY; envelope.palette_len()];
        let mut add = |stage: &str, values: &[f32]| {
            bits[STAGES.iter().position(|name| *name == stage).unwrap()].add(values);
        };
        add("pose", pose.as_flattened().as_flattened());
        if envelope.predictor().reconstructs() {
            let (mut relative, mut rotations) = (vec![[0.0; 3]; 4 * j], vec![[0.0; 3]; j]);
            let mut d = vec![[0.0; 3]; 3 * p];
            gradients::evaluate(&envelope, &pose, &mut relative, &mut rotations, &mut d).unwrap();
            let root = &pose[envelope.root()];
            palette::evaluate(&envelope, root, &relative, &d, &mut maps).unwrap();
            add("gradients", relative.as_flattened());
            add("gradients", rotations.as_flattened());
            add("gradients", d.as_flattened());
        } else {
            joints::evaluate(&envelope, &pose, &mut maps).unwrap();
        }
        add("palette", maps.as_flattened().as_flattened());
        if envelope.predictor().corrects() {
            let mut phi = vec![[[0.0; 4]; 3]; j];
            features::evaluate(&envelope, &pose, &mut phi).unwrap();
            let mut scratch = vec![0.0; envelope.scratch_len()];
            let confidence =
                correction::evaluate(&envelope, &pose, &phi, &mut scratch, &mut maps).unwrap();
            faded += usize::from(confidence > 0.0 && confidence < 1.0);
            add("features", phi.as_flattened().as_flattened());
            add("correction", maps.as_flattened().as_flattened());
            add("correction", &[confidence]);
        } else {
            let mut workspace = vec![0.0; envelope.workspace_len()];
            let confidence = envelope.palette(&pose, &mut workspace, &mut maps).unwrap();
            faded += usize::from(confidence > 0.0 && confidence < 1.0);
            add("correction", &[confidence]);
        }
        let mut skin = vec![0.0; 10 * v];
        let attribute = |offset| Some(Attribute { buffer: Buffer::A, offset, stride: 10 });
        SkinJob {
            envelope,
            palette: &maps,
            vertices: 0..v,
            positions: attribute(0),
            normals: attribute(3),
            tangents: attribute(6),
            out_a: &mut skin,
            out_b: &mut [],
        }
        .run()
        .unwrap();
        assert!(skin.iter().all(|x| x.is_finite()));
        let bounds = envelope.bounds(&maps).unwrap().unwrap();
        add("skin", &skin);
        add("bounds", &[bounds.min, bounds.max].concat());
    }
    (bits.map(|bits| bits.0), faded)
}

#[test]
fn bits_are_those_of_every_other_cpu() {
    let mut found = Vec::new();
    for golden in GOLDEN {
        let envelope = Model::from_bytes(golden.file).unwrap().envelope().unwrap();
        assert_eq!(envelope.predictor(), golden.predictor);
        let (bits, faded) = hashes(envelope, 0.0);
        assert!(faded > 100, "{:?}: {faded} poses in the fade", golden.predictor);
        found.push(bits);
    }
    assert_eq!(found, GOLDEN.map(|golden| golden.bits), "found {found:#018x?}");
}

#[test]
fn the_hash_sees_one_last_place() {
    for golden in GOLDEN {
        let envelope = Model::from_bytes(golden.file).unwrap().envelope().unwrap();
        let (nudged, _) = hashes(envelope, 1.2e-7);
        for ((stage, nudged), bits) in STAGES.iter().zip(nudged).zip(golden.bits) {
            assert!(nudged != bits || bits == 0, "{stage} of {:?}", golden.predictor);
        }
    }
}
