//! The row of the joint weights that come with the mesh, beside that of LBS, fitted.

use super::cases::with_cases;
use super::common::{Folder, Run, Set};
use super::number;
use serde_json::Value;

/// A demo whose joint weights leave the whole skin on the root.
fn on_the_root(folder: &Folder) -> Set {
    let mut set = Set::demo();
    let (vertex_len, joint_len) = (set.vertex_len(), set.joint_len());
    let weights = (0..vertex_len * joint_len).map(|k| if k % joint_len == 0 { 0.5 } else { 0.0 });
    let shape = vec![vertex_len as u64, joint_len as u64];
    set.reals.insert("joint_weights", (shape, weights.collect()));
    set.write(&folder.path("own.npz"));
    set
}

/// RMS error of a mesh that follows the root, over the frames of a split's code, in % of the diagonal.
fn root_alone(set: &Set, code: i64) -> f64 {
    let [rest, posed, maps] =
        ["rest", "vertices", "bone_transforms"].map(|name| &set.reals[name].1);
    let (vertex_len, joint_len) = (set.vertex_len(), set.joint_len());
    let corner = |axis: usize| {
        let along = rest.iter().skip(axis).step_by(3);
        along.clone().copied().fold(f64::MIN, f64::max) - along.copied().fold(f64::MAX, f64::min)
    };
    let diagonal = (0..3).map(|axis| corner(axis).powi(2)).sum::<f64>().sqrt();
    let (mut squares, frames) = (0.0, set.frames(code));
    for &frame in &frames {
        let map = &maps[16 * frame * joint_len..];
        for (vertex, x) in rest.chunks(3).enumerate() {
            for axis in 0..3 {
                let row = &map[4 * axis..];
                let moved = row[0] * x[0] + row[1] * x[1] + row[2] * x[2] + row[3];
                squares += (moved - posed[3 * (frame * vertex_len + vertex) + axis]).powi(2);
            }
        }
    }
    100.0 * (squares / (frames.len() * vertex_len) as f64).sqrt() / diagonal
}

#[track_caller]
fn near(found: &Value, expected: f64) {
    assert!((number(found) / expected - 1.0).abs() < 1e-6, "{found}, expected {expected}");
}

/// Insists on one row of own weights in a table of errors, right under that of LBS.
#[track_caller]
fn has_row(run: &Run, percent: f64) {
    let lines: Vec<&str> = run.out.lines().collect();
    let place = lines.iter().position(|line| line.starts_with("own weights ")).unwrap();
    assert!(lines[place - 1].starts_with("LBS, fitted "), "{}", run.out);
    let cells: Vec<&str> = lines[place].split_whitespace().collect();
    assert_eq!(cells[2], format!("{percent:.4}"), "{}", run.out);
}

#[test]
fn every_command_shows_the_error_of_the_weights_that_come_with_the_mesh() {
    let folder = Folder::with_demo("own-weights");
    let set = on_the_root(&folder);
    let [train, held_out] = [0, 1].map(|code| root_alone(&set, code));

    let checked = folder.sinew("check own.npz -q --json").json();
    near(&checked["lbs"]["own_weights_percent"], train);
    let text = folder.sinew("check own.npz -q").done().out;
    assert!(text.contains(&format!("\n  own weights: {train:.4} %\n")), "{text}");

    let command = "-q train own.npz -o own.sinew --predictor kernel --proxies 2";
    has_row(&folder.sinew(command).done(), train);
    let record = folder.sinew(&format!("{command} --json")).json();
    near(&record["report"]["own_weights_rms"], train / 100.0);

    let command = "-q eval own.sinew own.npz";
    has_row(&folder.sinew(command).done(), held_out);
    let found = folder.sinew(&format!("{command} --json")).json();
    near(&found["own_weights"]["rms_percent"], held_out);
    for region in found["regions"].as_array().unwrap() {
        assert!(number(&region["own_weights_rms_percent"]) > 0.0);
    }

    let command = "-q report own.sinew own.npz -o page.html --quick --csv frames.csv";
    has_row(&folder.sinew(command).done(), held_out);
    let page = String::from_utf8(folder.read("page.html")).unwrap();
    assert!(page.contains(&format!("{held_out:.4}\u{a0}%")), "{held_out}");
    let table = String::from_utf8(folder.read("frames.csv")).unwrap();
    assert!(table.lines().next().unwrap().contains(",own_weights_rms,"), "{table}");
}

#[test]
fn without_weights_no_row_is_shown() {
    let folder = Folder::with_demo("no-weights");
    for command in
        ["check demo.npz", "train demo.npz -o m.sinew --proxies 2", "eval demo.sinew demo.npz"]
    {
        let text = folder.sinew(command).done().out;
        assert!(text.contains("LBS, fitted") && !text.contains("own weights"), "{text}");
        let json = folder.sinew(&format!("{command} --json")).done().out;
        assert!(!json.contains("own_weights"), "{json}");
    }
}

/// The errors on the clips of a biped, measured by another program.
#[test]
fn own_weights_of_a_biped_are_measured_on_each_clip() {
    let Some(folder) = with_cases("biped", &["rigs/biped.npz"]) else { return };
    for (clip, percent) in [("Walk 歩き", 0.173), ("Wave & look", 0.163), ("Squat + squash", 0.226)]
    {
        let run = |arguments: &str| {
            let mut command = folder.command(arguments);
            command.args(["-q", "--json", "--hold-out-clip", clip]);
            folder.run(command).json()
        };
        run("train biped.npz -o m.sinew --predictor kernel --proxies 1");
        let found = run("eval m.sinew biped.npz");
        assert_eq!(found["split"], "held-out");
        let own = number(&found["own_weights"]["rms_percent"]);
        assert!((own / percent - 1.0).abs() < 0.01, "{clip}: {own}");
    }
}
