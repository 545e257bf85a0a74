//! The kinds of images that glTF knows.

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
