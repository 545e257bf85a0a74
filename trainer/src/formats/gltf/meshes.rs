//! The meshes of a glTF file, joined into one, and their vertices welded by position.

use super::file::{Parsed, is_surface, numbers, other_count, triangles};
use crate::Error;
use crate::formats::FormatWarning;
use crate::formats::scene::faults;
use crate::mesh::EngineMesh;
use gltf::{Mesh, Node, Primitive, Semantic};
use nalgebra::Vector3;
use std::collections::HashMap;
use std::ops::Range;

/// All meshes that are read, one after another.
#[derive(Default)]
pub(super) struct Meshes {
    /// The nodes that show the meshes.
    pub(super) instances: Vec<Instance>,
    /// Positions, V, each in its mesh's space; with morph targets at their default weights if [`Wanted`] says so.
    pub(super) positions: Vec<[f64; 3]>,
    /// Vertex indices of each triangle.
    pub(super) triangles: Vec<[usize; 3]>,
    /// Normals, V; 0 for a mesh without normals.
    pub(super) normals: Vec<[f64; 3]>,
    /// Tangents and handedness, V; 0 for a mesh without tangents.
    pub(super) tangents: Vec<[f64; 4]>,
    /// Texture coordinates, V, v upward; 0 for a mesh without them.
    pub(super) uv: Vec<[f64; 2]>,
    /// Whether any mesh has normals, tangents and texture coordinates.
    pub(super) authored: [bool; 3],
    /// Joints (of the instance's skin) and weights of each vertex; empty without a skin.
    pub(super) influences: Vec<Vec<(usize, f64)>>,
    /// Names of meshes left out for lack of a skin.
    pub(super) unskinned: Vec<String>,
    /// Names of meshes whose points and lines were left out.
    pub(super) with_lines: Vec<String>,
}

/// The choice of the meshes to read, and of their rest shape.
#[derive(Clone, Copy)]
pub(super) struct Wanted {
    /// Whether to leave out meshes without a skin.
    pub(super) skinned_only: bool,
    /// Whether to apply the default weights of the morph targets, on which clips build.
    pub(super) default_shape: bool,
}

/// A node that shows a mesh.
pub(super) struct Instance {
    /// Index of the node.
    pub(super) node: usize,
    /// Name of the node, or else of its mesh.
    pub(super) name: String,
    /// Index of the skin.
    pub(super) skin: Option<usize>,
    /// Index of its first vertex.
    pub(super) first: usize,
    /// Displacements of its vertices by each morph target.
    pub(super) morphs: Vec<Vec<[f64; 3]>>,
    /// Weights of the morph targets without animation.
    pub(super) weights: Vec<f64>,
}

impl Meshes {
    /// Reads the meshes of the shown nodes, in the order of the nodes.
    ///
    /// # Errors
    /// All meshes consist of points and lines, an accessor cannot be read, counts of attributes differ, or a joint
    /// weight is not finite.
    pub(super) fn read(file: &Parsed, wanted: Wanted) -> Result<Self, Error> {
        let mut all = Self::default();
        let mut no_triangles = None;
        for node in file.document.nodes().filter(|node| file.nodes.shown[node.index()]) {
            let Some(mesh) = node.mesh() else { continue };
            let name = node.name().or(mesh.name()).map(str::to_owned);
            let name = name.unwrap_or_else(|| format!("node {}", node.index()));
            let skin = node.skin().map(|skin| skin.index());
            if wanted.skinned_only && skin.is_none() {
                all.unskinned.push(name);
                continue;
            }
            if let Some(other) = mesh.primitives().find(|primitive| !is_surface(primitive)) {
                all.with_lines.push(name.clone());
                let mode = format!("{:?}", other.mode()).to_lowercase();
                no_triangles = Some(Error::unsupported(format!(
                    "mesh {name} is made of {mode}: export it as triangles"
                )));
            }
            if !has_surface(&mesh) {
                continue;
            }
            let mut instance = Instance {
                node: node.index(),
                name,
                skin,
                first: all.positions.len(),
                morphs: Vec::new(),
                weights: default_weights(&node, &mesh),
            };
            for primitive in mesh.primitives().filter(is_surface) {
                all.add(&primitive, &mut instance, file, wanted)?;
            }
            instance.weights.resize(instance.morphs.len(), 0.0);
            all.instances.push(instance);
        }
        match no_triangles {
            Some(error) if all.instances.is_empty() => Err(error),
            _ => Ok(all),
        }
    }

    /// Reads meshes as [`Meshes::read`] does, at least one.
    ///
    /// # Errors
    /// Those of [`Meshes::read`]; also if the file has no mesh.
    pub(super) fn required(file: &Parsed, wanted: Wanted) -> Result<Self, Error> {
        let all = Self::read(file, wanted)?;
        match all.instances.is_empty() {
            false => Ok(all),
            true if file.nodes.is_empty() => Err(faults::empty()),
            true if all.unskinned.is_empty() => Err(faults::no_mesh()),
            true => Err(no_skin()),
        }
    }

