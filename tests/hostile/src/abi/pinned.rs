//! What the runtime makes of a file's first prior: the inputs of its calls, and what they must give.

use sinew_capi::{SINEW_PINS_MAX, sinew_edit, sinew_pin};
use sinew_runtime::prior::{Anchor, Edit, PriorCounts, Temporal};
use sinew_runtime::{CallError, Matrix3x4, Model, Pin, PinJob, Pins, Prior};

/// Pins that an arena has room for: one more than a job may have.
pub(super) const PINS: usize = SINEW_PINS_MAX + 1;

/// Pins that a job is given scratch for.
pub(super) const FEW_PINS: usize = 3;

/// A file's first prior.
pub(super) struct Pinned {
    pub(super) name: String,
    pub(super) counts: PriorCounts,
    pub(super) beta: f32,
}

/// What a pin job is asked for; its arrays are the frame's, where nothing else is said.
pub(super) struct AskedPins {
    pub(super) pins: Vec<sinew_pin>,
    pub(super) is_from_mean: bool,
    pub(super) is_bounded: bool,
    pub(super) cancels: bool,
    pub(super) beta: f32,
    pub(super) symmetry: f32,
    pub(super) temporal: f32,
    pub(super) last: Option<Vec<f32>>,
    pub(super) weights: Vec<f32>,
}

impl Pinned {
    pub(super) fn new(prior: &Prior<'_>) -> Self {
        Self { name: prior.name().to_owned(), counts: prior.counts(), beta: prior.fit().beta }
    }

    /// Returns the numbers of scratch that a job of few pins needs at most.
    pub(super) fn scratch_len(&self) -> usize {
        self.counts.pin_scratch_len(3 * FEW_PINS)
    }

    /// Returns the bytes of what its calls write.
    pub(super) fn result_bytes(&self) -> usize {
        4 * self.counts.shape_len as usize + size_of::<sinew_edit>() + 8 * self.scratch_len()
    }
}

impl AskedPins {
    /// Counts the numbers of scratch that the job needs; of pins that are too many those of few.
    pub(super) fn scratch_len(&self, prior: &Pinned) -> usize {
        let rows = self.pins.iter().take(FEW_PINS).flat_map(|pin| pin.rows);
        prior.counts.pin_scratch_len(rows.filter(|[x, y, z, _]| [*x, *y, *z] != [0.0; 3]).count())
    }

    /// Solves with the first prior and the first skin of a file; without either nothing.
    ///
    /// # Errors
    /// As the runtime refuses it.
    pub(super) fn solve(
        &self,
        file: &[u8],
        palette: &[Matrix3x4],
    ) -> Result<(Vec<f32>, Edit), CallError> {
        let nothing = Ok((Vec::new(), Edit::default()));
        let Ok(model) = Model::from_bytes(file) else { return nothing };
        let Some((prior, skin)) = model.prior().zip(model.skin()) else { return nothing };
        let mut pins = Pins::<SINEW_PINS_MAX>::new();
        for pin in &self.pins {
            let sinew_pin { vertex, rows, target, stiffness } = *pin;
            pins.add(Pin { vertex, rows, target, stiffness })?;
        }
        let job = PinJob {
            palette,
            anchor: if self.is_from_mean { Anchor::Mean } else { Anchor::Current },
            beta: self.beta,
            is_bounded: self.is_bounded,
            temporal: self
                .last
                .as_ref()
                .map(|weights| Temporal { weights, stiffness: self.temporal }),
            symmetry: self.symmetry,
            cancels: self.cancels,
            ..PinJob::new(prior, skin, pins.list())
        };
        let mut scratch = vec![f64::NAN; prior.counts().pin_scratch_len(3 * self.pins.len())];
        let mut weights = self.weights.clone();
        job.run(&mut scratch, &mut weights).map(|edit| (weights, edit))
    }
}
