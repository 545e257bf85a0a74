//! Negative controls: a backend that is wrong once, by twice the tolerance, is caught, and so is one
//! that writes nothing.

use crate::gradients::{columns, exact_rotations};
use crate::{
    FEWER_POSES, Subject, bounds, confidence, correction, features, gradients, joints, layout,
};
use crate::{palette, skin, whole};
use conformance::backend::{Backend, Cpu, Gradients};
use conformance::compare::Mismatch;
use conformance::models::{self, shape_of};
use conformance::poses::widened;
use conformance::tolerance::{self, Inexact};
use sinew_runtime::envelope::{Attribute, Buffer, SkinJob};
use sinew_runtime::format::Predictor;
use sinew_runtime::{Envelope, EvalError, Matrix3x4};
use sinew_trainer::envelope::oracle::Oracle;
use std::cell::Cell;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Output {
    Relative,
    Rotations,
    Gradients,
    Palette,
    Features,
    Correction,
    /// Of the correction.
    Certainty,
    /// Of a rotational model.
    Confidence,
    Positions,
    Normals,
    Tangents,
}

impl Output {
    /// The predictor of a model to look at it on.
    fn predictor(self) -> Predictor {
        match self {
            Self::Features | Self::Correction | Self::Certainty => Predictor::Kernel,
            _ => Predictor::Rotational,
        }
    }
}

/// The runtime, but once one value of one output is `factor` tolerances off.
struct Wrong<'a> {
    oracle: &'a Oracle,
    output: Output,
    factor: f64,
    calls: Cell<usize>,
}

impl Wrong<'_> {
    fn spoils(&self, outputs: &[Output]) -> bool {
        outputs.contains(&self.output) && self.calls.get() < 10
    }

    /// Counts a value that may be off at all, and spoils the tenth.
    fn off(&self, value: &mut f32, expected: f64, tolerance: f64) {
        if tolerance > 0.0 {
            self.calls.set(self.calls.get() + 1);
        }
        if self.calls.get() == 10 {
            *value = (expected + self.factor * tolerance) as f32;
        }
    }
}

