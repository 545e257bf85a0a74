//! From a pose to the palette: the stages of each predictor, one after the other.

use super::counts::{Predictor, place};
use super::level::Level;
use super::scratch::ScratchLayout;
use super::view::Envelope;
use super::{confidence, correction, features, gradients, joints, palette};
use crate::error::{Argument, CallError};
use crate::linear::Matrix3x4;

impl Envelope<'_> {
    /// Returns the floats of scratch that [`Envelope::palette`] needs.
    pub const fn scratch_len(&self) -> usize {
        self.scratch_layout().len
    }

    /// Returns the floats of scratch that the stage `correction` needs; 0 without groups.
    pub const fn correction_len(&self) -> usize {
        self.0.layout.counts[place::CORRECTION] as usize
    }

    const fn scratch_layout(&self) -> ScratchLayout {
        ScratchLayout::in_turn(self.joint_len(), self.proxy_len(), self.correction_len())
    }

    /// Computes the palette of a pose, and returns the confidence in it, in [0, 1]: 1 within what
    /// was seen in training, 0 far from it.
    ///
    /// Where a kernel map is not confident it fades, and its proxies tend to their base. No map hears a joint that
    /// kept still in training, and no fit knows its skin: as it turns, and as any joint does far beyond its trained
    /// range, the confidence falls. A rotational envelope has nothing to fade: its confidence tells only how far joints
    /// turn beyond their trained ranges. An envelope of joints alone is certain.
    ///
    /// - `pose`: J skinning matrices, rest to posed, in model space; rigid to 1e-4, which is not looked at here:
    ///   [`Envelope::check_pose`] does in a debug build.
    /// - `scratch`: at least [`Envelope::scratch_len`] floats, of any content.
    /// - `out_palette`: [`Envelope::palette_len`] transforms, rest to posed, in model space: what an
    ///   engine's own skinning shader takes together with [`crate::Skin::influences`].
    ///
    /// # Errors
    /// - [`crate::CallErrorKind::Length`]: `pose` or `out_palette` has another length.
    /// - [`crate::CallErrorKind::TooShort`]: `scratch` is too short.
    /// - [`crate::CallErrorKind::NonFinite`]: a joint's matrix is not finite.
    pub fn palette(
        &self,
        pose: &[Matrix3x4],
        scratch: &mut [f32],
        out_palette: &mut [Matrix3x4],
    ) -> Result<f32, CallError> {
        self.check_lengths(1, pose, scratch, out_palette)?;
        self.check_finite(pose)?;
        Ok(self.any_palette(pose, scratch, out_palette))
    }

    /// Computes a palette at a level of evaluation: at [`Level::Full`] with the bits of [`Envelope::palette`], at
    /// [`Level::Joints`] without the correction.
    ///
    /// Arguments and errors are those of [`Envelope::palette`]. Without the correction the confidence tells of a
    /// reconstruction how far joints turn beyond their trained ranges, and of joints alone is 1.
    ///
    /// # Errors
    /// Those of [`Envelope::palette`].
    pub fn palette_at(
        &self,
        level: Level,
        pose: &[Matrix3x4],
        scratch: &mut [f32],
        out_palette: &mut [Matrix3x4],
    ) -> Result<f32, CallError> {
        self.check_lengths(1, pose, scratch, out_palette)?;
        self.check_finite(pose)?;
        Ok(match level {
            Level::Full => self.any_palette(pose, scratch, out_palette),
            Level::Joints if self.predictor().reconstructs() => {
                self.reconstruct(pose, scratch, out_palette);
                let base = self.scratch_layout().base(scratch, self.proxy_len());
                confidence::evaluate(self, base.rotations)
            }
            Level::Joints => {
                joints::evaluate(self, pose, out_palette);
                1.0
            }
        })
    }

    /// Computes how confident each joint is of a pose, by the kernel maps of its skin and by its trained range: which
    /// part of the skin the confidence of [`Envelope::palette`] is about.
    ///
    /// - `pose`, `scratch`: as for [`Envelope::palette`].
    /// - `out_confidences`: J values in [0, 1]; of a joint whose skin no map moves, what its trained range
    ///   tells. 1 without maps.
    ///
    /// # Errors
    /// - [`crate::CallErrorKind::NoStage`]: the envelope is rotational and has no kernel maps.
    /// - [`crate::CallErrorKind::Length`]: `pose` or `out_confidences` has another length.
    /// - [`crate::CallErrorKind::TooShort`]: `scratch` is too short.
    /// - [`crate::CallErrorKind::NonFinite`]: a joint's matrix is not finite.
    // In line down to the map: where nobody asks, the map has one caller and lies in the frame of `palette`, which keeps the
    // stack of firmware small.
    #[inline]
    pub fn joint_confidences(
        &self,
        pose: &[Matrix3x4],
        scratch: &mut [f32],
        out_confidences: &mut [f32],
    ) -> Result<(), CallError> {
        self.check_stage(self.predictor().corrects())?;
        Argument::Pose.check_len(self.joint_len(), pose.len())?;
        Argument::Confidences.check_len(self.joint_len(), out_confidences.len())?;
        Argument::Scratch.check_least(self.scratch_len(), scratch.len())?;
        self.check_finite(pose)?;
        out_confidences.fill(1.0);
        if self.group_len() > 0 {
            let (features, scratch) = self.scratch_layout().correction(scratch);
            features::evaluate(self, pose, features);
            correction::joint_confidences(self, features, scratch, out_confidences);
        }
        Ok(())
    }

    /// Computes the palettes of a batch of poses, with the bits of [`Envelope::palette`] for each.
    ///
    /// - `poses`: J skinning matrices a pose, one pose after the other.
    /// - `scratch`: as for one pose.
    /// - `out_palettes`: [`Envelope::palette_len`] transforms a pose.
    /// - `out_confidences`: one a pose; their number is that of the poses.
    ///
    /// # Errors
    /// - [`crate::CallErrorKind::Length`]: `poses` or `out_palettes` has another length than
    ///   `out_confidences` asks for.
    /// - [`crate::CallErrorKind::TooShort`]: `scratch` is too short.
    /// - [`crate::CallErrorKind::NonFinite`]: a matrix is not finite; its index counts through all poses.
    pub fn palettes(
        &self,
        poses: &[Matrix3x4],
        scratch: &mut [f32],
        out_palettes: &mut [Matrix3x4],
        out_confidences: &mut [f32],
    ) -> Result<(), CallError> {
        self.check_lengths(out_confidences.len(), poses, scratch, out_palettes)?;
        // Counts of a loaded envelope are at least one; chunks of zero would panic.
        let (joint_len, palette_len) = (self.joint_len().max(1), self.palette_len().max(1));
        for (number, pose) in poses.chunks(joint_len).enumerate() {
            self.check_finite(pose).map_err(|error| error.at(number * joint_len + error.index))?;
        }
        let palettes = out_palettes.chunks_mut(palette_len);
        let poses = poses.chunks(joint_len).zip(palettes);
        for ((pose, palette), confidence) in poses.zip(out_confidences) {
            *confidence = self.any_palette(pose, scratch, palette);
        }
        Ok(())
    }

    /// Computes what [`Envelope::palette`] does, of a rotational envelope alone. A program that calls
    /// this and not the other is linked without kernel maps: on a Cortex-M4F 5 kB less at opt-level s,
    /// 9 kB at 3.
    ///
    /// # Errors
    /// - [`crate::CallErrorKind::NoStage`]: the envelope is not rotational.
    /// - Those of [`Envelope::palette`].
    pub fn rotational_palette(
        &self,
        pose: &[Matrix3x4],
        scratch: &mut [f32],
        out_palette: &mut [Matrix3x4],
    ) -> Result<f32, CallError> {
        self.check_stage(self.predictor() == Predictor::Rotational)?;
        self.check_lengths(1, pose, scratch, out_palette)?;
        self.check_finite(pose)?;
        Ok(self.reconstruct(pose, scratch, out_palette))
    }

    fn check_lengths(
        &self,
        pose_len: usize,
        poses: &[Matrix3x4],
        scratch: &[f32],
        palettes: &[Matrix3x4],
    ) -> Result<(), CallError> {
        let all = |each: usize| pose_len.saturating_mul(each);
        Argument::Pose.check_len(all(self.joint_len()), poses.len())?;
        Argument::Palette.check_len(all(self.palette_len()), palettes.len())?;
        Argument::Scratch.check_least(self.scratch_len(), scratch.len())
    }

    /// Computes a palette by the stages of the predictor.
    fn any_palette(
        &self,
        pose: &[Matrix3x4],
        scratch: &mut [f32],
        out_palette: &mut [Matrix3x4],
    ) -> f32 {
        // Both predictors end in one place: an early return took 1196 bytes of stack on Cortex-M, over the budget of 950.
        let mut confidence = 1.0;
        if self.predictor().reconstructs() {
            confidence = self.reconstruct(pose, scratch, out_palette);
        } else {
            joints::evaluate(self, pose, out_palette);
        }
        if self.group_len() > 0 {
            let (features, scratch) = self.scratch_layout().correction(scratch);
            features::evaluate(self, pose, features);
            confidence = correction::evaluate(self, pose, features, scratch, out_palette);
        }
        confidence
    }

    /// Computes the palette by rotational regression, and the confidence in it.
    fn reconstruct(
        &self,
        pose: &[Matrix3x4],
        scratch: &mut [f32],
        out_palette: &mut [Matrix3x4],
    ) -> f32 {
        let base = self.scratch_layout().base(scratch, self.proxy_len());
        gradients::evaluate(self, pose, base.relative, base.rotations, base.gradients);
        let root = pose.get(self.root()).unwrap_or(&[[0.0; 4]; 3]);
        palette::evaluate(self, root, base.relative, base.gradients, out_palette);
        confidence::evaluate(self, base.rotations)
    }
}
