//! Instructions, stack and scratch of a frame, on a Cortex-M4F in QEMU.

use crate::bits::{Memory, Rng, cut};
use crate::memory::take;
use crate::platform::{TICK, count_down, instructions_of, stack_of, start_timer};
use crate::say;
use core::hint::black_box;
use sinew_runtime::envelope::{Attribute, Buffer, SkinJob};
use sinew_runtime::{Envelope, Model, model_space_pose};

/// Models of the shape that the budget is stated for.
const BARS: [(&str, &[u8]); 2] = [
    ("rotational", include_bytes!(concat!(env!("SINEW_MODELS"), "/bar-rotational.snw"))),
    ("kernel", include_bytes!(concat!(env!("SINEW_MODELS"), "/bar-kernel.snw"))),
];

/// Poses, of which the costliest counts.
const POSES: usize = 64;

/// Prints what each model costs; returns whether all could be evaluated and the clock is true.
pub fn cost() -> bool {
    let Some(memory) = take() else { return false };
    start_timer();
    let sound = BARS.iter().all(|(name, file)| model(name, file, memory).is_some());
    clock() && sound
}

/// Times loops of known length, of which one has two million instructions more.
fn clock() -> bool {
    let counted = |times| instructions_of(|| count_down(black_box(times)));
    let (short, long) = (counted(1_000), counted(1_001_000));
    say!("two_million instructions {}", long - short);
    (long - short).abs_diff(2_000_000) <= TICK
}

fn model(name: &str, file: &[u8], memory: &mut Memory) -> Option<()> {
    let file = black_box(file);
    let mut loaded = None;
    let stack = stack_of(&mut || loaded = Model::from_bytes(file).ok());
    let loading = instructions_of(|| loaded = Model::from_bytes(file).ok());
    let envelope = loaded?.envelope()?;
    say!("{name} load_instructions {loading}");
    say!("{name} load_stack {stack}");
    say!("{name} scratch {}", 4 * envelope.workspace_len());
    instructions(name, envelope, memory)?;
    stacks(name, envelope, memory)
}

/// Prints the instructions of the costliest of the poses, stage by stage and together.
fn instructions(name: &str, envelope: Envelope<'_>, memory: &mut Memory) -> Option<()> {
    let mut rng = Rng(7);
    let (mut posing, mut palette, mut skin, mut frame) = (0, 0, 0, 0);
    let mut sound = true;
    for _ in 0..POSES {
        let local = cut(&mut memory.local, envelope.joint_len());
        local.iter_mut().for_each(|local| *local = rng.local(0.3));
        let pose = cut(&mut memory.pose, envelope.joint_len());
        let maps = cut(&mut memory.palette, envelope.palette_len());
        let scratch = cut(&mut memory.workspace, envelope.workspace_len());
        let positions = cut(memory.skin.as_chunks_mut().0, envelope.vertex_len());
        let mut is_sound = |done| sound &= done;
        let posed = instructions_of(|| {
            is_sound(model_space_pose(&envelope, local, pose).is_ok());
        });
        let moved = instructions_of(|| {
            let confidence = envelope.palette(pose, scratch, maps);
            // A kernel map that has faded would cost little.
            let whole = |confidence| confidence > 0.0 || !envelope.predictor().corrects();
            is_sound(confidence.is_ok_and(whole));
        });
        let skinned = instructions_of(|| {
            is_sound(envelope.skin_positions(maps, positions).is_ok());
        });
        posing = posing.max(posed);
        palette = palette.max(moved);
        skin = skin.max(skinned);
        frame = frame.max(moved + skinned);
    }
    say!("{name} pose_instructions {posing}");
    say!("{name} palette_instructions {palette}");
    say!("{name} skin_instructions {skin}");
    say!("{name} frame_instructions {frame}");
    sound.then_some(())
}

/// Prints the deepest stack of each call.
fn stacks(name: &str, envelope: Envelope<'_>, memory: &mut Memory) -> Option<()> {
    let local = cut(&mut memory.local, envelope.joint_len());
    let pose = cut(&mut memory.pose, envelope.joint_len());
    let maps = cut(&mut memory.palette, envelope.palette_len());
    let scratch = cut(&mut memory.workspace, envelope.workspace_len());
    let skin = cut(&mut memory.skin, 10 * envelope.vertex_len());
    let mut sound = true;
    let posing = stack_of(&mut || sound &= model_space_pose(&envelope, local, pose).is_ok());
    let palette = stack_of(&mut || sound &= envelope.palette(pose, scratch, maps).is_ok());
    let attribute = |offset| Some(Attribute { buffer: Buffer::A, offset, stride: 10 });
    let skinning = stack_of(&mut || {
        let job = SkinJob {
            envelope,
            palette: maps,
            vertices: 0..envelope.vertex_len(),
            positions: black_box(attribute(0)),
            normals: black_box(attribute(3)),
            tangents: black_box(attribute(6)),
            out_a: skin,
            out_b: &mut [],
        };
        sound &= job.run().is_ok();
    });
    let bounds = stack_of(&mut || sound &= black_box(envelope.bounds(maps)).is_ok());
    say!("{name} pose_stack {posing}");
    say!("{name} palette_stack {palette}");
    say!("{name} skin_stack {skinning}");
    say!("{name} bounds_stack {bounds}");
    sound.then_some(())
}
