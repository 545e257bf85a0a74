//! Tests of curves from morph weights.

use super::made::Made;
use crate::examples::{Curves, Examples, Source, load, load_motion, load_poses};
use crate::{Error, ErrorKind};
use serde_json::{Value, json};

/// Adds a clip `talk` in which the mesh of a node has these weights at 0 and 1 s.
fn talk(made: &mut Made, node: usize, weights: &[[f32; 1]; 2]) {
    let (times, weights) = (made.floats(&[[0.0], [1.0]]), made.floats(weights));
    let target = json!({ "node": node, "path": "weights" });
    made.clip("talk", target, times, weights, "LINEAR");
}

/// A scene whose mesh has a morph target `jaw` of weight 0.25 without animation, which the clip `talk` moves.
fn jaw() -> Made {
    let mut made = Made::scene();
    made.json["meshes"][0]["extras"] = json!({ "targetNames": ["jaw"] });
    made.json["meshes"][0]["weights"] = json!([0.25]);
    talk(&mut made, 0, &[[0.5], [1.0]]);
    made
}

/// Adds a mesh without a skin that has the morph target too, with these weights in the clip `talk`.
fn teeth(made: &mut Made, weights: &[[f32; 1]; 2]) {
    let mut mesh = made.json["meshes"][0].clone();
    mesh["primitives"][0]["attributes"]
        .as_object_mut()
        .unwrap()
        .retain(|name, _| name == "POSITION");
    made.json["meshes"].as_array_mut().unwrap().push(mesh);
    let nodes = made.json["nodes"].as_array_mut().unwrap();
    nodes.push(json!({ "name": "teeth", "mesh": 1 }));
    made.json["scenes"][0]["nodes"] = json!([0, 1, 3]);
    talk(made, 3, weights);
    // One clip moves both meshes.
    let clips = made.json["animations"].as_array_mut().unwrap();
    let other: Value = clips.pop().unwrap();
    let clip = clips.last_mut().unwrap();
    clip["samplers"].as_array_mut().unwrap().push(other["samplers"][0].clone());
    let mut channel = other["channels"][0].clone();
    channel["sampler"] = json!(1);
    clip["channels"].as_array_mut().unwrap().push(channel);
}

fn read(made: &Made, test: &str, curves: Curves<'_>) -> Result<Examples, Error> {
    load(&Source { curves, ..Source::file(&made.write(test)) }).map(|loaded| loaded.examples)
}

#[test]
fn weights_of_named_morph_targets_are_curves() {
    let examples = read(&jaw(), "curves", Curves::All).unwrap();
    // Three frames of `bend`, which leaves the weight alone, and two of `talk`.
    assert_eq!(examples.curve_names, ["jaw"]);
    assert_eq!(examples.curves, [0.25, 0.25, 0.25, 0.5, 1.0]);
    for choice in [Curves::Usual, Curves::None] {
        let examples = read(&jaw(), "curves-none", choice).unwrap();
        assert!(examples.curve_names.is_empty() && examples.curves.is_empty());
    }
    let mut bare = jaw();
    bare.json["meshes"][0]["extras"] = json!({ "other": 1 });
    let error = read(&bare, "curves-bare", Curves::All).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Missing);
    assert!(
        error.message().starts_with("has no curve: no mesh has a shape with a name"),
        "{error}"
    );
    let error = read(&jaw(), "curves-missing", Curves::Named(&["brow".to_owned()])).unwrap_err();
    assert_eq!(error.message(), "there is no curve brow: it has jaw");
}

#[test]
fn meshes_share_a_curve_if_their_weights_agree() {
    let mut made = jaw();
    teeth(&mut made, &[[0.5], [1.0]]);
    let examples = read(&made, "curves-shared", Curves::All).unwrap();
    assert_eq!((&examples.curve_names[..], examples.curves[4]), (&["jaw".to_owned()][..], 1.0));
    let mut made = jaw();
    teeth(&mut made, &[[0.5], [0.75]]);
    let error = read(&made, "curves-differ", Curves::All).unwrap_err();
    assert_eq!((error.kind(), error.frame()), (ErrorKind::Mismatch, Some(4)));
    let words = "curve jaw is 1 on mesh body and 0.75 on mesh teeth: give the two shapes one motion, rename one";
    assert!(error.message().starts_with(words), "{error}");
    // Nobody asked for the curve.
    read(&made, "curves-unasked", Curves::None).unwrap();
}

/// A mesh without a skin is not learned, but its weights may drive the others.
#[test]
fn keys_of_a_curve_are_frames() {
    let mut made = jaw();
    let all = made.json["animations"].as_array_mut().unwrap();
    all.pop();
    let nodes = made.json["nodes"].as_array_mut().unwrap();
    nodes.push(json!({ "name": "control", "mesh": 0 }));
    made.json["scenes"][0]["nodes"] = json!([0, 1, 3]);
    talk(&mut made, 3, &[[0.0], [0.75]]);
    assert_eq!(read(&made, "curves-idle", Curves::None).unwrap().frame_len(), 3);
    let names = ["jaw".to_owned()];
    let error = read(&made, "curves-control", Curves::Named(&names)).unwrap_err();
    assert!(error.message().starts_with("curve jaw is 0.25 on mesh body and 0 on"), "{error}");
    made.json["meshes"].as_array_mut().unwrap().push(json!(null));
    let mut other = made.json["meshes"][0].clone();
    other["extras"] = json!({ "targetNames": ["breath"] });
    made.json["meshes"][1] = other;
    made.json["nodes"][3]["mesh"] = json!(1);
    let names = ["breath".to_owned()];
    let examples = read(&made, "curves-breath", Curves::Named(&names)).unwrap();
    assert_eq!(examples.curves, [0.25, 0.25, 0.25, 0.0, 0.75]);
}

#[test]
fn played_poses_have_their_curves() {
    let path = jaw().write("curves-played");
    let source = Source { curves: Curves::All, ..Source::file(&path) };
    let poses = load_poses(&source).unwrap();
    let played = load_motion(&source, Some(&path)).unwrap();
    for loaded in [poses, played] {
        let talk = &loaded.clips[1];
        let [first, last] = [talk.first, talk.first + talk.times.len() - 1];
        assert_eq!([first, last].map(|frame| loaded.examples.curves_of(frame)[0]), [0.5, 1.0]);
    }
}
