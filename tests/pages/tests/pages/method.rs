//! "METHOD §" of code, shaders and pages: places that are in `trainer/METHOD.md`.

use pages::text::{read, repository};
use std::path::Path;

/// What holds such references.
const FOLDERS: [&str; 5] = ["gpu", "runtime", "shaders", "tests", "trainer"];
const ENDINGS: [&str; 9] = ["rs", "md", "wgsl", "comp", "vert", "frag", "glsl", "h", "hpp"];

/// Lists the files below a folder, but for what is built.
fn files(folder: &Path, out: &mut Vec<std::path::PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap().flatten() {
        let path = entry.path();
        if path.is_dir() {
            if entry.file_name() != "target" {
                files(&path, out);
            }
        } else if path.extension().is_some_and(|end| ENDINGS.iter().any(|own| end == *own)) {
            out.push(path);
        }
    }
}

/// Reads the numbers of sections that a text refers to: those right after "METHOD §", and after commas and "and".
fn referred(text: &str) -> Vec<String> {
    let mut found = Vec::new();
    for rest in text.split("METHOD §").skip(1) {
        let mut rest = rest;
        loop {
            let end = rest.find(|letter: char| !letter.is_ascii_digit() && letter != '.');
            let number = rest.split_at(end.unwrap_or(rest.len())).0.trim_end_matches('.');
            if number.is_empty() {
                break;
            }
            found.push(number.to_owned());
            rest = &rest[number.len()..];
            let Some(next) = [", §", " and §"].iter().find_map(|joint| rest.strip_prefix(joint))
            else {
                break;
            };
            rest = next;
        }
    }
    found
}

#[test]
fn every_place_of_method_is_there() {
    assert_eq!(referred("by METHOD §1.9, §2 and §9. As METHOD §3"), ["1.9", "2", "9", "3"]);
    let method = read("trainer/METHOD.md");
    let headings = method.lines().filter(|line| line.starts_with('#'));
    let numbers: Vec<&str> = headings
        .filter_map(|line| line.trim_start_matches('#').split_whitespace().next())
        .map(|number| number.trim_end_matches('.'))
        .collect();
    let mut all = Vec::new();
    FOLDERS.iter().for_each(|folder| files(&repository().join(folder), &mut all));
    let mut len = 0;
    for path in all.iter().filter(|path| !path.ends_with("pages/method.rs")) {
        for number in referred(&std::fs::read_to_string(path).unwrap()) {
            assert!(
                numbers.contains(&number.as_str()),
                "{}: METHOD has no §{number}",
                path.display()
            );
            len += 1;
        }
    }
    assert!(len > 150, "{len} references");
}
