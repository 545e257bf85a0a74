//! Further meshes in addition to the tube of `gltf/plain.glb`, in every format.

use super::glb::Glb;
use super::with_cases;
use crate::cli::common::{Folder, Run};
use nalgebra::Vector3;
use serde_json::{Value, json};
use std::fmt::Write;

/// Runs a command with arguments that contain spaces.
fn sinew(folder: &Folder, arguments: &str, last: &[&str]) -> Run {
    let mut command = folder.command(arguments);
    command.args(last);
    folder.run(command)
}

#[track_caller]
fn run(folder: &Folder, arguments: &str, last: &[&str]) -> Run {
    let run = sinew(folder, arguments, last);
    assert_eq!(run.code, Some(0), "{arguments}: {}", run.err);
    run
}

/// Returns the tube's positions and the corners of its triangles.
fn tube(folder: &Folder) -> (Vec<f64>, Vec<f64>) {
    let glb = Glb::read(folder, "plain.glb");
    let primitive = &glb.json["meshes"][0]["primitives"][0];
    (glb.values(&primitive["attributes"]["POSITION"]), glb.values(&primitive["indices"]))
}

/// Writes the tube, transformed by `moved`, as lod.obj, lod.glb without a skin, and lod.fbx.
fn write(folder: &Folder, moved: impl Fn(&[f64]) -> [f64; 3]) {
    let (positions, corners) = tube(folder);
    let positions: Vec<[f64; 3]> = positions.chunks(3).map(moved).collect();
    let mut obj = String::new();
    positions.iter().for_each(|[x, y, z]| writeln!(obj, "v {x} {y} {z}").unwrap());
    for face in corners.chunks(3) {
        writeln!(obj, "f {} {} {}", face[0] + 1.0, face[1] + 1.0, face[2] + 1.0).unwrap();
    }
    std::fs::write(folder.path("lod.obj"), obj).unwrap();

    let mut glb = Glb::read(folder, "plain.glb");
    let single: Vec<f32> = positions.as_flattened().iter().map(|&x| x as f32).collect();
    let places = glb.floats("VEC3", 3, &single);
    glb.json["meshes"][0]["primitives"][0]["attributes"] = json!({ "POSITION": places });
    glb.json["nodes"][3].as_object_mut().unwrap().remove("skin");
    glb.json.as_object_mut().unwrap().remove("skins");
    glb.json.as_object_mut().unwrap().remove("animations");
    glb.write(folder, "lod.glb");

    let list = |all: Vec<String>| format!("*{} {{\na: {}\n}}\n", all.len(), all.join(","));
    let places = list(positions.as_flattened().iter().map(f64::to_string).collect());
    // The last corner of a face is stored as its complement.
    let corner = |(place, &v): (usize, &f64)| if place % 3 == 2 { -v - 1.0 } else { v }.to_string();
    let corners = list(corners.iter().enumerate().map(corner).collect());
    let fbx = format!(
        "; FBX 7.4.0 project file\nFBXHeaderExtension: {{\nFBXVersion: 7400\n}}\n\
         Objects: {{\nModel: 1, \"Model::lod\", \"Mesh\" {{\n}}\n\
         Geometry: 2, \"Geometry::\", \"Mesh\" {{\nVertices: {places}PolygonVertexIndex: {corners}}}\n}}\n\
         Connections: {{\nC: \"OO\",1,0\nC: \"OO\",2,1\n}}\n"
    );
    std::fs::write(folder.path("lod.fbx"), fbx).unwrap();
}

/// Returns the largest distance between the tube and its further mesh while a clip plays.
fn apart(folder: &Folder, clip: usize) -> f64 {
    let played = Glb::read(folder, "out.glb");
    let at = |mesh: &str, time| played.posed(mesh, Some((clip, time)));
    let times = played.times(clip, 0);
    let distance = |&time: &f64| {
        let pairs = at("tube", time).into_iter().zip(at("lod", time));
        pairs.map(|(a, b): (Vector3<f64>, Vector3<f64>)| (a - b).norm()).fold(0.0, f64::max)
    };
    times.iter().map(distance).fold(0.0, f64::max)
}

