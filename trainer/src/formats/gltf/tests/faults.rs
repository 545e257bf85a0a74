//! Tests of refused glTF files and their messages.

use super::*;
use serde_json::Value;
use std::panic::catch_unwind;

fn refused(made: &Made, test: &str) -> String {
    load(&Source::file(&made.write(test))).unwrap_err().to_string()
}

/// Changes one thing of the valid scene and expects a message with these words.
#[track_caller]
fn refuses(test: &str, change: impl FnOnce(&mut Value), words: &str) {
    let mut made = Made::scene();
    change(&mut made.json);
    let error = refused(&made, test);
    assert!(error.contains(words), "{error}");
    assert!(error.contains(test), "names no file: {error}");
}

#[test]
fn missing_parts_are_named() {
    let remove =
        |key: &'static str| move |json: &mut Value| drop(json.as_object_mut().unwrap().remove(key));
    refuses("no-animation", remove("animations"), "holds no animation");
    refuses(
        "no-skin",
        |json| drop(json["nodes"][0].as_object_mut().unwrap().remove("skin")),
        "no mesh has a skin",
    );
    refuses(
        "no-mesh",
        |json| {
            json["nodes"][0] = json!({});
            json["meshes"] = json!([]);
            json["animations"] = json!([]);
        },
        "holds no mesh",
    );
    refuses(
        "nothing-moves",
        |json| {
            json["nodes"][0]["children"] = json!([3]);
            json["nodes"].as_array_mut().unwrap().push(json!({}));
            json["animations"][0]["channels"][0]["target"]["node"] = json!(3);
        },
        "no animation targets a joint or a shape of the mesh (clips: bend)",
    );
}

#[test]
fn unsupported_features_are_named() {
    refuses(
        "draco",
        |json| json["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]),
        "needs the glTF extension KHR_draco_mesh_compression",
    );
    let mut made = Made::scene();
    made.json["extensionsRequired"] = json!(["KHR_mesh_quantization", "KHR_materials_unlit"]);
    made.json["extensionsUsed"] = made.json["extensionsRequired"].clone();
    assert!(load(&Source::file(&made.write("quantised"))).is_ok());
}

#[test]
fn damage_is_named() {
    refuses(
        "count",
        |json| json["accessors"][0]["count"] = json!(300),
        "accessor 0 reaches beyond its buffer",
    );
    refuses(
        "count-huge",
        |json| json["accessors"][0]["count"] = json!(u64::MAX),
        "accessor 0 reaches",
    );
    refuses(
        "width",
        |json| json["accessors"][5]["type"] = json!("VEC2"),
        "accessor 5 has 2 components",
    );
    refuses(
        "mode",
        |json| json["meshes"][0]["primitives"][0]["mode"] = json!(1),
        "mesh body is made of lines: export it as triangles",
    );
    refuses(
        "joint",
        |json| {
            json["skins"][0] = json!({ "joints": [1] });
            json["animations"][0]["channels"][0]["target"]["node"] = json!(1);
        },
        "mesh body names joint 1 of 1",
    );
    refuses(
        "keys",
        |json| json["animations"][0]["samplers"][0]["output"] = json!(0),
        "accessor 0 has 3 components",
    );
    refuses(
        "buffer",
        |json| json["buffers"] = json!([{ "byteLength": 4, "uri": "none.bin" }]),
        "buffer 0: ",
    );
    refuses(
        "cycle",
        |json| json["nodes"][2]["children"] = json!([1]),
        "has two parents or is its own ancestor",
    );
    refuses(
        "shared-child",
        |json| json["nodes"][0]["children"] = json!([2]),
        "node lower has two parents",
    );
}

#[test]
fn a_bind_that_cannot_be_inverted_is_named() {
    let mut made = Made::scene();
    let inverses = made.floats(&[moved_by(0.0), [0.0; 16]]);
    made.json["skins"][0]["inverseBindMatrices"] = json!(inverses);
    let error = refused(&made, "singular");
    assert!(error.contains("the bind matrix of joint lower cannot be inverted"), "{error}");
}

#[test]
fn meshes_bound_in_different_poses_are_named() {
    let mut made = Made::scene();
    let inverses = made.floats(&[moved_by(0.0), moved_by(-2.5)]);
    made.json["skins"]
        .as_array_mut()
        .unwrap()
        .push(json!({ "joints": [1, 2], "inverseBindMatrices": inverses }));
    made.json["nodes"]
        .as_array_mut()
        .unwrap()
        .push(json!({ "name": "sleeve", "mesh": 0, "skin": 1 }));
    made.json["scenes"][0]["nodes"] = json!([0, 1, 3]);
    let error = refused(&made, "other-bind");
    assert!(error.contains("mesh sleeve binds joint lower elsewhere"), "{error}");
}

#[test]
fn a_vertex_without_weights_is_named() {
    let mut made = Made::scene();
    let weights = made.floats(&[[1.0, 0.0, 0.0, 0.0], [0.0; 4], [0.5, 0.5, 0.0, 0.0]]);
    made.json["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_0"] = json!(weights);
    let error = refused(&made, "unbound");
    assert!(error.contains("mesh body: vertex 1 has no joint weight"), "{error}");
}

#[test]
fn keys_out_of_order_are_named() {
    let mut made = Made::scene();
    let times = made.floats(&[[0.0], [1.0], [0.5]]);
    made.json["animations"][0]["samplers"][0]["input"] = json!(times);
    let error = refused(&made, "order");
    assert!(error.contains("clip bend: its key times"), "{error}");
}

#[test]
fn an_unknown_clip_lists_the_known_clips() {
    let file = Made::scene().write("unknown-clip");
    let error = load(&Source { clips: &["walk".to_owned()], ..Source::file(&file) }).unwrap_err();
    assert!(error.to_string().ends_with("has no clip walk, there are: bend"), "{error}");
}

/// Changing any byte, or cutting the file anywhere, gives a result or an error, never a panic.
#[test]
fn damaged_files_never_panic() {
    let file = Made::scene().write("damaged");
    let good = std::fs::read(&file).unwrap();
    let try_bytes = |bytes: &[u8]| {
        std::fs::write(&file, bytes).unwrap();
        let done = catch_unwind(|| drop(load(&Source::file(&file))));
        assert!(done.is_ok(), "{}", String::from_utf8_lossy(bytes));
    };
    for len in (0..good.len()).step_by(7) {
        try_bytes(&good[..len]);
    }
    for place in 0..good.len() {
        let mut bytes = good.clone();
        bytes[place] = match bytes[place] {
            digit @ b'0'..=b'8' => digit + 1,
            b'9' => b'-',
            other => other ^ 1,
        };
        try_bytes(&bytes);
    }
}

#[test]
fn joints_that_hide_or_mirror_are_named_with_their_frame() {
    for (x, words) in [
        (0.0, "frame 4: joint lower is scaled to 0: "),
        (-1.0, "frame 4: joint lower is mirrored: "),
    ] {
        let mut made = Made::scene();
        let times = made.floats(&[[0.0], [1.0]]);
        let scales = made.floats(&[[1.0; 3], [x, 1.0, 1.0]]);
        made.clip("hide", json!({ "node": 2, "path": "scale" }), times, scales, "LINEAR");
        let message = refused(&made, &format!("hidden{x}"));
        assert!(message.contains(words), "{message}");
    }
}
