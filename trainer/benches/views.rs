//! Prints how near pictures of views come to true ones, and what they cost: `cargo bench -p sinew-trainer --bench views`.
//!
//! `../shared/data/character-2d` (three true pictures; in layers, flattened, and in layers whose points are proposed) and
//! `ict-views` (each view left out). PSNR is of premultiplied RGBA.
#![allow(missing_docs, reason = "a program")]

use serde_json::{Value, json};
use sinew_runtime::Model;
use sinew_runtime::format::Space;
use sinew_trainer::bake::bake;
use sinew_trainer::page::picture::Picture;
use sinew_trainer::views::fit::FitOptions;
use sinew_trainer::views::player::{Player, multiplied};
use sinew_trainer::views::psnr::PictureError;
use sinew_trainer::views::set::{Values, ViewSet, read};
use sinew_trainer::views::{bake as views_bake, train};
use std::error::Error;
use std::path::PathBuf;
use std::time::Instant;

type Outcome<T> = Result<T, Box<dyn Error>>;

fn data(path: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../shared/data").join(path)
}

fn trained(set: &ViewSet) -> Outcome<Model<Vec<u8>>> {
    let trained = train::train(set, FitOptions::default())?;
    let bytes = bake(Space::default(), &views_bake::parts(&trained.model)?)?;
    Ok(Model::from_bytes(bytes)?)
}

fn drawn(model: &Model<Vec<u8>>, map: &str, values: &Values) -> Outcome<Picture> {
    let player = Player::new(model, Some(map))?;
    Ok(player.draw(&player.play(values)?)?.0)
}

/// Returns the PSNR of a picture where a mask is set, in dB.
fn psnr(found: &Picture, truth: &Picture, counts: impl Fn(usize) -> bool) -> f64 {
    let mut error = PictureError::default();
    let pixels = found.rgba.chunks(4).zip(truth.rgba.chunks(4)).enumerate();
    pixels.filter(|(at, _)| counts(*at)).for_each(|(_, (found, truth))| error.add(truth, found));
    error.psnr().unwrap_or(f64::INFINITY)
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

fn character() -> Outcome<()> {
    let set = read(&data("character-2d/character.json"), None)?;
    let auto = without_points()?;
    let mut flat = set.clone();
    flat.layers = vec![sinew_trainer::views::set::Layer::whole("all", set.point_len(), Vec::new())];
    flat.maps.iter_mut().flat_map(|map| &mut map.train).for_each(|view| view.layers.clear());
    for (name, set) in
        [("in layers", &set), ("flattened", &flat), ("in layers, points proposed", &auto)]
    {
        let model = trained(set)?;
        let mut all = Vec::new();
        for map in &set.maps {
            for view in &map.test {
                let Some(image) = &view.image else { continue };
                let truth = multiplied(&image.load(set.size)?);
                all.push(psnr(&drawn(&model, &map.name, &view.values)?, &truth, |_| true));
            }
        }
        println!("character-2d, {name}: {all:.2?} dB");
        let player = Player::new(&model, None)?;
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
            println!("  a picture {:.2} ms, at least {:.2}", times[50], times[0]);
        }
        let steps = |path: &dyn Fn(f64) -> [f64; 2], len: usize| -> Outcome<[f64; 2]> {
            let at = |step: usize| {
                let [turn, nod] = path(step as f64 / (len - 1) as f64);
                let values: Values = [("turn".to_owned(), turn), ("nod".to_owned(), nod)].into();
                drawn(&model, &set.maps[0].name, &values)
            };
            let all = (0..len).map(at).collect::<Outcome<Vec<_>>>()?;
            let mut apart: Vec<f64> = all
                .windows(2)
                .map(|pair| 10f64.powf(-psnr(&pair[0], &pair[1], |_| true) / 20.0))
                .collect();
            apart.sort_by(f64::total_cmp);
            Ok([apart[apart.len() / 2], apart[apart.len() - 1]])
        };
        for (path, [median, most]) in [
            ("turn", steps(&|t| [2.0 * t - 1.0, 0.0], 41)?),
            (
                "circle",
                steps(
                    &|t| {
                        let a = t * std::f64::consts::TAU;
                        [0.7 * a.cos(), 0.7 * a.sin()]
                    },
                    61,
                )?,
            ),
        ] {
            println!("  {path}: most over median {:.2}", most / median);
        }
    }
    Ok(())
}

/// Lists the pixels within the hull of a view's visible points.
fn hull(points: &[[f64; 2]], [width, height]: [usize; 2]) -> Vec<bool> {
    let cross = |o: [f64; 2], a: [f64; 2], b: [f64; 2]| {
        (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0])
    };
    let mut sorted = points.to_vec();
    sorted.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    let half = |points: &mut dyn Iterator<Item = [f64; 2]>| {
        let mut out: Vec<[f64; 2]> = Vec::new();
        for point in points {
            while out.len() > 1 && cross(out[out.len() - 2], out[out.len() - 1], point) <= 0.0 {
                out.pop();
            }
            out.push(point);
        }
        out.pop();
        out
    };
    let lower = half(&mut sorted.iter().copied());
    let upper = half(&mut sorted.iter().rev().copied());
    let ring = [lower, upper].concat();
    (0..width * height)
        .map(|at| {
            let p = [(at % width) as f64 + 0.5, (at / width) as f64 + 0.5];
            (0..ring.len()).all(|i| cross(ring[i], ring[(i + 1) % ring.len()], p) >= 0.0)
        })
        .collect()
}

fn heads() -> Outcome<()> {
    let set = read(&data("ict-views/views.json"), None)?;
    let (mut all, mut holes) = (Vec::new(), 0);
    for number in 0..set.maps[0].train.len() {
        let mut rest = set.clone();
        let view = rest.maps[0].train.remove(number);
        let model = trained(&rest)?;
        let found = drawn(&model, &set.maps[0].name, &view.values)?;
        let Some(image) = &view.image else { continue };
        let truth = multiplied(&image.load(set.size)?);
        let seen = view.known().into_iter().zip(&view.visible).filter(|(_, seen)| **seen);
        let within = hull(&seen.map(|(point, _)| point).collect::<Vec<_>>(), set.size);
        all.push(psnr(&found, &truth, |at| within[at]));
        let is_hole = |at: &usize| {
            within[*at] && truth.rgba[4 * at + 3] > 127 && found.rgba[4 * at + 3] < 128
        };
        holes += (0..within.len()).filter(is_hole).count();
    }
    let mean = all.iter().sum::<f64>() / all.len() as f64;
    let least = all.iter().copied().fold(f64::INFINITY, f64::min);
    println!(
        "ict-views, each left out: mean {mean:.2} dB, least {least:.2}, {holes} pixels without"
    );
    println!("  {all:.1?}");
    Ok(())
}

fn main() -> Outcome<()> {
    character()?;
    heads()
}
