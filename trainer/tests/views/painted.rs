//! Sets with pictures in layers, as drawing programs write them.

use super::common::Folder;
use serde_json::{Value, json};
use sinew_trainer::Error;
use sinew_trainer::page::picture::Picture;
use sinew_trainer::views::fit::FitOptions;
use sinew_trainer::views::set::{ViewSet, as_json, read, read_instance};
use sinew_trainer::views::train::train;
use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

/// A layer of a picture: name, attributes, and index of its pixels.
type Row<'a> = (&'a str, &'a str, usize);

const ROWS: [Row<'_>; 2] = [("back", "", 0), ("front", "x='4' y='6' opacity='0.5'", 1)];

/// Writes an OpenRaster file of layers, the hindmost first. The pixels are 32 x 24.
fn ora(path: &Path, rows: &[Row<'_>], size: [usize; 2]) {
    let mut zip = ZipWriter::new(File::create(path).unwrap());
    let mut start = |name: &str| zip_file(&mut zip, name, &[]);
    start("mimetype");
    let layer = |(name, more, number): &Row<'_>| {
        format!("<layer name='{name}' src='{number}.png' {more}/>")
    };
    let list: String = rows.iter().rev().map(layer).collect();
    let [width, height] = size;
    let list = format!("<image w='{width}' h='{height}'><stack>{list}</stack></image>");
    zip_file(&mut zip, "stack.xml", list.as_bytes());
    let pictures = [Picture::filled(20, 16, [200, 30, 30]), Picture::filled(8, 8, [20, 40, 220])];
    for (number, picture) in pictures.iter().enumerate() {
        zip_file(&mut zip, &format!("{number}.png"), &picture.png().unwrap());
    }
    zip.finish().unwrap();
}

fn zip_file(zip: &mut ZipWriter<File>, name: &str, bytes: &[u8]) {
    zip.start_file(name, SimpleFileOptions::default()).unwrap();
    zip.write_all(bytes).unwrap();
}

/// Writes a set of two key views. The second is shifted by 3 pixels.
fn set(folder: &Folder, more: Value) -> PathBuf {
    ora(&folder.path("a.ora"), &ROWS, [32, 24]);
    let moved = [("back", "x='3'", 0), ("front", "x='7' y='6' opacity='0.5'", 1)];
    ora(&folder.path("b.ora"), &moved, [32, 24]);
    written(folder, more)
}

fn written(folder: &Folder, more: Value) -> PathBuf {
    let mut set = json!({
        "image_size": [32, 24],
        "train": [{ "image": "a.ora", "x": 0 }, { "image": "b.ora", "x": 1 }],
    });
    set.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
    fs::write(folder.path("views.json"), set.to_string()).unwrap();
    folder.path("views.json")
}

fn refused(found: Result<ViewSet, Error>) -> String {
    let text = found.unwrap_err().to_string();
    // The error without the folder of the test.
    let folder = std::env::temp_dir().display().to_string();
    let words: Vec<String> = text
        .split(' ')
        .map(|word| match word.strip_prefix(&folder) {
            Some(path) => path.rsplit('/').next().unwrap_or_default().to_owned(),
            None => word.to_owned(),
        })
        .collect();
    words.join(" ")
}

#[test]
fn layers_of_the_pictures_are_the_layers_of_a_set_that_names_none() {
    let folder = Folder::new("painted");
    let found = read(&set(&folder, json!({ "points": "auto" })), None).unwrap();
    let names: Vec<&str> = found.layers.iter().map(|layer| layer.name.as_str()).collect();
    assert_eq!(names, ["back", "front"], "the hindmost first");
    let views = &found.maps[0].train;
    assert_eq!(views[0].layers[1].opacity, Some(0.5));
    let front = views[1].picture(1).unwrap().load([32, 24]).unwrap();
    let covered = |x: usize, y: usize| front.rgba[4 * (32 * y + x) + 3];
    assert_eq!([covered(7, 6), covered(14, 13), covered(6, 6), covered(15, 13)], [255, 255, 0, 0]);
    // Both layers shift by 3 pixels.
    for (own, other) in views[0].points.iter().zip(&views[1].points) {
        let [own, other] = [own.unwrap(), other.unwrap()];
        assert!((other[0] - own[0] - 3.0).abs() < 0.1 && (other[1] - own[1]).abs() < 0.1);
    }
    assert!(found.layers.iter().all(|layer| layer.points.len() >= 3));
    assert_eq!(found.point_len(), found.layers.iter().map(|own| own.points.len()).sum::<usize>());
}

#[test]
fn a_set_with_its_points_written_trains_the_same_model() {
    let folder = Folder::new("painted-again");
    let found = read(&set(&folder, json!({ "points": "auto" })), None).unwrap();
    let text = as_json(&found, &folder.path("")).to_string();
    assert!(text.contains("\"image\":\"a.ora\"") && !text.contains("auto"), "{text}");
    fs::write(folder.path("points.json"), text).unwrap();
    let again = read(&folder.path("points.json"), None).unwrap();
    assert_eq!(again.layers.len(), 2);
    for (own, other) in found.maps[0].train.iter().zip(&again.maps[0].train) {
        assert_eq!(own, other);
    }
    let models = [&found, &again].map(|set| {
        let model = train(set, FitOptions::default()).unwrap().model;
        let parts = sinew_trainer::views::model::parts(&model).unwrap();
        sinew_trainer::bake::bake(Default::default(), &parts).unwrap()
    });
    assert_eq!(models[0], models[1]);
}

#[test]
fn layers_are_given_points_beside_layers_whose_points_are_proposed() {
    let folder = Folder::new("painted-both");
    let path = set(
        &folder,
        json!({
            "layers": [{ "name": "back", "points": [0, 1] }, { "name": "front", "points": "auto" }],
            "train": [
                { "image": "a.ora", "x": 0, "points": [[2, 8], [18, 8]] },
                { "image": "b.ora", "x": 1, "points": [[5, 8], [21, 8]] },
            ],
        }),
    );
    let found = read(&path, None).unwrap();
    assert_eq!(found.layers[0].points, [0, 1]);
    assert_eq!(found.layers[1].points[0], 2);
    assert!(found.layers[0].elements.is_empty() && !found.layers[1].elements.is_empty());
    assert!(train(&found, FitOptions::default()).is_ok());
}

#[test]
fn a_layer_is_drawn_only_where_its_files_show_it() {
    let folder = Folder::new("painted-order");
    let path = set(&folder, json!({ "points": "auto" }));
    ora(&folder.path("b.ora"), &[ROWS[1], ROWS[0]], [32, 24]);
    let found = read(&path, None).unwrap();
    let orders = |view: usize| [0, 1].map(|layer| found.maps[0].train[view].layers[layer].order);
    assert_eq!([orders(0), orders(1)], [[None; 2], [Some(1.0), Some(0.0)]]);
    let model = train(&found, FitOptions::default()).unwrap();
    let numbers = |x: f64| {
        let map = &model.model.maps[0];
        let given = map.evaluate(&[x]).unwrap().numbers;
        given[given.len() - 4..].to_vec()
    };
    for (x, expected) in [(0.0, [1.0, 0.5, 0.0, 1.0]), (1.0, [1.0, 0.5, 1.0, 0.0])] {
        let own = numbers(x);
        let off = own.iter().zip(expected).map(|(own, other)| (own - other).abs());
        assert!(off.fold(0.0, f64::max) < 1e-9, "{own:?}");
    }
    let hidden = [ROWS[0], ("front", "x='4' y='6' visibility='hidden'", 1)];
    ora(&folder.path("b.ora"), &hidden, [32, 24]);
    let found = read(&path, None).unwrap();
    assert_eq!(found.maps[0].train[1].layers[1].opacity, Some(0.0));
    ora(&folder.path("a.ora"), &hidden, [32, 24]);
    assert_eq!(read(&path, None).unwrap().layers.len(), 1, "hidden in both");
}

#[test]
fn a_file_for_one_layer_gives_that_layer() {
    let folder = Folder::new("painted-one");
    let path = set(
        &folder,
        json!({
            "layers": [{ "name": "front", "points": [0] }],
            "train": [{ "x": 0, "points": [[8, 10]], "layers": { "front": "a.ora" } }],
        }),
    );
    let found = read(&path, None).unwrap();
    let own = found.maps[0].train[0].picture(0).unwrap().load([32, 24]).unwrap();
    let covered = own.rgba.chunks(4).filter(|pixel| pixel[3] > 0).count();
    assert_eq!(covered, 64);
}

#[test]
fn an_instance_may_be_a_picture_in_layers() {
    let folder = Folder::new("painted-instance");
    set(&folder, json!({}));
    let view = json!({ "view": "a", "image": "b.ora", "points": [[5, 8]] });
    fs::write(folder.path("own.json"), json!({ "views": [view] }).to_string()).unwrap();
    let found = read_instance(&folder.path("own.json"), &["back", "front"]).unwrap();
    let (name, own) = &found[0];
    assert_eq!(name, "a");
    for (layer, covered) in [(0, 20 * 16), (1, 64)] {
        let picture = own.picture(layer).unwrap().load([32, 24]).unwrap();
        assert_eq!(picture.rgba.chunks(4).filter(|pixel| pixel[3] > 0).count(), covered);
        assert_eq!(own.layers[layer].opacity, None, "it is the prototype's");
    }
    let refused = read_instance(&folder.path("own.json"), &["back", "nose"]).unwrap_err();
    assert!(refused.to_string().contains("has no layer \"nose\""));
}

#[test]
fn views_without_pictures_leave_proposed_points_unknown() {
    let folder = Folder::new("painted-between");
    let train_views = json!([
        { "image": "a.ora", "x": 0 },
        { "x": 0.5, "layers": { "front": { "opacity": 0.8 } } },
        { "image": "b.ora", "x": 1 },
    ]);
    let path = set(&folder, json!({ "points": "auto", "train": train_views }));
    let found = read(&path, None).unwrap();
    let views = &found.maps[0].train;
    assert!(
        views[1].seen().all(|seen| seen.is_none())
            && views[0].seen().all(|seen| seen == Some(true))
    );
    let numbers = |set: &ViewSet, x: f64| {
        let map = &train(set, FitOptions::default()).unwrap().model.maps[0];
        map.evaluate(&[x]).unwrap().numbers
    };
    let seen = numbers(&found, 0.5);
    let len = found.point_len();
    // The layer is visible with its own opacity. The 0.5 of the other layer has no effect.
    assert!(seen[3 * len..4 * len].iter().all(|seen| (seen - 1.0).abs() < 1e-9), "{seen:?}");
    let front = seen[seen.len() - 3];
    assert!((front - 0.8).abs() < 1e-9, "{front}");
    // A view without pictures does not make a layer opaque.
    let mut silent = found.clone();
    silent.maps[0].train[1].layers[1].opacity = None;
    let faded = numbers(&silent, 0.5);
    assert!((faded[faded.len() - 3] - 0.5).abs() < 1e-9, "{faded:?}");
    let text = as_json(&found, &folder.path("")).to_string();
    fs::write(folder.path("points.json"), text).unwrap();
    let again = read(&folder.path("points.json"), None).unwrap();
    assert_eq!(again.maps[0].train, found.maps[0].train);
}

#[test]
fn key_views_whose_pictures_have_one_name_are_named_by_their_motion() {
    let folder = Folder::new("painted-names");
    let mut all = Vec::new();
    for (number, name) in ["left", "right"].into_iter().enumerate() {
        fs::create_dir(folder.path(name)).unwrap();
        let picture = Picture::filled(8, 8, [90; 3]).png().unwrap();
        fs::write(folder.path(name).join("back.png"), picture).unwrap();
        let file = format!("{name}/back.png");
        all.push(json!({ "x": number, "points": [[1, 1]], "layers": { "back": file } }));
    }
    let more = json!({
        "image_size": [8, 8], "layers": [{ "name": "back", "points": [0] }], "train": all,
    });
    let found = read(&written(&folder, more), None).unwrap();
    let model = train(&found, FitOptions::default()).unwrap().model;
    let names: Vec<&str> = model.keys.iter().map(|key| key.name.as_str()).collect();
    assert_eq!(names, ["main 0", "main 1"]);
}

#[test]
fn layers_that_a_picture_clips_are_clipped() {
    let folder = Folder::new("painted-clip");
    let path = set(&folder, json!({ "points": "auto" }));
    let rows = [ROWS[0], ("front", "composite-op='svg:src-atop'", 1)];
    for name in ["a.ora", "b.ora"] {
        ora(&folder.path(name), &rows, [32, 24]);
    }
    let found = read(&path, None).unwrap();
    let clips: Vec<_> = found.layers.iter().map(|layer| layer.clip).collect();
    assert_eq!(clips, [None, Some(0)]);
    let only = written(&folder, json!({ "layers": [{ "name": "front", "points": "auto" }] }));
    assert_eq!(
        refused(read(&only, None)),
        "layer \"front\": a.ora clips it to \"back\", no layer of the set"
    );
}

#[test]
fn pictures_that_contradict_a_set_are_refused() {
    let folder = Folder::new("painted-faults");
    let auto = || json!({ "points": "auto" });
    let path = set(&folder, json!({}));
    assert_eq!(
        refused(read(&path, None)),
        "a.ora has layers: write \"points\": \"auto\", or name the layers with their points under \"layers\""
    );
    let named = json!({ "layers": [{ "name": "nose", "points": "auto" }] });
    assert_eq!(
        refused(read(&written(&folder, named), None)),
        "a.ora: has no layer \"nose\": its layers are \"back\", \"front\""
    );
    let path = written(&folder, auto());
    ora(&folder.path("b.ora"), &ROWS[..1], [32, 24]);
    assert_eq!(
        refused(read(&path, None)),
        "layer \"front\": it is in a.ora, and not in b.ora: add it there, empty if it is not seen"
    );
    let clipped = [ROWS[0], ("front", "composite-op='svg:src-atop'", 1)];
    ora(&folder.path("b.ora"), &clipped, [32, 24]);
    assert_eq!(
        refused(read(&path, None)),
        "layer \"front\": a.ora does not clip it, b.ora clips it to \"back\": clip it alike, or write its \"clip\""
    );
    ora(&folder.path("b.ora"), &ROWS, [32, 24]);
    let back = written(&folder, json!({ "layers": [{ "name": "back", "points": "auto" }] }));
    assert_eq!(
        refused(read(&back, None)),
        "layer \"front\": a.ora shows it, and the set has no such layer: name it, or hide it there"
    );
    let path = written(&folder, auto());
    ora(&folder.path("b.ora"), &ROWS, [33, 24]);
    assert_eq!(refused(read(&path, None)), "b.ora: expected 32 x 24 pixels, found 33 x 24");
    fs::write(folder.path("b.ora"), "nothing").unwrap();
    assert!(refused(read(&path, None)).starts_with("b.ora: expected an OpenRaster file"));
    let masked = json!([{ "image": "a.ora", "mask": "m.png", "x": 0 }]);
    assert_eq!(
        refused(read(&written(&folder, json!({ "points": "auto", "train": masked })), None)),
        "main, train view 0: \"mask\" is the mask of a picture in layers: leave it out"
    );
    let wrong = written(&folder, json!({ "points": "automatic" }));
    let text = read(&wrong, None).unwrap_err().to_string();
    assert_eq!(
        text,
        "\"points\" beside \"image_size\": expected \"auto\" or a list of names, found \"automatic\""
    );
    let wrong = written(&folder, json!({ "layers": [{ "name": "back", "points": "all" }] }));
    let text = read(&wrong, None).unwrap_err().to_string();
    assert!(text.starts_with("layers[0].points: expected \"auto\" or a list of numbers"), "{text}");
    let view = json!({ "image": "a.ora", "x": 0, "points": [[2, 8]], "depth": [1.0] });
    let deep = json!({
        "points": "auto",
        "layers": [{ "name": "back", "points": [0] }, { "name": "front" }],
        "train": [view],
    });
    assert_eq!(
        refused(read(&written(&folder, deep), None)),
        "proposed points have no depth: leave \"depth\" and the mesh out"
    );
}
