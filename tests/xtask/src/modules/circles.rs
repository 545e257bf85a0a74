//! Circles of imports.

use super::resolve::Imports;
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::path::PathBuf;

/// Finds circles: of all that share a file the first, each as short as one through its first file is.
pub(super) fn circles(imports: &Imports) -> Vec<Vec<PathBuf>> {
    let mut out: Vec<Vec<PathBuf>> = Vec::new();
    for file in imports.keys() {
        if out.iter().flatten().any(|seen| seen == file) {
            continue;
        }
        out.extend(shortest(imports, file));
    }
    out
}

/// Finds the shortest way from a file back to it.
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
