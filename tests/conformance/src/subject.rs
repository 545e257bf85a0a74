//! A model under test, with its oracle and its poses.

use crate::backend::Loaded;
use crate::poses::{Pose, poses};
use sinew_runtime::Matrix3x4;
use sinew_trainer::envelope::oracle::Oracle;

/// A model under test.
pub struct Subject<'a> {
    /// What kind of model it is.
    pub name: &'static str,
    /// The model.
    pub loaded: Loaded<'a>,
    /// Its oracle.
    pub oracle: Oracle,
    /// Poses of it.
    pub poses: Vec<Pose>,
    /// Their matrices, J of each.
    pub maps: Vec<Matrix3x4>,
}

impl<'a> Subject<'a> {
    /// Loads a model and draws poses.
    ///
    /// # Panics
    /// If the bytes are no model with an envelope.
    pub fn new(name: &'static str, bytes: &'a [u8], pose_len: usize) -> Self {
        let loaded = Loaded::new(bytes);
        let poses = poses(&loaded.envelope, pose_len);
        let maps = poses.iter().flat_map(|pose| pose.maps.iter().copied()).collect();
        Self { name, oracle: Oracle::new(&loaded.envelope), loaded, poses, maps }
    }
}
