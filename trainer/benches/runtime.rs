//! Prints the cost of evaluation relative to plain skinning: `cargo bench -p sinew-trainer --bench
//! runtime`, and with `RUSTFLAGS="-C target-cpu=x86-64-v3"` on wider registers. Runs use one core.
//! Medians are of alternating runs, so that ratios hold on a busy machine. Sets that are missing in
//! `../shared/data` are skipped, and their names are printed.
//!
//! Plain skinning is measured twice: by the skin stage with the character's joints as palette, and by a plain loop, as
//! in an engine without SIMD.

use faer::Mat;
use sinew_runtime::envelope::{Certificate, GroupKernel, HelperKind, Predictor};
use sinew_runtime::skin::Output;
use sinew_runtime::{CallError, Envelope, Matrix3x4, Model, Skin, SkinJob};
use sinew_trainer::envelope::model::{EnvelopeModel, FeatureOrder, FileModel, Group, Input};
use sinew_trainer::envelope::s3::ProxyCount;
use sinew_trainer::envelope::{Options, Predict, train};
use sinew_trainer::examples::demo::{DemoOptions, demo};
use sinew_trainer::examples::{Examples, Skeleton, Split, npz};
use sinew_trainer::numeric::trs::Place;
use sinew_trainer::progress::Silent;
use sinew_trainer::regression::confidence::MapConfidence;
use sinew_trainer::regression::map::KernelMap;
use std::error::Error;
use std::hint::black_box;
use std::path::Path;
use std::time::Instant;

const RUNS: usize = 201;

/// Sets whose kernel maps and skins are timed, and their proxies.
const SETS: [(&str, &str, usize); 4] = [
    ("mpfb-arm", "mpfb-arm/mpfb_arm.npz", 40),
    ("mpfb-body", "mpfb-body/mpfb_body.npz", 60),
    ("stretchy", "stretchy/set.npz", 40),
    ("face-curves", "face-curves/set.npz", 40),
];

fn main() -> Result<(), Box<dyn Error>> {
    let examples =
        demo(&DemoOptions { vertices: 10_000, poses: 60, held_out: 10, ..DemoOptions::default() });
    let model = Model::from_bytes(trained(&examples, Predictor::Rotational, 40)?)?;
    let envelope = model.first::<Envelope>().ok_or("no envelope")?;
    let skin = model.first::<Skin>().ok_or("no skin")?;
    let vertices = skin.vertex_len();
    let pose = posed(&examples, 65);
    let mut scratch = vec![0.0; envelope.scratch_len()];
    let mut palette = vec![Matrix3x4::default(); envelope.palette_len()];
    envelope.palette(&pose, &[], &mut scratch, &mut palette)?;
    let mut positions = vec![[0.0; 3]; vertices];
    let mut plain = positions.clone();
    let mut normals = vec![0.0; 3 * vertices];
    let mut with_normals = vec![0.0; 3 * vertices];
    let influences: Vec<(usize, f32)> = (0..vertices)
        .flat_map(|v| {
            let mut all: Vec<_> = skin.influences(v).collect();
            all.resize(skin.influence_len(), (0, 0.0));
            all
        })
        .collect();
    let rest: Vec<[f32; 3]> =
        (0..vertices).map(|v| skin.rest_position(v).unwrap_or_default()).collect();

    let mut predict_seconds = Vec::new();
    let mut skin_seconds = Vec::new();
    let mut normal_seconds = Vec::new();
    let mut plain_seconds = Vec::new();
    for _ in 0..RUNS {
        predict_seconds.push(timed(|| {
            for _ in 0..16 {
                envelope.palette(black_box(&pose), &[], &mut scratch, &mut palette)?;
            }
            Ok(())
        })?);
        skin_seconds.push(timed(|| skin.skin_positions(black_box(&palette), &mut positions))?);
        normal_seconds.push(timed(|| {
            positions_and_normals(skin, black_box(&palette), &mut with_normals, &mut normals)
        })?);
        plain_seconds.push(timed(|| {
            skin_plainly(black_box(&palette), &influences, &rest, &mut plain);
            Ok(())
        })?);
    }
    black_box((&positions, &normals, &with_normals, &plain));
    let per_vertex = |seconds: f64| 1e9 * seconds / vertices as f64;
    let predict = median(predict_seconds) / 16.0;
    let (skinning, normals, plain) =
        (median(skin_seconds), median(normal_seconds), median(plain_seconds));
    println!(
        "{vertices} vertices, {} joints, {} proxies, {} influences",
        envelope.joint_len(),
        envelope.proxy_len(),
        skin.influence_len()
    );
    println!("pose to palette            {:>8.2} µs a character", 1e6 * predict);
    for kernel in GroupKernel::ALL {
        println!(
            "kernel maps, {:<14}{:>8.2} µs a character",
            kernel.name(),
            1e6 * correct(kernel)?
        );
    }
    for (name, file, proxies) in SETS {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data").join(file);
        if path.exists() {
            let examples = npz::load(&path)?.examples;
            let model = Model::from_bytes(trained(&examples, Predictor::Kernel, proxies)?)?;
            let envelope = model.first::<Envelope>().ok_or("no envelope")?;
            let frame = *examples.frames_of(Split::HeldOut).first().ok_or("nothing held out")?;
            let pose = posed(&examples, frame);
            let curves: Vec<f32> = examples.curves_of(frame).iter().map(|x| *x as f32).collect();
            let seconds = palette_seconds(&envelope, &pose, &curves)?;
            let row = format!("kernel, {name}, P {proxies}");
            println!("{row:<27}{:>8.2} µs a character", 1e6 * seconds);
            let seconds = joints_seconds(&envelope, &pose, &curves)?;
            println!("level joints               {:>8.2} µs a character", 1e6 * seconds);
            let seconds = check_seconds(&envelope, &pose, &curves)?;
            let joints = envelope.joint_len();
            println!("check_pose, {joints:<15}{:>8.2} µs a pose", 1e6 * seconds);
            skins(&model)?;
        } else {
            println!("{name}: not found in ../shared/data");
        }
    }
    println!("skin positions             {:>8.2} ns a vertex", per_vertex(skinning));
    println!("skin positions and normals {:>8.2} ns a vertex", per_vertex(normals));
    println!("with normals / without     {:>8.2}", normals / skinning);
    println!("plain loop, positions      {:>8.2} ns a vertex", per_vertex(plain));
    println!("skin / plain loop          {:>8.2}", skinning / plain);
    println!("(palette + skin) / skin    {:>8.2}", (predict + skinning) / skinning);
    Ok(())
}

