//! Checks the imports of crates: finds circles.

use super::parse::{Crate, normal};
use super::resolve::{Imports, imports};
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::path::{Path, PathBuf};

/// Packages whose files must not import in circles.
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

/// Checks the crate of a root file; `read` returns the text of a file, or `None` if there is no
/// file.
pub(super) fn check_crate(
    root: &Path,
    read: &dyn Fn(&Path) -> Option<String>,
) -> Result<(), String> {
    let parsed = Crate::parse(root, read)?;
    let imports = imports(&parsed);
    // A crate without detected imports would pass: the parser must find some.
    let with_imports = imports.keys().collect::<BTreeSet<_>>().len();
    if parsed.files().len() > 3 && with_imports < parsed.files().len() / 3 {
        return Err(format!("only {with_imports} of {} files import others", parsed.files().len()));
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

/// Finds circles. If circles share a file, only the first is listed, as the shortest circle through
/// its first file.
fn circles(imports: &Imports) -> Vec<Vec<PathBuf>> {
    let mut out: Vec<Vec<PathBuf>> = Vec::new();
    for file in imports.keys() {
        if out.iter().flatten().any(|seen| seen == file) {
            continue;
        }
        out.extend(shortest(imports, file));
    }
    out
}

/// Finds the shortest path from a file back to the file.
fn shortest(imports: &Imports, start: &PathBuf) -> Option<Vec<PathBuf>> {
    let none = BTreeSet::new();
    let mut before: BTreeMap<&PathBuf, &PathBuf> = BTreeMap::new();
    let mut open = VecDeque::from([start]);
    while let Some(file) = open.pop_front() {
        for next in imports.get(file).unwrap_or(&none) {
            if next == start {
                let mut way = vec![file.clone()];
                let mut at = file;
                while let Some(earlier) = before.get(at) {
                    way.push((*earlier).clone());
                    at = earlier;
                }
                way.reverse();
                return Some(way);
            }
            if !before.contains_key(next) {
                before.insert(next, file);
                open.push_back(next);
            }
        }
    }
    None
}
