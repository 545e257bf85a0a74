//! The check of a crate.

use super::circles::circles;
use super::parse::{Crate, normal};
use super::resolve::imports;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Packages whose files must import one way.
const PACKAGES: [&str; 11] = [
    "runtime",
    "runtime/capi",
    "gpu",
    "trainer",
    "tests/conformance",
    "tests/firmware",
    "tests/hostile",
    "tests/models",
    "tests/pages",
    "tests/shaders",
    "tests/xtask",
];

/// Checks every crate of a repository.
pub(crate) fn check(repository: &Path) -> Result<(), String> {
    for package in PACKAGES {
        let roots = roots(&repository.join(package));
        if roots.is_empty() {
            return Err(format!("{package} has no crate"));
        }
        for root in roots {
            check_crate(&root, &|path| std::fs::read_to_string(path).ok())
                .map_err(|error| format!("{}: {error}", root.display()))?;
        }
    }
    Ok(())
}

/// Lists the root files of a package's library and programs.
fn roots(package: &Path) -> Vec<PathBuf> {
    let own = ["src/lib.rs", "src/main.rs"].map(|root| package.join(root));
    let mut roots: Vec<_> = own.into_iter().filter(|root| root.is_file()).collect();
    let programs = std::fs::read_dir(package.join("src/bin")).into_iter().flatten().flatten();
    let programs = programs.map(|entry| entry.path());
    roots.extend(programs.filter(|path| path.extension().is_some_and(|end| end == "rs")));
    roots.sort();
    roots
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
    let root = normal(root);
    let folder = root.parent().unwrap_or(&root);
    let name = |file: &PathBuf| file.strip_prefix(folder).unwrap_or(file).display().to_string();
    let circle = |files: &Vec<PathBuf>| {
        let names = files.iter().chain(files.first()).map(name);
        names.collect::<Vec<_>>().join(" -> ")
    };
    Err(format!("imports in a circle: {}", found.iter().map(circle).collect::<Vec<_>>().join("; ")))
}
