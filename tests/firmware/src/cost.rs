//! Measures instructions, stack and scratch of a frame, on a Cortex-M4F in QEMU.

use crate::bits::{Memory, Rng, cut};
use crate::memory::take;
use crate::platform::{TICK, count_down, instructions_of, stack_of, start_timer};
use crate::say;
use core::hint::black_box;
#[cfg(feature = "kernel")]
use sinew_runtime::KernelMap;
use sinew_runtime::skin::Output;
use sinew_runtime::{Envelope, Model, Skin, SkinJob, model_space_pose};

/// Models of the shape for which the budget is stated.
const BARS: [(&str, &[u8]); 2] = [
    ("rotational", include_bytes!(concat!(env!("SINEW_MODELS"), "/bar-rotational.snw"))),
    ("kernel", include_bytes!(concat!(env!("SINEW_MODELS"), "/bar-kernel.snw"))),
];

/// Number of poses; the costliest counts.
const POSES: usize = 64;

/// Prints the cost of each model; returns whether all evaluations succeeded and the clock is right.
pub fn cost() -> bool {
    let Some(memory) = take() else { return false };
    start_timer();
    let sound = BARS.iter().all(|(name, file)| model(name, file, memory).is_some());
    clock() && sound
}

/// Prints the cost of the servo's kernel; returns whether all evaluations succeeded.
#[cfg(feature = "kernel")]
pub fn servo() -> bool {
    let Some(memory) = take() else { return false };
    start_timer();
    servo_kernel(memory).is_some()
}

#[cfg(feature = "kernel")]
fn servo_kernel(memory: &mut Memory) -> Option<()> {
    let model = load("servo", include_bytes!("../../golden/kernel-11-servo.snw"))?;
    let kernel = model.first::<KernelMap>()?;
    let scratch = cut(&mut memory.scratch, kernel.scratch_len());
    let mut rng = Rng(7);
    let (mut query, mut angle) = ([0.0; 6], [0.0]);
    let (mut most, mut sound) = (0, true);
    for _ in 0..POSES {
        query.iter_mut().for_each(|x| *x = rng.unit());
        let step =
            instructions_of(|| sound &= kernel.evaluate(&query, scratch, &mut angle).is_ok());
        most = most.max(step);
    }
    let stack = stack_of(&mut || sound &= kernel.evaluate(&query, scratch, &mut angle).is_ok());
    say!("servo scratch {}", 4 * kernel.scratch_len());
    say!("servo step_instructions {most}");
    say!("servo step_stack {stack}");
    sound.then_some(())
}

/// Prints the cost of a skin with tangent coefficients; returns whether the evaluation succeeded.
#[cfg(feature = "normals")]
pub fn normals() -> bool {
    let Some(memory) = take() else { return false };
    start_timer();
    let file = include_bytes!(concat!(env!("SINEW_MODELS"), "/bar-normals.snw"));
    turned_skin(file, memory).is_some()
}

/// Prints the instructions for positions and normals, and the deepest stack for all attributes.
#[cfg(feature = "normals")]
fn turned_skin(file: &[u8], memory: &mut Memory) -> Option<()> {
    let model = load("normals", file)?;
    let (envelope, skin) =
        (model.first::<Envelope>()?, model.first::<Skin>().filter(Skin::has_coefficients)?);
    let local = cut(&mut memory.local, envelope.joint_len());
    let mut rng = Rng(7);
    local.iter_mut().for_each(|local| *local = rng.local(0.3));
    let pose = cut(&mut memory.pose, envelope.joint_len());
    model_space_pose(&envelope, local, pose).ok()?;
    let palette = cut(&mut memory.palette, envelope.palette_len());
    let scratch = cut(&mut memory.scratch, envelope.scratch_len());
    envelope.palette(pose, &[], scratch, palette).ok()?;
    let [positions, normals, tangents] =
        Output::interleaved(cut(&mut memory.skin, 10 * skin.vertex_len()), 10, [0, 3, 6]);
    let job = SkinJob::new(skin, palette);
    let job = job.positions(black_box(Some(positions))).normals(black_box(Some(normals)));
    let mut sound = true;
    let skinning = instructions_of(|| sound &= job.run().is_ok());
    let all = job.tangents(black_box(Some(tangents)));
    let stack = stack_of(&mut || sound &= all.run().is_ok());
    say!("normals skin_instructions {skinning}");
    say!("normals skin_stack {stack}");
    sound.then_some(())
}

