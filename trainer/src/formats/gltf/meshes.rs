//! The meshes of a glTF file, joined into one.

use gltf::mesh::Mode;
use gltf::{Document, Primitive, Semantic};

use super::accessor::numbers;
use super::file::Buffers;
use crate::formats::scene::SceneError;

/// Every mesh that is read, one after another.
pub(super) struct Meshes {
    /// The nodes that show them.
    pub(super) instances: Vec<Instance>,
    /// Positions without morph targets, V, each in its mesh's space.
    pub(super) positions: Vec<[f64; 3]>,
    /// Vertex numbers of each triangle.
    pub(super) triangles: Vec<[usize; 3]>,
    /// Normals, V; 0 where a mesh has none.
    pub(super) normals: Vec<[f64; 3]>,
    /// Tangents and handedness, V; 0 where a mesh has none.
    pub(super) tangents: Vec<[f64; 4]>,
    /// Texture coordinates, V, v upward; 0 where a mesh has none.
    pub(super) uv: Vec<[f64; 2]>,
    /// Whether any mesh has normals, tangents and texture coordinates.
    pub(super) authored: [bool; 3],
    /// Joints of the instance's skin and weights that carry each vertex; none without a skin.
    pub(super) influences: Vec<Vec<(usize, f64)>>,
}

/// A node that shows a mesh.
pub(super) struct Instance {
    /// The node.
    pub(super) node: usize,
    /// Its name, or that of its mesh.
    pub(super) name: String,
    /// Its skin.
    pub(super) skin: Option<usize>,
    /// The first of its vertices.
    pub(super) first: usize,
    /// Displacements of its vertices by each morph target.
    pub(super) morphs: Vec<Vec<[f64; 3]>>,
    /// Weights of the morph targets where nothing is animated.
    pub(super) weights: Vec<f64>,
}

impl Meshes {
    /// Reads the meshes that the nodes of the file's scene show, in the nodes' order, or only those
    /// that have a skin; names those that were left out.
    ///
    /// # Errors
    /// [`SceneError::NoTriangles`], [`SceneError::Accessor`] and [`SceneError::Count`].
    pub(super) fn read(
        document: &Document,
        buffers: &Buffers,
        shown: impl Fn(usize) -> bool,
        skinned_only: bool,
    ) -> Result<(Self, Vec<String>), SceneError> {
        let mut all = Self {
            instances: Vec::new(),
            positions: Vec::new(),
            triangles: Vec::new(),
            normals: Vec::new(),
            tangents: Vec::new(),
            uv: Vec::new(),
            authored: [false; 3],
            influences: Vec::new(),
        };
        let mut left_out = Vec::new();
        for node in document.nodes().filter(|node| shown(node.index())) {
            let Some(mesh) = node.mesh() else { continue };
            let name = node.name().or(mesh.name()).map(str::to_owned);
            let name = name.unwrap_or_else(|| format!("node {}", node.index()));
            let skin = node.skin().map(|skin| skin.index());
            if skinned_only && skin.is_none() {
                left_out.push(name);
                continue;
            }
            let weights = node.weights().or(mesh.weights()).unwrap_or_default();
            let mut instance = Instance {
                node: node.index(),
                name,
                skin,
                first: all.positions.len(),
                morphs: Vec::new(),
                weights: weights.iter().copied().map(f64::from).collect(),
            };
            for primitive in mesh.primitives() {
                all.add(&primitive, &mut instance, buffers)?;
            }
            instance.weights.resize(instance.morphs.len(), 0.0);
            all.instances.push(instance);
        }
        Ok((all, left_out))
    }

    fn add(
        &mut self,
        primitive: &Primitive<'_>,
        instance: &mut Instance,
        buffers: &Buffers,
    ) -> Result<(), SceneError> {
        let place = || format!("mesh {}", instance.name);
        let count = |what, expected, found| match expected == found {
            true => Ok(()),
            false => Err(SceneError::Count { place: place(), what, expected, found }),
        };
        if primitive.mode() != Mode::Triangles {
            let mode = format!("{:?}", primitive.mode()).to_lowercase();
            return Err(SceneError::NoTriangles { mesh: instance.name.clone(), mode });
        }
        let read = |semantic, width| {
            let accessor = primitive.get(&semantic);
            accessor.map(|accessor| numbers(&accessor, buffers, width)).transpose()
        };
        let base = self.positions.len();
        let positions = read(Semantic::Positions, 3)?.unwrap_or_default();
        let vertex_len = positions.len() / 3;
        self.positions.extend_from_slice(positions.as_chunks().0);

        let corners: Vec<usize> = match primitive.indices() {
            Some(indices) => {
                numbers(&indices, buffers, 1)?.into_iter().map(|index| index as usize).collect()
            }
            None => (0..vertex_len).collect(),
        };
        if let Some(&vertex) = corners.iter().find(|&&vertex| vertex >= vertex_len) {
            return Err(SceneError::NoSuch {
                place: place(),
                what: "vertex",
                found: vertex,
                len: vertex_len,
            });
        }
        count("corners in whole triangles", corners.len() / 3 * 3, corners.len())?;
        let corners = corners.as_chunks::<3>().0;
        self.triangles.extend(corners.iter().map(|corners| corners.map(|vertex| base + vertex)));

        let end = base + vertex_len;
        self.normals.resize(end, [0.0; 3]);
        if let Some(normals) = read(Semantic::Normals, 3)? {
            count("normals", 3 * vertex_len, normals.len())?;
            self.normals[base..].copy_from_slice(normals.as_chunks().0);
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
            // In glTF v grows downward.
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
            for (all, (joints, weights)) in influences.iter_mut().zip(sets) {
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

    /// The vertices of the instances by name, where there are several.
    pub(super) fn ranges(&self) -> Vec<(String, std::ops::Range<usize>)> {
        let named = |number: usize| (self.instances[number].name.clone(), self.vertices(number));
        let count = self.instances.len();
        if count < 2 { Vec::new() } else { (0..count).map(named).collect() }
    }

    /// The vertices of an instance.
    pub(super) fn vertices(&self, instance: usize) -> std::ops::Range<usize> {
        let end = self.instances.get(instance + 1).map_or(self.positions.len(), |next| next.first);
        self.instances[instance].first..end
    }
}
