//! The golden face, and its hash of pin solves over seeded targets, which is equal on all CPUs.

use super::{Rng, add};
use sinew_runtime::prior::{Anchor, Temporal};
use sinew_runtime::{CallError, Model, Pin, PinJob, Pins, Prior, Skin};

/// A file of a skin with shapes and its prior.
pub(crate) const FACE: &[u8] = include_bytes!("prior-11.snw");

/// Hash of the solves, the promise of METHOD §7: change it only with a reason that the commit
/// states.
pub(crate) const BITS: u64 = 0xe673_5d42_1135_60a1;

/// Solves per hash.
const SOLVES: usize = 256;
const PINS: usize = 3;
const SHAPES: usize = 8;
/// Length of the scratch that the golden face needs, in f64 numbers.
const SCRATCH: usize = 240;

/// Hashes solves of a model's first prior for seeded pins: weights, edits, and the solved places of
/// the pinned vertices. `nudge` is added to the targets. Every second solve is a drag, which reuses
/// the factor of the previous solve.
///
/// # Errors
/// Errors of the calls; a length error if the prior does not have the golden file's size.
pub(crate) fn hash(prior: Prior<'_>, skin: Skin<'_>, nudge: f32) -> Result<u64, CallError> {
    let mut hash = 0;
    let mut rng = Rng(1985);
    let (mut scratch, mut weights) = ([0.0; SCRATCH], [0.25; SHAPES]);
    let vertex_len = skin.vertex_len().max(1) as u64;
    let mut vertices = [0; PINS];
    for number in 0..SOLVES {
        let is_drag = number % 2 == 1;
        if !is_drag {
            vertices = [(); PINS].map(|()| (rng.next_u64() % vertex_len) as u32);
        }
        let mut pins = Pins::<PINS>::new();
        for (at, vertex) in vertices.into_iter().enumerate().take(number / 2 % PINS + 1) {
            let place = skin.place(vertex, &[], &[]).unwrap_or_default();
            // Some targets are near, others out of reach of the shapes.
            let size = [0.125, 1.0][number / 16 % 2];
            let target = place.map(|x| x + size * rng.unit() + nudge);
            let keep = [true, at != 1, at != 2];
            pins.add(Pin::new(vertex, target).masked(keep).with_stiffness(0.5 + at as f32))?;
        }
        let last = weights;
        let job = PinJob {
            anchor: if number % 3 == 0 { Anchor::Mean } else { Anchor::Current },
            is_bounded: number % 8 < 6,
            temporal: (number % 16 > 7).then_some(Temporal { weights: &last, stiffness: 2.0 }),
            symmetry: (number / 2 % 2) as f32,
            cancels: number / 2 % 5 == 0,
            ..PinJob::new(prior, skin, pins.list())
        };
        let edit = job.run(&mut scratch, &mut weights)?;
        add(&mut hash, &weights);
        let told = [edit.unreachable_len as u32, edit.round_len, edit.is_least.into()];
        add(&mut hash, &[edit.norm]);
        add(&mut hash, &told.map(f32::from_bits));
        for vertex in vertices {
            add(&mut hash, &skin.place(vertex, &[], &weights).unwrap_or_default());
        }
    }
    Ok(hash)
}

/// Loads the golden face; `None` on failure.
pub(crate) fn load() -> Option<Model<&'static [u8]>> {
    Model::from_bytes(FACE).ok()
}
