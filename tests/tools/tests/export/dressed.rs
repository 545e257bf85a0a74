//! Names, materials and textures of a clip's file survive the export.

use super::into::Glb;
use super::scene::Scene;
use super::validator::valid;
use super::{arm, clip, farthest, model, pose, runtime_skin};
use models::shared;
use serde_json::{Value, json};
use sinew_runtime::Model;
use sinew_runtime::envelope::Predictor;
use sinew_trainer::examples::{Clip, Examples, Loaded, Source, load, load_poses};
use sinew_trainer::export::{Export, Placement, Playback};
use sinew_trainer::formats::appearance::{self, Appearance};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

fn dressed(model: &[u8], examples: &Examples, clips: &[Clip], appearance: &Appearance) -> Vec<u8> {
    let placement = Placement::AsModel;
    let playback = Playback { model, skin: None, examples, clips, between: false, levels: &[] };
    Export { playback, appearance, placement }.run().unwrap().glb
}

/// Trains on a scene and exports its first clip with the appearance of the scene.
fn of_file(path: &Path) -> (Vec<u8>, Appearance) {
    let Loaded { examples, clips, .. } = load(&Source::file(path)).unwrap();
    let model = model(&examples, Predictor::Kernel, 4, 4);
    let appearance = appearance::load(path).unwrap();
    assert_eq!(appearance.of_triangles.len(), examples.triangles.len());
    (dressed(&model, &examples, &clips[..1], &appearance), appearance)
}

