//! Counts lines of code: neither blank, nor comments, nor tests.

use std::path::{Path, PathBuf};

/// Crates that ship.
const SOURCES: [&str; 4] = ["runtime/src", "runtime/capi/src", "trainer/src", "gpu/src"];

/// Prints the files and lines of code of each folder that ships.
pub(crate) fn print() -> Result<(), String> {
    let mut all = [0, 0];
    for root in SOURCES {
        let mut folders = vec![(root.to_owned(), [0, 0])];
        for entry in entries(Path::new(root))? {
            let name = if entry.is_dir() { entry.display().to_string() } else { root.to_owned() };
            let [files, lines] = count(&entry)?;
            match folders.iter_mut().find(|(own, _)| *own == name) {
                Some((_, sum)) => *sum = [sum[0] + files, sum[1] + lines],
                None => folders.push((name, [files, lines])),
            }
        }
        for (name, [files, lines]) in folders {
            println!("{name:30} {files:5} files {lines:6} lines");
            all = [all[0] + files, all[1] + lines];
        }
    }
    println!("{:30} {:5} files {:6} lines", "all", all[0], all[1]);
    Ok(())
}

/// Counts the files and their lines of code under a path.
fn count(path: &Path) -> Result<[usize; 2], String> {
    if path.is_dir() {
        let mut sum = [0, 0];
        for entry in entries(path)? {
            let [files, lines] = count(&entry)?;
            sum = [sum[0] + files, sum[1] + lines];
        }
        return Ok(sum);
    }
    if path.extension().is_none_or(|extension| extension != "rs") {
        return Ok([0, 0]);
    }
    let source = std::fs::read_to_string(path).map_err(|error| said(path, &error))?;
    let is_test = ["tests", "testing"].iter().any(|name| {
        path.file_stem().is_some_and(|stem| stem == *name)
            || path.parent().is_some_and(|parent| parent.ends_with(name))
    });
    Ok([1, if is_test { 0 } else { code(&source) }])
}

/// Counts the lines of code of a source that rustfmt has formatted.
fn code(source: &str) -> usize {
    let mut lines = source.lines();
    let mut count = 0;
    while let Some(line) = lines.next() {
        let text = line.trim();
        if text == "#[cfg(test)]" {
            let mut item = lines.by_ref().skip_while(|line| line.trim_start().starts_with("#["));
            let first = item.next().unwrap_or_default();
            if !first.ends_with(';') {
                let indent = &first[..first.len() - first.trim_start().len()];
                item.find(|line| line.strip_prefix(indent).is_some_and(|end| end.starts_with('}')));
            }
        } else if !text.is_empty() && !text.starts_with("//") {
            count += 1;
        }
    }
    count
}

fn entries(folder: &Path) -> Result<Vec<PathBuf>, String> {
    let entries = std::fs::read_dir(folder).map_err(|error| said(folder, &error))?;
    let mut paths = Vec::new();
    for entry in entries {
        paths.push(entry.map_err(|error| said(folder, &error))?.path());
    }
    paths.sort();
    Ok(paths)
}

fn said(path: &Path, error: &std::io::Error) -> String {
    format!("{}: {error}", path.display())
}

#[cfg(test)]
mod tests {
    use super::code;

    #[test]
    fn blanks_comments_and_tests_are_no_code() {
        let source = "//! A file.\n\nuse a::b;\n\n/// A function.\nfn f() {\n    // Why.\n    g();\n}\n\n\
                      #[cfg(test)]\npub(crate) mod testing;\nmod c;\n\n#[cfg(test)]\n#[allow(x)]\nmod tests {\n    fn t() {\n    }\n}\n";
        assert_eq!(code(source), 5);
        assert_eq!(
            code(
                "impl A {\n    #[cfg(test)]\n    fn t() {\n        1\n    }\n\n    fn f() {}\n}\n"
            ),
            3
        );
    }
}
