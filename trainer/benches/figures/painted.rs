//! The effect of an artist's painted joint weights on a fit.

use super::{SETS, found, trained_on_first};
use sinew_trainer::envelope::{Options, train};
use sinew_trainer::evaluate::{Frames, evaluate};
use sinew_trainer::examples::{Examples, Source, Split, load, npz};
use sinew_trainer::progress::Silent;
use std::error::Error;
use std::fs::File;

/// Prints the effect of painted joint weights on the errors of LBS and of a model: held out, in
/// range, and outside the clip or the first frames of the training.
pub(crate) fn painted() -> Result<(), Box<dyn Error>> {
    let errors = |examples: &Examples| -> Result<[f64; 2], Box<dyn Error>> {
        let model = train(examples, &Options::default(), &Silent)?.model;
        let found = evaluate(&model, None, examples, Frames::Of(Split::HeldOut))?;
        Ok([found.lbs.rms_percent, found.errors.rms_percent])
    };
    println!("{:<26}{:>24}{:>24}", "LBS, model (%)", "without", "with");
    for (name, painted) in scenes()? {
        let plain = Examples { joint_weights: None, ..painted.clone() };
        let [[lbs, model], [lbs_with, model_with]] = [errors(&plain)?, errors(&painted)?];
        println!("{name:<26}{lbs:>16.4}{model:>8.4}{lbs_with:>16.4}{model_with:>8.4}");
    }
    Ok(())
}

/// Loads sets with an artist's painted weights, and scenes with the weights of their skin.
fn scenes() -> Result<Vec<(String, Examples)>, Box<dyn Error>> {
    let mut scenes = Vec::new();
    for (name, file) in SETS {
        let Some(path) = found(file) else { continue };
        let mut examples = npz::load(&path)?.examples;
        let mut archive = zip::ZipArchive::new(File::open(&path)?)?;
        let Ok(array) = archive.by_name("artist_lbs_weights.npy") else { continue };
        let weights = npyz::NpyFile::new(array)?.into_vec::<f32>()?;
        examples.joint_weights = Some(weights.into_iter().map(f64::from).collect());
        if name == "mpfb-arm" {
            for count in [12, 40] {
                scenes
                    .push((format!("{name}, {count} frames"), trained_on_first(&examples, count)));
            }
        }
        scenes.push((name.to_owned(), examples));
    }
    let [fbx, targets, fox] =
        ["leg/leg_strips.fbx", "leg/leg.abc", "gltf-loader/Fox.glb"].map(found);
    let leg = fbx.zip(targets.as_ref()).map(|(scene, targets)| (scene, Some(targets.as_path())));
    for (name, scene) in [("leg", leg), ("fox", fox.map(|scene| (scene, None)))] {
        let Some((scene, targets)) = scene else { continue };
        let loaded = load(&Source { targets, ..Source::file(&scene) })?;
        for trained in 0..2 {
            let mut examples = loaded.examples.clone();
            for frame in 0..examples.frame_len() {
                let own = examples.clip_of(frame) == trained + 1;
                examples.split[frame] = if own { Split::Train } else { Split::HeldOut };
            }
            scenes.push((format!("{name} trained on {}", loaded.clips[trained].name), examples));
        }
    }
    Ok(scenes)
}
