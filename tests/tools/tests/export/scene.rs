//! Plays a GLB as an engine does, by the glTF 2.0 specification only: nodes, keys, skins.

use super::Pose;
use gltf::animation::util::ReadOutputs;
use nalgebra::{Matrix4, Quaternion, Translation3, UnitQuaternion, Vector3, Vector4};

/// A file that was read back.
pub(crate) struct Scene {
    pub(crate) gltf: gltf::Gltf,
}

/// Translation, rotation and scale of a node.
type Placed = (Vector3<f64>, UnitQuaternion<f64>, Vector3<f64>);

impl Scene {
    pub(crate) fn read(bytes: &[u8]) -> Self {
        Self { gltf: gltf::Gltf::from_slice(bytes).unwrap() }
    }

    fn bytes<'a>(&'a self) -> impl Clone + Fn(gltf::Buffer<'_>) -> Option<&'a [u8]> {
        move |_| self.gltf.blob.as_deref()
    }

    pub(crate) fn node(&self, name: &str) -> usize {
        self.find(name).unwrap()
    }

    pub(crate) fn find(&self, name: &str) -> Option<usize> {
        self.gltf.nodes().find(|node| node.name() == Some(name)).map(|node| node.index())
    }

    /// Returns the key times of an animation, which all channels share.
    pub(crate) fn times(&self, animation: usize) -> Vec<f32> {
        let animation = self.gltf.animations().nth(animation).unwrap();
        let times = |channel: gltf::animation::Channel<'_>| -> Vec<f32> {
            channel.reader(self.bytes()).read_inputs().unwrap().collect()
        };
        let mut all = animation.channels().map(times);
        let first = all.next().unwrap();
        assert!(all.all(|other| other == first));
        first
    }

    /// Returns the world matrices of all nodes: at rest, or `part` of the way from a key to the
    /// next.
    pub(crate) fn worlds(&self, at: Option<(usize, usize, f64)>) -> Vec<Matrix4<f64>> {
        let mut placed: Vec<Placed> = self.gltf.nodes().map(|node| rest(&node)).collect();
        if let Some((animation, key, part)) = at {
            for channel in self.gltf.animations().nth(animation).unwrap().channels() {
                let node = &mut placed[channel.target().node().index()];
                let next = if part > 0.0 { key + 1 } else { key };
                match channel.reader(self.bytes()).read_outputs().unwrap() {
                    ReadOutputs::Translations(keys) => {
                        let keys: Vec<_> = keys.map(vector).collect();
                        node.0 = keys[key].lerp(&keys[next], part);
                    }
                    ReadOutputs::Scales(keys) => {
                        let keys: Vec<_> = keys.map(vector).collect();
                        node.2 = keys[key].lerp(&keys[next], part);
                    }
                    ReadOutputs::Rotations(keys) => {
                        let keys: Vec<_> = keys.into_f32().map(rotation).collect();
                        // The shorter arc, as the specification demands.
                        node.1 = keys[key].slerp(&keys[next], part);
                    }
                    ReadOutputs::MorphTargetWeights(_) => panic!("no morph targets are written"),
                }
            }
        }
        let mut worlds = vec![Matrix4::identity(); placed.len()];
        let scene = self.gltf.default_scene().unwrap();
        let mut open: Vec<_> = scene.nodes().map(|node| (node, Matrix4::identity())).collect();
        while let Some((node, parent)) = open.pop() {
            let (translation, rotation, scale) = placed[node.index()];
            let local = Translation3::from(translation).to_homogeneous()
                * rotation.to_homogeneous()
                * Matrix4::new_nonuniform_scaling(&scale);
            let world = parent * local;
            worlds[node.index()] = world;
            open.extend(node.children().map(|child| (child, world)));
        }
        worlds
    }

    /// Returns, for each joint of the first skin, the transform of points of the bind pose.
    pub(crate) fn palette(&self, worlds: &[Matrix4<f64>]) -> Vec<Matrix4<f64>> {
        self.palette_of(&self.gltf.skins().next().unwrap(), worlds)
    }

    fn palette_of(&self, skin: &gltf::Skin<'_>, worlds: &[Matrix4<f64>]) -> Vec<Matrix4<f64>> {
        let inverse_binds = skin.reader(self.bytes()).read_inverse_bind_matrices().unwrap();
        let matrix = |m: [[f32; 4]; 4]| Matrix4::from_fn(|row, column| f64::from(m[column][row]));
        let joints = skin.joints().map(|joint| worlds[joint.index()]);
        joints.zip(inverse_binds.map(matrix)).map(|(world, bind)| world * bind).collect()
    }

    /// Returns the pose of joints by name. A joint that stretches has a node for its stretch.
    pub(crate) fn pose(&self, names: &[String], worlds: &[Matrix4<f64>]) -> Pose {
        let at_rest = self.worlds(None);
        let map = |name: &String| {
            let stretched = self.find(&format!("{name}_axes"));
            let node = stretched.unwrap_or_else(|| self.node(name));
            let map = worlds[node] * at_rest[node].try_inverse().unwrap();
            [0, 1, 2].map(|r| [0, 1, 2, 3].map(|c| map[(r, c)] as f32))
        };
        Pose { joints: names.iter().map(map).collect(), curves: Vec::new() }
    }

    /// Skins the mesh whose node has this name, by linear blend skinning.
    pub(crate) fn skinned(&self, mesh: &str, palette: &[Matrix4<f64>]) -> Vec<Vector3<f64>> {
        let node = self.gltf.nodes().nth(self.node(mesh)).unwrap();
        assert_eq!(node.skin().unwrap().index(), 0);
        self.blended(&node.mesh().unwrap().primitives().next().unwrap(), palette)
    }

    /// Skins every primitive of the mesh whose node has this name, by the node's skin.
    pub(crate) fn posed(&self, mesh: &str, worlds: &[Matrix4<f64>]) -> Vec<Vector3<f64>> {
        let node = self.gltf.nodes().nth(self.node(mesh)).unwrap();
        let palette = self.palette_of(&node.skin().unwrap(), worlds);
        let primitives = node.mesh().unwrap().primitives();
        primitives.flat_map(|primitive| self.blended(&primitive, &palette)).collect()
    }

    fn blended(&self, of: &gltf::Primitive<'_>, palette: &[Matrix4<f64>]) -> Vec<Vector3<f64>> {
        let reader = of.reader(self.bytes());
        let positions: Vec<_> = reader.read_positions().unwrap().map(vector).collect();
        let mut out = vec![Vector3::zeros(); positions.len()];
        let mut set = 0;
        while let (Some(joints), Some(weights)) =
            (reader.read_joints(set), reader.read_weights(set))
        {
            for (vertex, (joints, weights)) in joints.into_u16().zip(weights.into_f32()).enumerate()
            {
                let [x, y, z] = positions[vertex].into();
                for (joint, weight) in joints.into_iter().zip(weights) {
                    let moved = palette[usize::from(joint)] * Vector4::new(x, y, z, 1.0);
                    out[vertex] += moved.xyz() * f64::from(weight);
                }
            }
            set += 1;
        }
        out
    }

    /// Returns the corners of a mesh's triangles.
    pub(crate) fn indices(&self, mesh: &str) -> Vec<usize> {
        let node = self.gltf.nodes().nth(self.node(mesh)).unwrap();
        let primitive = node.mesh().unwrap().primitives().next().unwrap();
        let indices = primitive.reader(self.bytes()).read_indices().unwrap();
        indices.into_u32().map(|index| index as usize).collect()
    }
}

fn rest(node: &gltf::Node<'_>) -> Placed {
    let (translation, turned, scale) = node.transform().decomposed();
    (vector(translation), rotation(turned), vector(scale))
}

fn vector(x: [f32; 3]) -> Vector3<f64> {
    x.map(f64::from).into()
}

fn rotation(xyzw: [f32; 4]) -> UnitQuaternion<f64> {
    UnitQuaternion::from_quaternion(Quaternion::from(xyzw.map(f64::from)))
}
