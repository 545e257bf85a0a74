//! Text of USD: prims, values and names.

use nalgebra::Matrix4;
use std::collections::HashSet;
use std::fmt::Display;

/// A file in the making.
pub(super) struct Text {
    out: String,
    depth: usize,
}

impl Text {
    pub(super) fn new() -> Self {
        Self { out: "#usda 1.0\n".to_owned(), depth: 0 }
    }

    /// Writes the metadata of the stage.
    pub(super) fn stage(&mut self, metadata: &[String]) {
        self.out += "(\n";
        metadata.iter().for_each(|line| self.out += &format!("    {line}\n"));
        self.out += ")\n";
    }

    /// Opens a prim with metadata.
    pub(super) fn open(&mut self, prim: &str, metadata: &[&str]) {
        self.out += "\n";
        if metadata.is_empty() {
            self.line(prim);
        } else {
            self.line(&format!("{prim} ("));
            metadata.iter().for_each(|line| self.line(&format!("    {line}")));
            self.line(")");
        }
        self.line("{");
        self.depth += 1;
    }

    /// Closes the prim that was opened last.
    pub(super) fn close(&mut self) {
        self.depth -= 1;
        self.line("}");
    }

    pub(super) fn line(&mut self, line: &str) {
        (0..self.depth).for_each(|_| self.out += "    ");
        self.out += line;
        self.out += "\n";
    }

    pub(super) fn finish(self) -> String {
        self.out
    }
}

/// Names of siblings.
#[derive(Default)]
pub(super) struct Names {
    taken: HashSet<String>,
}

impl Names {
    /// Makes an identifier of letters, digits and `_` from a name. If a sibling has it, a number is added.
    pub(super) fn new_one(&mut self, name: &str) -> String {
        let plain = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
        let mut own: String = name.chars().map(plain).collect();
        if own.starts_with(|c: char| c.is_ascii_digit()) || own.is_empty() {
            own.insert(0, '_');
        }
        let numbered = (1..).map(|number| format!("{own}_{number}"));
        let free = std::iter::once(own.clone()).chain(numbered);
        let found = free.into_iter().find(|name| !self.taken.contains(name)).unwrap_or_default();
        self.taken.insert(found.clone());
        found
    }
}

/// Quotes a text.
pub(super) fn quoted(text: &str) -> String {
    let mut out = "\"".to_owned();
    for c in text.chars() {
        match c {
            '"' | '\\' => out.extend(['\\', c]),
            _ if c.is_control() => out.push(' '),
            _ => out.push(c),
        }
    }
    out + "\""
}

/// Writes a list of texts.
pub(super) fn texts(all: &[&str]) -> String {
    list(all.iter().map(|text| quoted(text)))
}

/// Writes a list.
pub(super) fn list(items: impl Iterator<Item = impl Display>) -> String {
    let items: Vec<String> = items.map(|item| item.to_string()).collect();
    format!("[{}]", items.join(", "))
}

/// Writes a tuple.
pub(super) fn tuple<const N: usize>(numbers: [impl Display; N]) -> String {
    format!("({})", numbers.map(|x| x.to_string()).join(", "))
}

/// Writes a matrix. USD multiplies rows, so its rows are our columns.
pub(super) fn matrix(map: &Matrix4<f64>) -> String {
    let column = |c: usize| tuple([0, 1, 2, 3].map(|row| map[(row, c)]));
    tuple([0, 1, 2, 3].map(column))
}

/// Metadata of applied schemas.
pub(super) fn schemas(names: &[&str]) -> String {
    format!("prepend apiSchemas = {}", texts(names))
}
