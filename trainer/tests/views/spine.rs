//! Spine JSON, read back by the format's public description ("JSON export format", esotericsoftware.com).

use super::common::Folder;
use super::flat::{SCREEN, Sheet, draw, drawn, found, in_layers, made, mean_and_worst, psnr};
use super::puppets::decoded;
use models::shared;
use serde_json::Value;
use sinew_runtime::Model;
use sinew_trainer::views::demo::write;
use sinew_trainer::views::export::{Grid, Spine, spine};
use sinew_trainer::views::set::Values;
use sinew_trainer::views::train::Trained;

/// Tolerance of positions, pixels.
const OFF: f64 = 0.01;
/// Time between frames, seconds.
const FRAME: f64 = 0.04;

/// A skeleton at a time of an animation.
struct Posed {
    names: Vec<String>,
    sheets: Vec<Sheet>,
    /// Indices of the slots, the hindmost first.
    order: Vec<usize>,
}

fn numbers(list: &Value) -> Vec<f64> {
    list.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

fn pairs(list: &Value) -> Vec<[f64; 2]> {
    numbers(list).as_chunks::<2>().0.to_vec()
}

fn time(key: &Value) -> f64 {
    key["time"].as_f64().unwrap_or(0.0)
}

/// Returns the last key at or before a time, the next key, and the position between the two from 0 to 1.
fn around(keys: &Value, at: f64) -> Option<(&Value, &Value, f64)> {
    let keys = keys.as_array()?;
    assert!(keys.windows(2).all(|pair| time(&pair[0]) < time(&pair[1])), "keys are in order");
    let last = keys.iter().rposition(|key| time(key) <= at + 1e-9)?;
    let (from, to) = (&keys[last], keys.get(last + 1).unwrap_or(&keys[last]));
    let is_still = from["curve"] == "stepped" || time(to) <= time(from);
    let way = if is_still { 0.0 } else { (at - time(from)).max(0.0) / (time(to) - time(from)) };
    Some((from, to, way))
}

fn alpha(colour: &Value) -> f64 {
    let colour = colour.as_str().unwrap();
    assert_eq!((colour.len(), &colour[..6]), (8, "ffffff"));
    f64::from(u8::from_str_radix(&colour[6..], 16).unwrap()) / 255.0
}

fn posed(made: &Spine, name: &str, at: f64) -> Posed {
    let root: Value = serde_json::from_slice(&made.json).unwrap();
    assert!(root["skeleton"]["spine"].as_str().unwrap().starts_with("4.2"));
    assert_eq!(root["bones"], serde_json::json!([{ "name": "root" }]));
    let middle = ["width", "height"].map(|side| 0.5 * root["skeleton"][side].as_f64().unwrap());
    let slots = root["slots"].as_array().unwrap();
    let names: Vec<String> =
        slots.iter().map(|slot| slot["name"].as_str().unwrap().to_owned()).collect();
    let animation = &root["animations"][name];
    let mut sheets = Vec::new();
    for (slot, name) in slots.iter().zip(&names) {
        let timelines = &animation["slots"][name];
        let mut attachment = &slot["attachment"];
        if let Some((key, ..)) = around(&timelines["attachment"], at) {
            attachment = &key["name"];
        }
        let mut opacity = slot.get("color").map_or(1.0, alpha);
        if let Some((from, to, way)) = around(&timelines["rgba"], at) {
            let [from, to] = [from, to].map(|key| alpha(&key["color"]));
            opacity = from + way * (to - from);
        }
        let skin = &root["skins"][0];
        assert_eq!(skin["name"], "default");
        let mesh = &skin["attachments"][name][name];
        assert_eq!(mesh["type"], "mesh");
        let uvs = pairs(&mesh["uvs"]);
        let mut places = pairs(&mesh["vertices"]);
        assert_eq!(places.len(), uvs.len(), "no vertex is weighted");
        let deform = &animation["attachments"]["default"][name][name]["deform"];
        if let Some((from, to, way)) = around(deform, at) {
            let by = |key: &Value| {
                let start = key["offset"].as_u64().unwrap_or(0) as usize;
                let own = key.get("vertices").map(numbers).unwrap_or_default();
                let mut out = vec![0.0; 2 * uvs.len()];
                out[start..start + own.len()].copy_from_slice(&own);
                out
            };
            let (from, to) = (by(from), by(to));
            for (k, x) in places.as_flattened_mut().iter_mut().enumerate() {
                *x += from[k] + way * (to[k] - from[k]);
            }
        }
        let bytes = &made.pictures.iter().find(|(own, _)| own == name).unwrap().1;
        let picture = decoded(bytes);
        let size = [picture.size.width, picture.size.height].map(|side| side as f64);
        assert_eq!(["width", "height"].map(|side| mesh[side].as_f64().unwrap()), size);
        let corners: Vec<usize> =
            numbers(&mesh["triangles"]).into_iter().map(|x| x as usize).collect();
        let triangles = corners.as_chunks::<3>().0.to_vec();
        is_border(&triangles, mesh["hull"].as_u64().unwrap() as usize);
        sheets.push(Sheet {
            places: places.iter().map(|[x, y]| [x + middle[0], middle[1] - y]).collect(),
            texels: uvs.iter().map(|[u, v]| [u * size[0], v * size[1]]).collect(),
            triangles,
            picture,
            opacity: if attachment.is_null() { 0.0 } else { opacity },
            masks: Vec::new(),
        });
    }
    let order = around(&animation["drawOrder"], at).map_or_else(
        || (0..names.len()).collect(),
        |(key, ..)| ordered(&names, key.get("offsets")),
    );
    Posed { names, sheets, order }
}

/// Moves slots by offsets of their places. The other slots keep their order.
fn ordered(names: &[String], offsets: Option<&Value>) -> Vec<usize> {
    let mut out = vec![None; names.len()];
    let mut last = None;
    for offset in offsets.and_then(Value::as_array).into_iter().flatten() {
        let slot = names.iter().position(|name| offset["slot"] == **name).unwrap();
        assert!(last < Some(slot), "offsets come in the order of slots");
        last = Some(slot);
        let place = slot as i64 + offset["offset"].as_i64().unwrap();
        assert!(out[place as usize].replace(slot).is_none(), "two slots at one place");
    }
    let moved: Vec<usize> = out.iter().flatten().copied().collect();
    let mut others = (0..names.len()).filter(|slot| !moved.contains(slot));
    out.into_iter().map(|own| own.or_else(|| others.next()).unwrap()).collect()
}

/// Checks that the first vertices form a border: each edge between neighbours is in one triangle.
fn is_border(triangles: &[[usize; 3]], hull: usize) {
    assert!(hull >= 3);
    for at in 0..hull {
        let edge = [at, (at + 1) % hull];
        let own = triangles.iter().filter(|corners| edge.iter().all(|at| corners.contains(at)));
        assert_eq!(own.count(), 1, "{edge:?} of {hull}");
    }
}

fn path(keys: &[&[(&str, f64)]]) -> Vec<Values> {
    let values = |key: &&[(&str, f64)]| {
        key.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect()
    };
    keys.iter().map(values).collect()
}

fn exported(file: &Model<Vec<u8>>, map: Option<&str>, paths: &[(&str, Vec<Values>)]) -> Spine {
    let of = |(name, frames): &(&str, Vec<Values>)| {
        ((*name).to_owned(), Grid::of_frames(file, map, frames).unwrap())
    };
    let animations: Vec<_> = paths.iter().map(of).collect();
    spine(file, map, "pictures", &animations, FRAME).unwrap()
}

/// Compares every mesh at every frame with the model in double precision.
fn is_bent(made: &Spine, name: &str, trained: &Trained, map: usize, frames: &[Values]) {
    let model = &trained.model;
    for (number, values) in frames.iter().enumerate() {
        let pose = posed(made, name, number as f64 * FRAME);
        let shown = model.outputs().evaluate(&model.maps[map], values).unwrap();
        let slots = pose.names.iter().zip(&pose.sheets);
        for (slot, sheet) in slots.filter(|(_, sheet)| sheet.opacity > 0.0) {
            let (.., vertices) = found(model, slot, &sheet.picture, &sheet.texels);
            for (place, vertex) in sheet.places.iter().zip(vertices) {
                let expected = model.mesh.vertices[vertex].at(&shown.points);
                let off = (place[0] - expected[0]).hypot(place[1] - expected[1]);
                assert!(off < OFF, "frame {number}: {place:?}, expected {expected:?}");
            }
        }
    }
}

#[test]
fn layers_are_slots_that_bend_fade_and_change_their_order() {
    let folder = Folder::new("spine-layers");
    let (trained, file) = made(&in_layers(&folder));
    let frames: Vec<Values> =
        (0..5).map(|k| path(&[&[("x", f64::from(k) / 4.0)]])[0].clone()).collect();
    let back: Vec<Values> = frames.iter().rev().take(3).cloned().collect();
    let made = exported(&file, None, &[("go", frames.clone()), ("back", back.clone())]);
    assert_eq!(made.unclipped, ["eye"]);
    assert_eq!(made.pictures.len(), 8);
    is_bent(&made, "go", &trained, 0, &frames);
    is_bent(&made, "back", &trained, 0, &back);
    for (name, frames) in [("go", &frames), ("back", &back)] {
        for (number, values) in frames.iter().enumerate() {
            let mut pose = posed(&made, name, number as f64 * FRAME);
            let x = values["x"];
            // The order of the arm is 0.5 + 2.5 x. The order of the other layers is their index.
            let expected = match 0.5 + 2.5 * x {
                order if order < 1.0 => ["back", "arm", "face", "eye"],
                order if order < 2.0 => ["back", "face", "arm", "eye"],
                _ => ["back", "face", "eye", "arm"],
            };
            let names = pose.order.iter().map(|&at| pose.names[at].as_str());
            let layers: Vec<&str> = names.map(|name| name.split('-').next().unwrap()).collect();
            assert_eq!([0, 2, 4, 6].map(|at| layers[at]), expected, "x = {x}");
            assert_eq!([1, 3, 5, 7].map(|at| layers[at]), expected, "x = {x}");
            // The format has no masks. The test restores them to compare.
            let names = &pose.names;
            let of = |layer: &str| {
                let own = names.iter().enumerate().filter(|(_, name)| name.starts_with(layer));
                own.map(|(at, _)| at).collect::<Vec<_>>()
            };
            let (eyes, faces) = (of("eye"), of("face"));
            let bare = draw(SCREEN, &pose.sheets, &pose.order);
            eyes.iter().for_each(|&at| pose.sheets[at].masks.clone_from(&faces));
            let found = draw(SCREEN, &pose.sheets, &pose.order);
            let model = drawn(&file, values);
            let (bare, psnr) = (psnr(&bare, &model), psnr(&found, &model));
            println!("spine in layers, x = {x}: {psnr:.2} dB, without masks {bare:.2}");
            assert!(psnr > 34.0 && bare < psnr - 1.0, "x = {x}: {psnr} {bare}");
        }
    }
    // Between frames positions and opacities are linear, and the order stays.
    let [from, half, to] = [1.0, 1.5, 2.0].map(|frame| posed(&made, "go", frame * FRAME));
    assert_eq!(half.order, from.order);
    for ((a, b), half) in from.sheets.iter().zip(&to.sheets).zip(&half.sheets) {
        for ((a, b), half) in a.places.iter().zip(&b.places).zip(&half.places) {
            assert!((0..2).all(|axis| (0.5 * (a[axis] + b[axis]) - half[axis]).abs() < 1e-9));
        }
        assert!((0.5 * (a.opacity + b.opacity) - half.opacity).abs() < 1e-9);
    }
}

#[test]
fn a_character_walks_its_path_as_the_model_draws_it() {
    let Some(set) = shared("character-2d/character.json") else { return };
    let (trained, file) = made(&set);
    let frames: Vec<Values> = (0..9)
        .map(|k| path(&[&[("turn", -1.0 + f64::from(k) / 4.0), ("nod", 0.5)]])[0].clone())
        .collect();
    let made = exported(&file, None, &[("turn", frames.clone())]);
    assert_eq!(made.unclipped, [""; 0]);
    is_bent(&made, "turn", &trained, 0, &frames);
    let mut all = Vec::new();
    for (number, values) in frames.iter().enumerate() {
        let pose = posed(&made, "turn", number as f64 * FRAME);
        let found = draw([320, 320], &pose.sheets, &pose.order);
        all.push(psnr(&found, &drawn(&file, values)));
    }
    let [mean, worst] = mean_and_worst(&all);
    println!("spine of the character over the model, 9 frames: {mean:.2} dB, worst {worst:.2}");
    assert!(mean > 36.0 && worst > 33.0, "{all:?}");
}

#[test]
fn a_head_with_depth_turns_in_slots_that_are_switched() {
    let folder = Folder::new("spine-head");
    write(&folder.path("")).unwrap();
    let (trained, file) = made(&folder.path("head/views.json"));
    let frames: Vec<Values> =
        (0..7).map(|k| path(&[&[("yaw", 15.0 * f64::from(k))]])[0].clone()).collect();
    let made = exported(&file, None, &[("turn", frames.clone())]);
    is_bent(&made, "turn", &trained, 0, &frames);
    for (number, values) in frames.iter().enumerate() {
        let pose = posed(&made, "turn", number as f64 * FRAME);
        assert!(pose.sheets.iter().all(|sheet| [0.0, 1.0].contains(&sheet.opacity)));
        // The foremost visible slot belongs to the key view with the highest score. Halfway between frames two views
        // have that score.
        let front = pose.order.iter().rev().find(|&&at| pose.sheets[at].opacity > 0.0).unwrap();
        let shown = trained.model.outputs().evaluate(&trained.model.maps[0], values).unwrap();
        let highest = shown.scores.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let key = trained.model.keys.iter().position(|key| key.name == pose.names[*front]).unwrap();
        assert!(shown.scores[key] > highest - 1e-5, "frame {number}");
    }
}
