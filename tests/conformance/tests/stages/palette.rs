//! Stage 2: on the stacks that stage 1 gave.

use crate::Subject;
use crate::gradients::{columns, gradients_of};
use conformance::backend::{Backend, Gradients, poisoned_palette};
use conformance::compare::{Mismatch, within};
use conformance::poses::widened;
use conformance::tolerance::{self, Inexact, Map, UNDERFLOW};
use sinew_runtime::{Envelope, Matrix3x4};

/// Largest ratio of the maps' entries.
pub(crate) fn body(backend: &impl Backend, subject: &Subject<'_>) -> Result<[f64; 1], Mismatch> {
    let Subject { envelope, oracle, poses, .. } = subject;
    let mut worst = 0.0_f64;
    for pose in poses {
        let input = gradients_of(backend, envelope, &pose.maps);
        let found = palette_on(backend, envelope, &pose.maps, &input);
        let relative = Inexact::exact(columns::<4>(&input.relative));
        let gradients = Inexact::exact(columns::<3>(&input.gradients));
        let root = Inexact::exact(vec![widened(&pose.maps[envelope.root()])]);
        let expected = tolerance::palette(oracle, &root, &relative, &gradients);
        worst = worst.max(maps_within(&found, &expected)?);
    }
    Ok([worst])
}

/// Evaluates the reconstruction on what stage 1 gave.
pub(crate) fn palette_on(
    backend: &impl Backend,
    envelope: &Envelope<'_>,
    pose: &[Matrix3x4],
    input: &Gradients,
) -> Vec<Matrix3x4> {
    let mut palette = poisoned_palette(envelope);
    let run = backend.palette(envelope, &pose[envelope.root()], input, &mut palette);
    run.expect("the lengths are right");
    palette
}

/// Compares maps with those expected.
pub(crate) fn maps_within(found: &[Matrix3x4], expected: &Inexact<Map>) -> Result<f64, Mismatch> {
    let flat = |list: &[Map]| -> Vec<f64> {
        list.iter().flat_map(|m| m.transpose().iter().copied().collect::<Vec<_>>()).collect()
    };
    let tolerances: Vec<_> = flat(&expected.error).iter().map(|e| e + UNDERFLOW).collect();
    within(found.as_flattened().as_flattened(), &flat(&expected.value), &tolerances)
}
