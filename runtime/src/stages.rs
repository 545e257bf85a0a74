//! The stages of an envelope, one by one: for tests of other backends, and for those who measure.
//!
//! [`crate::Envelope::palette`] composes them; [`crate::SkinJob`] is the last stage.

pub use crate::envelope::confidence::evaluate as confidence;
pub use crate::envelope::correction::evaluate as correction;
pub use crate::envelope::features::evaluate as features;
pub use crate::envelope::gradients::evaluate as gradients;
pub use crate::envelope::joints::evaluate as joints;
pub use crate::envelope::palette::evaluate as palette;
