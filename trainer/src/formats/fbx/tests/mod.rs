//! Tests of FBX scenes that a test writes and reads back.

use super::*;
use crate::formats::FormatWarning;
use crate::formats::testing::{Folder, spoil};
use nalgebra::Matrix4;
use sinew_runtime::format::{Axis, Handedness, Space};

mod curves;
mod faults;
mod scene;
mod surface;

use scene::{Scene, translation};

/// All clips, at their own keys.
const KEYS: Sampling<'_> =
    Sampling { fps: None, clips: &[], shapes: true, still: false, played: false, curves: false };

/// A quad and a triangle along x.
const ARM: [[f64; 3]; 5] =
    [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
const FACES: [i32; 7] = [0, 1, 3, -5, 1, 2, -4];

/// A scene of an arm, with the numbers of its objects.
struct Arm {
    scene: Scene,
    root: u32,
    tip: u32,
    mesh: u32,
    layer: u32,
}

impl Arm {
    /// An arm of two joints. The tip, at 1 0 0, makes a quarter turn about z from one frame to the next, while the root
    /// moves by 3 along x. The mesh has no skin and does not move.
    fn bare() -> Self {
        let mut scene = Scene::default();
        let root = scene.node("root", "LimbNode", 0, &[]);
        let tip = scene.node("tip", "LimbNode", root, &[("Lcl Translation", [1.0, 0.0, 0.0])]);
        let node = scene.node("body", "Mesh", 0, &[]);
        let mesh = scene.mesh(node, &ARM, &FACES, "");
        let layer = scene.animation("bend");
        scene.keys(layer, tip, "Lcl Rotation", "d|Z", &[(1, 0.0), (2, 90.0)]);
        scene.keys(layer, root, "Lcl Translation", "d|X", &[(1, 0.0), (2, 3.0)]);
        Self { scene, root, tip, mesh, layer }
    }

    /// The arm with a skin, in which vertex 2 follows both joints and vertex 3 the tip.
    fn skinned(method: &str) -> Self {
        let mut arm = Self::bare();
        arm.bind(arm.mesh, method);
        arm
    }

    fn bind(&mut self, mesh: u32, method: &str) {
        let skin = self.scene.skin(mesh, method);
        let weights = [(0, 1.0), (1, 1.0), (2, 0.5), (4, 1.0)];
        let (here, there) = (translation(0.0, 0.0, 0.0), translation(1.0, 0.0, 0.0));
        self.scene.cluster(skin, self.root, &weights, here, here);
        let back = translation(-1.0, 0.0, 0.0);
        self.scene.cluster(skin, self.tip, &[(2, 0.5), (3, 1.0)], back, there);
    }

    fn rig(&self) -> SampledScene {
        self.sampled(&KEYS).unwrap_or_else(|error| panic!("{error}"))
    }

    fn sampled(&self, sampling: &Sampling<'_>) -> Result<SampledScene, Error> {
        parse(self.scene.text().as_bytes(), sampling)
    }

    fn fault(&self) -> Error {
        self.sampled(&KEYS).err().expect("the scene should be refused")
    }
}

#[track_caller]
fn near(found: &[[f64; 3]], expected: &[[f64; 3]]) {
    assert_eq!(found.len(), expected.len());
    for (found, expected) in found.iter().zip(expected) {
        let apart = (0..3).map(|axis| (found[axis] - expected[axis]).abs()).fold(0.0, f64::max);
        assert!(apart < 1e-9, "{found:?}, expected {expected:?}");
    }
}

fn shapes(rig: &SampledScene) -> Vec<&[[f64; 3]]> {
    rig.shapes.as_ref().unwrap().chunks(rig.rest.len()).collect()
}

#[test]
fn a_skinned_mesh_is_read_with_its_joints_and_frames() {
    let rig = Arm::skinned("Linear").rig();
    assert_eq!(rig.names, ["root", "tip"]);
    assert_eq!(rig.parents, [None, Some(0)]);
    near(&rig.rest, &ARM);
    assert_eq!(rig.triangles, [[0, 1, 3], [0, 3, 4], [1, 2, 3]]);
    assert_eq!((&rig.engine, rig.morphs, &rig.warnings[..]), (&None, false, &[][..]));
    let origin = |frame: &Matrix4<f64>| [frame.m14, frame.m24, frame.m34];
    let origins = |frames: &[Matrix4<f64>]| frames.iter().map(origin).collect::<Vec<_>>();
    near(&origins(&rig.binds), &[[0.0; 3], [1.0, 0.0, 0.0]]);
    near(&origins(&rig.frames), &[[0.0; 3], [1.0, 0.0, 0.0], [3.0, 0.0, 0.0], [4.0, 0.0, 0.0]]);
    // The quarter turn maps x to y.
    let weights = [[1.0, 0.0], [1.0, 0.0], [0.5, 0.5], [0.0, 1.0], [1.0, 0.0]];
    assert_eq!(rig.joint_weights.as_deref(), Some(weights.as_flattened()));
    near(&[[rig.frames[3].m11, rig.frames[3].m21, rig.frames[3].m31]], &[[0.0, 1.0, 0.0]]);
    near(shapes(&rig)[0], &ARM);
    let bent =
        [[3.0, 0.0, 0.0], [4.0, 0.0, 0.0], [4.5, 0.5, 0.0], [3.0, 1.0, 0.0], [3.0, 1.0, 0.0]];
    near(shapes(&rig)[1], &bent);
    let [clip] = &rig.clips[..] else { panic!("{:?}", rig.clips) };
    assert_eq!((clip.name.as_str(), clip.first, clip.times.len()), ("bend", 0, 2));
    // Times of the file, whose first frame is 1.
    let frames: Vec<f64> = clip.times.iter().map(|time| 24.0 * time).collect();
    assert!((frames[0] - 1.0).abs() < 1e-9 && (frames[1] - 2.0).abs() < 1e-9, "{frames:?}");
}

#[test]
fn dual_quaternions_turn_where_linear_blending_shrinks() {
    let rig = Arm::skinned("DualQuaternion").rig();
    assert!(rig.morphs, "these are not plain LBS");
    let half = std::f64::consts::FRAC_1_SQRT_2;
    // Half of both motions is a screw: half the turn about the fixed point of the whole motion. The tip maps p to (1,
    // 0) + R (p - (1, 0)) + (3, 0), and the root maps p to p + (3, 0). Between them lies a turn about the tip's origin;
    // half of that turn is an eighth of a full turn.
    let expected = [4.0 + half, half, 0.0];
    near(&[shapes(&rig)[1][2]], &[expected]);
    near(&shapes(&rig)[1][3..4], &[[3.0, 1.0, 0.0]]);
}

#[test]
fn blendshapes_move_before_the_skin_through_the_shapes_between() {
    let mut arm = Arm::skinned("Linear");
    let between = [(50.0, 3, [0.0, 0.0, 2.0]), (100.0, 3, [0.0, 1.0, 1.0])];
    let channel = arm.scene.channel(arm.mesh, "", &between);
    assert!(!arm.rig().morphs, "a channel at rest moves nothing");
    arm.scene.keys(arm.layer, channel, "DeformPercent", "d|DeformPercent", &[(1, 25.0), (2, 75.0)]);
    let rig = arm.rig();
    assert!(rig.morphs);
    near(&rig.rest, &ARM);
    // At a quarter: half of the first shape. At three quarters: half of each shape.
    near(&[shapes(&rig)[0][3]], &[[2.0, 1.0, 1.0]]);
    near(&[shapes(&rig)[1][3]], &[[4.0 - 1.5, 1.0, 1.5]]);
}

/// An animated channel is off at rest: its stored weight is that of the frame in which the file was saved.
#[test]
fn a_channel_without_keys_belongs_to_the_rest_mesh() {
    let mut arm = Arm::skinned("Linear");
    let fat = arm.scene.channel(arm.mesh, "fat", &[(100.0, 3, [0.0, 0.0, 2.0])]);
    let smile = arm.scene.channel(arm.mesh, "smile", &[(100.0, 1, [0.0, 1.0, 0.0])]);
    for channel in [fat, smile] {
        arm.scene.weigh(channel, 50.0);
    }
    let keys = [(1, 25.0), (2, 75.0)];
    arm.scene.keys(arm.layer, smile, "DeformPercent", "d|DeformPercent", &keys);
    let rig = arm.rig();
    assert!(rig.morphs);
    let mut rest = ARM;
    rest[3][2] += 1.0;
    near(&rig.rest, &rest);
    near(&[shapes(&rig)[0][1], shapes(&rig)[0][3]], &[[1.0, 0.25, 0.0], rest[3]]);
    near(&[shapes(&rig)[1][3]], &[[3.0, 1.0, 1.0]]);

    // Alone, the constant channel is no moving shape.
    let mut arm = Arm::skinned("Linear");
    let fat = arm.scene.channel(arm.mesh, "fat", &[(100.0, 3, [0.0, 0.0, 2.0])]);
    arm.scene.weigh(fat, 50.0);
    let rig = arm.rig();
    assert!(!rig.morphs);
    near(&rig.rest, &rest);
    near(&shapes(&rig)[0][3..4], &rest[3..4]);
}

#[test]
fn keys_that_hold_jump_where_they_are_played() {
    let mut arm = Arm::skinned("Linear");
    arm.scene.hold_keys();
    let played = Sampling { played: true, shapes: false, ..KEYS };
    let rig = arm.sampled(&played).unwrap_or_else(|error| panic!("{error}"));
    let times: Vec<f32> = rig.clips[0].times.iter().map(|time| *time as f32).collect();
    let end = (2.0_f64 / 24.0) as f32;
    assert_eq!(times, [(1.0_f64 / 24.0) as f32, end.next_down(), end]);
    let roots = [0, 2, 4].map(|place| rig.frames[place].m14.round());
    assert_eq!(roots, [0.0, 0.0, 3.0]);
    // Keys are linear by default, and a quarter turn about one axis needs no more samples.
    let rig = Arm::skinned("Linear").sampled(&played).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(rig.clips[0].times.len(), 2);
}

#[test]
fn joints_of_equal_names_get_different_names() {
    let mut arm = Arm::skinned("Linear");
    let [left, right] =
        ["left", "right"].map(|name| arm.scene.node(name, "LimbNode", arm.root, &[]));
    let hands = [left, right].map(|parent| arm.scene.node("hand", "LimbNode", parent, &[]));
    let node = arm.scene.node("gloves", "Mesh", 0, &[]);
    let gloves = arm.scene.mesh(node, &ARM, &FACES, "");
    let skin = arm.scene.skin(gloves, "Linear");
    let here = translation(0.0, 0.0, 0.0);
    let all = [0, 1, 2, 3, 4].map(|vertex| (vertex, 0.5));
    hands.iter().for_each(|&hand| arm.scene.cluster(skin, hand, &all, here, here));
    let rig = arm.rig();
    let mut names = rig.names.clone();
    names.sort();
    assert_eq!(names, ["left", "left/hand", "right", "right/hand", "root", "tip"]);
    let joints = vec!["left/hand".to_owned(), "right/hand".to_owned()];
    assert_eq!(rig.warnings, [FormatWarning::EqualNames(joints)]);
}

#[test]
fn the_bind_pose_places_a_mesh_whatever_its_node_does() {
    let mut arm = Arm::bare();
    let placed = [
        ("GeometricTranslation", [0.0, 2.0, 0.0]),
        // Differs from the bind pose, 5 along z.
        ("Lcl Translation", [9.0, 9.0, 9.0]),
    ];
    let node = arm.scene.node("bound", "Mesh", 0, &placed);
    let mesh = arm.scene.mesh(node, &ARM, &FACES, "");
    let skin = arm.scene.skin(mesh, "Linear");
    let all = [0, 1, 2, 3, 4].map(|vertex| (vertex, 1.0));
    arm.scene.cluster(skin, arm.root, &all, translation(0.0, 0.0, 5.0), translation(0.0, 0.0, 0.0));
    let rig = arm.rig();
    near(&rig.rest, &ARM.map(|[x, y, z]| [x, y + 2.0, z + 5.0]));
    near(shapes(&rig)[1], &ARM.map(|[x, y, z]| [x + 3.0, y + 2.0, z + 5.0]));
    let meshes = vec!["body".to_owned()];
    assert_eq!(rig.warnings, [FormatWarning::UnskinnedMeshes(meshes)]);
    assert_eq!(rig.names, ["root"], "the tip is neither bound nor above what is");
}

#[test]
fn bones_above_bound_joints_are_joints_and_other_nodes_move_them() {
    let mut scene = Scene::default();
    let group = scene.node("group", "Null", 0, &[("Lcl Translation", [0.0, 0.0, 1.0])]);
    let hip = scene.node("hip", "LimbNode", group, &[]);
    let null = scene.node("offset", "Null", hip, &[("Lcl Translation", [0.0, 1.0, 0.0])]);
    let leg = scene.node("leg", "LimbNode", null, &[]);
    scene.node("beside", "LimbNode", hip, &[]);
    let node = scene.node("body", "Mesh", 0, &[]);
    let mesh = scene.mesh(node, &ARM, &FACES, "");
    let skin = scene.skin(mesh, "Linear");
    let bound = (translation(0.0, -1.0, -1.0), translation(0.0, 1.0, 1.0));
    scene.cluster(skin, leg, &[0, 1, 2, 3].map(|vertex| (vertex, 1.0)), bound.0, bound.1);
    let layer = scene.animation("lift");
    scene.keys(layer, group, "Lcl Translation", "d|Z", &[(0, 1.0), (1, 3.0)]);
    scene.keys(layer, node, "Lcl Translation", "d|X", &[(0, 0.0), (1, 7.0), (5, 0.0)]);
    let rig = parse(scene.text().as_bytes(), &KEYS).unwrap();
    assert_eq!(
        (&rig.names[..], &rig.parents[..]),
        (&["hip".into(), "leg".into()][..], &[None, Some(0)][..])
    );
    assert_eq!([rig.binds[0].m34, rig.binds[1].m34, rig.binds[1].m24], [1.0, 1.0, 1.0]);
    assert_eq!(rig.clips[0].times.len(), 2, "keys of the mesh's own node do not count");
    near(&shapes(&rig)[1][..1], &[[0.0, 0.0, 2.0]]);
    near(&shapes(&rig)[1][4..], &[[7.0, 1.0, 0.0]]);
}

#[test]
fn a_bone_that_no_skin_names_is_bound_where_the_file_s_bind_pose_has_it() {
    let bound = |pose: bool| {
        let mut arm = Arm::bare();
        let skin = arm.scene.skin(arm.mesh, "Linear");
        let back = translation(-1.0, 0.0, 0.0);
        arm.scene.cluster(skin, arm.tip, &[(2, 1.0)], back, translation(1.0, 0.0, 0.0));
        if pose {
            arm.scene.bind_pose(arm.root, translation(0.25, 0.0, 0.0));
        }
        arm.rig().binds[0].m14
    };
    assert_eq!([bound(false), bound(true)], [0.0, 0.25]);
}

#[test]
fn meshes_are_joined_in_the_order_of_their_nodes() {
    let mut arm = Arm::skinned("Linear");
    let other = arm.scene.node("sleeve", "Mesh", 0, &[]);
    let mesh = arm.scene.mesh(other, &ARM, &FACES, "");
    arm.bind(mesh, "Linear");
    let rig = arm.rig();
    near(&rig.rest, &[ARM, ARM].concat());
    assert_eq!(rig.triangles[3..], [[5, 6, 8], [5, 8, 9], [6, 7, 8]]);
    assert_eq!(rig.ranges, [("body".to_owned(), 0..5), ("sleeve".to_owned(), 5..10)]);
    for shape in shapes(&rig) {
        assert_eq!(shape[..5], shape[5..]);
    }
}

/// Axes and unit as a file numbers them: right, up and front, with their signs.
#[test]
fn axes_and_unit_are_those_that_the_file_says() {
    let space = |axes: [(u8, i8); 3], centimetres: f64| {
        let [right, up, front] = axes;
        let property = |name: &str, (axis, sign): (u8, i8)| {
            format!(
                "P: \"{name}Axis\", \"int\", \"Integer\", \"\",{axis}\n\
                 P: \"{name}AxisSign\", \"int\", \"Integer\", \"\",{sign}\n"
            )
        };
        let settings = format!(
            "GlobalSettings: {{\nProperties70: {{\n{}{}{}\
             P: \"UnitScaleFactor\", \"double\", \"Number\", \"\",{centimetres}\n}}\n}}\nObjects: {{",
            property("Coord", right),
            property("Up", up),
            property("Front", front)
        );
        let text = Arm::skinned("Linear").scene.text().replacen("Objects: {", &settings, 1);
        parse(text.as_bytes(), &KEYS).unwrap_or_else(|error| panic!("{error}")).space
    };
    let expected = |up, forward, handedness, unit| Space {
        up: Some(up),
        forward: Some(forward),
        handedness,
        unit: Some(unit),
    };
    // Maya's axes, the axes of 3ds Max in inches, and left-handed axes.
    assert_eq!(
        space([(0, 1), (1, 1), (2, 1)], 1.0),
        expected(Axis::Y, Axis::Z, Handedness::Right, 0.01)
    );
    assert_eq!(
        space([(0, 1), (2, 1), (1, -1)], 2.54),
        expected(Axis::Z, Axis::MinusY, Handedness::Right, 0.0254)
    );
    assert_eq!(
        space([(0, -1), (1, 1), (2, 1)], 100.0),
        expected(Axis::Y, Axis::Z, Handedness::Left, 1.0)
    );
    // A file without settings does not state its axes.
    let unsaid = Arm::skinned("Linear").rig().space;
    assert_eq!((unsaid.up, unsaid.forward, unsaid.handedness), (None, None, Handedness::Right));
}

#[test]
fn without_a_skin_bones_and_a_mesh_in_its_place_are_enough() {
    let mut arm = Arm::bare();
    // Mirrored along x, so that the faces wind the other way in the world.
    let mirror = [("Lcl Scaling", [-1.0, 1.0, 1.0]), ("Lcl Translation", [0.0, 0.0, 4.0])];
    let node = arm.scene.node("mirrored", "Mesh", 0, &mirror);
    arm.scene.mesh(node, &ARM, &FACES, "");
    let rig = arm.rig();
    assert!(rig.shapes.is_none() && !rig.morphs);
    assert_eq!(rig.names, ["root", "tip"]);
    near(&rig.rest[..5], &ARM);
    near(&rig.rest[5..], &ARM.map(|[x, y, z]| [-x, y, z + 4.0]));
    assert_eq!(rig.triangles[3..], [[5, 8, 6], [5, 9, 8], [6, 8, 7]]);
    assert_eq!(rig.binds[1].m14, 1.0);
    assert_eq!(rig.warnings, []);
}

#[test]
fn animations_are_clips_and_empty_ones_are_skipped() {
    let mut arm = Arm::skinned("Linear");
    arm.scene.animation("Take 001");
    let layer = arm.scene.animation("walk");
    arm.scene.keys(layer, arm.root, "Lcl Translation", "d|Y", &[(10, 0.0), (11, 1.0), (12, 4.0)]);
    let rig = arm.rig();
    let clips: Vec<_> = rig.clips.iter().map(|clip| (&*clip.name, clip.first)).collect();
    assert_eq!(clips, [("bend", 0), ("walk", 2)]);
    assert_eq!(rig.frames.len(), 2 * 5);
    assert_eq!([4, 6, 8].map(|frame| rig.frames[frame].m24.round()), [0.0, 1.0, 4.0]);
    let walk = arm
        .sampled(&Sampling {
            fps: Some(48.0),
            clips: &["walk".to_owned()],
            shapes: true,
            still: false,
            played: false,
            curves: false,
        })
        .unwrap();
    let times: Vec<f64> = walk.clips[0].times.iter().map(|time| (time * 48.0).round()).collect();
    assert_eq!(times, [20.0, 21.0, 22.0, 23.0, 24.0]);
    near(&[[walk.frames[6].m24, 0.0, 0.0]], &[[2.5, 0.0, 0.0]]);
}

#[test]
fn a_mesh_of_a_point_cache_has_no_shapes_of_the_scene_s_own() {
    let mut arm = Arm::skinned("Linear");
    let cache = arm.scene.object("Deformer", "cache", "VertexCacheDeformer", "");
    arm.scene.connect(cache, arm.mesh);
    let rig = arm.rig();
    assert!(rig.shapes.is_none());
    assert_eq!(rig.warnings, [FormatWarning::CacheIgnored(vec!["body".to_owned()])]);
}

#[test]
fn frames_do_not_depend_on_the_number_of_threads() {
    let mut arm = Arm::skinned("Linear");
    let keys: Vec<(i64, f64)> = (1..60).map(|frame| (frame, (frame as f64).sin())).collect();
    arm.scene.keys(arm.layer, arm.tip, "Lcl Translation", "d|Y", &keys);
    let read = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let rig = pool.install(|| arm.rig());
        (rig.frames, rig.shapes)
    };
    let one = read(1);
    assert_eq!(one.0.len(), 2 * 59);
    assert_eq!(read(4), one);
}
