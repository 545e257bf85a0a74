//! Negative controls: a backend that is wrong once, by twice the tolerance, is caught, and so is one
//! that writes nothing.

use crate::gradients::{columns, exact_rotations};
use crate::{Subject, bounds, gradients, layout, palette, skin, whole};
use conformance::backend::{Backend, Cpu, Gradients};
use conformance::compare::Mismatch;
use conformance::models::{self, SHAPES};
use conformance::poses::widened;
use conformance::tolerance::{self, Inexact};
use sinew_runtime::envelope::{Attribute, Buffer, SkinJob};
use sinew_runtime::{Envelope, EvalError, Matrix3x4};
use sinew_trainer::envelope::oracle::Oracle;
use std::cell::Cell;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Output {
    Relative,
    Rotations,
    Gradients,
    Palette,
    Positions,
    Normals,
    Tangents,
}

/// The runtime, but in the tenth call one value of one output is `factor` tolerances off.
struct Wrong<'a> {
    oracle: &'a Oracle,
    output: Output,
    factor: f64,
    calls: Cell<usize>,
}

impl Wrong<'_> {
    fn now(&self, outputs: &[Output]) -> bool {
        if !outputs.contains(&self.output) {
            return false;
        }
        self.calls.set(self.calls.get() + 1);
        self.calls.get() == 10
    }

    fn off(&self, value: &mut f32, expected: f64, tolerance: f64) {
        *value = (expected + self.factor * tolerance) as f32;
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
        if !self.now(&[Output::Relative, Output::Rotations, Output::Gradients]) {
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
        if self.now(&[Output::Palette]) {
            let relative = Inexact::exact(columns(&input.relative));
            let gradients = Inexact::exact(columns(&input.gradients));
            let root = Inexact::exact(vec![widened(root)]);
            let right = tolerance::palette(self.oracle, &root, &relative, &gradients);
            self.off(&mut out[1][2][3], right.value[1][(2, 3)], right.error[1][(2, 3)]);
        }
        Ok(())
    }

    fn skin(&self, job: SkinJob<'_>) -> Result<(), EvalError> {
        let SkinJob { palette, positions, normals, tangents, .. } = job;
        let range = job.vertices.clone();
        let (out_a, out_b) = (&mut *job.out_a, &mut *job.out_b);
        Cpu.skin(SkinJob { vertices: range.clone(), out_a, out_b, ..job })?;
        if range.is_empty() || !self.now(&[Output::Positions, Output::Normals, Output::Tangents]) {
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

    fn whole_palette(
        &self,
        envelope: &Envelope<'_>,
        pose: &[Matrix3x4],
        out: &mut [Matrix3x4],
    ) -> Result<(), EvalError> {
        Cpu.whole_palette(envelope, pose, out)
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

    fn skin(&self, _: SkinJob<'_>) -> Result<(), EvalError> {
        Ok(())
    }

    fn whole_palette(
        &self,
        envelope: &Envelope<'_>,
        pose: &[Matrix3x4],
        out: &mut [Matrix3x4],
    ) -> Result<(), EvalError> {
        Cpu.whole_palette(envelope, pose, out)
    }
}

fn stage(backend: &impl Backend, subject: &Subject<'_>, output: Output) -> Result<(), Mismatch> {
    match output {
        Output::Relative | Output::Rotations | Output::Gradients => {
            gradients::body(backend, subject).map(|_| ())
        }
        Output::Palette => palette::body(backend, subject).map(|_| ()),
        _ => skin::body(backend, subject).map(|_| ()),
    }
}

const OUTPUTS: [Output; 7] = [
    Output::Relative,
    Output::Rotations,
    Output::Gradients,
    Output::Palette,
    Output::Positions,
    Output::Normals,
    Output::Tangents,
];

#[test]
fn one_value_off_by_two_tolerances_is_caught() {
    let bytes = models::random(SHAPES[0]);
    let subject = Subject::new("random", &bytes, 28);
    for output in OUTPUTS {
        let off_by = |factor| {
            let wrong = Wrong { oracle: &subject.oracle, output, factor, calls: Cell::new(0) };
            let result = stage(&wrong, &subject, output);
            assert!(wrong.calls.get() >= 10, "{output:?} was reached");
            result
        };
        let caught = off_by(2.0);
        assert!(matches!(caught, Err(Mismatch::Beyond { .. })), "{output:?}: {caught:?}");
        assert_eq!(off_by(0.5), Ok(()), "{output:?}: half a tolerance is within it");
    }
}

#[test]
fn a_vertex_astray_is_caught_from_end_to_end_and_by_the_bounds() {
    let bytes = models::random(SHAPES[0]);
    let subject = Subject::new("random", &bytes, 28);
    let output = Output::Positions;
    let wrong = |factor| Wrong { oracle: &subject.oracle, output, factor, calls: Cell::new(0) };
    assert!(whole::body(&wrong(1e6), &subject).is_err());
    assert!(whole::equivariance(&wrong(1e6), &subject).is_err());
    assert!(bounds::body(&wrong(1e9), &subject).is_err());
    // Layouts are compared with each other, so a value that is wrong once is one that differs.
    assert!(layout::body(&wrong(2.0), &subject).is_err());
}

#[test]
fn an_output_left_alone_is_caught() {
    let bytes = models::random(SHAPES[0]);
    let subject = Subject::new("random", &bytes, 2);
    for output in OUTPUTS {
        assert!(stage(&Idle, &subject, output).is_err(), "{output:?}");
    }
    assert!(whole::body(&Idle, &subject).is_err());
    assert!(whole::equivariance(&Idle, &subject).is_err());
    assert!(whole::rest(&Idle, &subject).is_err());
    assert!(layout::body(&Idle, &subject).is_err());
    assert!(bounds::body(&Idle, &subject).is_err());
}
