//! The nodes of a glTF file, a forest of local transforms.

use crate::Error;
use crate::formats::scene::Hierarchy;
use gltf::Document;
use nalgebra::{Matrix4, Quaternion, Translation3, UnitQuaternion, Vector3};

/// Transform of a node relative to its parent.
#[derive(Clone, Debug)]
pub(super) enum Local {
    /// Scale, then rotation, then translation.
    Parts {
        /// Offset.
        translation: Vector3<f64>,
        /// Rotation, not normalised.
        rotation: Quaternion<f64>,
        /// Factor along each axis.
        scale: Vector3<f64>,
    },
    /// The file's matrix; such a node is not animated.
    Matrix(Matrix4<f64>),
}

/// All nodes of the file.
pub(super) struct Nodes {
    /// Names, made up for nodes without a name, and parents.
    pub(super) tree: Hierarchy,
    /// Which nodes belong to the default scene; all nodes if the file has no scene.
    pub(super) shown: Vec<bool>,
    /// Transform of each node without animation.
    pub(super) locals: Vec<Local>,
    /// Nodes, parents before children.
    pub(super) order: Vec<usize>,
}

impl Nodes {
    /// Reads the nodes.
    ///
    /// # Errors
    /// The nodes do not form a tree.
    pub(super) fn read(document: &Document) -> Result<Self, Error> {
        let name = |node: gltf::Node<'_>| match node.name() {
            Some(name) => name.to_owned(),
            None => format!("node {}", node.index()),
        };
        let names: Vec<String> = document.nodes().map(name).collect();
        let no_tree = |node: usize| {
            let node = &names[node];
            Error::damaged(format!("node {node} has two parents or is its own ancestor"))
        };
        let mut parents = vec![None; names.len()];
        let mut children = vec![Vec::new(); names.len()];
        for node in document.nodes() {
            for child in node.children().map(|child| child.index()) {
                if parents[child].replace(node.index()).is_some() {
                    return Err(no_tree(child));
                }
                children[node.index()].push(child);
            }
        }
        let mut order: Vec<usize> =
            (0..parents.len()).filter(|&node| parents[node].is_none()).collect();
        let mut next = 0;
        while let Some(&node) = order.get(next) {
            order.extend(&children[node]);
            next += 1;
        }
        // Every node has at most one parent, so nodes that hang under no root form a cycle.
        let is_in_cycle = |node: &usize| order.len() < parents.len() && !order.contains(node);
        if let Some(node) = (0..parents.len()).find(is_in_cycle) {
            return Err(no_tree(node));
        }
        let locals = document.nodes().map(|node| local(&node.transform())).collect();
        let mut shown = vec![true; names.len()];
        let tree = Hierarchy { names, parents };
        if let Some(scene) = document.default_scene().or_else(|| document.scenes().next()) {
            let roots: Vec<usize> = scene.nodes().map(|node| node.index()).collect();
            for (node, shown) in shown.iter_mut().enumerate() {
                *shown = tree.upwards(node).any(|up| roots.contains(&up));
            }
        }
        Ok(Self { tree, shown, locals, order })
    }

    /// Returns whether the default scene has no node.
    pub(super) fn is_empty(&self) -> bool {
        !self.shown.contains(&true)
    }

    /// Returns the world transform of every node.
    pub(super) fn worlds(&self, locals: &[Local]) -> Vec<Matrix4<f64>> {
        let mut worlds = vec![Matrix4::identity(); locals.len()];
        for &node in &self.order {
            let local = locals[node].matrix();
            worlds[node] = self.tree.parents[node].map_or(local, |parent| worlds[parent] * local);
        }
        worlds
    }
}

impl Local {
    /// Returns the transform as a matrix.
    pub(super) fn matrix(&self) -> Matrix4<f64> {
        match self {
            Self::Parts { translation, rotation, scale } => {
                let moved = Translation3::from(*translation).to_homogeneous();
                let turned = UnitQuaternion::from_quaternion(*rotation).to_homogeneous();
                moved * turned * Matrix4::new_nonuniform_scaling(scale)
            }
            Self::Matrix(matrix) => *matrix,
        }
    }
}

/// Converts a transform of the library.
fn local(transform: &gltf::scene::Transform) -> Local {
    match *transform {
        gltf::scene::Transform::Matrix { matrix } => {
            Local::Matrix(Matrix4::from_fn(|row, column| f64::from(matrix[column][row])))
        }
        gltf::scene::Transform::Decomposed { translation, rotation: [x, y, z, w], scale } => {
            let [x, y, z, w] = [x, y, z, w].map(f64::from);
            Local::Parts {
                translation: translation.map(f64::from).into(),
                rotation: Quaternion::new(w, x, y, z),
                scale: scale.map(f64::from).into(),
            }
        }
    }
}
