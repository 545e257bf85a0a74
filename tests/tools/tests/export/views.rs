//! Objects of views as binary glTF.

use super::validator::valid;
use models::shared;
use sinew_runtime::Model;
use sinew_runtime::format::Space;
use sinew_trainer::bake::bake;
use sinew_trainer::views::demo::write;
use sinew_trainer::views::export::{Grid, Side, glb};
use sinew_trainer::views::fit::{FitOptions, Shown};
use sinew_trainer::views::model::parts;
use sinew_trainer::views::model::{LayerModel, ViewsModel};
use sinew_trainer::views::set::{Values, read};
use sinew_trainer::views::train::{Trained, train};

/// Tolerance of single precision, in heights of the screen.
const ROUNDING: f64 = 1e-5;

fn head() -> (Trained, Model<Vec<u8>>) {
    let folder = std::env::temp_dir().join(format!("sinew-views-glb-{}", std::process::id()));
    write(&folder).unwrap();
    let set = read(&folder.join("head/views.json"), None).unwrap();
    let trained = train(&set, FitOptions::default()).unwrap();
    std::fs::remove_dir_all(folder).unwrap();
    let bytes = bake(Space::default(), &parts(&trained.model).unwrap()).unwrap();
    (trained, Model::from_bytes(bytes).unwrap())
}

fn shown(trained: &Trained, yaw: f64) -> Shown {
    let values: Values = [("yaw".to_owned(), yaw)].into();
    trained.model.outputs().evaluate(&trained.model.maps[0], &values).unwrap()
}

/// A primitive: its key view, and for each vertex the position at rest, the offsets of the targets, and the place in
/// the picture.
struct Primitive {
    key: usize,
    name: String,
    rest: Vec<[f64; 3]>,
    targets: Vec<Vec<[f64; 3]>>,
    texels: Vec<[f64; 2]>,
    triangles: usize,
}

/// Reads the primitives of the only mesh.
///
/// - `layer`: finds the layer of a primitive, by the name of its material.
fn primitives(glb: &[u8], model: &ViewsModel, layer: impl Fn(&str) -> usize) -> Vec<Primitive> {
    let gltf = gltf::Gltf::from_slice(glb).unwrap();
    let blob = gltf.blob.clone().unwrap();
    assert_eq!(gltf.meshes().count(), 1);
    let mesh = gltf.meshes().next().unwrap();
    let weights = mesh.weights().unwrap();
    assert!(weights.iter().all(|weight| *weight == 0.0));
    let wide = |place: [f32; 3]| place.map(f64::from);
    let of = |primitive: gltf::Primitive<'_>| {
        let reader = primitive.reader(|_| Some(&blob));
        let name = primitive.material().name().unwrap().to_owned();
        let key = model.keys.iter().position(|key| name.ends_with(&key.name)).unwrap();
        let (picture, _) = model.keys[key].pictures[layer(&name)].as_ref().unwrap();
        let size = [picture.size.width, picture.size.height].map(|side| side as f64);
        let texel = |uv: [f32; 2]| [0, 1].map(|axis| f64::from(uv[axis]) * size[axis]);
        let target = |(positions, ..): (Option<gltf::mesh::util::ReadPositions<'_>>, _, _)| {
            positions.unwrap().map(wide).collect()
        };
        let targets: Vec<Vec<[f64; 3]>> = reader.read_morph_targets().map(target).collect();
        assert_eq!(targets.len(), weights.len());
        Primitive {
            key,
            name,
            rest: reader.read_positions().unwrap().map(wide).collect(),
            targets,
            texels: reader.read_tex_coords(0).unwrap().into_f32().map(texel).collect(),
            triangles: reader.read_indices().unwrap().into_u32().count() / 3,
        }
    };
    mesh.primitives().map(of).collect()
}

/// Finds the vertices of a layer at the places in the pictures of primitives with shared vertices.
fn vertices(model: &ViewsModel, layer: usize, primitives: &[&Primitive]) -> Vec<usize> {
    let mut all: Vec<usize> =
        model.mesh.layers[layer].iter().flat_map(|own| own.vertices()).copied().collect();
    all.sort_unstable();
    all.dedup();
    let nearest = |row: usize| {
        let off = |vertex: &usize| -> f64 {
            let of = |own: &&Primitive| {
                let key = &model.keys[own.key];
                let (_, corner) = key.pictures[layer].as_ref().unwrap();
                let place = model.mesh.vertices[*vertex].at(&key.points);
                let apart = [0, 1].map(|k| place[k] - corner[k] as f64 - own.texels[row][k]);
                apart[0].hypot(apart[1])
            };
            primitives.iter().map(of).sum()
        };
        let found = all.iter().min_by(|a, b| off(a).total_cmp(&off(b))).unwrap();
        assert!(off(found) < 1e-2, "{}", off(found));
        *found
    };
    (0..primitives[0].rest.len()).map(nearest).collect()
}

