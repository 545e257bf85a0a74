//! Skinning with vector units. The operations on a float and their order are those of the loops for one vertex, so the
//! bits are equal.

mod block;
mod columns;
mod copies;
mod eights;

use super::job::SkinJob;
use crate::lanes::WIDTH;
use crate::vectors::level;

/// Runs a job that has been checked. `None` without vector units or influences.
pub(super) fn run(job: &SkinJob<'_>) -> Option<()> {
    // Without registers the code would be long and slow. The rows of a file are little-endian.
    if WIDTH > 1 || cfg!(target_endian = "big") {
        return None;
    }
    let level = level();
    let alone = job.normals.is_none() && job.tangents.is_none();
    let done = if alone { columns::run(level, job) } else { None };
    done.or_else(|| eights::run(level, job))
}
