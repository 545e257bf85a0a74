//! Bakes the models that `tests/firmware` holds in flash: `firmware_models FOLDER`.

use conformance::models::{Shape, random_with, row_major, trained, with_coefficients};
use faer::Mat;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sinew_runtime::envelope::{GroupKernel, HelperKind, Predictor};
use sinew_trainer::envelope::model::{Feature, Group, Input};
use sinew_trainer::regression::confidence::MapConfidence;
use sinew_trainer::regression::map::KernelMap;
use std::path::PathBuf;
use std::process::ExitCode;

/// Number of values of a certainty, m.
const CERTAINTY: usize = 8;

fn main() -> ExitCode {
    let Some(folder) = std::env::args_os().nth(1).map(PathBuf::from) else {
        eprintln!("usage: firmware_models FOLDER");
        return ExitCode::from(2);
    };
    let demos = Predictor::ALL.into_iter().zip(trained());
    let demos = demos.map(|(predictor, file)| (format!("demo-{}", predictor.name()), file.clone()));
    let bars = [Predictor::Rotational, Predictor::Kernel];
    let bars = bars.map(|predictor| (format!("bar-{}", predictor.name()), bar(predictor)));
    let normals = with_coefficients(&bar(Predictor::Rotational), 4.0);
    let normals = ("bar-normals".to_owned(), normals);
    for (name, file) in demos.chain(bars).chain([normals]) {
        let path = folder.join(name).with_extension("snw");
        // An unchanged file keeps its date, so that the images that hold it are not rebuilt.
        if std::fs::read(&path).is_ok_and(|old| old == file) {
            continue;
        }
        if let Err(error) = std::fs::write(&path, file) {
            eprintln!("{}: {error}", path.display());
            return ExitCode::FAILURE;
        }
    }
    ExitCode::SUCCESS
}

/// Bakes a model of the budget's shape: J = 20, P = 20, V = 1000, K = 4. No joint can leave its
/// range, so the maps are evaluated in full for every pose.
fn bar(predictor: Predictor) -> Vec<u8> {
    let shape = Shape {
        predictor,
        vertices: 1000,
        joints: 20,
        proxies: 20,
        influences: 4,
        tangents: true,
        coefficients: false,
        stretches: false,
        curves: 0,
        kind: HelperKind::Affine,
    };
    let groups = if predictor.corrects() { groups(shape) } else { Vec::new() };
    random_with(shape, groups, vec![10.0; shape.joints])
}

/// Makes a group of two helpers for every other joint. Each group has 16 centres, 16 latent values
/// and 45 inputs: the rotations of the five joints within two hops.
fn groups(shape: Shape) -> Vec<Group> {
    let mut random = ChaCha8Rng::seed_from_u64(16);
    let mut list = |len: usize, size: f64| -> Vec<_> {
        (0..len).map(|_| random.random_range(-size..=size)).collect()
    };
    let (centres, rank, proxies) = (16, 16, 2);
    let group = |g: usize| {
        let joint = 2 * g;
        let first = joint.saturating_sub(2).min(shape.joints - 5)..;
        let rotation = |joint: usize| {
            let entries = (0..12).filter(|entry| entry % 4 < 3);
            entries.map(move |entry| Feature::Joint { joint, entry })
        };
        let inputs: Vec<_> = first
            .take(5)
            .flat_map(rotation)
            .map(|feature| Input { feature, weight: 0.5 })
            .collect();
        let d = inputs.len();
        let rows = rank + CERTAINTY;
        let coordinates = list(centres * d, 0.3);
        Group {
            joint,
            proxies: g * proxies..(g + 1) * proxies,
            inputs,
            map: KernelMap {
                kernel: GroupKernel::Gaussian,
                centres: Mat::from_fn(d, centres, |i, k| coordinates[k * d + i]),
                coefficients: row_major(&list(rows * (centres + d), 0.1), rows, centres + d),
                confidence: MapConfidence {
                    len: CERTAINTY,
                    reach: 1e3,
                    linear: 0.0,
                    signal: 1.0,
                    noise: 0.0,
                },
            },
            outputs: row_major(&list(12 * proxies * rank, 0.1), 12 * proxies, rank),
        }
    };
    (0..shape.proxies / proxies).map(group).collect()
}