#[test]
fn a_further_mesh_is_read_from_every_format_and_goes_into_an_artist_s_file_too() {
    let Some(folder) = with_cases("also", &["gltf/plain.glb"]) else { return };
    write(&folder, |x| [x[0], x[1], x[2]]);
    for file in ["lod.obj", "lod.glb", "lod.fbx"] {
        // FBX files are in centimetres.
        if file == "lod.fbx" {
            write(&folder, |x| [100.0 * x[0], 100.0 * x[1], 100.0 * x[2]]);
        }
        let train =
            format!("-q train --predictor kernel plain.glb --also {file} -o m.sinew --json");
        let record: Value = serde_json::from_str(&run(&folder, &train, &[]).out).unwrap();
        let level = &record["levels"][0];
        assert_eq!((&level["name"], &level["vertices"]), (&json!("lod"), &json!(132)), "{file}");
        assert!(level["distance_percent"].as_f64().unwrap() < 1e-3, "{file}: {level}");
        assert!(level["fitted_percent"].as_f64().unwrap() < 0.01, "{file}: {level}");
        for (into, clip) in [("", 0), ("--into plain.glb", 1)] {
            let export =
                format!("-q export m.sinew --clip plain.glb --also {file} {into} -o out.glb");
            let report = run(&folder, &format!("{export} --json"), &[]).out;
            let report: Value = serde_json::from_str(&report).unwrap();
            assert_eq!(report["levels"][0]["name"], "lod", "{file} {into}");
            let apart = apart(&folder, clip);
            assert!(apart < 1e-3, "{file} {into}: {apart}");
        }
    }
    for (file, words) in [
        ("m.sinew", "m.sinew: is a baked model"),
        ("none.glb", "none.glb: cannot be read"),
        ("plain.blend", "plain.blend: is a Blender scene"),
        ("plain.ply", "expected a file that ends in .obj, .glb, .gltf or .fbx, found .ply"),
    ] {
        std::fs::write(folder.path("plain.ply"), "ply\n").unwrap();
        let train = format!("-q train plain.glb --also {file} -o n.sinew");
        let line = sinew(&folder, &train, &[]).err;
        assert!(line.contains(words), "{line}");
    }
}

#[test]
fn an_ambiguous_orientation_is_refused_before_training_and_settled_by_an_option() {
    let Some(folder) = with_cases("also-axes", &["gltf/plain.glb"]) else { return };
    // Along z and in centimetres: the tube is almost round, so its orientation is ambiguous.
    write(&folder, |x| [100.0 * x[0], -100.0 * x[2], 100.0 * x[1]]);
    run(&folder, "-q train --predictor kernel plain.glb -o plain.sinew", &[]);
    for file in ["lod.obj", "lod.glb"] {
        let train = format!("-q train --predictor kernel plain.glb --also {file} -o m.sinew");
        // No training can meet this budget; its refusal comes after the training.
        let line = sinew(&folder, &format!("{train} --budget 10"), &[]).err;
        let words = "mesh lod is not in the model's axes and unit: turned to ";
        assert!(line.contains(words), "{line}");
        assert!(line.contains("give one of these, as --also-axes \"("), "{line}");
        assert!(!folder.path("m.sinew").exists());
        for axes in ["(x, z, -y) x 0.01", "x z -y 0.01", "(x,z,-y)x0.01"] {
            run(&folder, &train, &["--also-axes", axes]);
            for (into, clip) in [("", 0), ("--into plain.glb", 1)] {
                let export = format!(
                    "-q export plain.sinew --clip plain.glb --also {file} {into} -o out.glb"
                );
                let line = sinew(&folder, &export, &[]).err;
                assert!(line.contains(words), "{line}");
                run(&folder, &export, &["--also-axes", axes]);
                let apart = apart(&folder, clip);
                assert!(apart < 1e-3, "{file} {into}: {apart}");
            }
        }
        std::fs::remove_file(folder.path("m.sinew")).unwrap();
    }
    let train = "-q train plain.glb --also lod.obj -o m.sinew";
    for axes in ["x y", "(x, x, y)", "(x, y, z) x 0", "(x, y, w)"] {
        let run = sinew(&folder, train, &["--also-axes", axes]);
        assert!(
            run.code == Some(2) && run.err.contains("(x, -z, y) x 0.01"),
            "{axes}: {}",
            run.err
        );
    }
    let two = ["--also-axes", "x y z", "--also-axes", "x y z"];
    let line = sinew(&folder, &train.replace("-o", "--also lod.glb --also lod.fbx -o"), &two).err;
    assert!(
        line.contains("--also-axes: expected one for all meshes or one for each of 3, found 2")
    );
}

