//! A batch of an envelope on a device, in poisoned buffers that are checked for stray writes.

use crate::backend::{Failure, Loaded, Poses, Split, floats, part};
use crate::compare::POISON;
use sinew_gpu::headless::{Device, Uploaded};
use sinew_gpu::layout::{Array, Batch, DeviceLimits, Plan, Resource, SkinBatch, Stage};
use sinew_runtime::envelope::ScratchLayout;
use sinew_runtime::{Envelope, Matrix3x4};
use std::ops::Range;

/// Buffers that are poisoned and checked: all but those that the upload fills.
const BUFFERS: [Resource; 6] = [
    Resource::Poses,
    Resource::Curves,
    Resource::Scratch,
    Resource::Palettes,
    Resource::Confidences,
    Resource::Out,
];

/// Place of the confidences.
const CONFIDENCES: Array = Array { offset: 1, stride: 2 };

/// Floats that a stage may write: the first `usize` floats of each instance's part of an array.
pub(super) type Writable = (Resource, Array, usize);

/// A batch on a device, and the content of its buffers.
pub(super) struct Batched<'a> {
    uploaded: Box<dyn Uploaded + 'a>,
    batch: Batch,
    pub(super) scratch: ScratchLayout,
    instance_len: usize,
    palette_floats: usize,
    buffers: [(Resource, Vec<f32>); BUFFERS.len()],
}

impl<'a> Batched<'a> {
    /// Uploads a model, and poisons all other buffers.
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

    /// Writes each instance's part of some floats to its place in an array.
    pub(super) fn put(&mut self, resource: Resource, array: Array, floats: &[f32]) {
        if floats.is_empty() {
            return;
        }
        let n = self.instance_len;
        let out = self.floats(resource);
        for i in 0..n {
            let own = part(floats, n, i);
            out[array.offset + i * array.stride..][..own.len()].copy_from_slice(own);
        }
    }

    pub(super) fn put_poses(&mut self, poses: Poses<'_>) {
        self.put(Resource::Poses, self.batch.poses, floats(poses.joints));
        self.put(Resource::Curves, self.batch.curves, poses.curves);
    }

    /// Writes the outputs of stage polar.
    pub(super) fn put_split(&mut self, split: &Split) {
        let [turns, strains] = self.split_at();
        self.put(Resource::Scratch, turns, split.turns.as_flattened().as_flattened());
        self.put(Resource::Scratch, strains, split.strains.as_flattened());
    }

    pub(super) fn put_palettes(&mut self, palettes: &[Matrix3x4]) {
        self.put(Resource::Palettes, self.batch.palettes, floats(palettes));
    }

    /// Returns the place of an array in the scratch.
    pub(super) fn scratch_at(&self, offset: usize) -> Array {
        Array { offset, stride: self.scratch.len }
    }

    /// Returns the places of rotations and strains.
    pub(super) fn split_at(&self) -> [Array; 2] {
        [self.scratch.turns, self.scratch.strains].map(|offset| self.scratch_at(offset))
    }

    /// Uploads, runs the given stages alone or, if there are none, all stages, and downloads.
    /// Checks that only the floats of `own` and of the range `writable_skin` have changed.
    pub(super) fn run(
        &mut self,
        stages: &[Stage],
        own: &[Writable],
        writable_skin: Range<usize>,
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
            let mut writable = vec![false; floats.len()];
            for (_, array, len) in own.iter().filter(|(own, ..)| own == resource) {
                for i in 0..self.instance_len {
                    writable[array.offset + i * array.stride..][..*len].fill(true);
                }
            }
            if *resource == Resource::Out {
                writable[writable_skin.clone()].fill(true);
            }
            let stage = stages.first().map_or("the whole", |stage| stage.name());
            let changed = |(float, writable): (usize, bool)| {
                let same = found.get(float).map(|x| x.to_bits()) == Some(floats[float].to_bits());
                !writable && !same
            };
            if let Some(float) = writable.into_iter().enumerate().position(changed) {
                return Err(Failure::Touched { stage, resource: resource.name(), float });
            }
            *floats = found;
        }
        Ok(())
    }

    /// Copies each instance's part of an array out.
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

    /// Returns the floats of palettes that a stage may write.
    pub(super) fn writable_palettes(&self) -> Writable {
        (Resource::Palettes, self.batch.palettes, self.palette_floats)
    }

    /// Returns the floats of confidences that a stage may write.
    pub(super) fn writable_confidences(&self) -> Writable {
        (Resource::Confidences, CONFIDENCES, 1)
    }

    /// Copies the host's floats for skins into the buffer, up to the shorter length.
    pub(super) fn put_skin(&mut self, out: &[f32]) {
        let to = self.floats(Resource::Out);
        let len = out.len().min(to.len());
        to[..len].copy_from_slice(&out[..len]);
    }

    /// Copies the skins' floats out of the buffer.
    pub(super) fn take_skin(&mut self, out: &mut [f32]) {
        let from = self.floats(Resource::Out);
        let len = from.len().min(out.len());
        out[..len].copy_from_slice(&from[..len]);
    }

    /// Returns the range of the skins' floats that the comparing function checks itself; `host` is
    /// the length of the host's list.
    pub(super) fn writable_skin(&mut self, host: usize) -> Range<usize> {
        0..self.floats(Resource::Out).len().min(host)
    }
}

/// Describes a batch in which no array starts at 0 and every array has gaps; palettes are aligned
/// to 4 floats, as skins require.
fn batch(envelope: &Envelope<'_>, instance_len: usize, skin: Option<&SkinBatch>) -> Batch {
    Batch {
        instance_len,
        poses: Array { offset: 5, stride: 12 * envelope.joint_len() + 3 },
        curves: Array { offset: 2, stride: envelope.curve_len() + 4 },
        palettes: Array { offset: 4, stride: 12 * envelope.palette_len() + 8 },
        confidences: Some(CONFIDENCES),
        skin: skin.cloned(),
    }
}
