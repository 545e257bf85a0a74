//! Shared by the tests: poses, batches, and the runs that both APIs must pass.
#![allow(dead_code, unused_imports, reason = "each test uses a part of it")]
#![allow(clippy::unwrap_used, reason = "a test's helpers fail as the test does")]

mod case;
pub(crate) mod kernels;

pub(crate) use case::{Case, POISON, differing};
pub(crate) use models::{GOLDEN, GOLDEN_STRETCH, TURNED};

use models::{FilterContent, JOINTLESS, KernelContent, Pieces, Rng};
use sinew_gpu::headless::Device;
use sinew_gpu::layout::{
    Array, Attribute, Batch, DeviceLimits, FilterBatch, KernelBatch, Plan, Rest, ShapesBatch,
    SkinBatch,
};
use sinew_runtime::envelope::Predictor;
use sinew_runtime::filter::Samples;
use sinew_runtime::kernel::Kernel;
use sinew_runtime::{
    Envelope, Filter, KernelMap, LocalTransform, Matrix3x4, Model, Skin, model_space_pose,
};

pub(crate) fn load(bytes: &[u8]) -> Model<&[u8]> {
    Model::from_bytes(bytes).unwrap()
}

pub(crate) fn parts<'a>(model: &'a Model<&[u8]>) -> (Envelope<'a>, Skin<'a>) {
    (model.first::<Envelope>().unwrap(), model.first::<Skin>().unwrap())
}

/// Lists the golden models with a skin: of both predictors, with tangent coefficients, and with
/// joints that stretch.
pub(crate) fn goldens() -> impl Iterator<Item = &'static [u8]> {
    GOLDEN.into_iter().chain(TURNED).chain(GOLDEN_STRETCH)
}

/// A pose of J joints and C curves.
pub(crate) struct Pose {
    pub(crate) joints: Vec<Matrix3x4>,
    pub(crate) curves: Vec<f32>,
}

/// Draws poses; the first is the rest pose.
pub(crate) fn poses(envelope: &Envelope<'_>, count: usize) -> Vec<Pose> {
    let mut random = Rng(2007);
    let pose = |n: usize| {
        let size = 0.4 * (n % 8) as f32;
        let local = (0..envelope.joint_len()).map(|joint| {
            let [x, y, z] = [(); 3].map(|()| size * random.unit());
            let translation = rest_translation(envelope, joint);
            LocalTransform { rotation: [x, y, z, 1.0], translation }
        });
        let local: Vec<_> = local.collect();
        let mut joints = vec![[[0.0; 4]; 3]; local.len()];
        model_space_pose(envelope, &local, &mut joints).unwrap();
        if envelope.stretches() {
            stretch(&mut joints, n, &mut random);
        }
        Pose { joints, curves: (0..envelope.curve_len()).map(|_| size * random.unit()).collect() }
    };
    (0..count).map(pose).collect()
}

/// Scales and shears the joints of the n-th pose; in every eighth pose one joint is scaled to 0.
fn stretch(joints: &mut [Matrix3x4], n: usize, random: &mut Rng) {
    let size = 0.05 * (n % 8) as f32;
    for matrix in &mut *joints {
        for entry in matrix.iter_mut().flat_map(|row| &mut row[..3]) {
            *entry += size * random.unit();
        }
    }
    if n % 8 == 5 {
        let hidden = n % joints.len();
        joints[hidden] = joints[hidden].map(|[_, _, _, shift]| [0.0, 0.0, 0.0, shift]);
    }
}

/// Returns a joint's rest origin relative to its parent's, in model space. The rest frames of the
/// golden models are not rotated, or their rotation does not matter.
fn rest_translation(envelope: &Envelope<'_>, joint: usize) -> [f32; 3] {
    let origin = |joint: usize| {
        let m = envelope.inverse_bind(joint).unwrap();
        [0, 1, 2].map(|c| -(m[0][c] * m[0][3] + m[1][c] * m[1][3] + m[2][c] * m[2][3]))
    };
    let parent = envelope.parent(joint).map_or([0.0; 3], origin);
    let own = origin(joint);
    [0, 1, 2].map(|i| own[i] - parent[i])
}

/// All attributes interleaved, with odd offsets, odd strides and gaps, for a part of the vertices.
pub(crate) fn odd_batch(envelope: &Envelope<'_>, skin: &Skin<'_>, instance_len: usize) -> Batch {
    let mut batch = Batch::palettes(envelope, instance_len);
    batch.poses.offset = 13;
    batch.poses.stride += 5;
    batch.curves.offset = 11;
    batch.curves.stride += 3;
    batch.palettes.offset = 68;
    batch.palettes.stride += 4;
    batch.confidences = Some(Array { offset: 3, stride: 5 });
    batch.skin = Some(interleaved(skin, 1..skin.vertex_len() - 1));
    batch
}

/// As [`odd_batch`], with the host's own input: a remap that is longer than a workgroup and has an
/// index outside the mesh, and a rest mesh. The positions differ by instance; normals and tangents
/// are shared.
pub(crate) fn hosted_batch(envelope: &Envelope<'_>, skin: &Skin<'_>, instance_len: usize) -> Batch {
    let v = skin.vertex_len();
    let mut own = interleaved(skin, 3..203);
    own.remap = Some(Array { offset: 71, stride: 205 });
    let after = 71 + 205 * instance_len;
    let (normals, tangents) = (after + 3 * v, after + 6 * v);
    own.rest = Rest {
        positions: Some(Array { offset: tangents + 4 * v + 1, stride: 3 * v + 2 }),
        normals: Some(Array { offset: normals, stride: 0 }),
        tangents: Some(Array { offset: tangents, stride: 0 }).filter(|_| own.tangents.is_some()),
    };
    Batch { skin: Some(own), ..odd_batch(envelope, skin, instance_len) }
}

