//! Parses the modules of a crate: their definitions and the paths in them.

use super::tokens::tokens;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Component, Path, PathBuf};

/// The modules of a crate; the first module is the root.
pub(super) struct Crate {
    pub(super) modules: Vec<Module>,
}

/// A module: a file's module, or an inline module.
pub(super) struct Module {
    pub(super) file: PathBuf,
    pub(super) parent: Option<usize>,
    /// Children by name; several children share a name if `cfg` chooses between them.
    pub(super) children: BTreeMap<String, Vec<usize>>,
    /// Names that the module defines.
    pub(super) items: BTreeSet<String>,
    /// Names that the module imports with `use`.
    pub(super) uses: Vec<Use>,
    /// Other paths in the module.
    pub(super) paths: Vec<Vec<String>>,
}

/// A leaf of a `use`.
pub(super) struct Use {
    /// The imported name; `None` for `*`.
    pub(super) name: Option<String>,
    pub(super) path: Vec<String>,
}

/// Keywords before the name of a definition.
const DEFINING: [&str; 8] = ["fn", "struct", "enum", "union", "trait", "type", "const", "static"];

impl Crate {
    /// Parses the root file and the files of its modules.
    pub(super) fn parse(
        root: &Path,
        read: &dyn Fn(&Path) -> Option<String>,
    ) -> Result<Self, String> {
        let mut out = Self { modules: Vec::new() };
        let folder = root.parent().unwrap_or(Path::new("")).to_owned();
        out.file(None, &normal(root), &normal(&folder), read)?;
        Ok(out)
    }

    /// Lists the files of the crate.
    pub(super) fn files(&self) -> BTreeSet<&Path> {
        self.modules.iter().map(|module| module.file.as_path()).collect()
    }

    /// Parses a file and the files below it; returns the index of its module.
    fn file(
        &mut self,
        parent: Option<usize>,
        file: &Path,
        folder: &Path,
        read: &dyn Fn(&Path) -> Option<String>,
    ) -> Result<usize, String> {
        let text = read(file).ok_or_else(|| format!("cannot read {}", file.display()))?;
        let tokens = tokens(&text);
        let mut walk = Walk { tokens: &tokens, at: 0, file, read, places: Vec::new() };
        let module = self.add(parent, file);
        walk.module(self, module, folder)?;
        Ok(module)
    }

    fn add(&mut self, parent: Option<usize>, file: &Path) -> usize {
        self.modules.push(Module {
            file: file.to_owned(),
            parent,
            children: BTreeMap::new(),
            items: BTreeSet::new(),
            uses: Vec::new(),
            paths: Vec::new(),
        });
        self.modules.len() - 1
    }
}

/// A position in a file.
struct Walk<'a> {
    tokens: &'a [String],
    at: usize,
    file: &'a Path,
    read: &'a dyn Fn(&Path) -> Option<String>,
    /// Files of the next module by its attributes, each with whether the attribute always applies.
    places: Vec<(String, bool)>,
}

