//! Scenes from files give the same models as their examples in arrays.

use models::shared;
use sinew_runtime::envelope::Predictor;
use sinew_trainer::envelope::s3::ProxyCount;
use sinew_trainer::envelope::{Options, Predict, Trained, train};
use sinew_trainer::evaluate::{Character, Frames, evaluate, skin};
use sinew_trainer::examples::{Examples, Loaded, Source, Split, Warning, load, load_poses};
use sinew_trainer::progress::Silent;

/// Returns options for one predictor and a number of proxies.
fn options(predictor: Predictor, proxies: usize) -> Options {
    let (predictor, proxies) = (Predict::Only(predictor), Some(ProxyCount::Fixed(proxies)));
    Options { predictor, proxies, ..Options::default() }
}

/// Returns the largest distance between the skins of two models over the held-out frames, as a
/// share of the diagonal.
fn apart(a: (&Trained, &Examples), b: (&Trained, &Examples)) -> f64 {
    let examples = b.1;
    let skinned = |(trained, own): (&Trained, &Examples), frame: usize| {
        let character = Character::open(&trained.model, None, own).unwrap();
        let skinned = skin(&character, examples, frame).unwrap();
        let positions: &[[f32; 3]] = skinned.positions.as_chunks().0;
        own.surface().of_first_copies(positions)
    };
    let mut farthest: f64 = 0.0;
    for frame in examples.frames_of(Split::HeldOut) {
        let [a, b] = [a, b].map(|model| skinned(model, frame));
        for (a, b) in a.as_flattened().iter().zip(b.as_flattened()) {
            farthest = farthest.max(f64::from((a - b).abs()));
        }
    }
    farthest / examples.diagonal()
}

/// Combines the joints of an FBX scene without a skin with the meshes of arrays in other axes. The
/// arrays were made from that scene by another reader, in single precision.
#[test]
fn joints_of_a_scene_with_meshes_of_arrays_give_the_model_of_the_arrays() {
    let Some(folder) = shared("dem-bones") else { return };
    let [scene, arrays] = ["Bone_Trans.fbx", "bone.npz"].map(|file| folder.join(file));
    let joined = load(&Source { targets: Some(&arrays), ..Source::file(&scene) }).unwrap();
    let Loaded { examples: joined, clips, warnings } = joined;
    let whole = load(&Source::file(&arrays)).unwrap().examples;
    assert_eq!((clips.len(), clips[0].times.len()), (1, 400));
    let how = "(x, -z, y)".to_owned();
    assert!(warnings.contains(&Warning::Moved { what: "joints", how }), "{warnings:?}");
    assert_eq!(joined.skeleton.names, whole.skeleton.names);
    assert_eq!(joined.skeleton.parents, whole.skeleton.parents);
    assert_eq!(joined.split, whole.split);
    assert_eq!(joined.vertices, whole.vertices);

    // Only the unrefined reconstruction: the refinement learns from kernels.
    let unrefined = Options { refine: false, ..options(Predictor::Rotational, 20) };
    let [a, b] = [&joined, &whole].map(|examples| train(examples, &unrefined, &Silent).unwrap());
    // The scene's texture has seams; the arrays have none.
    assert!(joined.surface().engine_len() > 754 && whole.surface().engine_len() == 754);
    let apart = apart((&a, &joined), (&b, &whole));
    assert!(apart < 2e-6, "{apart:e}");
    // Kernels are chosen from a list, where rounding can decide between ties.
    for (predictor, proxies) in [(Predictor::Kernel, 40), (Predictor::Rotational, 20)] {
        let [a, b] = [&joined, &whole].map(|examples| {
            let model = train(examples, &options(predictor, proxies), &Silent).unwrap().model;
            evaluate(&model, None, examples, Frames::Of(Split::HeldOut)).unwrap().errors.rms
        });
        assert!((a / b - 1.0).abs() < 0.03, "{predictor:?}: {a} against {b}");
    }
}

/// Converts the poses of a scene without a skin to the axes of a model.
#[test]
fn poses_are_moved_to_where_a_model_is() {
    let Some(folder) = shared("dem-bones") else { return };
    let [scene, arrays] = ["Bone_Trans.fbx", "bone.npz"].map(|file| folder.join(file));
    let error = load(&Source::file(&scene)).unwrap_err().to_string();
    assert!(error.contains("holds poses but neither a skin nor shapes"), "{error}");

    let whole = load(&Source::file(&arrays)).unwrap().examples;
    let mut poses = load_poses(&Source::file(&scene)).unwrap().examples;
    let trained = train(&whole, &options(Predictor::Rotational, 4), &Silent).unwrap();
    let refused = Character::open(&trained.model, None, &poses).err().unwrap().to_string();
    assert!(refused.starts_with("the model has 754 vertices, the examples have 8"), "{refused}");
    poses.unsplit_for(754);
    let refused = Character::open(&trained.model, None, &poses).err().unwrap().to_string();
    assert!(refused.starts_with("the model's rest mesh is not that of the examples"), "{refused}");
    let how = "(x, -z, y)".to_owned();
    assert_eq!(poses.move_to(&whole.rest).unwrap(), Some(Warning::Moved { what: "poses", how }));
    assert!(Character::open(&trained.model, None, &poses).is_ok());
    let [found, expected] = [&poses, &whole].map(|examples| examples.transforms.as_flattened());
    let differences = found.as_flattened().iter().zip(expected.as_flattened());
    let most = differences.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(most < 2e-6, "{most:e}");
    assert_eq!(poses.move_to(&whole.rest).unwrap(), None);

    let mut other = whole.rest.clone();
    other.iter_mut().for_each(|x| x[1] *= 1.1);
    let error = poses.move_to(&other).unwrap_err().to_string();
    assert!(error.starts_with("its rest mesh is not that of the model"), "{error}");
    assert!(error.ends_with("at best"), "{error}");
    let reversed: Vec<_> = whole.rest.iter().rev().map(|x| x.map(|x| 100.0 * x)).collect();
    let error = poses.move_to(&reversed).unwrap_err().to_string();
    assert!(error.contains("the same vertices in another order"), "{error}");
}
