//! Errors in millimetres if a file states its unit; no millimetres if it does not.

use super::common::{Folder, Run, Set};
use super::{close, number};
use serde_json::{Value, json};

/// Writes the demo as `unit.npz`, with a unit of 1 cm.
fn with_unit(folder: &Folder) {
    let mut set = Set::demo();
    set.json["unit"] = json!(0.01);
    set.write(&folder.path("unit.npz"));
}

/// Checks that every key in millimetres is 10 times the length, or the share of the diagonal, next
/// to it.
#[track_caller]
fn are_centimetres(value: &Value, diagonal: f64, keys: &[&str]) {
    for key in keys {
        let of = |ending: &str| value.get(format!("{key}{ending}"));
        let percent = number(of("_percent").unwrap_or_else(|| panic!("{key}: {value}")));
        let found = number(of("_mm").unwrap_or_else(|| panic!("{key}: {value}")));
        assert!(close(found, 10.0 * diagonal * percent / 100.0), "{key}: {value}");
    }
}

/// Lists the keys in millimetres anywhere in a value.
fn keys_of(value: &Value) -> Vec<String> {
    match value {
        Value::Object(all) => {
            let own = all.keys().filter(|key| key.ends_with("_mm")).cloned();
            own.chain(all.values().flat_map(keys_of)).collect()
        }
        Value::Array(all) => all.iter().flat_map(keys_of).collect(),
        _ => Vec::new(),
    }
}

const DISTANCES: [&str; 3] = ["rms", "p99", "max"];

#[test]
fn eval_measures_in_millimetres_where_either_file_says_the_unit() {
    let folder = Folder::with_demo("mm-eval");
    with_unit(&folder);
    folder.sinew("train unit.npz -o unit.sinew --predictor kernel --proxies 2").done();
    for (model, examples) in
        [("unit.sinew", "unit.npz"), ("unit.sinew", "demo.npz"), ("demo.sinew", "unit.npz")]
    {
        let eval = format!("eval {model} {examples}");
        let found = folder.sinew(&format!("{eval} --json")).json();
        let diagonal = number(&found["diagonal"]);
        assert!(close(number(&found["diagonal_mm"]), 10.0 * diagonal));
        for errors in [&found, &found["lbs"]] {
            are_centimetres(errors, diagonal, &DISTANCES);
        }
        for region in found["regions"].as_array().unwrap() {
            are_centimetres(region, diagonal, &["rms", "lbs_rms"]);
        }
        let text = folder.sinew(&eval).done().out;
        let rms = format!("{:.3}", number(&found["rms_mm"]));
        let row = text.lines().find(|line| line.starts_with("kernel, ")).expect(&text);
        assert!(row.split_whitespace().any(|cell| cell == rms), "{text}");
        assert!(text.contains("mm"), "{text}");
    }
    let found = folder.sinew("eval demo.sinew demo.npz --json").json();
    assert!(keys_of(&found).is_empty(), "{found}");
    assert!(!folder.sinew("eval demo.sinew demo.npz").done().out.contains("mm"));
}

#[test]
fn a_unit_that_is_given_by_option_counts() {
    let folder = Folder::with_demo("mm-option");
    let found = folder.sinew("eval demo.sinew demo.npz --unit 0.01 --json").json();
    are_centimetres(&found, number(&found["diagonal"]), &DISTANCES);
}

