//! Compiles the GLSL in `shaders/` to the SPIR-V next to it.
//!
//! Building glslang takes minutes. So tests compare the files with [`sums`] that are kept beside the SPIR-V, and only
//! `cargo xtask shaders` enables the feature `compile`.
#![forbid(unsafe_code)]

#[cfg(feature = "compile")]
mod compile;

use anyhow::{Context, Result};
#[cfg(feature = "compile")]
pub use compile::compile;
use sha2::{Digest, Sha256};
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

/// Name of the file of [`sums`] in the folder of the shaders.
pub const SUMS: &str = "spirv/SHA256SUMS";

/// Returns the folder of the shaders.
pub fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shaders")
}

/// Lists the GLSL shaders of a folder (the other files are included), each with the path of its
/// SPIR-V.
///
/// # Errors
/// If the folder cannot be read.
pub fn sources(folder: &Path) -> Result<Vec<(PathBuf, PathBuf)>> {
    let entries = fs::read_dir(folder).with_context(|| folder.display().to_string())?;
    let mut found = Vec::new();
    for entry in entries {
        let source = entry?.path();
        if source.extension().is_some_and(|extension| extension == "comp") {
            let stem = source.file_stem().unwrap_or_default();
            found.push((source.clone(), folder.join("spirv").join(stem).with_extension("spv")));
        }
    }
    found.sort();
    Ok(found)
}

/// Returns a line `HASH  FILE` for each GLSL file of a folder and each SPIR-V made of it, as `sha256sum` prints them.
///
/// # Errors
/// If a file cannot be read.
pub fn sums(folder: &Path) -> Result<String> {
    let mut files = Vec::new();
    for within in ["", "spirv"] {
        let path = folder.join(within);
        for entry in fs::read_dir(&path).with_context(|| path.display().to_string())? {
            let file = Path::new(within).join(entry?.file_name());
            let extension = file.extension().unwrap_or_default();
            if ["comp", "glsl", "spv"].iter().any(|own| extension == *own) {
                files.push(file);
            }
        }
    }
    files.sort();
    let mut lines = String::new();
    for file in files {
        let path = folder.join(&file);
        let hash = Sha256::digest(fs::read(&path).with_context(|| path.display().to_string())?);
        hash.iter().try_for_each(|byte| write!(lines, "{byte:02x}"))?;
        writeln!(lines, "  {}", file.display())?;
    }
    Ok(lines)
}
