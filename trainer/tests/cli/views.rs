//! `sinew views`: from pictures to all between them.

use super::common::Folder;
use serde_json::json;
use std::fs;

/// A folder with the demo's sets and a model of one of them.
fn trained(test: &str, set: &str) -> Folder {
    let folder = Folder::new(test);
    folder.sinew("views demo demo").done();
    let found =
        folder.sinew(&format!("views train demo/{set}/views.json -o {set}.sinew --json")).json();
    assert_eq!(found["bytes"], fs::read(folder.path(&format!("{set}.sinew"))).unwrap().len());
    folder
}

/// Reads how large a PNG is, and how many of its pixels something covers.
fn picture(folder: &Folder, name: &str) -> ([u32; 2], usize) {
    let bytes = std::io::Cursor::new(folder.read(name));
    let mut reader = png::Decoder::new(bytes).read_info().unwrap();
    let mut rgba = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut rgba).unwrap();
    let covered = rgba.chunks(4).filter(|pixel| pixel[3] > 0).count();
    ([info.width, info.height], covered)
}

#[test]
fn a_head_is_trained_measured_drawn_and_reported() {
    let folder = trained("views-head", "head");
    let found = folder.sinew("views eval head.sinew demo/head/views.json --json").json();
    assert_eq!((found["views"].as_u64(), found["flipped"].as_u64()), (Some(12), Some(0)));
    assert!(found["rms"].as_f64().unwrap() < 0.05, "{found}");
    let drawn = folder.sinew("views render head.sinew --set yaw=137 -o head.png --json").json();
    assert_eq!(drawn["flipped"], 0);
    assert_eq!(drawn["points"].as_array().unwrap().len(), 128);
    let (size, covered) = picture(&folder, "head.png");
    assert_eq!(size, [160, 192]);
    assert!(covered > 8000, "{covered}");
    let round = ["1", "361"].map(|yaw| {
        let name = format!("yaw{yaw}.png");
        folder.sinew(&format!("views render head.sinew --set yaw={yaw} -o {name}")).done();
        folder.read(&name)
    });
    assert_eq!(round[0], round[1], "once round is none");
    folder.sinew("views report head.sinew demo/head/views.json -o head.html").done();
    let page = String::from_utf8(folder.read("head.html")).unwrap();
    assert!(page.contains("A network over pixels") && page.matches("<img").count() > 7);
    let about = &folder.sinew("inspect head.sinew --json").json()["views"][0];
    assert_eq!((about["points"].as_u64(), about["maps"].as_u64()), (Some(128), Some(1)));
}

#[test]
fn a_figure_walks_is_driven_lends_its_motion_and_is_dragged() {
    let folder = trained("views-figure", "figure");
    fs::write(
        folder.path("path.json"),
        json!({ "keys": [{ "phase": 0 }, { "phase": 90 }], "frames": 3 }).to_string(),
    )
    .unwrap();
    folder.sinew("views animate figure.sinew --map walk --path path.json -o walk").done();
    assert_eq!(folder.list().iter().filter(|name| *name == "walk").count(), 1);
    assert!(
        folder.path("walk/frame0003.png").exists() && !folder.path("walk/frame0004.png").exists()
    );
    let again = folder.sinew("views animate figure.sinew --map walk --path path.json -o walk");
    assert_eq!(again.failed(), "walk: it holds frames already");

    let set = folder.json("demo/figure/views.json");
    let view = &set["maps"][0]["train"][2];
    let points = view["points"].as_array().unwrap();
    let row: Vec<String> =
        points.iter().flat_map(|point| [point[0].to_string(), point[1].to_string()]).collect();
    fs::write(folder.path("track.csv"), row.join(",") + "\n").unwrap();
    let driven = folder
        .sinew("views drive figure.sinew --map walk --track track.csv -o driven --json")
        .json();
    let phase = driven["frames"][0]["values"]["phase"].as_f64().unwrap().rem_euclid(360.0);
    assert!((phase - view["phase"].as_f64().unwrap()).abs() < 0.01, "{phase}");
    assert_eq!(driven["bytes"], 4);
    folder.sinew("views render figure.sinew --map walk --set phase=90 -o set.png").done();
    assert!(folder.path("driven/frame0000.png").exists());

    let rest = &set["maps"][1]["train"][0];
    let wider: Vec<_> = rest["points"]
        .as_array()
        .unwrap()
        .iter()
        .map(|point| json!([1.2 * point[0].as_f64().unwrap() - 20.0, point[1]]))
        .collect();
    let instance = json!({ "views": [{ "view": "texture", "image": "texture.png", "mask": "mask.png", "points": wider }] });
    fs::write(folder.path("demo/figure/sister.json"), instance.to_string()).unwrap();
    folder
        .sinew("views transfer figure.sinew demo/figure/sister.json -o sister.sinew --by-size")
        .done();
    let drawn = folder
        .sinew("views render sister.sinew --map walk --set phase=45 -o sister.png --json")
        .json();
    assert!(drawn["elements"].as_u64().unwrap() > 200);
    let twice =
        folder.sinew("views transfer sister.sinew demo/figure/sister.json -o x.sinew").failed();
    assert!(twice.ends_with("its motion is lent itself: take its prototype"), "{twice}");

    let foot = view["points"][15].clone();
    let (x, y) = (foot[0].as_f64().unwrap(), foot[1].as_f64().unwrap());
    let pinned = folder
        .sinew(&format!(
            "views pin figure.sinew --map walk --set phase=60 --pin 15={x},{y} -o pinned.png --json"
        ))
        .json();
    assert!((pinned["values"]["phase"].as_f64().unwrap() - 90.0).abs() < 12.0, "{pinned}");
}

#[test]
fn what_cannot_be_done_is_told_in_a_line() {
    let folder = trained("views-refused", "panel");
    for (arguments, told) in [
        (
            "views render panel.sinew --set yaw=1 --set pitch=2 -o x.png",
            "parameter \"bend\" is missing",
        ),
        (
            "views render panel.sinew --set yaw=1 --set yaw=2 -o x.png",
            "parameter \"yaw\" is given twice",
        ),
        (
            "views render panel.sinew --set yaw=1 --set pitch=2 --set bend=0 --set nod=3 -o x.png",
            "\"nod\" is no parameter: expected pitch, yaw, bend",
        ),
        (
            "views render panel.sinew --set yaw=1 --set pitch=2 --set bend=5 -o x.png",
            "parameter \"bend\" is 5, expected -1 to 2",
        ),
        (
            "views render panel.sinew --map run -o x.png",
            "panel.sinew: it has no map \"run\"; there are main",
        ),
        (
            "views train demo/panel/none.json -o x.sinew",
            "demo/panel/none.json: cannot be read: No such file or directory (os error 2)",
        ),
        (
            "views pin panel.sinew --set yaw=0 --set pitch=0 --set bend=0 --pin 99=1,2 -o x.png",
            "pin 0: point 99, of 35",
        ),
    ] {
        assert_eq!(folder.sinew(arguments).failed(), told, "{arguments}");
    }
    fs::write(folder.path("track.csv"), "1,2,3\n").unwrap();
    let told = folder.sinew("views drive panel.sinew --track track.csv -o x").failed();
    assert_eq!(told, "track.csv: line 1: expected 70 numbers, found 3");
    fs::remove_file(folder.path("demo/panel/view03.png")).unwrap();
    let told = folder.sinew("views train demo/panel/views.json -o y.sinew").failed();
    assert!(told.starts_with("demo/panel/views.json: demo/panel/view03.png: "), "{told}");
}
