//! The tolerance of stage joints.

use super::inexact::{Inexact, Transform};
use sinew_trainer::envelope::model::EnvelopeModel;

/// Bounds the joints' transforms, which are copies.
pub fn joints(oracle: &EnvelopeModel, pose: &Inexact<Transform>) -> Inexact<Transform> {
    Inexact { value: oracle.joints(&pose.value), error: oracle.joints(&pose.error) }
}
