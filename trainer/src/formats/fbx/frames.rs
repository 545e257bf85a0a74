//! Joints of a scene, their bind frames, and the animation of joints and meshes frame by frame.

use super::curves::{NamedChannel, named_channels, tracks, weights};
use super::file::{fault, matrix};
use super::meshes::{MeshPart, WEIGHT, channels, is_shaped, skin};
use crate::Error;
use crate::formats::FormatWarning;
use crate::formats::scene::{
    Clip, CurveTrack, Hierarchy, MovingJoints, Sample, Sampling, faults, samples,
};
use nalgebra::{Matrix4, Vector4};
use rayon::prelude::*;
use ufbx::{AnimStack, EvaluateOpts, Mesh, Node, Scene, SceneRoot, SkinningMethod};

/// Properties of a node that place the node.
const PLACEMENT: [&str; 3] = ["Lcl Translation", "Lcl Rotation", "Lcl Scaling"];

/// Largest distance between the places at which two meshes bind a joint, as a share of the mesh's size. The room is for
/// single precision and some arithmetic.
const BIND_SLACK: f64 = 1e-4;

/// An animation and its sample times.
pub(super) struct Take {
    /// Index of the animation in the scene.
    stack: usize,
    name: String,
    /// Sample times, in seconds of the animation.
    samples: Vec<Sample>,
}

/// Chooses the animations that move joints, and their sample times.
pub(super) fn takes(
    scene: &SceneRoot,
    joints: &[usize],
    parts: &[MeshPart],
    sampling: &Sampling<'_>,
    warnings: &mut Vec<FormatWarning>,
) -> Result<Vec<Take>, Error> {
    let name = |stack: &AnimStack| stack.element.name.to_string();
    let named = |stack: &AnimStack| sampling.takes(&stack.element.name);
    sampling.check(scene.anim_stacks.iter().map(|stack| name(stack)).collect())?;
    let shapes = named_channels(scene, sampling);
    let tracked = Tracked::new(scene, joints, parts, &shapes);
    let parents = hierarchy(scene).parents_among(joints);
    let rate = scene.settings.frames_per_second;
    let frame = if rate > 0.0 { 1.0 / rate } else { 0.0 };
    let (mut takes, mut still) = (Vec::new(), Vec::new());
    for (place, stack) in scene.anim_stacks.iter().enumerate().filter(|(_, stack)| named(stack)) {
        let (keys, keyed) = tracked.keys(stack);
        // A clip of curves alone counts if curves are read.
        if !keyed.contains(&true) && (shapes.is_empty() || keys.is_empty()) {
            still.push(name(stack));
            continue;
        }
        tracked.check_constraints(scene, &keyed)?;
        let pose =
            |time: f64| evaluated(scene, place, time).map(|posed| joint_frames(&posed, joints));
        let joints = MovingJoints { parents: &parents, frame, pose };
        let samples = samples(&stack.element.name, keys, sampling, &joints)?;
        takes.push(Take { stack: place, name: name(stack), samples });
    }
    if takes.is_empty() {
        tracked.check_constraints(scene, &vec![false; scene.elements.len()])?;
        return Err(faults::nothing_moves(&still));
    }
    warnings.extend(FormatWarning::listed(FormatWarning::IdleClips, still));
    Ok(takes)
}

/// Poses a scene at a time, in seconds, of the animation with index `stack`.
fn evaluated(scene: &SceneRoot, stack: usize, time: f64) -> Result<SceneRoot, Error> {
    let animation = &scene.anim_stacks[stack].anim;
    ufbx::evaluate_scene(scene, animation, time, EvaluateOpts::default()).map_err(fault)
}

/// Returns the world frames of joints, given by their nodes.
fn joint_frames(posed: &Scene, nodes: &[usize]) -> Vec<Matrix4<f64>> {
    nodes.iter().map(|&node| matrix(&posed.nodes[node].node_to_world)).collect()
}

