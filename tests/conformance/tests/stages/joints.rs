//! Stage 1 of the kernel predictor: copies, bit for bit.

use crate::Subject;
use conformance::backend::{Backend, poisoned_palette};
use conformance::compare::{Mismatch, same_bits};
use conformance::poses::rounded;

/// Nothing is measured: what is compared is equal or not.
pub(crate) fn body(backend: &impl Backend, subject: &Subject<'_>) -> Result<[f64; 0], Mismatch> {
    let Subject { envelope, oracle, poses, .. } = subject;
    for pose in poses {
        let mut found = poisoned_palette(envelope);
        let run = backend.joints(envelope, &pose.maps, &mut found);
        run.expect("the pose is finite and the lengths are right");
        let expected: Vec<_> = oracle.joints(&pose.widened()).iter().map(rounded).collect();
        same_bits(found.as_flattened().as_flattened(), expected.as_flattened().as_flattened())?;
    }
    Ok([])
}
