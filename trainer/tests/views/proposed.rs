//! Proposed points: positions in the pictures of layers.

use super::common::Folder;
use models::shared;
use serde_json::{Value, json};
use sinew_runtime::Model;
use sinew_trainer::bake::bake;
use sinew_trainer::page::camera::Resolution;
use sinew_trainer::page::picture::Picture;
use sinew_trainer::views::evaluate::evaluate;
use sinew_trainer::views::fit::FitOptions;
use sinew_trainer::views::model::parts;
use sinew_trainer::views::set::{ViewSet, read};
use sinew_trainer::views::train::train;
use std::fs;

/// Width and height of pictures.
const SIDE: usize = 96;

type Place = [f64; 2];
/// A drawing: colour and coverage, from 0 to 1, at a place.
type Drawing<'a> = &'a dyn Fn(Place) -> [f64; 4];

/// Draws a picture. Each pixel averages 4 x 4 places, which `back` maps to the drawing.
fn drawn(drawing: Drawing<'_>, back: &dyn Fn(Place) -> Place) -> Picture {
    let size = Resolution { width: SIDE, height: SIDE };
    let pixel = |at: usize| {
        let mut sum = [0.0; 4];
        for k in 0..16 {
            let off = [k % 4, k / 4].map(|k| (f64::from(k) + 0.5) / 4.0);
            let place = [(at % SIDE) as f64 + off[0], (at / SIDE) as f64 + off[1]];
            let [r, g, b, a] = drawing(back(place));
            for (sum, own) in sum.iter_mut().zip([a * r, a * g, a * b, a]) {
                *sum += own / 16.0;
            }
        }
        let a = sum[3].max(1e-9);
        [sum[0] / a, sum[1] / a, sum[2] / a, sum[3]].map(|x| (255.0 * x).round() as u8)
    };
    Picture { size, rgba: (0..SIDE * SIDE).flat_map(pixel).collect() }
}

/// Reads a set of pictures of one layer with proposed points.
fn proposed(folder: &Folder, pictures: &[Picture]) -> ViewSet {
    let mut views = Vec::new();
    for (number, picture) in pictures.iter().enumerate() {
        let name = format!("{number}.png");
        fs::write(folder.path(&name), picture.png().unwrap()).unwrap();
        views.push(json!({ "image": name, "x": number }));
    }
    let set = json!({ "image_size": [SIDE, SIDE], "points": "auto", "train": views });
    fs::write(folder.path("views.json"), set.to_string()).unwrap();
    read(&folder.path("views.json"), None).unwrap()
}

/// Returns the RMS and the largest distance of points in the second view from the mapped points of the first.
fn off(set: &ViewSet, forth: &dyn Fn(Place) -> Place) -> [f64; 2] {
    let [first, second] = [0, 1].map(|view| &set.maps[0].train[view].points);
    let square = |(own, other): (&Option<Place>, &Option<Place>)| {
        let (own, other) = (forth(own.unwrap()), other.unwrap());
        (own[0] - other[0]).powi(2) + (own[1] - other[1]).powi(2)
    };
    let all: Vec<f64> = first.iter().zip(second).map(square).collect();
    let mean = all.iter().sum::<f64>() / all.len() as f64;
    [mean.sqrt(), all.iter().copied().fold(0.0, f64::max).sqrt()]
}

fn opaque(is_covered: bool, [r, g, b]: [f64; 3]) -> [f64; 4] {
    [r, g, b, f64::from(u8::from(is_covered))]
}

/// An oblong with a pattern.
fn oblong([x, y]: Place) -> [f64; 4] {
    let inside = ((x - 48.0) / 30.0).powi(2) + ((y - 48.0) / 18.0).powi(2) < 1.0;
    opaque(inside, [0.5 + 0.4 * (0.2 * x).sin(), 0.5 + 0.4 * (0.3 * y).cos(), x / 96.0])
}

/// Returns a map that turns and scales about the middle, then shifts.
fn similar(degrees: f64, scale: f64, shift: Place) -> impl Fn(Place) -> Place {
    let (sine, cosine) = degrees.to_radians().sin_cos();
    move |[x, y]| {
        let (x, y) = (x - 48.0, y - 48.0);
        let turned = [cosine * x - sine * y, sine * x + cosine * y];
        [48.0 + scale * turned[0] + shift[0], 48.0 + scale * turned[1] + shift[1]]
    }
}

#[test]
fn points_follow_shapes_that_turn_shrink_and_move() {
    for (name, degrees, scale, shift) in [
        ("proposed-still", 0.0, 1.0, [0.0, 0.0]),
        ("proposed-turned", 40.0, 1.0, [5.0, -8.0]),
        ("proposed-around", 150.0, 0.8, [-6.0, 3.0]),
        ("proposed-shrunk", -20.0, 0.5, [20.0, 15.0]),
    ] {
        let forth = similar(degrees, scale, shift);
        let back = move |[x, y]: Place| {
            let unshifted = [x - shift[0], y - shift[1]];
            let [x, y] = similar(-degrees, 1.0 / scale, [0.0; 2])(unshifted);
            [x, y]
        };
        let pictures = [drawn(&oblong, &|place| place), drawn(&oblong, &back)];
        let set = proposed(&Folder::new(name), &pictures);
        let [rms, most] = off(&set, &forth);
        println!("{name}: {rms:.3} px, at most {most:.3}");
        assert!(rms < 0.6 && most < 1.5, "{name}: {rms} px, at most {most}");
    }
}

