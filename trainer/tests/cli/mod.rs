//! Tests the command line's contract on the binary itself.

mod cases;
mod check;
mod common;
mod driven;
mod export;
mod face;
mod fit;
mod import;
mod kernel;
mod kernel_refused;
mod kernel_samples;
mod millimetres;
mod observations;
mod poses;
mod refusals;
mod report;
mod several;
mod signal;
mod skins;
mod tables;
mod views;

use common::{Folder, HELD_OUT, PROXIES, Set, TRAINING, read_npy};
use serde_json::{Value, json};
use sha2::{Digest, Sha256};

const TRAIN: &str = "train demo.npz -o new.sinew --proxies 2";

const ERRORS: [&str; 8] = [
    "rms",
    "rms_percent",
    "mean_percent",
    "p99_percent",
    "max_percent",
    "normal_rms_degrees",
    "normal_median_degrees",
    "normal_p99_degrees",
];

#[track_caller]
fn keys(value: &Value) -> Vec<&str> {
    let mut keys: Vec<_> = value.as_object().unwrap().keys().map(String::as_str).collect();
    keys.sort_unstable();
    keys
}

#[track_caller]
fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

fn close(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-9 * a.abs().max(b.abs())
}

#[test]
fn eval_prints_one_object_with_the_keys_promised() {
    let folder = Folder::with_demo("eval-json");
    let set = Set::demo();
    let found = folder.sinew("eval demo.sinew demo.npz --json").json();
    let mut promised = ["split", "frames", "vertices", "diagonal", "model_bytes", "predictor"]
        .into_iter()
        .chain(["proxies", "lbs", "confidence", "read", "regions"])
        .chain(ERRORS)
        .collect::<Vec<_>>();
    promised.sort_unstable();
    assert_eq!(keys(&found), promised);
    assert_eq!(found["split"], "held-out");
    assert_eq!(found["frames"], HELD_OUT);
    assert_eq!(found["vertices"], set.vertex_len());
    assert_eq!(found["model_bytes"], folder.read("demo.sinew").len());
    assert_eq!(
        found["predictor"],
        folder.sinew("inspect demo.sinew --json").json()["envelopes"][0]["predictor"]
    );
    assert_eq!(found["proxies"], PROXIES);
    let confidence = ["least", "mean"].map(|key| number(&found["confidence"][key]));
    assert!(0.0 <= confidence[0] && confidence[0] <= confidence[1] && confidence[1] <= 1.0);
    let rest = &set.reals["rest"].1;
    let extent = |axis: usize| {
        let along = rest.iter().skip(axis).step_by(3).copied();
        along.clone().fold(f64::MIN, f64::max) - along.fold(f64::MAX, f64::min)
    };
    let diagonal = (0..3).map(|axis| extent(axis).powi(2)).sum::<f64>().sqrt();
    assert!(close(number(&found["diagonal"]), diagonal));
    let mut names = ERRORS;
    names.sort_unstable();
    assert_eq!(keys(&found["lbs"]), names);
    for errors in [&found, &found["lbs"]] {
        let [rms, rms_percent, mean, p99, max, angle, median, angle_p99] =
            ERRORS.map(|key| number(&errors[key]));
        assert!(close(rms_percent, 100.0 * rms / diagonal));
        assert!(0.0 < mean && mean < rms_percent && rms_percent < p99 && p99 < max && max < 100.0);
        assert!(0.0 < median && median < angle && angle < angle_p99 && angle_p99 < 180.0);
    }
    assert_ne!(found["rms"], found["lbs"]["rms"]);
}

#[test]
fn eval_measures_the_split_that_is_asked_for() {
    let folder = Folder::with_demo("eval-splits");
    let mut set = Set::demo();
    for frame in set.frames(1).into_iter().take(5) {
        set.wholes.get_mut("split").unwrap().1[frame] = 2;
    }
    set.write(&folder.path("three.npz"));
    let mut squares = 0.0;
    for (split, frames) in [("train", TRAINING), ("held-out", HELD_OUT - 5), ("extreme", 5)] {
        let found =
            folder.sinew(&format!("eval demo.sinew three.npz --json --split {split}")).json();
        assert_eq!((&found["split"], &found["frames"]), (&json!(split), &json!(frames)));
        squares += number(&found["rms"]).powi(2) * frames as f64;
    }
    let found = folder.sinew("eval demo.sinew three.npz --json --split all").json();
    assert_eq!((&found["split"], &found["frames"]), (&json!("all"), &json!(TRAINING + HELD_OUT)));
    assert!(close(number(&found["rms"]).powi(2) * (TRAINING + HELD_OUT) as f64, squares));
}

