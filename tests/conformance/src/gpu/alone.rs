//! Kernels, shapes and filters on a device: batches of one stage, in poisoned buffers.

use crate::backend::{Failure, part};
use crate::compare::POISON;
use crate::filters::FilterSubject;
use crate::kernels::KernelSubject;
use crate::shapes::ShapeSubject;
use sinew_gpu::headless::Device;
use sinew_gpu::layout::{
    Array, Attribute, DeviceLimits, FilterBatch, KernelBatch, Plan, Resource, ShapesBatch, Stage,
};

/// Evaluates n queries of a kernel; only outputs, confidences and scratch may change.
///
/// # Errors
/// [`Failure`]
pub(super) fn kernel(
    device: &dyn Device,
    limits: &DeviceLimits,
    subject: &KernelSubject<'_>,
    queries: &[f32],
    [out, out_confidences]: [&mut [f32]; 2],
) -> Result<(), Failure> {
    let (n, kernel) = (out_confidences.len(), &subject.kernel);
    // Nothing starts at 0, and there is a gap behind every array.
    let (result_len, stride) = (kernel.result_len(), kernel.result_len() + 3);
    let confidences = Array { offset: 6 + result_len, stride };
    let batch = KernelBatch {
        instance_len: n,
        queries: Array { offset: 7, stride: kernel.query_len() + 2 },
        outputs: Array { offset: 5, stride },
        confidences: Some(confidences),
    };
    let plan = Plan::of_kernel(&subject.model, kernel, &batch, limits)?;
    let input = (Resource::Queries, batch.queries, queries);
    let mut found = Output::of(device, subject.model.blob(), &plan, Stage::Kernel, n, input)?;
    for (i, own) in out.chunks_exact_mut(result_len).enumerate() {
        found.take(batch.outputs.offset + i * stride, own);
        let own = &mut out_confidences[i..=i];
        found.take(confidences.offset + i * stride, own);
    }
    found.check_rest()
}

/// Shapes all faces of a subject; only the attributes may change.
///
/// # Errors
/// [`Failure`]
pub(super) fn shapes(
    device: &dyn Device,
    limits: &DeviceLimits,
    subject: &ShapeSubject<'_>,
    batch: &ShapesBatch,
    out: &mut [f32],
) -> Result<(), Failure> {
    let n = subject.face_len;
    // Nothing starts at 0, and there is a gap behind every array.
    let weights = Array { offset: 7, stride: subject.skin.shape_len() + 2 };
    let batch = ShapesBatch { weights, ..batch.clone() };
    let plan = Plan::of_shapes(&subject.model, &subject.skin, &batch, limits)?;
    let input = (Resource::Weights, weights, &subject.weights[..]);
    let mut found = Output::of(device, subject.model.blob(), &plan, Stage::Shapes, n, input)?;
    let attributes = [(batch.positions, 3), (batch.normals, 3), (batch.tangents, 4)];
    for (own, len) in attributes.into_iter().filter_map(|(own, len)| Some((own?, len))) {
        let Attribute { offset, stride, instance_stride } = own;
        for (face, i) in (0..n).flat_map(|face| (0..batch.vertices.len()).map(move |i| (face, i))) {
            let at = offset + face * instance_stride + i * stride;
            found.take(at, &mut out[at..][..len]);
        }
    }
    found.check_rest()
}

/// Makes all signals of a subject finer; only the finer samples may change.
///
/// # Errors
/// [`Failure`]
pub(super) fn filter(
    device: &dyn Device,
    limits: &DeviceLimits,
    subject: &FilterSubject<'_>,
    out: &mut [f32],
) -> Result<(), Failure> {
    let n = subject.shape.signal_len;
    // Nothing starts at 0, and there is a gap behind every array.
    let batch = FilterBatch::new(&subject.filter, subject.shape);
    let apart = |array: Array, offset, gap| Array { offset, stride: array.stride + gap };
    let (samples, outputs) = (apart(batch.samples, 5, 2), apart(batch.outputs, 3, 4));
    let batch = FilterBatch { samples, outputs, ..batch };
    let plan = Plan::of_filter(&subject.model, &subject.filter, &batch, limits)?;
    let input = (Resource::Samples, samples, &subject.samples[..]);
    let mut found = Output::of(device, subject.model.blob(), &plan, Stage::Filter, n, input)?;
    let len = out.len() / n;
    for (signal, own) in out.chunks_exact_mut(len).enumerate() {
        found.take(outputs.offset + signal * outputs.stride, own);
    }
    found.check_rest()
}

/// The floats of [`Resource::Out`] after a stage. Floats that have been copied out are poisoned
/// again.
struct Output {
    stage: Stage,
    floats: Vec<f32>,
}

impl Output {
    /// Poisons the buffers of a batch, writes each instance's input, runs the stage, and reads the
    /// outputs. Checks that the stage changed neither the input nor the gaps in it.
    ///
    /// # Errors
    /// [`Failure`]
    fn of(
        device: &dyn Device,
        blob: &[u8],
        plan: &Plan,
        stage: Stage,
        instance_len: usize,
        (resource, array, input): (Resource, Array, &[f32]),
    ) -> Result<Self, Failure> {
        let mut uploaded = device.upload(blob, plan)?;
        let poisoned = |resource| vec![POISON; (plan.bytes(resource) / 4) as usize];
        let mut given = poisoned(resource);
        for i in 0..instance_len {
            let own = part(input, instance_len, i);
            given[array.offset + i * array.stride..][..own.len()].copy_from_slice(own);
        }
        uploaded.write(resource, 0, &given)?;
        for resource in [Resource::Scratch, Resource::Out] {
            let floats = poisoned(resource);
            if !floats.is_empty() {
                uploaded.write(resource, 0, &floats)?;
            }
        }
        uploaded.run_stage(stage, instance_len)?;
        check_same(stage, resource, &uploaded.read(resource)?, &given)?;
        Ok(Self { stage, floats: uploaded.read(Resource::Out)? })
    }

    /// Copies floats out, starting at float `at`.
    fn take(&mut self, at: usize, out: &mut [f32]) {
        let own = &mut self.floats[at..][..out.len()];
        out.copy_from_slice(own);
        own.fill(POISON);
    }

    /// Checks that the stage wrote no other float.
    fn check_rest(&self) -> Result<(), Failure> {
        let poison = vec![POISON; self.floats.len()];
        check_same(self.stage, Resource::Out, &self.floats, &poison)
    }
}

fn check_same(
    stage: Stage,
    resource: Resource,
    found: &[f32],
    given: &[f32],
) -> Result<(), Failure> {
    let mut pairs = found.iter().zip(given);
    match pairs.position(|(found, given)| found.to_bits() != given.to_bits()) {
        None => Ok(()),
        Some(float) => {
            let (stage, resource) = (stage.name(), resource.name());
            Err(Failure::Touched { stage, resource, float })
        }
    }
}
