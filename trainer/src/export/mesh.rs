//! Skinned meshes of a document: what is in their vertices.

use serde_json::{Map, Value, json};

use crate::formats::gltf::write::{ArrayIndex, ArrayKind, Document, F32, SkinIndex, U8, U16};

/// A mesh of V vertices on a skin, in its bind pose.
pub(super) struct SkinnedMesh<'a> {
    /// Its name, and that of its node.
    pub(super) name: &'a str,
    /// Positions, V.
    pub(super) positions: &'a [[f64; 3]],
    /// Normals, V; those of no length become any direction, as glTF wants one.
    pub(super) normals: &'a [[f64; 3]],
    /// Texture coordinates, V, v upward.
    pub(super) uv: Option<&'a [[f64; 2]]>,
    /// Joint of the skin and weight, V lists.
    pub(super) influences: &'a [Vec<(usize, f64)>],
    /// Vertex numbers of the triangles of each primitive, and its material.
    pub(super) primitives: &'a [(Option<usize>, Vec<[usize; 3]>)],
}

impl Document {
    /// Adds a mesh and its node.
    pub(super) fn mesh(&mut self, mesh: &SkinnedMesh<'_>, skin: SkinIndex) {
        let positions: Vec<_> = mesh.positions.iter().map(|x| x.map(|x| x as f32)).collect();
        let normals: Vec<_> = mesh.normals.iter().map(unit).collect();
        let at = self.floats(ArrayKind::vertices(F32, "VEC3"), &positions);
        self.bound(at, &positions);
        let mut attributes = Map::new();
        attributes.insert("POSITION".to_owned(), json!(at));
        let at = self.floats(ArrayKind::vertices(F32, "VEC3"), &normals);
        attributes.insert("NORMAL".to_owned(), json!(at));
        if let Some(uv) = mesh.uv {
            // In glTF v grows downward.
            let uv: Vec<_> = uv.iter().map(|&[u, v]| [u as f32, (1.0 - v) as f32]).collect();
            let at = self.floats(ArrayKind::vertices(F32, "VEC2"), &uv);
            attributes.insert("TEXCOORD_0".to_owned(), json!(at));
        }
        let joint_len = self.skins[skin]["joints"].as_array().map_or(0, Vec::len);
        attributes.extend(self.influences(mesh.influences, joint_len));
        let primitive = |(material, triangles): &(Option<usize>, Vec<[usize; 3]>)| {
            let indices = self.indices(triangles, positions.len());
            let mut primitive = json!({ "attributes": attributes, "indices": indices, "mode": 4 });
            if let Some(material) = material {
                primitive["material"] = json!(material);
            }
            primitive
        };
        let primitives: Vec<_> = mesh.primitives.iter().map(primitive).collect();
        self.meshes.push(json!({ "name": mesh.name, "primitives": primitives }));
        // A skin moves the mesh by itself: under another node, that node's place would be ignored.
        let node = json!({ "name": mesh.name, "mesh": self.meshes.len() - 1, "skin": skin });
        self.nodes.push(node);
        self.show(self.nodes.len() - 1);
    }

    /// Adds the joints and weights of vertices, by the names of their attributes. Weights are divided by
    /// their sum; four influences fill a set, and there are as many sets as the longest list needs.
    pub(super) fn influences(
        &mut self,
        influences: &[Vec<(usize, f64)>],
        joint_len: usize,
    ) -> Vec<(String, Value)> {
        let most = influences.iter().map(Vec::len).max().unwrap_or(0).max(1);
        let mut attributes = Vec::new();
        for set in 0..most.div_ceil(4) {
            let (mut joints, mut weights) = (Vec::new(), Vec::new());
            for influences in influences {
                let sum: f64 = influences.iter().map(|&(_, weight)| weight).sum();
                let slot = |slot: usize| match influences.get(4 * set + slot) {
                    Some(&(joint, weight)) if weight > 0.0 => (joint, (weight / sum) as f32),
                    _ => (0, 0.0),
                };
                joints.push([0, 1, 2, 3].map(|k| slot(k).0));
                weights.push([0, 1, 2, 3].map(|k| slot(k).1));
            }
            let joints = self.joints(&joints, joint_len);
            attributes.push((format!("JOINTS_{set}"), json!(joints)));
            let weights = self.floats(ArrayKind::vertices(F32, "VEC4"), &weights);
            attributes.push((format!("WEIGHTS_{set}"), json!(weights)));
        }
        attributes
    }

    fn joints(&mut self, joints: &[[usize; 4]], joint_len: usize) -> ArrayIndex {
        let all = joints.as_flattened().iter();
        if joint_len <= 256 {
            let bytes = all.map(|&joint| joint as u8).collect();
            return self.array(ArrayKind::vertices(U8, "VEC4"), joints.len(), bytes);
        }
        let bytes = all.flat_map(|&joint| (joint as u16).to_le_bytes()).collect();
        self.array(ArrayKind::vertices(U16, "VEC4"), joints.len(), bytes)
    }
}

/// Rounds a direction to a unit vector.
fn unit(direction: &[f64; 3]) -> [f32; 3] {
    let length = direction.iter().map(|x| x * x).sum::<f64>().sqrt();
    if length > 0.0 { direction.map(|x| (x / length) as f32) } else { [0.0, 1.0, 0.0] }
}
