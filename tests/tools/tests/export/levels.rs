//! Further meshes on a model's palette.

use super::scene::Scene;
use super::{arm, clip, distances, export, farthest, model, pose, runtime_palette, vectors};
use nalgebra::Matrix4;
use sinew_runtime::envelope::Predictor;
use sinew_runtime::{Envelope, Model};
use sinew_trainer::envelope::levels::Level;
use sinew_trainer::examples::Examples;
use sinew_trainer::export::{Exported, Placement};
use sinew_trainer::formats::Mesh;
use sinew_trainer::mesh::EngineMesh;

fn level(name: &str, examples: &Examples) -> Level {
    let mesh = Mesh {
        positions: examples.rest.clone(),
        triangles: examples.triangles.clone(),
        engine: examples.engine.clone(),
    };
    Level { name: name.to_owned(), mesh, is_placed: false }
}

fn one(exported: &Exported) -> [f64; 3] {
    let report = &exported.levels[0];
    [report.distance_percent, report.transferred_percent, report.fitted_percent]
}

/// Skins a mesh of a file with the runtime's palettes of the frames, and returns the RMS distance
/// from the demo's true flesh, in % of the diagonal.
fn error(glb: &[u8], model: &[u8], examples: &Examples, truth: &Examples, frames: &[usize]) -> f64 {
    let (scene, model) = (Scene::read(glb), Model::from_bytes(model).unwrap());
    let envelope = model.first::<Envelope>().unwrap();
    let mut squares = 0.0;
    for &frame in frames {
        let square = |m: &[[f32; 4]; 3]| {
            Matrix4::from_fn(
                |r, c| if r < 3 { f64::from(m[r][c]) } else { f64::from(u8::from(c == 3)) },
            )
        };
        let palette = runtime_palette(&envelope, &pose(examples, frame));
        let palette: Vec<_> = palette.iter().map(square).collect();
        let found = scene.skinned("lod1", &palette);
        squares += distances(&found, &vectors(truth.frame(frame))).map(|d| d * d).sum::<f64>();
    }
    let count = (frames.len() * truth.vertex_len()) as f64;
    100.0 * (squares / count).sqrt() / truth.diagonal()
}

#[test]
fn the_model_s_own_mesh_in_another_order_moves_as_the_model_does() {
    let examples = arm(400);
    let model = model(&examples, Predictor::Kernel, 6, 4);
    let mut own = level("own", &examples);
    let last = examples.vertex_len() - 1;
    own.mesh.positions.reverse();
    own.mesh.triangles.iter_mut().flatten().for_each(|vertex| *vertex = last - *vertex);
    let uv = own.mesh.engine.take().and_then(|engine| engine.uv).unwrap();
    let uv: Vec<_> = uv.into_iter().rev().collect();
    own.mesh.engine = Some(EngineMesh::of_vertices(&own.mesh.positions, &own.mesh.triangles, &uv));
    let exported =
        export(&model, None, &examples, &[clip("all", 0, 20)], &[own], Placement::AsModel).unwrap();
    let scene = Scene::read(&exported.glb);
    for key in [0, 7, 19] {
        let palette = scene.palette(&scene.worlds(Some((0, key, 0.0))));
        let mut found = scene.skinned("own", &palette);
        found.reverse();
        let expected = scene.skinned("skin", &palette);
        assert!(farthest(&found, &expected) < 1e-5 * examples.diagonal());
    }
    let [distance, transferred, fitted] = one(&exported);
    assert!(distance < 1e-5 && transferred < 1e-4 && fitted <= transferred);
}

#[test]
fn a_coarser_mesh_is_fitted_and_comes_near_its_own_flesh() {
    let (examples, coarse) = (arm(1500), arm(300));
    let model = model(&examples, Predictor::Kernel, 20, 4);
    let fit = |frames: usize| {
        export(
            &model,
            None,
            &examples,
            &[clip("all", 0, frames)],
            &[level("lod1", &coarse)],
            Placement::AsModel,
        )
        .unwrap()
    };
    let all = examples.frame_len();
    let exported = fit(all);
    let [distance, transferred, fitted] = one(&exported);
    println!("distance {distance:.4}, transferred {transferred:.4}, fitted {fitted:.4} %");
    assert!(fitted < 0.7 * transferred && transferred < 0.5);
    let frames: Vec<usize> = (0..all).collect();
    let seen = error(&exported.glb, &model, &examples, &coarse, &frames);
    // Three frames must not make the other frames worse.
    let few = error(&fit(3).glb, &model, &examples, &coarse, &frames);
    println!("from its own flesh: {seen:.4} %, fitted to three frames {few:.4} %");
    assert!(seen < 0.3 && few < 1.1 * transferred.max(seen));
}

#[test]
fn a_mesh_in_other_axes_and_units_is_converted_or_reported_and_strays_are_reported() {
    let examples = arm(300);
    let model = model(&examples, Predictor::Rotational, 4, 4);
    let clips = [clip("all", 0, 4)];
    let exported =
        |level: Level| export(&model, None, &examples, &clips, &[level], Placement::AsModel);
    let turned = |change: fn([f64; 3]) -> [f64; 3]| {
        let mut level = level("lod1", &examples);
        level.mesh.positions.iter_mut().for_each(|x| *x = change(*x));
        level
    };
    let own = exported(turned(|x| x)).unwrap();
    assert_eq!(own.levels[0].moved, None);
    let moved = exported(turned(|[x, y, z]| [100.0 * x, -100.0 * z, 100.0 * y])).unwrap();
    assert_eq!(moved.levels[0].moved.as_deref(), Some("(x, z, -y) x 0.01"));
    let found = [&own, &moved].map(|exported| {
        let scene = Scene::read(&exported.glb);
        scene.skinned("lod1", &scene.palette(&scene.worlds(Some((0, 2, 0.0)))))
    });
    assert!(farthest(&found[0], &found[1]) < 1e-6);

    let far = exported(turned(|x| x.map(|x| 1e6 * x))).map(|exported| exported.levels).unwrap_err();
    let percent = far.message().strip_prefix("mesh lod1 is ").and_then(|rest| {
        let (number, rest) = rest.split_once(" % ")?;
        let expected = "of the diagonal away from the model's surface, expected at most 10 %";
        number.parse::<f64>().ok().filter(|_| rest.starts_with(expected))
    });
    assert!(percent.is_some_and(|percent| percent > 100.0), "{far}");
    let mut stray = level("lod1", &examples);
    stray.mesh.positions[5] = [9.0, 9.0, 9.0];
    let exported = export(&model, None, &examples, &clips, &[stray], Placement::AsModel).unwrap();
    assert_eq!(exported.levels[0].far, 1);
}
