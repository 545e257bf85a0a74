//! Named morph targets, whose weights are curves.

use super::file::Parsed;
use super::meshes::default_weights;
use crate::formats::scene::CurveTrack;
use serde::Deserialize;

/// Morph targets of a mesh that a node shows.
pub(super) struct NamedTargets {
    /// Index of the node.
    pub(super) node: usize,
    /// Name of the node, or else of its mesh.
    mesh: String,
    /// Names of the morph targets, in their order.
    names: Vec<String>,
    /// Weights without animation.
    weights: Vec<f64>,
}

/// Application-specific data of a mesh; other fields are ignored.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Extras {
    target_names: Vec<String>,
}

/// Lists the named morph targets of all shown meshes, with a skin or without.
pub(super) fn named_targets(file: &Parsed) -> Vec<NamedTargets> {
    let shown = file.document.nodes().filter(|node| file.nodes.shown[node.index()]);
    let named = shown.filter_map(|node| {
        let mesh = node.mesh()?;
        let extras = mesh.extras().as_ref()?;
        let Extras { target_names: names } = serde_json::from_str(extras.get()).ok()?;
        let name = node.name().or(mesh.name()).map(str::to_owned);
        let mut weights = default_weights(&node, &mesh);
        weights.resize(names.len(), 0.0);
        let mesh = name.unwrap_or_else(|| format!("node {}", node.index()));
        Some(NamedTargets { node: node.index(), mesh, names, weights })
    });
    named.collect()
}

/// Makes the curves of named morph targets.
///
/// - `frames`: weights of each node in each frame.
pub(super) fn tracks(named: &[NamedTargets], frames: &[Vec<Vec<f64>>]) -> Vec<CurveTrack> {
    let track = |own: &NamedTargets, target: usize| {
        let weight = |frame: &Vec<Vec<f64>>| {
            let animated = frame[own.node].get(target).copied();
            animated.unwrap_or(own.weights[target])
        };
        let weights = frames.iter().map(weight).collect();
        CurveTrack { name: own.names[target].clone(), mesh: own.mesh.clone(), weights }
    };
    named
        .iter()
        .flat_map(|own| (0..own.names.len()).map(move |target| track(own, target)))
        .collect()
}
