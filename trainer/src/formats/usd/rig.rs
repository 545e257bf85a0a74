//! Nodes of a document as joints of a skeleton.

use ::gltf::{Gltf, Node};
use nalgebra::{Matrix4, Quaternion, Translation3, UnitQuaternion, Vector3};
use std::collections::HashMap;

use super::text::Names;

/// Gives the bytes of a document's buffer.
pub(super) type Arrays<'a> = &'a dyn Fn(::gltf::Buffer<'_>) -> Option<&'a [u8]>;

/// Name of the skeleton.
pub(super) const SKELETON: &str = "Skeleton";

/// The nodes under the root of a skin.
pub(super) struct Rig {
    /// Name of the root node.
    pub(super) root: String,
    /// Transform of the root node.
    pub(super) placed: Matrix4<f64>,
    /// All nodes below, parents before children.
    pub(super) joints: Vec<Joint>,
    /// Index of the joint of each node.
    pub(super) of_node: HashMap<usize, usize>,
    /// Joints of the skin, in its order.
    pub(super) of_skin: Vec<usize>,
}

/// A node as a joint.
pub(super) struct Joint {
    /// Names from the root down, with slashes.
    pub(super) path: String,
    pub(super) name: String,
    /// Transform without animation, relative to the parent.
    pub(super) rest: Local,
    /// Frame in the bind pose, relative to the root.
    pub(super) bind: Matrix4<f64>,
}

/// Translation, rotation (xyzw) and scale of a node.
#[derive(Clone, Copy)]
pub(super) struct Local {
    pub(super) translation: [f32; 3],
    pub(super) rotation: [f32; 4],
    pub(super) scale: [f32; 3],
}

impl Local {
    fn of(node: &Node<'_>) -> Self {
        let (translation, rotation, scale) = node.transform().decomposed();
        Self { translation, rotation, scale }
    }

    pub(super) fn matrix(&self) -> Matrix4<f64> {
        let [moved, factors] =
            [self.translation, self.scale].map(|x| Vector3::from(x.map(f64::from)));
        let turned = Quaternion::from(self.rotation.map(f64::from));
        Translation3::from(moved).to_homogeneous()
            * UnitQuaternion::from_quaternion(turned).to_homogeneous()
            * Matrix4::new_nonuniform_scaling(&factors)
    }
}

impl Rig {
    /// Reads the nodes of the first skin; `None` if there is no skin, or no root node.
    pub(super) fn read(file: &Gltf, arrays: Arrays<'_>) -> Option<Self> {
        let skin = file.skins().next()?;
        let root = skin.skeleton()?;
        let mut rig = Self {
            root: Names::default().new_one(root.name().unwrap_or("root")),
            placed: Local::of(&root).matrix(),
            joints: Vec::new(),
            of_node: HashMap::new(),
            of_skin: Vec::new(),
        };
        rig.add_children(&root, "", &Matrix4::identity());
        let inverse_binds = skin.reader(arrays).read_inverse_bind_matrices()?;
        for (node, inverse) in skin.joints().zip(inverse_binds) {
            let joint = *rig.of_node.get(&node.index())?;
            let inverse = Matrix4::from_fn(|row, column| f64::from(inverse[column][row]));
            rig.joints[joint].bind = inverse.try_inverse()?;
            rig.of_skin.push(joint);
        }
        Some(rig)
    }

    fn add_children(&mut self, node: &Node<'_>, path: &str, world: &Matrix4<f64>) {
        let mut names = Names::default();
        for child in node.children() {
            let name = child.name().unwrap_or("joint");
            let path = format!("{path}{}", names.new_one(name));
            let rest = Local::of(&child);
            let bind = world * rest.matrix();
            self.of_node.insert(child.index(), self.joints.len());
            self.joints.push(Joint { path: path.clone(), name: name.to_owned(), rest, bind });
            self.add_children(&child, &format!("{path}/"), &bind);
        }
    }
}