/// Makes a folder for a test; the test removes it.
fn folder(test: &str) -> PathBuf {
    let name = format!("dressed-{test}-{}", std::process::id());
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

type Corners = Vec<[[f32; 3]; 3]>;

/// Lists the triangles of every mesh's primitives by the name of their material, corner by corner.
fn by_material(glb: &[u8]) -> BTreeMap<String, Corners> {
    let gltf = gltf::Gltf::from_slice(glb).unwrap();
    let mut all: BTreeMap<String, Corners> = BTreeMap::new();
    for primitive in gltf.meshes().flat_map(|mesh| mesh.primitives().collect::<Vec<_>>()) {
        let reader = primitive.reader(|_| gltf.blob.as_deref());
        let points: Vec<_> = reader.read_positions().unwrap().collect();
        let corners: Vec<usize> = match reader.read_indices() {
            Some(indices) => indices.into_u32().map(|index| index as usize).collect(),
            None => (0..points.len()).collect(),
        };
        let name = primitive.material().name().unwrap_or("none").to_owned();
        let corners = corners.as_chunks::<3>().0.iter().map(|t| t.map(|v| points[v]));
        all.entry(name).or_default().extend(corners);
    }
    all
}

#[test]
fn fox_comes_back_textured() {
    let Some(path) = shared("gltf-loader/Fox.glb") else { return };
    let (glb, _) = of_file(&path);
    valid("fox-dressed", &glb);
    let before = std::fs::read(&path).unwrap();
    assert_eq!(by_material(&glb), by_material(&before));
    let [before, after] = [&before, &glb].map(|glb| Glb::read(glb));
    for name in ["materials", "textures", "samplers"] {
        assert_eq!(before.json[name], after.json[name], "{name}");
    }
    let [from, to] = [&before, &after].map(|glb| {
        let image = &glb.json["images"][0];
        assert_eq!(image["mimeType"], "image/png");
        glb.seen(image["bufferView"].as_u64().unwrap() as usize)
    });
    assert!(from == to && !to.is_empty(), "the image, byte by byte");
    assert_eq!(after.json["meshes"][0]["name"], "fox");
    let [before, after] = [&before, &after].map(|glb| {
        let gltf = gltf::Gltf::from_slice(&glb.write()).unwrap();
        let primitive = gltf.meshes().next().unwrap().primitives().next().unwrap();
        let reader = primitive.reader(|_| gltf.blob.as_deref());
        reader.read_tex_coords(0).unwrap().into_f32().collect::<Vec<_>>()
    });
    assert_eq!(before.len(), after.len());
    for (before, after) in before.iter().zip(&after) {
        // The export flips v twice.
        assert!((0..2).all(|axis| (before[axis] - after[axis]).abs() < 1e-7));
    }
}

#[test]
fn a_leg_keeps_its_two_materials() {
    let Some(path) = shared("leg/leg.glb") else { return };
    let (glb, appearance) = of_file(&path);
    valid("leg-dressed", &glb);
    assert_eq!(appearance.mesh.as_deref(), Some("Leg"));
    let (found, expected) = (by_material(&glb), by_material(&std::fs::read(&path).unwrap()));
    assert_eq!(found.keys().collect::<Vec<_>>(), ["Claw", "Fur Brown"]);
    assert_eq!(found, expected);
}

#[test]
fn materials_of_an_fbx_are_named_coloured_and_textured_where_the_picture_is_beside_it() {
    let Some(path) = shared("leg/leg_strips.fbx") else { return };
    let Some(same) = shared("leg/leg.glb") else { return };
    let (glb, appearance) = of_file(&path);
    valid("leg-fbx", &glb);
    let count = |glb: &[u8]| -> Vec<(String, usize)> {
        by_material(glb).into_iter().map(|(name, triangles)| (name, triangles.len())).collect()
    };
    assert_eq!(count(&glb), count(&std::fs::read(&same).unwrap()));
    let places = ["textures/packed/checker", "checker"].map(|name| path.with_file_name(name));
    let [first, second] = places.each_ref().map(|place| place.display());
    let missing = format!("checker (looked for as {first} and {second})");
    assert_eq!(appearance.missing, [missing]);
    let json = Glb::read(&glb).json;
    let claw = json["materials"].as_array().unwrap().iter().find(|m| m["name"] == "Claw").unwrap();
    let colour = &claw["pbrMetallicRoughness"]["baseColorFactor"];
    for (found, expected) in colour.as_array().unwrap().iter().zip([0.05, 0.05, 0.06, 1.0]) {
        assert!((found.as_f64().unwrap() - expected).abs() < 1e-6, "{colour}");
    }
    assert_eq!(json.get("textures"), None);

    let folder = folder("fbx");
    let copy = folder.join("leg.fbx");
    std::fs::copy(&path, &copy).unwrap();
    let picture = Glb::read(&std::fs::read(&same).unwrap());
    let view = picture.json["images"][0]["bufferView"].as_u64().unwrap() as usize;
    std::fs::write(folder.join("checker"), picture.seen(view)).unwrap();
    let appearance = appearance::load(&copy).unwrap();
    std::fs::remove_dir_all(folder).unwrap();
    assert_eq!(appearance.missing, [""; 0]);
    let fur = appearance.materials.iter().find(|m| m["name"] == "Fur Brown").unwrap();
    let texture = fur["pbrMetallicRoughness"]["baseColorTexture"]["index"].as_u64().unwrap();
    let image = appearance.textures[texture as usize]["source"].as_u64().unwrap() as usize;
    assert_eq!(appearance.images[image].bytes, picture.seen(view));
}

#[test]
fn meshes_that_were_joined_come_apart_by_name_and_material() {
    let mut examples = arm(300);
    let (half, len) = (examples.vertex_len() / 2, examples.vertex_len());
    examples.engine = None;
    examples.triangles.retain(|t| t.iter().all(|&v| v < half) || t.iter().all(|&v| v >= half));
    examples.ranges = vec![("body".to_owned(), 0..half), ("trousers".to_owned(), half..len)];
    let of = |t: &[usize; 3]| [None, Some(0), Some(1)][t[0] % 3];
    let appearance = Appearance {
        of_triangles: examples.triangles.iter().map(of).collect(),
        materials: vec![json!({ "name": "red" }), json!({ "name": "blue" })],
        ..Appearance::default()
    };
    let bytes = model(&examples, Predictor::Kernel, 4, 4);
    let glb = dressed(&bytes, &examples, &[clip("all", 0, 3)], &appearance);
    valid("parts", &glb);
    let scene = Scene::read(&glb);
    let names: Vec<_> = scene.gltf.meshes().map(|mesh| mesh.name().unwrap().to_owned()).collect();
    assert_eq!(names, ["body", "trousers"]);
    let loaded = Model::from_bytes(bytes.as_slice()).unwrap();
    let skin = runtime_skin(&loaded, &pose(&examples, 2));
    for (name, range) in &examples.ranges {
        let node = scene.gltf.nodes().nth(scene.node(name)).unwrap();
        assert_eq!(node.mesh().unwrap().primitives().len(), 3);
        // Primitives share their vertices.
        let found = scene.posed(name, &scene.worlds(Some((0, 2, 0.0))));
        let found = &found[..range.len()];
        assert!(farthest(found, &skin[range.clone()]) < 1e-4 * examples.diagonal());
    }
    let count = |name: &str, of: Option<usize>| {
        assert_eq!(
            by_material(&glb)[name].len(),
            appearance.of_triangles.iter().filter(|&&material| material == of).count(),
            "{name}"
        );
    };
    count("none", None);
    count("red", Some(0));
    count("blue", Some(1));
}

/// Textures with a second set of coordinates, or without a picture, cannot be shown; the colour
/// can.
#[test]
fn textures_that_cannot_be_shown_are_taken_away() {
    let Some(path) = shared("gltf-loader/Fox.glb") else { return };
    let mut fox = Glb::read(&std::fs::read(&path).unwrap());
    let folder = folder("missing");
    let file = folder.join("fox.gltf");
    std::fs::write(folder.join("fox.bin"), &fox.bytes).unwrap();
    fox.json["buffers"][0]["uri"] = json!("fox.bin");
    let with = |change: &dyn Fn(&mut Value)| {
        let mut json = fox.json.clone();
        change(&mut json);
        std::fs::write(&file, json.to_string()).unwrap();
        let appearance = appearance::load(&file).unwrap();
        let examples = load_poses(&Source::file(&file)).unwrap().examples;
        let model = model(&examples, Predictor::Rotational, 2, 4);
        let glb = dressed(&model, &examples, &[clip("a", 0, 2)], &appearance);
        valid("fox-changed", &glb);
        (appearance.missing, Glb::read(&glb).json["materials"][0].clone())
    };
    let roughness = |material: &Value| {
        let surface = &material["pbrMetallicRoughness"];
        assert_eq!(surface["roughnessFactor"], 0.58);
        surface.get("baseColorTexture").is_some()
    };
    let (missing, material) = with(&|json| json["images"] = json!([{ "uri": "none.png" }]));
    let looked_for = folder.join("none.png");
    assert_eq!(missing, [format!("none.png (looked for as {})", looked_for.display())]);
    assert!(!roughness(&material));
    let (missing, material) = with(&|json| {
        let texture = &mut json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"];
        texture["texCoord"] = json!(1);
    });
    assert_eq!(missing, [""; 0]);
    assert!(!roughness(&material));
    let (_, material) = with(&|_| {});
    assert!(roughness(&material));
    std::fs::remove_dir_all(folder).unwrap();
}
