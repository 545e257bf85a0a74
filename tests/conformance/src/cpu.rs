//! The runtime as a backend.

use crate::backend::{Backend, Failure, Gradients, Loaded, Poses, Split, Whole, part};
use crate::compare::POISON;
use crate::filters::FilterSubject;
use crate::kernels::KernelSubject;
use crate::shapes::ShapeSubject;
use models::cells;
use sinew_gpu::layout::{Attribute, ShapesBatch, SkinBatch, Stage};
use sinew_runtime::skin::Output;
use sinew_runtime::{Matrix3x4, ShapesJob, SkinJob, stages};
use sinew_trainer::regression::arithmetic::Arithmetic;
use std::cell::Cell;

/// The runtime itself, one pose after another.
pub struct Cpu;

impl Backend for Cpu {
    fn arithmetic(&self) -> Arithmetic {
        Arithmetic::IEEE
    }

    fn has(&self, loaded: &Loaded<'_>, stage: Stage) -> bool {
        let predictor = loaded.envelope.predictor();
        match stage {
            Stage::Polar => loaded.envelope.stretches(),
            Stage::Gradients | Stage::Palette => predictor.reconstructs(),
            Stage::Joints => !predictor.reconstructs(),
            Stage::Features | Stage::Correction => predictor.corrects(),
            Stage::Confidence => !predictor.corrects(),
            Stage::Skin => loaded.skin.vertex_len() > 0,
            Stage::Kernel | Stage::Shapes | Stage::Filter => false,
        }
    }

    fn polar(&self, loaded: &Loaded<'_>, poses: Poses<'_>, out: &mut Split) -> Result<(), Failure> {
        let n = poses.len;
        for i in 0..n {
            let turns = part_mut(&mut out.turns, n, i);
            let strains = part_mut(&mut out.strains, n, i);
            stages::polar(&loaded.envelope, poses.one(i).joints, turns, strains)?;
        }
        Ok(())
    }

    fn gradients(
        &self,
        loaded: &Loaded<'_>,
        poses: Poses<'_>,
        split: &Split,
        out: &mut Gradients,
    ) -> Result<(), Failure> {
        let n = poses.len;
        for i in 0..n {
            stages::gradients(
                &loaded.envelope,
                poses.one(i).joints,
                (part(&split.turns, n, i), part(&split.strains, n, i)),
                part_mut(&mut out.relative, n, i),
                part_mut(&mut out.rotations, n, i),
                part_mut(&mut out.gradients, n, i),
            )?;
        }
        Ok(())
    }

    fn palette(
        &self,
        loaded: &Loaded<'_>,
        poses: Poses<'_>,
        input: &Gradients,
        out_palettes: &mut [Matrix3x4],
    ) -> Result<(), Failure> {
        let n = poses.len;
        for i in 0..n {
            stages::palette(
                &loaded.envelope,
                &poses.one(i).joints[loaded.envelope.root()],
                part(&input.relative, n, i),
                part(&input.gradients, n, i),
                part_mut(out_palettes, n, i),
            )?;
        }
        Ok(())
    }

    fn joints(
        &self,
        loaded: &Loaded<'_>,
        poses: Poses<'_>,
        out_palettes: &mut [Matrix3x4],
    ) -> Result<(), Failure> {
        let n = poses.len;
        for i in 0..n {
            let out = part_mut(out_palettes, n, i);
            stages::joints(&loaded.envelope, poses.one(i).joints, out)?;
        }
        Ok(())
    }

