//! Minimal examples for tests.

use super::{Examples, Matrix3x4, Skeleton, Split};
use sinew_runtime::format::Space;

pub(super) const IDENTITY: Matrix3x4 =
    [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];

/// Creates one triangle on two joints, `root` and `tip`, at rest in every frame.
pub(crate) fn triangle(frame_len: usize) -> Examples {
    let rest = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    Examples {
        vertices: rest.repeat(frame_len),
        rest,
        triangles: vec![[0, 1, 2]],
        engine: None,
        skeleton: Skeleton {
            names: vec!["root".into(), "tip".into()],
            parents: vec![None, Some(0)],
            rest: vec![IDENTITY; 2],
            roots: Vec::new(),
            unplaced: Vec::new(),
        },
        transforms: vec![IDENTITY; 2 * frame_len],
        split: vec![Split::Train; frame_len],
        ranges: Vec::new(),
        clip_starts: vec![0],
        space: Space::default(),
        joint_weights: None,
        importance: None,
        frame_weights: None,
        own_skin: false,
    }
}
