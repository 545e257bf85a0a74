//! Signals on a device, whose buffers are poisoned, and watched.

use crate::backend::{Failure, part};
use crate::compare::POISON;
use crate::filters::FilterSubject;
use sinew_gpu::headless::Device;
use sinew_gpu::layout::{Array, DeviceLimits, FilterBatch, Plan, Resource, Stage};

/// Makes all signals of a subject finer; only those may be written to.
///
/// # Errors
/// [`Failure`]
pub(super) fn evaluate(
    device: &dyn Device,
    limits: &DeviceLimits,
    subject: &FilterSubject<'_>,
    out: &mut [f32],
) -> Result<(), Failure> {
    let (n, stage) = (subject.shape.signal_len, Stage::Filter.name());
    // Nothing starts at 0 and nothing follows closely.
    let batch = FilterBatch::new(&subject.filter, subject.shape);
    let apart = |array: Array, offset, gap| Array { offset, stride: array.stride + gap };
    let (samples, outputs) = (apart(batch.samples, 5, 2), apart(batch.outputs, 3, 4));
    let batch = FilterBatch { samples, outputs, ..batch };
    let plan = Plan::of_filter(&subject.model, &subject.filter, &batch, limits)?;
    let mut uploaded = device.upload(subject.model.blob(), &plan)?;
    let poisoned = |resource| vec![POISON; (plan.bytes(resource) / 4) as usize];
    let mut given = poisoned(Resource::Samples);
    for signal in 0..n {
        let own = part(&subject.samples, n, signal);
        given[samples.offset + signal * samples.stride..][..own.len()].copy_from_slice(own);
    }
    uploaded.write(Resource::Samples, 0, &given)?;
    uploaded.write(Resource::Out, 0, &poisoned(Resource::Out))?;
    uploaded.run_stage(Stage::Filter, n)?;
    let changed = |found: &[f32], given: &[f32]| {
        found.iter().zip(given).position(|(a, b)| a.to_bits() != b.to_bits())
    };
    let touched = |resource: Resource, float: Option<usize>| match float {
        None => Ok(()),
        Some(float) => Err(Failure::Touched { stage, resource: resource.name(), float }),
    };
    touched(Resource::Samples, changed(&uploaded.read(Resource::Samples)?, &given))?;
    let mut found = uploaded.read(Resource::Out)?;
    for (signal, own) in out.chunks_exact_mut(out.len() / n).enumerate() {
        let found = &mut found[outputs.offset + signal * outputs.stride..][..own.len()];
        own.copy_from_slice(found);
        found.fill(POISON);
    }
    // What is left is nobody's.
    touched(Resource::Out, changed(&found, &poisoned(Resource::Out)))
}
