//! Choices of `train`: predictors, their errors, and file sizes; and the table row of the mesh's
//! own joint weights.

use super::cases::with_cases;
use super::common::{Folder, Run, Set};
use super::number;
use serde_json::{Value, json};

#[test]
fn each_predictor_can_be_asked_for_and_the_file_keeps_to_its_budget() {
    let folder = Folder::with_demo("predictors");
    for predictor in ["rotational", "kernel"] {
        let train = format!("-q train demo.npz -o new.sinew --predictor {predictor} --proxies 4");
        let free = folder.sinew(&format!("{train} --json")).json();
        assert_eq!(free["predictor"], predictor);
        let candidates = free["report"]["candidates"].as_array().unwrap();
        assert!(candidates.iter().all(|candidate| candidate["predictor"] == predictor));
        let found = folder.sinew("eval new.sinew demo.npz --json").json();
        // With fewer proxies than joints, the rotational predictor cannot replace the joints.
        let better = number(&found["rms"]) < number(&found["lbs"]["rms"]);
        assert!(better || predictor != "kernel", "{predictor}: {found}");
        assert!(folder.sinew("inspect new.sinew").done().out.contains(predictor));
        let bytes = free["model_bytes"].as_u64().unwrap();
        if predictor == "rotational" {
            continue;
        }
        let budget = bytes - 200;
        let tight = folder.sinew(&format!("{train} --budget {budget} --json")).json();
        assert!(tight["model_bytes"].as_u64().unwrap() <= budget, "{predictor}");
        assert_eq!(folder.read("new.sinew").len() as u64, tight["model_bytes"].as_u64().unwrap());
    }
    let before = folder.read("new.sinew");
    let line = folder.sinew("train demo.npz -o new.sinew --budget 1000").failed();
    let expected = "demo.npz: a budget of 1000 bytes is too small: skeleton and mesh alone take ";
    let least = line.strip_prefix(expected).and_then(|least| least.parse().ok());
    let least: usize = least.expect(&line);
    let line = folder.sinew(&format!("train demo.npz -o new.sinew --budget {least}")).failed();
    let expected = format!(
        "demo.npz: a budget of {least} bytes is too small: the smallest model that was tried takes "
    );
    assert!(line.starts_with(&expected), "{line}");
    assert_eq!(folder.read("new.sinew"), before);
}

#[test]
fn the_published_method_is_rotational_and_refuses_other_options() {
    let folder = Folder::with_demo("published");
    let train = "-q train demo.npz -o new.sinew --published";
    let found = folder.sinew(&format!("{train} --proxies 4 --json")).json();
    assert_eq!(
        (&found["predictor"], &found["options"]["published"]),
        (&json!("rotational"), &json!(true))
    );
    let candidates = found["report"]["candidates"].as_array().unwrap();
    let tried: Vec<_> = candidates.iter().map(|candidate| &candidate["method"]).collect();
    assert_eq!(tried, [&json!("published")]);
    // 4 proxies and the joints, which near-rigid vertices follow.
    assert_eq!(found["proxies"], 4 + Set::demo().joint_len());
    let same = folder.sinew(&format!("{train} --predictor rotational --proxies 4 --json")).json();
    assert_eq!(same["report"], found["report"]);
    let before = folder.read("new.sinew");
    for (more, expected) in [
        ("--predictor kernel", "--published is a way to fit --predictor rotational, and no other"),
        (
            "--proxies 513",
            "--published: a file has room for 512 helpers, since each takes the room of two",
        ),
    ] {
        assert_eq!(folder.sinew(&format!("{train} {more}")).failed(), expected);
    }
    let both = folder.sinew(&format!("{train} --unrefined"));
    assert!(both.err.contains("'--published' cannot be used with '--unrefined'"), "{}", both.err);
    assert_eq!(folder.read("new.sinew"), before);
}

#[test]
fn helpers_are_of_the_kind_that_the_command_names() {
    let folder = Folder::with_demo("kinds");
    let train = "train demo.npz --helpers 8 -o new.sinew --json --helper-kind";
    for kind in ["affine", "trs", "rigid"] {
        let found = folder.sinew(&format!("{train} {kind}")).json();
        assert_eq!(found["options"]["helper_kind"], kind);
        let [rms, largest] = ["rms", "largest"].map(|key| number(&found["report"]["bones"][key]));
        assert_eq!(rms > 1e-9, kind == "affine", "{rms}");
        let envelope = &folder.sinew("inspect new.sinew --json").json()["envelopes"][0];
        assert_eq!(envelope["helper_kind"], kind);
        let certificate = &envelope["certificate"];
        let stated = number(&certificate["trs_error"]) / number(&certificate["diagonal"]);
        assert!((stated - largest).abs() <= 1e-5 * largest + 1e-12, "{stated} {largest}");
        let text =
            folder.sinew(&format!("train demo.npz --helpers 8 -o new.sinew --helper-kind {kind}"));
        assert!(text.out.contains("helpers as bones (TRS)"), "{}", text.out);
    }
    let before = folder.read("new.sinew");
    let line = folder.sinew(&format!("{train} trs --predictor rotational")).failed();
    assert!(line.contains("helpers of kind trs need the predictor kernel"), "{line}");
    assert_eq!(folder.read("new.sinew"), before);
}

