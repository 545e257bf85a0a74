//! Invalid sets are refused, with the file, view, point or element.

use super::common::{Folder, examples, view};
use serde_json::{Value, json};
use sinew_trainer::page::picture::Picture;
use sinew_trainer::views::fit::{FitOptions, fit};
use sinew_trainer::views::set::{Image, Parameter, ViewSet, read, read_drawing};
use sinew_trainer::views::train::train;
use std::fs;

/// Returns a valid set of two views with four points.
fn set() -> Value {
    json!({
        "image_size": [8, 8],
        "elements": [[0, 1, 2, 3]],
        "train": [
            { "image": "a.png", "yaw_deg": 0, "smile": 0.0, "points": [[1, 1], [6, 1], [6, 6], [1, 6]] },
            { "yaw_deg": 20, "smile": 1.0, "points": [[2, 1], [5, 1], [5, 6], [2, 6]],
              "visible": [true, true, true, false] },
        ],
    })
}

fn refused(name: &str, spoil: impl Fn(&mut Value)) -> String {
    let folder = Folder::new(name);
    let mut set = set();
    spoil(&mut set);
    fs::write(folder.path("views.json"), set.to_string()).unwrap();
    match read(&folder.path("views.json"), None) {
        Ok(_) => "taken".to_owned(),
        Err(error) => error.to_string(),
    }
}

#[test]
fn faults_are_named_by_view_and_index() {
    for (name, spoil, expected) in [
        ("whole", (|_| {}) as fn(&mut Value), "taken"),
        (
            "few",
            |set| set["train"][1]["points"] = json!([[2, 1], [5, 1], [5, 6]]),
            "main, train view 1: expected 3 marks of visibility, found 4",
        ),
        (
            "counts",
            |set| {
                set["train"][1]["points"] = json!([[2, 1], [5, 1], [5, 6]]);
                set["train"][1]["visible"] = json!([true, true, true]);
            },
            "main, train view 1: expected 4 points, found 3",
        ),
        (
            "missing",
            |set| drop(set["train"][1].as_object_mut().unwrap().remove("smile")),
            "main, train view 1: parameter \"smile\" is missing",
        ),
        (
            "text",
            |set| set["train"][1]["smile"] = json!("much"),
            "main, train view 1: parameter \"smile\" is no number",
        ),
        (
            "unknown",
            |set| set["train"][1]["points"][2] = Value::Null,
            "main, train view 1: point 2 is visible and has no place",
        ),
        ("hidden", |set| set["train"][1]["points"][3] = Value::Null, "taken"),
        (
            "nowhere",
            |set| {
                for view in set["train"].as_array_mut().unwrap() {
                    view["points"][3] = Value::Null;
                    view["visible"] = json!([true, true, true, false]);
                }
            },
            "point 3 has a place in no view of \"main\"",
        ),
        (
            "concave",
            |set| set["train"][0]["points"][2] = json!([2, 2]),
            "element 0: quad [0, 1, 2, 3] is not convex in main, train view 0: write [2, 3, 0], [2, 0, 1] in its place",
        ),
        (
            "flat",
            |set| {
                set["elements"] = json!([[0, 1, 2], [0, 2, 3]]);
                set["train"][0]["points"][3] = json!([3.5, 3.5]);
            },
            "element 1: points [0, 2, 3] have no area in main, train view 0: move one, mark one as not visible, or leave them out",
        ),
        ("element", |set| set["elements"] = json!([[0, 1, 9]]), "element 0: point 9, of 4"),
        ("empty", |set| set["train"] = json!([]), "there are no views under \"train\""),
        (
            "test-alone",
            |set| set["maps"] = json!([{ "map": "walk", "test": set["train"] }]),
            "walk: \"test\" has views, and \"train\" none to learn from",
        ),
        (
            "unsaid",
            |set| set["train"][1]["visible"] = json!([true, true, null, false]),
            "main, train view 1: point 2: \"visible\" is null, expected true or false where there is a place or a picture",
        ),
        (
            "unsaid-key",
            |set| {
                set["train"][0]["points"][3] = Value::Null;
                set["train"][0]["visible"] = json!([true, true, true, null]);
            },
            "main, train view 0: point 3: \"visible\" is null, expected true or false where there is a place or a picture",
        ),
        (
            "maps-of-one-name",
            |set| set["maps"] = json!([{ "train": set["train"] }]),
            "main: \"map\" is the name of two motions: give each its own",
        ),
        (
            "misspelt",
            |set| set["train"][1]["visable"] = json!([true, true, true, true]),
            "main, train view 1: \"visable\" is neither a parameter nor one of image, mask, points, visible, depth, layers",
        ),
        (
            "mask-alone",
            |set| set["train"][1]["mask"] = json!("m.png"),
            "main, train view 1: \"mask\" is the mask of an image, and there is none",
        ),
    ] {
        assert_eq!(refused(name, spoil), expected, "{name}");
    }
    let found = refused("json", |set| set["image_size"] = json!("large"));
    assert_eq!(found, "image_size: expected a list of 2, found \"large\"");
}