impl Backend for Wrong<'_> {
    fn gradients(
        &self,
        envelope: &Envelope<'_>,
        pose: &[Matrix3x4],
        out: &mut Gradients,
    ) -> Result<(), EvalError> {
        Cpu.gradients(envelope, pose, out)?;
        if !self.spoils(&[Output::Relative, Output::Rotations, Output::Gradients]) {
            return Ok(());
        }
        let last = pose.len() - 1;
        let relative = Inexact::exact(columns::<4>(&out.relative));
        match self.output {
            Output::Relative => {
                let pose = Inexact::exact(pose.iter().map(widened).collect());
                let right = tolerance::relative(self.oracle, &pose);
                let (value, error) = (right.value[last], right.error[last]);
                self.off(&mut out.relative[4 * last + 3][2], value[(2, 3)], error[(2, 3)]);
            }
            Output::Rotations => {
                let right = tolerance::rotations(self.oracle, &relative);
                self.off(&mut out.rotations[last][1], right.value[last][1], right.error[last]);
            }
            _ => {
                let angles = exact_rotations(&out.rotations);
                let right = tolerance::gradients(self.oracle, &relative, &angles);
                self.off(&mut out.gradients[1][0], right.value[0][(0, 1)], right.error[0][(0, 1)]);
            }
        }
        Ok(())
    }

    fn palette(
        &self,
        envelope: &Envelope<'_>,
        root: &Matrix3x4,
        input: &Gradients,
        out: &mut [Matrix3x4],
    ) -> Result<(), EvalError> {
        Cpu.palette(envelope, root, input, out)?;
        if self.spoils(&[Output::Palette]) {
            let relative = Inexact::exact(columns(&input.relative));
            let gradients = Inexact::exact(columns(&input.gradients));
            let root = Inexact::exact(vec![widened(root)]);
            let right = tolerance::palette(self.oracle, &root, &relative, &gradients);
            self.off(&mut out[1][2][3], right.value[1][(2, 3)], right.error[1][(2, 3)]);
        }
        Ok(())
    }

    fn features(
        &self,
        envelope: &Envelope<'_>,
        pose: &[Matrix3x4],
        out: &mut [Matrix3x4],
    ) -> Result<(), EvalError> {
        Cpu.features(envelope, pose, out)?;
        if self.spoils(&[Output::Features]) {
            let pose = Inexact::exact(pose.iter().map(widened).collect());
            let right = tolerance::features(self.oracle, &pose);
            self.off(&mut out[0][2][3], right.value[0][(2, 3)], right.error[0][(2, 3)]);
        }
        Ok(())
    }

    fn correction(
        &self,
        envelope: &Envelope<'_>,
        pose: &[Matrix3x4],
        features: &[Matrix3x4],
        out: &mut [Matrix3x4],
    ) -> Result<f32, EvalError> {
        let exact = |maps: &[Matrix3x4]| Inexact::exact(maps.iter().map(widened).collect());
        let base = exact(out);
        let mut found = Cpu.correction(envelope, pose, features, out)?;
        if self.spoils(&[Output::Correction, Output::Certainty]) {
            let (maps, certainty) =
                tolerance::correction(self.oracle, &exact(pose), &exact(features), base);
            let last = out.len() - 1;
            match self.output {
                Output::Certainty => self.off(&mut found, certainty.value[0], certainty.error[0]),
                _ => {
                    let (value, error) = (maps.value[last], maps.error[last]);
                    self.off(&mut out[last][2][3], value[(2, 3)], error[(2, 3)]);
                }
            }
        }
        Ok(found)
    }

    fn confidence(
        &self,
        envelope: &Envelope<'_>,
        rotations: &[[f32; 3]],
    ) -> Result<f32, EvalError> {
        let mut found = Cpu.confidence(envelope, rotations)?;
        if self.spoils(&[Output::Confidence]) {
            let right = tolerance::confidence(self.oracle, &exact_rotations(rotations));
            self.off(&mut found, right.value[0], right.error[0]);
        }
        Ok(found)
    }

    fn skin(&self, job: SkinJob<'_>) -> Result<(), EvalError> {
        let SkinJob { palette, positions, normals, tangents, .. } = job;
        let range = job.vertices.clone();
        let (out_a, out_b) = (&mut *job.out_a, &mut *job.out_b);
        Cpu.skin(SkinJob { vertices: range.clone(), out_a, out_b, ..job })?;
        if range.is_empty() || !self.spoils(&[Output::Positions, Output::Normals, Output::Tangents])
        {
            return Ok(());
        }
        let vertex = &self.oracle.vertices[range.end - 1];
        let palette = Inexact::exact(palette.iter().map(widened).collect());
        let right = self.oracle.skin(vertex, &palette.value);
        let bounds = tolerance::skin(vertex, &palette);
        let (attribute, expected, tolerance) = match (self.output, right.tangent) {
            (Output::Positions, _) => (positions, right.position[0], bounds.position[0]),
            (Output::Tangents, Some((tangent, _))) => (tangents, tangent[0], bounds.tangent),
            _ => (normals, right.normal[0], bounds.normal),
        };
        if let Some(Attribute { buffer, offset, stride }) = attribute {
            let out = if buffer == Buffer::A { job.out_a } else { job.out_b };
            self.off(&mut out[offset + (range.len() - 1) * stride], expected, tolerance);
        }
        Ok(())
    }
}

/// Says that it has worked.
struct Idle;

impl Backend for Idle {
    fn gradients(
        &self,
        _: &Envelope<'_>,
        _: &[Matrix3x4],
        _: &mut Gradients,
    ) -> Result<(), EvalError> {
        Ok(())
    }

    fn palette(
        &self,
        _: &Envelope<'_>,
        _: &Matrix3x4,
        _: &Gradients,
        _: &mut [Matrix3x4],
    ) -> Result<(), EvalError> {
        Ok(())
    }

    fn joints(
        &self,
        _: &Envelope<'_>,
        _: &[Matrix3x4],
        _: &mut [Matrix3x4],
    ) -> Result<(), EvalError> {
        Ok(())
    }

    fn features(
        &self,
        _: &Envelope<'_>,
        _: &[Matrix3x4],
        _: &mut [Matrix3x4],
    ) -> Result<(), EvalError> {
        Ok(())
    }

    fn correction(
        &self,
        _: &Envelope<'_>,
        _: &[Matrix3x4],
        _: &[Matrix3x4],
        _: &mut [Matrix3x4],
    ) -> Result<f32, EvalError> {
        Ok(f32::NAN)
    }