impl Walk<'_> {
    fn peek(&self, ahead: usize) -> &str {
        self.tokens.get(self.at + ahead).map_or("", String::as_str)
    }

    fn is_name(token: &str) -> bool {
        token.starts_with(|sign: char| sign.is_alphabetic() || sign == '_')
    }

    /// Parses a module to its end; `folder` is the folder for files of its children.
    fn module(&mut self, all: &mut Crate, own: usize, folder: &Path) -> Result<(), String> {
        let mut depth = 0;
        while self.at < self.tokens.len() {
            match self.peek(0) {
                "#" => {
                    if self.attribute() {
                        self.skip_item();
                        self.places.clear();
                    }
                    continue;
                }
                "{" => depth += 1,
                "}" if depth == 0 => return Ok(()),
                "}" => depth -= 1,
                "use" => {
                    self.at += 1;
                    self.use_tree(&mut all.modules[own], Vec::new());
                    continue;
                }
                "mod" if depth == 0 && Self::is_name(self.peek(1)) => {
                    self.child(all, own, folder)?;
                    continue;
                }
                "macro_rules" if depth == 0 => {
                    all.modules[own].items.insert(self.peek(2).to_owned());
                }
                word if depth == 0 && DEFINING.contains(&word) => {
                    let ahead = if self.peek(1) == "mut" { 2 } else { 1 };
                    let name = self.peek(ahead);
                    if Self::is_name(name) && !DEFINING.contains(&name) {
                        all.modules[own].items.insert(name.to_owned());
                    }
                }
                word if Self::is_name(word) && self.peek(1) == "::" => {
                    let path = self.path();
                    all.modules[own].paths.push(path);
                    continue;
                }
                _ => {}
            }
            self.at += 1;
        }
        Ok(())
    }

    /// Parses `mod name;` or `mod name { ... }`.
    fn child(&mut self, all: &mut Crate, own: usize, folder: &Path) -> Result<(), String> {
        let name = self.peek(1).to_owned();
        let below = folder.join(&name);
        let places = std::mem::take(&mut self.places);
        if self.peek(2) == "{" {
            self.at += 3;
            let child = all.add(Some(own), self.file);
            self.module(all, child, &below)?;
            all.modules[own].children.entry(name).or_default().push(child);
            // The brace.
            self.at += 1;
            return Ok(());
        }
        // `path` is relative to the folder of the file, or, in an inline module, to the folder for
        // files of its children. Children of the named file lie next to that file.
        let is_inline = all.modules[own].parent.is_some_and(|p| all.modules[p].file == self.file);
        let from = self.file.parent().filter(|_| !is_inline).unwrap_or(folder);
        let mut files = Vec::new();
        for (place, _) in &places {
            let file = normal(&from.join(place));
            let beside = file.parent().unwrap_or(from).to_owned();
            files.push((file, beside));
        }
        if places.iter().all(|(_, always)| !always) {
            let (beside, inside) = (folder.join(format!("{name}.rs")), below.join("mod.rs"));
            let is_beside = (self.read)(&beside).is_some();
            // If every `cfg` has its own path, the default file may be missing.
            if is_beside || files.is_empty() || (self.read)(&inside).is_some() {
                files.push((if is_beside { beside } else { inside }, below));
            }
        }
        for (file, folder) in files {
            let child = all.file(Some(own), &file, &folder, self.read)?;
            all.modules[own].children.entry(name.clone()).or_default().push(child);
        }
        // The semicolon and the two words before it.
        self.at += 3;
        Ok(())
    }

    /// Parses an attribute; returns whether the next item exists only in tests.
    fn attribute(&mut self) -> bool {
        let start = self.at;
        self.at += if self.peek(1) == "!" { 2 } else { 1 };
        self.skip_group();
        let words: Vec<&str> = self.tokens[start..self.at].iter().map(String::as_str).collect();
        let always = !words.contains(&"cfg_attr");
        let texts = words.iter().filter_map(|word| word.strip_prefix('"'));
        self.places.extend(texts.map(|place| (place.to_owned(), always)));
        match words[..] {
            ["#", "[", "cfg", "(", ref condition @ .., ")", "]"] => needs_test(condition),
            _ => false,
        }
    }

    /// Skips a bracket and its content, or a single token.
    fn skip_group(&mut self) {
        let mut depth = 0;
        while self.at < self.tokens.len() {
            match self.peek(0) {
                "(" | "[" | "{" => depth += 1,
                ")" | "]" | "}" => depth -= 1,
                _ => {}
            }
            self.at += 1;
            if depth == 0 {
                return;
            }
        }
    }

    /// Skips an item to its semicolon or to the end of its body; a `use` has no body.
    fn skip_item(&mut self) {
        let mut is_use = false;
        while self.at < self.tokens.len() {
            match self.peek(0) {
                ";" => {
                    self.at += 1;
                    return;
                }
                "{" => {
                    self.skip_group();
                    if !is_use {
                        return;
                    }
                }
                "(" | "[" => self.skip_group(),
                word => {
                    is_use |= word == "use";
                    self.at += 1;
                }
            }
        }
    }

    /// Parses names separated by `::`; a `::` before a token that is no name ends the path.
    fn path(&mut self) -> Vec<String> {
        let mut out = vec![self.peek(0).to_owned()];
        self.at += 1;
        while self.peek(0) == "::" && Self::is_name(self.peek(1)) {
            out.push(self.peek(1).to_owned());
            self.at += 2;
        }
        // Names after `::<...>` belong to an item that is already named.
        if self.peek(0) == "::" {
            self.at += 1;
        }
        out
    }

    /// Parses the tree of a `use` after the names before it.
    fn use_tree(&mut self, own: &mut Module, mut path: Vec<String>) {
        if self.peek(0) == "::" {
            // A path into another crate.
            self.at += 1;
        }
        loop {
            match self.peek(0) {
                "{" => {
                    self.at += 1;
                    while !["}", ""].contains(&self.peek(0)) {
                        self.use_tree(own, path.clone());
                        if self.peek(0) == "," {
                            self.at += 1;
                        }
                    }
                    self.at += 1;
                    return;
                }
                "*" => {
                    self.at += 1;
                    own.uses.push(Use { name: None, path });
                    return;
                }
                word if Self::is_name(word) => {
                    path.push(word.to_owned());
                    self.at += 1;
                }
                _ => return,
            }
            if self.peek(0) == "::" {
                self.at += 1;
                continue;
            }
            // `{self}` names the module before the braces.
            if path.len() > 1 && path.last().is_some_and(|last| last == "self") {
                path.pop();
            }
            let mut name = path.last().cloned();
            if self.peek(0) == "as" {
                name = Some(self.peek(1).to_owned());
                self.at += 2;
            }
            own.uses.push(Use { name, path });
            return;
        }
    }
}

/// Returns whether a condition of `cfg` holds only in tests; any other condition may hold.
fn needs_test(condition: &[&str]) -> bool {
    match condition {
        ["test"] => true,
        ["all", "(", list @ .., ")"] => listed(list).any(needs_test),
        ["any", "(", list @ .., ")"] => listed(list).all(needs_test),
        _ => false,
    }
}

/// Splits at commas outside brackets.
fn listed<'a>(words: &'a [&'a str]) -> impl Iterator<Item = &'a [&'a str]> {
    let mut depth = 0;
    let parts = words.split(move |word| {
        depth += match *word {
            "(" => 1,
            ")" => -1,
            _ => 0,
        };
        *word == "," && depth == 0
    });
    parts.filter(|part| !part.is_empty())
}

/// Resolves `..` in a path.
pub(super) fn normal(path: &Path) -> PathBuf {
    let mut out = PathBuf::new();
    for part in path.components() {
        let leaves = part == Component::ParentDir
            && matches!(out.components().next_back(), Some(Component::Normal(_)));
        if leaves {
            out.pop();
        } else {
            out.push(part);
        }
    }
    out
}
