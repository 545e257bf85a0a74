//! Formats by the endings of their files.

use super::error::FormatError;
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
