//! Faulty backends: the runtime with altered outputs, and one that does nothing.

use conformance::backend::{Backend, Failure, Gradients, Loaded, Poses, Split, Whole};
use conformance::cpu::Cpu;
use conformance::filters::FilterSubject;
use conformance::kernels::KernelSubject;
use conformance::shapes::ShapeSubject;
use conformance::tolerance::Arithmetic;
use sinew_gpu::layout::{ShapesBatch, SkinBatch, Stage};
use sinew_runtime::Matrix3x4;

/// Inputs and outputs of a stage.
pub(crate) enum Step<'a> {
    Polar {
        poses: Poses<'a>,
        out: &'a mut Split,
    },
    Gradients {
        poses: Poses<'a>,
        out: &'a mut Gradients,
    },
    Palette {
        poses: Poses<'a>,
        input: &'a Gradients,
        out: &'a mut [Matrix3x4],
    },
    Features {
        poses: Poses<'a>,
        out: &'a mut [f32],
    },
    Correction {
        poses: Poses<'a>,
        features: &'a [f32],
        base: Vec<Matrix3x4>,
        out: &'a mut [Matrix3x4],
        confidences: &'a mut [f32],
    },
    Confidence {
        poses: Poses<'a>,
        rotations: &'a [[f32; 3]],
        out: &'a mut [f32],
    },
    Skin {
        palettes: &'a [Matrix3x4],
        skin: &'a SkinBatch,
        out: &'a mut [f32],
    },
    Shapes {
        batch: &'a ShapesBatch,
        out: &'a mut [f32],
    },
    Filter {
        out: &'a mut [f32],
    },
    Kernel {
        queries: &'a [f32],
        out: &'a mut [f32],
        confidences: &'a mut [f32],
    },
}

/// The runtime with altered outputs, or a backend that does nothing.
pub(crate) struct Altered<F> {
    /// Alters the outputs of each step; `None` leaves all outputs as they come.
    alter: Option<F>,
    /// The precision that the backend claims.
    arithmetic: Arithmetic,
}

/// Returns the runtime with outputs that a closure alters.
pub(crate) fn altered<F: Fn(Step<'_>)>(alter: F, arithmetic: Arithmetic) -> Altered<F> {
    Altered { alter: Some(alter), arithmetic }
}

/// Returns a backend that writes nothing, and reports success.
pub(crate) fn idle() -> Altered<fn(Step<'_>)> {
    Altered { alter: None, arithmetic: Arithmetic::IEEE }
}

impl<F: Fn(Step<'_>)> Backend for Altered<F> {
    fn arithmetic(&self) -> Arithmetic {
        self.arithmetic
    }

    fn has(&self, loaded: &Loaded<'_>, stage: Stage) -> bool {
        Cpu.has(loaded, stage)
    }

    fn polar(&self, loaded: &Loaded<'_>, poses: Poses<'_>, out: &mut Split) -> Result<(), Failure> {
        let Some(alter) = &self.alter else { return Ok(()) };
        Cpu.polar(loaded, poses, out)?;
        alter(Step::Polar { poses, out });
        Ok(())
    }

    fn gradients(
        &self,
        loaded: &Loaded<'_>,
        poses: Poses<'_>,
        split: &Split,
        out: &mut Gradients,
    ) -> Result<(), Failure> {
        let Some(alter) = &self.alter else { return Ok(()) };
        Cpu.gradients(loaded, poses, split, out)?;
        alter(Step::Gradients { poses, out });
        Ok(())
    }

    fn palette(
        &self,
        loaded: &Loaded<'_>,
        poses: Poses<'_>,
        input: &Gradients,
        out: &mut [Matrix3x4],
    ) -> Result<(), Failure> {
        let Some(alter) = &self.alter else { return Ok(()) };
        Cpu.palette(loaded, poses, input, out)?;
        alter(Step::Palette { poses, input, out });
        Ok(())
    }

    fn joints(
        &self,
        loaded: &Loaded<'_>,
        poses: Poses<'_>,
        out: &mut [Matrix3x4],
    ) -> Result<(), Failure> {
        if self.alter.is_none() {
            return Ok(());
        }
        Cpu.joints(loaded, poses, out)
    }

    fn features(
        &self,
        loaded: &Loaded<'_>,
        poses: Poses<'_>,
        split: &Split,
        out: &mut [f32],
    ) -> Result<(), Failure> {
        let Some(alter) = &self.alter else { return Ok(()) };
        Cpu.features(loaded, poses, split, out)?;
        alter(Step::Features { poses, out });
        Ok(())
    }

    fn correction(
        &self,
        loaded: &Loaded<'_>,
        poses: Poses<'_>,
        features: &[f32],
        out: &mut [Matrix3x4],
        confidences: &mut [f32],
    ) -> Result<(), Failure> {
        let Some(alter) = &self.alter else { return Ok(()) };
        let base = out.to_vec();
        Cpu.correction(loaded, poses, features, out, confidences)?;
        alter(Step::Correction { poses, features, base, out, confidences });
        Ok(())
    }

    fn confidence(
        &self,
        loaded: &Loaded<'_>,
        poses: Poses<'_>,
        rotations: &[[f32; 3]],
        split: &Split,
        out: &mut [f32],
    ) -> Result<(), Failure> {
        let Some(alter) = &self.alter else { return Ok(()) };
        Cpu.confidence(loaded, poses, rotations, split, out)?;
        alter(Step::Confidence { poses, rotations, out });
        Ok(())
    }

    fn skin(
        &self,
        loaded: &Loaded<'_>,
        palettes: &[Matrix3x4],
        skin: &SkinBatch,
        out: &mut [f32],
    ) -> Result<(), Failure> {
        let Some(alter) = &self.alter else { return Ok(()) };
        Cpu.skin(loaded, palettes, skin, out)?;
        alter(Step::Skin { palettes, skin, out });
        Ok(())
    }

    fn kernel(
        &self,
        subject: &KernelSubject<'_>,
        queries: &[f32],
        out: &mut [f32],
        confidences: &mut [f32],
    ) -> Result<(), Failure> {
        let Some(alter) = &self.alter else { return Ok(()) };
        Cpu.kernel(subject, queries, out, confidences)?;
        alter(Step::Kernel { queries, out, confidences });
        Ok(())
    }

    fn shapes(
        &self,
        subject: &ShapeSubject<'_>,
        batch: &ShapesBatch,
        out: &mut [f32],
    ) -> Result<(), Failure> {
        let Some(alter) = &self.alter else { return Ok(()) };
        Cpu.shapes(subject, batch, out)?;
        alter(Step::Shapes { batch, out });
        Ok(())
    }

    fn filter(&self, subject: &FilterSubject<'_>, out: &mut [f32]) -> Result<(), Failure> {
        let Some(alter) = &self.alter else { return Ok(()) };
        Cpu.filter(subject, out)?;
        alter(Step::Filter { out });
        Ok(())
    }

    fn whole(
        &self,
        loaded: &Loaded<'_>,
        poses: Poses<'_>,
        skin: &SkinBatch,
        out: &mut Whole,
    ) -> Result<(), Failure> {
        let Some(alter) = &self.alter else { return Ok(()) };
        Cpu.whole(loaded, poses, skin, out)?;
        let Whole { palettes, skin: out, .. } = out;
        alter(Step::Skin { palettes, skin, out });
        Ok(())
    }
}
