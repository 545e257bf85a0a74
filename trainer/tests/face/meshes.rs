//! A face without blendshapes: its shapes are principal components of example meshes, here of a
//! published model of planar landmarks.

use crate::face::{loaded, options};
use models::shared;
use serde_json::Value;
use sinew_runtime::prior::{Anchor, Pin, PinJob};
use sinew_trainer::face::baked::BakedFace;
use sinew_trainer::face::basis::ExampleMeshes;
use sinew_trainer::face::train::of_meshes;
use sinew_trainer::formats::ShapedMesh;

/// Mean of V points, and modes with their variances; each mode is an orthonormal vector.
struct Published {
    mean: Vec<[f64; 2]>,
    modes: Vec<(f64, Vec<[f64; 2]>)>,
}

fn published() -> Option<Published> {
    let file = shared("clm71-shape/clm71_pca20.json")?;
    let json: Value = serde_json::from_slice(&std::fs::read(file).unwrap()).unwrap();
    let number = |value: &Value| value.as_f64().unwrap();
    let mean: Vec<[f64; 2]> = json["meanShape"]
        .as_array()
        .unwrap()
        .iter()
        .map(|point| [number(&point[0]), number(&point[1])])
        .collect();
    let mode = |mode: usize| {
        let at = |row: usize| number(&json["eigenVectors"][row][mode]);
        let vector = (0..mean.len()).map(|v| [at(2 * v), at(2 * v + 1)]).collect();
        (number(&json["eigenValues"][mode]), vector)
    };
    let modes = (0..20).map(mode).collect();
    Some(Published { mean, modes })
}

impl Published {
    /// Makes meshes whose covariance is the model's: each mode alone, in both directions.
    fn meshes(&self) -> ExampleMeshes {
        let n = 2.0 * self.modes.len() as f64;
        let mut positions = Vec::new();
        for (variance, mode) in &self.modes {
            for side in [-1.0, 1.0] {
                let by = side * (variance * n / 2.0).sqrt();
                let at = |(p, u): (&[f64; 2], &[f64; 2])| [p[0] + by * u[0], p[1] + by * u[1], 0.0];
                positions.push(self.mean.iter().zip(mode).map(at).collect::<Vec<_>>());
            }
        }
        let mesh = ShapedMesh { positions: positions[0].clone(), ..ShapedMesh::default() };
        ExampleMeshes { mesh, positions }
    }
}

#[test]
fn components_of_meshes_are_the_published_modes() {
    let Some(published) = published() else { return };
    let (basis, model) = of_meshes(&published.meshes(), Some(20), &options()).unwrap();
    let len = published.mean.len() as f64;
    for (found, mean) in basis.mesh.positions.iter().zip(&published.mean) {
        assert!((found[0] - mean[0]).abs() < 1e-9 && (found[1] - mean[1]).abs() < 1e-9);
    }
    // The strongest first.
    let mut modes: Vec<_> = published.modes.iter().collect();
    modes.sort_by(|a, b| b.0.total_cmp(&a.0));
    for (shape, (variance, mode)) in modes.into_iter().enumerate() {
        let deltas = &basis.mesh.shapes[shape].deltas;
        let dot: f64 = deltas.iter().zip(mode).map(|(u, v)| u[0] * v[0] + u[1] * v[1]).sum();
        assert!((dot.abs() / len.sqrt() - 1.0).abs() < 1e-5, "mode {shape}: {dot}");
        let found = model.priors[0].covariance[(shape, shape)] * len;
        assert!((found / variance - 1.0).abs() < 1e-5, "mode {shape}: {found}, {variance}");
    }
}

#[test]
fn a_few_points_of_a_plane_say_where_the_others_are() {
    let Some(published) = published() else { return };
    let (_, model) = of_meshes(&published.meshes(), Some(20), &options()).unwrap();
    let model = loaded(&model);
    let face = BakedFace::open(&model).unwrap();
    // Three modes at two thirds of a standard deviation.
    let mut truth = vec![0.0; 20];
    for (mode, side) in [(0, 1.0), (1, -1.0), (2, 1.0)] {
        truth[mode] = side * f64::from(face.prior.weight_bounds(mode).unwrap()[1]) * 2.0 / 9.0;
    }
    let pinned = |vertex: usize| {
        let place = face.place(vertex, &truth).map(|x| x as f32);
        Pin::new(vertex as u32, place).masked([true, true, false])
    };
    let pins: Vec<Pin> = (0..71).step_by(7).map(pinned).collect();
    let mut weights = vec![0.0; 20];
    let options = PinJob { anchor: Anchor::Mean, ..face.edit() };
    face.solve(&pins, &options, &mut Vec::new(), &mut weights).unwrap();
    let wide: Vec<f64> = weights.into_iter().map(f64::from).collect();
    let apart = |weights: &[f64]| {
        let squares = (0..71).map(|v| {
            let (a, b) = (face.place(v, weights), face.place(v, &truth));
            (a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2)
        });
        (squares.sum::<f64>() / 71.0).sqrt()
    };
    let (found, nothing) = (apart(&wide), apart(&[0.0; 20]));
    assert!(found < 0.1 * nothing, "{found} of {nothing}");
}
