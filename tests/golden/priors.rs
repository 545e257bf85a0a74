//! The golden face, and the bits of pins over seeded targets, which all CPUs agree on.

use super::{Rng, add};
use sinew_runtime::prior::{Anchor, Temporal};
use sinew_runtime::{CallError, Model, Pin, PinJob, Pins, Prior, Skin};

/// A file of a skin with shapes and its prior.
pub(crate) const FACE: &[u8] = include_bytes!("prior-8.snw");

/// Its hash. Change it only with a reason that the commit states: it is the promise of METHOD §7.
pub(crate) const BITS: u64 = 0xe673_5d42_1135_60a1;

/// Solves of a hash.
const SOLVES: usize = 256;
const PINS: usize = 3;
const SHAPES: usize = 8;
/// Numbers of scratch that the golden face needs for them.
const SCRATCH: usize = 240;

/// Hashes solves of a model's first prior for seeded pins, to the targets of which `nudge` is added: weights, what was
/// done, and where the pinned vertices are then. Every second one is a drag, which uses the factor of the one before.
///
/// # Errors
/// Those of the calls; lengths, if the prior is not of the golden file's size.
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
            // Some are near, others beyond what the shapes reach.
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

/// Loads the golden face; `None` if that fails.
pub(crate) fn load() -> Option<Model<&'static [u8]>> {
    Model::from_bytes(FACE).ok()
}
