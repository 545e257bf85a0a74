//! A least set of examples, and folders to write to, for the tests of this folder.

use std::path::{Path, PathBuf};

use super::{Examples, Matrix3x4, Skeleton, Split};
use sinew_runtime::format::Space;

/// Gives the place of a file of `../shared/data`, which must be there where CI is set.
pub(super) fn shared(file: &str) -> Option<PathBuf> {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data");
    if !data.is_dir() {
        assert!(std::env::var_os("CI").is_none(), "CI is set, but there is no {}", data.display());
        eprintln!("not run: there is no {}", data.display());
        return None;
    }
    Some(data.join(file))
}

pub(super) const IDENTITY: Matrix3x4 =
    [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];

/// Makes one triangle on two joints, `root` and `tip`, at rest in every frame.
pub(super) fn triangle(frame_len: usize) -> Examples {
    let rest = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    Examples {
        vertices: rest.repeat(frame_len),
        rest,
        triangles: vec![[0, 1, 2]],
        uv: None,
        skeleton: Skeleton {
            names: vec!["root".into(), "tip".into()],
            parents: vec![None, Some(0)],
            rest: vec![IDENTITY; 2],
        },
        transforms: vec![IDENTITY; 2 * frame_len],
        split: vec![Split::Train; frame_len],
        ranges: Vec::new(),
        space: Space::default(),
        importance: None,
    }
}

/// A folder of its own for one test, removed at its end.
pub(super) struct Folder(pub(super) PathBuf);

impl Folder {
    pub(super) fn new(test: &str) -> Self {
        let name = format!("sinew-examples-{}-{test}", std::process::id());
        let path = std::env::temp_dir().join(name);
        std::fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    /// Writes a file, and gives its path.
    pub(super) fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
        let path = self.0.join(name);
        std::fs::write(&path, bytes).unwrap();
        path
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// Hands `check` the bytes cut off at every length, and with every byte changed in a few ways: what
/// it is given is hostile, and it must not panic.
pub(super) fn spoil(bytes: &[u8], check: impl Fn(&[u8])) {
    for len in 0..bytes.len() {
        check(&bytes[..len]);
    }
    let mut spoiled = bytes.to_vec();
    for place in 0..bytes.len() {
        for change in [0x01, 0x08, 0x80, 0xff] {
            spoiled[place] = bytes[place] ^ change;
            check(&spoiled);
        }
        spoiled[place] = bytes[place];
    }
}
