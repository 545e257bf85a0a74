//! Cases of the folder `face`.

use super::with_cases;
use crate::cli::common::Folder;
use serde_json::{Value, json};
use std::fs;

const FACES: [&str; 2] = ["face/face_arkit.npz", "face/face_prefixed.npz"];
/// Rows of `take_lost.csv` (of 120, counted from 0) in which the tracking is lost.
const LOST: [usize; 4] = [40, 41, 42, 43];

/// A way to lose a row: its name, and its change of the line.
type Spoil<'a> = (&'a str, &'a dyn Fn(&str) -> String);

fn folder(test: &str, takes: &[&str]) -> Option<Folder> {
    with_cases(test, &[&FACES[..], takes].concat())
}

/// Trains on a take; returns the JSON report and the file's bytes.
fn trained(folder: &Folder, basis: &str, take: &str) -> (Value, Vec<u8>) {
    let train = format!("face train --basis {basis} --animation {take} -o f.sinew --json -q");
    (folder.sinew(&train).json(), folder.read("f.sinew"))
}

#[test]
fn a_take_is_the_same_however_it_is_written() {
    let takes = ["face/take.csv", "face/take_lower.csv", "face/take_semicolon.csv"];
    let Some(folder) = folder("case-face-same", &takes) else { return };
    let plain = trained(&folder, "face_arkit.npz", "take.csv");
    let said = &plain.0;
    assert_eq!((&said["frames"], &said["lost_frames"]), (&json!(120.0), &json!(0)));
    let text = String::from_utf8(folder.read("take.csv")).unwrap();
    let semicolon = String::from_utf8(folder.read("take_semicolon.csv")).unwrap();
    let lines = |ending: &str| text.replace('\n', ending);
    let quoted = text.lines().map(|line| format!("\"{}\"\n", line.replace(',', "\",\""))).collect();
    let prefixed = |prefix: &str| {
        let (head, rows) = text.split_once('\n').unwrap();
        let names: Vec<String> = head.split(',').map(|name| format!("{prefix}{name}")).collect();
        format!("{}\n{rows}", names.join(","))
    };
    for (name, text) in [
        ("tabs.csv", text.replace(',', "\t")),
        ("tabs_comma.csv", semicolon.replace(';', "\t")),
        ("semicolon_point.csv", text.replace(',', ";")),
        ("mark.csv", format!("\u{feff}{text}")),
        ("mark_semicolon.csv", format!("\u{feff}{semicolon}")),
        ("windows.csv", lines("\r\n")),
        ("empty_lines.csv", format!("{text}\n\n  \n")),
        ("empty_cells.csv", format!("{text}{}\n", ",".repeat(62))),
        ("end.csv", lines(",\n")),
        ("quoted.csv", quoted),
        ("upper.csv", text.to_uppercase()),
        ("small.csv", text.to_lowercase()),
        ("prefixed.csv", prefixed("blendShape1.")),
    ] {
        fs::write(folder.path(name), text).unwrap();
        assert_eq!(trained(&folder, "face_arkit.npz", name), plain, "{name}");
    }
    for take in ["take_lower.csv", "take_semicolon.csv"] {
        assert_eq!(trained(&folder, "face_arkit.npz", take), plain, "{take}");
    }
}

#[test]
fn shapes_with_a_prefix_are_those_without() {
    let Some(folder) = folder("case-face-prefix", &["face/take.csv"]) else { return };
    let (expected, _) = trained(&folder, "face_arkit.npz", "take.csv");
    let (said, _) = trained(&folder, "face_prefixed.npz", "take.csv");
    assert_eq!(said["mirrored_pairs"], expected["mirrored_pairs"]);
    let weights = |basis: &str| -> Vec<f64> {
        let train = "face train --animation take.csv -o f.sinew -q";
        folder.sinew(&format!("{train} --basis {basis}")).done();
        let pin =
            folder.sinew("face pin f.sinew --pin 9=_,_,0.4 --anchor mean -o w.csv --json").json();
        pin["weights"].as_object().unwrap().values().map(|w| w.as_f64().unwrap()).collect()
    };
    let mut found = [weights("face_arkit.npz"), weights("face_prefixed.npz")];
    found.iter_mut().for_each(|all| all.sort_by(f64::total_cmp));
    assert!(found[0].iter().zip(&found[1]).all(|(a, b)| (a - b).abs() < 1e-6), "{found:?}");
}