    /// Warns of the meshes, points and lines that were left out.
    pub(super) fn warnings(&self) -> impl Iterator<Item = FormatWarning> + use<> {
        let unskinned =
            FormatWarning::listed(FormatWarning::UnskinnedMeshes, self.unskinned.clone());
        let with_lines =
            FormatWarning::listed(FormatWarning::PointsAndLines, self.with_lines.clone());
        unskinned.into_iter().chain(with_lines)
    }

    /// Appends the vertices and triangles of a primitive.
    fn add(
        &mut self,
        primitive: &Primitive<'_>,
        instance: &mut Instance,
        file: &Parsed,
        wanted: Wanted,
    ) -> Result<(), Error> {
        let buffers = &file.buffers;
        let place = || format!("mesh {}", instance.name);
        let count = |what, expected, found| match expected == found {
            true => Ok(()),
            false => Err(other_count(place(), what, expected, found)),
        };
        let read = |semantic, width| {
            let accessor = primitive.get(&semantic);
            accessor.map(|accessor| numbers(&accessor, buffers, width)).transpose()
        };
        let base = self.positions.len();
        let weights: &[f64] = if wanted.default_shape { &instance.weights } else { &[] };
        let positions = shaped(primitive, Semantic::Positions, weights, file, place)?;
        let vertex_len = positions.len();
        self.positions.extend(positions);
        let triangles = triangles(primitive, buffers, vertex_len, place)?;
        self.triangles
            .extend(triangles.into_iter().map(|corners| corners.map(|vertex| base + vertex)));

        let end = base + vertex_len;
        self.normals.resize(end, [0.0; 3]);
        let normals = shaped(primitive, Semantic::Normals, weights, file, place)?;
        if !normals.is_empty() {
            count("normals", vertex_len, normals.len())?;
            self.normals[base..].copy_from_slice(&normals);
            self.authored[0] = true;
        }
        self.tangents.resize(end, [0.0; 4]);
        if let Some(tangents) = read(Semantic::Tangents, 4)? {
            count("tangents", 4 * vertex_len, tangents.len())?;
            self.tangents[base..].copy_from_slice(tangents.as_chunks().0);
            self.authored[1] = true;
        }
        self.uv.resize(end, [0.0; 2]);
        if let Some(uv) = read(Semantic::TexCoords(0), 2)? {
            count("texture coordinates", 2 * vertex_len, uv.len())?;
            // glTF's v grows downward.
            let upward = uv.as_chunks().0.iter().map(|&[u, v]| [u, 1.0 - v]);
            self.uv.splice(base.., upward);
            self.authored[2] = true;
        }

        let mut influences = vec![Vec::new(); vertex_len];
        for set in 0.. {
            let Some(joints) = read(Semantic::Joints(set), 4)? else { break };
            let weights = read(Semantic::Weights(set), 4)?.unwrap_or_default();
            count("joints", 4 * vertex_len, joints.len())?;
            count("weights", 4 * vertex_len, weights.len())?;
            let sets = joints.as_chunks::<4>().0.iter().zip(weights.as_chunks::<4>().0);
            for (vertex, (all, (joints, weights))) in influences.iter_mut().zip(sets).enumerate() {
                if let Some(&number) = weights.iter().find(|weight| !weight.is_finite()) {
                    let (mesh, vertex) = (&instance.name, base - instance.first + vertex);
                    return Err(Error::value(format!(
                        "mesh {mesh}: vertex {vertex} has the joint weight {number}, expected a finite number: \
                         normalize the weights and export again"
                    )));
                }
                let pairs = joints.iter().zip(weights).filter(|(_, weight)| **weight > 0.0);
                all.extend(pairs.map(|(&joint, &weight)| (joint as usize, weight)));
            }
        }
        self.influences.extend(influences);

        let targets = primitive.morph_targets();
        if base > instance.first {
            count("morph targets in every primitive", instance.morphs.len(), targets.len())?;
        }
        instance.morphs.resize(targets.len(), Vec::new());
        for (morph, target) in instance.morphs.iter_mut().zip(targets) {
            let moved = target.positions().map(|moved| numbers(&moved, buffers, 3)).transpose()?;
            let moved = moved.unwrap_or_else(|| vec![0.0; 3 * vertex_len]);
            count("displacements", 3 * vertex_len, moved.len())?;
            morph.extend_from_slice(moved.as_chunks().0);
        }
        Ok(())
    }

    /// Returns the vertices of an instance.
    pub(super) fn vertices(&self, instance: usize) -> Range<usize> {
        let end = self.instances.get(instance + 1).map_or(self.positions.len(), |next| next.first);
        self.instances[instance].first..end
    }
}

