//! The stages on a device. All arrays have gaps between them, and a stage must not change the gaps.

mod alone;
mod batched;

use crate::backend::{Backend, Failure, Gradients, Loaded, Poses, Split, Whole};
use crate::filters::FilterSubject;
use crate::kernels::KernelSubject;
use crate::shapes::ShapeSubject;
use batched::Batched;
use sinew_gpu::headless::Device;
use sinew_gpu::layout::{Batch, DeviceLimits, Plan, Resource, ShapesBatch, SkinBatch, Stage};
use sinew_runtime::Matrix3x4;
use sinew_runtime::envelope::STRAIN_LEN;
use sinew_trainer::regression::arithmetic::Arithmetic;

/// A device as a backend.
pub struct Gpu<'a> {
    /// The device.
    pub device: &'a dyn Device,
    /// Limits for plans: the device's limits, or lower ones to cut batches into chunks.
    pub limits: DeviceLimits,
}

impl<'a> Gpu<'a> {
    /// Wraps a device at its own limits.
    pub fn new(device: &'a dyn Device) -> Self {
        Self { device, limits: device.limits() }
    }

    fn begin(
        &self,
        loaded: &Loaded<'_>,
        instance_len: usize,
        skin: Option<&SkinBatch>,
    ) -> Result<Batched<'_>, Failure> {
        Batched::new(self.device, &self.limits, loaded, instance_len, skin)
    }
}

