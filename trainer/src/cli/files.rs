//! Files that a command writes: checked before the work begins, moved into place when all are complete.

use crate::files::PendingFile;
use crate::formats::Content;
use crate::page::drawing::Drawing;
use anyhow::{Context, bail};
use std::ffi::OsStr;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Endings of files that other programs read.
const FOREIGN: [&str; 23] = [
    "abc", "blend", "csv", "fbx", "gif", "glb", "gltf", "html", "jpg", "json", "npy", "npz", "obj",
    "pc2", "pdf", "ply", "png", "txt", "usd", "usda", "usdc", "usdz", "yaml",
];

/// File that can be written.
pub(super) struct OutputFile {
    /// Path as given.
    pub(super) named: PathBuf,
    /// Absolute path without links.
    place: PathBuf,
}

impl OutputFile {
    /// Checks that a file can be written, so that hours of work do not end in a result that cannot be written.
    ///
    /// - `taken`: inputs, which must not be overwritten.
    ///
    /// # Errors
    /// The path is one of `taken` or no regular file, or its folder is missing or cannot be written to.
    pub(super) fn new(
        path: &Path,
        taken: impl IntoIterator<Item = impl AsRef<Path>>,
    ) -> anyhow::Result<Self> {
        let named = path.to_owned();
        let folder_like = path.as_os_str().as_encoded_bytes().ends_with(b"/");
        let (Some(name), Some(folder), false) = (path.file_name(), path.parent(), folder_like)
        else {
            bail!("{}: it is a folder", cannot_write(path));
        };
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        if !folder.is_dir() {
            bail!("{}: there is no folder {}", cannot_write(path), folder.display());
        }
        let place = path.canonicalize().or_else(|_| folder.canonicalize().map(|f| f.join(name)));
        let place = place.with_context(|| cannot_write(path))?;
        match fs::metadata(&place) {
            Ok(there) if there.is_dir() => bail!("{}: it is a folder", cannot_write(path)),
            Ok(there) if !there.is_file() => bail!("{}: it is no file", cannot_write(path)),
            _ => {}
        }
        let mut taken = taken.into_iter().map(|other| other.as_ref().canonicalize());
        if taken.any(|other| other.is_ok_and(|other| other == place)) {
            bail!("{}: it is an input", cannot_write(path));
        }
        let target = Self { named, place };
        target.part(&[])?;
        Ok(target)
    }

