//! The tolerance of stage joints.

use super::inexact::{Inexact, Transform};
use sinew_trainer::envelope::model::EnvelopeModel;

/// Bounds the joints' transforms, which are copies. Without joints every helper has the identity.
pub fn joints(oracle: &EnvelopeModel, pose: &Inexact<Transform>) -> Inexact<Transform> {
    let value = oracle.joints(&pose.value);
    if pose.value.is_empty() {
        return Inexact::exact(value);
    }
    Inexact { value, error: oracle.joints(&pose.error) }
}
