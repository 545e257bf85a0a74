//! Checks of a release, and its files: licences and sources of dependencies, packages of crates, binaries, the C archive.

use super::call::{cargo, run, target_folder};
use super::components::starts;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

const VERSION: &str = env!("CARGO_PKG_VERSION");

/// Version of the program that checks dependencies.
const DENY: &str = "0.18";

/// Checks licences, sources and duplicate versions of all dependencies, and that every crate can be published.
pub(super) fn check() -> Result<(), String> {
    if !starts("cargo-deny") {
        cargo(&format!("install --quiet --locked cargo-deny --version ^{DENY}"), &[])
            .map_err(|error| format!("{error}; run `cargo install --locked cargo-deny`"))?;
    }
    cargo("deny --offline --locked check licenses sources bans", &[])?;
    cargo("publish --workspace --dry-run --locked --no-verify --allow-dirty", &[])
}

/// Builds the command-line program and the C library, and packs them in `dist` of the target folder.
pub(super) fn dist() -> Result<(), String> {
    let target = target_folder()?;
    cargo("build --release --locked --bin sinew", &[])?;
    cargo("rustc -p sinew-capi --lib --crate-type staticlib,cdylib --profile embed --locked", &[])?;
    let triple = host()?;
    let (program, library) = (target.join("release"), target.join("embed"));
    let (exe, prefix) = (std::env::consts::EXE_SUFFIX, std::env::consts::DLL_PREFIX);
    let (shared, archive) =
        (std::env::consts::DLL_SUFFIX, if prefix.is_empty() { "lib" } else { "a" });
    let tool = vec![
        (program.join(format!("sinew{exe}")), ""),
        ("README.md".into(), ""),
        ("trainer/blender_export.py".into(), ""),
    ];
    let c = vec![
        (library.join(format!("{prefix}sinew_capi.{archive}")), "lib"),
        (library.join(format!("{prefix}sinew_capi{shared}")), "lib"),
        ("runtime/capi/include/sinew.h".into(), "include"),
        ("runtime/capi/include/sinew.hpp".into(), "include"),
        ("runtime/examples/host.c".into(), "examples"),
        ("runtime/examples/host.cpp".into(), "examples"),
        ("runtime/capi/README.md".into(), ""),
    ];
    for (name, files) in [("sinew", tool), ("sinew-c", c)] {
        let name = format!("{name}-{VERSION}-{triple}");
        pack(&target.join("dist"), &name, files).map_err(|error| format!("{name}: {error}"))?;
    }
    Ok(())
}

/// Copies files and the licences into a folder `name` of `dist`, each under a folder of its own, and archives it.
fn pack(dist: &Path, name: &str, files: Vec<(PathBuf, &str)>) -> Result<(), String> {
    let folder = dist.join(name);
    let _ = fs::remove_dir_all(&folder);
    let licences = ["LICENSE-APACHE", "LICENSE-MIT"].map(|file| (file.into(), ""));
    for (file, under) in files.into_iter().chain(licences) {
        let to = folder.join(under);
        fs::create_dir_all(&to).map_err(|error| error.to_string())?;
        let to = to.join(file.file_name().unwrap_or_default());
        fs::copy(&file, to).map_err(|error| format!("{}: {error}", file.display()))?;
    }
    let archive = format!("{name}.tar.gz");
    run(Command::new("tar").args(["-czf", &archive, name]).current_dir(dist))?;
    println!("{}", dist.join(archive).display());
    Ok(())
}

/// Returns this machine's target triple.
fn host() -> Result<String, String> {
    let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let told = Command::new(rustc).arg("-vV").output().map_err(|error| error.to_string())?;
    let told = String::from_utf8_lossy(&told.stdout).into_owned();
    let host = told.lines().find_map(|line| line.strip_prefix("host: "));
    host.map(str::to_owned).ok_or_else(|| "rustc -vV names no host".to_owned())
}
