//! Prints the cost of pictures of views: `cargo bench -p sinew-trainer --bench views`.
//!
//! The set is `../shared/data/character-2d`: in layers, flattened, and in layers with proposed points.
#![allow(missing_docs, reason = "a program")]

use serde_json::{Value, json};
use sinew_runtime::Model;
use sinew_runtime::format::Space;
use sinew_trainer::bake::bake;
use sinew_trainer::views::fit::FitOptions;
use sinew_trainer::views::player::Player;
use sinew_trainer::views::set::{ViewSet, read};
use sinew_trainer::views::{model, train};
use std::error::Error;
use std::path::PathBuf;
use std::time::Instant;

type Outcome<T> = Result<T, Box<dyn Error>>;

fn data(path: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../shared/data").join(path)
}

fn trained(set: &ViewSet) -> Outcome<Model<Vec<u8>>> {
    let trained = train::train(set, FitOptions::default())?;
    let bytes = bake(Space::default(), &model::parts(&trained.model)?)?;
    Ok(Model::from_bytes(bytes)?)
}

/// Reads the character without its points.
fn without_points() -> Outcome<ViewSet> {
    let file = data("character-2d/character.json");
    let mut set: Value = serde_json::from_slice(&std::fs::read(&file)?)?;
    set["points"] = json!("auto");
    let layers = set["layers"].as_array_mut().into_iter().flatten();
    layers.for_each(|layer| layer["points"] = json!("auto"));
    let absolute = |name: &mut Value| {
        let whole = name.as_str().map(|name| json!(file.with_file_name(name)));
        whole.into_iter().for_each(|whole| *name = whole);
    };
    for split in ["train", "test"] {
        for view in set[split].as_array_mut().into_iter().flatten() {
            absolute(&mut view["image"]);
            let pictures = view.get_mut("layers").and_then(Value::as_object_mut);
            pictures.into_iter().flat_map(|all| all.values_mut()).for_each(absolute);
            for known in ["points", "visible"] {
                view.as_object_mut().and_then(|view| view.remove(known));
            }
        }
    }
    let name = format!("sinew-bench-views-{}.json", std::process::id());
    let written = std::env::temp_dir().join(name);
    std::fs::write(&written, set.to_string())?;
    let before = Instant::now();
    let found = read(&written, None);
    std::fs::remove_file(&written)?;
    let found = found?;
    println!("{} points proposed in {:.1} s", found.point_len(), before.elapsed().as_secs_f64());
    Ok(found)
}

fn main() -> Outcome<()> {
    let set = read(&data("character-2d/character.json"), None)?;
    let auto = without_points()?;
    let mut flat = set.clone();
    flat.layers = vec![sinew_trainer::views::set::Layer::whole("all", set.point_len(), Vec::new())];
    flat.maps.iter_mut().flat_map(|map| &mut map.train).for_each(|view| view.layers.clear());
    for (name, set) in
        [("in layers", &set), ("flattened", &flat), ("in layers, points proposed", &auto)]
    {
        let model = trained(set)?;
        let player = Player::new(&model, None)?;
        println!("character-2d, {name}: a picture of each test view");
        for view in &set.maps[0].test {
            let played = player.play(&view.values)?;
            let mut times: Vec<f64> = (0..101)
                .map(|_| {
                    let before = Instant::now();
                    let _ = std::hint::black_box(player.draw(&played));
                    1e3 * before.elapsed().as_secs_f64()
                })
                .collect();
            times.sort_by(f64::total_cmp);
            println!("  {:.2} ms, at least {:.2}", times[50], times[0]);
        }
    }
    Ok(())
}
