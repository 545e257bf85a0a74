//! The stages on a device. Everything lies with room between: what a stage has no business with must
//! stay as it was.

use crate::backend::{Backend, Buffers, Failure, Gradients, Loaded, Whole, part};
use crate::compare::POISON;
use sinew_gpu::headless::{Device, Uploaded};
use sinew_gpu::layout::{Array, Batch, DeviceLimits, Plan, Resource, Skin, Stage, WorkLayout};
use sinew_runtime::{Envelope, Matrix3x4};
use sinew_trainer::kernel::arithmetic::Arithmetic;
use std::ops::Range;

/// What a stage may write to, other than the host's own writes.
const BUFFERS: [Resource; 6] = [
    Resource::Poses,
    Resource::Work,
    Resource::Palettes,
    Resource::Confidences,
    Resource::OutA,
    Resource::OutB,
];

/// A device as a backend.
pub struct Gpu<'a> {
    /// The device.
    pub device: &'a dyn Device,
    /// What batches are planned by: the device's limits, or less, so that batches are cut.
    pub limits: DeviceLimits,
}

impl<'a> Gpu<'a> {
    /// Takes a device at its own limits.
    pub fn new(device: &'a dyn Device) -> Self {
        Self { device, limits: device.limits() }
    }

    fn begin(
        &self,
        loaded: &Loaded<'_>,
        instance_len: usize,
        skin: Option<&Skin>,
    ) -> Result<Batched<'_>, Failure> {
        let envelope = &loaded.envelope;
        let batch = batch(envelope, instance_len, skin);
        let plan = Plan::new(&loaded.model, envelope, &batch, &self.limits)?;
        let uploaded = self.device.upload(&loaded.model, &plan)?;
        let poisoned = |resource| (resource, vec![POISON; (plan.bytes(resource) / 4) as usize]);
        let work = WorkLayout::new(envelope);
        let buffers = BUFFERS.map(poisoned);
        Ok(Batched { uploaded, batch, work, instance_len, buffers })
    }
}

/// Describes a batch in which nothing starts at 0 and nothing follows closely; palettes in fours, as
/// skins ask for.
fn batch(envelope: &Envelope<'_>, instance_len: usize, skin: Option<&Skin>) -> Batch {
    Batch {
        instance_len,
        poses: Array { offset: 5, stride: 12 * envelope.joint_len() + 3 },
        palettes: Array { offset: 4, stride: 12 * envelope.palette_len() + 8 },
        confidences: Some(Array { offset: 1, stride: 2 }),
        skin: skin.cloned(),
    }
}

/// A batch on its device, and what its buffers hold.
struct Batched<'a> {
    uploaded: Box<dyn Uploaded + 'a>,
    batch: Batch,
    work: WorkLayout,
    instance_len: usize,
    buffers: [(Resource, Vec<f32>); 6],
}

