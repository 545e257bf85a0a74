//! Skinned meshes of a document: the model's mesh, its parts by name and material, and further meshes on the palette.

use rayon::prelude::*;
use serde_json::{Value, json};
use std::ops::Range;

use super::played::Played;
use crate::Error;
use crate::envelope::levels::{Influences, Level, LevelReport, SkinSurface};
use crate::envelope::posed::skin_on;
use crate::evaluate::Character;
use crate::examples::Examples;
use crate::formats::appearance::{Appearance, Image, image_kind};
use crate::formats::gltf::write::{ArrayIndex, ArrayKind, Document, F32, SkinIndex, U8, U16};
use crate::space::Conversion;

/// A mesh of V vertices on a skin, in its bind pose.
pub(super) struct SkinnedMesh<'a> {
    /// Name of the mesh and of its node.
    pub(super) name: &'a str,
    /// Positions, V.
    pub(super) positions: &'a [[f64; 3]],
    /// Normals, V; zero normals get an arbitrary direction, because glTF requires unit vectors.
    pub(super) normals: &'a [[f64; 3]],
    /// Texture coordinates, V, v upward.
    pub(super) uv: Option<&'a [[f64; 2]]>,
    /// Joints of the skin with weights, V lists.
    pub(super) influences: &'a [Vec<(usize, f64)>],
    /// Material of each primitive, and its triangles by vertex.
    pub(super) primitives: &'a [(Option<usize>, Vec<[usize; 3]>)],
}

impl Document {
    /// Adds a mesh and its node.
    pub(super) fn mesh(&mut self, mesh: &SkinnedMesh<'_>, skin: SkinIndex) {
        let positions: Vec<_> = mesh.positions.iter().map(|x| x.map(|x| x as f32)).collect();
        let normals: Vec<_> = mesh.normals.iter().map(unit).collect();
        let at = self.floats(ArrayKind::vertices(F32, "VEC3"), &positions);
        self.bound(at, &positions);
        let normals = self.floats(ArrayKind::vertices(F32, "VEC3"), &normals);
        let mut attributes = json!({ "POSITION": at, "NORMAL": normals });
        if let Some(uv) = mesh.uv {
            // In glTF v grows downward.
            let uv: Vec<_> = uv.iter().map(|&[u, v]| [u as f32, (1.0 - v) as f32]).collect();
            attributes["TEXCOORD_0"] = json!(self.floats(ArrayKind::vertices(F32, "VEC2"), &uv));
        }
        let joint_len = self.skins[skin]["joints"].as_array().map_or(0, Vec::len);
        for (name, array) in self.influences(mesh.influences, joint_len) {
            attributes[name] = array;
        }
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
        // The skin alone moves the mesh. Under another node, that node's transform would be ignored.
        let node = json!({ "name": mesh.name, "mesh": self.meshes.len() - 1, "skin": skin });
        self.nodes.push(node);
        self.show(self.nodes.len() - 1);
    }

    /// Adds the joints and weights of vertices, and returns the attributes by name. Weights are divided by their sum.
    /// Four influences fill a set; the longest list determines the number of sets.
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
        let (component, bytes) = match joint_len <= 256 {
            true => (U8, all.map(|&joint| joint as u8).collect()),
            false => (U16, all.flat_map(|&joint| (joint as u16).to_le_bytes()).collect()),
        };
        self.array(ArrayKind::vertices(component, "VEC4"), joints.len(), bytes)
    }
}

/// Normalises a direction and rounds it to single precision; +y for a zero vector.
fn unit(direction: &[f64; 3]) -> [f32; 3] {
    let length = direction.iter().map(|x| x * x).sum::<f64>().sqrt();
    if length > 0.0 { direction.map(|x| (x / length) as f32) } else { [0.0, 1.0, 0.0] }
}

/// A part of a mesh: name, vertices, and the triangles of each material.
pub(super) struct Part<'a> {
    name: &'a str,
    vertices: Range<usize>,
    primitives: Vec<(Option<usize>, Vec<[usize; 3]>)>,
}

/// Splits a mesh by named ranges of its vertices and by material, both in order. Without ranges the mesh is one part.
/// Ranges without triangles are left out.
pub(super) fn parts<'a>(
    mesh: &SkinnedMesh<'a>,
    ranges: impl Iterator<Item = (&'a str, Range<usize>)>,
    triangles: &[[usize; 3]],
    materials: &[Option<usize>],
) -> Vec<Part<'a>> {
    let part = |(name, vertices)| Part { name, vertices, primitives: Vec::new() };
    let mut parts: Vec<_> = ranges.map(part).collect();
    if parts.is_empty() {
        parts.push(part((mesh.name, 0..mesh.positions.len())));
    }
    let materials = materials.iter().copied().chain(std::iter::repeat(None));
    for (triangle, material) in triangles.iter().zip(materials) {
        // The joined meshes follow one another.
        let part = parts.partition_point(|part| part.vertices.end <= triangle[0]);
        let Some(Part { vertices, primitives, .. }) = parts.get_mut(part) else { continue };
        let own = triangle.map(|vertex| vertex - vertices.start);
        match primitives.iter_mut().find(|(other, _)| *other == material) {
            Some((_, triangles)) => triangles.push(own),
            None => primitives.push((material, vec![own])),
        }
    }
    parts.retain(|part| !part.primitives.is_empty());
    parts
}

