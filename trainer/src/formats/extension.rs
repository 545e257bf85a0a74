//! Formats of files: by their ending, and by their first bytes.

use crate::Error;
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// First bytes of the known formats.
const BEGINNINGS: [(&[u8], Content); 8] = [
    (b"SNEW", Content::Model),
    (b"glTF", Content::Examples("glb")),
    (b"Kaydara FBX Binary", Content::Examples("fbx")),
    (b"; FBX", Content::Examples("fbx")),
    (b"PK\x03\x04", Content::Examples("npz")),
    (b"POINTCACHE2\0", Content::Examples("pc2")),
    (b"Ogawa", Content::Examples("abc")),
    // Alembic in its older container; the Alembic reader reports it.
    (b"\x89HDF\r\n\x1a\n", Content::Examples("abc")),
];

/// The byte order mark of UTF-8, which some programs write before text.
const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

/// Returns the ending of a file's name, in lower case, without the dot.
pub(crate) fn extension(path: &Path) -> String {
    path.extension().unwrap_or_default().to_string_lossy().to_lowercase()
}

/// Makes the error for a file whose ending is not supported; `expected` lists the supported endings.
pub(crate) fn unknown_format(path: &Path, expected: &'static str) -> Error {
    let found = match extension(path) {
        none if none.is_empty() => "none".to_owned(),
        found => format!(".{found}"),
    };
    Error::unsupported(format!("expected a file that ends in {expected}, found {found}"))
}

/// Checks that a file's format is not one of the known formats that are not supported.
fn check_supported(path: &Path) -> Result<(), Error> {
    let (format, remedy) = match extension(path).as_str() {
        "blend" => (
            "a Blender scene",
            "write examples of it by `blender FILE --background --python trainer/blender_export.py -- examples.npz`",
        ),
        "usd" | "usda" | "usdc" | "usdz" => (
            "USD",
            "export the scene with its joints as .fbx or .glb, and posed meshes as Alembic (.abc)",
        ),
        _ => return Ok(()),
    };
    Err(Error::unsupported(format!("is {format}, which is not read: {remedy}")))
}

/// Content of a file, recognised by its first bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Content {
    /// A baked model.
    Model,
    /// A scene or arrays, in the format of this ending.
    Examples(&'static str),
}

impl Content {
    /// Returns the content that begins with these bytes; `None` if the beginning is not known.
    pub fn of(bytes: &[u8]) -> Option<Self> {
        let found = BEGINNINGS.into_iter().find(|(beginning, _)| bytes.starts_with(beginning));
        found.map(|(_, content)| content)
    }
}

/// Checks that a file is not empty, and that its content fits its ending.
///
/// Does not report a file that cannot be opened; the reader of the file reports that.
///
/// # Errors
/// The format is known but not supported; the file is empty, is a baked model, or belongs to another ending.
pub(crate) fn check_content(path: &Path) -> Result<(), Error> {
    check_supported(path)?;
    let Ok(mut file) = File::open(path) else { return Ok(()) };
    let mut beginning = [0; 32];
    let Ok(len) = file.read(&mut beginning) else { return Ok(()) };
    if len == 0 {
        return Err(empty_file());
    }
    match Content::of(&beginning[..len]) {
        Some(Content::Model) => Err(Error::damaged(
            "is a baked model, expected examples: commands take the model first",
        )),
        // The glTF reader accepts both forms under either ending.
        Some(Content::Examples("glb")) if extension(path) == "gltf" => Ok(()),
        Some(Content::Examples(ending)) if extension(path) != ending => {
            Err(Error::damaged(format!("holds what a .{ending} file holds: give it that ending")))
        }
        _ => Ok(()),
    }
}

/// Makes the error for a file without any byte.
pub(super) fn empty_file() -> Error {
    Error::damaged("is empty")
}

/// Returns a text without its byte order mark.
pub(super) fn unmarked(text: &[u8]) -> &[u8] {
    text.strip_prefix(BYTE_ORDER_MARK).unwrap_or(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_known_by_their_first_bytes() {
        assert_eq!(Content::of(b"SNEW\x04"), Some(Content::Model));
        assert_eq!(Content::of(b"glTF\x02\0"), Some(Content::Examples("glb")));
        assert_eq!(Content::of(b"Kaydara FBX Binary  \0"), Some(Content::Examples("fbx")));
        assert_eq!(Content::of(b"PK\x03\x04"), Some(Content::Examples("npz")));
        assert_eq!(Content::of(b"Ogawa\xff\0\x01"), Some(Content::Examples("abc")));
        assert_eq!(Content::of(b"\x89HDF\r\n\x1a\n\0"), Some(Content::Examples("abc")));
        assert_eq!(Content::of(b"{\"asset\":"), None);
        assert_eq!(Content::of(b""), None);
    }
}