#[test]
fn auto_falls_back_to_the_joints_alone_where_bytes_are_few() {
    let folder = Folder::with_demo("joints-alone");
    let free = folder.sinew("train demo.npz -o free.sinew --json").json();
    let candidates = free["report"]["candidates"].as_array().unwrap();
    let proxies = |candidate: &Value| candidate["proxies"].as_u64().unwrap();
    assert_eq!((proxies(&candidates[0]), candidates[0]["predictor"].as_str()), (0, Some("kernel")));
    // 20 proxies need no trial, because 80 are better than 40.
    assert_eq!(candidates.iter().map(proxies).collect::<Vec<_>>(), [0, 40, 80]);
    assert_eq!(proxies(&candidates[free["report"]["chosen"].as_u64().unwrap() as usize]), 80);

    // Under a budget, the training record is dropped before accuracy is.
    let inspected = folder.sinew("inspect free.sinew --json").json();
    let is_record = |section: &&Value| section["part"] == 2;
    let record_bytes = inspected["sections"].as_array().unwrap().iter().filter(is_record);
    let record_bytes: u64 = record_bytes.map(|section| section["bytes"].as_u64().unwrap()).sum();
    let budget = candidates[0]["bytes"].as_u64().unwrap() - record_bytes;
    let few = folder.sinew(&format!("-q train demo.npz -o few.sinew --budget {budget} --json"));
    let few = few.json();
    let tried: Vec<_> =
        few["report"]["candidates"].as_array().unwrap().iter().map(proxies).collect();
    assert!([10, 20, 40, 80].iter().all(|count| tried.contains(count)), "{tried:?}");
    assert!(folder.read("few.sinew").len() as u64 <= budget);
    assert_eq!(folder.sinew("inspect few.sinew --json").json()["envelopes"][0]["proxies"], 0);
    let found = folder.sinew("eval few.sinew demo.npz --json").json();
    let [model, lbs] = [&found, &found["lbs"]].map(|errors| number(&errors["rms"]));
    assert!((model / lbs - 1.0).abs() < 1e-3, "{model} {lbs}");
}

#[test]
fn max_error_takes_the_fewest_proxies_that_meet_it() {
    let folder = Folder::with_demo("max-error");
    let share = |record: &Value| 100.0 * number(&record["report"]["rotational"]["proxy_rms"]);
    let train = "-q train demo.npz --predictor rotational --json -o";
    let met = folder.sinew(&format!("{train} new.sinew --max-error 2")).json();
    assert!(share(&met) <= 2.0);
    let fewer = met["proxies"].as_u64().unwrap() - 1;
    let missed = format!("{train} fewer.sinew --proxies {fewer}");
    assert!(share(&folder.sinew(&missed).json()) > 2.0);

    let helped = "train demo.npz -o helped.sinew --predictor kernel --max-error 0.1 --json";
    let helpers = folder.sinew(helped).json()["proxies"].as_u64().unwrap();
    assert!(helpers >= 4 && (helpers / 4).is_power_of_two(), "{helpers}");

    let mut set = Set::demo();
    let (shape, corners) = set.wholes.get_mut("tris").unwrap();
    shape[0] = 8;
    corners.truncate(24);
    set.write(&folder.path("few.npz"));
    let line = folder.sinew("train few.npz -o none.sinew --max-error 1e-9").failed();
    assert!(line.starts_with("few.npz: 0.000000001 % is out of reach: 8 helpers"), "{line}");
    assert!(!folder.path("none.sinew").exists());
}

/// Writes a demo whose joint weights bind the whole skin to the root.
fn on_the_root(folder: &Folder) -> Set {
    let mut set = Set::demo();
    let (vertex_len, joint_len) = (set.vertex_len(), set.joint_len());
    let weights = (0..vertex_len * joint_len).map(|k| if k % joint_len == 0 { 0.5 } else { 0.0 });
    let shape = vec![vertex_len as u64, joint_len as u64];
    set.reals.insert("joint_weights", (shape, weights.collect()));
    set.write(&folder.path("own.npz"));
    set
}

/// Returns the RMS error of a mesh that follows the root, over the frames with a code of the split,
/// in % of the diagonal.
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

/// Asserts one row of own weights in a table of errors, right below the row of LBS.
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

/// The expected errors on the clips of a biped come from another program.
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
