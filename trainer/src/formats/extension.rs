//! Formats by the endings of their files.
//! What a file holds, whatever its name says.
//! What some programs write before text.

use super::error::FormatError;
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// The end of a file's name, in lower case, without the dot.
pub(crate) fn extension(path: &Path) -> String {
    path.extension().unwrap_or_default().to_string_lossy().to_lowercase()
}

/// Says which formats are read instead of this file's.
pub(crate) fn unknown_format(path: &Path, expected: &'static str) -> FormatError {
    let found = match extension(path) {
        none if none.is_empty() => "none".to_owned(),
        found => format!(".{found}"),
    };
    FormatError::UnknownFormat { expected, found }
}

/// Says what to do with a file of a format that is known and not read; none of any other.
pub(crate) fn unread(path: &Path) -> Option<FormatError> {
    let (format, remedy) = match extension(path).as_str() {
        "blend" => (
            "a Blender scene",
            "write examples of it by `blender FILE --background --python trainer/blender_export.py -- examples.npz`",
        ),
        "usd" | "usda" | "usdc" | "usdz" => (
            "USD",
            "export the scene with its joints as .fbx or .glb, and posed meshes as Alembic (.abc)",
        ),
        _ => return None,
    };
    Some(FormatError::Unread { format, remedy })
}

/// A kind of file, told by its first bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Content {
    /// A baked model.
    Model,
    /// A scene or arrays, in the format of this ending.
    Examples(&'static str),
}

/// How files begin.
const BEGINNINGS: [(&[u8], Content); 8] = [
    (b"SNEW", Content::Model),
    (b"glTF", Content::Examples("glb")),
    (b"Kaydara FBX Binary", Content::Examples("fbx")),
    (b"; FBX", Content::Examples("fbx")),
    (b"PK\x03\x04", Content::Examples("npz")),
    (b"POINTCACHE2\0", Content::Examples("pc2")),
    (b"Ogawa", Content::Examples("abc")),
    // Alembic in its older container, which its reader names.
    (b"\x89HDF\r\n\x1a\n", Content::Examples("abc")),
];

impl Content {
    /// Tells what begins so; `None` of what is not known by its beginning.
    pub fn of(bytes: &[u8]) -> Option<Self> {
        let found = BEGINNINGS.into_iter().find(|(beginning, _)| bytes.starts_with(beginning));
        found.map(|(_, content)| content)
    }
}

/// Checks that a file that is to be read by its ending has one that may be, holds something, and nothing else. What
/// cannot be opened is left to whoever reads it.
pub(crate) fn check_content(path: &Path) -> Result<(), FormatError> {
    if let Some(error) = unread(path) {
        return Err(error);
    }
    let Ok(mut file) = File::open(path) else { return Ok(()) };
    let mut beginning = [0; 32];
    let Ok(len) = file.read(&mut beginning) else { return Ok(()) };
    if len == 0 {
        return Err(FormatError::Empty);
    }
    match Content::of(&beginning[..len]) {
        Some(Content::Model) => Err(FormatError::Model),
        // A reader of glTF takes both forms by either name.
        Some(Content::Examples("glb")) if extension(path) == "gltf" => Ok(()),
        Some(Content::Examples(ending)) if extension(path) != ending => {
            Err(FormatError::OtherContent { ending })
        }
        _ => Ok(()),
    }
}

/// The byte order mark of UTF-8.
const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

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
