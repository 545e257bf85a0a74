//! The kinds of images that glTF knows, and what is said of those that are not there.

use std::path::PathBuf;

/// Tells the media type of an image by its first bytes.
pub(crate) fn kind(bytes: &[u8]) -> Option<&'static str> {
    let begins = |with: &[u8]| bytes.starts_with(with);
    match () {
        () if begins(b"\x89PNG\r\n\x1a\n") => Some("image/png"),
        () if begins(b"\xff\xd8\xff") => Some("image/jpeg"),
        () if begins(b"RIFF") && bytes.get(8..12) == Some(b"WEBP") => Some("image/webp"),
        () if begins(b"\xabKTX 20\xbb") => Some("image/ktx2"),
        () => None,
    }
}

/// Names an image that cannot be read, with the files that it was looked for in.
pub(crate) fn missing(name: &str, looked_for: &[PathBuf]) -> String {
    match looked_for {
        [] => name.to_owned(),
        all => {
            let all: Vec<String> = all.iter().map(|file| file.display().to_string()).collect();
            format!("{name} (looked for as {})", all.join(" and "))
        }
    }
}
