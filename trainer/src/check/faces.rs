//! Triangles, at rest and in the training frames: area, winding, edges, pieces, and triangles that collapse, fold or
//! flip.

use super::context::{Context, worst_first};
use super::finding::{Finding, Kind, Place, Severity, count, listed};
use super::thresholds::{COLLAPSED, FLIPPED, LOOSE, MANY};
use crate::examples::{Examples, Split, Warning, spread};
use crate::numeric::affine::cofactors;
use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;
use serde::Serialize;
use std::collections::{BTreeMap, HashMap};

/// Counts of the surface.
#[derive(Clone, Debug, Serialize)]
pub struct Faces {
    /// Number of edges.
    pub edges: usize,
    /// Number of edges with one triangle.
    pub border_edges: usize,
    /// Number of parts that share no vertex.
    pub pieces: usize,
    /// Number of parts after vertices with a common position in all frames are merged.
    pub welded_pieces: usize,
}

pub(super) fn faces(
    examples: &Examples,
    warnings: &[Warning],
    findings: &mut Vec<Finding>,
) -> Faces {
    for warning in warnings {
        if let Warning::RepeatedVertex(triangles) | Warning::ZeroArea(triangles) = warning {
            let places = triangles.iter().map(|&triangle| Place::Triangle(triangle)).collect();
            findings.push(Finding::note(Kind::NoArea, warning.to_string(), places));
        }
    }
    let edges = edges(examples);
    findings.extend(winding(&edges));
    findings.extend(non_manifold(&edges));
    let mut used = vec![false; examples.vertex_len()];
    examples.triangles.iter().flatten().for_each(|&vertex| used[vertex] = true);
    let alone: Vec<usize> = (0..used.len()).filter(|&vertex| !used[vertex]).collect();
    if !alone.is_empty() {
        let text = format!(
            "{} to no triangle and {} no normal: {}",
            count(alone.len(), "vertex belongs", "vertices belong"),
            if alone.len() == 1 { "has" } else { "have" },
            listed(&alone)
        );
        let places = alone.into_iter().map(Place::Vertex).collect();
        findings.push(Finding::note(Kind::Unreferenced, text, places));
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

/// A triangle at an edge, and whether its winding goes from the smaller vertex to the larger.
type Use = (usize, bool);

/// Lists the triangles at each edge. Triangles with a repeated vertex are skipped.
fn edges(examples: &Examples) -> BTreeMap<[usize; 2], Vec<Use>> {
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
    // The triangle that disagrees with most of its neighbours has the wrong winding.
    let mut opposed: BTreeMap<usize, usize> = BTreeMap::new();
    for triangle in pairs.iter().flatten() {
        *opposed.entry(*triangle).or_default() += 1;
    }
    let mut triangles: Vec<(usize, usize)> = opposed.into_iter().collect();
    triangles.sort_by_key(|&(triangle, count)| (std::cmp::Reverse(count), triangle));
    let triangles = triangles.into_iter().map(|(triangle, _)| triangle);
    let text = format!(
        "{} triangles that face opposite sides: make the winding consistent; at triangles {}",
        count(pairs.len(), "edge joins", "edges join"),
        listed(triangles.clone())
    );
    let places = triangles.map(Place::Triangle).collect();
    (!pairs.is_empty()).then(|| Finding::warning(Kind::Winding, text, places))
}

fn non_manifold(edges: &BTreeMap<[usize; 2], Vec<Use>>) -> Option<Finding> {
    let shared: Vec<[usize; 2]> =
        edges.iter().filter(|(_, uses)| uses.len() > 2).map(|(&edge, _)| edge).collect();
    let text = format!(
        "{} more than two triangles, between vertices {}",
        count(shared.len(), "edge has", "edges have"),
        listed(shared.iter().map(|[a, b]| format!("{a} and {b}")))
    );
    let places = shared.iter().map(|&edge| Place::Edge(edge)).collect();
    (!shared.is_empty()).then(|| Finding::note(Kind::NonManifold, text, places))
}

fn unwelded(welded: &[usize], faces: &Faces) -> Option<Finding> {
    let mut sharing = vec![0usize; welded.len()];
    welded.iter().for_each(|&first| sharing[first] += 1);
    let doubled: Vec<usize> = (0..welded.len()).filter(|&v| sharing[welded[v]] > 1).collect();
    let most = *doubled.first()?;
    let loose = doubled.len() as f64 >= LOOSE * welded.len() as f64;
    let places = (0..welded.len()).filter(|&v| welded[v] == v).count();
    let severity = if loose { Severity::Warning } else { Severity::Note };
    let advice = match loose {
        true => "export with shared vertices, so that the surface hangs together",
        false => "seams of texture or normals do no harm",
    };
    let text = format!(
        "{} of {} vertices share their place with others and move with them ({places} places, \
         {} that would be {}), as vertex {most}: {advice}",
        doubled.len(),
        welded.len(),
        count(faces.pieces, "piece", "pieces"),
        faces.welded_pieces
    );
    let places = doubled.into_iter().map(Place::Vertex).collect();
    Some(Finding::new(severity, Kind::Unwelded, text, places))
}

/// Returns for each vertex the first vertex with the same position, at rest and in some training frames.
fn welded(examples: &Examples) -> Vec<usize> {
    const FRAMES: usize = 3;
    let training = examples.frames_of(Split::Train);
    let frames: Vec<&[[f64; 3]]> =
        spread(training.len(), FRAMES).into_iter().map(|i| examples.frame(training[i])).collect();
    let mut first = HashMap::new();
    let place = |v: usize| -> Vec<[u64; 3]> {
        let all = std::iter::once(&examples.rest[v]).chain(frames.iter().map(|f| &f[v]));
        // Positions are compared in single precision, which most exporters write.
        all.map(|x| x.map(|x| u64::from((x as f32 + 0.0).to_bits()))).collect()
    };
    (0..examples.vertex_len()).map(|v| *first.entry(place(v)).or_insert(v)).collect()
}

/// Counts the parts of the surface that share no vertex. `vertex` maps each vertex to the vertex that replaces it.
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

/// A kind of fault: what triangles do, and the rest of the words.
type Fault = (Kind, &'static str, &'static str);

/// The kinds of faults in a frame.
const FAULTS: [Fault; 3] = [
    (
        Kind::Flipped,
        "face",
        "away from the direction given by the joints, as in a mirrored or inverted mesh",
    ),
    (Kind::Folded, "fold", "over a neighbour, as skin does in deep bends"),
    (Kind::Collapsed, "keep", "less than a hundredth of the area at rest"),
];

pub(super) fn in_poses(context: &Context<'_>, findings: &mut Vec<Finding>) {
    let surface = RestFaces::new(context);
    let frames: Vec<[Vec<usize>; 3]> =
        (0..context.frames.len()).into_par_iter().map(|i| surface.faults(context, i)).collect();
    for (number, fault) in FAULTS.iter().enumerate() {
        let at_fault: Vec<&[usize]> = frames.iter().map(|faults| &*faults[number]).collect();
        findings.extend(report(context, fault, surface.triangles.len(), &at_fault));
    }
}

/// The triangles with an area at rest.
struct RestFaces {
    triangles: Vec<usize>,
    /// Pairs of triangles that share an edge without a crease, by index in the list.
    neighbours: Vec<[usize; 2]>,
    /// Twice the area at rest, along the normal.
    rest: Vec<Vector3<f64>>,
}

impl RestFaces {
    fn new(context: &Context<'_>) -> Self {
        let examples = context.examples;
        let mut place = vec![None; examples.triangles.len()];
        let flat = examples.degenerate_triangles();
        let triangles: Vec<usize> =
            (0..place.len()).filter(|t| flat.binary_search(t).is_err()).collect();
        triangles.iter().enumerate().for_each(|(k, &t)| place[t] = Some(k));
        let rest: Vec<_> =
            triangles.iter().map(|&t| normal(&examples.rest, examples.triangles[t])).collect();
        let neighbours = edges(examples)
            .into_values()
            .filter_map(|uses| match uses[..] {
                [(a, one), (b, other)] if one != other => Some([place[a]?, place[b]?]),
                _ => None,
            })
            .filter(|&[a, b]| rest[a].dot(&rest[b]) > 0.0)
            .collect();
        Self { triangles, neighbours, rest }
    }

    /// Lists the triangles of a frame with each of the [`FAULTS`], by number.
    fn faults(&self, context: &Context<'_>, i: usize) -> [Vec<usize>; 3] {
        let (examples, weights) = (context.examples, &context.training.lbs.weights);
        let posed = examples.frame(context.frames[i]);
        let pose = examples.pose(context.frames[i]);
        let linear = |joint: usize| Matrix3::from_fn(|r, c| pose[joint][r][c]);
        let of = |&t: &usize| normal(posed, examples.triangles[t]);
        let now: Vec<Vector3<f64>> = self.triangles.iter().map(of).collect();
        let collapsed: Vec<bool> =
            now.iter().zip(&self.rest).map(|(n, r)| n.norm() < COLLAPSED * r.norm()).collect();
        let flipped = |k: usize| {
            let blended: Matrix3<f64> = examples.triangles[self.triangles[k]]
                .into_iter()
                .flat_map(|vertex| weights.of(vertex))
                .map(|(joint, weight)| linear(joint) * weight)
                .sum();
            !collapsed[k] && opposed(&now[k], &(cofactors(&blended) * self.rest[k]))
        };
        let flipped: Vec<bool> = (0..now.len()).map(flipped).collect();
        let mut folded = vec![false; now.len()];
        for &[a, b] in &self.neighbours {
            if opposed(&now[a], &now[b]) {
                folded[a] |= flipped[a];
                folded[b] |= flipped[b];
            }
        }
        let many = flipped.iter().filter(|flipped| **flipped).count() as f64
            > MANY * self.triangles.len() as f64;
        let named = |at_fault: &[bool]| {
            let places = (0..at_fault.len()).filter(|&k| at_fault[k]);
            places.map(|k| self.triangles[k]).collect()
        };
        match many {
            true => [named(&flipped), Vec::new(), named(&collapsed)],
            // A few flipped triangles without a fold are a bend that LBS does not predict.
            false => [Vec::new(), named(&folded), named(&collapsed)],
        }
    }
}

/// Returns whether two directions differ by more than any bulge.
fn opposed(a: &Vector3<f64>, b: &Vector3<f64>) -> bool {
    a.dot(b) < FLIPPED * a.norm() * b.norm()
}

/// Returns the normal times twice the area.
fn normal(points: &[[f64; 3]], triangle: [usize; 3]) -> Vector3<f64> {
    let [a, b, c] = triangle.map(|vertex| Vector3::from(points[vertex]));
    (b - a).cross(&(c - a))
}

/// Reports a fault.
///
/// - `triangle_len`: number of triangles with an area at rest.
/// - `frames`: the faulty triangles of each training frame.
fn report(
    context: &Context<'_>,
    &(kind, verb, meaning): &Fault,
    triangle_len: usize,
    frames: &[&[usize]],
) -> Option<Finding> {
    let mut times = vec![0usize; context.examples.triangles.len()];
    frames.iter().copied().flatten().for_each(|&triangle| times[triangle] += 1);
    let at_fault = (0..times.len()).filter(|&triangle| times[triangle] > 0);
    let triangles = worst_first(at_fault, |triangle| times[triangle] as f64);
    let in_frame = |i: usize| frames[i].len() as f64;
    let order = worst_first((0..frames.len()).filter(|&i| !frames[i].is_empty()), in_frame);
    let &worst = order.first()?;
    let many = in_frame(worst) > MANY * triangle_len as f64;
    let severity = if many { Severity::Warning } else { Severity::Note };
    let line = |&triangle: &usize| format!("{triangle} ({})", times[triangle]);
    let text = format!(
        "{} {meaning}, in {}, most of them ({}) in frame {}; triangles (in frames): {}",
        count(triangles.len(), &format!("triangle {verb}s"), &format!("triangles {verb}")),
        count(order.len(), "training frame", "training frames"),
        frames[worst].len(),
        context.frame(worst),
        listed(triangles.iter().map(line))
    );
    let places = triangles.into_iter().map(Place::Triangle).chain(context.frames(order));
    Some(Finding::new(severity, kind, text, places.collect()))
}
