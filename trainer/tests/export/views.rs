//! Objects of views as binary glTF.

use super::validator::valid;
use sinew_runtime::Model;
use sinew_runtime::format::Space;
use sinew_trainer::bake::bake;
use sinew_trainer::views::bake::parts;
use sinew_trainer::views::demo::write;
use sinew_trainer::views::export::{Grid, Side, glb};
use sinew_trainer::views::fit::{FitOptions, Shown};
use sinew_trainer::views::set::{Values, read};
use sinew_trainer::views::train::{Trained, train};

/// Heights of the screen by which single precision may be off.
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

/// Holds every primitive, at rest and by each of its targets, against what the model shows in double precision.
fn shows(glb: &[u8], trained: &Trained, rest: f64, targets: &[f64]) {
    let gltf = gltf::Gltf::from_slice(glb).unwrap();
    let blob = gltf.blob.clone().unwrap();
    let mesh = gltf.meshes().next().unwrap();
    assert_eq!(gltf.meshes().count(), 1);
    assert_eq!(mesh.weights().unwrap(), vec![0.0; targets.len()]);
    let mut quads = 0;
    for primitive in mesh.primitives() {
        let reader = primitive.reader(|_| Some(&blob));
        let own: Vec<[f32; 3]> = reader.read_positions().unwrap().collect();
        let uvs: Vec<[f32; 2]> = reader.read_tex_coords(0).unwrap().into_f32().collect();
        quads += reader.read_indices().unwrap().into_u32().count() / 6;
        let is_at = |found: &[[f64; 3]], yaw: f64| {
            let shown = shown(trained, yaw);
            for ((found, point), depth) in found.iter().zip(&shown.points).zip(&shown.depths) {
                let expected =
                    [(point[0] - 80.0) / 192.0, (96.0 - point[1]) / 192.0, -depth / 192.0];
                assert!((0..3).all(|axis| (found[axis] - expected[axis]).abs() < ROUNDING));
            }
        };
        let own: Vec<[f64; 3]> = own.into_iter().map(|place| place.map(f64::from)).collect();
        assert_eq!((own.len(), uvs.len()), (128, 128));
        is_at(&own, rest);
        let mut count = 0;
        for ((positions, ..), yaw) in reader.read_morph_targets().zip(targets) {
            let moved = positions.unwrap().zip(&own);
            let moved = moved.map(|(by, own)| [0, 1, 2].map(|k| own[k] + f64::from(by[k])));
            is_at(&moved.collect::<Vec<_>>(), *yaw);
            count += 1;
        }
        assert_eq!(count, targets.len());
        let name = primitive.material().name().unwrap().to_owned();
        let key = trained.model.keys.iter().find(|key| key.name == name).unwrap();
        for (uv, place) in uvs.iter().zip(&key.points) {
            let expected = [place[0] / 160.0, place[1] / 192.0];
            assert!((0..2).all(|axis| (f64::from(uv[axis]) - expected[axis]).abs() < 1e-6));
        }
    }
    assert_eq!(quads, trained.model.mesh.element_len(), "each once");
}

#[test]
fn a_head_of_views_is_valid_and_stands_as_the_model_has_it() {
    let (trained, file) = head();
    let sides = [Side { name: "yaw".to_owned(), range: Some([-60.0, 60.0]), nodes: 5 }];
    let grid = Grid::of_sides(&file, None, &Values::new(), &sides).unwrap();
    let bytes = glb(&file, None, &grid).unwrap();
    shows(&bytes, &trained, 0.0, &[-60.0, -30.0, 0.0, 30.0, 60.0]);
    valid("views-grid", &bytes);
    // Key views' parameters are found of their points.
    let grid = Grid::of_key_views(&file, None).unwrap();
    let bytes = glb(&file, None, &grid).unwrap();
    let yaws: Vec<f64> = (0..12).map(|view| 30.0 * f64::from(view)).collect();
    shows(&bytes, &trained, 180.0, &yaws);
    valid("views-keys", &bytes);
}