/// Sampled motion.
pub(super) struct Posed {
    /// World frame of each joint, N x J, frame-major.
    pub(super) joints: Vec<Matrix4<f64>>,
    /// Posed positions, N x V, frame-major, if they were requested.
    pub(super) shapes: Option<Vec<[f64; 3]>>,
    /// Whether `shapes` are more than linear blend skinning: moved by blendshapes, or by dual quaternions.
    pub(super) morphs: bool,
    /// Weights of the channels that were asked for.
    pub(super) curves: Vec<CurveTrack>,
}

/// Poses joints, given by their nodes, and the vertices of `parts`, and reads the weights of channels. Without a take,
/// returns the joints and weights as the scene shows them.
pub(super) fn posed(
    scene: &SceneRoot,
    takes: &[Take],
    nodes: &[usize],
    parts: Option<&[MeshPart]>,
    named: &[NamedChannel],
) -> Result<Posed, Error> {
    if takes.is_empty() {
        let joints = joint_frames(scene, nodes);
        let curves = tracks(named, &[weights(scene, named)]);
        return Ok(Posed { joints, shapes: None, morphs: false, curves });
    }
    let moments =
        takes.iter().flat_map(|take| take.samples.iter().map(|sample| (take.stack, sample.at)));
    let pose = |&(stack, time): &(usize, f64)| {
        let posed = evaluated(scene, stack, time)?;
        let (mut shape, mut morphs) = (Vec::new(), false);
        for part in parts.into_iter().flatten() {
            morphs |= deform(scene, &posed, part, &mut shape);
        }
        Ok((joint_frames(&posed, nodes), shape, morphs, weights(&posed, named)))
    };
    let moments: Vec<_> = moments.collect();
    let frames: Vec<Result<_, Error>> = moments.par_iter().map(pose).collect();
    let shapes = parts.map(|_| Vec::new());
    let mut all = Posed { joints: Vec::new(), shapes, morphs: false, curves: Vec::new() };
    let mut weights = Vec::with_capacity(frames.len());
    for frame in frames {
        let (joints, shape, morphs, own) = frame?;
        weights.push(own);
        all.joints.extend(joints);
        all.morphs |= morphs;
        if let Some(shapes) = &mut all.shapes {
            shapes.extend(shape);
        }
    }
    all.curves = tracks(named, &weights);
    Ok(all)
}

/// Lists the clips of the frames.
pub(super) fn clips(takes: Vec<Take>) -> Vec<Clip> {
    if takes.is_empty() {
        return vec![Clip::still()];
    }
    let mut end = 0;
    let clip = |take: Take| {
        let first = end;
        end += take.samples.len();
        Clip::sampled(take.name, first, &take.samples)
    };
    takes.into_iter().map(clip).collect()
}

/// The joints of a scene, in the order of the file.
pub(super) struct Joints {
    /// Indices of their nodes in the scene.
    pub(super) nodes: Vec<usize>,
    pub(super) names: Vec<String>,
    pub(super) parents: Vec<Option<usize>>,
    pub(super) binds: Vec<Matrix4<f64>>,
}

/// Finds the joints of the parts' skins and the bones above them; without a skin, all bones.
pub(super) fn find_joints(
    scene: &Scene,
    parts: &[MeshPart],
    warnings: &mut Vec<FormatWarning>,
) -> Result<Joints, Error> {
    let mut binds = vec![None; scene.nodes.len()];
    for part in parts {
        bind(scene, part, &mut binds)?;
    }
    let skinned = binds.iter().any(Option::is_some);
    let mut is_joint: Vec<bool> = binds.iter().map(Option::is_some).collect();
    // Children come after their parents, so one pass backwards finds every ancestor of a joint.
    let mut under = is_joint.clone();
    for (place, node) in scene.nodes.iter().enumerate().rev() {
        is_joint[place] |= node.bone.is_some() && (under[place] || !skinned);
        if let (true, Some(parent)) = (under[place], &node.parent) {
            under[parent.element.typed_id as usize] = true;
        }
    }
    let mut nodes: Vec<usize> = (0..scene.nodes.len()).filter(|&place| is_joint[place]).collect();
    if nodes.is_empty() {
        return Err(Error::missing(
            "has no joint: no skin names one and no node is a bone; export the skeleton with the mesh, \
             and in Blender its armature too",
        ));
    }
    // ufbx sorts nodes by depth. Other readers of the format use the order of the file.
    nodes.sort_by_key(|&place| scene.nodes[place].element.element_id);
    let tree = hierarchy(scene);
    let (names, renamed) = tree.unique_names(|place| is_joint[place]);
    warnings.extend(renamed);
    Ok(Joints {
        names: nodes.iter().map(|&place| names[place].clone()).collect(),
        parents: tree.parents_among(&nodes),
        binds: nodes
            .iter()
            .map(|&place| binds[place].unwrap_or_else(|| at_rest(&scene.nodes[place])))
            .collect(),
        nodes,
    })
}

