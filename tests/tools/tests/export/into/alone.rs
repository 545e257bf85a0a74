//! An artist's file keeps its other content, and unsuitable files are refused.

use super::super::scene::Scene;
use super::super::validator::valid;
use super::{Character, Glb, export_into};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};
use sinew_trainer::Error;
use sinew_trainer::export::Grafted;
use std::path::{Path, PathBuf};

/// A PNG of one red pixel.
const PIXEL: &str =
    "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAIAAACQd1PeAAAADElEQVR4nGP4z8AAAAMBAQDJ/pLvAAAAAElFTkSuQmCC";

fn into(character: &Character, file: &Path) -> Result<Grafted, Error> {
    let Character { examples, clips, model, .. } = character;
    export_into(model, examples, clips, &[], file)
}

/// The demo with everything that an artist may add: a material, a texture, a hat with a shape, a
/// camera, a light, extras everywhere, and numbers that an inexact float parser would change.
fn decorated() -> Character {
    let mut character = Character::new();
    let glb = &mut character.glb;
    let image = glb.view(&STANDARD.decode(PIXEL).unwrap());
    let triangle: Vec<u8> = [0.0_f32, 0.0, 9.0, 1.0, 0.0, 9.0, 0.0, 1.0, 9.0]
        .iter()
        .flat_map(|x| x.to_le_bytes())
        .collect();
    let hat = glb.view(&triangle);
    let json = &mut glb.json;
    let accessors = json["accessors"].as_array_mut().unwrap();
    accessors.push(json!({
        "bufferView": hat, "componentType": 5126, "count": 3, "type": "VEC3",
        "min": [0.0, 0.0, 9.0], "max": [1.0, 1.0, 9.0], "name": "brim",
    }));
    let hat = accessors.len() - 1;
    json["images"] = json!([{ "bufferView": image, "mimeType": "image/png", "name": "red" }]);
    json["textures"] = json!([{ "source": 0 }]);
    json["materials"] = json!([{
        "name": "Skin", "pbrMetallicRoughness": { "baseColorTexture": { "index": 0, "texCoord": 0 } },
        "extensions": { "KHR_materials_ior": { "ior": 1.4500000000000002 } },
        "extras": { "shop": [1, null, { "deep": 0.12769094176175547 }] },
    }]);
    json["extensionsUsed"] = json!(["KHR_materials_ior", "KHR_lights_punctual"]);
    json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [{ "type": "point" }] } });
    json["cameras"] =
        json!([{ "type": "perspective", "perspective": { "yfov": 0.5, "znear": 0.1 } }]);
    json["asset"]["copyright"] = json!("the artist");
    json["extras"] = json!({ "note": 18446744073709551615_u64 });
    let mesh = &mut json["meshes"][0];
    mesh["extras"] = json!({ "targetNames": [] });
    mesh["primitives"][0]["extras"] = json!("part");
    // The demo has no texture coordinates.
    let uv: Vec<[f32; 2]> = vec![[0.25, 0.5]; character.examples.vertex_len()];
    let uv: Vec<u8> = uv.as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect();
    let uv = glb.view(&uv);
    glb.json["bufferViews"][uv]["target"] = json!(34962);
    let accessors = glb.json["accessors"].as_array_mut().unwrap();
    accessors.push(json!({
        "bufferView": uv, "componentType": 5126, "count": character.examples.vertex_len(), "type": "VEC2",
    }));
    let uv = accessors.len() - 1;
    let primitive = &mut glb.json["meshes"][0]["primitives"][0];
    primitive["attributes"]["TEXCOORD_0"] = json!(uv);
    primitive["material"] = json!(0);
    glb.json["meshes"].as_array_mut().unwrap().push(json!({ "name": "hat", "primitives": [
        { "attributes": { "POSITION": hat }, "targets": [{ "POSITION": hat }] },
    ], "weights": [0.5] }));
    let nodes = glb.json["nodes"].as_array_mut().unwrap();
    let more = nodes.len();
    nodes.push(json!({ "name": "hat", "mesh": 1, "extras": 7 }));
    nodes.push(json!({ "camera": 0 }));
    nodes.push(json!({ "extensions": { "KHR_lights_punctual": { "light": 0 } } }));
    nodes[0]["children"].as_array_mut().unwrap().push(json!(more));
    let scene = glb.json["scenes"][0]["nodes"].as_array_mut().unwrap();
    scene.extend([json!(more + 1), json!(more + 2)]);
    character
}

