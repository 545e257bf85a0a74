//! Stage joints: copies, bit for bit.

use crate::backend::{Backend, Failure, floats, part, poisoned_transforms};
use crate::finding::Finding;
use crate::poses::rounded;
use crate::subject::Subject;
use sinew_runtime::Matrix3x4;

/// Compares the transforms bit by bit.
///
/// # Errors
/// The backend's error.
pub fn body(backend: &dyn Backend, subject: &Subject<'_>) -> Result<Vec<Finding>, Failure> {
    let (found, n) = (joints_of(backend, subject)?, subject.poses.len());
    let mut transforms = Finding::new("joints");
    for (i, pose) in subject.poses.iter().enumerate() {
        let expected: Vec<_> = subject.oracle.joints(&pose.widened()).iter().map(rounded).collect();
        transforms.equal(floats(part(&found, n, i)), floats(&expected));
    }
    Ok(vec![transforms])
}

/// Evaluates the base palettes of every pose.
///
/// # Errors
/// The backend's error.
pub fn joints_of(backend: &dyn Backend, subject: &Subject<'_>) -> Result<Vec<Matrix3x4>, Failure> {
    let mut out = poisoned_transforms(subject.poses.len() * subject.loaded.envelope.palette_len());
    backend.joints(&subject.loaded, subject.inputs(), &mut out)?;
    Ok(out)
}