#[test]
fn points_follow_shapes_that_bend_without_a_pattern() {
    // Two separate half transparent discs and a line between them, all of one colour.
    let shape = |[x, y]: Place| {
        let disc = |cx: f64, r: f64| (x - cx).hypot(y - 48.0) < r;
        let line = (30.0..60.0).contains(&x) && (y - 48.0).abs() < 1.0;
        let alpha =
            if line { 1.0 } else { 0.5 * f64::from(u8::from(disc(22.0, 12.0) || disc(74.0, 9.0))) };
        [0.3, 0.5, 0.2, alpha]
    };
    let bow = |x: f64| 10.0 * (0.04 * (x - 10.0)).sin();
    let forth = move |[x, y]: Place| [x + 2.0, y + bow(x)];
    let back = move |[x, y]: Place| [x - 2.0, y - bow(x - 2.0)];
    let pictures = [drawn(&shape, &|place| place), drawn(&shape, &back)];
    let set = proposed(&Folder::new("proposed-bent"), &pictures);
    let [rms, most] = off(&set, &forth);
    println!("bent: {rms:.3} px, at most {most:.3}");
    assert!(rms < 1.0 && most < 3.0, "{rms} px, at most {most}");
}

#[test]
fn a_pattern_decides_where_the_outline_alone_would_turn_the_shape() {
    // An oblong of fine stripes, squeezed until it is upright: its outline equals that of a turned oblong.
    let striped = |[x, y]: Place| {
        let [.., alpha] = oblong([x, y]);
        [0.5 + 0.4 * (0.9 * x).sin(), 0.5 + 0.4 * (0.8 * y).sin(), 0.5, alpha]
    };
    let squeezed = |by: f64| move |[x, y]: Place| [48.0 + (x - 48.0) * by, 48.0 + (y - 48.0) / by];
    let pictures = [drawn(&striped, &|place| place), drawn(&striped, &squeezed(1.0 / 0.6))];
    let set = proposed(&Folder::new("proposed-squeezed"), &pictures);
    let [rms, most] = off(&set, &squeezed(0.6));
    println!("squeezed: {rms:.3} px, at most {most:.3}");
    assert!(rms < 1.0 && most < 3.0, "{rms} px, at most {most}");
}

#[test]
fn points_are_set_in_the_view_in_the_middle_of_the_parameters() {
    // Views at 0, 1 and 5: the second is the nearest to both others, and its silhouette is triangulated.
    let pictures = [1.0, 0.8, 0.9]
        .map(|scale| drawn(&oblong, &move |place| similar(0.0, 1.0 / scale, [0.0; 2])(place)));
    let folder = Folder::new("proposed-middle");
    let views = (0..3).zip([0.0, 1.0, 5.0]).map(|(number, x)| {
        let name = format!("{number}.png");
        fs::write(folder.path(&name), pictures[number].png().unwrap()).unwrap();
        json!({ "image": name, "x": x })
    });
    let set = json!({
        "image_size": [SIDE, SIDE], "points": "auto", "train": views.collect::<Vec<_>>(),
    });
    fs::write(folder.path("views.json"), set.to_string()).unwrap();
    let set = read(&folder.path("views.json"), None).unwrap();
    // In the triangulated view the outermost points lie on corners of whole pixels.
    let is_whole = |view: usize| {
        let points = set.maps[0].train[view].points.iter().flatten().flatten();
        points.filter(|x| x.fract() == 0.0).count()
    };
    println!("{:?}", [0, 1, 2].map(is_whole));
    assert!(is_whole(1) > is_whole(0) && is_whole(1) > is_whole(2));
}

#[test]
fn an_iris_that_moves_within_an_eye_does_not_turn_it() {
    let Some(folder) = shared("character-2d") else { return };
    let key = |number: usize| folder.join(format!("key{number}_eye_left.png"));
    let at = [[0, 0], [-1, -1], [1, -1], [-1, 1], [1, 1]];
    let view = |(number, [turn, nod]): (usize, [i32; 2])| json!({ "image": key(number), "turn": turn, "nod": nod });
    let views: Vec<Value> = at.into_iter().enumerate().map(view).collect();
    let set = json!({ "image_size": [320, 320], "points": "auto", "train": views });
    let written = Folder::new("proposed-eye");
    fs::write(written.path("views.json"), set.to_string()).unwrap();
    let set = read(&written.path("views.json"), None).unwrap();
    let points = |view: usize| -> Vec<Place> {
        let points = &set.maps[0].train[view].points;
        points.iter().map(|point| point.unwrap()).collect()
    };
    let arms = |points: &[Place]| -> Vec<Place> {
        let len = points.len() as f64;
        let middle = [0, 1].map(|axis| points.iter().map(|own| own[axis]).sum::<f64>() / len);
        points.iter().map(|own| [own[0] - middle[0], own[1] - middle[1]]).collect()
    };
    let first = arms(&points(0));
    for view in 1..5 {
        // The angle of the rotation that fits best (Procrustes).
        let (mut along, mut across) = (0.0, 0.0);
        for ([a, b], [x, y]) in first.iter().zip(arms(&points(view))) {
            (along, across) = (along + a * x + b * y, across + a * y - b * x);
        }
        let turn = f64::atan2(across, along).to_degrees();
        println!("view {view}: {turn:.1} degrees");
        assert!(turn.abs() < 15.0, "view {view} is turned by {turn} degrees");
    }
}

