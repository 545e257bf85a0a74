//! Tables fit a terminal, whatever names and figures they contain.

use super::common::{Folder, Run, Set};
use models::shared;
use serde_json::json;
use std::fs;
use unicode_width::UnicodeWidthStr;

/// Width of the terminal, in columns.
const COLUMNS: usize = 100;

/// Asserts that rows of tables, which have two blanks between cells, fit the terminal.
#[track_caller]
fn fits(run: Run) -> String {
    assert_eq!(run.code, Some(0), "{run:?}");
    let rows = run.out.lines().filter(|line| line.trim_start().contains("  "));
    for row in rows {
        assert!(row.width() <= COLUMNS, "{} columns: {row}", row.width());
    }
    run.out
}

const LONG: &str =
    "character_01:rig:deformation:left_forearm_twist_segment_0_with_a_name_that_goes_on_and_on";

#[test]
fn tables_of_long_names_fit_and_distinguish_the_names() {
    let folder = Folder::with_demo("tables-long");
    let mut set = Set::demo();
    for (joint, name) in set.json["bone_names"].as_array_mut().unwrap().iter_mut().enumerate() {
        *name = json!(format!("{LONG}_{joint}"));
    }
    set.json["bone_names"][2] = json!("左腕".repeat(40));
    set.json["mesh_names"] = json!([format!("{LONG}_body"), format!("{LONG}_jacket")]);
    set.json["mesh_starts"] = json!([0, 100]);
    set.json["unit"] = json!(0.01);
    set.write(&folder.path("long.npz"));
    let places = set.reals["rest"].1.chunks(3).map(|x| format!("v {} {} {}\n", x[0], x[1], x[2]));
    let faces = set.wholes["tris"].1.chunks(3);
    let faces = faces.map(|t| format!("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1));
    let mesh: String = places.chain(faces).collect();
    fs::write(folder.path(&format!("{LONG}.obj")), mesh).unwrap();
    let train = "train long.npz -o long.sinew --predictor kernel --proxies 2 -q";
    fits(folder.sinew(&format!("{train} --also {LONG}.obj")));
    let message = fits(folder.sinew("inspect long.sinew"));
    assert!(
        message.contains("…") && message.contains("on_3 ") && message.contains("on_4 "),
        "{message}"
    );
    let message = fits(folder.sinew("check long.npz"));
    assert!(message.contains("character_") && message.contains("on_3 "), "{message}");
    let message = fits(folder.sinew("eval long.sinew long.npz"));
    assert!(message.contains("_body ") && message.contains("_jacket "), "{message}");
    fits(folder.sinew("report long.sinew long.npz -o page.html --quick"));
    // JSON output contains whole names.
    let found = folder.sinew("inspect long.sinew --json").json();
    assert_eq!(found["envelopes"][0]["joints"][3]["name"], json!(format!("{LONG}_3")));
}

#[test]
fn every_candidate_fits() {
    let folder = Folder::with_demo("tables-candidates");
    let mut set = Set::demo();
    set.json["unit"] = json!(0.01);
    set.write(&folder.path("unit.npz"));
    fits(folder.sinew("train unit.npz -o new.sinew --proxies 2 --budget 60kB"));
    fits(
        folder.sinew("train unit.npz -o new.sinew --predictor rotational --unrefined --proxies 2"),
    );
    fits(folder.sinew("train unit.npz -o new.sinew --published --proxies 2"));
    fits(folder.sinew("demo --vertices 300 --poses 12 --held-out 4 --proxies 2"));
}

#[test]
fn tables_of_functions_and_signals_fit() {
    let folder = Folder::new("tables-functions");
    let samples = json!({
        "name": LONG,
        "sites": (0..12).map(|k| [k as f64 / 11.0, (k * k % 7) as f64]).collect::<Vec<_>>(),
        "values": (0..12).map(|k| [(k as f64).sin()]).collect::<Vec<_>>(),
        "inputs": [{ "name": format!("{LONG}_a") }, { "name": format!("{LONG}_b") }],
        "outputs": [{ "name": format!("{LONG}_c"), "clamp": [-1.123456789, 1.123456789] }],
    });
    fs::write(folder.path("p.json"), samples.to_string()).unwrap();
    fits(folder.sinew("kernel train p.json -o p.sinew --smoothing 0.01"));
    fits(folder.sinew("inspect p.sinew"));
    let case = |name: String| {
        json!({ "name": name, "sites": [[0.0], [1.0], [2.0]], "values": [[0.0], [1.0], [2.0]],
            "queries": [[0.5]], "expected": [[0.5]], "options": { "kernel": "linear", "degree": 1 } })
    };
    let cases = json!({ "cases": [case(LONG.to_owned()), case(format!("{LONG}_2"))] });
    fs::write(folder.path("cases.json"), cases.to_string()).unwrap();
    fits(folder.sinew("kernel check cases.json"));
    let mut signal = format!("t,{LONG}\n");
    (0..64).for_each(|k| signal += &format!("{k},{}\n", (0.2 * k as f64).sin()));
    fs::write(folder.path("s.csv"), signal).unwrap();
    fits(folder.sinew(&format!("signal train s.csv --column {LONG} --factor 4 -o s.sinew -q")));
    fits(folder.sinew("inspect s.sinew"));
}

#[test]
fn tables_of_real_sets_fit() {
    let folder = Folder::new("tables-real");
    for (set, also) in [
        ("leg/leg.glb", ""),
        ("gltf-loader/Fox.glb", ""),
        ("mpfb-arm/mpfb_arm.npz", ""),
        ("mpfb-body/mpfb_body.npz", "check alone"),
    ] {
        let Some(path) = shared(set) else { return };
        let path = path.display();
        fits(folder.sinew(&format!("check {path} -q")));
        if also.is_empty() {
            let train = "-o m.sinew --predictor kernel --proxies 4 --hold-out 0.25 -q";
            fits(folder.sinew(&format!("train {path} {train}")));
            fits(folder.sinew(&format!("eval m.sinew {path}  -q")));
            fits(folder.sinew("inspect m.sinew"));
        }
    }
}
