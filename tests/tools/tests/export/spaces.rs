//! Exports of models in the axes and the unit of an engine.

use super::scene::Scene;
use super::{arm, clip, export, farthest, model, pose, runtime_skin};
use nalgebra::Vector3;
use sinew_runtime::Model;
use sinew_runtime::envelope::Predictor;
use sinew_runtime::format::{Axis, Space};
use sinew_trainer::examples::Examples;
use sinew_trainer::export::Placement;
use sinew_trainer::space::SpaceRequest;

const GLTF: Space = Space::GLTF;
const UNREAL: Space = Space::UNREAL;

fn examples(space: Space) -> Examples {
    let mut arm = Examples { space: GLTF, ..arm(300) };
    arm.convert_to(&space);
    arm
}

fn to_gltf() -> Placement {
    Placement::In(SpaceRequest::all_of(&GLTF))
}

#[test]
fn a_left_handed_model_is_mirrored_back() {
    let examples = examples(UNREAL);
    let clips = [clip("all", 0, 6)];
    let bytes = model(&examples, Predictor::Kernel, 5, 4);
    let runtime = Model::from_bytes(bytes.as_slice()).unwrap();
    let skinned = |placement, key| {
        let exported = export(&bytes, None, &examples, &clips, &[], placement).unwrap();
        let scene = Scene::read(&exported.glb);
        scene.skinned("skin", &scene.palette(&scene.worlds(Some((0, key, 0.0)))))
    };
    for key in [0, 5] {
        let unreal = runtime_skin(&runtime, &pose(&examples, key));
        // x forward, y right, z up in centimetres: glTF has x left, y up, z forward in metres.
        let metres: Vec<_> = unreal.iter().map(|x| Vector3::new(-x.y, x.z, x.x) * 0.01).collect();
        let near = 1e-4 * 0.01 * examples.diagonal();
        assert!(farthest(&skinned(to_gltf(), key), &metres) < near);
        // By default the character keeps the model's axes, made right-handed: forward and up stay.
        let own: Vec<_> = unreal.iter().map(|x| Vector3::new(x.x, -x.y, x.z)).collect();
        assert!(farthest(&skinned(Placement::AsModel, key), &own) < 1e-4 * examples.diagonal());
    }
}

#[test]
fn triangles_of_an_export_face_outward() {
    for space in [GLTF, UNREAL] {
        let examples = examples(space);
        let bytes = model(&examples, Predictor::Kernel, 4, 4);
        let exported =
            export(&bytes, None, &examples, &[clip("all", 0, 2)], &[], to_gltf()).unwrap();
        let gltf = gltf::Gltf::from_slice(&exported.glb).unwrap();
        let primitive = gltf.meshes().next().unwrap().primitives().next().unwrap();
        let reader = primitive.reader(|_| gltf.blob.as_deref());
        let points: Vec<Vector3<f32>> =
            reader.read_positions().unwrap().map(Vector3::from).collect();
        let corners: Vec<u32> = reader.read_indices().unwrap().into_u32().collect();
        let volume: f32 = corners
            .as_chunks::<3>()
            .0
            .iter()
            .map(|t| t.map(|v| points[v as usize]))
            .map(|[a, b, c]| a.dot(&b.cross(&c)))
            .sum();
        assert!(volume > 0.0, "{volume}");
    }
}

#[test]
fn spaces_that_gltf_cannot_have_are_refused() {
    let clips = [clip("all", 0, 2)];
    let refused = |space: Space, wish: SpaceRequest| {
        let mut examples = examples(GLTF);
        examples.space = space;
        let bytes = model(&examples, Predictor::Kernel, 4, 4);
        let exported = export(&bytes, None, &examples, &clips, &[], Placement::In(wish));
        exported.map(|exported| exported.glb.len()).unwrap_err()
    };
    let all = SpaceRequest::all_of(&UNREAL);
    let left = refused(GLTF, all);
    assert!(left.message().starts_with("glTF is right-handed: leave out --to-hand"), "{left}");
    let right = SpaceRequest { handedness: None, ..all };
    let unknown = refused(Space::default(), right);
    assert!(unknown.message().contains("does not say which axis is up"), "{unknown}");
    let flat =
        SpaceRequest { up: Some(Axis::X), forward: Some(Axis::MinusX), ..Default::default() };
    let parallel = refused(GLTF, flat);
    let expected = "up x and forward -x lie along one line";
    assert!(parallel.message().starts_with(expected), "{parallel}");
}