/// Returns the names and parents of all nodes.
pub(super) fn hierarchy(scene: &Scene) -> Hierarchy {
    let parent = |node: &Node| Some(node.parent.as_ref()?.element.typed_id as usize);
    Hierarchy {
        names: scene.nodes.iter().map(|node| node.element.name.to_string()).collect(),
        parents: scene.nodes.iter().map(|node| parent(node)).collect(),
    }
}

/// Records the bind frame of each joint of a part's skin, and checks that all parts agree.
pub(super) fn bind(
    scene: &Scene,
    part: &MeshPart,
    binds: &mut [Option<Matrix4<f64>>],
) -> Result<(), Error> {
    let mesh = &scene.meshes[part.mesh];
    let name = &scene.nodes[part.node].element.name;
    let rest = matrix(&part.rest);
    let corners = box_corners(mesh).map(|corner| rest * corner);
    let size = (corners[7] - corners[0]).norm();
    for cluster in skin(mesh).into_iter().flat_map(|skin| &skin.clusters) {
        let Some(node) = &cluster.bone_node else { continue };
        let joint = &node.element.name;
        // Not the cluster's own bind frame, which may differ from that of the mesh's first cluster. The transform from
        // the mesh to the joint poses the mesh.
        let bind = matrix(&cluster.geometry_to_bone).try_inverse().map(|back| rest * back);
        let Some(bind) = bind.filter(|bind| bind.determinant() != 0.0) else {
            return Err(faults::singular_bind(joint));
        };
        let kept = binds[node.element.typed_id as usize].get_or_insert(bind);
        let distance = bind_distance(kept, &bind, &corners);
        if distance.is_nan() || distance > BIND_SLACK * size {
            return Err(faults::other_bind(name, joint));
        }
    }
    Ok(())
}

/// Returns the rest frame of a joint without a skin: from the file's bind pose, or else from the pose saved in the
/// file.
pub(super) fn at_rest(node: &Node) -> Matrix4<f64> {
    let bind = node.bind_pose.as_ref().and_then(|pose| ufbx::get_bone_pose(pose, node));
    matrix(bind.map_or(&node.node_to_world, |pose| &pose.bone_to_world))
}

/// Appends the posed vertices of a part; returns whether they are more than linear blend skinning.
fn deform(scene: &Scene, posed: &Scene, part: &MeshPart, positions: &mut Vec<[f64; 3]>) -> bool {
    let mesh = &posed.meshes[part.mesh];
    let Some(skin) = skin(mesh) else { return false };
    let mut shape = mesh.vertices.to_vec();
    for blend in &mesh.blend_deformers {
        ufbx::add_blend_vertex_offsets(blend, &mut shape, 1.0);
    }
    // A vertex without weights follows its node.
    let unweighted = &posed.nodes[part.node].geometry_to_world;
    positions.extend(shape.into_iter().enumerate().map(|(vertex, v)| {
        let map = ufbx::get_skin_vertex_matrix(skin, vertex, unweighted);
        let v = ufbx::transform_position(&map, v);
        [v.x, v.y, v.z]
    }));
    let linear = [SkinningMethod::Linear, SkinningMethod::Rigid].contains(&skin.skinning_method);
    !linear || is_shaped(scene, mesh)
}

