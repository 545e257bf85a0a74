//! Prints what evaluation costs beside plain skinning: `cargo bench -p sinew-trainer --bench
//! runtime`. One core; medians of runs taken in turn, so that ratios hold on a busy machine.
//!
//! Plain skinning is the same skin stage with the character's joints for a palette, and a loop as
//! an engine without SIMD would write it.

use sinew_runtime::envelope::{Attribute, Buffer, SkinJob};
use sinew_runtime::{EvalError, Matrix3x4, Model};
use sinew_trainer::demo::{DemoOptions, demo};
use sinew_trainer::envelope::rotational::Options;
use sinew_trainer::envelope::train;
use sinew_trainer::progress::Silent;
use std::error::Error;
use std::hint::black_box;
use std::time::Instant;

const RUNS: usize = 201;

fn main() -> Result<(), Box<dyn Error>> {
    let examples =
        demo(&DemoOptions { vertices: 10_000, poses: 60, held_out: 10, ..DemoOptions::default() });
    let trained = train(&examples, &Options::default(), &Silent)?;
    let envelope = Model::from_bytes(&trained.model)?.envelope().ok_or("no envelope")?;
    let vertices = envelope.vertex_len();
    let pose: Vec<Matrix3x4> =
        examples.pose(65).iter().map(|m| m.map(|row| row.map(|x| x as f32))).collect();
    let mut workspace = vec![0.0; envelope.workspace_len()];
    let mut palette = vec![Matrix3x4::default(); envelope.palette_len()];
    envelope.palette(&pose, &mut workspace, &mut palette)?;
    let mut positions = vec![[0.0; 3]; vertices];
    let mut plain = positions.clone();
    let mut normals = vec![0.0; 3 * vertices];
    let mut with_normals = vec![0.0; 3 * vertices];
    let influences: Vec<(usize, f32)> = (0..vertices)
        .flat_map(|v| {
            let mut all: Vec<_> = envelope.influences(v).collect();
            all.resize(envelope.influence_len(), (0, 0.0));
            all
        })
        .collect();
    let rest: Vec<[f32; 3]> =
        (0..vertices).map(|v| envelope.rest_position(v).unwrap_or_default()).collect();

    let mut predict_seconds = Vec::new();
    let mut skin_seconds = Vec::new();
    let mut normal_seconds = Vec::new();
    let mut plain_seconds = Vec::new();
    for _ in 0..RUNS {
        predict_seconds.push(timed(|| {
            for _ in 0..16 {
                envelope.palette(black_box(&pose), &mut workspace, &mut palette)?;
            }
            Ok(())
        })?);
        skin_seconds.push(timed(|| envelope.skin_positions(black_box(&palette), &mut positions))?);
        normal_seconds.push(timed(|| {
            let attribute = |buffer| Some(Attribute { buffer, offset: 0, stride: 3 });
            SkinJob {
                envelope,
                palette: black_box(&palette),
                vertices: 0..vertices,
                positions: attribute(Buffer::A),
                normals: attribute(Buffer::B),
                tangents: None,
                out_a: &mut with_normals,
                out_b: &mut normals,
            }
            .run()
        })?);
        plain_seconds.push(timed(|| {
            skin_plainly(black_box(&palette), &influences, &rest, &mut plain);
            Ok(())
        })?);
    }
    black_box((&positions, &normals, &with_normals, &plain));
    let per_vertex = |seconds: f64| 1e9 * seconds / vertices as f64;
    let predict = median(predict_seconds) / 16.0;
    let (skin, normals, plain) =
        (median(skin_seconds), median(normal_seconds), median(plain_seconds));
    println!(
        "{vertices} vertices, {} joints, {} proxies, {} influences",
        envelope.joint_len(),
        envelope.proxy_len(),
        envelope.influence_len()
    );
    println!("pose to palette            {:>8.2} µs a character", 1e6 * predict);
    println!("skin positions             {:>8.2} ns a vertex", per_vertex(skin));
    println!("skin positions and normals {:>8.2} ns a vertex", per_vertex(normals));
    println!("plain loop, positions      {:>8.2} ns a vertex", per_vertex(plain));
    println!("skin / plain loop          {:>8.2}", skin / plain);
    println!("(palette + skin) / skin    {:>8.2}", (predict + skin) / skin);
    Ok(())
}

/// Linear blend skinning as written without a thought of SIMD.
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

fn timed(run: impl FnOnce() -> Result<(), EvalError>) -> Result<f64, EvalError> {
    let start = Instant::now();
    run()?;
    Ok(start.elapsed().as_secs_f64())
}

fn median(mut seconds: Vec<f64>) -> f64 {
    seconds.sort_by(f64::total_cmp);
    seconds[seconds.len() / 2]
}
