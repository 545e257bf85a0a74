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

/// What each module calls by which name: what it defines, and what its `use`s bring in.
struct Names<'a> {
    all: &'a Crate,
    of: Vec<BTreeMap<String, Named>>,
}

/// Finds each file's imports.
pub(super) fn imports(all: &Crate) -> Imports {
    let names = Names::new(all);
    let mut out = Imports::new();
    for (number, module) in all.modules.iter().enumerate() {
        let used = module.uses.iter().flat_map(|own| names.used(number, own));
        let used = used.map(|(_, named)| named);
        let others = module.paths.iter().filter_map(|path| names.resolve(number, path));
        let files = used.chain(others).filter_map(|named| match named {
            Named::Item(target) => Some(all.modules[target].file.clone()),
            // A module by itself is nothing yet: what is taken of it is.
            Named::Module(_) => None,
        });
        let own = out.entry(module.file.clone()).or_default();
        own.extend(files.filter(|file| *file != module.file));
    }
    out.retain(|_, targets| !targets.is_empty());
    out
}

impl<'a> Names<'a> {
    /// Starts from what the modules define, and adds what they bring in until nothing is new: a name may
    /// pass through any number of re-exports, and modules may bring in all of each other.
    fn new(all: &'a Crate) -> Self {
        let of = all.modules.iter().enumerate().map(|(number, module)| {
            let items = module.items.iter().map(|name| (name.clone(), Named::Item(number)));
            let children = module.children.iter();
            items
                .chain(children.map(|(name, child)| (name.clone(), Named::Module(*child))))
                .collect()
        });
        let mut names = Self { all, of: of.collect() };
        loop {
            let grown = (0..all.modules.len()).filter(|&module| names.grow(module));
            if grown.count() == 0 {
                return names;
            }
        }
    }

    /// Adds what a module's `use`s bring in; returns whether that is more than before.
    fn grow(&mut self, module: usize) -> bool {
        let uses = self.all.modules[module].uses.iter();
        let brought: Vec<_> = uses.flat_map(|own| self.used(module, own)).collect();
        let before = self.of[module].len();
        for (name, named) in brought {
            self.of[module].entry(name).or_insert(named);
        }
        self.of[module].len() > before
    }

    /// Lists what a `use` of a module brings in.
    fn used(&self, module: usize, Use { name, path }: &Use) -> Vec<(String, Named)> {
        match (name, self.resolve(module, path)) {
            (None, Some(Named::Module(target))) => {
                self.of[target].iter().map(|(name, named)| (name.clone(), *named)).collect()
            }
            // `use name;` brings in what another crate is called.
            (Some(name), Some(named)) if path.len() > 1 => vec![(name.clone(), named)],
            _ => Vec::new(),
        }
    }

    /// Follows a path from a module; `None` where it leads out of the crate.
    fn resolve(&self, from: usize, path: &[String]) -> Option<Named> {
        let parent = |module: usize| self.all.modules[module].parent.map(Named::Module);
        let (first, rest) = path.split_first()?;
        let mut at = match first.as_str() {
            "crate" => Named::Module(0),
            "self" => Named::Module(from),
            "super" => parent(from)?,
            name => *self.of[from].get(name)?,
        };
        for name in rest {
            at = match at {
                // A method, a variant: they are where their type is.
                Named::Item(_) => return Some(at),
                Named::Module(module) if name == "super" => parent(module)?,
                Named::Module(module) => *self.of[module].get(name)?,
            };
        }
        Some(at)
    }
}