#[test]
fn layers_that_a_view_does_not_show_have_no_points_there() {
    let empty = |_: Place| [0.0; 4];
    let same = |place: Place| place;
    let moved = |[x, y]: Place| [x - 4.0, y];
    let pictures = [drawn(&oblong, &same), drawn(&empty, &same), drawn(&oblong, &moved)];
    let folder = Folder::new("proposed-empty");
    let set = proposed(&folder, &pictures);
    let view = &set.maps[0].train[1];
    assert!(view.points.iter().all(Option::is_none) && !view.visible.contains(&true));
    assert!(set.maps[0].train[2].points.iter().all(Option::is_some));
    let model = train(&set, FitOptions::default()).unwrap().model;
    assert_eq!(model.mesh.element_len(), set.element_len());
}

#[test]
fn a_layer_that_no_view_shows_is_refused() {
    let folder = Folder::new("proposed-nothing");
    let picture = drawn(&|_| [0.0; 4], &|place| place);
    fs::write(folder.path("0.png"), picture.png().unwrap()).unwrap();
    let set = json!({
        "name": "ghost", "image_size": [SIDE, SIDE], "points": "auto",
        "train": [{ "image": "0.png", "x": 0 }],
    });
    let said = |set: &Value| {
        fs::write(folder.path("views.json"), set.to_string()).unwrap();
        read(&folder.path("views.json"), None).unwrap_err().to_string()
    };
    assert_eq!(
        said(&set),
        "layer \"ghost\": no view has a picture of it: name one, or leave it out"
    );
    let mut with_points = set.clone();
    with_points["layers"] = json!([{ "name": "all", "points": "auto", "elements": [[0, 1, 2]] }]);
    with_points["train"][0] = json!({ "layers": { "all": "0.png" }, "x": 0 });
    assert_eq!(said(&with_points), "layer \"all\": it has elements, but no points yet");
}

#[test]
fn points_are_the_same_for_any_number_of_threads() {
    let back = similar(12.0, 1.1, [3.0, 1.0]);
    let pictures = [
        drawn(&oblong, &|place| place),
        drawn(&oblong, &back),
        drawn(&oblong, &similar(-9.0, 0.9, [0.0; 2])),
    ];
    let points = [1, 4].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let folder = Folder::new(&format!("proposed-threads-{threads}"));
        let set = pool.install(|| proposed(&folder, &pictures));
        set.maps[0].train.iter().map(|view| view.points.clone()).collect::<Vec<_>>()
    });
    assert_eq!(points[0], points[1]);
}

/// The drawn character in layers, without its points.
#[test]
fn a_character_with_proposed_points_has_the_right_pictures() {
    let Some(path) = shared("character-2d/character.json") else { return };
    let folder = Folder::new("proposed-character");
    let mut set: Value = serde_json::from_slice(&fs::read(&path).unwrap()).unwrap();
    set["points"] = json!("auto");
    for layer in set["layers"].as_array_mut().unwrap() {
        layer["points"] = json!("auto");
    }
    for split in ["train", "test"] {
        for view in set[split].as_array_mut().unwrap() {
            let view = view.as_object_mut().unwrap();
            view.remove("points");
            view.remove("visible");
        }
    }
    for file in fs::read_dir(path.parent().unwrap()).unwrap() {
        let file = file.unwrap().path();
        fs::write(
            folder.path(file.file_name().unwrap().to_str().unwrap()),
            fs::read(&file).unwrap(),
        )
        .unwrap();
    }
    fs::write(folder.path("views.json"), set.to_string()).unwrap();
    let set = read(&folder.path("views.json"), None).unwrap();
    let model = train(&set, FitOptions::default()).unwrap().model;
    let bytes = bake(Default::default(), &parts(&model).unwrap()).unwrap();
    let model = Model::from_bytes(bytes).unwrap();
    let found = evaluate(&model, &set).unwrap();
    println!("{} points: {:?} dB", set.point_len(), found.psnr);
    // The test views have no points to compare with the points of the file.
    assert!(found.points.is_none());
    // The issue asks for 24.
    assert!(found.psnr.unwrap() > 33.0, "{:?}", found.psnr);
}
