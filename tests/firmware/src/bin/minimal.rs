//! The smallest firmware: a model in flash, a pose, a palette, a skin.
#![cfg_attr(any(target_os = "none", target_family = "wasm"), no_std, no_main)]

use sinew_runtime::envelope::{EnvelopeCounts, Predictor, scratch_len};
use sinew_runtime::{LocalTransform, Matrix3x4, Model, Workspace, model_space_pose};

firmware::image!(run);
firmware::may_panic!();

/// In flash: read in place, never copied.
static MODEL: &[u8] = include_bytes!("../../../golden/envelope-9-rotational.snw");

/// Room for joints, transforms and their scratch. A model with kernel maps has more transforms, which
/// include the joints, and states the scratch of its correction.
const ROOM: EnvelopeCounts = EnvelopeCounts {
    predictor: Predictor::Rotational,
    joint_len: 8,
    proxy_len: 8,
    root: 0,
    group_len: 0,
    correction_len: 0,
    stretches: false,
    curve_len: 0,
};
const JOINTS: usize = ROOM.joint_len as usize;
const TRANSFORMS: usize = ROOM.palette_len();
const VERTICES: usize = 32;

const REST: Matrix3x4 = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
const STILL: LocalTransform =
    LocalTransform { rotation: [0.0, 0.0, 0.0, 1.0], translation: [0.0; 3] };

fn run() -> bool {
    frame().is_some()
}

fn frame() -> Option<()> {
    // Once: loading checks the whole file, so evaluation cannot fail because of the file.
    let model = Model::from_bytes(MODEL).ok()?;
    let (envelope, skin) = (model.envelope()?, model.skin()?);
    let (mut local, mut pose) = ([STILL; JOINTS], [REST; JOINTS]);
    let (mut palette, mut positions) = ([REST; TRANSFORMS], [[0.0; 3]; VERTICES]);
    let mut scratch = Workspace::<{ scratch_len(&ROOM) }>::new();
    let local = local.get_mut(..envelope.joint_len())?;
    let pose = pose.get_mut(..envelope.joint_len())?;
    let palette = palette.get_mut(..envelope.palette_len())?;

    // Each frame: the joints' rotations relative to their parents, then two calls.
    local.first_mut()?.rotation = [0.0, 0.0, 0.6, 0.8];
    model_space_pose(&envelope, local, pose).ok()?;
    let confidence = envelope.rotational_palette(pose, &mut scratch, palette).ok()?;
    skin.skin_positions(palette, &mut positions).ok()?;

    firmware::say!("confidence {confidence}, first vertex {:?}", positions.first()?);
    Some(())
}
