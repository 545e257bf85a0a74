//! The faces at rest: area, winding, edges, pieces.

use super::finding::{Finding, Kind, Place, Severity, count, listed};
use super::thresholds::LOOSE;
use crate::examples::{Examples, Split, Warning};
use serde::Serialize;
use std::collections::{BTreeMap, HashMap};

/// What the faces are.
#[derive(Clone, Debug, Serialize)]
pub struct Faces {
    /// Edges.
    pub edges: usize,
    /// Edges of one triangle alone.
    pub border_edges: usize,
    /// Parts that share no vertex.
    pub pieces: usize,
    /// Parts that are left when vertices that stand and move together are one.
    pub welded_pieces: usize,
}

pub(super) fn faces(
    examples: &Examples,
    warnings: &[Warning],
    findings: &mut Vec<Finding>,
) -> Faces {
    for warning in warnings {
        if let Warning::RepeatedVertex { triangles } | Warning::ZeroArea { triangles } = warning {
            findings.push(Finding {
                kind: Kind::NoArea,
                severity: Severity::Note,
                text: warning.to_string(),
                places: triangles.iter().map(|&triangle| Place::Triangle(triangle)).collect(),
            });
        }
    }
    let edges = edges(examples);
    findings.extend(winding(&edges));
    findings.extend(non_manifold(&edges));
    let mut used = vec![false; examples.vertex_len()];
    examples.triangles.iter().flatten().for_each(|&vertex| used[vertex] = true);
    let alone: Vec<usize> = (0..used.len()).filter(|&vertex| !used[vertex]).collect();
    if !alone.is_empty() {
        findings.push(Finding {
            kind: Kind::Unreferenced,
            severity: Severity::Note,
            text: format!(
                "{} to no triangle and {} no normal: {}",
                count(alone.len(), "vertex belongs", "vertices belong"),
                if alone.len() == 1 { "has" } else { "have" },
                listed(&alone)
            ),
            places: alone.iter().map(|&vertex| Place::Vertex(vertex)).collect(),
        });
    }
    let welded = welded(examples);
    let separate: Vec<usize> = (0..welded.len()).collect();
    let faces = Faces {
        edges: edges.len(),
        border_edges: edges.values().filter(|uses| uses.len() == 1).count(),
        pieces: pieces(examples, &separate),
        welded_pieces: pieces(examples, &welded),
    };
    findings.extend(unwelded(&welded, &faces));
    faces
}

/// A triangle that uses an edge, and whether from the smaller vertex to the larger.
type Use = (usize, bool);

/// The triangles at each edge, of those that name no vertex twice.
pub(super) fn edges(examples: &Examples) -> BTreeMap<[usize; 2], Vec<Use>> {
    let mut edges: BTreeMap<[usize; 2], Vec<Use>> = BTreeMap::new();
    for (number, &[a, b, c]) in examples.triangles.iter().enumerate() {
        if a != b && b != c && c != a {
            for (from, to) in [(a, b), (b, c), (c, a)] {
                let edge = [from.min(to), from.max(to)];
                edges.entry(edge).or_default().push((number, from < to));
            }
        }
    }
    edges
}

fn winding(edges: &BTreeMap<[usize; 2], Vec<Use>>) -> Option<Finding> {
    let pairs: Vec<[usize; 2]> = edges
        .values()
        .filter_map(|uses| match uses[..] {
            [(a, one), (b, other)] if one == other => Some([a, b]),
            _ => None,
        })
        .collect();
    // The triangle that disagrees with most of its neighbours is the one to turn.
    let mut against: BTreeMap<usize, usize> = BTreeMap::new();
    for triangle in pairs.iter().flatten() {
        *against.entry(*triangle).or_default() += 1;
    }
    let mut triangles: Vec<(usize, usize)> = against.into_iter().collect();
    triangles.sort_by_key(|&(triangle, count)| (std::cmp::Reverse(count), triangle));
    let lines = triangles.iter().map(|(triangle, _)| triangle);
    (!pairs.is_empty()).then(|| Finding {
        kind: Kind::Winding,
        severity: Severity::Warning,
        text: format!(
            "{} triangles that look to opposite sides: make the winding consistent; at triangles {}",
            count(pairs.len(), "edge joins", "edges join"),
            listed(lines.clone())
        ),
        places: lines.map(|&triangle| Place::Triangle(triangle)).collect(),
    })
}