    fn confidence(&self, _: &Envelope<'_>, _: &[[f32; 3]]) -> Result<f32, EvalError> {
        Ok(f32::NAN)
    }

    fn skin(&self, _: SkinJob<'_>) -> Result<(), EvalError> {
        Ok(())
    }
}

/// The runtime, but its correction only says how certain it is.
struct Uncorrected;

impl Backend for Uncorrected {
    fn correction(
        &self,
        envelope: &Envelope<'_>,
        pose: &[Matrix3x4],
        features: &[Matrix3x4],
        out: &mut [Matrix3x4],
    ) -> Result<f32, EvalError> {
        Cpu.correction(envelope, pose, features, &mut out.to_vec())
    }
}

fn stage(backend: &impl Backend, subject: &Subject<'_>, output: Output) -> Result<(), Mismatch> {
    match output {
        Output::Relative | Output::Rotations | Output::Gradients => {
            gradients::body(backend, subject).map(|_| ())
        }
        Output::Palette => palette::body(backend, subject).map(|_| ()),
        Output::Features => features::body(backend, subject).map(|_| ()),
        Output::Correction | Output::Certainty => correction::body(backend, subject).map(|_| ()),
        Output::Confidence => confidence::body(backend, subject).map(|_| ()),
        _ => skin::body(backend, subject).map(|_| ()),
    }
}

const OUTPUTS: [Output; 11] = [
    Output::Relative,
    Output::Rotations,
    Output::Gradients,
    Output::Palette,
    Output::Features,
    Output::Correction,
    Output::Certainty,
    Output::Confidence,
    Output::Positions,
    Output::Normals,
    Output::Tangents,
];

#[test]
fn one_value_off_by_two_tolerances_is_caught() {
    for output in OUTPUTS {
        let bytes = models::random(shape_of(output.predictor()));
        let subject = Subject::new("random", &bytes, FEWER_POSES);
        let off_by = |factor| {
            let wrong = Wrong { oracle: &subject.oracle, output, factor, calls: Cell::new(0) };
            let result = stage(&wrong, &subject, output);
            assert_eq!(wrong.calls.get(), 10, "{output:?} was reached");
            result
        };
        let caught = off_by(2.0);
        assert!(matches!(caught, Err(Mismatch::Beyond { .. })), "{output:?}: {caught:?}");
        assert_eq!(off_by(0.5), Ok(()), "{output:?}: half a tolerance is within it");
    }
}

#[test]
fn a_vertex_astray_is_caught_from_end_to_end_and_by_the_bounds() {
    for predictor in Predictor::ALL {
        let bytes = models::random(shape_of(predictor));
        let subject = Subject::new("random", &bytes, 28);
        let output = Output::Positions;
        let wrong = |factor| Wrong { oracle: &subject.oracle, output, factor, calls: Cell::new(0) };
        assert!(whole::body(&wrong(1e6), &subject).is_err());
        assert!(whole::equivariance(&wrong(1e6), &subject).is_err());
        assert!(bounds::body(&wrong(1e9), &subject).is_err());
        // Layouts are compared with each other, so a value that is wrong once is one that differs.
        assert!(layout::body(&wrong(2.0), &subject).is_err());
    }
}

#[test]
fn an_output_left_alone_is_caught() {
    for output in OUTPUTS {
        let bytes = models::random(shape_of(output.predictor()));
        let subject = Subject::new("random", &bytes, 2);
        assert!(stage(&Idle, &subject, output).is_err(), "{output:?}");
    }
    for predictor in Predictor::ALL {
        let bytes = models::random(shape_of(predictor));
        let subject = Subject::new("random", &bytes, 28);
        assert!(whole::body(&Idle, &subject).is_err());
        assert!(whole::equivariance(&Idle, &subject).is_err());
        assert!(whole::rest(&Idle, &subject).is_err());
        assert!(layout::body(&Idle, &subject).is_err());
        assert!(bounds::body(&Idle, &subject).is_err());
        if predictor.corrects() {
            assert!(correction::body(&Uncorrected, &subject).is_err());
            assert!(layout::body(&Uncorrected, &subject).is_err());
        }
    }
    let bytes = models::random(shape_of(Predictor::Kernel));
    assert!(joints::body(&Idle, &Subject::new("random", &bytes, 1)).is_err());
}