impl Batched<'_> {
    fn floats(&mut self, resource: Resource) -> &mut Vec<f32> {
        let own = self.buffers.iter_mut().find(|(own, _)| *own == resource);
        &mut own.expect("the host writes to it").1
    }

    /// Puts each instance's part of some floats where an array lies.
    fn put(&mut self, resource: Resource, array: Array, floats: &[f32]) {
        let n = self.instance_len;
        let out = self.floats(resource);
        for i in 0..n {
            let own = part(floats, n, i);
            out[array.offset + i * array.stride..][..own.len()].copy_from_slice(own);
        }
    }

    fn put_poses(&mut self, poses: &[Matrix3x4]) {
        self.put(Resource::Poses, self.batch.poses, floats(poses));
    }

    fn put_palettes(&mut self, palettes: &[Matrix3x4]) {
        self.put(Resource::Palettes, self.batch.palettes, floats(palettes));
    }

    /// Where an array lies in the work.
    fn work(&self, offset: usize) -> Array {
        Array { offset, stride: self.work.len }
    }

    /// Uploads, runs some stages alone, or else all of them, and downloads. Only what `own` lists of
    /// each instance may have changed.
    fn run(
        &mut self,
        stages: &[Stage],
        own: &[(Resource, Array, usize)],
        own_vertices: &[(Resource, Range<usize>)],
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
            for (_, range) in own_vertices.iter().filter(|(own, _)| own == resource) {
                may[range.clone()].fill(true);
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
    fn take(&mut self, resource: Resource, array: Array, out: &mut [f32]) {
        let n = self.instance_len;
        let len = out.len() / n;
        let found = self.floats(resource);
        for (i, out) in out.chunks_mut(len.max(1)).enumerate() {
            out.copy_from_slice(&found[array.offset + i * array.stride..][..len]);
        }
    }

    fn take_palettes(&mut self, out: &mut [Matrix3x4]) {
        let array = self.batch.palettes;
        self.take(Resource::Palettes, array, out.as_flattened_mut().as_flattened_mut());
    }

    /// What a stage writes of palettes, of confidences.
    fn own_palettes(&self) -> (Resource, Array, usize) {
        let array = self.batch.palettes;
        (Resource::Palettes, array, array.stride - 8)
    }

    fn own_confidences(&self) -> (Resource, Array, usize) {
        let array = Array { offset: 1, stride: 2 };
        (Resource::Confidences, array, 1)
    }

    /// Copies the host's buffers for skins in: as much of them as the device has.
    fn put_skin(&mut self, out: &Buffers) {
        for (resource, from) in [(Resource::OutA, &out.a), (Resource::OutB, &out.b)] {
            let to = self.floats(resource);
            let len = from.len().min(to.len());
            to[..len].copy_from_slice(&from[..len]);
        }
    }

    /// Copies them out.
    fn take_skin(&mut self, out: &mut Buffers) {
        for (resource, to) in [(Resource::OutA, &mut out.a), (Resource::OutB, &mut out.b)] {
            let from = self.floats(resource);
            let len = from.len().min(to.len());
            to[..len].copy_from_slice(&from[..len]);
        }
    }

    /// The part of the buffers for skins that the body looks after.
    fn own_skin(&self, out: &Buffers) -> [(Resource, Range<usize>); 2] {
        [(Resource::OutA, &out.a), (Resource::OutB, &out.b)]
            .map(|(resource, host)| (resource, 0..self.within(resource, host.len())))
    }

    /// Counts the floats of a host's buffer that the device has as well.
    fn within(&self, resource: Resource, host: usize) -> usize {
        let device = self.buffers.iter().find(|(own, _)| *own == resource);
        device.map_or(0, |(_, floats)| floats.len().min(host))
    }
}

impl Backend for Gpu<'_> {
    fn arithmetic(&self) -> Arithmetic {
        Arithmetic::VULKAN
    }

    fn has(&self, loaded: &Loaded<'_>, stage: Stage) -> bool {
        let envelope = &loaded.envelope;
        let plan = Plan::new(&loaded.model, envelope, &Batch::skinned(envelope, 1), &self.limits);
        plan.is_ok_and(|plan| plan.stages().any(|own| own == stage))
    }

    fn gradients(
        &self,
        loaded: &Loaded<'_>,
        poses: &[Matrix3x4],
        out: &mut Gradients,
    ) -> Result<(), Failure> {
        let envelope = &loaded.envelope;
        let (j, p) = (envelope.joint_len(), envelope.proxy_len());
        let mut batched = self.begin(loaded, poses.len() / j, None)?;
        batched.put_poses(poses);
        let (work, work_at) = (batched.work, |offset| Array { offset, stride: batched.work.len });
        let [q, theta, d] = [work.relative, work.rotations, work.gradients].map(work_at);
        let own = [(q, 12 * j), (theta, 3 * j), (d, 9 * p)];
        let own = own.map(|(array, len)| (Resource::Work, array, len));
        batched.run(&[Stage::Gradients], &own, &[])?;
        batched.take(Resource::Work, q, out.relative.as_flattened_mut());
        batched.take(Resource::Work, theta, out.rotations.as_flattened_mut());
        batched.take(Resource::Work, d, out.gradients.as_flattened_mut());
        Ok(())
    }

    fn palette(
        &self,
        loaded: &Loaded<'_>,
        poses: &[Matrix3x4],
        input: &Gradients,
        out_palettes: &mut [Matrix3x4],
    ) -> Result<(), Failure> {
        let mut batched = self.begin(loaded, poses.len() / loaded.envelope.joint_len(), None)?;
        batched.put_poses(poses);
        let [q, d] = [batched.work.relative, batched.work.gradients].map(|at| batched.work(at));
        batched.put(Resource::Work, q, input.relative.as_flattened());
        batched.put(Resource::Work, d, input.gradients.as_flattened());
        let own = batched.own_palettes();
        batched.run(&[Stage::Palette], &[own], &[])?;
        batched.take_palettes(out_palettes);
        Ok(())
    }

    fn joints(
        &self,
        loaded: &Loaded<'_>,
        poses: &[Matrix3x4],
        out_palettes: &mut [Matrix3x4],
    ) -> Result<(), Failure> {
        let mut batched = self.begin(loaded, poses.len() / loaded.envelope.joint_len(), None)?;
        batched.put_poses(poses);
        let own = batched.own_palettes();
        batched.run(&[Stage::Joints], &[own], &[])?;
        batched.take_palettes(out_palettes);
        Ok(())
    }

    fn features(
        &self,
        loaded: &Loaded<'_>,
        poses: &[Matrix3x4],
        out_features: &mut [Matrix3x4],
    ) -> Result<(), Failure> {
        let joint_len = loaded.envelope.joint_len();
        let mut batched = self.begin(loaded, poses.len() / joint_len, None)?;
        batched.put_poses(poses);
        let at = batched.work(batched.work.features);
        batched.run(&[Stage::Features], &[(Resource::Work, at, 12 * joint_len)], &[])?;
        batched.take(Resource::Work, at, out_features.as_flattened_mut().as_flattened_mut());
        Ok(())
    }

    fn correction(
        &self,
        loaded: &Loaded<'_>,
        poses: &[Matrix3x4],
        features: &[Matrix3x4],
        out_palettes: &mut [Matrix3x4],
        out_confidences: &mut [f32],
    ) -> Result<(), Failure> {
        let mut batched = self.begin(loaded, out_confidences.len(), None)?;
        batched.put_poses(poses);
        batched.put_palettes(out_palettes);
        let at = batched.work(batched.work.features);
        batched.put(Resource::Work, at, floats(features));
        let scratch = batched.work(batched.work.certainties);
        let scratch_len = batched.work.len - batched.work.certainties;
        let (own, confidences) = (batched.own_palettes(), batched.own_confidences());
        let own = [own, confidences, (Resource::Work, scratch, scratch_len)];
        batched.run(&[Stage::Correction, Stage::Confidence], &own, &[])?;
        batched.take_palettes(out_palettes);
        batched.take(Resource::Confidences, confidences.1, out_confidences);
        Ok(())
    }

    fn confidence(
        &self,
        loaded: &Loaded<'_>,
        rotations: &[[f32; 3]],
        out_confidences: &mut [f32],
    ) -> Result<(), Failure> {
        let mut batched = self.begin(loaded, out_confidences.len(), None)?;
        let at = batched.work(batched.work.rotations);
        batched.put(Resource::Work, at, rotations.as_flattened());
        let own = batched.own_confidences();
        batched.run(&[Stage::Confidence], &[own], &[])?;
        batched.take(Resource::Confidences, own.1, out_confidences);
        Ok(())
    }

    fn skin(
        &self,
        loaded: &Loaded<'_>,
        palettes: &[Matrix3x4],
        skin: &Skin,
        out: &mut Buffers,
    ) -> Result<(), Failure> {
        if skin.vertices.is_empty() {
            return Ok(());
        }
        let n = palettes.len() / loaded.envelope.palette_len();
        let mut batched = self.begin(loaded, n, Some(skin))?;
        batched.put_palettes(palettes);
        batched.put_skin(out);
        let own = batched.own_skin(out);
        batched.run(&[Stage::Skin], &[], &own)?;
        batched.take_skin(out);
        Ok(())
    }

    fn whole(
        &self,
        loaded: &Loaded<'_>,
        poses: &[Matrix3x4],
        skin: &Skin,
        out: &mut Whole,
    ) -> Result<(), Failure> {
        let mut batched = self.begin(loaded, out.confidences.len(), Some(skin))?;
        batched.put_poses(poses);
        batched.put_skin(&out.skin);
        let work = (Resource::Work, batched.work(0), batched.work.len);
        let (palettes, confidences) = (batched.own_palettes(), batched.own_confidences());
        let own = batched.own_skin(&out.skin);
        batched.run(&[], &[work, palettes, confidences], &own)?;
        batched.take_palettes(&mut out.palettes);
        batched.take(Resource::Confidences, confidences.1, &mut out.confidences);
        batched.take_skin(&mut out.skin);
        Ok(())
    }
}

fn floats(maps: &[Matrix3x4]) -> &[f32] {
    maps.as_flattened().as_flattened()
}
