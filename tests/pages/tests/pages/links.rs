//! Links between the pages: files that are there, and headings in them.

use pages::text::{read, repository};

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

/// Returns what a link to a heading calls it.
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
        // What stands in a fence is no link.
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