/// Splits the set into two layers.
fn in_layers(set: &mut Value) {
    set.as_object_mut().unwrap().remove("elements");
    set["layers"] = json!([
        { "name": "back", "points": [0, 3] },
        { "name": "front", "points": [1, 2], "clip": "back" },
    ]);
    set["train"][0]["layers"] = json!({ "back": "b.png", "front": { "image": "f.png" } });
}

#[test]
fn faults_of_layers_are_named() {
    for (name, spoil, expected) in [
        ("layers", (|_| {}) as fn(&mut Value), "taken"),
        (
            "layer-twice",
            |set| set["layers"][1]["name"] = json!("back"),
            "layer \"front\": main, train view 0 has a picture of it, and the set no such layer",
        ),
        (
            "layer-names",
            |set| {
                set["layers"][1]["name"] = json!("back");
                set["train"][0]["layers"] = json!({ "back": "b.png" });
            },
            "layer \"back\": two layers have this name",
        ),
        (
            "layer-both",
            |set| set["layers"][1]["points"] = json!([1, 2, 3]),
            "layer \"front\": point 3 is in \"back\", too",
        ),
        ("layer-none", |set| set["layers"][1]["points"] = json!([1]), "point 2 is in no layer"),
        (
            "layer-point",
            |set| set["layers"][1]["points"] = json!([1, 2, 4]),
            "layer \"front\": point 4, of 4",
        ),
        (
            "layer-empty",
            |set| {
                set["layers"][0]["points"] = json!([]);
                set["layers"][1]["points"] = json!([0, 1, 2, 3]);
            },
            "layer \"back\": it has no points",
        ),
        (
            "layer-elements",
            |set| set["layers"][0]["elements"] = json!([[0, 1, 3]]),
            "layer \"back\": an element has point 1, which is not its own",
        ),
        (
            "layer-clip",
            |set| set["layers"][1]["clip"] = json!("side"),
            "layer \"front\": it is clipped by \"side\", no layer",
        ),
        (
            "layer-cycle",
            |set| set["layers"][0]["clip"] = json!("front"),
            "layer \"back\": it is clipped by itself: back by front by back",
        ),
        (
            "layer-picture",
            |set| set["train"][0]["layers"] = json!({ "back": "b.png" }),
            "layer \"front\": main, train view 0 has no picture of it, but shows point 1: name a picture, or mark its points as not visible",
        ),
        (
            "layer-image",
            |set| set["train"][1]["image"] = json!("b.png"),
            "main, train view 1: \"image\" is one picture of all layers: name pictures of them under \"layers\"",
        ),
        (
            "layer-nowhere",
            |set| {
                set["train"][0]["layers"] = json!({ "back": "b.png" });
                set["train"][0]["visible"] = json!([true, false, false, true]);
            },
            "layer \"front\": no view has a picture of it: name one, or leave it out",
        ),
        (
            "layer-opacity",
            |set| set["train"][1]["layers"] = json!({ "front": { "opacity": 1.5 } }),
            "layer \"front\": main, train view 1 gives it the opacity 1.5, expected 0 to 1",
        ),
        (
            "layer-hidden",
            |set| {
                set["train"][1]["layers"] = json!({ "back": "b.png" });
                set["train"][1]["visible"] = json!([true, false, false, true]);
            },
            "taken",
        ),
    ] {
        let found = refused(name, |set| {
            in_layers(set);
            spoil(set);
        });
        assert_eq!(found, expected, "{name}");
    }
}

