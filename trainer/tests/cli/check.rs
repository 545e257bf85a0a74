//! `sinew check`: findings and advice, but no failure if there are any.

use super::common::{Folder, HELD_OUT, Set, TRAINING};
use super::keys;
use serde_json::json;
use unicode_width::UnicodeWidthStr;

#[test]
fn a_check_prints_its_sections_and_succeeds() {
    let folder = Folder::with_demo("check");
    let before = folder.list();
    let text = folder.sinew("check demo.npz").done().out;
    let first = text.lines().next().unwrap();
    assert!(
        first.ends_with(&format!("{TRAINING} training, {HELD_OUT} held-out, 0 extreme frames")),
        "{first}"
    );
    let headings: Vec<&str> = text.lines().filter(|line| !line.starts_with(' ')).skip(1).collect();
    let begins = |heading: &str| headings.iter().position(|line| line.starts_with(heading));
    let order: Vec<_> =
        ["size", "rest mesh", "faces", "joint ", "RMS error", "poses", "advice", "0 warnings"]
            .map(|heading| begins(heading).unwrap_or_else(|| panic!("{heading}: {text}")))
            .into();
    assert!(order.is_sorted(), "{text}");
    assert!(text.contains("m long if in metres") && text.contains("forearm_twist"), "{text}");
    assert!(text.lines().all(|line| !line.ends_with('.') && line.width() <= 100), "{text}");
    assert_eq!(folder.list(), before, "nothing is written");
}

#[test]
fn a_mesh_that_is_moved_is_named_left_out_and_not_called_read() {
    let folder = Folder::with_demo("moved");
    let mut set = Set::demo();
    let (moved, len) = (set.frames(0)[9], 3 * set.vertex_len());
    let (_, numbers) = set.reals.get_mut("vertices").unwrap();
    let ys = numbers[moved * len..][..len].iter_mut().skip(1).step_by(3);
    ys.for_each(|y| *y += 0.2);
    set.write(&folder.path("moved.npz"));
    let text = folder.sinew("check moved.npz").done().unwrapped();
    assert!(
        text.contains(&format!("check them, and fix or remove them: frame {moved} (")),
        "{text}"
    );
    assert!(!text.contains("another sculpt") && !text.contains("another order"), "{text}");
    let train =
        "train moved.npz -o moved.sinew --predictor kernel --proxies 2 --record record.json";
    let run = folder.sinew(train);
    assert!(run.code == Some(0) && run.err.contains("leaves out the frames named here"), "{run:?}");
    let mut others = set.frames(0);
    others.retain(|frame| *frame != moved);
    assert_eq!(folder.json("record.json")["training_frames"], json!(others));
    let found = folder.sinew("eval moved.sinew moved.npz --split train --json").json();
    assert_eq!(found["read"], json!(others.len()));
}

#[test]
fn tables_are_aligned_for_names_in_every_script() {
    let folder = Folder::with_demo("check-cjk");
    let mut set = Set::demo();
    for (joint, name) in [(1, "鎖骨"), (3, "前腕のひねり・左"), (6, "e\u{301}paule")] {
        set.json["bone_names"][joint] = json!(name);
    }
    set.write(&folder.path("named.npz"));
    let even = |text: &str, from: &str| {
        let rows: Vec<&str> =
            text.lines().map(str::trim_start).skip_while(|line| !line.starts_with(from)).collect();
        let rows = &rows[..=set.joint_len()];
        assert!(rows.iter().any(|row| row.starts_with("鎖骨 ")), "{text}");
        let widths: Vec<usize> = rows.iter().map(|row| row.width()).collect();
        assert!(widths[1..].iter().all(|width| *width == widths[1]), "{text}{widths:?}");
    };
    even(&folder.sinew("check named.npz").done().out, "joint ");
    folder.sinew("train named.npz -o named.sinew --predictor kernel --proxies 2").done();
    even(&folder.sinew("inspect named.sinew").done().out, "joint ");
}

#[test]
fn a_check_prints_one_object_with_the_keys_promised() {
    let folder = Folder::with_demo("check-json");
    let found = folder.sinew("check demo.npz --json").json();
    let promised = ["advice", "curves", "faces", "findings", "joints", "lbs", "never_together"];
    assert_eq!(keys(&found), [&promised[..], &["predicted", "rest", "size"]].concat());
    assert_eq!(found["joints"].as_array().unwrap().len(), Set::demo().joint_len());
    assert_eq!(found["predicted"]["compared"], TRAINING);
    let lbs = folder.sinew("eval demo.sinew demo.npz --json --split train").json();
    let [a, b] = [&found["lbs"], &lbs["lbs"]].map(|lbs| lbs["rms_percent"].as_f64().unwrap());
    // The model stores weights in units of 1/65,535.
    assert!((a / b - 1.0).abs() < 1e-4, "{a} {b}");
}

#[test]
fn faults_are_reported_with_their_places_and_do_not_fail() {
    let folder = Folder::with_demo("check-faults");
    let mut set = Set::demo();
    set.wholes.get_mut("tris").unwrap().1[3 * 60..3 * 61].swap(0, 1);
    set.write(&folder.path("turned.npz"));
    let text = folder.sinew("check turned.npz").done().unwrapped();
    let warning = text.lines().find(|line| line.starts_with("  warning: ")).expect(&text);
    assert!(warning.contains("3 edges join") && warning.contains("at triangles 60, "), "{warning}");
    assert!(text.contains("\n1 warning, "), "{text}");
    let found = folder.sinew("check turned.npz --json").json();
    let finding = &found["findings"][0];
    assert_eq!((&finding["kind"], &finding["severity"]), (&json!("winding"), &json!("warning")));
    assert_eq!(finding["places"][0], json!({ "triangle": 60 }));
}

#[test]
fn examples_that_cannot_be_read_or_fitted_fail() {
    let folder = Folder::with_demo("check-bad");
    assert!(folder.sinew("check none.npz").failed().starts_with("none.npz: cannot be read"));
    let mut set = Set::demo();
    let train = set.frames(0);
    train.iter().skip(4).for_each(|&frame| set.wholes.get_mut("split").unwrap().1[frame] = 1);
    set.write(&folder.path("few.npz"));
    let line = folder.sinew("check few.npz").failed();
    assert_eq!(line, "few.npz: the fit needs 6 training poses, found 4");
}
