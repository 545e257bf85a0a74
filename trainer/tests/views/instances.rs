//! Instances in layers: pictures of the prototype's layers, with the motion of the prototype.

use super::common::Folder;
use super::flat::{SCREEN, drawn, in_layers, made};
use serde_json::{Value, json};
use sinew_runtime::Model;
use sinew_runtime::format::Space;
use sinew_trainer::bake::bake;
use sinew_trainer::page::camera::Resolution;
use sinew_trainer::page::picture::Picture;
use sinew_trainer::views::model::parts;
use sinew_trainer::views::set::{View, read_instance};
use sinew_trainer::views::transfer::transfer;
use std::fs;

const LAYERS: [&str; 4] = ["back", "face", "eye", "arm"];
const BACK: [u8; 4] = [200, 0, 200, 255];
const FACE: [u8; 4] = [0, 200, 200, 255];
const EYE: [u8; 4] = [10, 10, 10, 255];

/// Corners of a square.
fn corners([left, top, right, bottom]: [f64; 4]) -> [[f64; 2]; 4] {
    [[left, top], [right, top], [right, bottom], [left, bottom]]
}

fn save(folder: &Folder, name: &str, [left, top, right, bottom]: [usize; 4], colour: [u8; 4]) {
    let [width, height] = SCREEN;
    let pixel = |at: usize| {
        let (x, y) = (at % width, at / width);
        let is_inside = (left..right).contains(&x) && (top..bottom).contains(&y);
        if is_inside { colour } else { [0; 4] }
    };
    let rgba = (0..width * height).flat_map(pixel).collect();
    let picture = Picture { size: Resolution { width, height }, rgba };
    fs::write(folder.path(name), picture.png().unwrap()).unwrap();
}

/// Writes the first key view of an instance. Its back extends far beyond its points, and it has no arm.
fn instance(
    folder: &Folder,
    spoil: impl FnOnce(&mut Value),
) -> Result<Vec<(String, View)>, String> {
    save(folder, "own_back.png", [8, 8, 84, 84], BACK);
    save(folder, "own_face.png", [24, 24, 64, 64], FACE);
    save(folder, "own_eye.png", [54, 36, 78, 52], EYE);
    // The points of the back are nearer to the centre, which stays.
    let sides = [
        [20.0, 20.0, 72.0, 72.0],
        [24.0, 24.0, 64.0, 64.0],
        [54.0, 36.0, 78.0, 52.0],
        [16.0, 52.0, 44.0, 80.0],
    ];
    let mut view = json!({
        "view": "back0",
        "layers": { "back": "own_back.png", "face": "own_face.png", "eye": "own_eye.png" },
        "points": sides.map(corners).as_flattened(),
    });
    spoil(&mut view);
    let file = folder.path("instance.json");
    fs::write(&file, json!({ "views": [view] }).to_string()).unwrap();
    read_instance(&file, &LAYERS).map_err(|error| error.to_string())
}

#[test]
fn an_instance_in_layers_has_its_own_pictures_and_the_prototypes_motion() {
    let folder = Folder::new("instance-layers");
    let (_, prototype) = made(&in_layers(&folder));
    let views = instance(&folder, |_| {}).unwrap();
    let made = transfer(&prototype, "instance", &views, false).unwrap();
    assert!(made.keys[0].pictures[3].is_none(), "it has no arm");
    let file = Model::from_bytes(bake(Space::default(), &parts(&made).unwrap()).unwrap()).unwrap();
    for x in [0.0, 0.5, 1.0] {
        let picture = drawn(&file, &[("x".to_owned(), x)].into());
        // Places at x = 0, the shifts of their layers at x = 1, and their colours.
        for (place, moves, expected) in [
            ([11.0, 11.0], [4.0, 2.0], BACK),
            ([80.0, 80.0], [4.0, 2.0], BACK),
            ([40.0, 30.0], [8.0, 0.0], FACE),
            ([60.0, 44.0], [8.0, 0.0], EYE),
            // The face clips the eye.
            ([70.0, 44.0], [8.0, 0.0], BACK),
            // The place of the missing arm.
            ([20.0, 60.0], [4.0, -12.0], BACK),
        ] {
            let [column, row] = [0, 1].map(|axis| (place[axis] + x * moves[axis]) as usize);
            let at = 4 * (row * SCREEN[0] + column);
            assert_eq!(picture.rgba[at..at + 4], expected, "x = {x}, {place:?}");
        }
    }
}

#[test]
fn layers_that_are_not_the_prototypes_are_refused() {
    let folder = Folder::new("instance-refused");
    let (_, prototype) = made(&in_layers(&folder));
    let small = Picture::filled(4, 4, [90; 3]).png().unwrap();
    fs::write(folder.path("small.png"), small).unwrap();
    let refused = |spoil: fn(&mut Value)| match instance(&folder, spoil) {
        Err(told) => told,
        Ok(views) => transfer(&prototype, "x", &views, false).unwrap_err().to_string(),
    };
    for (spoil, expected) in [
        (
            (|view| view["layers"]["hat"] = json!("own_eye.png")) as fn(&mut Value),
            "layer \"hat\": view \"back0\" of the instance has a picture of it; the prototype's layers are back, face, eye, arm",
        ),
        (
            |view| {
                view["layers"] = json!({});
                view["image"] = json!("own_back.png");
            },
            "view \"back0\" of the instance: expected pictures of 4 layers, found none under \"layers\"; the prototype's are back, face, eye, arm",
        ),
        (
            |view| view["layers"]["arm"] = json!({ "image": "own_eye.png", "opacity": 0.5 }),
            "view \"back0\" of the instance: layer \"arm\" has an opacity or an order, which are the prototype's: leave them out",
        ),
        (|view| view["layers"] = json!({ "arm": { "image": null } }), "there are no pictures"),
        (
            |view| view["layers"]["face"] = json!("small.png"),
            "small.png: expected 96 x 96 pixels, found 4 x 4",
        ),
    ] {
        let found = refused(spoil);
        assert!(found.ends_with(expected), "{found}");
    }
    let mut views = instance(&folder, |_| {}).unwrap();
    views[0].1.layers.pop();
    let told = transfer(&prototype, "x", &views, false).unwrap_err().to_string();
    assert_eq!(told, "view \"back0\" of the instance: expected 4 layers, found 3");
}
