//! Makes the SPIR-V of every GLSL shader and the file of sums, and prints which files changed.
#![forbid(unsafe_code)]

use anyhow::{Context, Result};
use std::fs;

fn main() -> Result<()> {
    // Writes nothing before every shader compiles.
    let sources = shaders::sources(&shaders::folder())?;
    let compiled: Result<Vec<_>> = sources.iter().map(|(glsl, _)| shaders::compile(glsl)).collect();
    for ((_, path), spirv) in sources.iter().zip(compiled?) {
        let changed = fs::read(path).ok().is_none_or(|old| old != spirv);
        if changed {
            fs::write(path, &spirv).with_context(|| path.display().to_string())?;
        }
        let name = path.file_name().unwrap_or_default().display();
        println!(
            "{name}: {} bytes, {}",
            spirv.len(),
            if changed { "written" } else { "as before" }
        );
    }
    let folder = shaders::folder();
    fs::write(folder.join(shaders::SUMS), shaders::sums(&folder)?)?;
    Ok(())
}
