//! Levels of evaluation.

/// How much of an envelope is evaluated: what a character far away can do without.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(u8)]
pub enum Level {
    /// What the correction starts from: the joints, or the reconstruction. Of a kernel envelope this is next to
    /// nothing, and of a rotational one all. [`super::Certificate::base_training_rms`] is its error.
    Joints = 1,
    /// Everything; [`super::Certificate::training_rms`] is its error.
    #[default]
    Full = 2,
}

impl Level {
    /// Every level, the cheapest first.
    pub const ALL: [Self; 2] = [Self::Joints, Self::Full];
}
