//! The golden file stays loadable, and its evaluation has the same bits on every CPU.
#![allow(clippy::unwrap_used, reason = "a test's helpers fail as the test does")]

mod common;

use common::{IDENTITY, Rng};
use sinew_runtime::envelope::{self, Attribute, Buffer, SkinJob};
use sinew_runtime::{Envelope, Model, model_space_pose};

const GOLDEN: &[u8] = include_bytes!("../../tests/golden/envelope-1.snw");

/// FNV-1a over the bits of floats, in order.
struct Bits(u64);

impl Bits {
    fn new() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }

    fn add(&mut self, values: &[f32]) {
        for byte in values.iter().flat_map(|x| x.to_bits().to_le_bytes()) {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }
}

/// Hashes of the pose, gradients, palette and skin stages and of the bounds over seeded poses.
fn hashes(envelope: Envelope<'_>, nudge: f32) -> [u64; 5] {
    let (v, j, p) = (envelope.vertex_len(), envelope.joint_len(), envelope.proxy_len());
    let [mut pose_bits, mut gradient_bits, mut palette_bits, mut skin_bits, mut bounds_bits] =
        [(); 5].map(|()| Bits::new());
    let mut rng = Rng(2007);
    for i in 0..1024 {
        let mut pose = vec![IDENTITY; j];
        // Small, usual and wild rotations, through every branch of the logarithm.
        let turn = [0.01, 0.3, 1.0, 8.0][i % 4];
        let mut local = (0..j).map(|_| rng.local(turn)).collect::<Vec<_>>();
        local[0].translation[0] += nudge;
        model_space_pose(&envelope, &local, &mut pose).unwrap();
        let (mut relative, mut rotations) = (vec![[0.0; 3]; 4 * j], vec![[0.0; 3]; j]);
        let mut gradients = vec![[0.0; 3]; 3 * p];
        let mut palette = vec![IDENTITY; p];
        envelope::gradients::evaluate(
            &envelope,
            &pose,
            &mut relative,
            &mut rotations,
            &mut gradients,
        )
        .unwrap();
        let root = &pose[envelope.root()];
        envelope::palette::evaluate(&envelope, root, &relative, &gradients, &mut palette).unwrap();
        let mut skin = vec![0.0; 10 * v];
        let attribute = |offset| Some(Attribute { buffer: Buffer::A, offset, stride: 10 });
        SkinJob {
            envelope,
            palette: &palette,
            vertices: 0..v,
            positions: attribute(0),
            normals: attribute(3),
            tangents: attribute(6),
            out_a: &mut skin,
            out_b: &mut [],
        }
        .run()
        .unwrap();
        let bounds = envelope.bounds(&palette).unwrap().unwrap();
        assert!(skin.iter().all(|x| x.is_finite()));
        pose_bits.add(pose.as_flattened().as_flattened());
        gradient_bits.add(relative.as_flattened());
        gradient_bits.add(rotations.as_flattened());
        gradient_bits.add(gradients.as_flattened());
        palette_bits.add(palette.as_flattened().as_flattened());
        skin_bits.add(&skin);
        bounds_bits.add(&bounds.min);
        bounds_bits.add(&bounds.max);
    }
    [pose_bits, gradient_bits, palette_bits, skin_bits, bounds_bits].map(|bits| bits.0)
}

/// Change these only with a reason that the commit states: they are the promise of METHOD §7.
const BITS: [u64; 5] = [
    0x97d3_d7f7_0f77_bf91,
    0x831c_b019_d3a8_7b88,
    0xe00f_aad0_a34d_6eea,
    0x9cee_3dec_bf52_30a0,
    0x6d26_a0d8_2bfc_0717,
];

#[test]
fn bits_are_those_of_every_other_cpu() {
    let envelope = Model::from_bytes(GOLDEN).unwrap().envelope().unwrap();
    let found = hashes(envelope, 0.0);
    assert_eq!(found, BITS, "found {found:#018x?}");
}

#[test]
fn the_hash_sees_one_last_place() {
    let envelope = Model::from_bytes(GOLDEN).unwrap().envelope().unwrap();
    let nudged = hashes(envelope, 1.2e-7);
    assert!(nudged.iter().zip(&BITS).all(|(a, b)| a != b));
}