/// Loads a model, and prints the cost of loading.
fn load<'a>(name: &str, file: &'a [u8]) -> Option<Model<&'a [u8]>> {
    let file = black_box(file);
    let mut loaded = Model::from_bytes(file);
    let stack = stack_of(&mut || loaded = Model::from_bytes(file));
    let instructions = instructions_of(|| loaded = Model::from_bytes(file));
    say!("{name} load_instructions {instructions}");
    say!("{name} load_stack {stack}");
    loaded.ok()
}

/// Checks the clock with loops of known length: one has two million instructions more.
fn clock() -> bool {
    let counted = |times| instructions_of(|| count_down(black_box(times)));
    let (short, long) = (counted(1_000), counted(1_001_000));
    say!("two_million instructions {}", long - short);
    (long - short).abs_diff(2_000_000) <= TICK
}

fn model(name: &str, file: &[u8], memory: &mut Memory) -> Option<()> {
    let model = load(name, file)?;
    let (envelope, skin) = (model.first::<Envelope>()?, model.first::<Skin>()?);
    say!("{name} scratch {}", 4 * envelope.scratch_len());
    instructions(name, envelope, skin, memory)?;
    stacks(name, envelope, skin, memory)
}

/// Prints the instructions of the costliest pose, by stage and in total.
fn instructions(
    name: &str,
    envelope: Envelope<'_>,
    skin: Skin<'_>,
    memory: &mut Memory,
) -> Option<()> {
    let mut rng = Rng(7);
    let (mut posing, mut moving, mut skinning, mut frame) = (0, 0, 0, 0);
    let mut sound = true;
    for _ in 0..POSES {
        let local = cut(&mut memory.local, envelope.joint_len());
        local.iter_mut().for_each(|local| *local = rng.local(0.3));
        let pose = cut(&mut memory.pose, envelope.joint_len());
        let palette = cut(&mut memory.palette, envelope.palette_len());
        let scratch = cut(&mut memory.scratch, envelope.scratch_len());
        let positions = cut(memory.skin.as_chunks_mut().0, skin.vertex_len());
        let mut is_sound = |done| sound &= done;
        let posed = instructions_of(|| {
            is_sound(model_space_pose(&envelope, local, pose).is_ok());
        });
        let moved = instructions_of(|| {
            let confidence = envelope.palette(pose, &[], scratch, palette);
            // A kernel map with confidence 0 would cost little.
            let whole = |confidence| confidence > 0.0 || !envelope.predictor().corrects();
            is_sound(confidence.is_ok_and(whole));
        });
        let skinned = instructions_of(|| {
            is_sound(skin.skin_positions(palette, positions).is_ok());
        });
        posing = posing.max(posed);
        moving = moving.max(moved);
        skinning = skinning.max(skinned);
        frame = frame.max(moved + skinned);
    }
    say!("{name} pose_instructions {posing}");
    say!("{name} palette_instructions {moving}");
    say!("{name} skin_instructions {skinning}");
    say!("{name} frame_instructions {frame}");
    sound.then_some(())
}

/// Prints the deepest stack of each call.
fn stacks(name: &str, envelope: Envelope<'_>, skin: Skin<'_>, memory: &mut Memory) -> Option<()> {
    let local = cut(&mut memory.local, envelope.joint_len());
    let pose = cut(&mut memory.pose, envelope.joint_len());
    let palette = cut(&mut memory.palette, envelope.palette_len());
    let scratch = cut(&mut memory.scratch, envelope.scratch_len());
    let vertices = cut(&mut memory.skin, 10 * skin.vertex_len());
    let mut sound = true;
    let posing = stack_of(&mut || sound &= model_space_pose(&envelope, local, pose).is_ok());
    let moving = stack_of(&mut || sound &= envelope.palette(pose, &[], scratch, palette).is_ok());
    let skinning = stack_of(&mut || {
        let attributes = Output::interleaved(vertices, 10, [0, 3, 6]);
        let [positions, normals, tangents] = attributes.map(|own| black_box(Some(own)));
        let job = SkinJob::new(skin, palette).positions(positions).normals(normals);
        sound &= job.tangents(tangents).run().is_ok();
    });
    let bounds = stack_of(&mut || sound &= black_box(skin.bounds(palette, 0.0)).is_ok());
    say!("{name} pose_stack {posing}");
    say!("{name} palette_stack {moving}");
    say!("{name} skin_stack {skinning}");
    say!("{name} bounds_stack {bounds}");
    sound.then_some(())
}
