//! Takes the Rust of `runtime/ENGINE.md` apart: each block a file, by its heading and its number below that.

use std::error::Error;
use std::path::Path;

const PAGE: &str = "../../runtime/ENGINE.md";

/// How lines begin that a test has to see: items, and functions of a type.
const ITEMS: [&str; 6] = ["fn ", "struct ", "enum ", "type ", "const ", "    fn "];

fn main() -> Result<(), Box<dyn Error>> {
    println!("cargo::rerun-if-changed={PAGE}");
    println!("cargo::rerun-if-changed=build.rs");
    let out = std::env::var("OUT_DIR")?;
    let page = std::fs::read_to_string(PAGE)?;
    for section in page.split("\n## ").skip(1) {
        let heading = section.lines().next().unwrap_or_default();
        let name: String = heading
            .chars()
            .map(|letter| if letter.is_alphanumeric() { letter.to_ascii_lowercase() } else { '_' })
            .collect();
        let blocks = section.split("```rust\n").skip(1).filter_map(|rest| rest.split_once("```"));
        for (number, (block, _)) in blocks.enumerate() {
            let lines = block.lines().map(seen).collect::<Vec<_>>();
            std::fs::write(Path::new(&out).join(format!("{name}_{number}.rs")), lines.join("\n"))?;
        }
    }
    Ok(())
}

/// Lets a test see what a line begins.
fn seen(line: &str) -> String {
    let code = line.trim_start();
    if ITEMS.iter().any(|item| line.starts_with(item)) {
        format!("{}pub(crate) {code}", &line[..line.len() - code.len()])
    } else {
        line.to_owned()
    }
}