/// The elements whose animation matters; keys of other elements do not count as frames. Indexed by element.
struct Tracked {
    /// Joints, and all nodes above them.
    placed: Vec<bool>,
    /// Channels of blendshapes.
    weighted: Vec<bool>,
}

impl Tracked {
    fn new(scene: &Scene, joints: &[usize], parts: &[MeshPart], shapes: &[NamedChannel]) -> Self {
        let mut placed = vec![false; scene.elements.len()];
        for &joint in joints {
            let mut node = Some(&scene.nodes[joint]);
            while let Some(here) = node.filter(|node| !placed[node.element.element_id as usize]) {
                placed[here.element.element_id as usize] = true;
                node = here.parent.as_deref();
            }
        }
        let mut weighted = vec![false; scene.elements.len()];
        for part in parts {
            for channel in channels(&scene.meshes[part.mesh]) {
                weighted[channel.element.element_id as usize] = true;
            }
        }
        for shape in shapes {
            weighted[scene.blend_channels[shape.channel].element.element_id as usize] = true;
        }
        Self { placed, weighted }
    }

    /// Collects the times of all keys of an animation; also returns which elements have keys that place them.
    fn keys(&self, stack: &AnimStack) -> (Vec<f64>, Vec<bool>) {
        let mut placed = vec![false; self.placed.len()];
        let mut times = Vec::new();
        for property in stack.layers.into_iter().flat_map(|layer| &layer.anim_props) {
            let element = property.element.element_id as usize;
            let places = self.placed[element] && PLACEMENT.contains(&&*property.prop_name);
            let weighs = self.weighted[element] && *property.prop_name == *WEIGHT;
            for curve in property.anim_value.curves.iter().flatten() {
                if places || weighs {
                    times.extend(curve.keyframes.iter().map(|key| key.time));
                    placed[element] |= places && !curve.keyframes.is_empty();
                }
            }
        }
        (times, placed)
    }

    /// Refuses a constraint on a node that places a joint and has no keys.
    fn check_constraints(&self, scene: &Scene, keyed: &[bool]) -> Result<(), Error> {
        for constraint in scene.constraints.into_iter().filter(|constraint| constraint.active) {
            let Some(node) = &constraint.node else { continue };
            let element = node.element.element_id as usize;
            if self.placed[element] && !keyed[element] {
                let (joint, constraint) = (&node.element.name, &constraint.element.name);
                return Err(Error::unsupported(format!(
                    "joint {joint} has no keys but a constraint, {constraint}, which is not evaluated; bake the \
                     animation of the joints to keys at every frame"
                )));
            }
        }
        Ok(())
    }
}

/// Returns the largest distance between the points as two binds place them.
fn bind_distance(kept: &Matrix4<f64>, bind: &Matrix4<f64>, points: &[Vector4<f64>]) -> f64 {
    let Some(back) = bind.try_inverse() else { return f64::NAN };
    let moved = kept * back - Matrix4::identity();
    points.iter().map(|point| (moved * point).norm()).fold(0.0, f64::max)
}

/// Returns the eight corners of a mesh's box, the lowest first and the highest last.
fn box_corners(mesh: &Mesh) -> [Vector4<f64>; 8] {
    let of = |from: f64, choose: fn(f64, f64) -> f64| {
        let all = mesh.vertices.iter().map(|v| [v.x, v.y, v.z]);
        all.fold([from; 3], |best, v| std::array::from_fn(|axis| choose(best[axis], v[axis])))
    };
    let [low, high] = [of(f64::INFINITY, f64::min), of(f64::NEG_INFINITY, f64::max)];
    std::array::from_fn(|corner| {
        let at = |axis: usize| if corner >> axis & 1 == 0 { low[axis] } else { high[axis] };
        Vector4::new(at(0), at(1), at(2), 1.0)
    })
}