/// Makes the error for a file without a skin.
pub(super) fn no_skin() -> Error {
    Error::missing(
        "no mesh has a skin, so there are no joints to learn from: bind the mesh to its armature and \
         export with skinning; posed meshes alone serve as --targets of a scene that has one",
    )
}

/// Returns whether a mesh has triangles.
pub(super) fn has_surface(mesh: &Mesh<'_>) -> bool {
    mesh.primitives().any(|primitive| is_surface(&primitive))
}

/// Returns the weights of a mesh's morph targets without animation.
pub(super) fn default_weights(node: &Node<'_>, mesh: &Mesh<'_>) -> Vec<f64> {
    let weights = node.weights().or(mesh.weights()).unwrap_or_default();
    weights.iter().copied().map(f64::from).collect()
}

/// Reads the positions or normals of a primitive's vertices, displaced by its morph targets with these weights; empty if
/// the primitive lacks the attribute. Displaced normals are normalised.
///
/// # Errors
/// An accessor cannot be read, or the counts of an attribute and its displacements differ.
pub(super) fn shaped(
    primitive: &Primitive<'_>,
    attribute: Semantic,
    weights: &[f64],
    file: &Parsed,
    place: impl Fn() -> String,
) -> Result<Vec<[f64; 3]>, Error> {
    let Some(own) = primitive.get(&attribute) else { return Ok(Vec::new()) };
    let is_normal = attribute == Semantic::Normals;
    let mut all = numbers(&own, &file.buffers, 3)?.as_chunks().0.to_vec();
    for (target, &weight) in primitive.morph_targets().zip(weights) {
        let displaced = if is_normal { target.normals() } else { target.positions() };
        let Some(displaced) = displaced.filter(|_| weight != 0.0) else { continue };
        let by = numbers(&displaced, &file.buffers, 3)?;
        let (expected, found) = (3 * all.len(), by.len());
        if expected != found {
            return Err(other_count(place(), "displacements", expected, found));
        }
        for (own, by) in all.iter_mut().zip(by.as_chunks().0) {
            let sum = Vector3::from(*own) + Vector3::from(*by) * weight;
            let sum = if is_normal { sum.try_normalize(0.0).unwrap_or(sum) } else { sum };
            *own = sum.into();
        }
    }
    Ok(all)
}

/// Vertices welded by position. Vertices of a mesh with equal positions, influences and morph displacements become one
/// vertex. The file's vertices remain the engine vertices, in the file's order.
pub(super) struct Welded {
    /// First file vertex of each welded vertex, V, ascending.
    pub(super) firsts: Vec<usize>,
    /// Vertex indices of each triangle.
    pub(super) triangles: Vec<[usize; 3]>,
    /// The file's vertices as engine vertices, if they differ from the welded ones or have attributes.
    pub(super) engine: Option<EngineMesh>,
    /// A warning if normals of vertices had no direction.
    pub(super) repaired: Option<FormatWarning>,
}

impl Welded {
    /// Welds the vertices of all meshes.
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
        let repaired = FormatWarning::repaired(engine.complete(&positions, &triangles));
        let engine = (!engine.is_plain()).then_some(engine);
        Self { firsts, triangles, engine, repaired }
    }

    /// Returns the names and welded vertices of the instances; empty for a single instance.
    pub(super) fn ranges(&self, meshes: &Meshes) -> Vec<(String, Range<usize>)> {
        let below = |end: usize| self.firsts.partition_point(|&first| first < end);
        let named = |number: usize| {
            let Range { start, end } = meshes.vertices(number);
            (meshes.instances[number].name.clone(), below(start)..below(end))
        };
        let count = meshes.instances.len();
        if count < 2 { Vec::new() } else { (0..count).map(named).collect() }
    }

    /// Picks the positions of the welded vertices, V, from those of the file.
    pub(super) fn pick(&self, all: &[[f64; 3]]) -> Vec<[f64; 3]> {
        self.firsts.iter().map(|&first| all[first]).collect()
    }
}

/// Returns, as bits, everything that a vertex must share with its copies.
fn key(meshes: &Meshes, instance: usize, own: usize, vertex: usize) -> Vec<u64> {
    // Adding 0 joins the two zeros.
    let bits = |x: &f64| (x + 0.0).to_bits();
    let mut influences = meshes.influences[vertex].clone();
    influences.sort_by_key(|&(joint, _)| joint);
    let moved = meshes.instances[instance].morphs.iter().flat_map(|morph| &morph[own]);
    let place = meshes.positions[vertex].iter().chain(moved).map(bits);
    let influences = influences.iter().flat_map(|(joint, weight)| [*joint as u64, bits(weight)]);
    place.chain(influences).collect()
}
