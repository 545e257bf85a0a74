//! Faulty backends: the runtime with altered outputs, and one that does nothing.

use conformance::backend::{Backend, Failure, Gradients, Loaded, Whole};
use conformance::cpu::Cpu;
use conformance::filters::FilterSubject;
use conformance::kernels::KernelSubject;
use conformance::shapes::ShapeSubject;
use conformance::tolerance::Arithmetic;
use sinew_gpu::layout::{ShapesBatch, SkinBatch, Stage};
use sinew_runtime::Matrix3x4;

/// Inputs and outputs of a stage.
pub(crate) enum Step<'a> {
    Gradients {
        poses: &'a [Matrix3x4],
        out: &'a mut Gradients,
    },
    Palette {
        poses: &'a [Matrix3x4],
        input: &'a Gradients,
        out: &'a mut [Matrix3x4],
    },
    Features {
        poses: &'a [Matrix3x4],
        out: &'a mut [Matrix3x4],
    },
    Correction {
        poses: &'a [Matrix3x4],
        features: &'a [Matrix3x4],
        base: Vec<Matrix3x4>,
        out: &'a mut [Matrix3x4],
        confidences: &'a mut [f32],
    },
    Confidence {
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

/// Passes every step to a closure, which may alter the outputs; the second field is the precision
/// that the backend claims.
pub(crate) struct Altered<F>(pub(crate) F, pub(crate) Arithmetic);

impl<F: Fn(Step<'_>)> Backend for Altered<F> {
    fn arithmetic(&self) -> Arithmetic {
        self.1
    }

    fn has(&self, loaded: &Loaded<'_>, stage: Stage) -> bool {
        Cpu.has(loaded, stage)
    }

    fn gradients(
        &self,
        loaded: &Loaded<'_>,
        poses: &[Matrix3x4],
        out: &mut Gradients,
    ) -> Result<(), Failure> {
        Cpu.gradients(loaded, poses, out)?;
        (self.0)(Step::Gradients { poses, out });
        Ok(())
    }

    fn palette(
        &self,
        loaded: &Loaded<'_>,
        poses: &[Matrix3x4],
        input: &Gradients,
        out: &mut [Matrix3x4],
    ) -> Result<(), Failure> {
        Cpu.palette(loaded, poses, input, out)?;
        (self.0)(Step::Palette { poses, input, out });
        Ok(())
    }

    fn joints(
        &self,
        loaded: &Loaded<'_>,
        poses: &[Matrix3x4],
        out: &mut [Matrix3x4],
    ) -> Result<(), Failure> {
        Cpu.joints(loaded, poses, out)
    }

    fn features(
        &self,
        loaded: &Loaded<'_>,
        poses: &[Matrix3x4],
        out: &mut [Matrix3x4],
    ) -> Result<(), Failure> {
        Cpu.features(loaded, poses, out)?;
        (self.0)(Step::Features { poses, out });
        Ok(())
    }

    fn correction(
        &self,
        loaded: &Loaded<'_>,
        poses: &[Matrix3x4],
        features: &[Matrix3x4],
        out: &mut [Matrix3x4],
        confidences: &mut [f32],
    ) -> Result<(), Failure> {
        let base = out.to_vec();
        Cpu.correction(loaded, poses, features, out, confidences)?;
        (self.0)(Step::Correction { poses, features, base, out, confidences });
        Ok(())
    }

    fn confidence(
        &self,
        loaded: &Loaded<'_>,
        rotations: &[[f32; 3]],
        out: &mut [f32],
    ) -> Result<(), Failure> {
        Cpu.confidence(loaded, rotations, out)?;
        (self.0)(Step::Confidence { rotations, out });
        Ok(())
    }

    fn skin(
        &self,
        loaded: &Loaded<'_>,
        palettes: &[Matrix3x4],
        skin: &SkinBatch,
        out: &mut [f32],
    ) -> Result<(), Failure> {
        Cpu.skin(loaded, palettes, skin, out)?;
        (self.0)(Step::Skin { palettes, skin, out });
        Ok(())
    }

    fn kernel(
        &self,
        subject: &KernelSubject<'_>,
        queries: &[f32],
        out: &mut [f32],
        confidences: &mut [f32],
    ) -> Result<(), Failure> {
        Cpu.kernel(subject, queries, out, confidences)?;
        (self.0)(Step::Kernel { queries, out, confidences });
        Ok(())
    }

    fn shapes(
        &self,
        subject: &ShapeSubject<'_>,
        batch: &ShapesBatch,
        out: &mut [f32],
    ) -> Result<(), Failure> {
        Cpu.shapes(subject, batch, out)?;
        (self.0)(Step::Shapes { batch, out });
        Ok(())
    }

    fn filter(&self, subject: &FilterSubject<'_>, out: &mut [f32]) -> Result<(), Failure> {
        Cpu.filter(subject, out)?;
        (self.0)(Step::Filter { out });
        Ok(())
    }

    fn whole(
        &self,
        loaded: &Loaded<'_>,
        poses: &[Matrix3x4],
        skin: &SkinBatch,
        out: &mut Whole,
    ) -> Result<(), Failure> {
        Cpu.whole(loaded, poses, skin, out)?;
        let Whole { palettes, skin: out, .. } = out;
        (self.0)(Step::Skin { palettes, skin, out });
        Ok(())
    }
}

/// Writes nothing, and reports success.
pub(crate) struct Idle;

impl Backend for Idle {
    fn arithmetic(&self) -> Arithmetic {
        Cpu.arithmetic()
    }

    fn has(&self, loaded: &Loaded<'_>, stage: Stage) -> bool {
        Cpu.has(loaded, stage)
    }

    fn gradients(&self, _: &Loaded<'_>, _: &[Matrix3x4], _: &mut Gradients) -> Result<(), Failure> {
        Ok(())
    }

    fn palette(
        &self,
        _: &Loaded<'_>,
        _: &[Matrix3x4],
        _: &Gradients,
        _: &mut [Matrix3x4],
    ) -> Result<(), Failure> {
        Ok(())
    }

    fn joints(&self, _: &Loaded<'_>, _: &[Matrix3x4], _: &mut [Matrix3x4]) -> Result<(), Failure> {
        Ok(())
    }

    fn features(
        &self,
        _: &Loaded<'_>,
        _: &[Matrix3x4],
        _: &mut [Matrix3x4],
    ) -> Result<(), Failure> {
        Ok(())
    }

    fn correction(
        &self,
        _: &Loaded<'_>,
        _: &[Matrix3x4],
        _: &[Matrix3x4],
        _: &mut [Matrix3x4],
        _: &mut [f32],
    ) -> Result<(), Failure> {
        Ok(())
    }

    fn confidence(&self, _: &Loaded<'_>, _: &[[f32; 3]], _: &mut [f32]) -> Result<(), Failure> {
        Ok(())
    }

    fn skin(
        &self,
        _: &Loaded<'_>,
        _: &[Matrix3x4],
        _: &SkinBatch,
        _: &mut [f32],
    ) -> Result<(), Failure> {
        Ok(())
    }

    fn kernel(
        &self,
        _: &KernelSubject<'_>,
        _: &[f32],
        _: &mut [f32],
        _: &mut [f32],
    ) -> Result<(), Failure> {
        Ok(())
    }

    fn shapes(&self, _: &ShapeSubject<'_>, _: &ShapesBatch, _: &mut [f32]) -> Result<(), Failure> {
        Ok(())
    }

    fn filter(&self, _: &FilterSubject<'_>, _: &mut [f32]) -> Result<(), Failure> {
        Ok(())
    }

    fn whole(
        &self,
        _: &Loaded<'_>,
        _: &[Matrix3x4],
        _: &SkinBatch,
        _: &mut Whole,
    ) -> Result<(), Failure> {
        Ok(())
    }
}
