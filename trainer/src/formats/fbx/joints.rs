//! The joints of a scene, and where they stand when the meshes are bound to them.

use nalgebra::{Matrix4, Vector4};
use ufbx::{Mesh, Node, Scene};

use super::convert::matrix;
use super::meshes::{MeshPart, skin};
use crate::formats::scene::{SceneError, told_apart};
use crate::formats::warning::FormatWarning;

/// How far apart the places may be where two meshes are bound to a joint, as a share of the size of
/// the mesh: single precision, and some arithmetic.
const BIND_SLACK: f64 = 1e-4;

/// The joints of a scene, in the order of the file.
pub(super) struct Joints {
    /// Their nodes, by place in the scene.
    pub(super) nodes: Vec<usize>,
    pub(super) names: Vec<String>,
    pub(super) parents: Vec<Option<usize>>,
    pub(super) binds: Vec<Matrix4<f64>>,
}

/// Finds the joints of the parts' skins and the bones above them, or all bones without a skin.
pub(super) fn find(
    scene: &Scene,
    parts: &[MeshPart],
    warnings: &mut Vec<FormatWarning>,
) -> Result<Joints, SceneError> {
    let mut binds = vec![None; scene.nodes.len()];
    for part in parts {
        bind(scene, part, &mut binds)?;
    }
    let skinned = binds.iter().any(Option::is_some);
    let mut is_joint: Vec<bool> = binds.iter().map(Option::is_some).collect();
    // Children come after their parents, so that one way back meets every ancestor of a joint.
    let mut under = is_joint.clone();
    for (place, node) in scene.nodes.iter().enumerate().rev() {
        is_joint[place] |= node.bone.is_some() && (under[place] || !skinned);
        if let (true, Some(parent)) = (under[place], &node.parent) {
            under[parent.element.typed_id as usize] = true;
        }
    }
    let mut nodes: Vec<usize> = (0..scene.nodes.len()).filter(|&place| is_joint[place]).collect();
    if nodes.is_empty() {
        return Err(SceneError::NoJoint);
    }
    // The scene has them by depth, other readers of the format in the order of the file.
    nodes.sort_by_key(|&place| scene.nodes[place].element.element_id);
    let (names, renamed) = names(scene, |place| is_joint[place]);
    if !renamed.is_empty() {
        let joints = renamed.into_iter().map(|place| names[place].clone()).collect();
        warnings.push(FormatWarning::EqualNames { joints });
    }
    Ok(Joints {
        names: nodes.iter().map(|&place| names[place].clone()).collect(),
        parents: parents_among(scene, &nodes),
        binds: nodes
            .iter()
            .map(|&place| binds[place].unwrap_or_else(|| at_rest(&scene.nodes[place])))
            .collect(),
        nodes,
    })
}

/// Gives the names of all nodes, those of joints told apart where they are equal, and lists the nodes of these.
pub(super) fn names(scene: &Scene, is_joint: impl Fn(usize) -> bool) -> (Vec<String>, Vec<usize>) {
    let names: Vec<String> = scene.nodes.iter().map(|node| node.element.name.to_string()).collect();
    let places = 0..scene.nodes.len();
    let parents: Vec<Option<usize>> = places.map(|place| above(scene, place)).collect();
    told_apart(&names, &parents, is_joint)
}

/// Gives the nearest of some nodes above each of them; several may have none.
pub(super) fn parents_among(scene: &Scene, nodes: &[usize]) -> Vec<Option<usize>> {
    let of = |place: usize| nodes.iter().position(|&node| node == place);
    nodes.iter().map(|&node| upwards(scene, node).skip(1).find_map(of)).collect()
}

/// Walks from a node to its root.
pub(super) fn upwards(scene: &Scene, place: usize) -> impl Iterator<Item = usize> + Clone + '_ {
    std::iter::successors(Some(place), |&place| above(scene, place))
}

fn above(scene: &Scene, place: usize) -> Option<usize> {
    scene.nodes[place].parent.as_ref().map(|parent| parent.element.typed_id as usize)
}

/// Notes where each joint of a part's skin stands when it is bound.
pub(super) fn bind(
    scene: &Scene,
    part: &MeshPart,
    binds: &mut [Option<Matrix4<f64>>],
) -> Result<(), SceneError> {
    let mesh = &scene.meshes[part.mesh];
    let name = || scene.nodes[part.node].element.name.to_string();
    let rest = matrix(&part.rest);
    let corners = corners(mesh).map(|corner| rest * corner);
    let size = (corners[7] - corners[0]).norm();
    for cluster in skin(mesh).into_iter().flat_map(|skin| &skin.clusters) {
        let Some(node) = &cluster.bone_node else { continue };
        let joint = || node.element.name.to_string();
        // Not the cluster's own place of the joint, which need not be that of the mesh's first: what
        // poses the mesh is the way from the mesh to the joint.
        let bind = matrix(&cluster.geometry_to_bone).try_inverse().map(|back| rest * back);
        let Some(bind) = bind.filter(|bind| bind.determinant() != 0.0) else {
            return Err(SceneError::SingularBind { joint: joint() });
        };
        let kept = binds[node.element.typed_id as usize].get_or_insert(bind);
        let distance = apart(kept, &bind, &corners);
        if distance.is_nan() || distance > BIND_SLACK * size {
            return Err(SceneError::OtherBind { joint: joint(), mesh: name() });
        }
    }
    Ok(())
}

/// Measures how far one bind carries some points from where another does.
fn apart(kept: &Matrix4<f64>, bind: &Matrix4<f64>, points: &[Vector4<f64>]) -> f64 {
    let Some(back) = bind.try_inverse() else { return f64::NAN };
    let moved = kept * back - Matrix4::identity();
    points.iter().map(|point| (moved * point).norm()).fold(0.0, f64::max)
}

/// The eight corners of a mesh's box, the lowest first and the highest last.
fn corners(mesh: &Mesh) -> [Vector4<f64>; 8] {
    let mut low = [f64::INFINITY; 3];
    let mut high = [f64::NEG_INFINITY; 3];
    for v in &mesh.vertices {
        for (axis, number) in [v.x, v.y, v.z].into_iter().enumerate() {
            low[axis] = low[axis].min(number);
            high[axis] = high[axis].max(number);
        }
    }
    std::array::from_fn(|corner| {
        let at = |axis: usize| if corner >> axis & 1 == 0 { low[axis] } else { high[axis] };
        Vector4::new(at(0), at(1), at(2), 1.0)
    })
}

/// Where a joint stands that no skin names: in the file's bind pose, or in the pose it is saved in.
pub(super) fn at_rest(node: &Node) -> Matrix4<f64> {
    let bind = node.bind_pose.as_ref().and_then(|pose| ufbx::get_bone_pose(pose, node));
    matrix(bind.map_or(&node.node_to_world, |pose| &pose.bone_to_world))
}
