//! One refusal a test: each says what is not there and what to export.

use super::*;

#[track_caller]
fn says(fault: &SceneError, expected: &str) {
    let text = fault.to_string();
    assert!(text.starts_with(expected), "{text}");
    assert!(!text.ends_with('.') && text.len() > expected.len(), "{text}");
}

#[test]
fn what_is_no_fbx_is_refused_and_named() {
    let folder = Folder::new("fbx");
    for bytes in [&b""[..], b"garbage", b"v 0 0 0\n", b"Kaydara FBX Binary  \0\x1a\0\xe8\x1c\0\0"] {
        let path = folder.write("a.fbx", bytes);
        let error = read(&path, &KEYS).err().unwrap();
        let FormatError::Scene(fault) = error else { panic!("{error}") };
        says(&fault, "is no FBX file that can be read: ");
    }
    let error = read(&folder.0.join("none.fbx"), &KEYS).err().unwrap();
    assert!(matches!(error, FormatError::Read(_)));
}

#[test]
fn a_scene_without_a_mesh_a_joint_or_an_animation_is_refused() {
    let mut scene = Scene::default();
    let parse = |scene: &Scene| parse(scene.text().as_bytes(), &KEYS).err().unwrap();
    says(&parse(&scene), "is empty: its scene shows no node");
    let mut bare = Scene::default();
    bare.node("bone", "LimbNode", 0, &[]);
    says(&parse(&bare), "holds no mesh");
    let node = scene.node("body", "Mesh", 0, &[]);
    scene.mesh(node, &ARM, &FACES, "");
    says(&parse(&scene), "has no joint");
    scene.node("bone", "LimbNode", 0, &[]);
    says(&parse(&scene), "holds no animation");
    let layer = scene.animation("still");
    let text = "no animation targets a joint or a shape of the mesh (clips: still)";
    says(&parse(&scene), text);
    scene.keys(layer, node, "Lcl Translation", "d|X", &[(0, 0.0), (1, 1.0)]);
    says(&parse(&scene), text);
}

#[test]
fn clips_that_are_not_there_or_move_nothing_are_refused() {
    let mut arm = Arm::skinned("Linear");
    arm.scene.animation("empty");
    let fault = |clip: &str| {
        let sampling = Sampling {
            fps: None,
            clips: &[clip.to_owned()],
            shapes: true,
            still: false,
            played: false,
        };
        arm.sampled(&sampling).err().unwrap().to_string()
    };
    assert_eq!(fault("walk"), "has no clip walk, there are: bend, empty");
    assert!(fault("empty").contains("(clips: empty)"));
}

#[test]
fn skins_that_cannot_be_read_name_the_mesh() {
    let mut arm = Arm::skinned("Linear");
    arm.bind(arm.mesh, "Linear");
    says(&arm.fault(), "mesh body has 2 skins, expected one");
    let mut arm = Arm::bare();
    arm.scene.skin(arm.mesh, "Linear");
    says(&arm.fault(), "the skin of mesh body has no joint");
    let mut arm = Arm::bare();
    let skin = arm.scene.skin(arm.mesh, "Linear");
    let flat = [1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 0., 0., 0., 0., 0., 1.];
    arm.scene.cluster(skin, arm.tip, &[(0, 1.0)], flat, translation(0.0, 0.0, 0.0));
    says(&arm.fault(), "the bind matrix of joint tip cannot be inverted");
}

#[test]
fn meshes_bound_in_different_poses_are_refused() {
    let bound = |apart: f64| {
        let mut arm = Arm::skinned("Linear");
        let node = arm.scene.node("sleeve", "Mesh", 0, &[]);
        let mesh = arm.scene.mesh(node, &ARM, &FACES, "");
        let skin = arm.scene.skin(mesh, "Linear");
        let link = translation(1.0 + apart, 0.0, 0.0);
        arm.scene.cluster(skin, arm.tip, &[(0, 1.0)], translation(-1.0, 0.0, 0.0), link);
        arm
    };
    says(&bound(0.5).fault(), "mesh sleeve binds joint tip elsewhere than the other meshes do");
    assert_eq!(bound(1e-6).rig().rest.len(), 10, "rounding is no difference");
}

#[test]
fn joints_under_a_constraint_without_keys_are_refused() {
    let constrained = |keyed: bool| {
        let mut arm = Arm::skinned("Linear");
        let group = arm.scene.node("group", "Null", 0, &[]);
        let target = arm.scene.node("target", "Null", 0, &[]);
        arm.scene.connect(arm.root, group);
        let joint = if keyed { arm.tip } else { group };
        let inside = "Type: \"Position From Positions\"\n";
        let constraint =
            arm.scene.object("Constraint", "follow", "Position From Positions", inside);
        arm.scene.connect_to(joint, constraint, "Constrained Object");
        arm.scene.connect_to(target, constraint, "Source");
        arm
    };
    let mut arm = constrained(true);
    assert_eq!(arm.rig().names, ["root", "tip"], "what is baked needs no constraint");
    arm = constrained(false);
    says(&arm.fault(), "joint group has no keys but a constraint, follow, which is not evaluated");
}

#[test]
fn spoiled_scenes_do_not_panic() {
    let mut arm = Arm::skinned("Linear");
    arm.scene.channel(arm.mesh, "", &[(50.0, 3, [0.0, 0.0, 2.0]), (100.0, 3, [0.0, 1.0, 1.0])]);
    let text = arm.scene.text();
    assert!(arm.rig().shapes.is_some());
    spoil(text.as_bytes(), |bytes| drop(parse(bytes, &KEYS)));
}

#[test]
fn numbers_that_are_none_do_not_panic() {
    let text = Arm::skinned("Linear").scene.text();
    for number in ["nan", "inf", "-inf", "1e308", "-1e308", "99999999999"] {
        for place in text.match_indices("a: ").map(|(place, _)| place + 3) {
            let end = place + text[place..].find([',', '\n']).unwrap();
            let spoiled = format!("{}{number}{}", &text[..place], &text[end..]);
            drop(parse(spoiled.as_bytes(), &KEYS));
        }
    }
}
