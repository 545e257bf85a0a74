//! What poses are made of and what is read from them.
//!
//! [`model_space_pose`] makes the skinning matrices of a pose from local transforms; [`features`]
//! is the stage that kernel maps listen to.

pub mod features;
mod local;

pub use local::{LocalTransform, model_space_pose};

use crate::Matrix3x4;
use crate::envelope::Envelope;
use crate::error::{Argument, EvalError};

/// Checks that a pose has J matrices, all of them finite.
pub(crate) fn check(envelope: &Envelope<'_>, pose: &[Matrix3x4]) -> Result<(), EvalError> {
    Argument::Pose.check_len(envelope.joint_len(), pose.len())?;
    let unsound = pose.iter().position(|m| !m.as_flattened().iter().all(|x| x.is_finite()));
    unsound.map_or(Ok(()), |joint| Err(EvalError::NonFinite { joint }))
}