    /// Checks the ending, one of `known`.
    ///
    /// # Errors
    /// The file has another ending.
    pub(super) fn ending_in(self, known: &[&'static str]) -> anyhow::Result<Self> {
        ending(&self.named, known)?;
        Ok(self)
    }

    /// Checks the ending of a model.
    ///
    /// # Errors
    /// The ending is that of another kind of file.
    pub(super) fn of_a_model(self) -> anyhow::Result<Self> {
        self.of_a("a model", "sinew")
    }

    /// Checks the ending of a report.
    ///
    /// # Errors
    /// The ending is that of another kind of file.
    pub(super) fn of_a_report(self) -> anyhow::Result<Self> {
        self.of_a("a report", "html")
    }

    fn of_a(self, what: &str, ending: &str) -> anyhow::Result<Self> {
        let own = self.named.extension().map(|own| own.to_ascii_lowercase());
        let own = own.as_ref().and_then(|own| own.to_str()).filter(|own| *own != ending);
        if let Some(own) = own.filter(|own| FOREIGN.contains(own)) {
            bail!("{}: {what} is no .{own} file, name it .{ending}", cannot_write(&self.named));
        }
        Ok(self)
    }

    /// Returns whether two paths lead to one file.
    pub(super) fn is(&self, other: &OutputFile) -> bool {
        self.place == other.place
    }

    /// Writes bytes to a file in the same folder.
    fn part(&self, bytes: &[u8]) -> anyhow::Result<PendingFile> {
        let written = PendingFile::create(&self.place)
            .and_then(|mut part| part.file.write_all(bytes).map(|()| part));
        written.with_context(|| cannot_write(&self.named))
    }
}

/// Adds the name of a file to errors.
pub(super) trait OfFile<T> {
    /// Returns the value, or the error with the name of `file`.
    fn of(self, file: &Path) -> anyhow::Result<T>;
}

impl<T, E> OfFile<T> for Result<T, E>
where
    Result<T, E>: Context<T, E>,
{
    fn of(self, file: &Path) -> anyhow::Result<T> {
        self.with_context(|| file.display().to_string())
    }
}

/// Refuses two outputs that are one file.
///
/// # Errors
/// Names the file.
pub(super) fn refuse_same(files: &[Option<&OutputFile>]) -> anyhow::Result<()> {
    let files: Vec<_> = files.iter().flatten().collect();
    for (number, one) in files.iter().enumerate() {
        if files[..number].iter().any(|other| other.is(one)) {
            bail!("{}: two outputs are one file", cannot_write(&one.named));
        }
    }
    Ok(())
}

/// Writes complete files, in order. All are written to their folders before the first is moved into place, so that a
/// failure leaves every file as it was.
///
/// # Errors
/// Names the file that could not be written.
pub(super) fn write(files: &[(&OutputFile, &[u8])]) -> anyhow::Result<()> {
    let parts = files.iter().map(|(target, bytes)| target.part(bytes));
    let parts = parts.collect::<anyhow::Result<Vec<_>>>()?;
    for (part, (target, _)) in parts.into_iter().zip(files) {
        part.finish().with_context(|| cannot_write(&target.named))?;
    }
    Ok(())
}

/// States that a file was written, with its number of bytes.
pub(super) fn wrote(file: &OutputFile, bytes: &[u8]) -> String {
    format!("wrote {} ({} bytes)", file.named.display(), bytes.len())
}

/// Returns the ending of a file, one of `known`, regardless of case.
///
/// # Errors
/// The file has another ending.
pub(super) fn ending(path: &Path, known: &[&'static str]) -> anyhow::Result<&'static str> {
    let own = path.extension().unwrap_or_default();
    let found = known.iter().find(|known| own.eq_ignore_ascii_case(OsStr::new(known)));
    found.copied().with_context(|| {
        let (last, others) = known.split_last().unwrap_or((&"", &[]));
        let others = others.join(", .");
        let known = if others.is_empty() { String::new() } else { format!(".{others} or ") };
        format!("{}: expected a file that ends in {known}.{last}", path.display())
    })
}

/// Returns a drawing as a file, SVG or PNG by the path's ending.
///
/// # Errors
/// The drawing cannot be encoded.
pub(super) fn drawn(drawing: &Drawing, path: &Path) -> anyhow::Result<Vec<u8>> {
    let is_svg = ending(path, &["png", "svg"])? == "svg";
    Ok(if is_svg { drawing.svg()?.into_bytes() } else { drawing.picture().png()? })
}

/// Makes a folder if it does not exist.
///
/// # Errors
/// The folder cannot be made.
pub(super) fn make_folder(folder: &Path) -> anyhow::Result<()> {
    let cannot_make = || format!("cannot make the folder {}", folder.display());
    if folder.is_file() {
        bail!("{}: it is a file", cannot_make());
    }
    fs::create_dir_all(folder).with_context(cannot_make)
}

fn cannot_write(path: &Path) -> String {
    format!("cannot write {}", path.display())
}

/// Returns whether bytes are lines of text.
fn is_text(bytes: &[u8]) -> bool {
    bytes.contains(&b'\n') && !bytes.contains(&0) && std::str::from_utf8(bytes).is_ok()
}

/// Reads a model file.
pub(super) fn read_model(path: &Path) -> anyhow::Result<Vec<u8>> {
    let cannot_read = || format!("cannot read {}", path.display());
    let kind = std::fs::metadata(path).with_context(cannot_read)?;
    if !kind.is_file() {
        // Reading a device may never end.
        bail!("{}: it is {}", cannot_read(), if kind.is_dir() { "a folder" } else { "no file" });
    }
    let bytes = std::fs::read(path).with_context(cannot_read)?;
    match Content::of(&bytes) {
        Some(Content::Examples(ending)) => bail!(
            "{}: holds what a .{ending} file holds, expected a model, which commands take first",
            path.display()
        ),
        None if is_text(&bytes) => {
            bail!("{}: holds text, expected a model, which commands take first", path.display())
        }
        _ if bytes.is_empty() => {
            bail!("{}: the model is refused: the file is empty", path.display())
        }
        _ => Ok(bytes),
    }
}
