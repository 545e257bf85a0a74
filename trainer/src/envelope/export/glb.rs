//! A GLB in the making: nodes, skinned meshes and animations, and the bytes behind them.

use std::borrow::Cow;

use gltf::binary::{Glb, Header};
use gltf::json::accessor::{ComponentType, GenericComponentType, Type};
use gltf::json::animation::{Channel, Interpolation, Property, Sampler, Target as Channeled};
use gltf::json::buffer::{Target, View};
use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::scene::UnitQuaternion;
use gltf::json::validation::Checked::Valid;
use gltf::json::{
    Accessor, Animation, Buffer, Index, Mesh, Node, Root, Scene, Skin, Value, extras,
};
use serde_json::json;

use super::error::ExportError;

/// Vertex numbers of a triangle.
type Triangle = [usize; 3];

/// A node of the document.
pub(super) type NodeIndex = Index<Node>;
/// A skin of the document.
pub(super) type SkinIndex = Index<Skin>;

/// A binary glTF 2.0 file in the making: one scene, one buffer.
pub(super) struct Document {
    root: Root,
    scene: Vec<NodeIndex>,
    bytes: Vec<u8>,
}

/// Places a node against its parent: scaled, then turned, then moved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Placed {
    /// Where its origin is.
    pub(super) translation: [f32; 3],
    /// A unit quaternion, xyzw.
    pub(super) rotation: [f32; 4],
    /// Factors along its own axes.
    pub(super) scale: [f32; 3],
}

impl Placed {
    /// Coincides with the parent.
    pub(super) const AT_PARENT: Self =
        Self { translation: [0.0; 3], rotation: [0.0, 0.0, 0.0, 1.0], scale: [1.0; 3] };
}

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
    /// Vertex numbers.
    pub(super) triangles: &'a [Triangle],
}

/// What moves one property of a node: one value a key time.
pub(super) struct Track {
    /// The node.
    pub(super) node: NodeIndex,
    /// The values.
    pub(super) keys: ChannelKeys,
}

/// Values of one property.
pub(super) enum ChannelKeys {
    /// Translations.
    Translation(Vec<[f32; 3]>),
    /// Unit quaternions, xyzw.
    Rotation(Vec<[f32; 4]>),
    /// Scales.
    Scale(Vec<[f32; 3]>),
}

impl Document {
    /// Begins a document whose asset carries a note.
    pub(super) fn new(note: &str) -> Self {
        let mut root = Root::default();
        root.asset.generator = Some(format!("sinew {}", env!("CARGO_PKG_VERSION")));
        root.asset.extras = extras::RawValue::from_string(json!({ "note": note }).to_string()).ok();
        Self { root, scene: Vec::new(), bytes: Vec::new() }
    }

    /// Adds a node under a parent, or to the scene.
    pub(super) fn node(
        &mut self,
        name: String,
        parent: Option<NodeIndex>,
        placed: &Placed,
    ) -> NodeIndex {
        let Placed { translation, rotation, scale } = *placed;
        let stated = |differs: bool| differs.then_some(());
        let rest = Placed::AT_PARENT;
        let node = self.root.push(Node {
            name: Some(name),
            translation: stated(translation != rest.translation).map(|()| translation),
            rotation: stated(rotation != rest.rotation).map(|()| UnitQuaternion(rotation)),
            scale: stated(scale != rest.scale).map(|()| scale),
            ..Node::default()
        });
        match parent.and_then(|parent| self.root.nodes.get_mut(parent.value())) {
            Some(parent) => parent.children.get_or_insert_default().push(node),
            None => self.scene.push(node),
        }
        node
    }

    /// Adds a skin of joints under a common root, with their inverse bind matrices (rows of 3 x 4).
    pub(super) fn skin(
        &mut self,
        root: NodeIndex,
        joints: Vec<NodeIndex>,
        inverse_binds: &[[[f32; 4]; 3]],
    ) -> SkinIndex {
        let columns = |m: &[[f32; 4]; 3]| -> [f32; 16] {
            std::array::from_fn(|at| match (at % 4, at / 4) {
                (3, 3) => 1.0,
                (3, _) => 0.0,
                (row, column) => m[row][column],
            })
        };
        let matrices: Vec<[f32; 16]> = inverse_binds.iter().map(columns).collect();
        let matrices = self.floats(Type::Mat4, &matrices, None);
        self.root.push(Skin {
            extensions: None,
            extras: None,
            inverse_bind_matrices: Some(matrices),
            joints,
            name: None,
            skeleton: Some(root),
        })
    }