/// Compares every primitive with the model in double precision, at rest and with each of its targets.
fn shows(glb: &[u8], trained: &Trained, rest: f64, targets: &[f64]) {
    let model = &trained.model;
    let all = primitives(glb, model, |_| 0);
    let vertices = vertices(model, 0, &all.iter().collect::<Vec<_>>());
    assert_eq!(vertices.len(), 128);
    let is_at = |found: &[[f64; 3]], yaw: f64| {
        let shown = shown(trained, yaw);
        for (found, &vertex) in found.iter().zip(&vertices) {
            let point = model.mesh.vertices[vertex].at(&shown.points);
            let [(at, _)] = model.mesh.vertices[vertex].weights[..] else { panic!("a point") };
            let depth = shown.depths[at];
            let expected = [(point[0] - 80.0) / 192.0, (96.0 - point[1]) / 192.0, -depth / 192.0];
            assert!((0..3).all(|axis| (found[axis] - expected[axis]).abs() < ROUNDING));
        }
    };
    for own in &all {
        is_at(&own.rest, rest);
        assert_eq!(own.targets.len(), targets.len());
        for (by, yaw) in own.targets.iter().zip(targets) {
            is_at(&moved(&own.rest, by), *yaw);
        }
    }
    let triangles: usize = all.iter().map(|own| own.triangles).sum();
    assert_eq!(triangles, 2 * model.mesh.element_len(), "each once, in two");
}

fn moved(rest: &[[f64; 3]], by: &[[f64; 3]]) -> Vec<[f64; 3]> {
    rest.iter().zip(by).map(|(rest, by)| [0, 1, 2].map(|k| rest[k] + by[k])).collect()
}

#[test]
fn a_head_of_views_is_valid_and_stands_as_the_model_has_it() {
    let (trained, file) = head();
    let sides = [Side { name: "yaw".to_owned(), range: Some([-60.0, 60.0]), nodes: 5 }];
    let grid = Grid::of_sides(&file, None, &Values::new(), &sides).unwrap();
    let bytes = glb(&file, None, &grid).unwrap();
    shows(&bytes, &trained, 0.0, &[-60.0, -30.0, 0.0, 30.0, 60.0]);
    valid("views-grid", &bytes);
    // The parameters of key views are found from their points.
    let grid = Grid::of_key_views(&file, None).unwrap();
    let bytes = glb(&file, None, &grid).unwrap();
    let yaws: Vec<f64> = (0..12).map(|view| 30.0 * f64::from(view)).collect();
    shows(&bytes, &trained, 180.0, &yaws);
    valid("views-keys", &bytes);
}

#[test]
fn layers_are_stacked_in_depth() {
    let Some(file) = shared("character-2d/character.json") else { return };
    let set = read(&file, None).unwrap();
    let trained = train(&set, FitOptions::default()).unwrap();
    let bytes = bake(Space::default(), &parts(&trained.model).unwrap()).unwrap();
    let file = Model::from_bytes(bytes).unwrap();
    let side = |name: &str| Side { name: name.to_owned(), range: None, nodes: 3 };
    let sides = [side("turn"), side("nod")];
    let grid = Grid::of_sides(&file, None, &Values::new(), &sides).unwrap();
    let bytes = glb(&file, None, &grid).unwrap();
    let model = &trained.model;
    let layer = |name: &str| {
        let is_of = |layer: &LayerModel| name.starts_with(&format!("{} ", layer.name));
        model.layers.iter().position(is_of).unwrap()
    };
    let all = primitives(&bytes, model, layer);
    let names: Vec<&str> = all.iter().map(|own| own.name.as_str()).collect();
    // The middle key view is the rest shape. Layers are listed with the hindmost first.
    let expected: Vec<String> =
        model.layers.iter().map(|layer| format!("{} key0", layer.name)).collect();
    assert_eq!(names, expected);
    let triangles: usize = all.iter().map(|own| own.triangles).sum();
    assert_eq!(triangles, model.mesh.element_len(), "each once");
    for (number, own) in all.iter().enumerate() {
        let vertices = vertices(model, number, &[own]);
        for (node, by) in grid.nodes.iter().zip(&own.targets) {
            let shown = model.outputs().evaluate(&model.maps[0], &node.values).unwrap();
            for (found, &vertex) in moved(&own.rest, by).iter().zip(&vertices) {
                let place = model.mesh.vertices[vertex].at(&shown.points);
                let expected = [(place[0] - 160.0) / 320.0, (160.0 - place[1]) / 320.0];
                assert!((0..2).all(|axis| (found[axis] - expected[axis]).abs() < ROUNDING));
                assert!((found[2] - 1e-3 * number as f64).abs() < 1e-9, "{number}: {}", found[2]);
            }
        }
    }
    valid("views-layers", &bytes);
}
