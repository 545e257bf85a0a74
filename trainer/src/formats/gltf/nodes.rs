//! The nodes of a glTF file: a forest of local transforms.

use gltf::Document;
use nalgebra::{Matrix4, Quaternion, Translation3, UnitQuaternion, Vector3};

use crate::formats::scene::SceneError;

/// A node's transform relative to its parent.
#[derive(Clone, Debug)]
pub(super) enum Local {
    /// Scaled, then turned, then moved.
    Parts {
        /// Offset.
        translation: Vector3<f64>,
        /// Rotation, normalised where it is used.
        rotation: Quaternion<f64>,
        /// Factor along each axis.
        scale: Vector3<f64>,
    },
    /// As the file has it; such a node is not animated.
    Matrix(Matrix4<f64>),
}

/// Every node of the file, by its number.
pub(super) struct Nodes {
    /// Names, made up where the file has none.
    pub(super) names: Vec<String>,
    /// Parents.
    pub(super) parents: Vec<Option<usize>>,
    /// Transforms where nothing is animated.
    pub(super) locals: Vec<Local>,
    /// Nodes, parents before children.
    pub(super) order: Vec<usize>,
}

impl Nodes {
    /// Reads the nodes.
    ///
    /// # Errors
    /// [`SceneError::NoTree`]
    pub(super) fn read(document: &Document) -> Result<Self, SceneError> {
        let name = |node: gltf::Node<'_>| match node.name() {
            Some(name) => name.to_owned(),
            None => format!("node {}", node.index()),
        };
        let names: Vec<String> = document.nodes().map(name).collect();
        let no_tree = |node: usize| SceneError::NoTree { node: names[node].clone() };
        let mut parents = vec![None; names.len()];
        for node in document.nodes() {
            for child in node.children() {
                if parents[child.index()].replace(node.index()).is_some() {
                    return Err(no_tree(child.index()));
                }
            }
        }
        let mut order: Vec<usize> =
            (0..parents.len()).filter(|&node| parents[node].is_none()).collect();
        let children: Vec<Vec<usize>> = document
            .nodes()
            .map(|node| node.children().map(|child| child.index()).collect())
            .collect();
        let mut next = 0;
        while let Some(&node) = order.get(next) {
            order.extend(&children[node]);
            next += 1;
        }
        // With one parent each, what hangs under no root is a cycle.
        if let Some(node) =
            (0..parents.len()).find(|node| order.len() < parents.len() && !order.contains(node))
        {
            return Err(no_tree(node));
        }
        let locals = document.nodes().map(|node| local(&node.transform())).collect();
        Ok(Self { names, parents, locals, order })
    }

    /// Gives the world transform of every node.
    pub(super) fn worlds(&self, locals: &[Local]) -> Vec<Matrix4<f64>> {
        let mut worlds = vec![Matrix4::identity(); locals.len()];
        for &node in &self.order {
            let local = locals[node].matrix();
            worlds[node] = self.parents[node].map_or(local, |parent| worlds[parent] * local);
        }
        worlds
    }

    /// Tells which nodes belong to the scene that the file shows; all of them where it names none.
    pub(super) fn shown(&self, document: &Document) -> Vec<bool> {
        let Some(scene) = document.default_scene().or_else(|| document.scenes().next()) else {
            return vec![true; self.names.len()];
        };
        let roots: Vec<usize> = scene.nodes().map(|node| node.index()).collect();
        (0..self.names.len()).map(|node| self.upwards(node).any(|up| roots.contains(&up))).collect()
    }

    /// Gives the nearest of some joints above each of them; several may have none.
    pub(super) fn parents_among(&self, joints: &[usize]) -> Vec<Option<usize>> {
        let of = |node: usize| joints.iter().position(|&joint| joint == node);
        joints.iter().map(|&node| self.upwards(node).skip(1).find_map(of)).collect()
    }

    /// Walks from a node to its root.
    pub(super) fn upwards(&self, node: usize) -> impl Iterator<Item = usize> + Clone + '_ {
        std::iter::successors(Some(node), |&node| self.parents[node])
    }
}

impl Local {
    /// Gives the transform as a matrix.
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