    /// Adds a mesh and its node. Weights are divided by their sum; four influences fill a set of
    /// attributes, and there are as many sets as the longest list needs.
    pub(super) fn mesh(&mut self, mesh: &SkinnedMesh<'_>, skin: SkinIndex) {
        let joint_len = self.root.skins.get(skin.value()).map_or(0, |skin| skin.joints.len());
        let vertices = Some(Target::ArrayBuffer);
        let positions: Vec<_> = mesh.positions.iter().map(|x| x.map(|x| x as f32)).collect();
        let normals: Vec<_> = mesh.normals.iter().map(unit).collect();
        let at = self.floats(Type::Vec3, &positions, vertices);
        self.bound(at, &positions);
        let mut attributes = vec![
            (Semantic::Positions, at),
            (Semantic::Normals, self.floats(Type::Vec3, &normals, vertices)),
        ];
        if let Some(uv) = mesh.uv {
            // In glTF v grows downward.
            let uv: Vec<_> = uv.iter().map(|&[u, v]| [u as f32, (1.0 - v) as f32]).collect();
            attributes.push((Semantic::TexCoords(0), self.floats(Type::Vec2, &uv, vertices)));
        }
        let most = mesh.influences.iter().map(Vec::len).max().unwrap_or(0).max(1);
        for set in 0..most.div_ceil(4) {
            let (mut joints, mut weights) = (Vec::new(), Vec::new());
            for influences in mesh.influences {
                let sum: f64 = influences.iter().map(|&(_, weight)| weight).sum();
                let slot = |slot: usize| match influences.get(4 * set + slot) {
                    Some(&(joint, weight)) if weight > 0.0 => (joint, (weight / sum) as f32),
                    _ => (0, 0.0),
                };
                joints.push([0, 1, 2, 3].map(|k| slot(k).0));
                weights.push([0, 1, 2, 3].map(|k| slot(k).1));
            }
            let joints = joints.as_flattened();
            let array = if joint_len <= 256 {
                let bytes = joints.iter().map(|&joint| joint as u8).collect();
                self.array(ComponentType::U8, Type::Vec4, mesh.influences.len(), bytes, vertices)
            } else {
                let bytes = joints.iter().flat_map(|&j| (j as u16).to_le_bytes()).collect();
                self.array(ComponentType::U16, Type::Vec4, mesh.influences.len(), bytes, vertices)
            };
            attributes.push((Semantic::Joints(set as u32), array));
            let weights = self.floats(Type::Vec4, &weights, vertices);
            attributes.push((Semantic::Weights(set as u32), weights));
        }
        let indices = self.indices(mesh.triangles, positions.len());
        let primitive = Primitive {
            attributes: attributes.into_iter().map(|(name, array)| (Valid(name), array)).collect(),
            extensions: None,
            extras: None,
            indices: Some(indices),
            material: None,
            mode: Valid(Mode::Triangles),
            targets: None,
        };
        let name = Some(mesh.name.to_owned());
        let mesh = self.root.push(Mesh {
            extensions: None,
            extras: None,
            name: name.clone(),
            primitives: vec![primitive],
            weights: None,
        });
        // A skin moves the mesh by itself: under another node, that node's place would be ignored.
        let node = Node { name, mesh: Some(mesh), skin: Some(skin), ..Node::default() };
        let node = self.root.push(node);
        self.scene.push(node);
    }

    /// Adds an animation with keys at some times, in seconds, ascending; between them values are
    /// interpolated linearly, rotations along the shorter arc.
    pub(super) fn animation(&mut self, name: &str, times: &[f32], tracks: Vec<Track>) {
        let times: Vec<[f32; 1]> = times.iter().map(|&time| [time]).collect();
        let input = self.floats(Type::Scalar, &times, None);
        self.bound(input, &times);
        let (mut channels, mut samplers) = (Vec::new(), Vec::new());
        for Track { node, keys } in tracks {
            let (path, output) = match keys {
                ChannelKeys::Translation(keys) => {
                    (Property::Translation, self.floats(Type::Vec3, &keys, None))
                }
                ChannelKeys::Rotation(keys) => {
                    (Property::Rotation, self.floats(Type::Vec4, &keys, None))
                }
                ChannelKeys::Scale(keys) => (Property::Scale, self.floats(Type::Vec3, &keys, None)),
            };
            let sampler = Sampler {
                extensions: None,
                extras: None,
                input,
                interpolation: Valid(Interpolation::Linear),
                output,
            };
            let sampler = Index::push(&mut samplers, sampler);
            let target = Channeled { extensions: None, extras: None, node, path: Valid(path) };
            channels.push(Channel { sampler, target, extensions: None, extras: None });
        }
        let name = Some(name.to_owned());
        self.root.push(Animation { extensions: None, extras: None, channels, name, samplers });
    }