/// Lists the places where two trees differ.
fn differences(place: &str, a: &Value, b: &Value, found: &mut Vec<String>) {
    match (a, b) {
        (Value::Object(a), Value::Object(b)) => {
            let mut names: Vec<_> = a.keys().chain(b.keys()).collect();
            names.sort();
            names.dedup();
            for name in names {
                let [a, b] = [a, b].map(|map| map.get(name).unwrap_or(&Value::Null));
                differences(&format!("{place}.{name}"), a, b, found);
            }
        }
        (Value::Array(a), Value::Array(b)) if a.len() <= b.len() => {
            for (number, a) in a.iter().enumerate() {
                differences(&format!("{place}.{number}"), a, &b[number], found);
            }
            if a.len() < b.len() {
                found.push(format!("{place}+{}", b.len() - a.len()));
            }
        }
        _ if a == b => {}
        _ => found.push(place.to_owned()),
    }
}

#[test]
fn only_what_moves_the_mesh_changes() {
    let character = decorated();
    let file = character.glb.save("alone");
    valid("decorated", &std::fs::read(&file).unwrap());
    let glb = into(&character, &file).unwrap().glb;
    valid("alone", &glb);
    std::fs::remove_file(file).unwrap();
    let (before, after) = (&character.glb, Glb::read(&glb));
    assert!(after.bytes.starts_with(&before.bytes), "bytes are appended");
    let mut found = Vec::new();
    differences("", &before.json, &after.json, &mut found);
    // Joints get proxies as children; arrays of the old skin, joints and weights are replaced.
    let primitive = &before.json["meshes"][0]["primitives"][0]["attributes"];
    let freed = ["JOINTS_0", "WEIGHTS_0"].map(|name| &primitive[name]);
    let freed: Vec<u64> = freed
        .into_iter()
        .chain([&before.json["skins"][0]["inverseBindMatrices"]])
        .map(|array| array.as_u64().unwrap())
        .collect();
    let views = |array: &u64| before.json["accessors"][*array as usize]["bufferView"].as_u64();
    let views: Vec<u64> = freed.iter().filter_map(views).collect();
    let joints = before.json["skins"][0]["joints"].as_array().unwrap();
    found.retain(|place| {
        let parts: Vec<&str> = place.split(['.', '+']).skip(1).collect();
        let number = parts.get(1).and_then(|part| part.parse::<u64>().ok());
        let expected = match parts[0] {
            "accessors" => number.is_some_and(|n| freed.contains(&n)) || place.contains('+'),
            "bufferViews" => number.is_some_and(|n| views.contains(&n)) || place.contains('+'),
            "buffers" => place.ends_with("byteLength"),
            "nodes" if place == &format!(".nodes+{}", 12) => true,
            "nodes" => {
                let node = number.unwrap();
                joints.contains(&json!(node)) && place.contains("children")
            }
            "skins" => place.contains("joints") || place.contains("inverseBindMatrices"),
            "meshes" => place.contains("JOINTS_0") || place.contains("WEIGHTS_0"),
            "animations" => place == ".animations+2",
            _ => false,
        };
        !expected
    });
    assert_eq!(found, [""; 0]);
    for view in 0..before.json["bufferViews"].as_array().unwrap().len() {
        assert!(views.contains(&(view as u64)) || before.seen(view) == after.seen(view), "{view}");
    }
}

