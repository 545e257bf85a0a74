//! What the tests share: models, poses, and what the CPU makes of them.
#![allow(dead_code, reason = "each test uses a part of it")]
#![allow(clippy::unwrap_used, reason = "a test's helpers fail as the test does")]

use sinew_gpu::layout::{Attribute, Batch, Skin};
use sinew_runtime::envelope::{Attribute as CpuAttribute, Buffer, SkinJob};
use sinew_runtime::{Envelope, LocalTransform, Matrix3x4, Model, model_space_pose};

/// A small model of each predictor: rotational, kernel, hybrid.
pub(crate) const GOLDEN: [&[u8]; 3] = [
    include_bytes!("../../../tests/golden/envelope-2-rotational.snw"),
    include_bytes!("../../../tests/golden/envelope-2-kernel.snw"),
    include_bytes!("../../../tests/golden/envelope-2-hybrid.snw"),
];

pub(crate) fn load(bytes: &[u8]) -> (Model<'_>, Envelope<'_>) {
    let model = Model::from_bytes(bytes).unwrap();
    (model, model.envelope().unwrap())
}

/// Numbers from 0 to 1 that look random: xorshift.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn next(&mut self) -> f32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 40) as f32 / (1u64 << 24) as f32
    }

    /// A number from -1 to 1.
    pub(crate) fn signed(&mut self) -> f32 {
        2.0 * self.next() - 1.0
    }
}

/// Draws poses; the first is that of rest.
pub(crate) fn poses(envelope: &Envelope<'_>, count: usize) -> Vec<Vec<Matrix3x4>> {
    let mut random = Random(2007);
    let pose = |n: usize| {
        let size = 0.4 * (n % 8) as f32;
        let local = (0..envelope.joint_len()).map(|joint| {
            let [x, y, z] = [(); 3].map(|()| size * random.signed());
            let translation = rest_translation(envelope, joint);
            LocalTransform { rotation: [x, y, z, 1.0], translation }
        });
        let local: Vec<_> = local.collect();
        let mut pose = vec![[[0.0; 4]; 3]; local.len()];
        model_space_pose(envelope, &local, &mut pose).unwrap();
        pose
    };
    (0..count).map(pose).collect()
}

/// A joint's rest origin from its parent's, in model space: the rest frames of the goldens are not
/// turned, or it does not matter.
fn rest_translation(envelope: &Envelope<'_>, joint: usize) -> [f32; 3] {
    let origin = |joint: usize| {
        let m = envelope.inverse_bind(joint).unwrap();
        [0, 1, 2].map(|c| -(m[0][c] * m[0][3] + m[1][c] * m[1][3] + m[2][c] * m[2][3]))
    };
    let parent = envelope.parent(joint).map_or([0.0; 3], origin);
    let own = origin(joint);
    [0, 1, 2].map(|i| own[i] - parent[i])
}

/// What the CPU makes of poses, in buffers laid out as a batch says; other floats stay as they are.
pub(crate) struct Expected {
    pub(crate) palettes: Vec<f32>,
    pub(crate) confidences: Vec<f32>,
    pub(crate) out_a: Vec<f32>,
    pub(crate) out_b: Vec<f32>,
}

impl Expected {
    /// Evaluates into buffers that are given.
    pub(crate) fn evaluate(
        &mut self,
        envelope: &Envelope<'_>,
        batch: &Batch,
        poses: &[Vec<Matrix3x4>],
    ) {
        let mut workspace = vec![0.0; envelope.workspace_len()];
        let mut palette = vec![[[0.0; 4]; 3]; envelope.palette_len()];
        for (n, pose) in poses.iter().enumerate() {
            let confidence = envelope.palette(pose, &mut workspace, &mut palette).unwrap();
            if let Some(array) = batch.confidences {
                self.confidences[array.offset + n * array.stride] = confidence;
            }
            let flat = palette.as_flattened().as_flattened();
            let at = batch.palettes.offset + n * batch.palettes.stride;
            self.palettes[at..at + flat.len()].copy_from_slice(flat);
            let Some(skin) = &batch.skin else { continue };
            let Skin { vertices, positions, normals, tangents } = skin.clone();
            let place = |attribute: Option<Attribute>| {
                attribute.map(|Attribute { buffer, offset, stride, instance_stride }| {
                    CpuAttribute { buffer, offset: offset + n * instance_stride, stride }
                })
            };
            SkinJob {
                envelope: *envelope,
                palette: &palette,
                vertices,
                positions: place(positions),
                normals: place(normals),
                tangents: place(tangents),
                out_a: &mut self.out_a,
                out_b: &mut self.out_b,
            }
            .run()
            .unwrap();
        }
    }
}

/// Positions and tangents in A, normals in B; odd offsets, odd strides, part of the vertices.
pub(crate) fn odd_batch(envelope: &Envelope<'_>, instance_len: usize) -> Batch {
    let vertices = 1..envelope.vertex_len() - 1;
    let (len, tangents) = (vertices.len(), envelope.has_tangents());
    let attribute = |buffer, offset, stride, gap| {
        Some(Attribute { buffer, offset, stride, instance_stride: stride * len + gap })
    };
    let mut batch = Batch::palettes(envelope, instance_len);
    batch.poses.offset = 13;
    batch.poses.stride += 5;
    batch.palettes.offset = 68;
    batch.palettes.stride += 4;
    batch.confidences = Some(sinew_gpu::layout::Array { offset: 3, stride: 5 });
    batch.skin = Some(Skin {
        positions: attribute(Buffer::A, 101, 9, 11),
        normals: attribute(Buffer::B, 5, 4, 3),
        tangents: attribute(Buffer::A, 104, 9, 11).filter(|_| tangents),
        vertices,
    });
    batch
}