/// A batch that needs every resource, from its first byte on.
pub(crate) fn remapped_batch(
    envelope: &Envelope<'_>,
    skin: &Skin<'_>,
    instance_len: usize,
) -> Batch {
    let mut batch = Batch::skinned(envelope, skin, instance_len);
    let own = batch.skin.as_mut().unwrap();
    own.remap = Some(Array { offset: 0, stride: skin.vertex_len() });
    batch
}

/// 17 floats a vertex: positions, a gap, normals, a gap, tangents, a gap.
fn interleaved(skin: &Skin<'_>, vertices: std::ops::Range<usize>) -> SkinBatch {
    let instance_stride = 17 * vertices.len() + 11;
    let attribute = |offset| Some(Attribute { offset, stride: 17, instance_stride });
    SkinBatch {
        vertices,
        positions: attribute(101),
        normals: attribute(105),
        tangents: attribute(110).filter(|_| skin.has_tangents()),
        ..SkinBatch::new(skin)
    }
}

/// Evaluates more instances than a dispatch has workgroups along an axis: all but the last five of
/// a batch. Behind each instance of each array is a gap that must not change.
pub(crate) fn past_65535_workgroups(device: &dyn Device, bytes: &[u8]) {
    const INSTANCES: usize = 65_535 + 70;
    let model = load(bytes);
    let (envelope, skin) = parts(&model);
    let mut batch = odd_batch(&envelope, &skin, INSTANCES);
    let own = batch.skin.as_mut().unwrap();
    // Two workgroups of vertices for each instance, with one remap for all.
    own.remap = Some(Array { offset: 0, stride: 0 });
    own.vertices = 7..72;
    let instance_stride = 3 * own.vertices.len() + 4;
    own.positions = Some(Attribute { offset: 1, stride: 3, instance_stride });
    (own.normals, own.tangents) = (None, None);
    let limits = &device.limits();
    let chunks = Case { bytes, batch: &batch, limits, instance_len: INSTANCES - 5 }.check(device);
    assert!(chunks > 1, "{chunks} chunks");
}

/// Plans three queries of a kernel with every kind of input and output; also returns the blob.
pub(crate) fn kernel_plan(limits: &DeviceLimits) -> (Plan, Vec<u8>) {
    let content = KernelContent::every(Kernel::Gaussian);
    let bytes = Pieces::kernels(&[content]).bytes();
    let model = load(&bytes);
    let kernel = model.first::<KernelMap>().unwrap();
    let plan = Plan::of_kernel(&model, &kernel, &KernelBatch::new(&kernel, 3), limits).unwrap();
    (plan, model.blob().to_vec())
}

/// Plans three instances of the shapes of a skin; also returns the blob.
pub(crate) fn shapes_plan(limits: &DeviceLimits) -> (Plan, Vec<u8>) {
    let [.., face] = Pieces::shaped();
    let bytes = face.bytes();
    let model = load(&bytes);
    let skin = model.first::<Skin>().unwrap();
    let plan = Plan::of_shapes(&model, &skin, &ShapesBatch::new(&skin, 3), limits).unwrap();
    (plan, model.blob().to_vec())
}

/// Plans three signals of a filter; also returns the blob.
pub(crate) fn filter_plan(limits: &DeviceLimits) -> (Plan, Vec<u8>) {
    let bytes = Pieces::filter(&FilterContent::sample(2, 5)).bytes();
    let model = load(&bytes);
    let filter = model.first::<Filter>().unwrap();
    let samples = Samples { signal_len: 3, sample_len: 9, lane_len: 2 };
    let batch = FilterBatch::new(&filter, samples);
    let plan = Plan::of_filter(&model, &filter, &batch, limits).unwrap();
    (plan, model.blob().to_vec())
}

/// Evaluates each golden model, and a model without joints, in several batches.
pub(crate) fn every_batch(device: &dyn Device) {
    println!("on {:?}", device.info());
    goldens().for_each(|bytes| every_batch_of(device, bytes));
    every_batch_of(device, &Pieces::sample(Predictor::Kernel, JOINTLESS).bytes());
}

/// Evaluates a model without gaps, with odd offsets and strides, palettes only, with the host's
/// input, one instance, and some of many.
fn every_batch_of(device: &dyn Device, bytes: &[u8]) {
    let limits = &device.limits();
    let model = load(bytes);
    let (envelope, skin) = parts(&model);
    let runs = [
        (Batch::skinned(&envelope, &skin, 1), 1),
        (Batch::skinned(&envelope, &skin, 17), 17),
        (Batch::palettes(&envelope, 5), 5),
        (odd_batch(&envelope, &skin, 3), 3),
        (odd_batch(&envelope, &skin, 129), 129),
        (odd_batch(&envelope, &skin, 129), 7),
        (hosted_batch(&envelope, &skin, 9), 9),
        (hosted_batch(&envelope, &skin, 9), 4),
        (Batch { confidences: None, ..odd_batch(&envelope, &skin, 4) }, 4),
    ];
    for (batch, instance_len) in &runs {
        Case { bytes, batch, limits, instance_len: *instance_len }.check(device);
    }
}
