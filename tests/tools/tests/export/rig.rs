//! The demo's rig and point cache contain the demo.

use super::scene::Scene;
use super::{arm, farthest, vectors};
use nalgebra::{Matrix4, Vector3};
use sinew_runtime::envelope::Predictor;
use sinew_trainer::envelope::s3::ProxyCount;
use sinew_trainer::envelope::{Options, Predict, train};
use sinew_trainer::evaluate::{Frames, evaluate};
use sinew_trainer::examples::{Examples, Loaded, Source, Split, load};
use sinew_trainer::export::{by_use, demo_glb};
use sinew_trainer::formats::save_pc2;
use sinew_trainer::progress::Silent;

/// Reads a point cache; returns the points per sample and the samples' positions.
fn read_pc2(bytes: &[u8]) -> (usize, Vec<[f64; 3]>) {
    let word = |at: usize| -> [u8; 4] { bytes[at..at + 4].try_into().unwrap() };
    assert_eq!(&bytes[..12], b"POINTCACHE2\0");
    assert_eq!(i32::from_le_bytes(word(12)), 1);
    assert_eq!([word(20), word(24)].map(f32::from_le_bytes), [0.0, 1.0]);
    let [points, samples] = [word(16), word(28)].map(|x| i32::from_le_bytes(x) as usize);
    assert_eq!(bytes.len(), 32 + 12 * points * samples);
    let float = |at: usize| f64::from(f32::from_le_bytes(word(at)));
    let position = |i: usize| [0, 4, 8].map(|axis| float(32 + 12 * i + axis));
    (points, (0..points * samples).map(position).collect())
}

/// Reads the examples from a rig and a point cache.
fn read_back(examples: &Examples) -> Examples {
    let folder = std::env::temp_dir().join(format!("sinew-rig-{}.pc2", std::process::id()));
    save_pc2(&folder, examples.vertex_len(), &examples.vertices).unwrap();
    let (points, vertices) = read_pc2(&std::fs::read(&folder).unwrap());
    std::fs::remove_file(folder).unwrap();
    assert_eq!(points, examples.vertex_len());

    let (_, clips) = by_use(examples.clone());
    let scene = Scene::read(&demo_glb(examples, &clips).unwrap());
    let skin = scene.gltf.skins().next().unwrap();
    let names: Vec<_> = skin.joints().map(|joint| joint.name().unwrap().to_owned()).collect();
    assert_eq!(names, examples.skeleton.names);
    for (joint, parent) in examples.skeleton.parents.iter().enumerate() {
        let above = parent.map_or("armature", |parent| &names[parent]);
        let above = scene.gltf.nodes().nth(scene.node(above)).unwrap();
        assert!(above.children().any(|child| child.name() == Some(&names[joint])));
    }
    let at_rest = scene.palette(&scene.worlds(None));
    let rest = scene.skinned("skin", &at_rest);
    let corners = scene.indices("skin");
    assert_eq!(corners, examples.triangles.as_flattened());
    let mut transforms = Vec::new();
    for (animation, clip) in clips.iter().enumerate() {
        assert_eq!(scene.times(animation).len(), clip.times.len());
        for key in 0..clip.times.len() {
            let palette = scene.palette(&scene.worlds(Some((animation, key, 0.0))));
            let rows = |m: &Matrix4<f64>| [0, 1, 2].map(|r| [0, 1, 2, 3].map(|c| m[(r, c)]));
            transforms.extend(palette.iter().map(rows));
        }
    }
    let rest = rest.into_iter().map(Into::into).collect();
    Examples { rest, vertices, transforms, ..examples.clone() }
}

#[test]
fn joints_and_meshes_survive_single_precision() {
    let (examples, clips) = by_use(arm(400));
    let found = clips.iter().map(|clip| (clip.name.as_str(), clip.first, clip.times.len()));
    assert_eq!(found.collect::<Vec<_>>(), [("train", 0, 30), ("held-out", 30, 10)]);
    assert_eq!(examples.frames_of(Split::Train), (0..30).collect::<Vec<_>>());
    let read = read_back(&examples);
    let unit = examples.diagonal();
    assert!(farthest(&vectors(&read.rest), &vectors(&examples.rest)) < 1e-7 * unit * 2.0);
    assert!(farthest(&vectors(&read.vertices), &vectors(&examples.vertices)) < 1e-7 * unit * 2.0);
    // Compares only the effect of a joint on the points around it.
    let mut most: f64 = 0.0;
    for (found, expected) in read.transforms.iter().zip(&examples.transforms) {
        for x in &examples.rest {
            let moved = |m: &[[f64; 4]; 3]| {
                Vector3::from(m.map(|[a, b, c, d]| a * x[0] + b * x[1] + c * x[2] + d))
            };
            most = most.max((moved(found) - moved(expected)).norm());
        }
    }
    println!("joints are off by {:.1e} of the diagonal at most", most / unit);
    assert!(most < 4e-7 * unit, "{}", most / unit);
}

#[test]
fn the_rig_trains_to_the_model_of_the_demo() {
    let (examples, clips) = by_use(arm(400));
    let folder = std::env::temp_dir().join(format!("sinew-rig-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let [glb, pc2] = ["demo.glb", "demo.pc2"].map(|file| folder.join(file));
    std::fs::write(&glb, demo_glb(&examples, &clips).unwrap()).unwrap();
    save_pc2(&pc2, examples.vertex_len(), &examples.vertices).unwrap();
    let Loaded { examples: mut read, clips, warnings } =
        load(&Source { targets: Some(&pc2), ..Source::file(&glb) }).unwrap();
    std::fs::remove_dir_all(folder).unwrap();
    assert_eq!(warnings, []);
    read.hold_out_clips(&clips, &["held-out".to_owned()]).unwrap();
    assert_eq!(read.split, examples.split);
    // The demo itself has no skin that binds vertices to near joints.
    assert_eq!(
        read.joint_weights.take().map(|all| all.len()),
        Some(read.rest.len() * read.joint_len())
    );
    let proxies = Some(ProxyCount::Fixed(6));
    for predictor in [Predictor::Kernel, Predictor::Rotational] {
        let predictor = Predict::Only(predictor);
        let options = Options { predictor, proxies, ..Options::default() };
        let rms = [&examples, &read].map(|source| {
            let model = train(source, &options, &Silent).unwrap().model;
            evaluate(&model, None, &examples, Frames::Of(Split::HeldOut))
                .unwrap()
                .errors
                .rms_percent
        });
        println!("held-out error of the demo {:.6} %, of its files {:.6} %", rms[0], rms[1]);
        assert!((rms[1] / rms[0] - 1.0).abs() < 1e-3, "{rms:?}");
    }
}
