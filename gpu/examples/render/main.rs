//! Skins inside the host's own render pass: the stages compute palettes only, and the host's vertex
//! shader skins. Saves a picture from each API.
//!
//! `cargo run --release -p sinew-gpu --example render [-- FOLDER]`

mod scene;
mod target;
mod vulkan;
mod wgpu;

use scene::{HEIGHT, Scene, WIDTH};
use std::error::Error;
use std::path::{Path, PathBuf};

type Result<T> = std::result::Result<T, Box<dyn Error>>;

fn main() -> Result<()> {
    let folder = std::env::args().nth(1).map_or_else(std::env::temp_dir, PathBuf::from);
    std::fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let scene = Scene::new()?;
    let pictures = [wgpu::render(&scene)?, vulkan::render(&scene)?];
    let [one, other] = pictures.each_ref().map(|pixels| pixels.as_chunks::<4>().0);
    let differ = one.iter().zip(other).filter(|(a, b)| a != b).count();
    println!("{differ} of {} pixels differ", one.len());
    for (api, pixels) in ["wgpu", "vulkan"].into_iter().zip(pictures) {
        save(&folder, api, pixels)?;
    }
    Ok(())
}

/// Saves rows of RGBA8, from the top.
fn save(folder: &Path, api: &str, pixels: Vec<u8>) -> Result<()> {
    let path = folder.join(format!("sinew-{api}.png"));
    let mut encoder = png::Encoder::new(std::fs::File::create(&path)?, WIDTH, HEIGHT);
    encoder.set_color(png::ColorType::Rgba);
    encoder.write_header()?.write_image_data(&pixels)?;
    println!("{}", path.display());
    Ok(())
}
