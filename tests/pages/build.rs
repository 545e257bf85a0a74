//! Splits the Rust code of pages into files: one per block, named after the heading and the block's
//! index under the heading.

use std::error::Error;
use std::path::Path;

const PAGES: [&str; 3] = ["../../README.md", "../../runtime/ENGINE.md", "../../runtime/WEB.md"];

/// Starts of lines that a test must be able to call: items, and functions of a type.
const ITEMS: [&str; 6] = ["fn ", "struct ", "enum ", "type ", "const ", "    fn "];

fn main() -> Result<(), Box<dyn Error>> {
    println!("cargo::rerun-if-changed=build.rs");
    let out = std::env::var("OUT_DIR")?;
    for page in PAGES {
        println!("cargo::rerun-if-changed={page}");
        take_apart(&std::fs::read_to_string(page)?, Path::new(&out))?;
    }
    Ok(())
}

/// Writes the blocks of a page.
fn take_apart(page: &str, out: &Path) -> Result<(), Box<dyn Error>> {
    for section in page.split("\n## ").skip(1) {
        let heading = section.lines().next().unwrap_or_default();
        let name: String = heading
            .chars()
            .map(|letter| if letter.is_alphanumeric() { letter.to_ascii_lowercase() } else { '_' })
            .collect();
        let blocks = section.split("```rust\n").skip(1).filter_map(|rest| rest.split_once("```"));
        for (number, (block, _)) in blocks.enumerate() {
            let lines = block.lines().map(seen).collect::<Vec<_>>();
            std::fs::write(out.join(format!("{name}_{number}.rs")), lines.join("\n"))?;
        }
    }
    Ok(())
}

/// Makes the item of a line visible to tests.
fn seen(line: &str) -> String {
    let code = line.trim_start();
    if ITEMS.iter().any(|item| line.starts_with(item)) {
        format!("{}pub(crate) {code}", &line[..line.len() - code.len()])
    } else {
        line.to_owned()
    }
}
