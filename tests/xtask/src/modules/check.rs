//! The check of a crate.

use super::circles::circles;
use super::parse::Crate;
use super::resolve::imports;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Crates whose files must import one way, by their roots.
const CRATES: [&str; 9] = [
    "runtime/src/lib.rs",
    "runtime/capi/src/lib.rs",
    "gpu/src/lib.rs",
    "trainer/src/lib.rs",
    "trainer/src/main.rs",
    "tests/conformance/src/lib.rs",
    "tests/hostile/src/lib.rs",
    "tests/shaders/src/lib.rs",
    "tests/xtask/src/main.rs",
];

/// Checks every crate of a repository.
pub(crate) fn check(repository: &Path) -> Result<(), String> {
    for root in CRATES {
        check_crate(&repository.join(root), &|path| std::fs::read_to_string(path).ok())
            .map_err(|error| format!("{root}: {error}"))?;
    }
    Ok(())
}

/// Checks the crate of a root file; `read` gives a file's text, where there is such a file.
pub(super) fn check_crate(
    root: &Path,
    read: &dyn Fn(&Path) -> Option<String>,
) -> Result<(), String> {
    let parsed = Crate::parse(root, read)?;
    let imports = imports(&parsed);
    // A crate of which nothing was found would be free of circles.
    let with_imports = imports.keys().collect::<BTreeSet<_>>().len();
    if parsed.files().len() > 3 && with_imports < parsed.files().len() / 3 {
        return Err(format!("of {} files only {with_imports} import", parsed.files().len()));
    }
    let found = circles(&imports);
    if found.is_empty() {
        return Ok(());
    }
    let folder = root.parent().unwrap_or(root);
    let name = |file: &PathBuf| file.strip_prefix(folder).unwrap_or(file).display().to_string();
    let circle = |files: &Vec<PathBuf>| {
        let names = files.iter().chain(files.first()).map(name);
        names.collect::<Vec<_>>().join(" -> ")
    };
    Err(format!("imports in a circle: {}", found.iter().map(circle).collect::<Vec<_>>().join("; ")))
}