#[test]
fn rows_in_which_the_tracking_is_lost_are_left_out_and_counted() {
    let Some(folder) = folder("case-face-lost", &["face/take.csv", "face/take_lost.csv"]) else {
        return;
    };
    let (said, lost) = trained(&folder, "face_arkit.npz", "take_lost.csv");
    assert_eq!((&said["frames"], &said["lost_frames"]), (&json!(116.0), &json!(4)));
    // The file must equal the file of a take without those rows.
    let text = String::from_utf8(folder.read("take.csv")).unwrap();
    let kept = |rows: &[usize]| -> String {
        let all =
            text.lines().enumerate().filter(|(line, _)| *line == 0 || !rows.contains(&(line - 1)));
        all.map(|(_, line)| format!("{line}\n")).collect()
    };
    fs::write(folder.path("kept.csv"), kept(&LOST)).unwrap();
    assert_eq!(trained(&folder, "face_arkit.npz", "kept.csv").1, lost);
    // The text output reports the lost rows by line.
    let run =
        folder.sinew("face train --basis face_arkit.npz --animation take_lost.csv -o f.sinew");
    assert_eq!(run.code, Some(0));
    assert!(run.out.contains("frames without tracking     4\n"), "{}", run.out);
    let message = "take_lost.csv: the tracking is lost in 4 of 120 rows, which are left out: line 42, 43, 44, 45\n";
    assert!(run.err.contains(message), "{}", run.err);
    // Empty cells, a count of 0 with numbers, and rows at the start and at the end.
    let rows = [0, 1, 60, 118, 119];
    let spoilt = |spoil: &dyn Fn(&str) -> String| -> String {
        let line = |(at, line): (usize, &str)| match at > 0 && rows.contains(&(at - 1)) {
            true => format!("{}\n", spoil(line)),
            false => format!("{line}\n"),
        };
        text.lines().enumerate().map(line).collect()
    };
    fs::write(folder.path("kept.csv"), kept(&rows)).unwrap();
    let (_, expected) = trained(&folder, "face_arkit.npz", "kept.csv");
    let cells = |line: &str, change: &dyn Fn(usize, &str) -> String| {
        let all: Vec<String> =
            line.split(',').enumerate().map(|(at, cell)| change(at, cell)).collect();
        all.join(",")
    };
    let first_two =
        |line: &str, count: &str| format!("{},{count}", line.split(',').next().unwrap());
    let spoils: [Spoil<'_>; 5] = [
        ("short", &|line| first_two(line, "0")),
        ("empty", &|line| {
            cells(line, &|at, cell| if at > 1 { String::new() } else { cell.to_owned() })
        }),
        ("some", &|line| {
            cells(line, &|at, cell| if at == 2 { String::new() } else { cell.to_owned() })
        }),
        ("zero", &|line| {
            cells(line, &|at, cell| if at == 1 { "0".to_owned() } else { cell.to_owned() })
        }),
        ("uncounted", &|line| first_two(line, "")),
    ];
    for (name, spoil) in spoils {
        let name = format!("{name}.csv");
        fs::write(folder.path(&name), spoilt(spoil)).unwrap();
        let (said, file) = trained(&folder, "face_arkit.npz", &name);
        assert_eq!((&said["lost_frames"], file == expected), (&json!(5), true), "{name}");
    }
    // Frames keep the file's numbers. A take without any tracked row is refused.
    let train = "face train --basis face_arkit.npz --animation take_lost.csv -o f.sinew --json -q";
    let said = folder.sinew(&format!("{train} --frames 38..46")).json();
    assert_eq!((&said["frames"], &said["lost_frames"]), (&json!(4.0), &json!(4)));
    let error = folder.sinew(&format!("{train} --frames 40..44")).failed();
    assert!(error.contains("frames 40..44"), "{error}");
    let none: String =
        text.lines().take(1).chain(["0:0,0", "0:1,0"]).map(|line| format!("{line}\n")).collect();
    fs::write(folder.path("take_lost.csv"), none).unwrap();
    let error = folder.sinew(train).failed();
    assert!(error.contains("the tracking is lost in all 2 rows"), "{error}");
}

/// METHOD §5.1: without frames the covariance is the identity, so the prior is the slider norm.
#[test]
fn a_face_without_a_take_trains() {
    let Some(folder) = folder("case-face-no-take", &["face/take.csv"]) else { return };
    let run = folder.sinew("face train --basis face_arkit.npz -o f.sinew").done();
    assert!(run.out.contains("from no take: weights are independent"), "{}", run.out);
    let said = folder.sinew("inspect f.sinew --json").json();
    assert_eq!(said["priors"][0]["frames"], 0.0);
    assert!(folder.sinew("inspect f.sinew").done().out.contains("from no take"));
    let pin = |options: &str| {
        folder.sinew(&format!("face pin f.sinew --pin 9=_,_,0.4 -o w.csv --json {options}")).json()
    };
    for options in ["", "--anchor mean", "--bounded"] {
        assert_eq!(pin(options)["weights"], pin(&format!("{options} --slider"))["weights"]);
    }
    folder.sinew("face eval f.sinew --animation take.csv --handles 3 -q").failed();
    let error = folder.sinew("face train --basis face_arkit.npz --frames 0..4 -o f.sinew").failed();
    assert!(error.contains("--frames is of a take: give --animation"), "{error}");
}