#[test]
fn check_and_train_and_inspect_say_millimetres() {
    let folder = Folder::with_demo("mm-check");
    with_unit(&folder);
    let found = folder.sinew("check unit.npz --json").json();
    let diagonal = number(&found["size"]["diagonal"]);
    are_centimetres(&found["lbs"], diagonal, &["rms"]);
    are_centimetres(&found["predicted"], diagonal, &["lbs", "expected"]);
    let joints = found["joints"].as_array().unwrap();
    joints.iter().for_each(|joint| are_centimetres(joint, diagonal, &["lbs"]));
    let rms = format!("({:.3} mm)", number(&found["lbs"]["rms_mm"]));
    let text = folder.sinew("check unit.npz").done().out;
    assert!(text.contains(&rms) && text.contains("LBS, mm"), "{rms}: {text}");

    let train = "train unit.npz -o unit.sinew --predictor kernel --proxies 2";
    let record = folder.sinew(&format!("{train} --json")).json();
    for (key, share) in [
        ("lbs_rms_mm", &record["report"]["lbs_rms"]),
        ("training_rms_mm", &record["report"]["training_rms"]),
        ("same_clips_rms_mm", &record["report"]["same_clips_rms"]),
    ] {
        assert!(close(number(&record[key]), 10.0 * diagonal * number(share)), "{key}");
    }
    let text = folder.sinew(train).done().out;
    let validated = format!("{:.3}", number(&record["same_clips_rms_mm"]));
    assert!(text.contains(&validated) && text.contains("mm"), "{validated}: {text}");
    let found = folder.sinew("inspect unit.sinew --json").json();
    let certificate = &found["envelopes"][0]["certificate"];
    let rms = number(&certificate["same_clips_rms"]);
    assert!(close(number(&certificate["same_clips_rms_mm"]), 10.0 * rms), "{certificate}");
    assert!(
        folder.sinew("inspect unit.sinew").done().out.contains(&format!("{:.3} mm", 10.0 * rms))
    );

    for command in ["check demo.npz", "train demo.npz -o m.sinew --proxies 2", "inspect demo.sinew"]
    {
        let found = folder.sinew(&format!("{command} --json")).json();
        assert!(keys_of(&found).is_empty(), "{command}: {:?}", keys_of(&found));
        assert!(!folder.sinew(command).done().out.contains(" mm"), "{command}");
    }
}

#[test]
fn the_report_and_its_table_say_millimetres() {
    let folder = Folder::with_demo("mm-report");
    with_unit(&folder);
    let report = "report demo.sinew unit.npz -o page.html --quick --csv frames.csv";
    let found = folder.sinew(&format!("{report} --json")).json();
    let model = &found["model"];
    let page = String::from_utf8(folder.read("page.html")).unwrap();
    for errors in [model, &model["lbs"]] {
        for key in ["rms_mm", "p99_mm", "max_mm"] {
            let cell = format!("{:.3}\u{a0}mm", number(&errors[key]));
            assert!(page.contains(&cell), "{key}: {cell}");
        }
    }
    let table = String::from_utf8(folder.read("frames.csv")).unwrap();
    let head: Vec<&str> = table.lines().next().unwrap().split(',').collect();
    for name in ["rms_mm", "p99_mm", "max_mm", "lbs_rms_mm"] {
        assert!(head.contains(&name), "{head:?}");
    }
    let column = |name: &str| head.iter().position(|own| *own == name).unwrap();
    for row in table.lines().skip(1) {
        let cells: Vec<f64> = row.split(',').map(|cell| cell.parse().unwrap_or(f64::NAN)).collect();
        let percent = cells[column("rms")] / 100.0 * number(&model["diagonal_mm"]);
        assert!(close(cells[column("rms_mm")], percent), "{row}");
    }
    folder.sinew(&report.replace("unit.npz", "demo.npz")).done();
    let [page, table] =
        ["page.html", "frames.csv"].map(|name| String::from_utf8(folder.read(name)).unwrap());
    assert!(!page.contains("\u{a0}mm") && !table.contains("_mm"));
}

#[test]
fn a_scene_is_in_metres() {
    let folder = Folder::new("mm-scene");
    folder.sinew("export-demo . --vertices 300 --poses 20 --held-out 5").done();
    let train = "train demo.glb --targets demo.pc2 --predictor kernel --proxies 4 -o m.sinew";
    let text = |run: Run| run.done().out;
    assert!(text(folder.sinew(train)).contains("mm"));
    let found = folder.sinew("eval m.sinew demo.glb --targets demo.pc2 --json").json();
    assert!(close(number(&found["rms_mm"]), 1000.0 * number(&found["rms"])), "{found}");
}
