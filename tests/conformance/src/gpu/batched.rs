//! A batch on its device, whose buffers are poisoned, and watched.

use crate::backend::{Failure, Loaded, floats, part};
use crate::compare::POISON;
use sinew_gpu::headless::{Device, Uploaded};
use sinew_gpu::layout::{Array, Batch, DeviceLimits, Plan, Resource, SkinBatch, Stage};
use sinew_runtime::envelope::ScratchLayout;
use sinew_runtime::{Envelope, Matrix3x4};
use std::ops::Range;

/// What is poisoned and watched: all but what the helper itself uploads.
const BUFFERS: [Resource; 5] =
    [Resource::Poses, Resource::Scratch, Resource::Palettes, Resource::Confidences, Resource::Out];

/// Where confidences lie.
const CONFIDENCES: Array = Array { offset: 1, stride: 2 };

/// What a stage may write to: so many floats of each instance's part of an array.
pub(super) type Own = (Resource, Array, usize);

/// A batch on its device, and what its buffers hold.
pub(super) struct Batched<'a> {
    uploaded: Box<dyn Uploaded + 'a>,
    batch: Batch,
    pub(super) scratch: ScratchLayout,
    instance_len: usize,
    palette_floats: usize,
    buffers: [(Resource, Vec<f32>); BUFFERS.len()],
}

impl<'a> Batched<'a> {
    /// Uploads a model, and poisons everything else.
    ///
    /// # Errors
    /// [`Failure`]
    pub(super) fn new(
        device: &'a dyn Device,
        limits: &DeviceLimits,
        loaded: &Loaded<'_>,
        instance_len: usize,
        skin: Option<&SkinBatch>,
    ) -> Result<Self, Failure> {
        let envelope = &loaded.envelope;
        let batch = batch(envelope, instance_len, skin);
        let plan = Plan::new(&loaded.model, envelope, &batch, limits)?;
        let uploaded = device.upload(loaded.model.blob(), &plan)?;
        let poisoned = |resource| (resource, vec![POISON; (plan.bytes(resource) / 4) as usize]);
        let buffers = BUFFERS.map(poisoned);
        let palette_floats = 12 * envelope.palette_len();
        Ok(Self {
            uploaded,
            batch,
            scratch: ScratchLayout::at_once(envelope),
            instance_len,
            palette_floats,
            buffers,
        })
    }

    fn floats(&mut self, resource: Resource) -> &mut Vec<f32> {
        let own = self.buffers.iter_mut().find(|(own, _)| *own == resource);
        &mut own.expect("the host writes to it").1
    }

    /// Puts each instance's part of some floats where an array lies.
    pub(super) fn put(&mut self, resource: Resource, array: Array, floats: &[f32]) {
        let n = self.instance_len;
        let out = self.floats(resource);
        for i in 0..n {
            let own = part(floats, n, i);
            out[array.offset + i * array.stride..][..own.len()].copy_from_slice(own);
        }
    }

    pub(super) fn put_poses(&mut self, poses: &[Matrix3x4]) {
        self.put(Resource::Poses, self.batch.poses, floats(poses));
    }

    pub(super) fn put_palettes(&mut self, palettes: &[Matrix3x4]) {
        self.put(Resource::Palettes, self.batch.palettes, floats(palettes));
    }

    /// Where an array lies in the scratch.
    pub(super) fn scratch_at(&self, offset: usize) -> Array {
        Array { offset, stride: self.scratch.len }
    }

    /// Uploads, runs some stages alone, or else all of them, and downloads. Only what `own` lists of
    /// each instance, and a range of the skins' floats, may have changed.
    pub(super) fn run(
        &mut self,
        stages: &[Stage],
        own: &[Own],
        own_skin: Range<usize>,
    ) -> Result<(), Failure> {
        for (resource, floats) in self.buffers.iter().filter(|(_, floats)| !floats.is_empty()) {
            self.uploaded.write(*resource, 0, floats)?;
        }
        for &stage in stages {
            self.uploaded.run_stage(stage, self.instance_len)?;
        }
        if stages.is_empty() {
            self.uploaded.run(self.instance_len)?;
        }
        for (resource, floats) in self.buffers.iter_mut().filter(|(_, floats)| !floats.is_empty()) {
            let found = self.uploaded.read(*resource)?;
            let mut may = vec![false; floats.len()];
            for (_, array, len) in own.iter().filter(|(own, ..)| own == resource) {
                for i in 0..self.instance_len {
                    may[array.offset + i * array.stride..][..*len].fill(true);
                }
            }
            if *resource == Resource::Out {
                may[own_skin.clone()].fill(true);
            }
            let stage = stages.first().map_or("the whole", |stage| stage.name());
            let changed = |(float, may): (usize, bool)| {
                let same = found.get(float).map(|x| x.to_bits()) == Some(floats[float].to_bits());
                !may && !same
            };
            if let Some(float) = may.into_iter().enumerate().position(changed) {
                return Err(Failure::Touched { stage, resource: resource.name(), float });
            }
            *floats = found;
        }
        Ok(())
    }

    /// Gathers each instance's part of what lies where an array does.
    pub(super) fn take(&mut self, resource: Resource, array: Array, out: &mut [f32]) {
        let n = self.instance_len;
        let len = out.len() / n;
        let found = self.floats(resource);
        for (i, out) in out.chunks_mut(len.max(1)).enumerate() {
            out.copy_from_slice(&found[array.offset + i * array.stride..][..len]);
        }
    }

    pub(super) fn take_palettes(&mut self, out: &mut [Matrix3x4]) {
        let array = self.batch.palettes;
        self.take(Resource::Palettes, array, out.as_flattened_mut().as_flattened_mut());
    }

    /// What a stage writes of palettes.
    pub(super) fn own_palettes(&self) -> Own {
        (Resource::Palettes, self.batch.palettes, self.palette_floats)
    }

    /// What a stage writes of confidences.
    pub(super) fn own_confidences(&self) -> Own {
        (Resource::Confidences, CONFIDENCES, 1)
    }

    /// Copies the host's floats for skins in: as much of them as the device has.
    pub(super) fn put_skin(&mut self, out: &[f32]) {
        let to = self.floats(Resource::Out);
        let len = out.len().min(to.len());
        to[..len].copy_from_slice(&out[..len]);
    }

    /// Copies them out.
    pub(super) fn take_skin(&mut self, out: &mut [f32]) {
        let from = self.floats(Resource::Out);
        let len = from.len().min(out.len());
        out[..len].copy_from_slice(&from[..len]);
    }

    /// The part of the skins' floats, of which the host has so many, that the body looks after.
    pub(super) fn own_skin(&mut self, host: usize) -> Range<usize> {
        0..self.floats(Resource::Out).len().min(host)
    }
}

/// Describes a batch in which nothing starts at 0 and nothing follows closely; palettes in fours, as
/// skins ask for.
fn batch(envelope: &Envelope<'_>, instance_len: usize, skin: Option<&SkinBatch>) -> Batch {
    Batch {
        instance_len,
        poses: Array { offset: 5, stride: 12 * envelope.joint_len() + 3 },
        palettes: Array { offset: 4, stride: 12 * envelope.palette_len() + 8 },
        confidences: Some(CONFIDENCES),
        skin: skin.cloned(),
    }
}
