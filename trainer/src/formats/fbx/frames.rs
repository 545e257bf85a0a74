//! The animations of a scene, and its joints and meshes frame by frame.

use nalgebra::Matrix4;
use rayon::prelude::*;
use ufbx::{AnimStack, EvaluateOpts, Scene, SceneRoot, SkinningMethod};

use super::blends::{WEIGHING, channels, is_shaped};
use super::convert::{fault, matrix};
use super::joints::parents_among;
use super::meshes::{MeshPart, skin};
use crate::formats::scene::{Clip, MovingJoints, Sample, Sampling, SceneError, samples};
use crate::formats::warning::FormatWarning;

/// The properties of a node that place it.
const PLACING: [&str; 3] = ["Lcl Translation", "Lcl Rotation", "Lcl Scaling"];

/// An animation, and when its frames are taken.
pub(super) struct Take {
    /// Its place in the scene.
    stack: usize,
    name: String,
    /// In the animation's own seconds.
    samples: Vec<Sample>,
}

/// Chooses the animations that move joints, and their frames.
pub(super) fn takes(
    scene: &SceneRoot,
    joints: &[usize],
    parts: &[MeshPart],
    sampling: &Sampling<'_>,
    warnings: &mut Vec<FormatWarning>,
) -> Result<Vec<Take>, SceneError> {
    let name = |stack: &AnimStack| stack.element.name.to_string();
    let named = |stack: &AnimStack| sampling.takes(&stack.element.name);
    sampling.check(scene.anim_stacks.iter().map(|stack| name(stack)).collect())?;
    let watched = Watched::new(scene, joints, parts);
    let parents = parents_among(scene, joints);
    let rate = scene.settings.frames_per_second;
    let frame = if rate > 0.0 { 1.0 / rate } else { 0.0 };
    let (mut takes, mut still) = (Vec::new(), Vec::new());
    for (place, stack) in scene.anim_stacks.iter().enumerate().filter(|(_, stack)| named(stack)) {
        let (keys, keyed) = watched.keys(stack);
        if !keyed.contains(&true) {
            still.push(name(stack));
            continue;
        }
        watched.check_constraints(scene, &keyed)?;
        let pose = |time: f64| {
            let animation = &scene.anim_stacks[place].anim;
            let posed = ufbx::evaluate_scene(scene, animation, time, EvaluateOpts::default());
            let posed = posed.map_err(fault)?;
            Ok(joints.iter().map(|&node| matrix(&posed.nodes[node].node_to_world)).collect())
        };
        let joints = MovingJoints { parents: &parents, frame, pose };
        let samples = samples(&stack.element.name, keys, sampling, &joints)?;
        takes.push(Take { stack: place, name: name(stack), samples });
    }
    if takes.is_empty() {
        watched.check_constraints(scene, &vec![false; scene.elements.len()])?;
        return Err(SceneError::NothingMoves { clips: still });
    }
    if !still.is_empty() {
        warnings.push(FormatWarning::IdleClips { clips: still });
    }
    Ok(takes)
}

/// What moves, frame by frame.
pub(super) struct Posed {
    /// World frame of each joint, N x J, frame-major.
    pub(super) joints: Vec<Matrix4<f64>>,
    /// Posed positions, N x V, frame-major, where they were asked for.
    pub(super) shapes: Option<Vec<[f64; 3]>>,
    /// Whether those are more than linear blend skinning: moved by blendshapes, or by dual
    /// quaternions.
    pub(super) morphs: bool,
}