#[test]
fn written_vertices_have_the_error_that_eval_prints() {
    let folder = Folder::with_demo("vertices");
    let set = Set::demo();
    let (v, truth) = (set.vertex_len(), &set.reals["vertices"].1);
    for (split, frames) in
        [("held-out", set.frames(1)), ("all", (0..TRAINING + HELD_OUT).collect())]
    {
        let command = format!("eval demo.sinew demo.npz --json --split {split}");
        let found = folder.sinew(&format!("{command} --write-vertices out.npy")).json();
        let (shape, numbers) = read_npy(&folder.read("out.npy"));
        assert_eq!(shape, [frames.len() as u64, v as u64, 3]);
        let squares: f64 = frames
            .iter()
            .zip(numbers.chunks_exact(3 * v))
            .flat_map(|(frame, found)| found.iter().zip(&truth[3 * v * frame..]))
            .map(|(&found, truth)| (f64::from(found) - truth).powi(2))
            .sum();
        let rms = (squares / (frames.len() * v) as f64).sqrt();
        assert!(close(rms, number(&found["rms"])), "{split}: {rms}");
    }
    assert_eq!(folder.list(), ["demo.json", "demo.npz", "demo.sinew", "out.npy"]);
}

#[test]
fn written_normals_have_the_angles_that_eval_prints() {
    let folder = Folder::with_demo("normals");
    let set = Set::demo();
    let frames = set.frames(1);
    let command = "eval demo.sinew demo.npz --json --write-normals out.npy";
    let found = folder.sinew(&format!("{command} --write-vertices at.npy")).json();
    let (shape, numbers) = read_npy(&folder.read("out.npy"));
    let v = set.vertex_len();
    assert_eq!(shape, [frames.len() as u64, v as u64, 3]);
    assert_eq!(read_npy(&folder.read("at.npy")).0, shape);
    let triangles = &set.wholes["tris"].1;
    let corners = || triangles.chunks_exact(3).map(|t| [0, 1, 2].map(|k| t[k] as usize));
    // Returns normals of a mesh's vertices, with a length of twice the surrounding area, and that
    // area.
    let directions = |points: &[f64]| {
        let (mut sums, mut areas) = (vec![[0.0; 3]; v], vec![0.0; v]);
        for triangle in corners() {
            let [a, b, c] = triangle.map(|vertex| &points[3 * vertex..]);
            let [p, q] = [b, c].map(|end| [0, 1, 2].map(|k| end[k] - a[k]));
            let cross = [0, 1, 2].map(|k| {
                let (i, j) = ((k + 1) % 3, (k + 2) % 3);
                p[i] * q[j] - p[j] * q[i]
            });
            for vertex in triangle {
                (0..3).for_each(|k| sums[vertex][k] += cross[k]);
                areas[vertex] += cross.iter().map(|x| x * x).sum::<f64>().sqrt();
            }
        }
        (sums, areas)
    };
    let areas = directions(&set.reals["rest"].1).1;
    let mut angles = Vec::new();
    for (frame, found) in frames.iter().zip(numbers.chunks_exact(3 * v)) {
        let truth = directions(&set.reals["vertices"].1[3 * v * frame..][..3 * v]).0;
        for (vertex, truth) in truth.iter().enumerate() {
            let own = [0, 1, 2].map(|k| f64::from(found[3 * vertex + k]));
            let dot = |a: &[f64; 3], b: &[f64; 3]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
            assert!((dot(&own, &own) - 1.0).abs() < 1e-5);
            let cosine = dot(&own, truth) / (dot(truth, truth) * dot(&own, &own)).sqrt();
            angles.push((cosine.clamp(-1.0, 1.0).acos().to_degrees(), areas[vertex]));
        }
    }
    angles.sort_by(|a, b| a.0.total_cmp(&b.0));
    let all: f64 = angles.iter().map(|angle| angle.1).sum();
    let squares: f64 = angles.iter().map(|(angle, area)| area * angle * angle).sum();
    let below = |share: f64| {
        let mut sum = 0.0;
        let within = angles.iter().take_while(|angle| {
            sum += angle.1;
            sum < share * all
        });
        angles[within.count()].0
    };
    let expected = [(squares / all).sqrt(), below(0.5), below(0.99)];
    // The arc cosine of a small angle has half the digits.
    for (key, expected) in ERRORS[5..].iter().zip(expected) {
        let found = number(&found[*key]);
        assert!((found - expected).abs() < 1e-4, "{key}: {found} {expected}");
    }
    let line =
        folder.sinew("eval demo.sinew demo.npz --write-normals a.npy --write-vertices a.npy");
    assert!(line.failed().ends_with("two outputs are one file"));
    assert!(!folder.list().contains(&"a.npy".to_owned()));
}

