//! What moves each vertex, in colours.

use crate::evaluate::Character;
use crate::examples::Examples;
use crate::page::colour::{Colour, distinct_colours};
use sinew_runtime::Skin;
use std::collections::BTreeSet;

/// Colours each vertex by the transform of the palette that it follows most; those that meet on the surface
/// get hues that differ.
pub(super) fn dominant_colours(character: &Character<'_>, examples: &Examples) -> Vec<Colour> {
    let firsts = examples.surface().first_copies().into_iter();
    let dominant: Vec<usize> = firsts.map(|copy| strongest(&character.skin, copy)).collect();
    let mut meet = vec![BTreeSet::new(); character.skin.palette_len()];
    for corners in &examples.triangles {
        let own = corners.map(|vertex| dominant[vertex]);
        for (a, b) in [(0, 1), (1, 2), (2, 0)] {
            if own[a] != own[b] {
                meet[own[a]].insert(own[b]);
                meet[own[b]].insert(own[a]);
            }
        }
    }
    let neighbours: Vec<Vec<usize>> = meet.into_iter().map(Vec::from_iter).collect();
    let colours = distinct_colours(&neighbours);
    dominant.into_iter().map(|index| colours[index]).collect()
}

/// Marks the V vertices of a kernel model that follow joints alone; none for models without joints
/// in their palette.
pub(super) fn follow_joints(character: &Character<'_>, examples: &Examples) -> Option<Vec<bool>> {
    let Character { envelope, skin, .. } = character;
    let joints = envelope.palette_len() - envelope.proxy_len();
    let alone =
        |vertex| skin.influences(vertex).all(|(index, weight)| index < joints || weight == 0.0);
    let firsts = examples.surface().first_copies().into_iter();
    (joints > 0).then(|| firsts.map(alone).collect())
}

fn strongest(skin: &Skin<'_>, vertex: usize) -> usize {
    let all = skin.influences(vertex);
    all.fold((0, 0.0), |best, next| if next.1 > best.1 { next } else { best }).0
}
