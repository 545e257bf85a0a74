//! Cases of the folder `views`.

use super::{run, with_cases};
use serde_json::{Value, json};
use sinew_trainer::views::set::Image;
use std::fs;

#[test]
fn one_hidden_point_opens_no_hole() {
    let files = ["views/views-hidden-hole.json", "views/sq.png"];
    let Some(folder) = with_cases("views-hidden-hole", &files) else { return };
    run(&folder, "views train views-hidden-hole.json -o v.sinew");
    run(&folder, "views render v.sinew --set a=0.51 -o v.png");
    let picture = Image::of_file(folder.path("v.png")).load([64, 64]).unwrap();
    for (at, pixel) in picture.rgba.chunks(4).enumerate() {
        let is_inside = [at % 64, at / 64].iter().all(|place| (4..60).contains(place));
        assert!(!is_inside || pixel[3] == 255, "{}, {}: {pixel:?}", at % 64, at / 64);
    }
    // The model reproduces the picture of the key view.
    let exact = run(&folder, "views eval v.sinew views-hidden-hole.json").out;
    assert!(exact.contains("PSNR, whole pictures   inf dB"), "{exact}");
}

/// Elements 0 and 4 of the file have more than four corners, so they become triangles.
#[test]
fn a_quad_that_is_not_convex_is_named_by_its_place_in_the_file() {
    let Some(folder) = with_cases("views-nonconvex", &["views/views-nonconvex.json"]) else {
        return;
    };
    let mut set = folder.json("views-nonconvex.json");
    let train = "views train views-nonconvex.json -o v.sinew";
    let error = folder.sinew(train).failed();
    let (number, place) = (7, json!([40, 41, 42, 43]));
    assert_eq!(set["elements"][number], place);
    let expected = format!(
        "views-nonconvex.json: element {number}: quad [40, 41, 42, 43] is not convex in main, "
    );
    assert!(error.starts_with(&expected), "{error}");
    // The advice in the error fixes that element, and then the next one.
    let (_, told) = error.rsplit_once(": write ").unwrap();
    let triangles = told.strip_suffix(" in its place").unwrap();
    let triangles: Vec<Value> = serde_json::from_str(&format!("[{triangles}]")).unwrap();
    set["elements"].as_array_mut().unwrap().splice(number..=number, triangles);
    fs::write(folder.path("views-nonconvex.json"), set.to_string()).unwrap();
    let error = folder.sinew(train).failed();
    let expected =
        "element 10: edges of quad [57, 58, 59, 60] cross in main, train view 0: list its";
    assert!(error.contains(expected), "{error}");
    set["elements"][10] = json!([57, 59, 58, 60]);
    fs::write(folder.path("views-nonconvex.json"), set.to_string()).unwrap();
    // The pictures are not among the cases.
    assert!(folder.sinew(train).failed().contains("key0.png"));
}