#[test]
fn a_gltf_with_files_beside_it_becomes_one_file() {
    let character = decorated();
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR"))
        .join(format!("into-gltf-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let mut json = character.glb.json.clone();
    let parts = character.glb.bytes.split_at(character.glb.bytes.len() / 8 * 4);
    json["images"] = json!([{ "uri": "red%20one.png", "name": "red" }]);
    std::fs::write(folder.join("red one.png"), STANDARD.decode(PIXEL).unwrap()).unwrap();
    std::fs::write(folder.join("a.bin"), &character.glb.bytes).unwrap();
    // A second buffer, which holds the hat.
    let hat = json["accessors"].as_array().unwrap().iter().find(|a| a["name"] == "brim").unwrap();
    let hat = hat["bufferView"].as_u64().unwrap() as usize;
    let data = STANDARD.encode([&[1, 2, 3, 4], character.glb.seen(hat)].concat());
    json["bufferViews"][hat] = json!({ "buffer": 1, "byteOffset": 4, "byteLength": 36 });
    json["buffers"] = json!([
        { "uri": "a.bin", "byteLength": parts.0.len() + parts.1.len(), "name": "all" },
        { "uri": format!("data:application/octet-stream;base64,{data}"), "byteLength": 40 },
    ]);
    let file = folder.join("character.gltf");
    std::fs::write(&file, json.to_string()).unwrap();
    let grafted = into(&character, &file).unwrap();
    valid("gltf", &grafted.glb);
    let after = Glb::read(&grafted.glb);
    let image = &after.json["images"][0];
    assert_eq!((&image["name"], &image["mimeType"]), (&json!("red"), &json!("image/png")));
    assert_eq!(image.get("uri"), None);
    let bytes = after.seen(image["bufferView"].as_u64().unwrap() as usize);
    assert_eq!(bytes, STANDARD.decode(PIXEL).unwrap());
    assert_eq!(after.seen(hat), character.glb.seen(hat));
    assert_eq!(after.json["buffers"].as_array().unwrap().len(), 1);
    assert_eq!(after.json["buffers"][0]["name"], "all");
    let same = Scene::read(&into(&character, &character.glb.save("same")).unwrap().glb);
    let scene = Scene::read(&grafted.glb);
    let posed = |scene: &Scene| scene.posed("skin", &scene.worlds(Some((2, 3, 0.0))));
    assert_eq!(posed(&scene), posed(&same));

    std::fs::write(folder.join("red one.png"), "no picture").unwrap();
    let error = into(&character, &file).map(|_| ()).unwrap_err().to_string();
    assert!(error.contains("image 0: red%20one.png is no PNG"), "{error}");
    std::fs::remove_dir_all(folder).unwrap();
}

#[track_caller]
fn refused(test: &str, change: impl FnOnce(&mut Glb)) -> Error {
    let mut character = Character::new();
    change(&mut character.glb);
    let file = character.glb.save(test);
    let error = into(&character, &file).map(|_| ()).unwrap_err();
    std::fs::remove_file(file).unwrap();
    error
}

fn positions(glb: &Glb) -> usize {
    glb.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"].as_u64().unwrap() as usize
}

#[test]
fn unsuitable_files_are_refused() {
    for name in ["KHR_draco_mesh_compression", "EXT_meshopt_compression"] {
        let error = refused("compressed", |glb| glb.json["extensionsUsed"] = json!([name]));
        let expected = format!("needs the glTF extension {name}, which is not read: ");
        assert!(error.file().is_some() && error.message().starts_with(&expected), "{error}");
    }
    let error = refused("short", |glb| glb.bytes.truncate(100));
    let is_short = ["buffer 0: ", "accessor "].iter().any(|own| error.message().starts_with(own));
    assert!(error.file().is_some() && is_short, "{error}");
    // No rotation and scale undoes this deformation, and none moves a vertex to another vertex's
    // place.
    let other = refused("other", |glb| {
        glb.change(positions(glb), 3, |x| x[1] = 1.7 * x[1] + 7.7 + 0.31 * x[0] * x[2]);
    });
    assert!(other.message().starts_with("no mesh has the model's vertices, "), "{other}");
    let at = std::sync::atomic::AtomicUsize::new(0);
    let partly = refused("partly", |glb| {
        glb.change(positions(glb), 3, |x| {
            if at.fetch_add(1, std::sync::atomic::Ordering::Relaxed) == 17 {
                x[0] += 0.1;
            }
        });
    });
    assert!(partly.message().starts_with("mesh skin: vertex 17 at "), "{partly}");
    let all = at.into_inner();
    let counts = format!("is not in the model, {} of {all} are: ", all - 1);
    assert!(partly.message().contains(&counts), "{partly}");
    let uneven = refused("uneven", |glb| {
        glb.json["nodes"][0]["scale"] = json!([1.0, 1.0, 1.5]);
    });
    assert!(uneven.message().contains("hangs under nodes that scale unevenly"), "{uneven}");
}