/// Prints the cost of a model's skins at rest; the cost does not depend on the pose.
fn skins(model: &Model<Vec<u8>>) -> Result<(), Box<dyn Error>> {
    for skin in model.all::<Skin>() {
        let identity = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
        let palette = vec![identity; skin.palette_len()];
        let vertices = skin.vertex_len();
        let mut positions = vec![[0.0; 3]; vertices];
        let [mut with_normals, mut normals] = [const { Vec::new() }; 2];
        with_normals.resize(3 * vertices, 0.0);
        normals.resize(3 * vertices, 0.0);
        let [mut alone, mut both] = [const { Vec::new() }; 2];
        for _ in 0..RUNS {
            alone.push(timed(|| skin.skin_positions(black_box(&palette), &mut positions))?);
            both.push(timed(|| {
                let palette = black_box(&palette);
                positions_and_normals(skin, palette, &mut with_normals, &mut normals)
            })?);
        }
        black_box((&positions, &with_normals, &normals));
        let (alone, both) = (median(alone), median(both));
        let per_vertex = |seconds: f64| 1e9 * seconds / vertices as f64;
        let way = if skin.has_coefficients() { "tangent coefficients" } else { "cofactors" };
        let (name, k) = (skin.name(), skin.influence_len());
        println!("{name}: {vertices} vertices, {k} influences, normals by {way}");
        println!("skin positions             {:>8.2} ns a vertex", per_vertex(alone));
        println!("skin positions and normals {:>8.2} ns a vertex", per_vertex(both));
        println!("with normals / without     {:>8.2}", both / alone);
    }
    Ok(())
}

fn positions_and_normals(
    skin: Skin<'_>,
    palette: &[Matrix3x4],
    out_positions: &mut [f32],
    out_normals: &mut [f32],
) -> Result<(), CallError> {
    SkinJob::new(skin, palette)
        .positions(Output::new(out_positions, 3))
        .normals(Output::new(out_normals, 3))
        .run()
}

/// Trains a model and returns its file.
fn trained(
    examples: &Examples,
    predictor: Predictor,
    proxies: usize,
) -> Result<Vec<u8>, Box<dyn Error>> {
    let options = Options {
        predictor: Predict::Only(predictor),
        proxies: Some(ProxyCount::Fixed(proxies)),
        ..Options::default()
    };
    // In a separate thread: the training leaves wide registers in use, which would halve the speed
    // of all later measurements in this thread.
    let trained = std::thread::scope(|scope| {
        scope
            .spawn(|| train(examples, &options, &Silent))
            .join()
            .map_err(|_| "the training panicked")
    })??;
    Ok(trained.model)
}

fn posed(examples: &Examples, frame: usize) -> Vec<Matrix3x4> {
    examples.pose(frame).iter().map(|m| m.map(|row| row.map(|x| x as f32))).collect()
}