/// Poses the joints at these nodes, and the vertices of parts, where there are any to pose; without a take, the joints
/// as the scene shows them.
pub(super) fn posed(
    scene: &SceneRoot,
    takes: &[Take],
    nodes: &[usize],
    parts: Option<&[MeshPart]>,
) -> Result<Posed, SceneError> {
    if takes.is_empty() {
        let joints = nodes.iter().map(|&node| matrix(&scene.nodes[node].node_to_world)).collect();
        return Ok(Posed { joints, shapes: None, morphs: false });
    }
    let moments =
        takes.iter().flat_map(|take| take.samples.iter().map(|sample| (take.stack, sample.at)));
    let pose = |&(stack, time): &(usize, f64)| {
        let animation = &scene.anim_stacks[stack].anim;
        let posed = ufbx::evaluate_scene(scene, animation, time, EvaluateOpts::default());
        let posed = posed.map_err(fault)?;
        let joints = nodes.iter().map(|&node| matrix(&posed.nodes[node].node_to_world));
        let (mut shape, mut morphs) = (Vec::new(), false);
        for part in parts.into_iter().flatten() {
            morphs |= deform(scene, &posed, part, &mut shape);
        }
        Ok((joints.collect::<Vec<_>>(), shape, morphs))
    };
    let moments: Vec<_> = moments.collect();
    let frames: Vec<Result<_, SceneError>> = moments.par_iter().map(pose).collect();
    let mut all = Posed { joints: Vec::new(), shapes: parts.map(|_| Vec::new()), morphs: false };
    for frame in frames {
        let (joints, shape, morphs) = frame?;
        all.joints.extend(joints);
        all.morphs |= morphs;
        if let Some(shapes) = &mut all.shapes {
            shapes.extend(shape);
        }
    }
    Ok(all)
}

/// Lists the clips that the frames come from.
pub(super) fn clips(takes: Vec<Take>) -> Vec<Clip> {
    if takes.is_empty() {
        return vec![Clip::still()];
    }
    let mut first = 0;
    let clip = |take: Take| {
        first += take.samples.len();
        let times: Vec<f64> = take.samples.iter().map(|sample| sample.time).collect();
        Clip::at(take.name, first - times.len(), &times)
    };
    takes.into_iter().map(clip).collect()
}

/// Adds the posed vertices of a part, and tells whether they are more than linear blend skinning.
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

/// Elements whose animation the examples need, by their numbers: keys of others do not count as frames.
struct Watched {
    /// Joints and all nodes above them.
    placed: Vec<bool>,
    /// Channels of blendshapes.
    weighed: Vec<bool>,
}

impl Watched {
    fn new(scene: &Scene, joints: &[usize], parts: &[MeshPart]) -> Self {
        let mut placed = vec![false; scene.elements.len()];
        for &joint in joints {
            let mut node = Some(&scene.nodes[joint]);
            while let Some(here) = node.filter(|node| !placed[node.element.element_id as usize]) {
                placed[here.element.element_id as usize] = true;
                node = here.parent.as_deref();
            }
        }
        let mut weighed = vec![false; scene.elements.len()];
        for part in parts {
            for channel in channels(&scene.meshes[part.mesh]) {
                weighed[channel.element.element_id as usize] = true;
            }
        }
        Self { placed, weighed }
    }

    /// Collects the times of all keys of an animation, and tells which elements they place.
    fn keys(&self, stack: &AnimStack) -> (Vec<f64>, Vec<bool>) {
        let mut placed = vec![false; self.placed.len()];
        let mut times = Vec::new();
        for property in stack.layers.into_iter().flat_map(|layer| &layer.anim_props) {
            let element = property.element.element_id as usize;
            let places = self.placed[element] && PLACING.contains(&&*property.prop_name);
            let weighs = self.weighed[element] && *property.prop_name == *WEIGHING;
            for curve in property.anim_value.curves.iter().flatten() {
                if places || weighs {
                    times.extend(curve.keyframes.iter().map(|key| key.time));
                    placed[element] |= places && !curve.keyframes.is_empty();
                }
            }
        }
        (times, placed)
    }

    /// Refuses a constraint on what places a joint and has no keys instead.
    fn check_constraints(&self, scene: &Scene, keyed: &[bool]) -> Result<(), SceneError> {
        for constraint in scene.constraints.into_iter().filter(|constraint| constraint.active) {
            let Some(node) = &constraint.node else { continue };
            let element = node.element.element_id as usize;
            if self.placed[element] && !keyed[element] {
                let joint = node.element.name.to_string();
                let constraint = constraint.element.name.to_string();
                return Err(SceneError::Constrained { joint, constraint });
            }
        }
        Ok(())
    }
}