impl Part<'_> {
    /// Returns the part of a mesh.
    pub(super) fn of<'a>(&'a self, mesh: &SkinnedMesh<'a>) -> SkinnedMesh<'a> {
        let own = self.vertices.clone();
        SkinnedMesh {
            name: self.name,
            positions: &mesh.positions[own.clone()],
            normals: &mesh.normals[own.clone()],
            uv: mesh.uv.map(|uv| &uv[own.clone()]),
            influences: &mesh.influences[own],
            primitives: &self.primitives,
        }
    }
}

impl Document {
    /// Adds materials with their textures, samplers and images. Without texture coordinates, textures are left out.
    pub(super) fn dress(&mut self, appearance: &Appearance, uv: bool) {
        let mut appearance = appearance.clone();
        appearance.keep_uv(uv);
        let extensions = appearance.extensions();
        let Appearance { materials, textures, samplers, images, required, .. } = appearance;
        let picture = |image: Image| {
            let mut members = image.members;
            if let Some(kind) = image_kind(&image.bytes) {
                members.insert("mimeType".to_owned(), json!(kind));
            }
            members.insert("bufferView".to_owned(), json!(self.view(image.bytes)));
            Value::Object(members)
        };
        let images: Vec<Value> = images.into_iter().map(picture).collect();
        for (name, items) in [
            ("materials", materials),
            ("textures", textures),
            ("samplers", samplers),
            ("images", images),
            ("extensionsUsed", extensions.into_iter().map(Value::from).collect()),
            ("extensionsRequired", required.into_iter().map(Value::from).collect()),
        ] {
            if !items.is_empty() {
                self.root.insert(name.to_owned(), Value::Array(items));
            }
        }
    }
}

/// Further meshes and their weights on the palette.
#[derive(Default)]
pub(super) struct FurtherMeshes {
    levels: Vec<Level>,
    influences: Vec<Influences>,
    /// Reports on the meshes, in order.
    pub(super) reports: Vec<LevelReport>,
}

impl FurtherMeshes {
    /// Computes the weights of further meshes. Meshes in other axes or units are converted.
    ///
    /// # Errors
    /// A mesh does not lie on the model's skin, or the runtime refuses a frame.
    pub(super) fn new(
        played: &Played<'_>,
        examples: &Examples,
        levels: &[Level],
    ) -> Result<Self, Error> {
        if levels.is_empty() {
            return Ok(Self::default());
        }
        let own = examples.surface();
        let Played { character: Character { skin, .. }, rest, palettes, influences, .. } = played;
        let posed = palettes
            .par_iter()
            .enumerate()
            .map(|(key, palette)| {
                let [positions, _] = skin_on(skin, palette, key)?;
                Ok(own.of_first_copies(positions.as_chunks().0))
            })
            .collect::<Result<Vec<_>, Error>>()?;
        let surface = SkinSurface {
            rest: &own.of_first_copies(rest),
            triangles: &examples.solid_triangles(),
            influences: &own.of_first_copies(influences),
            most: skin.influence_len(),
            diagonal: examples.diagonal(),
            palettes,
            posed,
        };
        let mut levels = levels.to_vec();
        let (influences, reports) = surface.follow_all(&mut levels)?;
        Ok(Self { levels, influences, reports })
    }

    /// Mirrors the meshes.
    pub(super) fn convert(&mut self, mirror: &Conversion) {
        self.levels.iter_mut().for_each(|level| level.mesh.convert(mirror));
    }

    /// Adds the meshes to a document, on a skin.
    pub(super) fn add(&self, document: &mut Document, skin: SkinIndex) {
        for (level, influences) in self.levels.iter().zip(&self.influences) {
            let surface = level.mesh.surface();
            let mesh = SkinnedMesh {
                name: &level.name,
                positions: &surface.copied(&level.mesh.positions),
                normals: &surface.normals(),
                uv: surface.uv(),
                influences: &surface.copied(influences),
                primitives: &[(None, surface.engine_triangles().to_vec())],
            };
            document.mesh(&mesh, skin);
        }
    }
}