/// Returns the seconds from pose to palette of 20 joints and 40 helpers in 10 groups, each of 45
/// inputs, 64 centres and 24 latent values.
fn correct(kernel: GroupKernel) -> Result<f64, Box<dyn Error>> {
    let (joints, inputs, centres, rank, certainty, proxies) = (20, 45, 64, 24, 8, 4);
    let number = |i: usize| (0.37 * i as f64).sin();
    let matrix = |from: usize, rows, columns| {
        Mat::from_fn(rows, columns, |r, c| number(from + r * columns + c))
    };
    let order = FeatureOrder { joint_len: joints, stretches: false };
    let group = |g: usize| Group {
        joint: 2 * g,
        proxies: g * proxies..(g + 1) * proxies,
        inputs: (0..inputs)
            .map(|i| Input {
                feature: order.feature((12 * g + 5 * i) % (12 * joints)),
                weight: 0.5,
            })
            .collect(),
        map: KernelMap {
            kernel,
            centres: Mat::from_fn(inputs, centres, |i, k| number(k + i)),
            coefficients: matrix(g, rank + certainty, inputs + centres),
            confidence: MapConfidence {
                len: certainty,
                reach: 1e3,
                signal: 1.0,
                ..MapConfidence::default()
            },
        },
        outputs: matrix(g, 12 * proxies, rank),
    };
    let identity = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
    let envelope = EnvelopeModel {
        name: "kernel maps".to_owned(),
        skeleton: Skeleton {
            names: vec![String::new(); joints],
            parents: (0..joints).map(|joint| joint.checked_sub(1)).collect(),
            rest: vec![identity; joints],
            ..Skeleton::default()
        },
        reconstruction: None,
        groups: (0..10).map(group).collect(),
        helper_kind: HelperKind::Affine,
        places: vec![Place::at([0.0; 3]); 10 * proxies],
        pose_ranges: vec![1.0; joints],
        pose_gaps: vec![0.0; joints],
        stretch_ranges: None,
        curves: Vec::new(),
        certificate: Certificate::default(),
    };
    let file = FileModel { envelopes: vec![envelope], ..FileModel::default() };
    let model = Model::from_bytes(file.bake()?)?;
    let envelope = model.first::<Envelope>().ok_or("no envelope")?;
    let turned = |j: usize| {
        let (sin, cos) = (0.1 * number(j) as f32).sin_cos();
        [[cos, -sin, 0.0, 0.1], [sin, cos, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]
    };
    let pose: Vec<Matrix3x4> = (0..joints).map(turned).collect();
    palette_seconds(&envelope, &pose, &[])
}

/// Returns the seconds from pose to palette of an envelope with kernel maps.
fn palette_seconds(
    envelope: &Envelope<'_>,
    pose: &[Matrix3x4],
    curves: &[f32],
) -> Result<f64, Box<dyn Error>> {
    let mut scratch = vec![0.0; envelope.scratch_len()];
    let mut palette = vec![Matrix3x4::default(); envelope.palette_len()];
    let seconds = seconds_of(|| {
        let confidence = envelope.palette(black_box(pose), curves, &mut scratch, &mut palette)?;
        assert!(confidence > 0.0, "the maps run");
        Ok(())
    })?;
    black_box(&palette);
    Ok(seconds)
}

/// Returns the seconds from pose to palette without the correction.
fn joints_seconds(
    envelope: &Envelope<'_>,
    pose: &[Matrix3x4],
    curves: &[f32],
) -> Result<f64, Box<dyn Error>> {
    let mut scratch = vec![0.0; envelope.scratch_len()];
    let mut palette = vec![Matrix3x4::default(); envelope.palette_len()];
    let seconds = seconds_of(|| {
        let pose = black_box(pose);
        envelope.base_palette(pose, curves, &mut scratch, &mut palette).map(|_| ())
    })?;
    black_box(&palette);
    Ok(seconds)
}

/// Returns the seconds to check an acceptable pose.
fn check_seconds(
    envelope: &Envelope<'_>,
    pose: &[Matrix3x4],
    curves: &[f32],
) -> Result<f64, Box<dyn Error>> {
    envelope.check_pose(pose, curves)?;
    Ok(seconds_of(|| {
        assert!(envelope.check_pose(black_box(pose), curves).is_ok(), "the same pose as before");
        Ok(())
    })?)
}

/// Returns the seconds per call: the median over runs of 16 calls.
fn seconds_of(mut call: impl FnMut() -> Result<(), CallError>) -> Result<f64, CallError> {
    let mut seconds = Vec::new();
    for _ in 0..RUNS {
        seconds.push(timed(|| (0..16).try_for_each(|_| call()))?);
    }
    Ok(median(seconds) / 16.0)
}

/// Linear blend skinning in a plain loop, as in an engine without SIMD.
fn skin_plainly(
    palette: &[Matrix3x4],
    influences: &[(usize, f32)],
    rest: &[[f32; 3]],
    out: &mut [[f32; 3]],
) {
    let most = influences.len() / rest.len().max(1);
    for ((x, out), influences) in rest.iter().zip(out).zip(influences.chunks_exact(most)) {
        let mut blended = [[0.0; 4]; 3];
        for &(index, weight) in influences {
            for (row, from) in blended.iter_mut().zip(&palette[index]) {
                for (value, from) in row.iter_mut().zip(from) {
                    *value += weight * from;
                }
            }
        }
        *out = blended.map(|row| row[0] * x[0] + row[1] * x[1] + row[2] * x[2] + row[3]);
    }
}

fn timed(run: impl FnOnce() -> Result<(), CallError>) -> Result<f64, CallError> {
    let start = Instant::now();
    run()?;
    Ok(start.elapsed().as_secs_f64())
}

fn median(mut seconds: Vec<f64>) -> f64 {
    seconds.sort_by(f64::total_cmp);
    seconds[seconds.len() / 2]
}