#[test]
fn the_record_holds_hashes_folds_candidates_and_the_choice() {
    let folder = Folder::with_demo("record");
    let set = Set::demo();
    let printed = folder.sinew(&format!("{TRAIN} --record record.json --json")).json();
    let record = folder.json("record.json");
    assert_eq!(printed, record);

    let hash = |name: &str| -> String {
        Sha256::digest(folder.read(name)).iter().map(|byte| format!("{byte:02x}")).collect()
    };
    let input = |name: &str| json!({ "file": name, "sha256": hash(name) });
    assert_eq!(record["inputs"], json!([input("demo.npz"), input("demo.json")]));
    assert_eq!(record["training_frames"], json!(set.frames(0)));
    assert_eq!(record["held_out_frames"], json!(set.frames(1)));
    assert_eq!(record["extreme_frames"], json!([]));
    assert_eq!(record["vertices"], set.vertex_len());
    assert_eq!(record["joints"], set.joint_len());
    assert_eq!(record["proxies"], 2);
    let asked = json!({
        "predictor": null, "proxies": 2, "helper_kind": "affine", "max_error": null,
        "influences": 4, "unrefined": false, "published": false, "budget": null,
    });
    assert_eq!(record["options"], asked);
    assert_eq!(record["model_bytes"], folder.read("new.sinew").len());

    let report = &record["report"];
    let folds = report["folds"].as_array().unwrap().iter();
    let poses: Vec<_> = folds.flat_map(|fold| fold.as_array().unwrap()).cloned().collect();
    assert_eq!(poses, Vec::from_iter((0..TRAINING).map(Value::from)));
    let candidates = report["candidates"].as_array().unwrap();
    let mut kinds: Vec<_> = candidates.iter().map(|c| c["predictor"].as_str().unwrap()).collect();
    kinds.dedup();
    assert_eq!(kinds, ["kernel"]);
    let score = |candidate: &Value| number(&candidate["validated_rms"]);
    let chosen = &candidates[report["chosen"].as_u64().unwrap() as usize];
    assert!(candidates.iter().all(|candidate| score(candidate) >= score(chosen)));
    assert_eq!(record["predictor"], chosen["predictor"]);
    assert_eq!(chosen["bytes"], record["model_bytes"]);
    for candidate in candidates {
        let groups = candidate["groups"].as_array().unwrap();
        assert_eq!(groups.is_empty(), candidate["predictor"] == "rotational");
    }
}

