//! Cases of the folder `views`.

use super::with_cases;
use serde_json::{Value, json};
use std::fs;

/// The file's elements 0 and 4 have more corners than four, so that triangles are made of them.
#[test]
fn a_quad_that_is_not_convex_is_the_users_own_element() {
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
    // What it says to do settles that element, and then the next one.
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
