//! Curves of a scene, from its file to a model and back.

use super::{Glb, moments, off, refused, run, with_cases};
use crate::cli::common::Folder;
use serde_json::{Value, json};

/// Number of frames, at 24 a second.
const FRAMES: usize = 72;

/// Weight of the shape in a frame. The joints move at another pace.
fn weight(frame: usize) -> f32 {
    0.5 - 0.5 * (0.41 * frame as f32).cos()
}

/// Changes the plain tube: the joint `mid` bends, and a bulge has the weight [`weight`]. The shape of the tube has no
/// name; a mesh without a skin has the shape `puff` of the same weights.
fn bulging(folder: &Folder) -> Glb {
    let mut glb = Glb::read(folder, "plain.glb");
    let positions = glb.values(&json!(0));
    let bulge: Vec<f32> = positions
        .chunks(3)
        .flat_map(|x| {
            let by = 0.4 * (-6.0 * (x[1] - 1.2).powi(2)).exp();
            [by * x[0], 0.0, by * x[2]].map(|x| x as f32)
        })
        .collect();
    let bulge = glb.floats("VEC3", 3, &bulge);
    let mut control = glb.json["meshes"][0].clone();
    let targets = json!([{ "POSITION": bulge }]);
    glb.json["meshes"][0]["primitives"][0]["targets"] = targets.clone();
    control["primitives"] =
        json!([{ "attributes": { "POSITION": 0 }, "indices": 1, "targets": targets }]);
    control["extras"] = json!({ "targetNames": ["puff"] });
    glb.json["meshes"].as_array_mut().unwrap().push(control);
    glb.json["nodes"].as_array_mut().unwrap().push(json!({ "name": "control", "mesh": 1 }));
    glb.json["scenes"][0]["nodes"] = json!([4, 5]);
    let times: Vec<f32> = (0..FRAMES).map(|frame| frame as f32 / 24.0).collect();
    let turns: Vec<f32> = (0..FRAMES)
        .flat_map(|frame| {
            let half = 0.4 * (0.23 * frame as f32).sin();
            [half.sin(), 0.0, 0.0, half.cos()]
        })
        .collect();
    let weights: Vec<f32> = (0..FRAMES).map(weight).collect();
    let times = glb.floats("SCALAR", 1, &times);
    let [turns, weights] = [glb.floats("VEC4", 4, &turns), glb.floats("SCALAR", 1, &weights)];
    let channel = |sampler: usize, node: usize, path: &str| json!({ "sampler": sampler, "target": { "node": node, "path": path } });
    glb.json["animations"] = json!([{
        "name": "breathe",
        "samplers": [{ "input": times, "output": turns }, { "input": times, "output": weights }],
        "channels": [channel(0, 1, "rotation"), channel(1, 3, "weights"), channel(1, 5, "weights")],
    }]);
    glb
}

/// Trains the scene, without its last quarters of runs, and returns the held-out error in % of the diagonal.
#[track_caller]
fn held_out(folder: &Folder, options: &str) -> f64 {
    let options = format!("bulging.glb --hold-out 0.25 {options}");
    run(folder, &format!("-q train {options} -o m.sinew"));
    let found = run(folder, &format!("-q eval m.sinew {options} --json")).out;
    let found: Value = serde_json::from_str(&found).unwrap();
    found["rms_percent"].as_f64().unwrap()
}

#[test]
fn morph_weights_drive_a_skin() {
    let Some(folder) = with_cases("curves", &["gltf/plain.glb"]) else { return };
    let glb = bulging(&folder);
    glb.write(&folder, "bulging.glb");
    let rows = (0..FRAMES).map(|frame| format!("{},{}\n", weight(frame), frame % 7));
    let table: String = ["puff,noise\n".to_owned()].into_iter().chain(rows).collect();
    std::fs::write(folder.path("take.csv"), &table).unwrap();
    let short = table.lines().take(FRAMES).collect::<Vec<_>>().join("\n");
    std::fs::write(folder.path("short.csv"), short).unwrap();

    let without = held_out(&folder, "");
    let of_table = held_out(&folder, "--curves-from take.csv --curve puff");
    let with = held_out(&folder, "--curves all");
    assert!(without > 0.3 && with < 0.05 * without, "{with} with the curve, {without} without");
    // The same numbers make the same model.
    assert!((of_table / with - 1.0).abs() < 1e-3, "{of_table} from the table, {with}");
    // The exported file plays the curve of the scene, or of the table.
    for curves in ["", "--curves-from take.csv"] {
        run(&folder, &format!("-q export m.sinew --clip bulging.glb {curves} -o out.glb"));
        let played = Glb::read(&folder, "out.glb");
        let off = off((&glb, "tube", 0), (&played, "tube", 0));
        assert!(off < 0.3 && moments(&played, 0).len() >= FRAMES, "{curves}: {off}");
    }
    for (command, words) in [
        ("eval m.sinew bulging.glb", "the model follows curve puff, which the examples lack"),
        ("train bulging.glb --curve huff -o n.sinew", "there is no curve huff: it has puff"),
        ("train plain.glb --curves all -o n.sinew", "plain.glb: has no curve: no mesh has a shape"),
        (
            "train bulging.glb --curves-from short.csv -o n.sinew",
            "short.csv: has 71 rows, the scene's clips have 72 frames (breathe: 72): give a row",
        ),
        (
            "train bulging.glb plain.glb --curves-from short.csv -o n.sinew",
            "--curves-from: expected one for each scene in order: 2, found 1",
        ),
        ("export m.sinew --clip plain.glb -o o.glb", "there is no curve puff: it has none"),
    ] {
        let line = refused(&folder, command);
        assert!(line.contains(words), "{command}: {line}");
    }
}