#[test]
fn inspect_accounts_for_every_byte_and_repeats_the_record() {
    let folder = Folder::with_demo("inspect");
    let record = folder.sinew(&format!("{TRAIN} --json")).json();
    let found = folder.sinew("inspect new.sinew --json").json();
    let sections = found["sections"].as_array().unwrap();
    let bytes = |value: &Value| value.as_u64().unwrap();
    let sum: u64 = sections.iter().map(|section| bytes(&section["bytes"])).sum();
    assert_eq!(sum + bytes(&found["other_bytes"]), folder.read("new.sinew").len() as u64);
    assert_eq!(found["bytes"], record["model_bytes"]);
    let (envelope, skin) = (&found["envelopes"][0], &found["skins"][0]);
    assert_eq!((&envelope["proxies"], &skin["vertices"]), (&json!(2), &record["vertices"]));
    for (in_file, in_record) in [
        ("diagonal", &record["diagonal"]),
        ("training_rms", &record["report"]["training_rms"]),
        ("same_clips_rms", &record["report"]["same_clips_rms"]),
        ("lbs_training_rms", &record["report"]["lbs_rms"]),
    ] {
        let unit = if in_file == "diagonal" { 1.0 } else { number(&record["diagonal"]) };
        let found = number(&envelope["certificate"][in_file]) as f32;
        let expected = (unit * number(in_record)) as f32;
        assert!((found / expected - 1.0).abs() < 1e-6, "{in_file}");
    }
    let text = folder.sinew("inspect new.sinew").done().out;
    for section in sections {
        let [kind, element] = ["kind", "element"].map(|key| section[key].as_str().unwrap());
        let part = ["envelope \"envelope\"", "skin \"skin\"", "record \"envelope\""]
            [bytes(&section["part"]) as usize];
        let own = |line: &&str| line.starts_with(&format!("{kind} ")) && line.contains(part);
        let row = text.lines().find(own).unwrap();
        assert!(row.contains(&format!(" {element} ")), "{row}");
        assert!(row.ends_with(&format!(" {}", section["bytes"])), "{row}");
    }
    let joint = envelope["joints"][1]["name"].as_str().unwrap();
    assert!(text.contains("certificate") && text.contains(joint), "{text}");
}

#[test]
fn hold_out_takes_blocks_and_replaces_the_split() {
    let folder = Folder::with_demo("hold-out");
    let record = folder.sinew(&format!("{TRAIN} --hold-out 0.25 --json")).json();
    let frames = |key: &str| -> Vec<u64> {
        record[key].as_array().unwrap().iter().map(|frame| frame.as_u64().unwrap()).collect()
    };
    let (train, held_out) = (frames("training_frames"), frames("held_out_frames"));
    let mut all = [train, held_out.clone()].concat();
    all.sort_unstable();
    assert_eq!(all, Vec::from_iter(0..(TRAINING + HELD_OUT) as u64));
    let blocks = 1 + held_out.windows(2).filter(|pair| pair[1] != pair[0] + 1).count();
    assert_eq!(blocks, 5);
    assert!((11..=15).contains(&held_out.len()), "{held_out:?}");
    assert_eq!(record["hold_out"], 0.25);
    let found = folder.sinew("eval new.sinew demo.npz --hold-out 0.25 --json").json();
    assert_eq!(found["frames"], held_out.len());
}

#[test]
fn training_gives_the_same_bytes_for_any_number_of_threads() {
    let folder = Folder::with_demo("threads");
    let run = |threads: &str| {
        let mut command = folder.command(&format!("{TRAIN} --record record.json"));
        command.env("RAYON_NUM_THREADS", threads);
        folder.run(command).done();
        (folder.read("new.sinew"), folder.read("record.json"))
    };
    assert!(run("1") == run("3"));
    assert!(run("1").0 != folder.read("demo.sinew"));
}

#[test]
fn warnings_go_to_standard_error_unless_quiet() {
    let folder = Folder::with_demo("quiet");
    let mut set = Set::demo();
    set.json["bone_parents"][3] = json!(-1);
    set.write(&folder.path("roots.npz"));
    let warning = "sinew: warning: roots.npz: 2 joints have no parent: chest is the root, and the model has upper_arm_twist under it; where that is wrong, put all of them under one joint\n";
    for command in [
        "train roots.npz -o new.sinew --proxies 2",
        "eval demo.sinew roots.npz",
        "eval demo.sinew roots.npz --json",
    ] {
        let loud = folder.sinew(command);
        assert_eq!((loud.code, loud.err.as_str()), (Some(0), warning));
        let quiet = folder.sinew(&format!("{command} --quiet")).done();
        assert!(!quiet.out.is_empty() && quiet.out == loud.out);
    }
    let failed = folder.sinew("train none.npz -o new.sinew --quiet").failed();
    assert!(failed.starts_with("none.npz: "), "{failed}");
}

