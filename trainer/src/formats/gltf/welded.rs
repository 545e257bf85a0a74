//! The vertices of a glTF file by place: what they have in common is one vertex of a fit's.

use std::collections::HashMap;
use std::ops::Range;

use super::meshes::Meshes;
use crate::mesh::EngineMesh;

/// The meshes' vertices, of which those of one mesh that have one position, and move alike by joints and morph
/// targets, are copies of one. The file's vertices are the engine's, in its order.
pub(super) struct Welded {
    /// The first vertex of each place, V, ascending.
    pub(super) firsts: Vec<usize>,
    /// Vertex numbers of each triangle.
    pub(super) triangles: Vec<[usize; 3]>,
    /// The file's own vertices, where they say more.
    pub(super) engine: Option<EngineMesh>,
    /// Of how many vertices the normal had no direction.
    pub(super) repaired: usize,
}

impl Welded {
    /// Welds meshes.
    pub(super) fn new(meshes: &Meshes) -> Self {
        let mut firsts = Vec::new();
        let mut copy_of = Vec::with_capacity(meshes.positions.len());
        for instance in 0..meshes.instances.len() {
            let mut known = HashMap::new();
            for (own, vertex) in meshes.vertices(instance).enumerate() {
                let welded =
                    *known.entry(key(meshes, instance, own, vertex)).or_insert(firsts.len());
                if welded == firsts.len() {
                    firsts.push(vertex);
                }
                copy_of.push(welded);
            }
        }
        let positions: Vec<_> = firsts.iter().map(|&first| meshes.positions[first]).collect();
        let triangles: Vec<_> =
            meshes.triangles.iter().map(|corners| corners.map(|corner| copy_of[corner])).collect();
        let [normals, tangents, uv] = meshes.authored;
        let mut engine = EngineMesh {
            copy_of,
            triangles: meshes.triangles.clone(),
            normals: normals.then(|| meshes.normals.clone()),
            tangents: tangents.then(|| meshes.tangents.clone()),
            uv: uv.then(|| meshes.uv.clone()),
        };
        let repaired = engine.complete(&positions, &triangles);
        let engine = (!engine.is_plain()).then_some(engine);
        Self { firsts, triangles, engine, repaired }
    }

    /// Gives the vertices among the V of a range of the file's.
    pub(super) fn range(&self, range: &Range<usize>) -> Range<usize> {
        let below = |end: usize| self.firsts.partition_point(|&first| first < end);
        below(range.start)..below(range.end)
    }

    /// Picks the V of the file's positions.
    pub(super) fn pick(&self, all: &[[f64; 3]]) -> Vec<[f64; 3]> {
        self.firsts.iter().map(|&first| all[first]).collect()
    }
}

/// What a vertex shares with its copies, as bits.
fn key(meshes: &Meshes, instance: usize, own: usize, vertex: usize) -> Vec<u64> {
    // Zero has two signs.
    let bits = |x: &f64| (x + 0.0).to_bits();
    let mut influences = meshes.influences[vertex].clone();
    influences.sort_by_key(|&(joint, _)| joint);
    let moved = meshes.instances[instance].morphs.iter().flat_map(|morph| &morph[own]);
    let place = meshes.positions[vertex].iter().chain(moved).map(bits);
    place
        .chain(influences.iter().flat_map(|(joint, weight)| [*joint as u64, bits(weight)]))
        .collect()
}
