//! Shaped meshes on a device, whose buffers are poisoned, and watched.

use crate::backend::{Failure, part};
use crate::compare::POISON;
use crate::shapes::ShapeSubject;
use sinew_gpu::headless::Device;
use sinew_gpu::layout::{Array, Attribute, DeviceLimits, Plan, Resource, ShapesBatch, Stage};

/// Shapes all faces of a subject; only the attributes may be written to.
///
/// # Errors
/// [`Failure`]
pub(super) fn evaluate(
    device: &dyn Device,
    limits: &DeviceLimits,
    subject: &ShapeSubject<'_>,
    batch: &ShapesBatch,
    out: &mut [f32],
) -> Result<(), Failure> {
    let (n, stage) = (subject.face_len, Stage::Shapes.name());
    // Nothing starts at 0 and nothing follows closely.
    let weights = Array { offset: 7, stride: subject.skin.shape_len() + 2 };
    let batch = ShapesBatch { weights, ..batch.clone() };
    let plan = Plan::of_shapes(&subject.model, &subject.skin, &batch, limits)?;
    let mut uploaded = device.upload(subject.model.blob(), &plan)?;
    let poisoned = |resource| vec![POISON; (plan.bytes(resource) / 4) as usize];
    let mut given = poisoned(Resource::Weights);
    for face in 0..n {
        let own = part(&subject.weights, n, face);
        given[weights.offset + face * weights.stride..][..own.len()].copy_from_slice(own);
    }
    uploaded.write(Resource::Weights, 0, &given)?;
    uploaded.write(Resource::Out, 0, &poisoned(Resource::Out))?;
    uploaded.run_stage(Stage::Shapes, n)?;
    let changed = |found: &[f32], given: &[f32]| {
        found.iter().zip(given).position(|(a, b)| a.to_bits() != b.to_bits())
    };
    let touched = |resource: Resource, float: Option<usize>| match float {
        None => Ok(()),
        Some(float) => Err(Failure::Touched { stage, resource: resource.name(), float }),
    };
    touched(Resource::Weights, changed(&uploaded.read(Resource::Weights)?, &given))?;
    let mut found = uploaded.read(Resource::Out)?;
    let attributes = [(batch.positions, 3), (batch.normals, 3), (batch.tangents, 4)];
    for (own, len) in attributes.into_iter().filter_map(|(own, len)| Some((own?, len))) {
        let Attribute { offset, stride, instance_stride } = own;
        for (face, i) in (0..n).flat_map(|face| (0..batch.vertices.len()).map(move |i| (face, i))) {
            let at = offset + face * instance_stride + i * stride;
            out[at..][..len].copy_from_slice(&found[at..][..len]);
            found[at..][..len].fill(POISON);
        }
    }
    // What is left is nobody's.
    touched(Resource::Out, changed(&found, &poisoned(Resource::Out)))
}
