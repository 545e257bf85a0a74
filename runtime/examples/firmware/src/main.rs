//! Skins a character on an STM32F4: the model lies in flash, all other memory is static.
//!
//!     rustup target add thumbv7em-none-eabihf
//!     cargo run --release
#![no_std]
#![no_main]

use cortex_m_rt::entry;
use cortex_m_semihosting::{debug, hprintln};
use panic_halt as _;
use sinew_runtime::{Envelope, LocalTransform, Matrix3x4, Model, Skin, model_space_pose};

/// The file, read in place and never copied. Yours: `sinew train EXAMPLES --predictor rotational`.
static MODEL: &[u8] = include_bytes!("../../../../tests/golden/envelope-11-rotational.snw");

/// Room for joints, transforms, floats of scratch, and vertices. `sinew inspect MODEL` prints a model's, the scratch
/// in bytes.
const JOINTS: usize = 20;
const TRANSFORMS: usize = 20;
const SCRATCH: usize = 480;
const VERTICES: usize = 1000;

/// Memory of a character.
struct Character {
    local: [LocalTransform; JOINTS],
    pose: [Matrix3x4; JOINTS],
    palette: [Matrix3x4; TRANSFORMS],
    scratch: [f32; SCRATCH],
    positions: [[f32; 3]; VERTICES],
}

#[entry]
fn main() -> ! {
    static mut CHARACTER: Character = Character {
        local: [LocalTransform { rotation: [0.0; 4], translation: [0.0; 3] }; JOINTS],
        pose: [[[0.0; 4]; 3]; JOINTS],
        palette: [[[0.0; 4]; 3]; TRANSFORMS],
        scratch: [0.0; SCRATCH],
        positions: [[0.0; 3]; VERTICES],
    };
    let done = run(CHARACTER);
    if done.is_none() {
        hprintln!("the model is damaged, too large, not rotational, or needs a feature");
    }
    debug::exit(if done.is_some() { debug::EXIT_SUCCESS } else { debug::EXIT_FAILURE });
    loop {
        cortex_m::asm::wfi();
    }
}

fn run(character: &mut Character) -> Option<()> {
    // Once: checks the whole file, so that no frame fails because of the file.
    let model = Model::from_bytes(MODEL).ok()?;
    let (envelope, skin) = (model.first::<Envelope>()?, model.first::<Skin>()?);
    let local = character.local.get_mut(..envelope.joint_len())?;
    let pose = character.pose.get_mut(..envelope.joint_len())?;
    let palette = character.palette.get_mut(..envelope.palette_len())?;
    let positions = character.positions.get_mut(..skin.vertex_len())?;
    for frame in 0..3u8 {
        // Each frame: the rest frames of the joints, bent; then the palette and the skin.
        for (local, rest) in local.iter_mut().zip(envelope.rest_locals()) {
            *local = rest;
            local.rotation[2] += 0.1 * f32::from(frame);
        }
        model_space_pose(&envelope, local, pose).ok()?;
        let confidence = envelope.rotational_palette(pose, &mut character.scratch, palette).ok()?;
        skin.skin_positions(palette, positions).ok()?;
        hprintln!("confidence {:.2}, last vertex {:.3?}", confidence, positions.last()?);
    }
    Some(())
}
