//! Which of the meshes of a file is which of a scene's.

use std::ops::Range;

use crate::examples::Warning;
use crate::formats::posed_meshes::{Part, PosedMeshes};

/// Picks and sorts the joined meshes of a file as a scene has its `ranges` of `vertex_len` vertices: by name, or by
/// the count of vertices where that tells. Where neither does, they stay as they are.
pub(super) fn arranged(
    ranges: &[(String, Range<usize>)],
    vertex_len: usize,
    meshes: PosedMeshes,
    warnings: &mut Vec<Warning>,
) -> PosedMeshes {
    let parts = &meshes.parts;
    let Some(picked) = picked(ranges, vertex_len, meshes.vertex_len, parts) else { return meshes };
    if picked.iter().copied().eq(0..parts.len()) {
        return meshes;
    }
    let left_out = (0..parts.len()).filter(|part| !picked.contains(part));
    let left_out: Vec<String> =
        left_out.filter_map(|part| parts[part].names.first().cloned()).collect();
    if !left_out.is_empty() {
        warnings.push(Warning::TargetsLeftOut { meshes: left_out });
    }
    let picked: Vec<&Part> = picked.into_iter().map(|part| &parts[part]).collect();
    let pick = |all: &[[f64; 3]]| -> Vec<[f64; 3]> {
        picked.iter().flat_map(|part| &all[part.range.clone()]).copied().collect()
    };
    let mut end = 0;
    let parts = picked.iter().map(|part| {
        let begin = end;
        end += part.range.len();
        Part { names: part.names.clone(), range: begin..end }
    });
    let parts: Vec<Part> = parts.collect();
    PosedMeshes {
        rest: meshes.rest.as_deref().map(pick),
        reference: meshes.reference.as_deref().map(pick),
        parts,
        ..PosedMeshes::bare(end, meshes.vertices.chunks(meshes.vertex_len).flat_map(pick).collect())
    }
}

/// Chooses a part for each of a scene's meshes.
fn picked(
    ranges: &[(String, Range<usize>)],
    vertex_len: usize,
    found: usize,
    parts: &[Part],
) -> Option<Vec<usize>> {
    let one_of = |fits: &dyn Fn(&Part) -> bool| {
        let mut fitting = (0..parts.len()).filter(|&part| fits(&parts[part]));
        fitting.next().filter(|_| fitting.next().is_none())
    };
    let of_len = |len: usize| one_of(&|part| part.range.len() == len);
    if ranges.is_empty() {
        return (found != vertex_len).then(|| of_len(vertex_len)).flatten().map(|part| vec![part]);
    }
    let of = |(name, range): &(String, Range<usize>)| {
        let is_called = |part: &Part| part.names.iter().any(|own| plain(own) == plain(name));
        let named = one_of(&|part| part.range.len() == range.len() && is_called(part));
        named.or_else(|| of_len(range.len()))
    };
    let picked: Vec<usize> = ranges.iter().map(of).collect::<Option<_>>()?;
    let mut once = picked.clone();
    once.sort_unstable();
    once.dedup();
    (once.len() == picked.len()).then_some(picked)
}

/// A name without what programs replace in it.
fn plain(name: &str) -> String {
    name.chars().map(|c| if c.is_alphanumeric() { c } else { '_' }).collect()
}