#[test]
fn unknown_fields_of_layers_are_refused() {
    let fault = |name: &str, spoil: fn(&mut Value)| {
        refused(name, |set| {
            in_layers(set);
            spoil(set);
        })
    };
    let found = fault("layer-field", |set| set["layers"][1]["clips"] = json!("back"));
    assert!(found.starts_with("layers[1]: unknown key \"clips\": expected one of name"), "{found}");
    let words =
        "layers of a view: expected the name of a picture, or \"image\", \"opacity\" and \"order\"";
    for value in [json!({ "file": "f.png" }), json!(3)] {
        let folder = Folder::new("layer-view");
        let mut set = set();
        in_layers(&mut set);
        set["train"][0]["layers"]["front"] = value;
        fs::write(folder.path("views.json"), set.to_string()).unwrap();
        let found = read(&folder.path("views.json"), None).unwrap_err().to_string();
        assert!(found.starts_with(words), "{found}");
    }
}

#[test]
fn layers_are_clipped_by_eight_others_at_most() {
    let chain = |len: usize| {
        refused(&format!("chain-{len}"), |set| {
            let layer = |at: usize| match at {
                0 => json!({ "name": "l0", "points": [0] }),
                _ => {
                    json!({ "name": format!("l{at}"), "points": [at], "clip": format!("l{}", at - 1) })
                }
            };
            let named = |at: usize| (format!("l{at}"), json!("a.png"));
            *set = json!({
                "image_size": [8, 8],
                "layers": (0..=len).map(layer).collect::<Vec<_>>(),
                "train": [{
                    "x": 0,
                    "points": (0..=len).map(|at| [at, 0]).collect::<Vec<_>>(),
                    "layers": (0..=len).map(named).collect::<serde_json::Map<_, _>>(),
                }],
            });
        })
    };
    assert_eq!(chain(8), "taken");
    assert_eq!(chain(9), "layer \"l9\": 9 layers clip it, each the one before: expected at most 8");
}

#[test]
fn a_mesh_without_the_vertices_of_points_and_a_broken_one_are_named() {
    let folder = Folder::new("views-mesh");
    let mut set = set();
    fs::write(folder.path("views.json"), set.to_string()).unwrap();
    fs::write(folder.path("mesh.obj"), "v 0 0\n").unwrap();
    let read = || {
        read(&folder.path("views.json"), Some(&folder.path("mesh.obj"))).unwrap_err().to_string()
    };
    assert_eq!(
        read(),
        "there are no vertices under \"mesh_vertex_index\": list that of each point"
    );
    set["mesh_vertex_index"] = json!([0, 0, 0, 0]);
    fs::write(folder.path("views.json"), set.to_string()).unwrap();
    assert!(read().contains("mesh.obj: "), "{}", read());
}

