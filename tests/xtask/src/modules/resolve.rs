//! Resolves paths to the files that define the names.

use super::parse::{Crate, Use};
use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

/// For each file, the files that it imports from.
pub(super) type Imports = BTreeMap<PathBuf, BTreeSet<PathBuf>>;

/// Meaning of a name, with the index of a module.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Named {
    Module(usize),
    /// An item that the module defines.
    Item(usize),
}

/// All possible meanings of a name: `cfg` chooses one.
type Meanings = BTreeSet<Named>;

/// The names known in each module: its definitions and its `use`s.
struct Names<'a> {
    all: &'a Crate,
    of: Vec<BTreeMap<String, Meanings>>,
}

/// Finds the imports of each file.
pub(super) fn imports(all: &Crate) -> Imports {
    let names = Names::new(all);
    let mut out = Imports::new();
    for (number, module) in all.modules.iter().enumerate() {
        let used = module.uses.iter().flat_map(|own| names.used(number, own));
        let used = used.flat_map(|(_, named)| named);
        let others = module.paths.iter().flat_map(|path| names.resolve(number, path));
        let files = used.chain(others).filter_map(|named| match named {
            Named::Item(target) => Some(all.modules[target].file.clone()),
            // A module alone is not an import; an item in it is.
            Named::Module(_) => None,
        });
        let own = out.entry(module.file.clone()).or_default();
        own.extend(files.filter(|file| *file != module.file));
    }
    out.retain(|_, targets| !targets.is_empty());
    out
}

impl<'a> Names<'a> {
    /// Starts from the definitions of the modules and adds imported names until none is new. A name
    /// may pass through many re-exports, and modules may import everything from each other.
    fn new(all: &'a Crate) -> Self {
        let of = all.modules.iter().enumerate().map(|(number, module)| {
            let items = module.items.iter();
            let items = items.map(|name| (name.clone(), Meanings::from([Named::Item(number)])));
            let children = module.children.iter().map(|(name, children)| {
                (name.clone(), children.iter().copied().map(Named::Module).collect())
            });
            items.chain(children).collect()
        });
        let mut names = Self { all, of: of.collect() };
        loop {
            let grown = (0..all.modules.len()).filter(|&module| names.grow(module));
            if grown.count() == 0 {
                return names;
            }
        }
    }

    /// Adds the names that a module's `use`s import; returns whether a name is new.
    fn grow(&mut self, module: usize) -> bool {
        let own = &self.all.modules[module];
        let mut has_grown = false;
        for brought in &own.uses {
            for (name, named) in self.used(module, brought) {
                // A definition or a named `use` shadows the names of `*`.
                let is_defined = own.items.contains(&name) || own.children.contains_key(&name);
                let is_named = own.uses.iter().any(|other| other.name.as_ref() == Some(&name));
                if is_defined || (brought.name.is_none() && is_named) {
                    continue;
                }
                let meanings = self.of[module].entry(name).or_default();
                let before = meanings.len();
                meanings.extend(named);
                has_grown |= meanings.len() > before;
            }
        }
        has_grown
    }

    /// Lists the names that a `use` of a module imports.
    fn used(&self, module: usize, Use { name, path }: &Use) -> Vec<(String, Meanings)> {
        let found = self.resolve(module, path);
        match name {
            None => {
                let modules = found.iter().filter_map(|named| match named {
                    Named::Module(target) => Some(*target),
                    Named::Item(_) => None,
                });
                let all = modules.flat_map(|target| self.of[target].iter());
                all.map(|(name, named)| (name.clone(), named.clone())).collect()
            }
            // `use name;` imports the name of another crate.
            Some(name) if path.len() > 1 && !found.is_empty() => vec![(name.clone(), found)],
            Some(_) => Vec::new(),
        }
    }

    /// Follows a path from a module; empty if the path leads out of the crate.
    fn resolve(&self, from: usize, path: &[String]) -> Meanings {
        let parent = |module: usize| self.all.modules[module].parent.map(Named::Module);
        let named =
            |module: usize, name: &str| self.of[module].get(name).cloned().unwrap_or_default();
        let Some((first, rest)) = path.split_first() else { return Meanings::new() };
        let mut at = match first.as_str() {
            "crate" => Meanings::from([Named::Module(0)]),
            "self" => Meanings::from([Named::Module(from)]),
            "super" => parent(from).into_iter().collect(),
            name => named(from, name),
        };
        for name in rest {
            let next = at.into_iter().flat_map(|each| match each {
                // A method or variant is defined in the file of its type.
                Named::Item(_) => Meanings::from([each]),
                Named::Module(module) if name == "super" => parent(module).into_iter().collect(),
                Named::Module(module) => named(module, name),
            });
            at = next.collect();
        }
        at
    }
}
