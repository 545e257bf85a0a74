//! Tools for tests of readers: temporary folders, real files and spoiled bytes.

use std::path::{Path, PathBuf};

/// Returns the path of a file in `../shared/data`; `None` if that folder does not exist, which is a failure in CI.
pub(crate) fn shared(file: &str) -> Option<PathBuf> {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data");
    if !data.is_dir() {
        assert!(std::env::var_os("CI").is_none(), "CI is set, but there is no {}", data.display());
        eprintln!("not run: there is no {}", data.display());
        return None;
    }
    Some(data.join(file))
}

/// A temporary folder for one test, removed at its end.
pub(crate) struct Folder(pub(crate) PathBuf);

impl Folder {
    pub(crate) fn new(test: &str) -> Self {
        let name = format!("sinew-formats-{}-{test}", std::process::id());
        let path = std::env::temp_dir().join(name);
        std::fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    /// Writes a file and returns its path.
    pub(crate) fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
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

/// Calls `check` with damaged bytes: cut off at every length, and with every byte changed in a few ways. `check` must
/// not panic.
pub(crate) fn spoil(bytes: &[u8], check: impl Fn(&[u8])) {
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
