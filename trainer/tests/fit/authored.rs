//! Real files with seams: authored attributes arrive in the model's file and in an exported file.

use models::shared;
use sinew_runtime::envelope::Predictor;
use sinew_runtime::{Model, Skin};
use sinew_trainer::envelope::s3::ProxyCount;
use sinew_trainer::envelope::{Options, Predict, train};
use sinew_trainer::examples::{Examples, Loaded, Source, load};
use sinew_trainer::export::{Export, Placement, Playback};
use sinew_trainer::formats::appearance::Appearance;
use sinew_trainer::progress::Silent;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

fn model(examples: &Examples) -> Vec<u8> {
    let options = Options {
        predictor: Predict::Only(Predictor::Kernel),
        proxies: Some(ProxyCount::Fixed(4)),
        ..Options::default()
    };
    train(examples, &options, &Silent).unwrap().model
}

/// An attribute of all primitives of a glTF file, in order, as the gltf crate reads it.
struct Attributes {
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    uv: Vec<[f32; 2]>,
}

fn attributes(bytes: &[u8]) -> Attributes {
    let file = gltf::Gltf::from_slice(bytes).unwrap();
    let blob = file.blob.as_deref();
    let mut all = Attributes { positions: Vec::new(), normals: Vec::new(), uv: Vec::new() };
    for primitive in file.meshes().flat_map(|mesh| mesh.primitives()) {
        let reader = primitive.reader(|_| blob);
        all.positions.extend(reader.read_positions().unwrap());
        all.normals.extend(reader.read_normals().into_iter().flatten());
        all.uv.extend(reader.read_tex_coords(0).unwrap().into_f32());
    }
    all
}

fn bits<const N: usize>(values: [f64; N]) -> [u64; N] {
    values.map(f64::to_bits)
}

/// The arrays have one vertex per place, in another order; the scenes have y up, and one is in
/// centimetres.
#[test]
fn a_leg_s_scenes_with_its_arrays_train_with_their_seams() {
    let Some(folder) = shared("leg") else { return };
    let arrays = folder.join("leg.npz");
    let whole = load(&Source::file(&arrays)).unwrap().examples;
    let file = attributes(&std::fs::read(folder.join("leg.glb")).unwrap());
    let joined = |name: &str| {
        let scene = folder.join(name);
        load(&Source { targets: Some(&arrays), ..Source::file(&scene) }).unwrap().examples
    };
    for name in ["leg_strips.fbx", "leg.glb"] {
        let examples = joined(name);
        let surface = examples.surface();
        assert_eq!((examples.vertex_len(), surface.engine_len()), (3938, 4164), "{name}");
        // Every vertex moves like the vertex of the arrays at the same place.
        let numbers: BTreeMap<_, _> =
            whole.rest.iter().enumerate().map(|(number, x)| (bits(*x), number)).collect();
        let own: Vec<usize> = examples.rest.iter().map(|x| numbers[&bits(*x)]).collect();
        assert_eq!(own.iter().collect::<BTreeSet<_>>().len(), 3938);
        for frame in [0, 65, 100] {
            for (x, &number) in examples.frame(frame).iter().zip(&own) {
                assert_eq!(*x, whole.frame(frame)[number]);
            }
        }
        let bytes = model(&examples);
        let model = Model::from_bytes(&bytes[..]).unwrap();
        let skin = model.first::<Skin>().unwrap();
        assert!(skin.vertex_len() == 4164 && skin.has_tangents());
        if name == "leg.glb" {
            // The file's vertices in its order, in the arrays' axes.
            for vertex in 0..4164 {
                let turned = |[x, y, z]: [f32; 3]| [x, -z, y];
                for (found, expected) in [
                    (skin.rest_position(vertex).unwrap(), turned(file.positions[vertex])),
                    (skin.rest_normal(vertex).unwrap(), turned(file.normals[vertex])),
                ] {
                    let apart = found.iter().zip(expected).map(|(a, b)| (a - b).abs());
                    assert!(apart.fold(0.0, f32::max) < 1e-5, "{found:?} {expected:?}");
                }
                let [u, v] = surface.uv().unwrap()[vertex].map(|x| x as f32);
                assert_eq!([u, 1.0 - v], file.uv[vertex]);
            }
        }
    }
}

#[test]
fn the_fox_keeps_its_texture_and_is_smooth() {
    let Some(file) = shared("gltf-loader/Fox.glb") else { return };
    let Loaded { examples, clips, .. } = load(&Source::file(Path::new(&file))).unwrap();
    let bytes = model(&examples);
    let export = Export {
        playback: Playback {
            model: &bytes,
            skin: None,
            examples: &examples,
            clips: &clips,
            between: false,
            levels: &[],
        },
        appearance: &Appearance::default(),
        placement: Placement::AsModel,
    };
    let exported = export.run().unwrap().glb;
    let [before, after] = [std::fs::read(&file).unwrap(), exported].map(|bytes| attributes(&bytes));
    assert_eq!((after.positions.len(), after.uv.len()), (1728, 1728));
    for vertex in 0..1728 {
        let apart = (0..2).map(|k| (before.uv[vertex][k] - after.uv[vertex][k]).abs());
        assert!(apart.fold(0.0, f32::max) < 1e-6);
        let apart =
            (0..3).map(|k| (before.positions[vertex][k] - after.positions[vertex][k]).abs());
        assert!(apart.fold(0.0, f32::max) < 1e-3);
    }
    // The file has no normals: vertices at one place are shaded alike.
    assert!(before.normals.is_empty());
    let mut shaded = BTreeMap::new();
    for (x, n) in after.positions.iter().zip(&after.normals) {
        let known = *shaded.entry(x.map(f32::to_bits)).or_insert(*n);
        assert_eq!(known, *n);
    }
    assert_eq!(shaded.len(), 290);
}
