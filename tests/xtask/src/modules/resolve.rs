//! From paths to the files that define what they name.

use super::parse::{Crate, Use};
use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

/// For each file those from which it imports.
pub(super) type Imports = BTreeMap<PathBuf, BTreeSet<PathBuf>>;

/// What a name stands for, by the number of a module.
#[derive(Clone, Copy)]
enum Named {
    Module(usize),
    /// Something that the module defines.
    Item(usize),
}

/// How many re-exports a name may pass through.
const MOST_STEPS: usize = 32;

/// Finds each file's imports.
pub(super) fn imports(all: &Crate) -> Imports {
    let mut out = Imports::new();
    for (number, module) in all.modules.iter().enumerate() {
        let mut found = Vec::new();
        for Use { name, path } in &module.uses {
            match (name, resolve(all, number, path, MOST_STEPS)) {
                (None, Some(Named::Module(target))) => {
                    everything(all, target, &mut found, MOST_STEPS)
                }
                (_, Some(Named::Item(target))) => found.push(target),
                // A module by itself is nothing yet: what is taken of it is.
                _ => {}
            }
        }
        for path in &module.paths {
            if let Some(Named::Item(target)) = resolve(all, number, path, MOST_STEPS) {
                found.push(target);
            }
        }
        let files = found.into_iter().map(|target| all.modules[target].file.clone());
        let others = files.filter(|file| *file != module.file);
        let own = out.entry(module.file.clone()).or_default();
        own.extend(others);
    }
    out.retain(|_, targets| !targets.is_empty());
    out
}

/// Lists who defines what a module offers: itself, and what it re-exports.
fn everything(all: &Crate, target: usize, found: &mut Vec<usize>, steps: usize) {
    let module = &all.modules[target];
    if !module.items.is_empty() {
        found.push(target);
    }
    for Use { name, path } in &module.uses {
        let Some(steps) = steps.checked_sub(1) else { return };
        match (name, resolve(all, target, path, steps)) {
            (None, Some(Named::Module(target))) => everything(all, target, found, steps),
            (_, Some(Named::Item(target))) => found.push(target),
            _ => {}
        }
    }
}

/// Follows a path from a module; `None` where it leads out of the crate.
fn resolve(all: &Crate, from: usize, path: &[String], steps: usize) -> Option<Named> {
    let steps = steps.checked_sub(1)?;
    let (first, rest) = path.split_first()?;
    let mut at = match first.as_str() {
        "crate" => Named::Module(0),
        "self" => Named::Module(from),
        "super" => Named::Module(all.modules[from].parent?),
        name => named(all, from, name, steps)?,
    };
    for name in rest {
        at = match at {
            // A method, a variant: they are where their type is.
            Named::Item(_) => return Some(at),
            Named::Module(module) if name == "super" => Named::Module(all.modules[module].parent?),
            Named::Module(module) => named(all, module, name, steps)?,
        };
    }
    Some(at)
}

/// Finds what a module calls by a name.
fn named(all: &Crate, module: usize, name: &str, steps: usize) -> Option<Named> {
    let own = &all.modules[module];
    if let Some(child) = own.children.get(name) {
        return Some(Named::Module(*child));
    }
    if own.items.contains(name) {
        return Some(Named::Item(module));
    }
    let brought = own.uses.iter().filter(|own| own.name.as_deref() == Some(name));
    let brought = brought.filter_map(|own| {
        // `use name;` brings in what another crate is called.
        let is_itself = own.path.len() == 1;
        if is_itself { None } else { resolve(all, module, &own.path, steps) }
    });
    brought.chain(from_globs(all, module, name, steps)).next()
}

fn from_globs(all: &Crate, module: usize, name: &str, steps: usize) -> impl Iterator<Item = Named> {
    let globs = all.modules[module].uses.iter().filter(|own| own.name.is_none());
    globs.filter_map(move |own| match resolve(all, module, &own.path, steps)? {
        Named::Module(target) if target != module => {
            named(all, target, name, steps.checked_sub(1)?)
        }
        _ => None,
    })
}