    /// Gives the file's bytes.
    ///
    /// # Errors
    /// [`ExportError::TooLarge`] and [`ExportError::Glb`].
    pub(super) fn finish(mut self) -> Result<Vec<u8>, ExportError> {
        self.root.push(Buffer {
            byte_length: self.bytes.len().into(),
            name: None,
            uri: None,
            extensions: None,
            extras: None,
        });
        let scene = Scene {
            extensions: None,
            extras: None,
            name: None,
            nodes: std::mem::take(&mut self.scene),
        };
        self.root.scene = Some(self.root.push(scene));
        let json = self.root.to_vec().map_err(gltf::Error::Deserialize)?;
        let bytes = json.len() + self.bytes.len();
        // Heads and padding take less than the last 64 bytes.
        if bytes > u32::MAX as usize - 64 {
            return Err(ExportError::TooLarge { bytes });
        }
        // The writer finds the length itself.
        let header = Header { magic: *b"glTF", version: 2, length: 0 };
        let glb = Glb { header, json: Cow::Owned(json), bin: Some(Cow::Owned(self.bytes)) };
        Ok(glb.to_vec()?)
    }

    fn indices(&mut self, triangles: &[Triangle], vertex_len: usize) -> Index<Accessor> {
        let corners = triangles.as_flattened();
        let target = Some(Target::ElementArrayBuffer);
        // The largest number of a width is kept free: some engines restart a strip at it.
        if vertex_len <= usize::from(u16::MAX) {
            let bytes = corners.iter().flat_map(|&vertex| (vertex as u16).to_le_bytes()).collect();
            return self.array(ComponentType::U16, Type::Scalar, corners.len(), bytes, target);
        }
        let bytes = corners.iter().flat_map(|&vertex| (vertex as u32).to_le_bytes()).collect();
        self.array(ComponentType::U32, Type::Scalar, corners.len(), bytes, target)
    }

    fn floats<const N: usize>(
        &mut self,
        kind: Type,
        rows: &[[f32; N]],
        target: Option<Target>,
    ) -> Index<Accessor> {
        let bytes = rows.as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect();
        self.array(ComponentType::F32, kind, rows.len(), bytes, target)
    }

    /// Adds an array in a view of its own, which begins on a multiple of four.
    fn array(
        &mut self,
        component: ComponentType,
        kind: Type,
        len: usize,
        bytes: Vec<u8>,
        target: Option<Target>,
    ) -> Index<Accessor> {
        let view = self.root.push(View {
            buffer: Index::new(0),
            byte_length: bytes.len().into(),
            byte_offset: Some(self.bytes.len().into()),
            byte_stride: None,
            name: None,
            target: target.map(Valid),
            extensions: None,
            extras: None,
        });
        self.bytes.extend(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.root.push(Accessor {
            buffer_view: Some(view),
            byte_offset: None,
            count: len.into(),
            component_type: Valid(GenericComponentType(component)),
            extensions: None,
            extras: None,
            type_: Valid(kind),
            min: None,
            max: None,
            name: None,
            normalized: false,
            sparse: None,
        })
    }

    /// States an array's bounds, which glTF wants of positions and of key times.
    fn bound<const N: usize>(&mut self, array: Index<Accessor>, rows: &[[f32; N]]) {
        let bound = |choose: fn(f32, f32) -> f32, from: f32| -> Value {
            let all = |axis: usize| rows.iter().map(|row| row[axis]).fold(from, choose);
            (0..N).map(all).collect()
        };
        if let Some(array) = self.root.accessors.get_mut(array.value()) {
            array.min = Some(bound(f32::min, f32::INFINITY));
            array.max = Some(bound(f32::max, f32::NEG_INFINITY));
        }
    }
}

/// Rounds a direction to a unit vector.
fn unit(direction: &[f64; 3]) -> [f32; 3] {
    let length = direction.iter().map(|x| x * x).sum::<f64>().sqrt();
    if length > 0.0 { direction.map(|x| (x / length) as f32) } else { [0.0, 1.0, 0.0] }
}
