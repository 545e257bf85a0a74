//! A face as binary glTF: a mesh with morph targets and their weights, still or animated.

use super::baked::BakedFace;
use crate::Error;
use crate::formats::Mesh;
use crate::formats::gltf::write::{ArrayKind, ChannelKeys, Document, F32, Placed, Track};
use crate::mesh::Surface;
use serde_json::json;

/// Description in the file.
const NOTE: &str = "A face with its shapes as morph targets, by their names.";

/// Weights of the morph targets.
pub enum Weights<'a> {
    /// A still face: S.
    Still(&'a [f32]),
    /// An animation: time in seconds and weights (S) of each frame.
    Played(&'a [(f64, Vec<f32>)]),
}

/// Exports a face as binary glTF.
///
/// - `mesh`: the mesh beside the file, with the skin's vertices.
///
/// # Errors
/// The scene is too large; errors of the runtime.
pub fn glb(face: &BakedFace<'_>, mesh: &Mesh, weights: &Weights<'_>) -> Result<Vec<u8>, Error> {
    let surface = Surface { positions: &mesh.positions, ..mesh.surface() };
    let shape_len = face.skin.shape_len();
    let rest = face.shaped(&vec![0.0; shape_len])?;
    let copied = |all: &[[f64; 3]]| -> Vec<[f32; 3]> {
        surface.copied(all).into_iter().map(|v| v.map(|x| x as f32)).collect()
    };
    let mut document = Document::new(NOTE);
    let mut attribute = |name: &str, rows: &[[f32; 3]]| {
        let at = document.floats(ArrayKind::vertices(F32, "VEC3"), rows);
        document.bound(at, rows);
        (name.to_owned(), json!(at))
    };
    let directions = |normals: &[[f64; 3]]| -> Vec<[f32; 3]> {
        let one = |n: [f32; 3]| if n == [0.0; 3] { [0.0, 1.0, 0.0] } else { n };
        copied(normals).into_iter().map(one).collect()
    };
    let mut attributes = serde_json::Map::new();
    attributes.extend([attribute("POSITION", &copied(&rest.positions))]);
    attributes.extend([attribute("NORMAL", &directions(&rest.normals))]);
    let mut targets = Vec::new();
    for shape in 0..shape_len {
        let mut alone = vec![0.0; shape_len];
        alone[shape] = 1.0;
        let shaped = face.shaped(&alone)?;
        let by = |to: &[[f64; 3]], from: &[[f64; 3]]| -> Vec<[f64; 3]> {
            to.iter().zip(from).map(|(a, b)| [0, 1, 2].map(|k| a[k] - b[k])).collect()
        };
        let positions = copied(&by(&shaped.positions, &rest.positions));
        let normals = copied(&by(&shaped.normals, &rest.normals));
        let target: serde_json::Map<_, _> =
            [attribute("POSITION", &positions), attribute("NORMAL", &normals)]
                .into_iter()
                .collect();
        targets.push(target);
    }
    if let Some(uv) = surface.uv() {
        // In glTF v grows downward.
        let uv: Vec<_> = uv.iter().map(|&[u, v]| [u as f32, (1.0 - v) as f32]).collect();
        let at = document.floats(ArrayKind::vertices(F32, "VEC2"), &uv);
        attributes.insert("TEXCOORD_0".to_owned(), json!(at));
    }
    let indices = document.indices(surface.engine_triangles(), surface.engine_len());
    let primitive =
        json!({ "attributes": attributes, "indices": indices, "mode": 4, "targets": targets });
    let still = match weights {
        Weights::Still(weights) => weights.to_vec(),
        Weights::Played(frames) => frames.first().map(|(_, w)| w.clone()).unwrap_or_default(),
    };
    let name = face.skin.name();
    document.meshes.push(json!({
        "name": name, "primitives": [primitive], "weights": still, "extras": { "targetNames": face.names() },
    }));
    let node = document.node(name.to_owned(), None, &Placed::AT_PARENT);
    document.nodes[node]["mesh"] = json!(document.meshes.len() - 1);
    if let Weights::Played(frames) = weights {
        let times: Vec<f32> = frames.iter().map(|(time, _)| *time as f32).collect();
        let keys = frames.iter().flat_map(|(_, weights)| weights.iter().map(|w| [*w])).collect();
        document.animation(
            "take",
            &times,
            vec![Track { node, keys: ChannelKeys::Weights(keys), holds: false }],
        );
    }
    document.finish()
}