fn non_manifold(edges: &BTreeMap<[usize; 2], Vec<Use>>) -> Option<Finding> {
    let shared: Vec<[usize; 2]> =
        edges.iter().filter(|(_, uses)| uses.len() > 2).map(|(&edge, _)| edge).collect();
    (!shared.is_empty()).then(|| Finding {
        kind: Kind::NonManifold,
        severity: Severity::Note,
        text: format!(
            "{} more than two triangles, between vertices {}",
            count(shared.len(), "edge has", "edges have"),
            listed(shared.iter().map(|[a, b]| format!("{a} and {b}")))
        ),
        places: shared.iter().map(|&edge| Place::Edge(edge)).collect(),
    })
}

fn unwelded(welded: &[usize], faces: &Faces) -> Option<Finding> {
    let mut sharing = vec![0usize; welded.len()];
    welded.iter().for_each(|&first| sharing[first] += 1);
    let doubled: Vec<usize> = (0..welded.len()).filter(|&v| sharing[welded[v]] > 1).collect();
    let most = *doubled.first()?;
    let loose = doubled.len() as f64 >= LOOSE * welded.len() as f64;
    let places = (0..welded.len()).filter(|&v| welded[v] == v).count();
    Some(Finding {
        kind: Kind::Unwelded,
        severity: if loose { Severity::Warning } else { Severity::Note },
        text: format!(
            "{} of {} vertices share their place with others and move with them ({places} places, \
             {} that would be {}), as vertex {most}: {}",
            doubled.len(),
            welded.len(),
            count(faces.pieces, "piece", "pieces"),
            faces.welded_pieces,
            if loose {
                "export with shared vertices, so that the surface hangs together"
            } else {
                "seams of texture or normals do no harm"
            }
        ),
        places: doubled.into_iter().map(Place::Vertex).collect(),
    })
}

/// The first vertex that stands where each does, at rest and in some training frames.
fn welded(examples: &Examples) -> Vec<usize> {
    const FRAMES: usize = 3;
    let training = examples.frames_of(Split::Train);
    let frames: Vec<&[[f64; 3]]> = crate::examples::spread(training.len(), FRAMES)
        .into_iter()
        .map(|i| examples.frame(training[i]))
        .collect();
    let mut first = HashMap::new();
    let place = |v: usize| -> Vec<[u64; 3]> {
        let all = std::iter::once(&examples.rest[v]).chain(frames.iter().map(|f| &f[v]));
        // Single precision, in which most exporters write.
        all.map(|x| x.map(|x| u64::from((x as f32 + 0.0).to_bits()))).collect()
    };
    (0..examples.vertex_len()).map(|v| *first.entry(place(v)).or_insert(v)).collect()
}

/// Counts the parts of the surface that share no vertex.
fn pieces(examples: &Examples, vertex: &[usize]) -> usize {
    fn root(parents: &mut [usize], mut v: usize) -> usize {
        while parents[v] != v {
            parents[v] = parents[parents[v]];
            v = parents[v];
        }
        v
    }
    let mut parents: Vec<usize> = (0..vertex.len()).collect();
    let mut used = vec![false; vertex.len()];
    for triangle in &examples.triangles {
        let [a, b, c] = triangle.map(|v| vertex[v]);
        for (from, to) in [(a, b), (a, c)] {
            let (from, to) = (root(&mut parents, from), root(&mut parents, to));
            parents[from.max(to)] = from.min(to);
        }
        [a, b, c].into_iter().for_each(|v| used[v] = true);
    }
    (0..vertex.len()).filter(|&v| used[v] && parents[v] == v).count()
}