impl Backend for Gpu<'_> {
    fn arithmetic(&self) -> Arithmetic {
        Arithmetic::VULKAN
    }

    fn has(&self, loaded: &Loaded<'_>, stage: Stage) -> bool {
        let Loaded { model, envelope, skin } = loaded;
        let batch = Batch::skinned(envelope, skin, 1);
        let plan = Plan::new(model, envelope, &batch, &self.limits);
        plan.is_ok_and(|plan| plan.stages().any(|own| own == stage))
    }

    fn polar(&self, loaded: &Loaded<'_>, poses: Poses<'_>, out: &mut Split) -> Result<(), Failure> {
        let joint_len = loaded.envelope.joint_len();
        let mut batched = self.begin(loaded, poses.len, None)?;
        batched.put_poses(poses);
        let [turns, strains] = batched.split_at();
        let own = [(turns, 9 * joint_len), (strains, STRAIN_LEN * joint_len)];
        let own = own.map(|(array, len)| (Resource::Scratch, array, len));
        batched.run(&[Stage::Polar], &own, 0..0)?;
        let out_turns = out.turns.as_flattened_mut().as_flattened_mut();
        batched.take(Resource::Scratch, turns, out_turns);
        batched.take(Resource::Scratch, strains, out.strains.as_flattened_mut());
        Ok(())
    }

    fn gradients(
        &self,
        loaded: &Loaded<'_>,
        poses: Poses<'_>,
        split: &Split,
        out: &mut Gradients,
    ) -> Result<(), Failure> {
        let envelope = &loaded.envelope;
        let (j, p) = (envelope.joint_len(), envelope.proxy_len());
        let mut batched = self.begin(loaded, poses.len, None)?;
        batched.put_poses(poses);
        batched.put_split(split);
        let scratch = batched.scratch;
        let [q, theta, d] = [scratch.relative, scratch.rotations, scratch.gradients]
            .map(|offset| batched.scratch_at(offset));
        let own = [(q, 12 * j), (theta, 3 * j), (d, 9 * p)];
        let own = own.map(|(array, len)| (Resource::Scratch, array, len));
        batched.run(&[Stage::Gradients], &own, 0..0)?;
        batched.take(Resource::Scratch, q, out.relative.as_flattened_mut());
        batched.take(Resource::Scratch, theta, out.rotations.as_flattened_mut());
        batched.take(Resource::Scratch, d, out.gradients.as_flattened_mut());
        Ok(())
    }

    fn palette(
        &self,
        loaded: &Loaded<'_>,
        poses: Poses<'_>,
        input: &Gradients,
        out_palettes: &mut [Matrix3x4],
    ) -> Result<(), Failure> {
        let mut batched = self.begin(loaded, poses.len, None)?;
        batched.put_poses(poses);
        let [q, d] = [batched.scratch.relative, batched.scratch.gradients]
            .map(|offset| batched.scratch_at(offset));
        batched.put(Resource::Scratch, q, input.relative.as_flattened());
        batched.put(Resource::Scratch, d, input.gradients.as_flattened());
        let own = batched.writable_palettes();
        batched.run(&[Stage::Palette], &[own], 0..0)?;
        batched.take_palettes(out_palettes);
        Ok(())
    }

    fn joints(
        &self,
        loaded: &Loaded<'_>,
        poses: Poses<'_>,
        out_palettes: &mut [Matrix3x4],
    ) -> Result<(), Failure> {
        let mut batched = self.begin(loaded, poses.len, None)?;
        batched.put_poses(poses);
        let own = batched.writable_palettes();
        batched.run(&[Stage::Joints], &[own], 0..0)?;
        batched.take_palettes(out_palettes);
        Ok(())
    }

    fn features(
        &self,
        loaded: &Loaded<'_>,
        poses: Poses<'_>,
        split: &Split,
        out_features: &mut [f32],
    ) -> Result<(), Failure> {
        let envelope = &loaded.envelope;
        let (j, c) = (envelope.joint_len(), envelope.curve_len());
        let mut batched = self.begin(loaded, poses.len, None)?;
        batched.put_poses(poses);
        batched.put_split(split);
        let first = batched.scratch.features;
        let last = first + envelope.counts().feature_len() - c;
        let [at, curves] = [first, last].map(|offset| batched.scratch_at(offset));
        // The strains, between the two, stay as stage polar has written them.
        let own = [(Resource::Scratch, at, 12 * j), (Resource::Scratch, curves, c)];
        batched.run(&[Stage::Features], &own, 0..0)?;
        batched.take(Resource::Scratch, at, out_features);
        Ok(())
    }

    fn correction(
        &self,
        loaded: &Loaded<'_>,
        poses: Poses<'_>,
        features: &[f32],
        out_palettes: &mut [Matrix3x4],
        out_confidences: &mut [f32],
    ) -> Result<(), Failure> {
        let mut batched = self.begin(loaded, poses.len, None)?;
        batched.put_poses(poses);
        batched.put_palettes(out_palettes);
        let at = batched.scratch_at(batched.scratch.features);
        batched.put(Resource::Scratch, at, features);
        let scratch = batched.scratch_at(batched.scratch.confidences);
        let scratch_len = batched.scratch.len - batched.scratch.confidences;
        let (own, confidences) = (batched.writable_palettes(), batched.writable_confidences());
        let own = [own, confidences, (Resource::Scratch, scratch, scratch_len)];
        batched.run(&[Stage::Correction, Stage::Confidence], &own, 0..0)?;
        batched.take_palettes(out_palettes);
        batched.take(Resource::Confidences, confidences.1, out_confidences);
        Ok(())
    }

    fn confidence(
        &self,
        loaded: &Loaded<'_>,
        poses: Poses<'_>,
        rotations: &[[f32; 3]],
        split: &Split,
        out_confidences: &mut [f32],
    ) -> Result<(), Failure> {
        let mut batched = self.begin(loaded, poses.len, None)?;
        batched.put_poses(poses);
        batched.put_split(split);
        let at = batched.scratch_at(batched.scratch.rotations);
        batched.put(Resource::Scratch, at, rotations.as_flattened());
        let own = batched.writable_confidences();
        batched.run(&[Stage::Confidence], &[own], 0..0)?;
        batched.take(Resource::Confidences, own.1, out_confidences);
        Ok(())
    }

    fn skin(
        &self,
        loaded: &Loaded<'_>,
        palettes: &[Matrix3x4],
        skin: &SkinBatch,
        out: &mut [f32],
    ) -> Result<(), Failure> {
        if skin.vertices.is_empty() {
            return Ok(());
        }
        let n = palettes.len() / loaded.envelope.palette_len();
        let mut batched = self.begin(loaded, n, Some(skin))?;
        batched.put_palettes(palettes);
        batched.put_skin(out);
        let own = batched.writable_skin(out.len());
        batched.run(&[Stage::Skin], &[], own)?;
        batched.take_skin(out);
        Ok(())
    }

    fn kernel(
        &self,
        subject: &KernelSubject<'_>,
        queries: &[f32],
        out: &mut [f32],
        out_confidences: &mut [f32],
    ) -> Result<(), Failure> {
        alone::kernel(self.device, &self.limits, subject, queries, [out, out_confidences])
    }

    fn shapes(
        &self,
        subject: &ShapeSubject<'_>,
        batch: &ShapesBatch,
        out: &mut [f32],
    ) -> Result<(), Failure> {
        alone::shapes(self.device, &self.limits, subject, batch, out)
    }

    fn filter(&self, subject: &FilterSubject<'_>, out: &mut [f32]) -> Result<(), Failure> {
        alone::filter(self.device, &self.limits, subject, out)
    }

    fn whole(
        &self,
        loaded: &Loaded<'_>,
        poses: Poses<'_>,
        skin: &SkinBatch,
        out: &mut Whole,
    ) -> Result<(), Failure> {
        let mut batched = self.begin(loaded, poses.len, Some(skin))?;
        batched.put_poses(poses);
        batched.put_skin(&out.skin);
        let scratch = (Resource::Scratch, batched.scratch_at(0), batched.scratch.len);
        let (palettes, confidences) = (batched.writable_palettes(), batched.writable_confidences());
        let own = batched.writable_skin(out.skin.len());
        batched.run(&[], &[scratch, palettes, confidences], own)?;
        batched.take_palettes(&mut out.palettes);
        batched.take(Resource::Confidences, confidences.1, &mut out.confidences);
        batched.take_skin(&mut out.skin);
        Ok(())
    }
}
