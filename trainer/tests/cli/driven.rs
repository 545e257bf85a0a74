//! `sinew views drive` and `pin`: parameters and weights of key views from points, for lent motion, too.

use super::common::Folder;
use serde_json::{Value, json};
use std::fs;

/// Writes a frame of tracked points.
fn track(folder: &Folder, name: &str, points: &[Value]) {
    let row: Vec<String> = points.iter().map(|at| format!("{},{}", at[0], at[1])).collect();
    fs::write(folder.path(name), row.join(",") + "\n").unwrap();
}

#[test]
fn points_of_a_key_view_have_its_weight_in_a_table() {
    let folder = Folder::new("driven-table");
    folder.sinew("views demo demo").done();
    folder.sinew("views train demo/panel/views.json -o panel.sinew").done();
    let set = folder.json("demo/panel/views.json");
    let views = set["maps"][0]["train"].as_array().unwrap();
    let keys: Vec<&Value> = views.iter().filter(|view| view["image"].is_string()).collect();
    track(&folder, "track.csv", keys[1]["points"].as_array().unwrap());
    let drive = "views drive panel.sinew --track track.csv";
    let found = folder.sinew(&format!("{drive} -o a --csv table.csv --json")).json();
    let name = |view: &&Value| {
        let image = view["image"].as_str().unwrap().split('.').next().unwrap();
        image.to_owned()
    };
    let names: Vec<String> = keys.iter().map(name).collect();
    assert_eq!(found["key_views"], json!(names));
    let mut expected = vec![0.0; names.len()];
    expected[1] = 1.0;
    let weights = &found["frames"][0]["weights"];
    for (found, expected) in weights.as_array().unwrap().iter().zip(&expected) {
        assert!((found.as_f64().unwrap() - expected).abs() < 1e-4, "{weights}");
    }
    let table = String::from_utf8(folder.read("table.csv")).unwrap();
    let lines: Vec<Vec<&str>> = table.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!(lines.len(), 2);
    let columns = ["frame", "bend", "pitch", "yaw", "rms"].map(str::to_owned);
    let views = names.iter().map(|name| format!("view {name}"));
    let columns: Vec<String> = columns.into_iter().chain(views).collect();
    assert_eq!(lines[0], columns);
    let number = |column: &str| {
        let at = columns.iter().position(|name| name == column).unwrap();
        lines[1][at].parse::<f64>().unwrap()
    };
    assert!(number("frame") == 0.0 && number("rms") < 0.01);
    assert!((number("yaw") - keys[1]["yaw"].as_f64().unwrap()).abs() < 0.01);
    assert!((number(&format!("view {}", names[1])) - 1.0).abs() < 1e-4);
    let refused = folder.sinew(&format!("{drive} -o b --csv table.txt")).failed();
    assert_eq!(refused, "table.txt: expected a file that ends in .csv");
    assert!(!folder.path("b").exists(), "nothing is drawn before");
}

#[test]
fn points_of_an_instance_drive_and_drag_its_lent_motion() {
    let folder = Folder::new("driven-lent");
    folder.sinew("views demo demo").done();
    folder.sinew("views train demo/figure/views.json -o figure.sinew").done();
    let set = folder.json("demo/figure/views.json");
    let rest = set["maps"][1]["train"][0]["points"].as_array().unwrap();
    let wider: Vec<_> =
        rest.iter().map(|at| json!([1.2 * at[0].as_f64().unwrap() - 20.0, at[1]])).collect();
    let instance = json!({ "views": [
        { "view": "texture", "image": "texture.png", "mask": "mask.png", "points": wider },
    ] });
    fs::write(folder.path("demo/figure/sister.json"), instance.to_string()).unwrap();
    folder.sinew("views transfer figure.sinew demo/figure/sister.json -o sister.sinew").done();
    let drawn = "views render sister.sinew --map walk --set phase=75 -o set.png --json";
    let drawn = folder.sinew(drawn).json();
    let points = drawn["points"].as_array().unwrap();
    track(&folder, "track.csv", points);
    let found = folder
        .sinew("views drive sister.sinew --map walk --track track.csv -o driven --json")
        .json();
    let phase = found["frames"][0]["values"]["phase"].as_f64().unwrap().rem_euclid(360.0);
    assert!((phase - 75.0).abs() < 0.01, "{phase}");
    assert_eq!(found["frames"][0]["weights"], json!([1.0]));
    // The old place of the point is somewhere else on the prototype.
    let pin = |model: &str, point: usize| {
        let (x, y) = (points[point][0].as_f64().unwrap(), points[point][1].as_f64().unwrap());
        let pin = format!("views pin {model} --map walk --set phase=65 --pin {point}={x},{y}");
        let found = folder.sinew(&format!("{pin} -o pinned.png --json")).json();
        found["values"]["phase"].as_f64().unwrap()
    };
    assert!((pin("sister.sinew", 15) - 75.0).abs() < 2.0);
    assert!((pin("figure.sinew", 15) - 75.0).abs() > 4.0);
}

#[test]
fn the_control_over_pixels_is_labelled_and_writes_no_file() {
    let folder = Folder::new("driven-pixels");
    folder.sinew("views demo demo").done();
    let train = "views train demo/head/views.json --pixels";
    let before = folder.list();
    let text = folder.sinew(train).done().out;
    assert_eq!(folder.list(), before);
    assert!(
        text.starts_with("negative control: ") && text.contains("no file is written"),
        "{text}"
    );
    assert!(text.contains("Fourier"), "{text}");
    let found = folder.sinew(&format!("{train} --json")).json();
    let rows = found["negative_control"]["rows"].as_array().unwrap();
    assert_eq!(rows[0]["name"], "control points and warping");
    assert!(rows.len() > 5 && rows.iter().all(|row| row["psnr"].is_f64()), "{found}");
    let help = folder.sinew("views train --help").done().out;
    assert!(help.contains("Negative control"), "{help}");
    let both = folder.sinew(&format!("{train} -o x.sinew"));
    assert!(both.code == Some(2) && both.err.contains("cannot be used with"), "{}", both.err);
    let neither = folder.sinew("views train demo/head/views.json");
    assert!(neither.code == Some(2) && neither.err.contains("--out"), "{}", neither.err);
    // The widest gaussians cannot be fitted to views all the way round, and are left out.
    assert!(rows.len() < 9, "{found}");
    // A figure with one drawing leaves no view to predict.
    let few = folder.sinew("views train demo/figure/views.json --pixels").failed();
    let told = "demo/figure/views.json: \"jump\": expected 4 key views or more, found 1";
    assert_eq!(few, told);
}
