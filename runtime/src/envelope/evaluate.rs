//! Evaluation from a pose to the palette: the stages of each predictor in order.

use super::counts::{Predictor, place};
use super::pose::Pose;
use super::scratch::ScratchLayout;
use super::view::Envelope;
use super::{confidence, helpers, polar, rotational};
use crate::error::{Argument, CallError};
use crate::linear::Matrix3x4;

impl Envelope<'_> {
    /// Returns the floats of scratch that [`Envelope::palette`] needs.
    pub const fn scratch_len(&self) -> usize {
        self.scratch_layout().len
    }

    /// Returns the floats of scratch that stage `correction` needs; 0 without groups.
    #[cfg_attr(feature = "internals", visibility::make(pub))]
    pub(crate) const fn correction_len(&self) -> usize {
        self.0.layout.counts[place::CORRECTION] as usize
    }

    const fn scratch_layout(&self) -> ScratchLayout {
        ScratchLayout::in_turn(&self.counts())
    }

    /// Computes the palette of a pose, and returns the confidence in [0, 1]: 1 within the trained range, 0 far outside.
    ///
    /// A kernel map of low confidence gets a low weight, so its helpers stay near their base. The confidence also falls
    /// when a joint turns or stretches, or a curve goes, far beyond its trained range. A joint that never moved in
    /// training has a range of 0, and is no input of any map.
    ///
    /// The confidence of a rotational envelope depends only on the trained ranges of the joints, and changes no
    /// transform. The confidence of an envelope without helpers is 1.
    ///
    /// A joint that is scaled to 0, or mirrored, has the features of the rest pose and confidence 0.
    ///
    /// - `pose`: J skinning matrices, rest to posed, in model space; rigid to 1e-4 where [`Envelope::stretch_range`] is
    ///   0. This function does not check the pose: call [`Envelope::check_pose`] in a debug build.
    /// - `curves`: values of the C curves, in the order of [`Envelope::curve_name`]; empty for a model without curves.
    /// - `scratch`: at least [`Envelope::scratch_len`] floats, of any content.
    /// - `out_palette`: [`Envelope::palette_len`] transforms, rest to posed, in model space. The skinning shader of an
    ///   engine takes the palette together with [`crate::Skin::influences`].
    ///
    /// # Errors
    /// - [`crate::CallErrorKind::Length`]: `pose`, `curves` or `out_palette` has another length.
    /// - [`crate::CallErrorKind::TooShort`]: `scratch` is too short.
    /// - [`crate::CallErrorKind::NonFinite`]: a joint's matrix or a curve is not finite.
    pub fn palette(
        &self,
        pose: &[Matrix3x4],
        curves: &[f32],
        scratch: &mut [f32],
        out_palette: &mut [Matrix3x4],
    ) -> Result<f32, CallError> {
        let pose = Pose { joints: pose, curves };
        self.check_lengths(1, pose, scratch, out_palette)?;
        self.check_finite(pose)?;
        Ok(self.any_palette(pose, scratch, out_palette))
    }

    /// Computes the base of the palette, for a character that is far away: the palette without the correction.
    ///
    /// The cost is next to nothing for a kernel envelope, whose base is its joints, and the full cost for a rotational
    /// envelope. [`super::Certificate::base_training_rms`] is the error. The arguments and the result are as for
    /// [`Envelope::palette`]; the confidence is 1 unless the envelope is rotational.
    ///
    /// # Errors
    /// The errors of [`Envelope::palette`].
    pub fn base_palette(
        &self,
        pose: &[Matrix3x4],
        curves: &[f32],
        scratch: &mut [f32],
        out_palette: &mut [Matrix3x4],
    ) -> Result<f32, CallError> {
        let pose = Pose { joints: pose, curves };
        self.check_lengths(1, pose, scratch, out_palette)?;
        self.check_finite(pose)?;
        if self.predictor().reconstructs() {
            return Ok(self.any_palette(pose, scratch, out_palette));
        }
        helpers::joints(self, pose.joints, out_palette);
        Ok(1.0)
    }

    /// Computes the confidence of each joint, which shows where the confidence of [`Envelope::palette`] comes from.
    ///
    /// The confidence of a joint is the least of two: from the joint's trained range, and from the kernel maps of the
    /// groups that the joint dominates. All confidences are 1 without kernel maps.
    ///
    /// - `pose`, `curves`, `scratch`: as for [`Envelope::palette`].
    /// - `out_confidences`: J values in [0, 1].
    ///
    /// # Errors
    /// - [`crate::CallErrorKind::NoStage`]: the envelope is rotational and has no kernel maps.
    /// - [`crate::CallErrorKind::Length`]: `pose`, `curves` or `out_confidences` has another length.
    /// - [`crate::CallErrorKind::TooShort`]: `scratch` is too short.
    /// - [`crate::CallErrorKind::NonFinite`]: a joint's matrix or a curve is not finite.
    // Inlined down to the map. In firmware that never calls this function, the map then has one caller and is inlined
    // into `palette`, which keeps the stack small.
    #[inline]
    pub fn joint_confidences(
        &self,
        pose: &[Matrix3x4],
        curves: &[f32],
        scratch: &mut [f32],
        out_confidences: &mut [f32],
    ) -> Result<(), CallError> {
        let pose = Pose { joints: pose, curves };
        self.check_stage(self.predictor().corrects())?;
        Argument::Pose.check_len(self.joint_len(), pose.joints.len())?;
        Argument::Confidences.check_len(self.joint_len(), out_confidences.len())?;
        Argument::Scratch.check_least(self.scratch_len(), scratch.len())?;
        self.check_finite(pose)?;
        out_confidences.fill(1.0);
        if self.group_len() > 0 {
            let (features, turns, scratch) = self.scratch_layout().correction(scratch);
            helpers::all_features(self, pose, turns, features);
            helpers::joint_confidences(self, pose.joints, features, scratch, out_confidences);
        }
        Ok(())
    }

    /// Computes the palettes of a batch of poses, with the bits of [`Envelope::palette`] for each.
    ///
    /// - `poses`: J skinning matrices for each pose, one pose after the other.
    /// - `curves`: C values for each pose.
    /// - `scratch`: as for one pose.
    /// - `out_palettes`: [`Envelope::palette_len`] transforms for each pose.
    /// - `out_confidences`: one confidence for each pose. Its length is the number of poses.
    ///
    /// # Errors
    /// - [`crate::CallErrorKind::Length`]: the length of `poses`, `curves` or `out_palettes` does not match the number
    ///   of poses.
    /// - [`crate::CallErrorKind::TooShort`]: `scratch` is too short.
    /// - [`crate::CallErrorKind::NonFinite`]: a matrix or a curve is not finite; its index counts through all poses.
    pub fn palettes(
        &self,
        poses: &[Matrix3x4],
        curves: &[f32],
        scratch: &mut [f32],
        out_palettes: &mut [Matrix3x4],
        out_confidences: &mut [f32],
    ) -> Result<(), CallError> {
        let all = Pose { joints: poses, curves };
        self.check_lengths(out_confidences.len(), all, scratch, out_palettes)?;
        all.check_finite()?;
        // A loaded envelope has a transform in its palette; chunks of 0 would panic.
        let palettes = out_palettes.chunks_mut(self.palette_len().max(1));
        let mut rest = all;
        for (palette, confidence) in palettes.zip(out_confidences) {
            let pose;
            (pose, rest) = rest.split(self.joint_len(), self.curve_len());
            *confidence = self.any_palette(pose, scratch, palette);
        }
        Ok(())
    }

    /// Computes the palette of a rotational envelope, with the bits of [`Envelope::palette`].
    ///
    /// A program that calls only this function links no kernel maps. On a Cortex-M4F that saves 6 kB at opt-level s,
    /// and 9 kB at opt-level 3.
    ///
    /// # Errors
    /// - [`crate::CallErrorKind::NoStage`]: the envelope is not rotational.
    /// - The errors of [`Envelope::palette`].
    pub fn rotational_palette(
        &self,
        pose: &[Matrix3x4],
        scratch: &mut [f32],
        out_palette: &mut [Matrix3x4],
    ) -> Result<f32, CallError> {
        self.check_stage(self.predictor() == Predictor::Rotational)?;
        // A rotational envelope has no curves.
        Argument::Palette.check_len(self.proxy_len(), out_palette.len())?;
        let scratch_len = ScratchLayout::of_base(&self.counts()).len;
        Argument::Scratch.check_least(scratch_len, scratch.len())?;
        self.check_joints(pose)?;
        Ok(self.reconstruct(pose, scratch, out_palette))
    }

    fn check_lengths(
        &self,
        pose_len: usize,
        poses: Pose<'_>,
        scratch: &[f32],
        palettes: &[Matrix3x4],
    ) -> Result<(), CallError> {
        let all = |each: usize| pose_len.saturating_mul(each);
        Argument::Pose.check_len(all(self.joint_len()), poses.joints.len())?;
        Argument::Curves.check_len(all(self.curve_len()), poses.curves.len())?;
        Argument::Palette.check_len(all(self.palette_len()), palettes.len())?;
        Argument::Scratch.check_least(self.scratch_len(), scratch.len())
    }

    /// Computes the palette with either predictor.
    fn any_palette(
        &self,
        pose: Pose<'_>,
        scratch: &mut [f32],
        out_palette: &mut [Matrix3x4],
    ) -> f32 {
        // No early return: one took 1196 bytes of stack on a Cortex-M, over the budget of 950.
        let mut confidence = 1.0;
        if self.predictor().reconstructs() {
            confidence = self.reconstruct(pose.joints, scratch, out_palette);
        } else {
            helpers::joints(self, pose.joints, out_palette);
        }
        if self.group_len() > 0 {
            let (features, turns, scratch) = self.scratch_layout().correction(scratch);
            helpers::all_features(self, pose, turns, features);
            confidence = helpers::correction(self, pose.joints, features, scratch, out_palette);
        }
        confidence
    }

    /// Computes the palette by rotational regression, and the confidence.
    fn reconstruct(
        &self,
        pose: &[Matrix3x4],
        scratch: &mut [f32],
        out_palette: &mut [Matrix3x4],
    ) -> f32 {
        let base = ScratchLayout::of_base(&self.counts()).base(scratch);
        if self.stretches() {
            polar::polar(self, pose, base.turns, base.strains);
        }
        let split = (&*base.turns, &*base.strains);
        rotational::gradients(self, pose, split, base.relative, base.rotations, base.gradients);
        let root = pose.get(self.root()).unwrap_or(&[[0.0; 4]; 3]);
        rotational::palette(self, root, base.relative, base.gradients, out_palette);
        confidence::of_rotations(self, pose, base.rotations, base.strains)
    }
}
