//! Variants of the takes in folder `face`, as other programs write them.

use super::with_cases;
use crate::cli::common::Folder;
use serde_json::{Value, json};
use std::fs;

const TRAIN: &str = "face train --basis face_arkit.npz --animation t.csv -o f.sinew";

/// A take as text: names, and rows of cells.
#[derive(Clone)]
struct Table {
    names: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Table {
    fn of(text: &str) -> Self {
        let cells = |line: &str| line.split(',').map(str::to_owned).collect::<Vec<_>>();
        let mut lines = text.lines().map(cells);
        Self { names: lines.next().unwrap(), rows: lines.collect() }
    }

    /// Returns a copy with changed weights; the first two columns are time and count.
    fn weighed(&self, change: impl Fn(f64) -> f64) -> Self {
        let mut all = self.clone();
        for cell in all.rows.iter_mut().flat_map(|row| &mut row[2..]) {
            *cell = change(cell.parse().unwrap()).to_string();
        }
        all
    }

    /// Returns a copy with a second column for every weight, under other names.
    fn twice(&self, [first, second]: [&str; 2], change: impl Fn(usize, &str) -> String) -> Self {
        let mut all = self.clone();
        for (at, name) in self.names.iter().enumerate().skip(2) {
            all.names[at] = format!("{first}{name}");
            all.names.push(format!("{second}{name}"));
        }
        for (row, cells) in all.rows.iter_mut().enumerate() {
            let more: Vec<String> = cells[2..].iter().map(|cell| change(row, cell)).collect();
            cells.extend(more);
        }
        all
    }

    fn with_column(&self, name: &str, cell: &str) -> Self {
        let mut all = self.clone();
        all.names.push(name.to_owned());
        all.rows.iter_mut().for_each(|row| row.push(cell.to_owned()));
        all
    }

    fn text(&self) -> String {
        let lines = std::iter::once(&self.names).chain(&self.rows);
        lines.map(|cells| cells.join(",") + "\n").collect()
    }

    fn write(&self, folder: &Folder) {
        fs::write(folder.path("t.csv"), self.text()).unwrap();
    }
}

fn with_take(test: &str) -> Option<(Folder, Table)> {
    let folder = with_cases(test, &["face/face_arkit.npz", "face/take.csv"])?;
    let text = String::from_utf8(folder.read("take.csv")).unwrap();
    Some((folder, Table::of(&text)))
}

/// Trains on a take; returns the JSON and the file's bytes.
#[track_caller]
fn trained(folder: &Folder, take: &Table, options: &str) -> (Value, Vec<u8>) {
    take.write(folder);
    (folder.sinew(&format!("{TRAIN} --json -q {options}")).json(), folder.read("f.sinew"))
}

/// Trains on a take and returns the warnings.
#[track_caller]
fn warned(folder: &Folder, take: &Table, options: &str) -> String {
    take.write(folder);
    let run = folder.sinew(&format!("{TRAIN} {options}"));
    assert_eq!(run.code, Some(0), "{}", run.err);
    run.err
}

#[track_caller]
fn refused(folder: &Folder, text: &[u8]) -> String {
    fs::write(folder.path("t.csv"), text).unwrap();
    folder.sinew(&format!("{TRAIN} -q")).failed()
}

/// Solves a pin with the given options; returns the weights.
#[track_caller]
fn pinned(folder: &Folder, options: &str) -> Vec<f64> {
    let run = format!("face pin f.sinew --pin 9=_,_,0.4 -o w.csv --json {options}");
    let found = folder.sinew(&run).json();
    found["weights"].as_object().unwrap().values().map(|w| w.as_f64().unwrap()).collect()
}

#[test]
fn columns_that_drive_one_shape_must_agree() {
    let Some((folder, take)) = with_take("takes-agree") else { return };
    let plain = trained(&folder, &take, "");
    let meshes = ["head_geo.", "teeth_geo."];
    // A slider on two meshes, in f64 and in f32, is one slider.
    let narrow = |_: usize, cell: &str| f64::from(cell.parse::<f32>().unwrap()).to_string();
    for change in
        [&|_: usize, cell: &str| cell.to_owned(), &narrow as &dyn Fn(usize, &str) -> String]
    {
        assert_eq!(trained(&folder, &take.twice(meshes, change), ""), plain);
    }
    let still = take.twice(meshes, |_, _| "0".to_owned()).text();
    let first = &take.rows[0][2].parse::<f64>().unwrap();
    let expected = format!(
        "t.csv: columns \"head_geo.EyeBlinkLeft\" and \"teeth_geo.EyeBlinkLeft\" both drive shape \
         \"eyeBlinkLeft\", and differ in line 2: {first} and 0: remove one of each of 9 such pairs"
    );
    let error = refused(&folder, still.as_bytes());
    assert!(error.ends_with(&expected), "{error}");
    // Two spellings of a name; one differing row is enough.
    let other = take.with_column("eyeBlink_L", "0.5").text();
    let error = refused(&folder, other.as_bytes());
    assert!(error.contains("columns \"EyeBlinkLeft\" and \"eyeBlink_L\" both drive"), "{error}");
    assert!(error.ends_with("and 0.5: remove one of them"), "{error}");
    let last = take.rows.len() - 1;
    let late = |row, cell: &str| if row == last { "0.123".to_owned() } else { cell.to_owned() };
    let error = refused(&folder, take.twice(meshes, late).text().as_bytes());
    assert!(error.contains(&format!("differ in line {}: ", last + 2)), "{error}");
}

/// Without motion the covariance is the identity (METHOD §5.1), so the prior is the slider norm
/// about the mean.
#[test]
fn a_take_that_never_changes_trains() {
    let Some((folder, take)) = with_take("takes-still") else { return };
    let still = |count: usize, noise: f64| {
        let mut still = take.clone();
        still.rows = vec![take.rows[0].clone(); count];
        for (at, row) in still.rows.iter_mut().enumerate() {
            for (column, cell) in row.iter_mut().enumerate().skip(2) {
                let sign = if (at * 7 + column * 3) % 5 < 2 { 1.0 } else { -1.0 };
                *cell = (cell.parse::<f64>().unwrap() + sign * noise).to_string();
            }
        }
        still
    };
    for (count, noise) in
        [(1, 0.0), (3, 0.0), (7, 0.0), (50, 0.0), (50, 1e-9), (50, 1e-6), (50, 5e-5)]
    {
        let err = warned(&folder, &still(count, noise), "");
        let frames = if count == 1 { "1 frame".to_owned() } else { format!("{count} frames") };
        let message =
            format!("t.csv: weights do not change in {frames}: only their mean is learned");
        assert!(err.contains(&message), "{count} {noise}: {err}");
        let (prior, slider) =
            (pinned(&folder, "--anchor mean"), pinned(&folder, "--anchor mean --slider"));
        assert!(prior.iter().zip(&slider).all(|(a, b)| (a - b).abs() < 1e-6), "{count} {noise}");
    }
    let err = warned(&folder, &take, "");
    assert!(!err.contains("do not change"), "{err}");
    // Weights outside the range of a file are refused, with the names of both files.
    let error = refused(&folder, take.weighed(|w| 1e12 * w).text().as_bytes());
    assert!(error.contains("face_arkit.npz with t.csv: the runtime refuses"), "{error}");
}

#[test]
fn percent_are_noticed_and_taken() {
    let Some((folder, take)) = with_take("takes-percent") else { return };
    trained(&folder, &take, "");
    let expected = pinned(&folder, "--anchor mean");
    let percent = take.weighed(|w| 100.0 * w);
    let err = warned(&folder, &percent, "");
    let (column, line, largest) = largest(&percent);
    let message = format!(
        "t.csv: the largest weight is {largest}, of column {column:?} in line {line}, and 1 is the full shape: \
         give --percent if 100 is the full shape, or divide the weights by their full value"
    );
    assert!(err.contains(&message), "{err}");
    let err = warned(&folder, &percent, "--percent");
    assert!(!err.contains("largest"), "{err}");
    let found = pinned(&folder, "--anchor mean");
    assert!(expected.iter().zip(&found).all(|(a, b)| (a - b).abs() < 1e-5), "{found:?}");
    // Slightly above the full shape, or below 0: not unusual.
    for change in [|w: f64| 1.5 * w, |w: f64| -w] {
        assert!(!warned(&folder, &take.weighed(change), "").contains("largest"));
    }
    for (take, options, message) in [
        (take.weighed(|w| -10.0 * w), "", "give --percent if 100 is the full shape"),
        (take.clone(), "--percent", "100 is the full shape: leave --percent out"),
        (take.weighed(|w| 255.0 * w), "--percent", "divide the weights by their full value"),
    ] {
        let err = warned(&folder, &take, options);
        assert!(err.contains(message), "{err}");
    }
    // Also everywhere else that reads weights.
    trained(&folder, &take, "");
    percent.write(&folder);
    let weights = |file: &str| pinned(&folder, &format!("--weights {file} -q"));
    let (from, to) = (weights("take.csv"), weights("t.csv --percent"));
    assert!(from.iter().zip(&to).all(|(a, b)| (a - b).abs() < 1e-5), "{from:?} {to:?}");
}

/// Returns the column, the line and the value of the largest weight that drives a shape of the
/// face.
fn largest(take: &Table) -> (String, usize, f64) {
    let shapes = [
        "EyeBlinkLeft",
        "EyeBlinkRight",
        "MouthSmileLeft",
        "MouthSmileRight",
        "BrowInnerUp",
        "JawOpen",
        "NoseSneerLeft",
        "NoseSneerRight",
        "TongueOut",
    ];
    let mut found = (String::new(), 0, 0.0);
    for (row, cells) in take.rows.iter().enumerate() {
        for (name, cell) in
            take.names.iter().zip(cells).filter(|(name, _)| shapes.contains(&name.as_str()))
        {
            let weight: f64 = cell.parse().unwrap();
            if weight > found.2 {
                found = (name.clone(), row + 2, weight);
            }
        }
    }
    found
}

#[test]
fn prefixes_stand_before_any_column() {
    let Some((folder, take)) = with_take("takes-prefix") else { return };
    let mut lossy = take.clone();
    lossy.rows[5][1] = "0".to_owned();
    let plain = trained(&folder, &lossy, "");
    assert_eq!(plain.0["lost_frames"], json!(1));
    for prefix in [
        "blendShape1_",
        "BS_",
        "ARKit_",
        "SM_Head_",
        "CTRL_expressions_",
        "bs_node_",
        "head_geo.",
        "head:",
        "head_geo.blendShape1_",
        "root|head_geo|BS_",
        "BS-",
        "Face ",
    ] {
        let mut prefixed = lossy.clone();
        // With and without the prefix on time and count.
        for skip in [0, 2] {
            prefixed.names.clone_from(&lossy.names);
            prefixed.names.iter_mut().skip(skip).for_each(|name| name.insert_str(0, prefix));
            assert_eq!(trained(&folder, &prefixed, ""), plain, "{prefix}");
        }
    }
}

#[test]
fn other_tables_than_takes_are_refused_briefly() {
    let Some((folder, take)) = with_take("takes-words") else { return };
    let remedy = "name each column after a shape of the face, or remove the column";
    for name in ["Confidence", "FrameNumber", "Date", "Name", "Index", "Comment", "Unnamed: 0"] {
        let error = refused(&folder, take.with_column(name, "1").text().as_bytes());
        assert!(error.ends_with(&format!("t.csv: unknown {name:?}: {remedy}")), "{error}");
    }
    let typo = take.text().replacen("EyeBlinkLeft", "EyeBlnkLeft", 1);
    let error = refused(&folder, typo.as_bytes());
    assert!(
        error.contains("\"EyeBlnkLeft\" (did you mean eyeBlinkLeft, eyeBlinkRight?): name each"),
        "{error}"
    );
    let mut suffixed = take.clone();
    suffixed.names.iter_mut().skip(2).for_each(|name| name.push_str("_x1"));
    let error = refused(&folder, suffixed.text().as_bytes());
    assert!(error.contains(" and 56 more: name each column"), "{error}");
    // Lines above the names, and a missing line of names.
    let text = take.text();
    for title in ["# exported", "sep=,", "Exported by X, take 3"] {
        let error = refused(&folder, format!("{title}\n{text}").as_bytes());
        assert!(
            error.contains("line 1: expected the names of 63 columns, as the next line has"),
            "{error}"
        );
        assert!(error.ends_with("\": remove the lines before the names"), "{error}");
    }
    let rows = text.split_once('\n').unwrap().1;
    let error = refused(&folder, rows.as_bytes());
    assert!(
        error.contains(
            "line 1: expected the names of the columns, found numbers (61): write a line"
        ),
        "{error}"
    );
    for (bytes, found) in [
        (text.encode_utf16().flat_map(u16::to_le_bytes).collect::<Vec<_>>(), "UTF-16"),
        (format!("\u{feff}{text}").encode_utf16().flat_map(u16::to_be_bytes).collect(), "UTF-16"),
        (text.bytes().chain([b'1', 0xe9]).collect(), "byte 0xe9"),
    ] {
        let error = refused(&folder, &bytes);
        let expected =
            format!(": expected text in UTF-8, found {found}: save the table as CSV in UTF-8");
        assert!(error.ends_with(&expected), "{error}");
    }
    // Of many columns without a shape, the first are listed.
    let err = warned(&folder, &take, "");
    let message = "left out: EyeLookDownLeft, EyeLookInLeft, EyeLookOutLeft, EyeLookUpLeft, EyeSquintLeft and 47 more\n";
    assert!(err.contains(message), "{err}");
}

#[test]
fn lost_frames_are_counted_wherever_a_take_is_read() {
    let Some((folder, take)) = with_take("takes-lost") else { return };
    fs::write(folder.path("landmarks.txt"), "0 9 20 50").unwrap();
    let mut lossy = take.clone();
    for row in [1, 2, 50, 90, 91, 92] {
        lossy.rows[row][1] = "0".to_owned();
    }
    trained(&folder, &lossy, "--landmarks landmarks.txt --frames ..60");
    let eval = "face eval f.sinew --animation t.csv --handles 2 --every 5 --from 0 --json -q";
    for (frames, lost) in [("0..", 6), ("60..", 3), ("10..40", 0)] {
        let found = folder.sinew(&format!("{eval} --frames {frames}")).json();
        assert_eq!(found["lost_frames"], json!(lost), "{frames}");
    }
    let percent = take.weighed(|w| 100.0 * w);
    let plain = format!("{eval} --frames 60..");
    take.write(&folder);
    let expected = folder.sinew(&plain).json();
    percent.write(&folder);
    let found = folder.sinew(&format!("{plain} --percent")).json();
    let number = |value: &Value| value["handles"]["2"]["prior"].as_f64().unwrap();
    assert!((number(&expected) - number(&found)).abs() < 1e-5 * number(&expected));
}
