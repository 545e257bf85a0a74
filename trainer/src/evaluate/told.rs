//! What a model's file tells of its training, to whom it is measured by.

use super::{Baseline, Character};
use crate::envelope::lbs::blend::Weights;
use crate::examples::{Examples, is_same};
use sinew_runtime::{Model, Record};

/// What a model tells of its training, about some examples.
#[derive(Default)]
pub struct Told {
    /// Whether training has read each frame of the examples, N; none where the file does not tell.
    read: Option<Vec<bool>>,
    /// LBS as training fitted it.
    lbs: Option<Weights>,
}

impl Told {
    /// Reads the record of a character's envelope.
    pub fn of(model: &[u8], character: &Character<'_>, examples: &Examples) -> Self {
        let Ok(loaded) = Model::from_bytes(model) else { return Self::default() };
        let Some(record) = loaded.record_of(&character.envelope) else { return Self::default() };
        let marks: Vec<_> = record.frame_marks().collect();
        let has_read = |frame| {
            let own = examples.mark(frame);
            marks.iter().any(|mark| is_same(mark, &own))
        };
        Self {
            read: Some((0..examples.frame_len()).map(has_read).collect()),
            lbs: weights(&record, examples),
        }
    }

    /// Tells whether training has read a frame, where the file knows.
    pub fn has_read(&self, frame: usize) -> Option<bool> {
        self.read.as_ref().and_then(|read| read.get(frame)).copied()
    }

    /// Counts those of some frames that training has read, where the file knows.
    pub fn read_len(&self, frames: &[usize]) -> Option<usize> {
        let read = self.read.as_ref()?;
        Some(frames.iter().filter(|&&frame| read[frame]).count())
    }

    /// Gives LBS as training fitted it; of a file that does not tell, fitted to the examples' training frames.
    pub fn baseline(&self, examples: &Examples) -> Baseline {
        match &self.lbs {
            Some(weights) => Baseline::new(weights.clone(), examples),
            None => Baseline::fit(examples),
        }
    }
}

/// Reads joint weights of the examples' vertices; none where the file has none, or of another mesh.
fn weights(record: &Record<'_>, examples: &Examples) -> Option<Weights> {
    let counts = record.counts();
    let is_own = counts.vertex_len as usize == examples.vertex_len()
        && counts.joint_len as usize == examples.joint_len();
    if !is_own || counts.influence_len == 0 {
        return None;
    }
    let list = |vertex| {
        let own = record.lbs_influences(vertex)?;
        let own: Vec<(usize, f64)> = own.map(|(joint, w)| (joint, f64::from(w))).collect();
        let sum: f64 = own.iter().map(|(_, weight)| weight).sum();
        Some(own.into_iter().map(|(joint, weight)| (joint, weight / sum)).collect())
    };
    let lists: Option<Vec<_>> = (0..examples.vertex_len()).map(list).collect();
    Some(Weights::from_lists(counts.influence_len as usize, lists?.into_iter()))
}
