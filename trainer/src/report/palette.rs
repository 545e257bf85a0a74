//! What moves each vertex, in colours.

use super::colour::{Colour, tell_apart};
use crate::examples::Examples;
use sinew_runtime::Envelope;
use std::collections::BTreeSet;

/// Colours each vertex by the map of the palette that it follows most; maps that meet on the surface
/// get hues that differ.
pub(super) fn dominant_colours(envelope: &Envelope<'_>, examples: &Examples) -> Vec<Colour> {
    let dominant: Vec<usize> = (0..examples.vertex_len()).map(|v| strongest(envelope, v)).collect();
    let mut meet = vec![BTreeSet::new(); envelope.palette_len()];
    for corners in &examples.triangles {
        let maps = corners.map(|vertex| dominant[vertex]);
        for (a, b) in [(0, 1), (1, 2), (2, 0)] {
            if maps[a] != maps[b] {
                meet[maps[a]].insert(maps[b]);
                meet[maps[b]].insert(maps[a]);
            }
        }
    }
    let neighbours: Vec<Vec<usize>> = meet.into_iter().map(Vec::from_iter).collect();
    let colours = tell_apart(&neighbours);
    dominant.into_iter().map(|map| colours[map]).collect()
}

/// Marks the V vertices of a kernel model that follow joints alone; none for models without joints
/// in their palette.
pub(super) fn follow_joints(envelope: &Envelope<'_>) -> Option<Vec<bool>> {
    let joints = envelope.palette_len() - envelope.proxy_len();
    let alone =
        |vertex| envelope.influences(vertex).all(|(map, weight)| map < joints || weight == 0.0);
    (joints > 0).then(|| (0..envelope.vertex_len()).map(alone).collect())
}

fn strongest(envelope: &Envelope<'_>, vertex: usize) -> usize {
    let all = envelope.influences(vertex);
    all.fold((0, 0.0), |best, next| if next.1 > best.1 { next } else { best }).0
}