    fn features(
        &self,
        loaded: &Loaded<'_>,
        poses: Poses<'_>,
        split: &Split,
        out_features: &mut [f32],
    ) -> Result<(), Failure> {
        let n = poses.len;
        for i in 0..n {
            let (Poses { joints, curves, .. }, out) = (poses.one(i), part_mut(out_features, n, i));
            let strains = part(&split.strains, n, i).as_flattened();
            out[12 * joints.len()..][..strains.len()].copy_from_slice(strains);
            stages::features(&loaded.envelope, joints, curves, part(&split.turns, n, i), out)?;
        }
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
        let n = poses.len;
        let mut scratch = vec![POISON; loaded.envelope.correction_len()];
        for (i, confidence) in out_confidences.iter_mut().enumerate() {
            *confidence = stages::correction(
                &loaded.envelope,
                poses.one(i).joints,
                part(features, n, i),
                &mut scratch,
                part_mut(out_palettes, n, i),
            )?;
        }
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
        let n = poses.len;
        for (i, confidence) in out_confidences.iter_mut().enumerate() {
            let (rotations, strains) = (part(rotations, n, i), part(&split.strains, n, i));
            let joints = poses.one(i).joints;
            *confidence = stages::confidence(&loaded.envelope, joints, rotations, strains)?;
        }
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
        // A kernel model without helpers still has joints, so every palette has a transform.
        let n = palettes.len() / loaded.envelope.palette_len();
        let out = cells(out);
        for i in 0..n {
            let at = |attribute| output(out, attribute, i);
            let job = SkinJob::new(loaded.skin, part(palettes, n, i))
                .vertices(skin.vertices.clone())
                .positions(at(skin.positions))
                .normals(at(skin.normals))
                .tangents(at(skin.tangents));
            job.run()?;
        }
        Ok(())
    }

    fn kernel(
        &self,
        subject: &KernelSubject<'_>,
        queries: &[f32],
        out: &mut [f32],
        out_confidences: &mut [f32],
    ) -> Result<(), Failure> {
        let n = out_confidences.len();
        let kernel = &subject.kernel;
        let mut scratch = vec![POISON; kernel.counts().scratch_len()];
        for (i, confidence) in out_confidences.iter_mut().enumerate() {
            let own = part_mut(out, n, i);
            *confidence = kernel.evaluate(part(queries, n, i), &mut scratch, own)?;
        }
        Ok(())
    }

    fn shapes(
        &self,
        subject: &ShapeSubject<'_>,
        batch: &ShapesBatch,
        out: &mut [f32],
    ) -> Result<(), Failure> {
        let out = cells(out);
        for face in 0..subject.face_len {
            let at = |attribute| output(out, attribute, face);
            let job = ShapesJob::new(subject.skin, part(&subject.weights, subject.face_len, face))
                .vertices(batch.vertices.clone())
                .positions(at(batch.positions))
                .normals(at(batch.normals))
                .tangents(at(batch.tangents));
            job.run()?;
        }
        Ok(())
    }

    fn filter(&self, subject: &FilterSubject<'_>, out: &mut [f32]) -> Result<(), Failure> {
        Ok(subject.filter.apply(subject.shape, &subject.samples, out)?)
    }

    fn whole(
        &self,
        loaded: &Loaded<'_>,
        poses: Poses<'_>,
        skin: &SkinBatch,
        out: &mut Whole,
    ) -> Result<(), Failure> {
        let mut scratch = vec![POISON; loaded.envelope.scratch_len()];
        let (palettes, confidences) = (&mut out.palettes, &mut out.confidences);
        let Poses { joints, curves, .. } = poses;
        loaded.envelope.palettes(joints, curves, &mut scratch, palettes, confidences)?;
        self.skin(loaded, &out.palettes, skin, &mut out.skin)
    }
}

fn part_mut<T>(list: &mut [T], n: usize, i: usize) -> &mut [T] {
    let len = list.len() / n;
    &mut list[i * len..][..len]
}

/// Returns the place of an attribute of one instance.
fn output<'o>(
    out: &'o [Cell<f32>],
    attribute: Option<Attribute>,
    instance: usize,
) -> Option<Output<'o>> {
    let Attribute { offset, stride, instance_stride } = attribute?;
    Some(Output::shared(&out[offset + instance * instance_stride..], stride))
}