#[test]
fn meshes_that_skinning_makes_are_warned_of() {
    let folder = Folder::with_demo("nothing");
    let mut set = Set::demo();
    let (vertex_len, joint_len) = (set.vertex_len(), set.joint_len());
    let maps = set.reals["bone_transforms"].1.clone();
    let rest = set.reals["rest"].1.clone();
    let posed = &mut set.reals.get_mut("vertices").unwrap().1;
    for (place, x) in posed.chunks_mut(3).enumerate() {
        let (frame, vertex) = (place / vertex_len, place % vertex_len);
        // Vertices beyond the elbow follow the hand.
        let from = &rest[3 * vertex..][..3];
        let joint = if from[0] > 0.3 { joint_len - 1 } else { 0 };
        let map = &maps[16 * (frame * joint_len + joint)..];
        for axis in 0..3 {
            let row = &map[4 * axis..];
            x[axis] = row[0] * from[0] + row[1] * from[1] + row[2] * from[2] + row[3];
        }
    }
    set.write(&folder.path("plain.npz"));
    let train = "train plain.npz -o plain.sinew --predictor kernel --proxies 2";
    let run = folder.sinew(train);
    let expected = "sinew: warning: plain.npz: linear blend skinning gives these meshes to within ";
    assert!(run.code == Some(0) && run.err.starts_with(expected), "{}", run.err);
    assert_eq!(run.err.lines().count(), 1, "{}", run.err);
    let record = folder.sinew(&format!("{train} --quiet --json")).json();
    assert_eq!(record["warnings"].as_array().unwrap().len(), 1);
    // For a scene, the notice comes while reading.
    folder.sinew("export-demo . --vertices 200 --poses 20 --held-out 5").done();
    let run = folder.sinew("train demo.glb -o glb.sinew --predictor kernel --proxies 2");
    assert!(run.err.contains("nothing to learn") && run.err.lines().count() == 1, "{}", run.err);
}

#[test]
fn the_demo_trains_and_measures_as_the_other_commands_do() {
    let folder = Folder::with_demo("demo-same");
    let sizes = format!("--poses {TRAINING} --held-out {HELD_OUT} --proxies {PROXIES}");
    let found = folder.sinew(&format!("demo --vertices 300 {sizes} --json")).json();
    let trained =
        folder.sinew(&format!("train demo.npz -o new.sinew --proxies {PROXIES} --json")).json();
    assert_eq!(found["report"], trained["report"]);
    assert_eq!(folder.read("new.sinew"), folder.read("demo.sinew"));
    assert_eq!(found["evaluation"], folder.sinew("eval new.sinew demo.npz --json").json());
    let text = folder.sinew("eval new.sinew demo.npz").done().out;
    assert!(text.contains("LBS, fitted") && text.contains(", 4 helpers"), "{text}");
}

#[test]
fn triangles_without_area_are_listed_by_number() {
    let folder = Folder::with_demo("zero-area");
    let mut set = Set::demo();
    let corners = &mut set.wholes.get_mut("tris").unwrap().1;
    corners[3 * 17 + 1] = corners[3 * 17];
    set.write(&folder.path("bad.npz"));
    let run = folder.sinew("train bad.npz -o new.sinew --proxies 2");
    assert_eq!(run.code, Some(0));
    assert_eq!(
        run.err,
        "sinew: warning: bad.npz: triangles that name a vertex twice are left out of the fit: 17\n"
    );
}

#[test]
fn names_from_a_file_cannot_steer_the_terminal() {
    let folder = Folder::with_demo("names");
    let mut set = Set::demo();
    set.json["bone_names"][1] = json!("a\n\u{1b}[2Jb");
    set.write(&folder.path("named.npz"));
    folder.sinew("train named.npz -o new.sinew --proxies 2").done();
    let text = folder.sinew("inspect new.sinew").done().out;
    assert!(text.contains("\n  a\\n\\u{1b}[2Jb "), "{text}");
    let line = folder.sinew("eval new.sinew demo.npz").failed();
    let expected = "new.sinew: joint 1 is called a\\n\\u{1b}[2Jb in the model, clavicle in the \
                    examples";
    assert_eq!(line, expected);
}