#[test]
fn axes_that_are_given_and_do_not_fit_are_named() {
    let Some(folder) = with_cases("also-given", &["gltf/plain.glb"]) else { return };
    run(&folder, "-q train --predictor kernel plain.glb -o plain.sinew", &[]);
    write(&folder, |x| [100.0 * x[0], 100.0 * x[1], 100.0 * x[2]]);
    for command in [
        "-q train --predictor kernel plain.glb --also lod.obj -o m.sinew",
        "-q export plain.sinew --clip plain.glb --also lod.obj -o out.glb",
    ] {
        for axes in ["(x, y, z)", "(x,z,-y)x0.1"] {
            let line = sinew(&folder, command, &["--also-axes", axes]).err;
            let expected = "in the axes and unit given as --also-axes, expected at most 10 % at the median: give \
                            others, or leave --also-axes out";
            assert!(line.starts_with("sinew: mesh lod is ") && line.contains(expected), "{line}");
        }
        run(&folder, command, &["--also-axes", "(x,y,z)x0.01"]);
    }
}

#[test]
fn a_mesh_that_is_not_the_character_s_is_warned_of_by_its_distance() {
    let Some(folder) = with_cases("also-other", &["gltf/plain.glb"]) else { return };
    let (positions, _) = tube(&folder);
    let scale = |about: f64, by: f64| move |x: f64| about + (x - about) * by;
    let middle = |axis: usize| {
        let all = positions.iter().skip(axis).step_by(3).copied();
        0.5 * (all.clone().fold(f64::MAX, f64::min) + all.fold(f64::MIN, f64::max))
    };
    let [x, y, z] = [0, 1, 2].map(middle);
    let distance = |is_warned: bool| {
        let train = "train --predictor kernel plain.glb --also lod.obj -o m.sinew";
        let run = run(&folder, train, &[]);
        let message: Vec<&str> =
            run.err.lines().filter(|line| line.contains("lod.obj: ")).collect();
        let record = sinew(&folder, &format!("-q {train} --json"), &[]).out;
        let record: Value = serde_json::from_str(&record).unwrap();
        let percent = record["levels"][0]["distance_percent"].as_f64().unwrap();
        assert_eq!(message.len(), usize::from(is_warned), "{percent}: {}", run.err);
        if let [line] = message[..] {
            let expected = format!("half of its vertices are more than {percent:.1} % (");
            assert!(line.contains(&expected) && line.contains(" mm) of the diagonal"), "{line}");
        }
        percent
    };
    // The same surface, a garment around it, and a mesh of half the size.
    write(&folder, |p| [p[0], p[1], p[2]]);
    assert!(distance(false) < 1e-3);
    write(&folder, |p| [scale(x, 1.1)(p[0]), p[1], scale(z, 1.1)(p[2])]);
    let garment = distance(false);
    assert!(garment > 0.2, "{garment}");
    write(&folder, |p| [scale(x, 0.5)(p[0]), scale(y, 0.5)(p[1]), scale(z, 0.5)(p[2])]);
    let half = distance(true);
    assert!(half > 2.0, "{half}");
}

#[test]
fn files_whose_skins_would_have_one_name_are_named() {
    let Some(folder) = with_cases("also-names", &["gltf/plain.glb"]) else { return };
    write(&folder, |x| [x[0], x[1], x[2]]);
    let train = "-q train plain.glb --also lod.obj --also lod.glb -o m.sinew";
    let line = sinew(&folder, train, &[]).err;
    let expected = "sinew: lod.glb: its skin would be called lod, as that of lod.obj: rename one of the files\n";
    assert_eq!(line, expected);
}
