//! Minimal examples for tests.

use super::{Examples, Matrix3x4, Skeleton, Split};

pub(super) const IDENTITY: Matrix3x4 =
    [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];

/// Creates one triangle on two joints, `root` and `tip`, at rest in every frame.
pub(crate) fn triangle(frame_len: usize) -> Examples {
    let rest = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    Examples {
        vertices: rest.repeat(frame_len),
        rest,
        triangles: vec![[0, 1, 2]],
        skeleton: Skeleton {
            names: vec!["root".into(), "tip".into()],
            parents: vec![None, Some(0)],
            rest: vec![IDENTITY; 2],
            ..Skeleton::default()
        },
        transforms: vec![IDENTITY; 2 * frame_len],
        split: vec![Split::Train; frame_len],
        clip_starts: vec![0],
        ..Examples::default()
    }
}
