//! Checks links between the pages, and references "METHOD §" of code, shaders and pages: files,
//! headings and sections exist.

use pages::{read, repository};
use std::path::Path;

const PAGES: [&str; 18] = [
    "README.md",
    "runtime/CHANGELOG.md",
    "runtime/ENGINE.md",
    "runtime/FORMAT.md",
    "runtime/README.md",
    "runtime/WEB.md",
    "runtime/capi/README.md",
    "tests/README.md",
    "tests/firmware/README.md",
    "trainer/COMPARE.md",
    "trainer/FACE.md",
    "trainer/FIGURES.md",
    "trainer/KERNEL.md",
    "trainer/METHOD.md",
    "trainer/NOTES.md",
    "trainer/SIGNAL.md",
    "trainer/TRAIN.md",
    "trainer/VIEWS.md",
];

/// Returns the anchor of a heading.
fn anchor(heading: &str) -> String {
    let text = heading.trim_start_matches('#').trim().to_lowercase();
    let kept = text.chars().filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'));
    kept.map(|c| if c == ' ' { '-' } else { c }).collect()
}

#[test]
fn every_link_leads_somewhere() {
    assert_eq!(anchor("## Who owns what, and why?"), "who-owns-what-and-why");
    let mut len = 0;
    for page in PAGES {
        let text = read(page);
        // Code blocks contain no links.
        let prose: String = text.split("```").step_by(2).collect();
        for link in prose.split("](").skip(1).filter_map(|rest| rest.split_once(')')) {
            let (path, heading) = link.0.split_once('#').unwrap_or((link.0, ""));
            if path.contains("://") {
                continue;
            }
            let folder = repository().join(page).parent().unwrap().to_owned();
            let target = if path.is_empty() { repository().join(page) } else { folder.join(path) };
            assert!(target.exists(), "{page}: {path}");
            if !heading.is_empty() && target.extension().is_some_and(|end| end == "md") {
                let linked = std::fs::read_to_string(&target).unwrap();
                let found = linked
                    .lines()
                    .filter(|line| line.starts_with('#'))
                    .any(|line| anchor(line) == heading);
                assert!(found, "{page}: {path} has no #{heading}");
            }
            len += 1;
        }
    }
    assert!(len > 60, "{len} links");
}

/// Folders and file types that may contain references.
const FOLDERS: [&str; 5] = ["gpu", "runtime", "shaders", "tests", "trainer"];
const ENDINGS: [&str; 9] = ["rs", "md", "wgsl", "comp", "vert", "frag", "glsl", "h", "hpp"];

/// Lists the files below a folder, except build outputs.
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

/// Reads the section numbers in a text: those right after "METHOD §", and after commas and "and".
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
fn every_referenced_section_of_method_exists() {
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
    for path in all.iter().filter(|path| !path.ends_with("pages/links.rs")) {
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
