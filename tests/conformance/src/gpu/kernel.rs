//! Queries of a kernel on a device, whose buffers are poisoned, and watched.

use crate::backend::{Failure, part};
use crate::compare::POISON;
use crate::kernels::KernelSubject;
use sinew_gpu::headless::Device;
use sinew_gpu::layout::{Array, DeviceLimits, KernelBatch, Plan, Resource, Stage};

/// Evaluates n queries; only outputs, confidences and scratch may be written to.
///
/// # Errors
/// [`Failure`]
pub(super) fn evaluate(
    device: &dyn Device,
    limits: &DeviceLimits,
    subject: &KernelSubject<'_>,
    queries: &[f32],
    [out, out_confidences]: [&mut [f32]; 2],
) -> Result<(), Failure> {
    let n = out_confidences.len();
    let batch = batch(subject, n);
    let plan = Plan::of_kernel(&subject.model, &subject.kernel, &batch, limits)?;
    let mut uploaded = device.upload(subject.model.blob(), &plan)?;
    let poisoned = |resource| vec![POISON; (plan.bytes(resource) / 4) as usize];
    let mut given = poisoned(Resource::Queries);
    for i in 0..n {
        let own = part(queries, n, i);
        given[place(batch.queries, i)..][..own.len()].copy_from_slice(own);
    }
    uploaded.write(Resource::Queries, 0, &given)?;
    for resource in [Resource::Scratch, Resource::Out] {
        uploaded.write(resource, 0, &poisoned(resource))?;
    }
    uploaded.run_stage(Stage::Kernel, n)?;
    let changed = |found: &[f32], given: &[f32]| {
        found.iter().zip(given).position(|(a, b)| a.to_bits() != b.to_bits())
    };
    let touched = |resource: Resource, float: Option<usize>| match float {
        None => Ok(()),
        Some(float) => {
            let (stage, resource) = (Stage::Kernel.name(), resource.name());
            Err(Failure::Touched { stage, resource, float })
        }
    };
    touched(Resource::Queries, changed(&uploaded.read(Resource::Queries)?, &given))?;
    let mut found = uploaded.read(Resource::Out)?;
    let len = out.len() / n;
    for (i, confidence) in out_confidences.iter_mut().enumerate() {
        let own = &mut found[place(batch.outputs, i)..][..len];
        out[i * len..][..len].copy_from_slice(own);
        own.fill(POISON);
        if let Some(array) = batch.confidences {
            let own = &mut found[place(array, i)];
            *confidence = *own;
            *own = POISON;
        }
    }
    // What is left is nobody's.
    touched(Resource::Out, changed(&found, &poisoned(Resource::Out)))
}

/// Describes a batch in which nothing starts at 0 and nothing follows closely.
fn batch(subject: &KernelSubject<'_>, instance_len: usize) -> KernelBatch {
    let kernel = &subject.kernel;
    let (result_len, stride) = (kernel.result_len(), kernel.result_len() + 3);
    KernelBatch {
        instance_len,
        queries: Array { offset: 7, stride: kernel.query_len() + 2 },
        outputs: Array { offset: 5, stride },
        confidences: Some(Array { offset: 6 + result_len, stride }),
    }
}

/// The first float of an instance.
fn place(array: Array, instance: usize) -> usize {
    array.offset + instance * array.stride
}