#[test]
fn pictures_that_are_missing_broken_or_of_another_size_are_named() {
    let folder = Folder::new("pictures");
    let image = |name: &str| Image::of_file(folder.path(name));
    let missing = image("no.png").load([8, 8]).unwrap_err().to_string();
    assert!(missing.contains("no.png"), "{missing}");
    fs::write(folder.path("text.png"), "no picture").unwrap();
    assert!(image("text.png").load([8, 8]).unwrap_err().to_string().contains("text.png"));
    let picture = sinew_trainer::page::picture::Picture::filled(4, 2, [9; 3]);
    fs::write(folder.path("small.png"), picture.png().unwrap()).unwrap();
    assert_eq!(image("small.png").load([4, 2]).unwrap(), picture);
    let wrong = image("small.png").load([8, 8]).unwrap_err().to_string();
    assert!(wrong.ends_with("small.png: expected 8 x 8 pixels, found 4 x 2"), "{wrong}");
}

#[test]
fn contradictory_views_are_named() {
    let at = |x: f64, y: f64| view(&[("x", x)], vec![[y, 0.0], [0.0, y]]);
    let set = examples(
        vec![Parameter::Scalar("x".to_owned())],
        vec![at(0.0, 1.0), at(1.0, 2.0), at(1.0, 3.0)],
    );
    let refused = fit(&set, &[], FitOptions::default()).unwrap_err().to_string();
    assert_eq!(refused, "train views 1 and 2 have the same parameters");
}

#[test]
fn points_on_the_edge_of_a_picture_replace_places_of_its_frame() {
    let folder = Folder::new("frame");
    fs::write(folder.path("a.png"), Picture::filled(8, 8, [9; 3]).png().unwrap()).unwrap();
    let set = json!({
        "image_size": [8, 8],
        "train": [
            { "image": "a.png", "x": 0, "points": [[0, 0], [4, 8], [8, 8], [3, 3]] },
            { "x": 1, "points": [[1, 0], [4, 7], [8, 8], [3, 4]] },
        ],
    });
    fs::write(folder.path("views.json"), set.to_string()).unwrap();
    let set = read(&folder.path("views.json"), None).unwrap();
    let vertices =
        |set: &ViewSet| train(set, FitOptions::default()).unwrap().model.mesh.vertices.len();
    // Points replace three of the frame's eight places.
    assert_eq!(vertices(&set), 4 + 5);
    let mut hidden = set;
    hidden.maps[0].train[0].visible[0] = false;
    assert_eq!(vertices(&hidden), 3 + 6, "a hidden point takes no corner");
}

#[test]
fn a_single_view_stays_where_it_is() {
    let one = view(&[("x", 3.0)], vec![[1.5, 0.0], [0.0, 7.25]]);
    let set = examples(vec![Parameter::Scalar("x".to_owned())], vec![one.clone()]);
    let map = fit(&set, &[Some(0)], FitOptions::default()).unwrap();
    let shown = map.shown(&[("x".to_owned(), -5.0)].into()).unwrap();
    assert_eq!((shown.view(), shown.points), (Some(0), one.known()));
    assert_eq!(shown.visible, [true; 2]);
}

#[test]
fn a_hidden_point_follows_the_views_that_show_it() {
    let at = |x: f64| view(&[("x", x)], vec![[x, 2.0 * x], [3.0 - x, x]]);
    let mut set =
        examples(vec![Parameter::Scalar("x".to_owned())], vec![at(0.0), at(1.0), at(2.0), at(4.0)]);
    set.train[2].points[1] = None;
    set.train[2].visible[1] = false;
    let map = fit(&set, &[], FitOptions::default()).unwrap();
    let shown = map.shown(&[("x".to_owned(), 2.0)].into()).unwrap();
    assert!((shown.points[1][0] - 1.0).abs() < 1e-9 && (shown.points[1][1] - 2.0).abs() < 1e-9);
    assert_eq!(shown.visible, [true, false]);
}

#[test]
fn a_drawing_without_a_joint_is_refused() {
    let folder = Folder::new("descriptions");
    fs::write(folder.path("char_cfg.yaml"), "skeleton:\n- loc:\n  - 1\n  - 2\n  name: root\n")
        .unwrap();
    let refused = read_drawing(&folder.path("char_cfg.yaml")).unwrap_err().to_string();
    assert_eq!(refused, "skeleton: parameter \"hip\" is missing");
}
